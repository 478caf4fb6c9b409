"""A cam lifts a valve by a roller, against a spring that must hold it down."""

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
    SpringDamper,
    System,
    shapes,
    simulate,
)

from ..form import Ablation, Against, Beat, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

TURN_SAMPLES = 1441  # [1] of one turn
OUTLINE_POINTS = 720  # [1] of the outline
# [1] of the roller at which the nose of the cam is a point: the outline has it between two of its points
NOSE_RADIUS_RATIO = 0.95
# [1] relative; greatest values lie between samples, and at the nose the third derivative of the lift jumps
SAMPLE_TOLERANCE = 1e-4


def law(turn, lift, half):
    """Return (s, s', s'') of a cycloidal lift over the angle from the nose [rad]."""
    angle = (turn + np.pi) % (2 * np.pi) - np.pi
    x, way = np.clip(1 - np.abs(angle) / half, 0.0, 1.0), -np.sign(angle) * lift / half
    u = 2 * np.pi * x
    return lift * (x - np.sin(u) / (2 * np.pi)), way * (1 - np.cos(u)), 2 * np.pi * lift / half**2 * np.sin(u)


def outline(lift, half, pitch, roller):
    """Return the outline of the cam in the plane y, z, its nose up: the path of the roller's centre less the roller,
    shape (points, 3).
    """
    turn = 2 * np.pi * np.arange(OUTLINE_POINTS) / OUTLINE_POINTS
    s, slope, _ = law(turn, lift, half)
    tilt = np.arctan2(slope, pitch + s)
    y, z = roller * np.sin(tilt), pitch + s - roller * np.cos(tilt)  # as a cam shows that has turned
    return np.column_stack([0 * turn, y * np.cos(turn) + z * np.sin(turn), z * np.cos(turn) - y * np.sin(turn)])


def mechanism(
    *, lift=0.009, half_deg=70.0, pitch=0.028, roller=0.009, m=0.12, stiffness=30e3, preload=250.0, omega=240.0
) -> System:
    """Build a cam at omega [rad/s] about x; valve m [kg] on a roller, its centre ``pitch`` [m] over the axis when
    shut."""
    require(0.0 < half_deg <= 180.0, f"demo 'roller_cam': half_deg = {half_deg:g}; give more than 0, at most 180")
    points = outline(lift, np.radians(half_deg), pitch, roller)
    wire = [shapes.Lines(np.append(points, points[:1], axis=0) + (x, 0, 0)) for x in (-0.5 * roller, 0.5 * roller)]
    cam = Body("cam", 1.0, (1e-3, 1e-3, 1e-3), shape=wire)
    top = np.array([0, 0, pitch + lift])
    form = (shapes.Disc(roller, 0.8 * roller, "x"), shapes.Cylinder(0.3 * roller, 5 * roller, at=(0, 0, 2.5 * roller)))
    valve = Body("valve", m, (1e-4, 1e-4, 1e-4), position=top, shape=form)
    shaft = Revolute(GROUND, cam, at=(0, 0, 0), axis=(1, 0, 0), name="shaft")
    joints = [
        shaft,
        AngleDriver(shaft, Ramp(omega), name="motor"),
        Prismatic(GROUND, valve, at=top, axis=(0, 0, 1), name="guide"),
        CurveContact(cam, valve, points, at=top, pin=(1, 0, 0), radius=roller, name="roller"),
    ]
    seat = np.array([0, 0, pitch + 10 * roller])
    long = 10 * roller + preload / stiffness
    spring = SpringDamper(GROUND, valve, at_a=seat, at_b=top, stiffness=stiffness, length=long, name="spring")
    return System([cam, valve], joints, [spring], gravity=(0, 0, 0))


def push(turn, lift, half, m, stiffness, preload, omega):
    """Return the force along the guide [N]."""
    s, _, bend = law(turn, lift, half)
    return m * bend * omega**2 + stiffness * s + preload


def theory(*, lift, half_deg, pitch, roller, m, stiffness, preload, omega):
    """Return tan(a) = s' / (r + s), and the force m s'' w^2 + k s + F along the guide, which must not be negative."""
    turn, half = np.linspace(-np.pi, np.pi, 400_001), np.radians(half_deg)
    s, slope, bend = law(turn, lift, half)
    out = pitch + s
    bent = (out**2 + 2 * slope**2 - out * bend) / (out**2 + slope**2) ** 1.5  # of the path of the roller's centre
    require(
        roller * bent.max() < NOSE_RADIUS_RATIO,
        f"demo 'roller_cam': roller = {roller:g} m undercuts the cam; give less than "
        f"{NOSE_RADIUS_RATIO / bent.max():.3g}, or more pitch or half_deg, or less lift",
    )
    force = push(turn, lift, half, m, stiffness, preload, omega)
    falls = bend < -1e-9 * bend.max()
    return {
        "pressure_angle_deg": np.degrees(np.arctan2(slope, pitch + s).max()),
        "float_rad_s": np.sqrt(((preload + stiffness * s)[falls] / (-m * bend[falls])).min()),
        "side_force_N": np.abs(force * slope / (pitch + s)).max(),
        "torque_Nm": np.abs(force * slope).max(),
    }


