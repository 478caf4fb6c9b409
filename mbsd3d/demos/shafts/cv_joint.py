"""A constant-velocity joint transmits every angle, and still bends its shafts: steadily."""

import numpy as np

from mbsd3d import ConstantVelocity, System

from ..form import Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share
from . import cardan_couple
from .shaft_pair import one_turn, shaft_pair


def mechanism(*, bend_deg=20.0, torque=500.0, cross=0) -> System:
    """Build two shafts at an angle, a load torque [N m] on the driven one; cross = 1 puts a Cardan joint between
    them."""
    if cross:
        return cardan_couple.mechanism(bend_deg=bend_deg, torque=torque)
    b = np.radians(bend_deg)
    return shaft_pair(ConstantVelocity, bend_deg, torque, axis_a=(1, 0, 0), axis_b=(np.cos(b), np.sin(b), 0))


def theory(*, bend_deg, torque, cross):
    """Return the moment in the bisecting plane: T tan(b/2) across each shaft, at rest."""
    require(abs(bend_deg) < 90, f"demo 'cv_joint': bend_deg = {bend_deg:g}: give less than 90")
    if cross:
        return with_cross(bend_deg=bend_deg, torque=torque)
    couple = abs(torque) * np.tan(np.radians(abs(bend_deg)) / 2)
    return {"couple_on_driving_shaft_Nm": couple, "couple_on_driven_shaft_Nm": couple, "unevenness": 0.0}


def with_cross(*, bend_deg, torque):
    """Return the values of a Cardan joint in its place."""
    b = np.radians(bend_deg)
    return {**cardan_couple.theory(bend_deg=bend_deg, torque=torque), "unevenness": 1 / np.cos(b) - np.cos(b)}


def over_a_turn(angle, bend_deg, torque, cross):
    """Return the couple on the driving shaft [N m] and ratio of the rates at angles [rad] of a turn."""
    if not cross:
        couple = theory(bend_deg=bend_deg, torque=torque, cross=0)["couple_on_driving_shaft_Nm"]
        return np.full(angle.size, couple), np.ones(angle.size)
    b = np.radians(bend_deg)
    return cardan_couple.couple(angle, bend_deg, torque), np.cos(b) / (1 - (np.sin(b) * np.cos(angle)) ** 2)


def measure(build, terms, *, bend_deg, torque, cross) -> Measured:
    """Measure couples and evenness of one slow turn."""
    run, on_driving, on_driven, ratio = one_turn(build(), **terms)
    angle, (couple, even) = np.degrees(run.t), over_a_turn(run.t, bend_deg, torque, cross)
    values = {
        "couple_on_driving_shaft_Nm": on_driving.max(),
        "couple_on_driven_shaft_Nm": on_driven.max(),
        "unevenness": np.ptp(ratio),
    }
    curves = [
        Curve("couple on the driving shaft [N m]", angle, on_driving, (angle, couple), "turn [deg]"),
        Curve("output over input rate [-]", angle, ratio, (angle, even), "turn [deg]"),
    ]
    return Measured(values, [run], curves)


demo = Demo(
    __name__,
    title="The constant-velocity joint",
    question="What does a constant-velocity joint do better than a cross, and what can it not avoid?",
    beats=(
        Beat(0.0, "It runs even ..."),
        Beat(share(0.5), "... but a couple of 88 N m stands on its bearing, and does not beat."),
    ),
    why="Balls in the plane that bisects the angle pass the turn on evenly, which no cross does. But the moment "
    "along one shaft is not the moment along the other: their difference points across, and some bearing must "
    "supply it. No joint can avoid that; here it stands still, T tan(b/2) on each shaft, instead of beating "
    "twice a turn.",
    equation="ratio = 1; couple = T tan(b/2) on both shafts, constant",
    symbols={
        "T": Symbol("torque", "N m", "torque", arrow="reaction moment"),
        "b": Symbol("bend", "deg", "bend_deg"),
    },
    source="Seherr-Thoss, Schmelz, Aucktor, Universal Joints and Driveshafts; Hunt, J. Appl. Mech. 40 (1973)",
    quantities={
        "couple_on_driving_shaft_Nm": Quantity("couple on the driving shaft", "N m"),
        "couple_on_driven_shaft_Nm": Quantity("couple on the driven shaft", "N m"),
        "unevenness": Quantity("greatest less least ratio"),
    },
    alone="its shafts have no mass",
    ablation=Ablation("constancy", "a cross in its place is uneven and shakes", {"cross": 1}, values=with_cross),
    against=Against("bend_deg", 0.0, 60.0, "bend [deg]"),
    show={"curves": [("reaction", "bearing")], "shown": ["reaction moment"], "traces": []},
    may_vanish=("bend_deg",),
    sliders=(
        Control("bend_deg", 0.0, 60.0, "deg", "bend"),
        Control("torque", 100.0, 1000.0, "N m"),
    ),
    attempt="bend it more: it still runs even, and still needs a couple.",
)
