"""Crank, rod and piston: the force on the block, to which the offset of the crank's centre of mass adds a tenth."""

from typing import Any

import numpy as np

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
    shapes,
    simulate,
)  # fmt: skip

from ..figure import Bars
from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

ORDERS, TURN_SAMPLES = (1, 2, 4, 6), 256  # of the crank's speed; of one turn


def forms(R, L, ahead):
    """Draw crank, rod and piston."""
    crank = (shapes.Cylinder(0.1 * R, 0.6 * R, "y", at=(0, ahead - 0.42 * R, 0)),
             shapes.Box((0.24 * R, 0.08 * R, 1.3 * R), at=(0, ahead - 0.12 * R, 0.5 * R)),
             shapes.Cylinder(0.07 * R, 0.22 * R, "y", at=(0, ahead, R)))  # fmt: skip
    ends = [shapes.Torus(0.13 * R, 0.05 * R, "y", at=(0, 0, end)) for end in (-0.5 * L, 0.5 * L)]
    rod = shapes.Box((0.1 * R, 0.07 * R, L - 0.3 * R)), *ends
    return crank, rod, shapes.Cylinder(0.4 * R, 0.6 * R, "z", at=(0, 0, 0.12 * R))


def mechanism(*, rpm=10.0, R=1.0, L=2.0, rc=0.5, ahead=0.1, mc=2.0, mr=4.0, mp=5.0) -> System:
    """Build one cylinder, its bore along z at ``ahead`` [m] from the bearing along the crank's axis y; piston up, no
    gravity.

    Crank mc [kg] of radius R with its centre of mass at rc [m], reference point on the axis; rod mr of length L with
    its at mid length, piston mp. Spherical crankpin, universal wristpin: no row is redundant.
    """
    pin, wrist = np.array([0.0, ahead, R]), np.array([0.0, ahead, R + L])
    shape = forms(R, L, ahead)
    crank = Body("crank", mc, (0.3, 0.4, 0.5), com=(0, ahead, rc), shape=shape[0])
    rod = Body("rod", mr, (1 / 3, 1 / 3, 0.01), position=0.5 * (pin + wrist), shape=shape[1])
    piston = Body("piston", mp, (1.0, 1.0, 1.0), position=wrist, shape=shape[2])
    bearing = Revolute(GROUND, crank, at=(0, 0, 0), axis=(0, 1, 0), name="bearing")
    joints = [
        bearing,
        Spherical(crank, rod, at=pin, name="crankpin"),
        Universal(piston, rod, at=wrist, axis_a=(0, 1, 0), axis_b=(1, 0, 0), name="wristpin"),
        Prismatic(GROUND, piston, at=wrist, axis=(0, 0, 1), name="bore"),
        AngleDriver(bearing, Ramp(rpm * np.pi / 30), name="motor"),
    ]
    return System([crank, rod, piston], joints, gravity=(0, 0, 0))


def harmonics(*, rpm, R, L, rc, mc, mr, mp):
    """Return amplitudes of the force on the block along the bore at 1, 2, 4, 6 times crank speed, signed cosines [N].

    1x: w^2 (mc rc + mr R + mp R); 2k: w^2 (mp + mr / 2) L (2k)^2 a_2k with sqrt(1 - (R/L)^2 sin^2 q) = a_0 +
    sum a_2k cos 2kq, the coefficients by a sum over equal angles, which is exact to rounding.
    """
    angle = 2 * np.pi * np.arange(64) / 64
    rod = 2 * np.fft.rfft(np.sqrt(1 - (R / L * np.sin(angle)) ** 2)).real / 64 * np.arange(33) ** 2
    return (rpm * np.pi / 30) ** 2 * np.array([mc * rc + (mr + mp) * R, *((mp + mr / 2) * L * rod[list(ORDERS[1:])])])


def theory(*, rpm, R, L, rc, ahead, mc, mr, mp):
    """Return `harmonics` along the bore and w^2 (mc rc + mr R / 2) across it; both act at ``ahead`` from the
    bearing."""
    require(L > 1.2 * R > 0, f"demo 'crank': L = {L:g}, R = {R:g}: give a rod that is longer than 1.2 radii")
    along = abs(harmonics(rpm=rpm, R=R, L=L, rc=rc, mc=mc, mr=mr, mp=mp))
    across, w2 = mc * rc + 0.5 * mr * R, (rpm * np.pi / 30) ** 2
    found = {f"along_{order}x_N": size for order, size in zip(ORDERS, along, strict=True)}
    rest = {"across_1x_N": w2 * across, "rocking_1x_Nm": abs(ahead) * along[0]}
    return {**found, **rest, "along_1x_without_centripetal_N": w2 * (mr + mp) * R}


def without_centripetal(*, rpm, R, L, ahead, mc, mr, mp):
    """Return the values without m w x (w x s): the share of the crank is missing, whose reference point is not its
    centre of mass.
    """
    return theory(rpm=rpm, R=R, L=L, rc=0.0, ahead=ahead, mc=mc, mr=mr, mp=mp)


def block_load(run: Solution) -> tuple[np.ndarray, np.ndarray]:
    """Return force on the block [N] and moment about the bearing [N m] from bearing and bore, shape (samples, 3)
    each."""
    bearing, bore = run.reaction("bearing"), run.reaction("bore")
    arm = bore.point - bearing.point
    return -(bearing.force + bore.force), -(bearing.moment + bore.moment + np.cross(arm, bore.force))


