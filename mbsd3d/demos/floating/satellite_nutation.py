"""A spinning body thrown with a little tilt wobbles: two cones that roll on each other."""

import numpy as np

from mbsd3d import Body, System, shapes, simulate

from ..figure import Line
from ..form import Ablation, Against, Curve, Demo, Measured, Quantity, require

ROUNDS_MAX = 20  # [1] of the wobble; the samples resolve each one


def mechanism(*, A=8.0, C=10.0, w3=5.0, wt=1.0) -> System:
    """Build a free body of moments (A, A, C) [kg m^2], spin w3 about its axis and a small rate wt [rad/s] across it."""
    ratio = np.sqrt(max(12 * (2 * A - C), 1e-3 * C) / (6 * C))  # height over radius of the cylinder it looks like
    form = (shapes.Cylinder(1.0, ratio), shapes.Cylinder(0.05, ratio + 0.8))
    return System([Body("body", 20.0, (A, A, C), omega=(wt, 0, w3), shape=form)], gravity=(0, 0, 0))


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
    L = run.momentum().angular[0]
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
    why="Angular momentum stays where it is, angular velocity need not: the body's axis, its angular velocity and "
    "its angular momentum lie in one plane, and that plane turns. The axis runs around the angular momentum at "
    "H/A. A flat body, C = 2 A, wobbles twice as fast as it spins (Feynman's plate); a long one, C < A, more "
    "slowly.",
    equation="body cone: (C - A) w_3 / A; space cone: H / A; tan(half angle) = A w_t / (C w_3)",
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
        "traces": [("body", (0, 0, 1.2))],
    },  # fmt: skip
)
