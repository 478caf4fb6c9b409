"""The hub of a two-bladed propeller on a turning airplane has an alternating moment, that of a three-bladed one a
constant one.
"""

import numpy as np

from mbsd3d import GROUND, Body, Revolute, SpeedDriver, System, shapes, simulate

from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

TURN_SAMPLES = 144  # [1] of one turn; the extremes are among them, and means over the turn are exact


AIRFRAME_SHAPES = [
    shapes.Capsule(0.35, 2.6, "x", at=(-1.7, 0, 0)),
    shapes.Box((0.6, 3.6, 0.06), at=(-1.1, 0, 0.1)),
    shapes.Box((0.3, 1.2, 0.05), at=(-2.9, 0, 0.1)),
    shapes.Box((0.35, 0.05, 0.6), at=(-2.9, 0, 0.4)),
]


def mechanism(*, J=2.0, Omega=250.0, r=0.4, blades=2) -> System:
    """Build an airplane turning at r [rad/s] about z, propeller of moment J [kg m^2] at Omega [rad/s] about its nose
    x."""
    require(blades >= 2, f"demo 'propeller_shake': blades = {blades}; give 2 or more")
    plane = Body("plane", 900.0, (800.0, 900.0, 1500.0), shape=AIRFRAME_SHAPES)
    moments = (J, 0.0, J) if blades == 2 else (J, J / 2, J / 2)
    sails = [
        shapes.Box((0.04, 0.9, 0.15), at=0.45 * d, orientation=np.column_stack([(1, 0, 0), d, np.cross((1, 0, 0), d)]))
        for d in (np.array([0, np.cos(a), np.sin(a)]) for a in 2 * np.pi * np.arange(blades) / blades)
    ]
    propeller = Body("propeller", 20.0, moments, shape=sails)
    joints = [
        Revolute(GROUND, plane, at=(0, 0, 0), axis=(0, 0, 1), name="turn"),
        SpeedDriver(GROUND, plane, axis=(0, 0, 1), speed=r, name="rudder"),
        Revolute(plane, propeller, at=(0, 0, 0), axis=(1, 0, 0), name="hub"),
        SpeedDriver(plane, propeller, axis=(1, 0, 0), speed=Omega, name="engine"),
    ]
    return System([plane, propeller], joints, gravity=(0, 0, 0))


def theory(*, J, Omega, r, blades):
    """Return the moments: two blades, pitch J W r (1 - cos 2 psi), yaw -J W r sin 2 psi; three or more, pitch J W r, no
    yaw.
    """
    size, two = abs(J * Omega * r), blades == 2
    return {
        "pitch_moment_peak_Nm": 2 * size if two else size,
        "pitch_moment_mean_Nm": size,
        "yaw_moment_amplitude_Nm": size if two else 0.0,
    }


def measure(build, terms, *, J, Omega, r) -> Measured:
    """Measure the moment of the hub on the propeller in the airplane's axes, over one turn of the propeller."""
    run = simulate(build(), 2 * np.pi / abs(Omega), rtol=1e-12, output=TURN_SAMPLES + 1, **terms)
    moment = np.einsum("tji,tj->ti", run.rotation("plane"), run.reaction("hub").moment)
    pitch, yaw = moment[:-1, 1], moment[:-1, 2]
    sign = np.sign(pitch.mean())
    values = {
        "pitch_moment_peak_Nm": (sign * pitch).max(),
        "pitch_moment_mean_Nm": abs(pitch.mean()),
        "yaw_moment_amplitude_Nm": 0.5 * np.ptp(yaw),
    }
    psi, wave = np.degrees(abs(Omega) * run.t), build.theory["yaw_moment_amplitude_Nm"]
    expected = J * abs(Omega) * abs(r) - wave * np.cos(2 * np.radians(psi))
    curve = Curve("pitching moment of the hub [N m]", psi, sign * moment[:, 1], (psi, expected), "propeller [deg]")
    path = Curve("yawing moment [N m]", sign * moment[:, 1], moment[:, 2], None, "pitching moment [N m]")
    return Measured(values, [run], [curve, path])


demo = Demo(
    __name__,
    title="Two blades shake, three do not",
    question="Why do two-bladed propellers shake an airplane that yaws and three-bladed ones do not?",
    beats=(
        Beat(0.0, "Blades upright: no moment."),
        Beat(share(0.25), "Blades level: 400 N m, twice the mean."),
        Beat(share(0.5), "Upright again, and none: it beats twice a turn."),
    ),
    why="A propeller on a turning airplane needs a gyroscopic moment about the pitch axis. Two blades have this "
    "inertia only while they stand across the axis of the turn: the moment beats between zero and twice its "
    "mean, twice a turn, and a yawing moment of the same size beats with it. Three or more blades are as good as "
    "a disc, whose inertia is the same in all directions of its plane.",
    equation="two blades: M_pitch = J W r (1 - cos 2 psi), M_yaw = -J W r sin 2 psi; three blades: M_pitch = J W r",
    symbols={
        "M_pitch": Symbol("pitching moment", "N m", curve=(0, 1), arrow="reaction moment"),
        "M_yaw": Symbol("yawing moment", "N m", curve=(0, 2), arrow="reaction moment"),
        "J": Symbol("moment of a blade", "kg m^2", "J"),
        "W": Symbol("turn of the propeller", "rad/s", "Omega"),
        "r": Symbol("turn of the aircraft", "rad/s", "r"),
        "psi": Symbol("angle of the blades", "rad"),
    },
    source="d(I w)/dt of a body of two and of three equal moments; Den Hartog, Mechanics (gyroscopes)",
    quantities={
        "pitch_moment_peak_Nm": Quantity("pitching moment, peak", "N m"),
        "pitch_moment_mean_Nm": Quantity("pitching moment, mean", "N m"),
        "yaw_moment_amplitude_Nm": Quantity("yawing moment, amplitude", "N m"),
    },
    ablation=Ablation("two-blades", "three blades make a steady moment and do not shake", {"blades": 3}),
    show={"curves": [("reaction", "hub")], "shown": ["reaction moment"]},
    sliders=(
        Control("r", 0.1, 1.0, "rad/s", "turn of the aircraft"),
        Control("Omega", 100.0, 400.0, "rad/s", "propeller"),
    ),
    attempt="turn faster: the moment grows in proportion, and so does its beat. The ghost has three blades.",
)
