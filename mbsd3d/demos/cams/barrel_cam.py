"""A drum with a groove moves a slide to and fro along its axis."""

import numpy as np

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    CurveContact,
    Kinematic,
    Prismatic,
    Ramp,
    Revolute,
    System,
    shapes,
    simulate,
)

from ..form import Ablation, Against, Beat, Curve, Demo, Measured, Quantity, Symbol
from ..moments import share

TURN_SAMPLES = 361  # [1] of one turn; greatest values lie at whole degrees
GROOVE_POINTS = 360  # [1] of the groove
SPLINE_TOLERANCE = 1e-6  # [1] relative error of the second derivative of the groove by a spline through these points


def height(turn, stroke):
    """Return (z, z', z'') of the groove over the angle: h (u - sin(2 pi u) / 2 pi) in half a turn, and back in the
    other.
    """
    half, back = turn % np.pi, (turn // np.pi) % 2 == 1
    sign = np.where(back, -1.0, 1.0)
    rise = stroke * (half / np.pi - np.sin(2 * half) / (2 * np.pi))
    slope, bend = stroke / np.pi * (1 - np.cos(2 * half)), 2 * stroke / np.pi * np.sin(2 * half)
    return np.where(back, stroke - rise, rise), sign * slope, sign * bend


def mechanism(*, R=0.06, stroke=0.08, m=1.5, omega=30.0) -> System:
    """Build a drum of radius R [m] at omega [rad/s] about z; the pin of a slide m [kg] at x = R runs in its groove."""
    turn = 2 * np.pi * np.arange(GROOVE_POINTS) / GROOVE_POINTS
    out = np.column_stack([np.cos(turn), -np.sin(turn), 0 * turn])  # turned back: the groove comes to the pin
    groove = R * out + np.outer(height(turn, stroke)[0], (0, 0, 1))
    long = stroke + R
    drum = Body("drum", 2.0, (4e-3, 4e-3, 4e-3), shape=(
        shapes.Cylinder(0.94 * R, long, at=(0, 0, 0.5 * stroke)),
        *(shapes.Lines(np.vstack([groove, groove[:1]]) + (0, 0, up), colour="black") for up in (-0.1 * R, 0.1 * R)),
    ))  # fmt: skip
    pin = shapes.Cylinder(0.1 * R, 0.5 * R, "x", at=(-0.25 * R, 0, 0))
    form = (pin, shapes.Box((0.4 * R, R, 0.6 * R), at=(0.2 * R, 0, 0)))
    slide = Body("slide", m, (1e-3, 1e-3, 1e-3), position=(1.25 * R, 0, 0), shape=form)
    shaft = Revolute(GROUND, drum, at=(0, 0, 0), axis=(0, 0, 1), name="shaft")
    joints = [
        shaft,
        AngleDriver(shaft, Ramp(omega), name="motor"),
        Prismatic(GROUND, slide, at=slide.position, axis=(0, 0, 1), name="rail"),
        CurveContact(drum, slide, groove, at=(R, 0, 0), pin=out, name="groove"),
    ]
    return System([drum, slide], joints, gravity=(0, 0, 0))


def theory(*, R, stroke, m, omega):
    """Return the greatest slope 2 h / (pi R), the side force m z'' w^2 z' / R, and the torque z' times m z'' w^2."""
    torque = m * omega**2 * 2 * stroke**2 / np.pi**2 * 0.75 * np.sqrt(3)  # sin u (1 - cos u) is greatest at 120 degrees
    return {
        "stroke_m": abs(stroke),
        "pressure_angle_deg": np.degrees(np.arctan(2 * abs(stroke) / (np.pi * R))),
        "side_force_N": torque / R,
        "torque_Nm": torque,
    }


def measure(build, terms, *, stroke, m, omega) -> Measured:
    """Measure a turn by kinematics: motion of the slide, force of the groove, torque of the motor."""
    system = build()
    run = simulate(system, 2 * np.pi / abs(omega), method=Kinematic(), output=TURN_SAMPLES, **terms)
    way, force, torque = run.position("slide")[:, 2], run.reaction("groove").force, run.effort("motor")
    normal = system.joints[-1].contact_normal(run)
    tilt = np.degrees(np.arctan2(np.linalg.norm(normal[:, :2], axis=1), np.abs(normal[:, 2])))
    degrees = np.degrees(abs(omega) * run.t)
    z, slope, bend = height(omega * run.t, stroke)
    found = {
        "stroke_m": np.ptp(way),
        "pressure_angle_deg": tilt.max(),
        "side_force_N": np.abs(force[:, 1]).max(),
        "torque_Nm": np.abs(torque).max(),
    }
    along = "drum [deg]"
    curves = [
        Curve("slide [m]", degrees, way, (degrees, z), along),
        Curve("torque of the motor [N m]", degrees, torque, (degrees, m * omega**2 * bend * slope), along),
    ]
    return Measured(found, [run], curves)


demo = Demo(
    __name__,
    title="The barrel cam",
    question="How does a groove around a drum move a slide along its axis, and what must the rail bear?",
    beats=(
        Beat(0.0, "The drum turns evenly."),
        Beat(share(0.25), "Here the groove is steepest."),
        Beat(share(0.5), "The far end: 80 mm."),
    ),
    why="A pin reaches into a groove that winds around the drum; while the drum turns evenly, the pin goes to and fro "
    "as the groove says, by any law. The flank pushes at right angles to the groove and to the pin, so "
    "where the groove is steep the push leans over by the pressure angle. Its part across the slide "
    "moves nothing: the rail bears it, and its arm about the drum is the torque.",
    equation="z = h (u - sin(2 pi u) / 2 pi), u = phi / pi; tan(alpha) = z' / (R w); side force = m z'' tan(alpha); "
    "torque = m z'' z' / w",
    symbols={
        "z": Symbol("place of the slide", "m"),
        "h": Symbol("stroke", "m", "stroke"),
        "u": Symbol("share of a stroke's turn"),
        "phi": Symbol("angle of the drum", "rad"),
        "alpha": Symbol("pressure angle", "rad"),
        "R": Symbol("drum", "m", "R"),
        "w": Symbol("turn of the drum", "rad/s", "omega"),
        "m": Symbol("slide", "kg", "m"),
    },
    source="Norton, Cam Design and Manufacturing Handbook; Rothbart, Cams",
    quantities={
        "stroke_m": Quantity("stroke", "m"),
        "pressure_angle_deg": Quantity("greatest pressure angle", "deg", SPLINE_TOLERANCE),
        "side_force_N": Quantity("greatest side force on the rail", "N", SPLINE_TOLERANCE),
        "torque_Nm": Quantity("greatest torque", "N m", SPLINE_TOLERANCE),
    },
    ablation=Ablation("groove", "in a groove that does not climb nothing moves", {"stroke": 0.0}),
    alone="no other engine has contacts on curves",
    against=Against("stroke", 0.0, 0.12, "stroke [m]"),
    show={"curves": [("effort", "motor")], "traces": []},
)
