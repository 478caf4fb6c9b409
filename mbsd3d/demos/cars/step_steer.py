"""Response of a car in the first second after a step of its steer: yaw rate and roll, their overshoot, and its time."""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from mbsd3d import Pulse, System, measures, simulate

from ..figure import Line
from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, require
from .car import SHOW_OPTIONS, Car, car
from .linear import FULL_SPIN, HALF_SPIN, HEADING, ROLL, SYMBOLS, Y, linear

SMALL_STEER, TIGHT_RTOL = 1e-6, 1e-12  # rad of steer: what is of second order has no say; tolerance of the run
RESPONSE_MAX = 100.0  # [m/s^2/rad] per steer; a car with more is steered less, so that its tyres slip no more
EDGE_SECONDS, ARRIVAL_SHARE = (
    0.15,
    0.9,
)  # s in which the steer rises; share of the end at which one says that it is there
TIMES = np.linspace(0.0, 3.5, 701)


class Answer(NamedTuple):
    """Responses over `TIMES`, per steer."""

    yaw: np.ndarray  # yaw rate [1/s]
    side: np.ndarray  # acceleration to the left [m/s^2]
    roll: np.ndarray  # [-]


def answer_of(run, steer) -> Answer:
    """Return the response of a run per steer."""
    left = np.einsum("ti,ti->t", run.rotation("chassis")[:, :, 1], run.acceleration("chassis"))
    lean = run.measure(measures.lean(run.system.part("chassis"))).ravel()
    return Answer(run.omega("chassis")[:, 2] / steer, left / steer, lean / steer)


def arrival(x: np.ndarray) -> float:
    """Return the time after half of the steer at which a curve first reaches `ARRIVAL_SHARE` of its final value [s]."""
    found = CubicSpline(TIMES, x - ARRIVAL_SHARE * x[-1]).roots(extrapolate=False)
    return float(found[0]) - 0.5 * EDGE_SECONDS


def features(one: Answer) -> dict[str, float]:
    """Return the features of a response that are compared."""
    ends = {"yaw_gain_1_s": one.yaw[-1], "side_gain_m_s2": one.side[-1], "roll_gain": one.roll[-1]}
    return {name: float(x) for name, x in ends.items()} | {
        "yaw_s": arrival(one.yaw),
        "side_s": arrival(one.side),
        "roll_s": arrival(one.roll),
    }


def mechanism(
    *, ms=1400.0, h=0.55, a=1.2, b=1.5, track=1.5, damping=2000.0, relaxation=0.4, v=25.0, steer=0.05
) -> System:  # fmt: skip
    """Build the car at v whose front wheels are steered to an angle [rad]."""
    require(v > 0.0, f"demo 'step_steer': v = {v:g} m/s; give a speed ahead")
    return car(car_of(ms, h, a, b, track, damping, relaxation), v, Pulse(steer, start=0.0, edge=EDGE_SECONDS))


def car_of(ms, h, a, b, track, damping, relaxation):
    """Return the car with some of its numbers."""
    return Car(ms=ms, h=h, a=a, b=b, track=track, damping=damping, relaxation=relaxation)


def known(ms, h, a, b, track, damping, relaxation, v, spin):
    """Return the response of the small motions in closed form."""
    c = car_of(ms, h, a, b, track, damping, relaxation)
    steer, small = Pulse(SMALL_STEER, start=0.0, edge=EDGE_SECONDS), linear(c, v, spin)
    x, rates = small.respond(steer, TIMES, [EDGE_SECONDS])
    return Answer(x[:, 5 + HEADING] / SMALL_STEER, rates[:, 5 + Y] / SMALL_STEER, x[:, ROLL] / SMALL_STEER)


def theory(*, ms, h, a, b, track, damping, relaxation, v):
    """Return the features of the small motions of `linear`."""
    return features(known(ms, h, a, b, track, damping, relaxation, v, FULL_SPIN))


def without_gyroscopic(*, ms, h, a, b, track, damping, relaxation, v):
    """Return the values without the gyroscopic moment: half of the moments that turn the wheels' spin is I dw/dt of
    their diameters, and stays.
    """
    return features(known(ms, h, a, b, track, damping, relaxation, v, HALF_SPIN))


def measure(build, terms, *, ms, h, a, b, track, damping, relaxation, v, steer) -> Measured:
    """Measure a very small step, and the given one."""
    theirs = known(ms, h, a, b, track, damping, relaxation, v, FULL_SPIN)
    little = SMALL_STEER * min(1.0, RESPONSE_MAX / np.abs(theirs.side).max())
    small = simulate(build(steer=little), TIMES[-1], output=TIMES, rtol=TIGHT_RTOL, **terms)
    run = simulate(build(), TIMES[-1], output=TIMES, rtol=1e-6, **terms)
    found, large = answer_of(small, little), answer_of(run, steer)
    name = f"steer {np.degrees(steer):.3g} deg"
    labels = "yaw rate over steer [1/s]", "side acceleration over steer [m/s^2]", "roll over steer [-]"
    curves = [
        Curve(label, TIMES, mine, (TIMES, small), name="small steer", more=[Line(name, big)])
        for label, mine, small, big in zip(labels, found, theirs, large, strict=True)
    ]
    return Measured(features(found), [run], curves)


demo = Demo(
    __name__,
    title="A step of the steer",
    question="In which order does a car answer its steering wheel: does it yaw, move aside, or roll first?",
    beats=(
        Beat(0.0, "Steered at once."),
        Beat(0.309, "First it turns ..."),
        Beat(0.477, "... then it goes aside ..."),
        Beat(0.499, "... and last it leans."),
    ),
    why="The front tyres push as soon as they have rolled a little way, and the car yaws. Only when it has turned do "
    "the rear tyres push too: then it moves aside with all it has, and by that it rolls, last, on its springs and "
    "dampers. The faster the car the later all of it. After a large step each comes to less in proportion, as the "
    "tyres slip more.",
    equation="M q'' + D q' + K q = B d'' + C d' + T F; q: five displacements; the tyres lag",
    symbols=SYMBOLS,
    source="ISO 7401 (step input); Milliken, Milliken, Race Car Vehicle Dynamics",
    quantities={
        "yaw_gain_1_s": Quantity("yaw rate over steer, in the end", "1/s", relative=2e-5),
        "side_gain_m_s2": Quantity("side acceleration over steer, in the end", "m/s^2", relative=2e-5),
        "roll_gain": Quantity("roll over steer, in the end", "", relative=2e-5),
        "yaw_s": Quantity("90 % of the yaw rate after", "s", relative=1e-4),
        "side_s": Quantity("90 % of the side acceleration after", "s", relative=1e-4),
        "roll_s": Quantity("90 % of the roll after", "s", relative=1e-4),
    },
    ablation=Ablation(
        "gyroscopic",
        "the car rolls less, by half of what its spinning wheels add; the other half is I dw/dt of the wheels",
        values=without_gyroscopic,
    ),
    alone="MuJoCo has no such tyre, and Exudyn no bar between two wheels",
    show={**SHOW_OPTIONS, "curves": [("force", "front right tyre"), ("force", "rear right tyre")]},
    sliders=(
        Control("v", 15.0, 35.0, "m/s", "speed"),
        Control("steer", 0.01, 0.06, "rad"),
    ),
    attempt="drive faster: the car leans later, and swings longer.",
)  # fmt: skip
