"""Hinges alone make an exact straight line: knees in two planes hold a platform level."""

import numpy as np

from mbsd3d import GROUND, AngleDriver, Body, Kinematic, Polynomial, Revolute, System, shapes, simulate

from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

T = 1.0  # s, from half the angle to the angle


def mechanism(*, l=0.5, x=0.4, q_deg=50.0, rate=0.6, legs=2, plane_deg=90.0) -> System:
    """Build legs of two links l [m] at x [m] from the middle, each plane turned from the last; driven to q at a rate
    [rad/s].
    """
    require(2 <= legs <= 4, f"demo 'sarrus': legs = {legs}; give 2, 3 or 4")
    end, start = np.radians(q_deg), np.radians(q_deg) / 2
    up = np.array([0, 0, 1.0])
    top = Body("platform", 2.0, (0.1, 0.1, 0.1), position=2 * l * np.sin(start) * up,
               shape=shapes.Box((2.4 * x, 2.4 * x, 0.04 * l)))  # fmt: skip
    bodies, joints = [top], []
    for k, angle in enumerate(np.radians(plane_deg) * np.arange(legs)):
        out, across = np.array([np.cos(angle), np.sin(angle), 0]), np.array([np.sin(angle), -np.cos(angle), 0])
        foot, knee = x * out, x * out + l * (np.cos(start) * out + np.sin(start) * up)
        head = x * out + 2 * l * np.sin(start) * up
        links = [bar(f"{name} {k + 1}", *ends) for name, ends in (("shin", (foot, knee)), ("thigh", (knee, head)))]
        bodies += links
        for name, place, pair in (
            ("foot", foot, (GROUND, links[0])),
            ("knee", knee, links),
            ("hip", head, (links[1], top)),
        ):
            joints.append(Revolute(*pair, at=place, axis=across, name=f"{name} {k + 1}"))
    # from rest to the angle in T, with the wanted rate at its end
    turn = Polynomial((0, 0, (3 * (end - start) - rate * T) / T**2, (rate * T - 2 * (end - start)) / T**3))
    return System(bodies, [*joints, AngleDriver(joints[0], turn, name="motor")], gravity=(0, 0, 0))


def bar(name, start, end):
    """Return a link between two points."""
    along = end - start
    form = shapes.Cylinder(0.04 * np.linalg.norm(along), np.linalg.norm(along), tuple(along))
    return Body(name, 1.0, (0.01, 0.01, 0.01), position=0.5 * (start + end), shape=form)


def theory(*, l, q_deg, rate, plane_deg):
    """Return the height 2 l sin q, rate 2 l cos q q'; one degree of freedom, although counting the hinges of two legs
    gives none.
    """
    require(
        0 < abs(q_deg) < 90, f"demo 'sarrus': q_deg = {q_deg:g}: flat or upright legs hold no platform; stay between"
    )
    require(plane_deg % 180 != 0, f"demo 'sarrus': plane_deg = {plane_deg:g}: legs in parallel planes hold no platform")
    q = np.radians(q_deg)
    return {"height_m": 2 * l * np.sin(q), "mobility": 1.0, "rise_rate_m_s": 2 * l * np.cos(q) * rate}


def measure(build, terms, *, l, q_deg) -> Measured:
    """Measure height and rate of the platform at the end, and mobility without the motor."""
    system = build()
    mobility = System(system.bodies, system.joints[:-1]).check().mobility
    if mobility != 1:  # more than the motor drives
        return Measured({"height_m": np.nan, "mobility": mobility, "rise_rate_m_s": np.nan})
    run = simulate(system, T, method=Kinematic(), output=121, **terms)
    place, q = run.position("platform"), np.degrees(run.angle("foot 1")) + q_deg / 2
    known = 2 * l * np.sin(np.radians(q))
    off = np.linalg.norm(place[:, :2], axis=1)
    curves = [
        Curve("height [m]", q, place[:, 2], (q, known), "angle of the legs [deg]"),
        Curve("off the straight line [m]", q, off, (q, 0 * q), "angle of the legs [deg]", scale=0.1 * l),
    ]
    values = {"height_m": place[-1, 2], "mobility": mobility, "rise_rate_m_s": run.velocity("platform")[-1, 2]}
    return Measured(values, [run], curves)


demo = Demo(
    __name__,
    title="Sarrus' straight line",
    question="How do hinges alone make an exact straight line, which no plane linkage does with so few?",
    beats=(
        Beat(0.0, "Nothing but hinges."),
        Beat(share(0.5), "The table rises straight and level."),
        Beat(share(1.0), "77 cm high, and not a hair aside."),
    ),
    why="A knee lets a platform move in the plane of the leg and tilt about its hinges. A second knee in another "
    "plane allows other motions; all that both allow is going straight up and down, without tilting. Sarrus "
    "found this in 1853, eleven years before Peaucellier's famous plane linkage. Counting hinges gives no "
    "freedom: two of the conditions say the same.",
    equation="height = 2 l sin q; rate = 2 l q' cos q; mobility 1 where counting says 0 (two legs)",
    symbols={
        "q": Symbol("angle of the legs, from its start on", "rad", curve=(1, 0)),
        "l": Symbol("half a leg", "m", "l"),
    },
    source="Sarrus, C. R. Acad. Sci. 36 (1853) 1036; Hunt, Kinematic Geometry of Mechanisms",
    quantities={
        "height_m": Quantity("height of the platform", "m"),
        "mobility": Quantity("degrees of freedom without the motor"),
        "rise_rate_m_s": Quantity("rate of rise", "m/s"),
    },
    ablation=Ablation(
        "planes",
        "legs in parallel planes leave three degrees of freedom",
        {"plane_deg": 180.0},
        values=lambda: {"mobility": 3.0},
    ),  # fmt: skip
    show={"curves": [("position", "platform"), ("angle", "foot 1")], "traces": []},
    ranges={"plane_deg": None, "x": (0.35, 0.5)},
    sliders=(
        Control("plane_deg", 40.0, 140.0, "deg", "angle of the planes"),
        Control("rate", 0.2, 0.8, "rad/s", "rate of the foot"),
    ),
    attempt="turn one leg about the vertical: whatever the angle between the planes, the platform goes straight up.",
)
