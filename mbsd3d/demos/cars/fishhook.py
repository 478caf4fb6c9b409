"""Fishhook of rollover tests: a car is steered one way and, at its largest roll, the other."""

import numpy as np
from scipy.interpolate import CubicSpline

from mbsd3d import Pulse, System, measures, simulate

from ..figure import Line
from ..form import Ablation, Beat, Curve, Demo, Measured, Quantity, require
from ..moments import share
from .car import SHOW_OPTIONS, WHEELS, Car, car
from .linear import ROLL, SYMBOLS, linear

SMALL_STEER, TIGHT_RTOL = 1e-6, 1e-12  # rad of steer: what is of second order has no say; tolerance of the run
EDGE_SECONDS = 0.15  # [s] in which it is steered by the angle, back by twice of it in twice the time
REVERSAL_SECONDS_MAX = 3.0  # [s] after which a car that still rolls on is steered back
TIMES = np.linspace(0.0, 5.0, 1001)
MAXIMUM_RISE_MIN = 1e-6  # [1] by which a maximum exceeds the end; with less it may be rounding
TIPPED_ROLL = 1.0  # [rad] of roll at which a car falls onto its side


def mechanism(
    *, ms=1400.0, h=0.7, track=1.5, kf=25e3, kr=22e3, damping=2000.0, v=22.0, steer=0.1, back=1.0, at=0.73
) -> System:  # fmt: skip
    """Build the car at v, steered to the left by an angle [rad], and at a time [s] to the right by ``back`` of it."""
    require(v > 0.0 and back >= 0.0, f"demo 'fishhook': v = {v:g} m/s, back = {back:g}; give v > 0 and back >= 0")
    return car(car_of(ms, h, track, kf, kr, damping), v, hook(steer, back, at))


def car_of(ms, h, track, kf, kr, damping):
    """Return the car with some of its numbers."""
    return Car(ms=ms, h=h, track=track, kf=kf, kr=kr, damping=damping)


def hook(steer, back, at):
    """Return the steer angle over time [rad] of the fishhook manoeuvre."""
    return Pulse(steer, start=0.0, edge=EDGE_SECONDS) + Pulse(-(1.0 + back) * steer, start=at, edge=2.0 * EDGE_SECONDS)


def top(t, x, after=0.0):
    """Return (time, value) of the first maximum of a curve after a time, between its samples; None if there is none."""
    curve = CubicSpline(t, x)
    slope = curve.derivative()
    tops = [place for place in slope.roots(extrapolate=False) if place > after and curve(place, 2) < 0.0]
    return (float(tops[0]), float(curve(tops[0]))) if tops else None


def features(answer):
    """Return features of small motions, whose roll per steer over `TIMES` is ``answer(time of steering back)``, and
    these rolls.

    When it is steered back; the roll of the single turn in the end; the largest one to the left over that.
    """
    single = answer(TIMES[-1])
    found = top(TIMES, single)
    back = found is not None and found[1] > single[-1] * (1.0 + MAXIMUM_RISE_MIN)
    require(back, "demo 'fishhook': this car does not roll back by itself; give less damping or track")
    roll = answer(found[0])
    _, swing = top(TIMES, -roll, found[0]) or (TIMES[-1], -roll[-1])
    values = {"at_s": found[0], "roll_gain": float(single[-1]), "swing_over_steady": float(swing / single[-1])}
    return values, [roll, single]


def by_hand(c, v, back):
    """Return a function for the roll of the small motions per steer, by the time of steering back."""
    small = linear(c, v)

    def roll(at):
        return (
            small.respond(hook(SMALL_STEER, back, at), TIMES, [EDGE_SECONDS, at, at + 2.0 * EDGE_SECONDS])[0][:, ROLL]
            / SMALL_STEER
        )

    return roll


def theory(*, ms, h, track, kf, kr, damping, v, back):
    """Return the features of the small motions of `linear`."""
    return features(by_hand(car_of(ms, h, track, kf, kr, damping), v, back))[0]


def roll_of(run):
    """Return the roll to the right [rad]."""
    return run.measure(measures.lean(run.system.part("chassis"))).ravel()


