"""Four hinges that are neither parallel nor meet, and move all the same."""

import numpy as np

from mbsd3d import System

from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share
from .closed_loop import Loop, run_loop


def mechanism(*, a=0.2, alpha_deg=30.0, beta_deg=70.0, theta0_deg=60.0, turn_deg=100.0, misfit=0.0) -> System:
    """Build sides a, b, a, b with twists alpha, beta and a/sin(alpha) = b/sin(beta); misfit: one side longer by this
    share.
    """
    al, be = np.radians([alpha_deg, beta_deg])
    b, t1 = long_side(a, al, be), np.radians(theta0_deg)
    t2 = follower(t1, al, be)
    loop = Loop((a, b, a, b), (al, be, al, be), (0, 0, 0, 0))
    return loop.system(loop.close(t1, [t2, -t1, -t2]), np.radians(turn_deg), misfit)


def long_side(a, al, be):
    """Return b = a sin(beta)/sin(alpha) [m]."""
    return a * np.sin(be) / np.sin(al)


def follower(t1, al, be):
    """Return t2 of tan(t1/2) tan(t2/2) = sin((al + be)/2)/sin((be - al)/2), continuous over whole turns [rad]."""
    k = np.sin((al + be) / 2) / np.sin((be - al) / 2)
    return 2 * np.arctan2(k * np.cos(t1 / 2), np.sin(t1 / 2))


def theory(*, a, alpha_deg, beta_deg, theta0_deg, misfit, turn_deg):
    """Return the next hinge by the equation of Bennett, the other side by his condition."""
    require(
        misfit == 0,
        f"demo 'bennett': misfit = {misfit:g} locks the loop; theory is that of the one that closes, with 0",
    )
    require(a > 0, f"demo 'bennett': a = {a:g}; give a length > 0")
    require(0 < alpha_deg < 180 and 0 < beta_deg < 180 and alpha_deg != beta_deg, f"demo 'bennett': twists "
            f"{alpha_deg:g} "
            f"and {beta_deg:g} degrees; give two different ones between 0 and 180")  # fmt: skip
    al, be, t0, turn = np.radians([alpha_deg, beta_deg, theta0_deg, turn_deg])
    path = np.unwrap(follower(t0 + turn * np.linspace(0, 1, 201), al, be))
    return {"follower_turn_deg": np.degrees(path[-1] - path[0]), "long_side_m": long_side(a, al, be)}


def measure(build, terms, *, alpha_deg, beta_deg, theta0_deg) -> Measured:
    """Measure the rotation of the next hinge, and then the distance of the hinges at the ends of the other side."""
    run, turns = run_loop(build(), **terms)
    points = [run.reaction(f"hinge {k}").point[-1] for k in (2, 3)]
    al, be, t0 = np.radians([alpha_deg, beta_deg, theta0_deg])
    known = np.degrees(np.unwrap(follower(t0 + np.radians(turns[:, 0]), al, be)))
    curve = Curve("next hinge [deg]", turns[:, 0], turns[:, 1], (turns[:, 0], known - known[0]), "driven hinge [deg]")
    values = {"follower_turn_deg": turns[-1, 1], "long_side_m": np.linalg.norm(points[1] - points[0])}
    return Measured(values, [run], [curve])


demo = Demo(
    __name__,
    title="Bennett's linkage",
    question="How can four hinges that are neither parallel nor meet move at all?",
    beats=(
        Beat(0.0, "Four hinges: none parallel to another, and none meets another."),
        Beat(share(0.5), "It should be stuck, and it turns."),
        Beat(share(1.0), "100 degrees at one hinge are 108 at the next."),
    ),
    why="A loop of hinges needs seven to move in space; by counting, four are locked. Hinges that are all "
    "parallel (a plane four-bar) or all meet in a point (a spherical one) move because they repeat each other's "
    "conditions. Bennett found the only other case: opposite sides alike, lengths in proportion to the sines of "
    "their twists. One side a hair longer, and it is a rigid frame.",
    equation="a / sin(alpha) = b / sin(beta); tan(t_1/2) tan(t_2/2) = sin((alpha + beta)/2) / sin((beta - alpha)/2)",
    symbols={
        "a": Symbol("one side", "m", "a"),
        "b": Symbol("the other one", "m"),
        "alpha": Symbol("twist of one side", "deg", "alpha_deg"),
        "beta": Symbol("twist of the other one", "deg", "beta_deg"),
        "t_1": Symbol("turn of the first hinge", "rad", curve=(0, 0)),
        "t_2": Symbol("turn of the next one", "rad", curve=(1, 0)),
    },
    source="Bennett, Engineering 76 (1903) 777; Hunt, Kinematic Geometry of Mechanisms",
    quantities={
        "follower_turn_deg": Quantity("turn of the next hinge", "deg"),
        "long_side_m": Quantity("length of the other side", "m"),
    },
    ablation=Ablation(
        "proportion",
        "one side is 1 % longer, and the loop is locked",
        {"misfit": 0.01},
        values=lambda: {"follower_turn_deg": 0.0},
    ),  # fmt: skip
    show={
        "curves": [("angle", "hinge 1"), ("angle", "hinge 2")],
        "traces": [],
        "hidden": ["ground grid"],
        "speed": 0.3,
    },
    ranges={"alpha_deg": (20.0, 40.0), "misfit": None},
    sliders=(Control("alpha_deg", 20.0, 65.0, "deg", "twist of the short sides"),),
    attempt="change the twist: the long sides follow it, and the ring still moves.",
)