def amplitudes(values: np.ndarray) -> np.ndarray:
    """Return the amplitudes at ORDERS of one turn of samples, the last one a repetition of the first."""
    return 2 * np.abs(np.fft.rfft(values[:-1]))[list(ORDERS)] / (values.size - 1)


def one_turn(system: System, rpm: float, **terms: Any) -> Solution:
    """Simulate one turn of the crank by kinematics."""
    return simulate(system, 60 / abs(rpm), method=Kinematic(), output=TURN_SAMPLES + 1, **terms)


def measure(build, terms, *, rpm, R, L, rc, ahead, mc, mr, mp) -> Measured:
    """Measure harmonics of force and moment on the block during one turn."""
    run, lacking = one_turn(build(), rpm, **terms), one_turn(build(), rpm, **{**terms, "centripetal": False})
    (force, moment), angle = block_load(run), rpm * np.pi / 30 * run.t
    along = amplitudes(force[:, 2])
    signed = harmonics(rpm=rpm, R=R, L=L, rc=rc, mc=mc, mr=mr, mp=mp)
    known, aside = np.cos(np.multiply.outer(angle, ORDERS)) @ signed, build.theory["across_1x_N"] * np.sin(angle)
    values = {f"along_{order}x_N": size for order, size in zip(ORDERS, along, strict=True)}
    values |= {"across_1x_N": amplitudes(force[:, 0])[0], "rocking_1x_Nm": amplitudes(moment[:, 0])[0]}
    values["along_1x_without_centripetal_N"] = amplitudes(block_load(lacking)[0][:, 2])[0]
    curves = [
        Curve("force [N]", np.degrees(angle), force[:, 2], (np.degrees(angle), known), "crank angle [deg]",
              "force on the block along the bore"),
        Bars("amplitude [N]", ORDERS, along, abs(signed), "multiple of the crank speed [-]", "its harmonics"),
        Curve("about the axis across the bore [N m]", moment[:, 2], moment[:, 0], (-ahead * aside, ahead * known),
              "about the bore [N m]", "moment on the block: 0 in a plane"),
    ]  # fmt: skip
    return Measured(values, [run, lacking], curves)


demo = Demo(
    __name__,
    title="Crank with an offset centre of mass: what shakes the block",
    question="Why does a single cylinder shake and rock its block, and which term does a plane model forget?",
    beats=(
        Beat(0.0, "Top: the piston pulls the block up."),
        Beat(share(0.5), "Bottom: less than half of that, for a rod of finite length."),
        Beat(share(1.0), "Once a turn, and twice, and four times."),
    ),
    why="Crank, rod and piston are thrown to and fro, and the block takes the reaction once, twice, four times a turn. "
    "A cylinder beside its bearing also rocks the block about an axis that lies in the plane of the mechanism, where a "
    "plane model has no moment. And the crank's centre of mass off its axis needs the term m w x (w x s): without it "
    "a tenth of the force along the bore is missing.",
    equation="F_1 = w^2 (m_c r_c + m_r R + m_p R); M = ahead F; F_2k from sqrt(1 - (R/L)^2 sin^2 q)",
    symbols={
        "w": Symbol("turn of the crank", "rad/s", lambda rpm: rpm * float(np.pi) / 30),
        "R": Symbol("throw", "m", "R"),
        "L": Symbol("rod", "m", "L"),
        "r_c": Symbol("centre of mass of the crank, off its axis", "m", "rc"),
        "m_c": Symbol("crank", "kg", "mc"),
        "m_r": Symbol("rod", "kg", "mr"),
        "m_p": Symbol("piston", "kg", "mp"),
        "F": Symbol("force on the block; at the bearing", "N", curve=(1, 0), arrow="reaction force"),
        "F_1": Symbol("its part once a turn", "N"),
        "F_2k": Symbol("its parts 2, 4, 6 times a turn", "N"),
        "M": Symbol("rocking moment", "N m"),
        "q": Symbol("angle of the crank", "rad"),
    },
    source="slider-crank by Newton's second law: the block takes the mass times acceleration of crank, rod and piston; "
    "Fourier series of sqrt(1 - (R/L)^2 sin^2 q)",
    quantities={
        **{f"along_{order}x_N": Quantity(f"block force along the bore, {order}x", "N") for order in ORDERS},
        "across_1x_N": Quantity("block force across the bore, 1x", "N"),
        "rocking_1x_Nm": Quantity("rocking moment across the bore, 1x", "N m"),
        "along_1x_without_centripetal_N": Quantity("the force along it without m w x (w x s), 1x", "N"),
    },
    ablation=Ablation("centripetal", "the share of the crank is missing", values=without_centripetal),
    show={"curves": [("slide", "bore"), ("reaction", "bearing", "bore")], "shown": ["reaction force"]},
    sliders=(
        Control("rc", -0.5, 1.0, "m", "centre of mass of the crank"),
        Control("L", 1.5, 4.0, "m", "rod"),
        Control("mp", 1.0, 10.0, "kg", "piston"),
    ),
    attempt="take a long rod: the force twice a turn fades, and that once a turn stays.",
)  # fmt: skip
