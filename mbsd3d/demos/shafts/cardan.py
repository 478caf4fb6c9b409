"""Two shafts at an angle: the driven one runs unevenly, and a second joint takes it back."""

from typing import Any

import numpy as np

from mbsd3d import (
    GROUND,
    Body,
    Cylindrical,
    PointOnLine,
    Revolute,
    Solution,
    SpeedDriver,
    System,
    Universal,
    rotation,
    simulate,
)  # fmt: skip

from ...api.viewable import AnimateOptions
from ..base import Show
from ..figure import Bars, Line
from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share
from .shaft_pair import forked

ORDERS = np.array([2, 4, 6])
TURN_SAMPLES = 256  # [1] of one turn; greatest and least rate are among them


def mechanism(*, bend_deg=30.0, rate=10.0, J=0.2, joints=1) -> System:
    """Build an input along x at ``rate`` [rad/s], output of moment J [kg m^2] bent by the angle; or with a second
    joint, whose yokes are aligned, parallel to the input beyond a middle shaft.
    """
    require(joints in (1, 2), f"demo 'cardan': joints = {joints}; give 1, or 2 for the double joint")
    bend = np.radians(bend_deg)
    along, moments = np.array([np.cos(bend), np.sin(bend), 0.0]), (J, 1.0, 1.0)
    drive = Body("drive", 1.0, moments, position=(-0.5, 0, 0), shape=forked(-0.5, (0.5, "y")))
    parts = [
        Revolute(GROUND, drive, at=(-0.5, 0, 0), axis=(1, 0, 0), name="bearing"),
        SpeedDriver(GROUND, drive, axis=(1, 0, 0), speed=rate, name="motor"),
    ]
    shape = forked(0.5, (-0.5, "z")) if joints == 1 else forked(None, (-0.5, "z"), (0.5, "z"))
    name = "driven" if joints == 1 else "middle"
    bent = Body(name, 1.0, moments, position=0.5 * along, orientation=rotation("z", bend), shape=shape)
    parts.append(Universal(drive, bent, at=(0, 0, 0), axis_a=(0, 1, 0), axis_b=(0, 0, 1), name="cross"))
    if joints == 1:  # a bearing at its end would be redundant
        return System(
            [drive, bent], [*parts, PointOnLine(GROUND, bent, at=along, axis=along, name="support")], gravity=(0, 0, 0)
        )
    driven = Body("driven", 1.0, moments, position=along + (0.5, 0, 0), shape=forked(0.5, (-0.5, "y")))
    parts += [
        Universal(bent, driven, at=along, axis_a=(0, 0, 1), axis_b=(0, 1, 0), name="cross 2"),
        Cylindrical(GROUND, driven, at=along + (1, 0, 0), axis=(1, 0, 0), name="support"),
    ]
    return System([drive, bent, driven], parts, gravity=(0, 0, 0))


def ratio(angle: np.ndarray, bend: float) -> np.ndarray:
    """Return output over input rate: cos b / (1 - sin^2 b cos^2(angle)), the input's cross axis in the shafts' plane at
    0.
    """
    return np.cos(bend) / (1 - np.sin(bend) ** 2 * np.cos(angle) ** 2)


def motor_torque(angle: np.ndarray, bend: float, rate: float, J: float) -> np.ndarray:
    """Return J times output acceleration times ratio [N m]: all power goes into the driven shaft."""
    n = ratio(angle, bend)
    return J * rate**2 * n * -(np.sin(bend) ** 2) * np.sin(2 * angle) * n**2 / np.cos(bend)


def harmonics(bend: float) -> np.ndarray:
    """Return amplitudes over the mean at 2, 4, 6 times shaft speed: 2 tan^(2k)(b/2), the Poisson kernel of `ratio`."""
    return 2 * np.tan(bend / 2) ** ORDERS


def theory(*, bend_deg, rate, J):
    """Return 1/cos^2 b between fastest and slowest, `harmonics`, the greatest `motor_torque` of the samples; 1 for
    two."""
    require(abs(bend_deg) < 90, f"demo 'cardan': bend_deg = {bend_deg:g}: a cross locks at 90; give less")
    b = np.radians(bend_deg)
    torque = motor_torque(2 * np.pi * np.arange(TURN_SAMPLES + 1) / TURN_SAMPLES, b, rate, J).max()
    amplitudes = dict(zip(("amplitude_2x", "amplitude_4x", "amplitude_6x"), harmonics(b), strict=True))
    even = {"double_greatest_ratio": 1.0, "double_least_ratio": 1.0}
    return {"greatest_over_least": 1 / np.cos(b) ** 2, **amplitudes, "motor_torque_Nm": torque, **even}


