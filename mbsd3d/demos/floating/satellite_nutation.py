"""A spinning body thrown with a little tilt wobbles: two cones that roll on each other."""

import numpy as np

from mbsd3d import GROUND, Body, Fixed, System, shapes, simulate

from ..figure import Line
from ..form import Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require

CONE_SIDE, RIM_POINTS = 1.7, 48  # [m] of the cones that are drawn, and points of their rims
ROUNDS_MAX = 20  # [1] of the wobble; the samples resolve each one


def cone(axis, side):
    """Return rim and sides of the cone about an axis that goes through the direction ``side``, its apex at 0."""
    axis, side = (np.asarray(x) / np.linalg.norm(x) for x in (axis, side))
    middle = (side @ axis) * axis
    out = side - middle
    around = np.linspace(0.0, 2.0 * np.pi, RIM_POINTS + 1)[:, None]
    rim = CONE_SIDE * (middle + np.cos(around) * out + np.sin(around) * np.cross(axis, out))
    return [rim, np.vstack([(start, end, 0 * end) for start, end in zip(rim[:-1:2], rim[1::2], strict=True)])]


def mechanism(*, A=8.0, C=15.0, w3=5.0, wt=2.0) -> System:
    """Build a free body of moments (A, A, C) [kg m^2], spin w3 about its axis and a rate wt [rad/s] across it, with the
    cones that its angular velocity goes round: gold in the body, about its axis; crimson in space, about the angular
    momentum.
    """
    ratio = np.sqrt(max(12 * (2 * A - C), 1e-3 * C) / (6 * C))  # height over radius of the cylinder it looks like
    form = (shapes.Cylinder(1.0, ratio), shapes.Cylinder(0.05, ratio + 0.8))
    turning, momentum = (wt, 0.0, w3), (A * wt, 0.0, C * w3)
    own = [shapes.Lines(line, colour="gold") for line in cone((0.0, 0.0, 1.0), turning)]
    fixed = tuple(shapes.Lines(line, colour="crimson") for line in cone(momentum, turning))
    body = Body("body", 20.0, (A, A, C), omega=turning, shape=(*form, *own))
    space = Body("space", 1.0, (1, 1, 1), shape=fixed)
    return System([body, space], [Fixed(GROUND, space, at=(0, 0, 0), name="space cone")], gravity=(0, 0, 0))


def theory(*, A, C, w3, wt):
    """Return the body cone (C - A) w3/A, > 0 towards +z; space cone H/A about H; tan(half angle) = A wt/(C w3)."""
    require(wt != 0, "demo 'satellite_nutation': wt = 0: it does not wobble; give a rate across the axis")
    return {
        "body_cone_rate_rad_s": (C - A) / A * w3,
        "space_cone_rate_rad_s": np.hypot(A * wt, C * w3) / A,
        "cone_angle_deg": np.degrees(np.arctan2(abs(A * wt), C * w3)),
    }


