"""Car as a single track, both tyres of an axle in one: its eigenvalues, yaw gain and characteristic speed."""

import numpy as np
from scipy.optimize import brentq

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Planar,
    Pulse,
    Revolute,
    System,
    Tyre,
    accelerations,
    linearize,
    measures,
    rotation,
    shapes,
    simulate,
)

from ..figure import Line
from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share
from .car import KINGPIN_SHAPE, G

WHEEL_RADIUS, TYRE_STIFFNESS = 0.3, 1e6  # m; N/m of the tyres' springs, which carry the weight
SMALL_STEER = 1e-6  # [rad] of steer
# the wheels are locked, and longitudinal forces do not hold them
SOFT_TYRE = {"longitudinal": 1e-12, "relaxation_x": 1e9}
VISIBLE_RELAXATION = 0.1  # [m] of relaxation in the run that is shown
STRAIGHT_RUN = {"steer": 0.0, "step": 0.0}  # the motion that is linearized
SPEED_MAX = 100.0  # [m/s] of the curves
CABIN_WIDTH = 1.5  # [m] of the cabin that is drawn
SLOWDOWN_SHARE_MAX = 1e-5  # [1] error of the steady state in a run that slows down by that


def mechanism(
    *, m=1600.0, Iz=3600.0, a=1.4, b=1.6, Cf=60e3, Cr=60e3, v=20.0, relaxation=1e-8, steer=0.0, step=0.01
) -> System:  # fmt: skip
    """Build a body m [kg], Iz [kg m^2] at v, on two linear tyres, Cf [N/rad] a ahead and Cr b behind.

    ``relaxation`` [m]: the tyres' forces follow their slip after this way; ``steer``, ``step`` [rad]: of the ride that
    is shown, at the start and what is added within 0.1 s.
    """
    require(v > 0.0, f"demo 'single_track': v = {v:g} m/s; give a speed ahead")
    up, form = (0, 0, 1), drawn(a, b)
    body = Body("car", m, (0.5 * Iz, 0.5 * Iz, Iz), position=(0, 0, WHEEL_RADIUS), velocity=(v, 0, 0), shape=form)
    wheel = [KINGPIN_SHAPE, shapes.Cylinder(WHEEL_RADIUS, 0.2, "y", colour="dimgray")]
    knuckle = Body(
        "knuckle", 0.0, (0, 0, 0), position=(a, 0, WHEEL_RADIUS), orientation=rotation("z", steer), shape=wheel
    )
    hinge = Revolute(body, knuckle, at=(a, 0, WHEEL_RADIUS), axis=up, name="kingpin")
    turn = AngleDriver(hinge, Pulse(step, start=0.2, edge=0.1), name="steering")
    tyres = []
    for name, on, x, C, other in (("front", knuckle, a, Cf, b), ("rear", body, -b, Cr, a)):
        N = m * G * other / (a + b)
        numbers = {
            "cornering": C / N,
            "mu": None,
            "relaxation": relaxation,
            "stiffness": TYRE_STIFFNESS,
            "name": name,
            **SOFT_TYRE,
        }
        tyres.append(
            Tyre(
                GROUND,
                on,
                axis=on.axes[:, 1],
                radius=WHEEL_RADIUS + N / TYRE_STIFFNESS,
                centre=(x, 0, WHEEL_RADIUS),
                **numbers,
            )
        )
    return System([body, knuckle], [Planar(GROUND, body, at=(0, 0, WHEEL_RADIUS), normal=up), hinge, turn], tyres)


def drawn(a, b):
    """Draw a floor between the wheels, a cabin as wide as a car, and the rear wheel."""
    L, middle = a + b, 0.5 * (a - b)
    return [
        shapes.Box((L - 3 * WHEEL_RADIUS, 0.6, 0.3), at=(middle, 0, 0.1), colour="lightsteelblue"),
        shapes.Box((0.55 * L, CABIN_WIDTH, 0.45), at=(middle, 0, 0.45), colour="lightsteelblue"),
        shapes.Cylinder(WHEEL_RADIUS, 0.2, "y", at=(-b, 0, 0), colour="dimgray"),
    ]