def one_turn(system: System, rate: float, **terms: Any) -> Solution:
    """Simulate one turn of the input."""
    return simulate(system, 2 * np.pi / abs(rate), rtol=1e-12, output=TURN_SAMPLES + 1, **terms)


def measure(build, terms, *, bend_deg, rate, J) -> Measured:
    """Measure the ratio of the rates, its harmonics and the motor's torque during one turn, with one joint and with
    two.
    """
    single, double = (one_turn(build(joints=count), rate, **terms) for count in (1, 2))
    found, even = (run.omega_body("driven")[:, 0] / rate for run in (single, double))
    spectrum = np.abs(np.fft.rfft(found[:-1]))
    amplitudes = 2 * spectrum[ORDERS] / spectrum[0]
    torque, b = single.effort("motor"), np.radians(bend_deg)
    names = ("greatest_over_least", "amplitude_2x", "amplitude_4x", "amplitude_6x", "motor_torque_Nm",
             "double_greatest_ratio", "double_least_ratio")  # fmt: skip
    values = (found.max() / found.min(), *amplitudes, torque.max(), even.max(), even.min())
    angle, degrees, along = rate * single.t, np.degrees(rate * single.t), "input angle [deg]"
    curves = [
        Curve("output rate / input rate [-]", degrees, found, (degrees, ratio(angle, b)), along, "it runs unevenly",
              name="one joint", more=[Line("two joints", even)]),
        Bars("amplitude / mean rate [-]", ORDERS, amplitudes, harmonics(b), title="harmonics of the output rate"),
        Curve("motor torque [N m]", degrees, torque, (degrees, motor_torque(angle, b, rate, J)), along,
              "torque that an even input takes"),
    ]  # fmt: skip
    options: AnimateOptions = {**demo.shown(demo.parameters), "title": "two Cardan joints: an even ratio again"}
    return Measured(dict(zip(names, values, strict=True)), [single, double], curves, {"double": Show(double, options)})


demo = Demo(
    __name__,
    title="Cardan joint: an uneven ratio between shafts at an angle",
    question="Why does a shaft behind a Cardan joint run unevenly, and what takes it back?",
    beats=(
        Beat(0.0, "The driven shaft runs ahead, at 11.5 rad/s instead of 10 ..."),
        Beat(share(0.25), "... and waits, at 8.7, twice a turn."),
        Beat(share(0.5), "Ahead again."),
    ),
    why="In a plane all shafts are parallel and a coupling hands every angle on unchanged. Two shafts that meet at an "
    "angle need space, and the cross between them makes the output faster and slower twice a turn, as its pins lie now "
    "across the bend, now in it. An output with inertia then needs a torque that swings, even at a steady input. A "
    "second joint with aligned yokes at the same angle takes the unevenness back.",
    equation="n = cos b / (1 - sin^2 b cos^2 a); amplitude 2k: 2 tan^(2k)(b/2)",
    symbols={
        "n": Symbol("output over input; the output", "rad/s", curve=(0, 0)),
        "a": Symbol("angle of the driving shaft", "rad"),
        "b": Symbol("bend", "deg", "bend_deg"),
        "k": Symbol("1, 2, 3 ..."),
    },
    source="spherical trigonometry of the cross, tan(out) = cos(bend) tan(in); the Fourier series of the rate is the "
    "Poisson kernel with q = tan^2(bend/2)",
    quantities={
        "greatest_over_least": Quantity("greatest over least output rate", absolute=1e-10, relative=1e-10),
        **{f"amplitude_{k}x": Quantity(f"{k}x amplitude over the mean rate", absolute=1e-10) for k in ORDERS},
        "motor_torque_Nm": Quantity("greatest motor torque", "N m", absolute=1e-8),
        "double_greatest_ratio": Quantity("double joint: greatest output/input rate", relative=1e-10, absolute=1e-10),
        "double_least_ratio": Quantity("double joint: least output/input rate", relative=1e-10, absolute=1e-10),
    },
    ablation=Ablation("bend", "shafts in line turn as one", {"bend_deg": 0.0}),
    show={"curves": [("omega_body", "driven"), ("effort", "motor")], "traces": []},
    ranges={"joints": None},
    sliders=(Control("bend_deg", 0.0, 50.0, "deg", "bend"), Control("rate", 5.0, 20.0, "rad/s", "speed of the input")),
    attempt="straighten the shafts: the output turns evenly. Bend them by 45 degrees: it turns twice as fast in some "
    "places as in others.",
)  # fmt: skip
