"""A crank, a rod with ball ends and a rocker on a skew axis: a turn becomes a swing."""

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import minimize_scalar

from mbsd3d import GROUND, AngleDriver, Body, Distance, Kinematic, Ramp, Revolute, System, shapes, simulate

from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require

TURN_SAMPLES = 1441  # [1] of one turn; cubics between them err by less than 1e-12


def mechanism(*, a=0.1, b=0.3, l=0.5, Q=(0.4, 0.1, 0.2), u=(1.0, 0.3, -0.2), branch=1) -> System:
    """Build a crank a [m] about z, rod l [m], rocker b [m] about an axis u through Q; branch 1 or -1: how it is
    assembled.
    """
    require(branch in (1, -1), f"demo 'rssr': branch = {branch}; give 1 or -1")
    axis = np.asarray(u) / np.linalg.norm(u)
    pin, ball = np.array([a, 0, 0]), rocker_ball(rocker(0.0, a, b, l, Q, u, branch), b, Q, u)
    crank = Body("crank", 1.0, (0.01, 0.01, 0.01), shape=rod(np.zeros(3), pin, a))
    arm = Body("rocker", 1.0, (0.01, 0.01, 0.01), position=Q, shape=[*rod(np.zeros(3), ball - Q, a),
               shapes.Cylinder(0.08 * a, 2 * a, tuple(axis), at=(0, 0, 0))])  # fmt: skip
    turn = Revolute(GROUND, crank, at=(0, 0, 0), axis=(0, 0, 1), name="crankshaft")
    joints = [
        turn,
        AngleDriver(turn, Ramp(1.0), name="motor"),
        Revolute(GROUND, arm, at=Q, axis=axis, name="rocker shaft"),
        Distance(crank, arm, at_a=pin, at_b=ball, name="rod"),
    ]
    return System([crank, arm], joints, gravity=(0, 0, 0))


def rod(start, end, size):
    """Draw a bar with a ball at its end."""
    along = end - start
    bar = shapes.Cylinder(0.1 * size, np.linalg.norm(along), tuple(along), at=0.5 * (start + end))
    return [bar, shapes.Sphere(0.18 * size, at=end)]


def cross_axes(u):
    """Return two axes that make a right-handed frame with u."""
    u = np.asarray(u) / np.linalg.norm(u)
    first = np.cross(u, np.eye(3)[np.argmin(abs(u))])
    first /= np.linalg.norm(first)
    return first, np.cross(u, first)


def rocker_ball(f, b, Q, u):
    """Return the end of the rocker at an angle f [m]."""
    one, two = cross_axes(u)
    return np.asarray(Q) + b * (np.cos(f) * one + np.sin(f) * two)


def rocker(angle, a, b, l, Q, u, branch):
    """Solve A cos f + B sin f = C: f = atan2(B, A) +- acos(C/|A, B|) for |pin - ball| = l."""
    one, two = cross_axes(u)
    out = a * np.stack([np.cos(angle), np.sin(angle), 0 * np.asarray(angle)], axis=-1) - Q
    A, B = 2 * b * out @ one, 2 * b * out @ two
    C = b**2 - l**2 + np.sum(out**2, axis=-1)
    share = C / np.hypot(A, B)
    require(np.all(abs(share) < 1), "demo 'rssr': the crank does not go all the way round; give other lengths")
    return np.arctan2(B, A) + branch * np.arccos(share)


def theory(*, a, b, l, Q, u, branch):
    """Return the closed form of the rocker, its extremes over a turn."""
    turn = np.linspace(0, 2 * np.pi, 721)
    f = np.unwrap(rocker(turn, a, b, l, Q, u, branch))

    def since(t, start):
        return (rocker(t, a, b, l, Q, u, branch) - start + np.pi) % (2 * np.pi) - np.pi

    def extreme(sign):
        k = np.argmax(sign * f)
        near = {"bounds": (turn[k] - 0.01, turn[k] + 0.01), "method": "bounded", "options": {"xatol": 1e-10}}
        return f[k] - sign * minimize_scalar(lambda t: -sign * since(t, f[k]), **near).fun

    at_1 = since(1.0, f[0])
    return {"turn_at_1rad_deg": np.degrees(at_1), "swing_deg": np.degrees(extreme(1) - extreme(-1))}


def measure(build, terms, *, a, b, l, Q, u, branch) -> Measured:
    """Measure the rocker angle after a crank angle of 1 rad, and its swing over a turn."""
    system = build()
    at_1 = simulate(system, 1.0, method=Kinematic(), output=61, **terms)
    run = simulate(system, 2 * np.pi, method=Kinematic(), output=TURN_SAMPLES, **terms)
    angle = run.angle("rocker shaft")
    between = CubicHermiteSpline(run.t, angle, run.rate("rocker shaft"))
    ends = between(between.derivative().roots(extrapolate=False))
    degrees, known = np.degrees(run.t), np.unwrap(rocker(run.t, a, b, l, Q, u, branch))
    curve = Curve("rocker [deg]", degrees, np.degrees(angle), (degrees, np.degrees(known - known[0])), "crank [deg]")
    values = {"turn_at_1rad_deg": np.degrees(at_1.angle("rocker shaft")[-1]), "swing_deg": np.degrees(np.ptp(ends))}
    return Measured(values, [run], [curve])


demo = Demo(
    __name__,
    title="A windscreen wiper between skew axes",
    question="How does a windscreen wiper hand a turn from one axis to a skew one?",
    beats=(
        Beat(0.0, "Round and round on one axis ..."),
        Beat(0.85, "... the end of the sweep, on another ..."),
        Beat(3.82, "... and the other end, 72 degrees away."),
    ),
    why="A rod with a ball at each end asks for one thing only: that its length stays. So crank and rocker may turn "
    "about axes that are neither parallel nor meet, and still hand on one motion. Written down for the rocker's "
    "angle, the condition has two solutions: the two ways of putting it together.",
    equation="A cos f + B sin f = C; f = atan2(B, A) +- acos(C / |A, B|)",
    symbols={
        "f": Symbol("rocker", "rad", curve=(1, 0)),
        "A": Symbol("of crank, rocker and distance", "m^2"),
        "B": Symbol("the same across", "m^2"),
        "C": Symbol("of the length of the rod", "m^2"),
    },
    source="Hartenberg, Denavit, Kinematic Synthesis of Linkages, ch. 12; Hunt, Kinematic Geometry of Mechanisms",
    quantities={
        "turn_at_1rad_deg": Quantity("rocker after 1 rad of the crank", "deg"),
        "swing_deg": Quantity("swing of the rocker", "deg"),
    },
    ablation=Ablation("skewness", "on parallel axes it is the plane four-bar", {"u": [0, 0, 1.0], "Q": [0.4, 0.1, 0]}),
    show={"curves": [("angle", "crankshaft"), ("angle", "rocker shaft")], "traces": []},
    ranges={
        "branch": None,
        "a": (0.09, 0.105),
        "b": (0.28, 0.34),
        "l": (0.49, 0.52),
        "Q": [(0.38, 0.41), (0.08, 0.12), (0.18, 0.22)],
    },
    sliders=(
        Control("a", 0.05, 0.13, "m", "crank"),
        Control("l", 0.47, 0.53, "m", "rod"),
    ),
    attempt="take a longer crank: the wiper swings wider, and less evenly.",
)
