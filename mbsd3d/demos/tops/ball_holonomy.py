"""A ball rolled once around a circle without twisting comes back turned."""

import numpy as np

from mbsd3d import GROUND, Body, PositionDriver, RollingDisc, Sine, SpeedDriver, System, shapes, simulate

from ..form import Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol
from ..moments import share

T = 2.0  # s: one round; the turn does not depend on it


def mechanism(*, r=0.1, rho=0.25) -> System:
    """Build a ball of radius r [m] whose centre is led around a circle of radius rho [m], without spin about the
    vertical.
    """
    dots = [shapes.Sphere(0.12 * r, at=0.92 * r * np.array(d), colour="orangered") for d in ((1, 0, 0), (0, 0, 1))]
    ball = Body("ball", 1.0, (0.4 * r**2,) * 3, position=(rho, 0, r), shape=[shapes.Sphere(r), *dots])
    round_x, round_y = Sine(rho, 1 / T, np.pi / 2, -rho), Sine(rho, 1 / T)
    joints = [
        RollingDisc(GROUND, ball, axis=(0, 1, 0), radius=r, crown=r, name="contact"),
        PositionDriver(ball, at=(rho, 0, r), signal=(round_x, round_y, None), name="hand"),
        SpeedDriver(GROUND, ball, axis=(0, 0, 1), speed=0.0, name="no twist"),
    ]
    return System([ball], joints)


def theory(*, r, rho):
    """Return a turn by 2 pi sqrt(1 + (rho/r)^2), less whole turns, about (rho/r, 0, -1) in axes that go round with the
    hand.
    """
    slope = np.hypot(1, rho / r)
    return {"net_turn_cos": np.cos(2 * np.pi * slope), "axis_height": 1 / slope}


def measure(build, terms, *, r, rho) -> Measured:
    """Measure the turn between start and end of the round."""
    run = simulate(build(), T, rtol=1e-13, output=201, **terms)
    e = run.orientation("ball")
    cosine = 1 - 2 * np.sum(e[:, 1:] ** 2, axis=1)
    size = np.linalg.norm(e[-1, 1:])
    slope = np.hypot(1, rho / r)
    turn = 2 * np.pi * run.t / T  # R = Rz(turn) exp(turn (slope axis)): its trace by the product of two quaternions
    half, back = 0.5 * slope * turn, 0.5 * turn
    scalar = np.cos(half) * np.cos(back) + np.sin(half) * np.sin(back) / slope
    curve = Curve("turn from the start [deg]", run.t, np.degrees(np.arccos(np.clip(cosine, -1, 1))),
                  (run.t, np.degrees(np.arccos(np.clip(2 * scalar**2 - 1, -1, 1)))))  # fmt: skip
    height = abs(e[-1, 3]) / size if size else 1.0
    return Measured({"net_turn_cos": cosine[-1], "axis_height": height}, [run], [curve])


demo = Demo(
    __name__,
    title="Once around, and turned",
    question="Roll a ball once around a circle without twisting it: why does it come back turned?",
    beats=(
        Beat(0.0, "A ball rolls once round a circle, and nobody twists it."),
        Beat(share(0.5), "Halfway."),
        Beat(share(1.0), "Back at its place, and turned by 111 degrees."),
    ),
    why="Rolling turns a ball about horizontal axes only; it never twists about the vertical. But turns about "
    "different axes do not add up: one after the other they make a turn about a third axis, and around a closed "
    "path something is left over. It depends only on the path. So one can bring a ball into any position by "
    "rolling alone: two degrees of freedom of velocity reach five of place and turn.",
    equation="net turn = 2 pi sqrt(1 + (rho/r)^2) mod 2 pi about (rho/r, 0, -1)",
    symbols={
        "r": Symbol("ball", "m", "r"),
        "rho": Symbol("circle", "m", "rho"),
    },
    source="Montgomery, A Tour of Subriemannian Geometries; Jurdjevic (1993), The geometry of the plate-ball problem",
    quantities={
        "net_turn_cos": Quantity("cosine of the net turn"),
        "axis_height": Quantity("height of its axis"),
    },
    ablation=Ablation(
        "circle", "on a circle of no size it comes back as it was", {"rho": 1e-6}, values=lambda: {"net_turn_cos": 1.0}
    ),  # fmt: skip
    against=Against("rho", 0.01, 0.4, "radius of the circle [m]"),
    show={"curves": [("omega", "ball")], "traces": [("ball", (0.25, 0, 0.1))]},
    may_vanish=("rho",),
    sliders=(Control("rho", 0.1, 0.4, "m", "radius of the circle"),),
    attempt="lead it around a larger circle: it comes back turned by more.",
)
