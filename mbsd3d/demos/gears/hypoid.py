"""Gears on shafts that pass each other: the pinion of an axle below the middle of its crown wheel."""

import numpy as np

from mbsd3d import GROUND, Body, GearMesh, Revolute, SpeedDriver, System, Torque, shapes, simulate

from ..form import Ablation, Against, Beat, Control, Demo, Measured, Quantity, Symbol, require
from ..moments import share

PITCH_POINT = np.array([0.0, 0.0, 0.0])  # [m] the origin
PINION_TEETH = 10  # [1] of the pinion, as drawn


def mechanism(
    *, torque=100.0, rate=100.0, wheel_radius=0.1, ratio=3.7, spiral_deg=50.0, offset_angle_deg=20.0,
    pressure_deg=20.0,
) -> System:  # fmt: skip
    """Build shafts along -x and y; torque [N m] and rate [rad/s] of the pinion, pitch radius of the wheel [m], spiral
    of the pinion, angle between the elements of the cones in contact.
    """
    r, b, d = numbers(wheel_radius, ratio, spiral_deg, offset_angle_deg)
    eta, n = b[0] - b[1], np.array([0, 1.0, 0])  # in the pitch plane, whose normal n points to the wheel's shaft
    elements = np.array([0, 0, 1.0]), np.array([-np.sin(eta), 0, np.cos(eta)])
    axes = [np.cos(d[k]) * elements[k] + (-1, 1)[k] * np.sin(d[k]) * n for k in (0, 1)]
    turned = np.array([-axes[0], axes[1], np.cross(axes[1], axes[0])])  # to the world's axes: the pinion is below
    bodies, shafts = [], []
    for k, name in enumerate(("pinion", "wheel")):
        arm = turned @ (np.sin(d[k]) * elements[k] + (1, -1)[k] * np.cos(d[k]) * n)  # from the shaft to the pitch point
        axis = turned @ axes[k]
        frame, count = np.column_stack([arm, np.cross(axis, arm), axis]), round(PINION_TEETH * (1, ratio)[k])
        shape = cone(r[k], d[k], (1, -1)[k] * b[k], count, 0.3 * wheel_radius, 0.5 * k)
        bodies.append(Body(name, 2.0, (0.01, 0.01, 0.02), position=-r[k] * arm, orientation=frame, shape=shape))
        shafts.append(Revolute(GROUND, bodies[k], at=-r[k] * arm, axis=axis, name=f"{name} shaft"))
    angles = {"pressure_angle": np.radians(pressure_deg), "helix_angle": b[0]}
    mesh = GearMesh(*shafts, at=PITCH_POINT, flank=-1, name="mesh", **angles)
    brake = SpeedDriver(GROUND, bodies[1], axis=(0, 1, 0), speed=-rate / ratio, name="brake")
    return System(bodies, [*shafts, mesh, brake], [Torque(bodies[0], (-torque, 0, 0))], gravity=(0, 0, 0))


def numbers(wheel_radius, ratio, spiral_deg, offset_angle_deg):
    """Return pitch radii, spiral angles and cone angles of pinion and wheel, tan(d1) tan(d2) = cos(b1 - b2) for this
    angle.
    """
    b = np.radians([spiral_deg, spiral_deg - offset_angle_deg])
    require(
        abs(b).max() < np.pi / 2 and np.cos(b[0] - b[1]) > 0,
        f"demo 'hypoid': spiral_deg = {spiral_deg:g}, offset_angle_deg = {offset_angle_deg:g}; give spiral angles "
        "of both gears (that of the wheel is the difference) below 90 degrees",
    )
    radius = wheel_radius * np.cos(b[1]) / (ratio * np.cos(b[0]))
    share = radius / wheel_radius  # free for hypoid gears; so the cones are those of bevel gears without an offset
    return (radius, wheel_radius), b, (np.arctan(share * np.cos(b[0] - b[1])), np.arctan(1 / share))


def cone(radius, angle, spiral, count, width, shift):
    """Draw a cone with oblique teeth about z on a shaft; its pitch circle lies at the origin."""
    up, found, depth = (
        np.array([0, 0, 1.0]),
        [shapes.Cylinder(0.15 * width, 4 * width, at=(0, 0, 1.8 * width))],
        0.1 * width,
    )
    for s in np.linspace(-0.45, 0.45, 7) * width:
        place = s * np.cos(angle) + depth * np.sin(angle)
        form = max(radius + s * np.sin(angle) - depth * np.cos(angle), depth), 0.2 * width * np.cos(angle)
        found.append(shapes.Cylinder(*form, at=(0, 0, place)))
    for a in 2 * np.pi * (np.arange(count) + shift) / count:
        out, around = np.array([np.cos(a), np.sin(a), 0]), np.array([-np.sin(a), np.cos(a), 0])
        normal = np.cos(angle) * out - np.sin(angle) * up
        along = np.cos(spiral) * (np.cos(angle) * up + np.sin(angle) * out) + np.sin(spiral) * around
        size, frame = (
            (2 * depth, 2.8 * radius * np.cos(spiral) / count, width),
            [normal, np.cross(along, normal), along],
        )
        found.append(shapes.Box(size, at=radius * out, orientation=np.column_stack(frame)))
    return found


