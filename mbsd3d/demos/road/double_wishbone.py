"""A wheel on two arms and a tie rod steers and leans by itself as it goes up and down."""

import numpy as np
from scipy.optimize import brentq

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Distance,
    Kinematic,
    Polynomial,
    Revolute,
    Spherical,
    System,
    shapes,
    simulate,
)

from ...base.errors import InputError
from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

T = 1.0  # s, of the travel
POINTS = {
    "L": (0.0, 0.75, -0.1), "L1": (0.15, 0.35, -0.08), "L2": (-0.2, 0.35, -0.06),
    "U": (-0.02, 0.7, 0.15), "U1": (0.12, 0.42, 0.14), "U2": (-0.18, 0.42, 0.12),
    "T": (-0.12, 0.72, -0.05), "K": (-0.11, 0.36, -0.04),
}  # fmt: skip


def mechanism(*, points=POINTS, arm_deg=8.0) -> System:
    """Build ball joints L, U, T of the upright, inner axes L1-L2 and U1-U2, rack end K [m]; the lower arm turned by an
    angle.
    """
    p = {name: np.array(at) for name, at in points.items()}
    lower, upper = (arm(name, p[f"{k}1"], p[f"{k}2"], p[k]) for name, k in (("lower arm", "L"), ("upper arm", "U")))
    middle = 0.5 * (p["L"] + p["U"])
    stem, steer = p["U"] - p["L"], p["T"] - middle
    wheel = [rod(p["L"] - middle, p["U"] - middle), rod(np.zeros(3), steer),
             shapes.Torus(0.26, 0.07, "y", at=(0, 0.08, 0)), shapes.Disc(0.2, 0.06, "y", at=(0, 0.08, 0))]  # fmt: skip
    upright = Body("wheel", 20.0, (1, 1, 1), position=middle, shape=wheel)
    require(
        np.linalg.norm(np.cross(stem, p["T"] - p["L"])) > 1e-6, "demo 'double_wishbone': L, U and T lie on one line"
    )
    hinge = Revolute(GROUND, lower, at=p["L1"], axis=p["L2"] - p["L1"], name="lower axis")
    travel = np.radians(arm_deg)
    joints = [
        hinge,
        AngleDriver(hinge, Polynomial((0, 0, 3 * travel / T**2, -2 * travel / T**3)), name="road"),
        Revolute(GROUND, upper, at=p["U1"], axis=p["U2"] - p["U1"], name="upper axis"),
        Spherical(lower, upright, at=p["L"], name="lower ball"),
        Spherical(upper, upright, at=p["U"], name="upper ball"),
        Distance(GROUND, upright, at_a=p["K"], at_b=p["T"], name="tie rod"),
    ]
    return System([lower, upper, upright], joints, gravity=(0, 0, 0))


def arm(name, one, two, ball):
    """Return a wishbone."""
    middle = (one + two + ball) / 3
    return Body(
        name, 3.0, (0.1, 0.1, 0.1), position=middle, shape=[rod(end - middle, ball - middle) for end in (one, two)]
    )


def rod(start, end):
    """Draw a bar between two points."""
    return shapes.Cylinder(0.012, np.linalg.norm(end - start), tuple(end - start), at=0.5 * (start + end))


def turned(point, start, end, angle):
    """Return a point rotated about the axis from start to end [m]."""
    axis = (end - start) / np.linalg.norm(end - start)
    d = point - start
    return start + d * np.cos(angle) + np.cross(axis, d) * np.sin(angle) + axis * (axis @ d) * (1 - np.cos(angle))


def near_root(function, guess):
    """Return the root nearest to a guess, by steps to both sides."""
    for step in np.linspace(0.002, 1.0, 500):
        for low, high in ((guess + step - 0.002, guess + step), (guess - step, guess - step + 0.002)):
            if function(low) * function(high) <= 0:
                return brentq(function, low, high, xtol=1e-15)
    raise InputError("demo 'double_wishbone': the arms do not reach that far; give a smaller arm_deg")


