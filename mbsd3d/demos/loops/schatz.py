"""A bottle between two shafts that turn against each other and unevenly: shaken in all directions by one motor."""

import numpy as np

from mbsd3d import System, shapes

from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share
from .closed_loop import Loop, run_loop

START_ANGLES = (0.5, 2.4341, -1.386, -1.7267, -0.8778, 2.4004)


def loop_of(a, R):
    """Return the loop of Schatz: sides (0, 1, 1, 1, 0, sqrt 3) a, right angles but for the parallel shafts, offsets R
    and -R.
    """
    return Loop((0, a, a, a, 0, np.sqrt(3) * a), np.radians([90, 90, 90, 90, 90, 0]), (R, 0, 0, 0, 0, -R))


def bottle(closed, a):
    """Draw a bottle along the side of the middle link of a closed loop."""
    start, end = (frame[:3, 3] for frame in closed[2:4])
    way = tuple((end - start) / a)
    neck = 0.42 * a * np.array(way)
    glass = shapes.Cylinder(0.24 * a, 0.6 * a, way, at=-0.08 * a * np.array(way), colour="teal")
    return (
        glass,
        shapes.Cylinder(0.1 * a, 0.28 * a, way, at=0.8 * neck, colour="teal"),
        shapes.Cylinder(0.11 * a, 0.08 * a, way, at=1.2 * neck, colour="orange"),
    )


def mechanism(*, a=0.2, R=0.3, theta=START_ANGLES, turn_deg=360.0, misfit=0.0) -> System:
    """Build the linkage of Schatz, closed near the angles theta [rad]; misfit: one side longer by this share."""
    loop = loop_of(a, R)
    closed = loop.close(theta[0], theta[1:])
    held = bottle(loop.frames(closed), a)
    return loop.system(closed, np.radians(turn_deg), misfit, thick=0.06, carried=held)


def theory(*, a, R, theta, misfit, turn_deg):
    """Solve the closure of the Denavit-Hartenberg matrices, followed from the start."""
    require(
        misfit == 0, f"demo 'schatz': misfit = {misfit:g} locks the loop; theory is that of the one that closes, with 0"
    )
    loop = loop_of(a, R)
    path = np.degrees(loop.follow(loop.close(theta[0], theta[1:]), np.radians(turn_deg)))
    turns = path[-1] - path[0]
    return {"output_turn_deg": turns[5], "middle_turn_deg": turns[2]}


def measure(build, terms, *, a, R, theta, turn_deg) -> Measured:
    """Measure the turns of the other shaft and of a middle hinge."""
    run, turns = run_loop(build(), **terms)
    loop = loop_of(a, R)
    path = np.degrees(loop.follow(loop.close(theta[0], theta[1:]), np.radians(turn_deg), 24))
    known = path - path[0]
    curves = [
        Curve("other shaft [deg]", turns[:, 0], turns[:, 5], (known[:, 0], known[:, 5]), "driven shaft [deg]"),
        Curve("middle hinge [deg]", turns[:, 0], turns[:, 2], (known[:, 0], known[:, 2]), "driven shaft [deg]"),
    ]
    return Measured({"output_turn_deg": turns[-1, 5], "middle_turn_deg": turns[-1, 2]}, [run], curves)


demo = Demo(
    __name__,
    title="The Turbula",
    question="How does a Turbula shake a bottle with one motor and no gear?",
    beats=(
        Beat(0.0, "One shaft is driven."),
        Beat(share(0.5), "The bottle is carried round, tipped and rolled."),
        Beat(share(1.0), "The other shaft has come round as well, unevenly."),
    ),
    why="Schatz turned a cube inside out and kept six of its hinges: a ring that should be rigid and moves, because "
    "its sides are those of the cube. Two of the hinges are parallel shafts in the frame; the bottle sits in the "
    "middle and is carried round, tipped and turned. The shafts turn against each other and unevenly, so that a "
    "real machine drives one of them only.",
    equation="product of the six link matrices = 1; a = (0, 1, 1, 1, 0, sqrt(3)); twists: (90, 90, 90, 90, 90, 0) deg",
    symbols={
        "a": Symbol("sides; the longest but one", "m", "a"),
    },
    source="Schatz, Rhythmusforschung und Technik (1975); Phillips, Freedom in Machinery II",
    quantities={
        "output_turn_deg": Quantity("turn of the other shaft", "deg"),
        "middle_turn_deg": Quantity("turn of a middle hinge", "deg"),
    },
    ablation=Ablation(
        "proportion",
        "one side is 1 % longer, and the loop is locked",
        {"misfit": 0.01},
        values=lambda: {"output_turn_deg": 0.0, "middle_turn_deg": 0.0},
    ),  # fmt: skip
    show={
        "curves": [("angle", "hinge 1"), ("angle", "hinge 6")],
        "traces": [],
        "hidden": ["ground grid"],
        "speed": 0.3,
    },  # fmt: skip
    ranges={"theta": None, "misfit": None},
    sliders=(Control("turn_deg", 60.0, 720.0, "deg", "turn of the crank"),),
    theory_moves=False,
    attempt="turn it farther: half a turn gives half a turn at the other end, and what lies between is uneven.",
)