def theory(*, m, Iz, a, b, Cf, Cr, v):
    """Return eigenvalues of x = (speed to the left, yaw rate); K is the understeer gradient, and the gain v/(L + K v^2)
    peaks at V.
    """
    L = a + b
    K = m * (b * Cr - a * Cf) / (L * Cf * Cr)
    require(K > 0.0, "demo 'single_track': it oversteers and has no characteristic speed; give b Cr > a Cf")
    A = -np.array([
        [(Cf + Cr) / (m * v), v + (a * Cf - b * Cr) / (m * v)],
        [(a * Cf - b * Cr) / (Iz * v), (a * a * Cf + b * b * Cr) / (Iz * v)],
    ])  # fmt: skip
    s = max(np.linalg.eigvals(A), key=lambda s: (s.imag, s.real))
    return {
        "damping_1_s": float(-s.real),
        "frequency_rad_s": float(s.imag),
        "yaw_gain_1_s": v / (L + K * v * v),
        "characteristic_m_s": np.sqrt(L / K),
    }


def small_motions(system, v, terms):
    """Return A of speed to the left over that ahead, yaw rate and the deflections of both tyres, shape (4, 4)."""
    body, forces = system.part("car"), system.forces
    seen = [measures.velocity(body, axis=(0, 1, 0)), measures.heading_rate(body)]
    seen += [*(measures.state(tyre, "lateral") for tyre in forces), measures.heading(body)]
    A = linearize(system, outputs=seen, tolerance=SLOWDOWN_SHARE_MAX, **terms).A
    turned = np.eye(5)
    turned[0, 4] = v  # over the ground it has that of the heading too
    return np.linalg.solve(turned, A @ turned)[:4, :4]


def response(build, v, terms):
    """Return (eigenvalue of the car [1/s], yaw rate over steer [1/s]) at a speed [m/s].

    Where nothing changes A x = -B steer; B is what a little steer starts. The deflections of the tyres have large
    eigenvalues, those of the car are the two small ones.
    """
    A = small_motions(build(v=v, **STRAIGHT_RUN), v, terms)
    start = accelerations(build(v=v, **STRAIGHT_RUN | {"steer": SMALL_STEER}), **terms)
    rates = [start.acceleration("car")[0, 1], start.alpha("car")[0, 2]]
    rates += [start.force(name).state_rates["lateral"][0] for name in ("front", "rear")]
    s = np.linalg.eigvals(A)
    slow = max(s[np.argsort(np.abs(s))[:2]], key=lambda s: (s.imag, s.real))
    return slow, float(np.linalg.solve(A, rates)[1] / -SMALL_STEER)


def film(build) -> System:
    """Build what is seen: the car on tyres whose forces come late enough for steps that one can wait for."""
    return build(relaxation=VISIBLE_RELAXATION)


def measure(build, terms, *, a, b, v) -> Measured:
    """Measure eigenvalue and yaw gain at v, the speed at which a circle needs twice the steer L/R, and a step of the
    steer.
    """

    def more_steer(v):
        return v / response(build, v, terms)[1] - 2.0 * (a + b)

    slow, gain = response(build, v, terms)
    guess = v / np.sqrt(v / gain / (a + b) - 1.0)
    values = {
        "damping_1_s": float(-slow.real),
        "frequency_rad_s": float(slow.imag),
        "yaw_gain_1_s": gain,
        "characteristic_m_s": float(brentq(more_steer, 0.9 * guess, 1.1 * guess, xtol=1e-8)),
    }
    run = simulate(build(relaxation=VISIBLE_RELAXATION), 3.0, output=301, **terms)
    return Measured(values, [run], curves(build, terms, values["characteristic_m_s"]))