def upright_axes(p, angle, guess=(0.0, 0.0)):
    """Return the axes of the wheel (3, 3), and the angles found: upper arm by |U L|, then T on its circle about L-U by
    |T K|.
    """
    L = turned(p["L"], p["L1"], p["L2"], angle)

    def miss(x):
        return np.sum((turned(p["U"], p["U1"], p["U2"], x) - L) ** 2) - np.sum((p["U"] - p["L"]) ** 2)

    upper = near_root(miss, guess[0])
    U = turned(p["U"], p["U1"], p["U2"], upper)
    before, after = (U0 - L0 for U0, L0 in ((p["U"], p["L"]), (U, L)))
    size = before @ before
    bend, cosine = np.cross(before, after) / size, before @ after / size
    swung = cosine * np.eye(3) + cross_matrix(bend) + np.outer(bend, bend) / (1 + cosine)  # takes the one to the other

    def axes(x):
        k = cross_matrix(after / np.sqrt(size))
        return (np.eye(3) + np.sin(x) * k + (1 - np.cos(x)) * k @ k) @ swung

    def length(x):
        return np.sum((L + axes(x) @ (p["T"] - p["L"]) - p["K"]) ** 2) - np.sum((p["T"] - p["K"]) ** 2)

    twist = near_root(length, guess[1])
    return axes(twist), (upper, twist)


def cross_matrix(a):
    """Return the matrix [a]x of the cross product."""
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def angles(axle):
    """Return toe and camber [deg] of a wheel whose axle was along y."""
    return np.degrees(np.arctan2(axle[0], axle[1])), np.degrees(np.arcsin(axle[2]))


def theory(*, points, arm_deg):
    """Solve for intersections of spheres, one after the other; return toe and camber from the axle."""
    p, guess = {name: np.array(at) for name, at in points.items()}, (0.0, 0.0)
    for angle in np.radians(arm_deg) * np.linspace(0, 1, 11)[1:]:
        R, guess = upright_axes(p, angle, guess)
    toe, camber = angles(R[:, 1]) if arm_deg else (0.0, 0.0)
    return {"toe_deg": toe, "camber_deg": camber}


def measure(build, terms, *, points, arm_deg) -> Measured:
    """Measure toe and camber at the end of the travel."""
    run = simulate(build(), T, method=Kinematic(), output=81, **terms)
    toe, camber = np.array([angles(R[:, 1]) for R in run.rotation("wheel")]).T
    arm_angle = np.degrees(run.angle("lower axis"))
    share = np.linspace(0, 1, 11)
    known = np.array([list(theory(points=points, arm_deg=arm_deg * x).values()) for x in share])
    curves = [
        Curve("toe [deg]", arm_angle, toe, (arm_deg * share, known[:, 0]), "lower arm [deg]"),
        Curve("camber [deg]", arm_angle, camber, (arm_deg * share, known[:, 1]), "lower arm [deg]"),
    ]
    return Measured({"toe_deg": toe[-1], "camber_deg": camber[-1]}, [run], curves)


demo = Demo(
    __name__,
    title="The wheel that steers on a bump",
    question="Why does a wheel steer by itself on a bump?",
    beats=(
        Beat(0.0, "Straight ahead, on level road."),
        Beat(share(1.0), "Up on the bump it has turned and leaned, and nobody has steered."),
    ),
    why="Three links guide the wheel, and each end of them moves on an arc of its own, in planes that are not "
    "parallel. As the wheel goes up and down, the tie rod's arc differs from those of the arms: it pushes the "
    "wheel's rear edge out or in, and the wheel steers. The arms' different lengths tip it as well. Designers "
    "place the rack's ends so that this bump steer vanishes, or helps.",
    equation="|U - L|, |T - L|, |T - U|, |T - K| stay; toe and camber from the axle",
    symbols={
        "U": Symbol("upper ball joint"),
        "L": Symbol("lower ball joint"),
        "T": Symbol("tie rod, outer end"),
        "K": Symbol("tie rod, inner end"),
    },
    source="Dixon, Suspension Geometry and Computation; Milliken, Milliken, Race Car Vehicle Dynamics, ch. 17",
    quantities={"toe_deg": Quantity("toe", "deg"), "camber_deg": Quantity("camber", "deg")},
    ablation=Ablation("travel", "on a flat road it neither steers nor leans", {"arm_deg": 0.0}),
    show={"curves": [("omega", "wheel"), ("angle", "lower axis")], "traces": []},
    ranges={"arm_deg": (-9.0, 9.0), "points": None},
    sliders=(Control("arm_deg", -9.0, 20.0, "deg", "travel of the lower arm"),),
    attempt="let the wheel rise farther: the toe grows faster than the travel.",
)
