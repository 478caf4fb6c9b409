"""Crank, rod and piston: the force on the block, to which the offset of the crank's centre of mass adds a tenth."""

from functools import partial

import numpy as np
from matplotlib.figure import Figure

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Kinematic,
    Prismatic,
    Ramp,
    Revolute,
    Solution,
    Spherical,
    System,
    Universal,
    simulate,
)
from mbsd3d.base.style import COLOURS, LIGHT
from mbsd3d.mechanism import shapes

from ..base import Exhibit, Outcome, Row, Show
from ..drawing import every, legend_below, new_figure, spectrum_bars, theory_dots

RATE = 2 * np.pi * 10 / 60  # rad/s: 10 rpm
RADIUS, ROD, OFFSET = 1.0, 2.0, 0.5  # crank radius, rod length, centre of mass of the crank from its axis [m]
AHEAD = 0.1  # distance of the cylinder's plane from the bearing, along the crank axis [m]
CRANK_MASS, ROD_MASS, PISTON_MASS = 2.0, 4.0, 5.0  # kg; the rod's centre of mass at mid length
ACROSS = RATE**2 * (CRANK_MASS * OFFSET + 0.5 * ROD_MASS * RADIUS)  # amplitude at right angles to the bore [N]
ORDERS = (1, 2, 4, 6)
SAMPLES = 256  # of one turn
CRANK = (
    shapes.Cylinder(0.1, 0.6, "y", at=(0, -0.32, 0)),
    shapes.Box((0.24, 0.08, RADIUS + 0.3), at=(0, -0.02, 0.5 * RADIUS)),
    shapes.Cylinder(0.07, 0.22, "y", at=(0, AHEAD, RADIUS)),
)
CONNECTION = (
    shapes.Box((0.1, 0.07, ROD - 0.3)),
    shapes.Torus(0.13, 0.05, "y", at=(0, 0, -0.5 * ROD)),
    shapes.Torus(0.13, 0.05, "y", at=(0, 0, 0.5 * ROD)),
)
PISTON = shapes.Cylinder(0.4, 0.6, "z", at=(0, 0, 0.12))


def harmonics(*, centripetal: bool = True) -> np.ndarray:
    """Amplitudes of the force on the block along the bore at 1, 2, 4, 6 times crank speed, signed cosines [N].

    1x: w^2 (mc rc + mr R + mp R); 2k: w^2 (mp + mr / 2) L (2k)^2 a_2k with sqrt(1 - (R/L)^2 sin^2 q) = a_0 +
    sum a_2k cos 2kq, the coefficients by a sum over equal angles, which is exact to rounding. Without m w x (w x s)
    the crank's share mc rc is missing.
    """
    angle = 2 * np.pi * np.arange(64) / 64
    lengths = np.sqrt(1 - (RADIUS / ROD * np.sin(angle)) ** 2)
    rod = 2 * np.fft.rfft(lengths).real / 64 * np.arange(33) ** 2
    first = (CRANK_MASS * OFFSET if centripetal else 0.0) + (ROD_MASS + PISTON_MASS) * RADIUS
    return RATE**2 * np.array([first, *((PISTON_MASS + ROD_MASS / 2) * ROD * rod[list(ORDERS[1:])])])


def engine() -> System:
    """One cylinder, its bore along z, the crank axis along y; piston up at the start, no gravity.

    The reference point of the crank lies on its axis. Spherical crankpin, universal wristpin: no row is redundant.
    """
    pin, wrist = np.array([0.0, AHEAD, RADIUS]), np.array([0.0, AHEAD, RADIUS + ROD])
    crank = Body("crank", CRANK_MASS, (0.3, 0.4, 0.5), com=(0, AHEAD, OFFSET), shape=CRANK)
    rod = Body("rod", ROD_MASS, (1 / 3, 1 / 3, 0.01), position=0.5 * (pin + wrist), shape=CONNECTION)
    piston = Body("piston", PISTON_MASS, (1.0, 1.0, 1.0), position=wrist, shape=PISTON)
    bearing = Revolute(GROUND, crank, at=(0, 0, 0), axis=(0, 1, 0), name="bearing")
    joints = [
        bearing,
        Spherical(crank, rod, at=pin, name="crankpin"),
        Universal(piston, rod, at=wrist, axis_a=(0, 1, 0), axis_b=(1, 0, 0), name="wristpin"),
        Prismatic(GROUND, piston, at=wrist, axis=(0, 0, 1), name="bore"),
        AngleDriver(bearing, Ramp(RATE), name="motor"),
    ]
    return System([crank, rod, piston], joints, gravity=(0, 0, 0))