def curves(build, terms, characteristic):
    """Draw yaw gain and eigenvalues over the speed, up to twice the characteristic one where that is in reach."""
    speeds = np.geomspace(0.1, 1.0, 12) * min(2.0 * characteristic, SPEED_MAX)
    found = [response(build, v, terms) for v in speeds]
    known = [build.demo.call(theory, {**build.values, "v": v}) for v in speeds]
    lines = {
        "damping": ("damping_1_s", [-s.real for s, _ in found]),
        "frequency": ("frequency_rad_s", [s.imag for s, _ in found]),
    }
    dots = {name: (speeds, [one[key] for one in known]) for name, (key, _) in lines.items()}
    (first, (_, y)), (other, (_, z)) = lines.items()
    gains = [gain for _, gain in found], [one["yaw_gain_1_s"] for one in known]
    along = "speed [m/s]"
    return [
        Curve("yaw rate over steer [1/s]", speeds, gains[0], (speeds, gains[1]), along),
        Curve("rate [1/s]", speeds, y, dots[first], along, name=first, more=[Line(other, z, None, dots[other])]),
    ]


demo = Demo(
    __name__,
    title="The car as a single track",
    question="Why does a car answer its steering wheel most at one speed, and less when it is faster?",
    beats=(
        Beat(0.0, "A step of the handwheel at 72 km/h."),
        Beat(share(1.0), "It turns at 5.4 times its steer, each second. At 41 m/s it would be most."),
    ),
    why="A turn wants a side force of each axle, and that a slip angle of its tyres. If the front axle has to slip "
    "more, the car understeers: the faster it is the more of the steer goes into slip, and from the "
    "characteristic speed on, where a circle wants twice the steer, the yaw rate falls. The same slip damps the "
    "car, and ever less the faster it is: the slips are sideways speeds over the speed ahead.",
    equation="(yaw rate) / steer = v/(L + K v^2), K = m (b C_r - a C_f)/(L C_f C_r), V = sqrt(L/K)",
    symbols={
        "v": Symbol("speed", "m/s", "v"),
        "L": Symbol("wheelbase", "m", lambda a, b: a + b),
        "K": Symbol("understeer", "rad s^2/m", lambda m, a, b, Cf, Cr: m * (b * Cr - a * Cf) / ((a + b) * Cf * Cr)),
        "m": Symbol("car", "kg", "m"),
        "a": Symbol("front axle, from the centre of mass", "m", "a"),
        "b": Symbol("rear axle", "m", "b"),
        "C_f": Symbol("stiffness of the front tyres", "N/rad", "Cf"),
        "C_r": Symbol("stiffness of the rear tyres", "N/rad", "Cr"),
        "V": Symbol("speed of the fastest answer", "m/s"),
    },
    source="Riekert, Schunck 1940; Milliken, Milliken, Race Car Vehicle Dynamics, ch. 5",
    quantities={
        "damping_1_s": Quantity("damping of the swing between sideslip and yaw", "1/s", relative=1e-6),
        "frequency_rad_s": Quantity("its frequency", "rad/s", relative=1e-6),
        "yaw_gain_1_s": Quantity("yaw rate over steer", "1/s", relative=1e-9),
        "characteristic_m_s": Quantity("characteristic speed", "m/s", relative=1e-7),
    },
    ablation=Ablation(
        "understeer",
        "with the centre of mass all but in the middle both axles slip alike, the yaw rate grows with the speed, and "
        "the characteristic speed is out of reach",
        {"a": 1.4999, "b": 1.5001},
    ),
    alone="its closed forms say all of it",
    show={"curves": [("force", "front"), ("force", "rear")], "hidden": ["joints", "joint names"], "follow": "car"},
    ranges={"a": (1.3, 1.4), "Cf": (50e3, 58e3), "relaxation": None, "steer": None},
    may_vanish=("step",),
    sliders=(
        Control("v", 8.0, 40.0, "m/s", "speed"),
        Control("step", 0.005, 0.02, "rad", "step of the steering"),
    ),
    attempt="drive faster: the answer comes later and overshoots.",
)  # fmt: skip
