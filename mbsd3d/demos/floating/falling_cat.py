"""Two halves of a bent cat roll about their own axes, and the whole turns the other way."""

import numpy as np

from mbsd3d import GROUND, AngleDriver, Body, Fixed, Polynomial, Revolute, System, rotation, shapes, simulate
from mbsd3d.rotations import multiply

from ..form import Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol
from ..moments import share

FALL_SECONDS = 0.6  # [s] for a roll by 360 degrees; the turn depends neither on it nor on the fall
FALL_HEIGHT = 0.5 * 9.81 * FALL_SECONDS**2  # [m]
PAWS_HEIGHT = 0.39  # [m] of the waist above the floor, feet down
FUR_COLOUR = "peru"


def mechanism(*, A=0.12, C=0.03, bend_deg=60.0) -> System:
    """Build halves (C, A, A) [kg m^2] along their own axes, bent by an angle at a massless waist about which both
    roll, dropped upside down."""
    g, bodies, joints, upside_down = np.radians(bend_deg) / 2, [], [], rotation("x", np.pi)
    waist = Body("waist", 0.0, (0, 0, 0), orientation=upside_down, shape=shapes.Sphere(0.09, colour=FUR_COLOUR))
    floor = Body("floor", 0.0, (0, 0, 0), position=(0, 0, -FALL_HEIGHT - PAWS_HEIGHT),
                 shape=shapes.Box((1.4, 1.0, 0.02), colour="lightgrey"))  # fmt: skip
    for name, side in (("fore", 1), ("hind", -1)):
        along = np.array([side * np.cos(g), 0, np.sin(g)])  # away from the waist
        axis = side * along  # both roll the same way about the cat's length
        turned = multiply(upside_down, rotation("y", side * g))
        legs = [shapes.Cylinder(0.03, 0.2, at=(side * 0.28, y, -0.16)) for y in (-0.08, 0.08)]
        form: list[shapes.Shape] = [shapes.Capsule(0.11, 0.3, "x", at=(side * 0.2, 0, 0), colour=FUR_COLOUR), *legs]
        form += [shapes.Sphere(0.1, at=(0.46, 0, 0.06), colour=FUR_COLOUR)] if side > 0 else []
        half = Body(name, 2.0, (C, A, A), orientation=turned, shape=form)
        hinge = Revolute(waist, half, at=(0, 0, 0), axis=axis, name=f"{name} roll")
        roll = AngleDriver(
            hinge, Polynomial((0, 0, -6 * np.pi / FALL_SECONDS**2, 4 * np.pi / FALL_SECONDS**3)), name=f"{name} muscle"
        )
        bodies.append(half)
        joints += [hinge, roll]
    return System([waist, *bodies, floor], [*joints, Fixed(GROUND, floor, at=floor.position)])


def theory(*, A, C, bend_deg):
    """Return the turn per roll of 360 degrees at angular momentum zero: 360 (C cos g/(C cos^2 g + A sin^2 g) - 1), g =
    bend/2.
    """
    g = np.radians(bend_deg) / 2
    return {"net_turn_deg": 360 * (C * np.cos(g) / (C * np.cos(g) ** 2 + A * np.sin(g) ** 2) - 1)}


def measure(build, terms) -> Measured:
    """Measure the turn of the waist about the length of the cat, less the roll of the halves."""
    run = simulate(build(), FALL_SECONDS, rtol=1e-12, output=201, **terms)
    R = run.rotation("waist")
    turn = np.degrees(np.unwrap(np.arctan2(R[:, 2, 1], R[:, 1, 1])))
    rolled = np.degrees(run.angle("fore roll"))
    turn -= turn[0]
    known = -build.theory["net_turn_deg"] / 360 * rolled
    curve = Curve("turn of the cat beyond its roll [deg]", run.t, turn + rolled, (run.t, known))
    return Measured({"net_turn_deg": turn[-1] + rolled[-1]}, [run], [curve])


demo = Demo(
    __name__,
    title="The cat that lands on its feet",
    question="How does a cat land on its feet without anything to push on?",
    beats=(
        Beat(0.0, "Dropped with its legs up, with nothing to push on."),
        Beat(share(0.5), "Bent at the waist, it rolls about its own back."),
        Beat(share(1.0), "Legs down. Its angular momentum was nothing all the way."),
    ),
    why="The cat bends and rolls both halves of its body about their own axes, like a bent hose turned in a hose. "
    "Rolling has angular momentum; so that the sum stays zero, the bent cat as a whole turns the other way. "
    "After one roll its shape is what it was, and it has turned by half a revolution. Straight, it would turn "
    "back exactly what it rolled.",
    equation="turn = 360 deg (C cos g / (C cos^2 g + A sin^2 g) - 1); g = bend / 2",
    symbols={
        "g": Symbol("half of the bend at the waist", "deg", lambda bend_deg: bend_deg / 2),
        "C": Symbol("moment of a half along its back", "kg m^2", "C"),
        "A": Symbol("moment of a half across it", "kg m^2", "A"),
    },
    source="Kane, Scher, Int. J. Solids Struct. 5 (1969) 663; closed form of equal halves by angular momentum zero",
    quantities={"net_turn_deg": Quantity("turn of the cat after one roll", "deg")},
    ablation=Ablation("bend", "a straight cat does not turn", {"bend_deg": 0.0}),
    against=Against("bend_deg", 0.0, 120.0, "bend at the waist [deg]"),
    show={"curves": [("angle", "fore roll"), "momentum"], "shown": [], "traces": [], "speed": 0.25, "view": (-70, 10)},
    ranges={"A": (0.09, 0.15), "C": (0.02, 0.05)},
    sliders=(Control("bend_deg", 5.0, 110.0, "deg", "half bend"),),
    attempt="bend it more: it turns by more in the same fall. The ghost is stiff, and comes back as it was.",
)