def measure(build, terms, *, ms, h, track, kf, kr, damping, v, back) -> Measured:
    """Measure very small steers, and a large one: a single turn, and the fishhook at the time of its largest roll."""

    def small(at):
        run = simulate(build(steer=SMALL_STEER, at=at), TIMES[-1], output=TIMES, rtol=TIGHT_RTOL, **terms)
        return roll_of(run) / SMALL_STEER

    def large(at):
        system = build(at=at)
        fallen = measures.lean(system.part("chassis")) < -TIPPED_ROLL
        return simulate(system, TIMES[-1], output=TIMES, rtol=1e-6, stop_when=fallen, **terms)

    values, found = features(small)
    single = large(TIMES[-1])
    turned = top(single.t, roll_of(single)) or (REVERSAL_SECONDS_MAX, 0.0)
    run = large(min(turned[0], REVERSAL_SECONDS_MAX))
    known = features(by_hand(car_of(ms, h, track, kf, kr, damping), v, back))[1]
    notes = [f"steered back after {turned[0]:.3f} s: {said(run)}", f"a single turn of the same steer: {said(single)}"]
    return Measured(values, [run], curves(found, known, run, single), notes=notes)


def loads_of(run):
    """Return the loads of the wheels [N], shape (4, n)."""
    return np.array([run.force(f"{name} tyre").normal for name in WHEELS])


def said(run):
    """Return in a line how far the car rolls and whether it tips."""
    roll, least = np.degrees(roll_of(run)), loads_of(run).min(axis=1)
    if roll[-1] < -np.degrees(TIPPED_ROLL) + 1.0:
        return f"the car falls onto its left side within {run.t[-1]:.2f} s"
    lifted = [name for name, load in zip(WHEELS, least, strict=True) if load <= 0.0]
    what = f"lifted: {', '.join(lifted)}" if lifted else f"no wheel lifts, the least load is {least.min():.0f} N"
    right, left = max(0.0, roll.max()), max(0.0, -roll.min())
    return f"it rolls up to {right:.1f} deg to the right and {left:.1f} deg to the left; {what}"


def curves(found, known, run, single):
    """Draw roll of small steers and of the large one, and loads of the wheels."""
    loads, names = loads_of(run), [*WHEELS]
    small, one = (np.asarray(x) for x in found)
    return [
        Curve(
            "roll over steer, small [-]", TIMES, small, (TIMES, known[0]), name="fishhook",
            more=[Line("a single turn", one, None, (TIMES, known[1]))],
        ),
        Curve(
            "roll to the right [deg]", run.t, np.degrees(roll_of(run)), name="fishhook",
            more=[Line("a single turn", np.degrees(roll_of(single)), single.t)],
        ),
        Curve("load [N]", run.t, loads[0], name=names[0], more=[Line(names[k], loads[k]) for k in (1, 2, 3)]),
    ]  # fmt: skip


demo = Demo(
    __name__,
    title="The fishhook",
    question="Why does a car that slides in a steady turn tip over when it is steered to and fro?",
    beats=(
        Beat(0.0, "At 79 km/h."),
        Beat(0.531, "Steered one way it holds, and is steered back now."),
        Beat(share(0.75), "The wheels on one side are off the road."),
        Beat(share(1.0), "Over."),
    ),
    why="In a steady turn the loads of the inner wheels follow the side force, and that ends with the grip: a car "
    "that is low and wide enough slides. A car that is thrown from one side to the other, just when it has rolled "
    "farthest, swings through: springs and side force now push the same way, and it rolls farther than any steady "
    "turn rolls it. With luggage on its roof this one falls over at a steer at which a single turn leaves all "
    "wheels on the road.",
    equation="roll of the fishhook / roll of the steady turn, by M q'' + D q' + K q = B d'' + C d' + T F",
    symbols=SYMBOLS,
    source="NHTSA, Federal Register 68 (2003), p. 59250 (fishhook with roll rate feedback)",
    quantities={
        "at_s": Quantity("it has rolled farthest, and is steered back, after", "s", relative=1e-4),
        "roll_gain": Quantity("roll over steer, in the end of a single turn", "", relative=2e-5),
        "swing_over_steady": Quantity("largest roll to the other side, over that", "", relative=5e-5),
    },
    ablation=Ablation("steering_back", "steered straight again only, it swings over by very little", {"back": 0.0}),
    alone="MuJoCo has no such tyre, and Exudyn no bar between two wheels",
    show={**SHOW_OPTIONS, "curves": [("force", "front right tyre"), ("force", "rear right tyre")]},
    ranges={"h": (0.6, 0.72), "damping": (1500.0, 2300.0), "at": None},
)  # fmt: skip