def one_turn(centripetal: bool = True) -> Solution:
    """One turn of the crank, by kinematics."""
    return simulate(engine(), 2 * np.pi / RATE, method=Kinematic(), output=SAMPLES + 1, centripetal=centripetal)


def block_load(solution: Solution) -> tuple[np.ndarray, np.ndarray]:
    """(samples, 3) force on the block [N] and moment about the bearing [N m]: what bearing and bore hand on to it."""
    bearing, bore = solution.reaction("bearing"), solution.reaction("bore")
    arm = bore.point - bearing.point
    return -(bearing.force + bore.force), -(bearing.moment + bore.moment + np.cross(arm, bore.force))


def amplitudes(values: np.ndarray) -> np.ndarray:
    """Amplitudes at ORDERS of one turn of samples, the last one a repetition of the first."""
    return 2 * np.abs(np.fft.rfft(values[:-1]))[list(ORDERS)] / (values.size - 1)


def run(*, centripetal: bool = True) -> Outcome:
    """One turn of the crank."""
    true, without = one_turn(centripetal), one_turn(centripetal=False)
    force, moment = block_load(true)
    theory = np.abs(harmonics())
    rows = [
        Row(f"block force along the bore, {order}x", value, expected, 1e-9, "N")
        for order, value, expected in zip(ORDERS, amplitudes(force[:, 2]), theory, strict=True)
    ]
    rows.append(Row("block force across the bore, 1x", amplitudes(force[:, 0])[0], ACROSS, 1e-9, "N"))
    rocking = amplitudes(moment[:, 0])
    rows.append(Row("rocking moment across the bore, 1x", rocking[0], AHEAD * theory[0], 1e-9, "N m"))
    missing = amplitudes(block_load(without)[0][:, 2])[0]
    rows.append(Row("the same force without m w x (w x s), 1x", missing, harmonics(centripetal=False)[0], 1e-9, "N"))
    solutions = {"crank": true, "crank_without_centripetal": without}
    options = {"curves": [("slide", "bore"), ("reaction", "bearing", "bore")], "shown": ["reaction force"]}
    return Outcome(tuple(rows), partial(draw, true, without), solutions, views={"crank": Show(true, options)})


def shaking(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Theory of the force on the block along and across the bore [N]; the harmonics left out make 1e-3 N."""
    return np.cos(np.multiply.outer(angle, ORDERS)) @ harmonics(), ACROSS * np.sin(angle)


def draw(true: Solution, without: Solution) -> Figure:
    """Force along the bore, its harmonics, and the moment the block feels about axes in the mechanism's plane."""
    titles = ("force on the block along the bore", "its harmonics", "moment on the block about the bearing")
    figure, (along, bars, rocking) = new_figure("Crank with an offset centre of mass, 10 rpm", titles)
    names = ("all terms", "without m w × (w × s)")
    loads = [block_load(solution) for solution in (true, without)]
    angle, dots = RATE * true.t, every(true.t.size, 25)
    for (force, moment), name, tint, line in zip(loads, names, COLOURS, ("-", "--"), strict=False):
        along.plot(np.degrees(angle), force[:, 2], line, color=tint, label=name)
        rocking.plot(moment[:, 2], moment[:, 0], line, color=tint, label=name)
    force_along, force_across = shaking(angle[dots])
    theory_dots(along, np.degrees(angle[dots]), force_along)
    theory_dots(rocking, -AHEAD * force_across, AHEAD * force_along)
    rocking.plot([0.0], [0.0], "+", color=LIGHT.ink, markersize=10, label="plane model")
    groups = [(name, amplitudes(force[:, 2])) for (force, _), name in zip(loads, names, strict=True)]
    spectrum_bars(bars, ORDERS, groups, np.abs(harmonics()))
    along.set(xlabel="crank angle [°]", ylabel="force [N]", xticks=np.arange(0, 361, 90))
    rocking.set(xlabel="about the bore [N m]", ylabel="across the bore [N m]", xlim=(-0.6, 0.6))
    bars.set(xlabel="multiple of the crank speed [-]", ylabel="amplitude [N]", ylim=(1e-2, 40))
    for axes in (along, bars, rocking):
        legend_below(axes, 2)
    return figure


demo = Exhibit(
    name="crank",
    title="crank with an offset centre of mass: what shakes the block",
    why="A cylinder beside its bearing rocks the block about an axis that lies in the plane of the mechanism, where a "
    "plane model has no moment; and it is the reference point off the centre of mass that calls for m w x (w x s).",
    source="slider-crank by Newton's second law: the block takes the mass times acceleration of crank, rod and piston; "
    "Fourier series of sqrt(1 - (R/L)^2 sin^2 q)",
    make=run,
    family="Shafts out of line",
    ablation={"centripetal": False},
)