def theory(*, torque, rate, wheel_radius, ratio, spiral_deg, offset_angle_deg, pressure_deg):
    """Return the forces of each gear as a bevel gear with its own cone and spiral angle; offset and sliding by their
    difference.
    """
    (r1, r2), (b1, b2), (d1, d2) = numbers(wheel_radius, ratio, spiral_deg, offset_angle_deg)
    require(torque > 0, f"demo 'hypoid': torque = {torque:g} N m; give more than 0, for the flanks that then touch")
    push, k, off = torque / (r1 * np.cos(b1)), np.tan(np.radians(pressure_deg)), np.sin(abs(b1 - b2))
    return {
        "thrust_on_pinion_N": push * (k * np.sin(d1) + np.sin(b1) * np.cos(d1)),
        "thrust_on_wheel_N": push * (k * np.sin(d2) - np.sin(b2) * np.cos(d2)),
        "offset_m": (r1 * np.cos(d2) + r2 * np.cos(d1)) * off,
        "slip_m_s": abs(rate) * r1 * off / np.cos(b2),
        "ratio": ratio,
    }


def measure(build, terms, *, rate, ratio) -> Measured:
    """Measure tooth force along the shafts, distance of the shafts, velocities at the pitch point, and rates."""
    system = build()
    one, two, *_ = system.joints
    run = simulate(system, 2 * np.pi * ratio / abs(rate), output=121, **terms)
    force, across = run.reaction("mesh").force.mean(axis=0), np.cross(one.axis, two.axis)
    there = [run.velocity(x) + np.cross(run.omega(x), PITCH_POINT - run.position(x)) for x in ("pinion", "wheel")]
    values = {
        "thrust_on_pinion_N": -force @ one.axis,
        "thrust_on_wheel_N": force @ two.axis,
        "offset_m": abs((two.at - one.at) @ across),
        "slip_m_s": np.linalg.norm(there[1] - there[0], axis=1).mean(),
        "ratio": abs(run.rate("pinion shaft") / run.rate("wheel shaft")).mean(),
    }
    return Measured(values, [run])


demo = Demo(
    __name__,
    title="Hypoid gears: shafts that pass each other",
    question="Why does the drive shaft of a car meet its rear axle below the middle?",
    beats=(
        Beat(0.0, "The shafts pass each other, 37 mm apart."),
        Beat(share(0.5), "So the teeth slide along each other, and push the pinion with 3600 N."),
    ),
    why="Bevel gears need shafts that meet. Give the two gears different spiral angles, and the pinion moves out of "
    "the plane of the wheel: each has a pitch cone of its own, and the cones touch in one point. The ratio is then no "
    "longer that of the radii: the pinion grows by the ratio of the cosines of the spiral angles, so it is stronger "
    "beside the same wheel, and its shaft lies lower. The price is that the teeth slide along each other, which only "
    "special oil endures.",
    equation="ratio = r_2 cos b_2 / (r_1 cos b_1); F_1 = T (tan p sin d_1 + sin b_1 cos d_1) / (r_1 cos b_1); "
    "offset = (r_1 cos d_2 + r_2 cos d_1) sin(b_1 - b_2)",
    symbols={
        "F_1": Symbol("thrust on the pinion", "N", curve=(0, 0), arrow="reaction force"),
        "T": Symbol("torque", "N m", "torque"),
        "r_1": Symbol("pinion", "m"),
        "r_2": Symbol("wheel", "m", "wheel_radius"),
        "b_1": Symbol("spiral of the pinion", "deg", "spiral_deg"),
        "b_2": Symbol("spiral of the wheel", "deg", lambda spiral_deg, offset_angle_deg: spiral_deg - offset_angle_deg),
        "d_1": Symbol("cone of the pinion", "rad"),
        "d_2": Symbol("cone of the wheel", "rad"),
        "p": Symbol("slant of the flanks", "deg", "pressure_deg"),
    },
    source="thrusts: those of a bevel gear (Shigley, Mechanical Engineering Design), as the tooth normal has the same "
    "parts in the frame of each pitch cone; cones and offset: Litvin, Fuentes, Gear Geometry and Applied Theory, and "
    "the geometry of two cones on one plane",
    quantities={
        "thrust_on_pinion_N": Quantity("thrust on the pinion, away from its apex", "N"),
        "thrust_on_wheel_N": Quantity("thrust on the wheel, away from its apex", "N"),
        "offset_m": Quantity("distance of the shafts", "m"),
        "slip_m_s": Quantity("sliding along the teeth", "m/s"),
        "ratio": Quantity("rate of the pinion over that of the wheel"),
    },
    ablation=Ablation(
        "offset",
        "the shafts meet: these are spiral bevel gears, with a smaller pinion and no sliding",
        {"offset_angle_deg": 0.0},
    ),
    against=Against("offset_angle_deg", 0.0, 40.0, "angle between the elements of the cones [deg]"),
    show={"curves": [("reaction", "mesh")], "shown": ["reaction force"], "traces": []},
    sliders=(Control("offset_angle_deg", 5.0, 40.0, "deg", "offset of the pinion"),),
    attempt="lower the pinion: it pushes harder along its shaft, and the teeth slide more.",
)