def measure(build, terms, *, lift, half_deg, m, stiffness, preload, omega) -> Measured:
    """Measure two speeds by kinematics: the force is a + b w^2, which gives the speed at which it vanishes."""
    turn = 2 * np.pi / abs(omega)
    run = simulate(build(), turn, method=Kinematic(), output=TURN_SAMPLES, **terms)
    slow = simulate(build(omega=0.5 * omega), 2 * turn, method=Kinematic(), output=TURN_SAMPLES, **terms)
    (contact,) = (joint for joint in run.system.joints if isinstance(joint, CurveContact))
    normal = contact.contact_normal(run)
    tilt = np.degrees(np.arctan2(np.abs(normal[:, 1]), normal[:, 2]))
    fast_push, slow_push = (each.reaction("roller").force[:, 2] for each in (run, slow))
    b = (fast_push - slow_push) / (0.75 * omega**2)
    a = fast_push - b * omega**2
    falls = b < -1e-6 * b.max()
    found = {
        "pressure_angle_deg": tilt.max(),
        "float_rad_s": np.sqrt((a[falls] / -b[falls]).min(initial=np.inf)),
        "side_force_N": np.abs(run.reaction("roller").force[:, 1]).max(),
        "torque_Nm": np.abs(run.effort("motor")).max(),
    }
    degrees = np.degrees(omega * run.t)
    known = push(omega * run.t, lift, np.radians(half_deg), m, stiffness, preload, omega)
    curves = [
        Curve("force of the cam along the guide [N]", degrees, fast_push, (degrees, known), "cam [deg]"),
        Curve("pressure angle [deg]", degrees, tilt, None, "cam [deg]"),
    ]
    return Measured(found, [run], curves, notes=run.certificate.notes)


demo = Demo(
    __name__,
    title="The roller and its cam",
    question="Why does a cam push its roller sideways, and from which speed on does the roller fly?",
    beats=(
        Beat(0.0, "Over the nose: nothing but the spring keeps the roller on the cam."),
        Beat(0.00254, "On the flank the push leans over by 25 degrees, and shoves the valve aside."),
        Beat(share(0.5), "Shut."),
    ),
    why="The flank of a cam is not level where it lifts, and a roller can only be pushed at right angles to it: the "
    "push leans over by the pressure angle, and what it has across bends the stem in its guide. Beyond the middle "
    "of the flank the valve must be slowed down, and only the spring can do that. Above a speed it is too weak: "
    "the cam would have to pull, which it cannot, and the valve floats.",
    equation="tan(alpha) = s' / (w (r + s)); N cos(alpha) = m s'' + k s + F >= 0; torque = N cos(alpha) s' / w",
    symbols={
        "s": Symbol("lift", "m"),
        "r": Symbol("centre of the roller over the axis, shut", "m", "pitch"),
        "alpha": Symbol("how much the push leans", "rad"),
        "N": Symbol("push", "N"),
        "m": Symbol("valve", "kg", "m"),
        "k": Symbol("spring", "N/m", "stiffness"),
        "F": Symbol("spring, shut", "N", "preload"),
        "w": Symbol("turn of the cam", "rad/s", "omega"),
    },
    source="Norton, Cam Design and Manufacturing Handbook",
    quantities={
        "pressure_angle_deg": Quantity("greatest pressure angle", "deg", SAMPLE_TOLERANCE),
        "float_rad_s": Quantity("speed of float", "rad/s", SAMPLE_TOLERANCE),
        "side_force_N": Quantity("greatest side force", "N", SAMPLE_TOLERANCE),
        "torque_Nm": Quantity("greatest torque", "N m", SAMPLE_TOLERANCE),
    },
    ablation=Ablation("size", "on a cam ten times as large the push hardly leans", {"pitch": 0.28}),
    alone="no other engine has contacts on curves",
    against=Against("pitch", 0.02, 0.06, "radius [m]"),
    show={"curves": [("effort", "motor")], "traces": []},
)
