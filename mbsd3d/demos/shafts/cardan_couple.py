"""A Cardan joint under torque bends its shafts to and fro twice a turn."""

import numpy as np

from mbsd3d import System, Universal

from ..form import Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share
from .shaft_pair import one_turn, shaft_pair


def mechanism(*, bend_deg=20.0, torque=500.0) -> System:
    """Build two shafts at an angle, a cross between them, a load torque [N m] on the driven one."""
    return shaft_pair(Universal, bend_deg, torque, axis_a=(0, 1, 0), axis_b=(0, 0, 1))


def couple(angle, bend_deg, torque):
    """Return the couple on the driving shaft [N m]: the joint's moment M n, n normal to both pins, M n . driven =
    torque.
    """
    b = np.radians(bend_deg)
    pin = np.stack([np.zeros_like(angle), np.cos(angle), np.sin(angle)])
    along = np.array([np.cos(b), np.sin(b), 0.0])
    other = np.cross(along, pin.T)  # normal to the driven shaft and to the first pin: the second pin
    n = np.cross(pin.T, other)
    moment = torque * n / (n @ along)[:, None]
    return np.linalg.norm(moment[:, 1:], axis=1)


def theory(*, bend_deg, torque):
    """Return the couples of a joint moment normal to its cross: now along the driven shaft, now as far off it as the
    bend.
    """
    require(abs(bend_deg) <= 45, f"demo 'cardan_couple': bend_deg = {bend_deg:g}: above 45 the greatest couple on the "
            "driving shaft is T/(2 cos b), between the quarters of a turn; give less")  # fmt: skip
    b = np.radians(abs(bend_deg))
    return {"couple_on_driving_shaft_Nm": abs(torque) * np.sin(b), "couple_on_driven_shaft_Nm": abs(torque) * np.tan(b)}


def measure(build, terms, *, bend_deg, torque) -> Measured:
    """Measure the greatest couples of one slow turn."""
    run, on_driving, on_driven, _ = one_turn(build(), **terms)
    angle = np.degrees(run.t)
    values = {"couple_on_driving_shaft_Nm": on_driving.max(), "couple_on_driven_shaft_Nm": on_driven.max()}
    curves = [
        Curve("couple on the driving shaft [N m]", angle, on_driving, (angle, couple(run.t, bend_deg, torque)),
              "turn [deg]"),
        Curve("couple on the driven shaft [N m]", angle, on_driven, None, "turn [deg]"),
    ]  # fmt: skip
    return Measured(values, [run], curves)


demo = Demo(
    __name__,
    title="The couple of a Cardan joint",
    question="Why does a Cardan shaft shake its bearings twice a turn although nothing is out of balance?",
    beats=(
        Beat(0.0, "No couple on the bearing."),
        Beat(share(0.25), "171 N m, though nothing is out of balance."),
        Beat(share(0.5), "None again: it beats twice a turn."),
    ),
    why="A cross passes on a moment only at right angles to its two pins. As it turns, this direction swings between "
    "the two shafts, and whatever is not along a shaft bends it. So a loaded Cardan joint bends each shaft twice "
    "a turn between nothing and T sin b or T tan b. The bearings feel it, however well the shafts are balanced.",
    equation="couple on the driving shaft <= T sin b; couple on the driven shaft <= T tan b",
    symbols={
        "T": Symbol("torque", "N m", "torque", arrow="reaction moment"),
        "b": Symbol("bend", "deg", "bend_deg"),
    },
    source="Seherr-Thoss, Schmelz, Aucktor, Universal Joints and Driveshafts (secondary couples); SAE AE-7",
    quantities={
        "couple_on_driving_shaft_Nm": Quantity("greatest couple on the driving shaft", "N m"),
        "couple_on_driven_shaft_Nm": Quantity("greatest couple on the driven shaft", "N m"),
    },
    alone="its shafts have no mass",
    ablation=Ablation("bend", "shafts in line feel no couple", {"bend_deg": 0.0}),
    against=Against("bend_deg", 0.0, 45.0, "bend [deg]"),
    show={"curves": [("reaction", "bearing")], "shown": ["reaction moment"], "traces": []},
    sliders=(
        Control("bend_deg", 0.0, 45.0, "deg", "bend"),
        Control("torque", 100.0, 1000.0, "N m"),
    ),
    attempt="straighten the joint: the couple goes. At 45 degrees it is 0.7 of the torque.",
)