def measure(build, terms, *, A, C, w3, wt) -> Measured:
    """Measure the phase of the transverse rate in the body, of the axis about the angular momentum, and their angle."""
    t = min(2.0, ROUNDS_MAX * 2 * np.pi * A / np.hypot(A * wt, C * w3))
    run = simulate(build(), t, rtol=1e-13, output=401, **terms)
    w, axis = run.omega_body("body"), run.rotation("body")[:, :, 2]
    L = run.rotation("body")[0] @ (run.system.part("body").inertia @ w[0])
    L = L / np.linalg.norm(L)
    side = np.cross(L, (0, 1, 0)) / np.linalg.norm(np.cross(L, (0, 1, 0)))
    phase = np.unwrap(np.arctan2(axis @ np.cross(L, side), axis @ side))
    body_phase = np.unwrap(np.arctan2(w[:, 1], w[:, 0]))
    cosine = np.clip(axis @ L, -1, 1)
    values = {
        "body_cone_rate_rad_s": (body_phase[-1] - body_phase[0]) / run.t[-1],
        "space_cone_rate_rad_s": (phase[-1] - phase[0]) / run.t[-1],
        "cone_angle_deg": np.degrees(np.arctan2(np.linalg.norm(np.cross(axis, L), axis=1), cosine)).mean(),
    }
    expected = wt * np.cos((C - A) / A * w3 * run.t)
    space, body = (np.degrees(angle - angle[0]) for angle in (phase, body_phase))
    known = [np.degrees(rate * run.t) for rate in (np.hypot(A * wt, C * w3) / A, (C - A) / A * w3)]
    curves = [
        Curve("rate across the axis, in the body [rad/s]", run.t, w[:, 0], (run.t, expected)),
        Curve("turn about the cone [deg]", run.t, space, (run.t, known[0]), name="axis about L, in space",
              more=[Line("w about the axis, in the body", body, theory=(run.t, known[1]))],
              title=f"in the body w goes round {'with' if C > A else 'against'} the spin"),
    ]  # fmt: skip
    return Measured(values, [run], curves)


demo = Demo(
    __name__,
    title="Two cones that roll on each other",
    question="Does a flat (frisbee) or a long (football) spinning body wobble faster than it spins?",
    beats=(
        Beat(0.0, "The plate spins. Its gold cone rolls on the red one, which stands in space."),
        Beat(0.6555, "Once round: the axis is back where it was."),
        Beat(1.257, "Only now it has turned once about its own axis: it wobbles nearly twice as fast."),
    ),
    why="Angular momentum stays where it is, angular velocity need not: the body's axis, its angular velocity and "
    "its angular momentum lie in one plane, and that plane turns. The axis runs around the angular momentum at "
    "H/A. A flat body, C = 2 A, wobbles twice as fast as it spins (Feynman's plate); a long one, C < A, more "
    "slowly.",
    equation="body cone: (C - A) w_3 / A; space cone: H / A; tan(half angle) = A w_t / (C w_3)",
    symbols={
        "w_3": Symbol("spin about its axis", "rad/s", curve=(0, 2), arrow="angular velocity"),
        "w_t": Symbol("spin across it", "rad/s", "wt"),
        "A": Symbol("moment across", "kg m^2", "A"),
        "C": Symbol("moment along the axis", "kg m^2", "C"),
        "H": Symbol(
            "angular momentum",
            "N m s",
            lambda A, C, w3, wt: ((C * w3) ** 2 + (A * wt) ** 2) ** 0.5,
            arrow="angular momentum",
        ),
    },
    source="Goldstein, Classical Mechanics, 5.6; Landau, Lifshitz, Mechanics, par. 33",
    quantities={
        "body_cone_rate_rad_s": Quantity("rate on the body cone, < 0 in a long body", "rad/s"),
        "space_cone_rate_rad_s": Quantity("rate on the space cone", "rad/s"),
        "cone_angle_deg": Quantity("half angle of the cone of the axis", "deg"),
    },
    ablation=Ablation(
        "gyroscopic",
        "the angular velocity stays fixed in the body, and there is no body cone",
        values=lambda: {"body_cone_rate_rad_s": 0.0},
    ),  # fmt: skip
    against=Against("C", 1.0, 15.9, "moment about the axis [kg m^2]"),
    show={
        "curves": [("omega_body", "body")],
        "shown": ["angular momentum", "angular velocity"],
        "traces": [],
        "hidden": ["joints", "joint names", "body names"],
        "speed": 0.2,
    },  # fmt: skip
    ranges={"A": (7.5, 8.5), "C": (12.0, 14.5)},
    sliders=(Control("w3", 1.0, 9.0, "rad/s", "spin"), Control("wt", 0.2, 3.0, "rad/s", "rate across")),
    attempt="spin it slower: it nods slower in proportion. Omit the gyroscopic term, and the cone is gone.",
)
