"""Two quarter turns of a book, in both orders: the ends differ by a third of a revolution."""

import numpy as np

from mbsd3d import GROUND, Body, Joint, Pulse, SpeedDriver, Spherical, System, shapes, simulate

from ..form import Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol
from ..moments import share

EDGE_SECONDS, TURN_SECONDS = 0.2, 1.0  # s, of the rise and of each turn
BOOK_SHAPES = (shapes.Box((0.5, 0.08, 0.7)), shapes.Box((0.04, 0.085, 0.705), at=(-0.23, 0, 0), colour="orangered"))


def mechanism(*, a_deg=90.0, b_deg=90.0) -> System:
    """Build two books on ball joints: one turned about the world's x by a, then about y by b; the other y first, then
    x.
    """
    bodies: list[Body] = []
    joints: list[Joint] = []
    for k, name in enumerate(("x then y", "y then x")):
        place = (1.2 * k - 0.6, 0, 0)
        book = Body(name, 1.0, (0.04, 0.06, 0.02), position=place, shape=BOOK_SHAPES)
        turns = [np.radians(angle) / (TURN_SECONDS - EDGE_SECONDS) for angle in (a_deg, b_deg)]
        starts = (0.1, 1.2) if k == 0 else (1.2, 0.1)
        speeds: list[Pulse | float] = [
            *(Pulse(turn, start, EDGE_SECONDS, TURN_SECONDS) for turn, start in zip(turns, starts, strict=True)), 0.0
        ]  # fmt: skip
        joints += [Spherical(GROUND, book, at=place, name=f"centre {k}")]
        for axis, speed in zip(np.eye(3), speeds, strict=True):
            joints.append(SpeedDriver(GROUND, book, axis=axis, speed=speed))
        bodies.append(book)
    return System(bodies, joints, gravity=(0, 0, 0))


def theory(*, a_deg, b_deg):
    """Return the angle of the quaternions of both products, which differ by 2 sin(a/2) sin(b/2) along z: cos(angle/2) =
    1 - 2 sin^2 sin^2.
    """
    s = np.sin(np.radians(a_deg) / 2) * np.sin(np.radians(b_deg) / 2)
    return {"angle_between_deg": 4 * np.degrees(np.arcsin(abs(s)))}


def measure(build, terms) -> Measured:
    """Measure the angle of the rotation from one book to the other."""
    run = simulate(build(), 2.4, rtol=1e-12, output=201, **terms)
    e, f = run.orientation("x then y"), run.orientation("y then x")
    # both start alike and their quaternions go on smoothly, so that angles above 180 degrees are told from those below
    gap, sum_of_both = np.linalg.norm(e - f, axis=1), np.linalg.norm(e + f, axis=1)
    angle = 4 * np.degrees(np.arctan2(gap, sum_of_both))
    end = build.theory["angle_between_deg"]
    curve = Curve("angle between the books [deg]", run.t, angle, ([2.4], [end]))
    return Measured({"angle_between_deg": angle[-1]}, [run], [curve])


demo = Demo(
    __name__,
    title="Turning does not commute",
    question="Does the order of two quarter turns matter?",
    beats=(
        Beat(0.0, "The same two quarter turns, in two orders."),
        Beat(share(0.5), "Now the other one."),
        Beat(share(1.0), "The books end 120 degrees apart."),
    ),
    why="Steps along x and y can be taken in any order, turns about x and y cannot: the first turn carries the "
    "book's own axes away before the second one comes. Two quarter turns in the two orders end a third of a "
    "revolution apart. That is why an orientation has no three coordinates that simply add up, and why this "
    "program uses quaternions.",
    equation="cos(angle/2) = 1 - 2 sin^2(a/2) sin^2(b/2); 90 and 90 degrees: 120 degrees",
    symbols={
        "a": Symbol("turn about x", "deg", "a_deg"),
        "b": Symbol("turn about y", "deg", "b_deg"),
    },
    source="Altmann, Rotations, Quaternions and Double Groups; Goldstein, Classical Mechanics, 4.8",
    quantities={"angle_between_deg": Quantity("angle between the two books", "deg", relative=1e-8, absolute=1e-9)},
    ablation=Ablation("second-axis", "a single turn has no order", {"b_deg": 0.0}),
    against=Against("b_deg", 0.0, 180.0, "second turn [deg]"),
    show={"curves": [("omega", "x then y"), ("omega", "y then x")], "traces": []},
    sliders=(
        Control("a_deg", 10.0, 150.0, "deg", "turn about x"),
        Control("b_deg", 10.0, 150.0, "deg", "turn about y"),
    ),
    attempt="make both turns small: the order hardly matters. Make them half turns: it is opposite.",
)
