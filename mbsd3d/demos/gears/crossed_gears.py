"""Two screws on crossed shafts make a gear whose ratio is not that of the radii."""

import numpy as np

from mbsd3d import GROUND, AngleDriver, Body, GearMesh, Kinematic, Ramp, Revolute, System, Torque, simulate

from ..form import Ablation, Against, Beat, Control, Demo, Measured, Quantity, Symbol, require
from ..moments import share
from .helical_thrust import teeth


def mechanism(*, r1=0.03, r2=0.05, helix_deg=50.0, shaft_angle_deg=90.0, torque=20.0) -> System:
    """Build a pinion r1 [m] about z with its helix angle, wheel r2 [m] on a shaft crossed to it; torque [N m] on the
    pinion.
    """
    angle = np.radians(shaft_angle_deg)
    place, axis = np.array([r1 + r2, 0, 0]), np.array([0, np.sin(angle), np.cos(angle)])
    frame = np.column_stack([(1, 0, 0), np.cross(axis, (1, 0, 0)), axis])
    pinion = Body("pinion", 1.0, (0.01, 0.01, 0.02), shape=teeth(r1, 12, -helix_deg, 1.4))
    wheel = Body("wheel", 1.0, (0.01, 0.01, 0.02), position=place, orientation=frame,
                 shape=teeth(r2, 24, helix_deg - shaft_angle_deg, 0.9))  # fmt: skip
    one = Revolute(GROUND, pinion, at=(0, 0, 0), axis=(0, 0, 1), name="pinion shaft")
    two = Revolute(GROUND, wheel, at=place, axis=axis, name="wheel shaft")
    mesh = GearMesh(one, two, at=(r1, 0, 0), helix_angle=np.radians(helix_deg), name="mesh")
    brake = AngleDriver(two, Ramp(-1.0), name="brake")
    return System([pinion, wheel], [one, two, mesh, brake], [Torque(pinion, (0, 0, torque))], gravity=(0, 0, 0))


def theory(*, r1, r2, helix_deg, shaft_angle_deg, torque):
    """Return the ratio r1 cos b1/(r2 cos b2) with b1 + b2 the angle of the shafts; thrust T tan(b1)/r1; both from the
    tooth force.
    """
    b1, b2 = np.radians(helix_deg), np.radians(shaft_angle_deg - helix_deg)
    require(abs(helix_deg) < 90 and abs(shaft_angle_deg - helix_deg) < 90, f"demo 'crossed_gears': helix_deg = "
            f"{helix_deg:g}: both helix angles must be less than 90 degrees")  # fmt: skip
    ratio = r1 * np.cos(b1) / (r2 * np.cos(b2))
    return {"ratio": ratio, "thrust_on_pinion_N": abs(torque * np.tan(b1)) / r1, "wheel_torque_Nm": abs(torque) / ratio}


def measure(build, terms) -> Measured:
    """Measure rates, force along the pinion's shaft, torque of the brake."""
    run = simulate(build(), 2 * np.pi, method=Kinematic(), output=121, **terms)
    values = {
        "ratio": abs(run.rate("wheel shaft") / run.rate("pinion shaft")).mean(),
        "thrust_on_pinion_N": abs(run.reaction("mesh").force[:, 2]).mean(),
        "wheel_torque_Nm": abs(run.effort("brake")).mean(),
    }
    return Measured(values, [run])


demo = Demo(
    __name__,
    title="Crossed screws as gears",
    question="How do two screws on crossed shafts make a gear whose ratio is not that of the radii?",
    beats=(
        Beat(0.0, "Screws on crossed shafts."),
        Beat(share(0.5), "The pinion has turned once, the wheel half: not the ratio of their radii."),
    ),
    why="On crossed shafts the teeth slide along each other like screws. Only the motion at right angles to the "
    "teeth is handed on; it sees each radius shortened by the cosine of its helix angle. So two wheels of the "
    "same size can gear down, and the ratio is set by the helix. The price is sliding and a large push along the "
    "shafts.",
    equation="ratio = r_1 cos b_1 / (r_2 cos b_2); b_1 + b_2 = angle of the shafts; thrust = T tan(b_1) / r_1",
    symbols={
        "r_1": Symbol("pinion", "m", "r1"),
        "r_2": Symbol("wheel", "m", "r2"),
        "b_1": Symbol("slant of the pinion's teeth", "deg", "helix_deg"),
        "b_2": Symbol(
            "slant of the wheel's teeth", "deg", lambda helix_deg, shaft_angle_deg: shaft_angle_deg - helix_deg
        ),
        "T": Symbol("torque on the pinion", "N m", "torque", arrow="reaction force"),
    },
    source="Shigley, Mechanical Engineering Design, ch. 13; Litvin, Fuentes, Gear Geometry and Applied Theory",
    quantities={
        "ratio": Quantity("rate of the wheel over that of the pinion"),
        "thrust_on_pinion_N": Quantity("push along the pinion's shaft", "N"),
        "wheel_torque_Nm": Quantity("torque on the wheel", "N m"),
    },
    ablation=Ablation("helix", "with equal helix angles the ratio is that of the radii", {"helix_deg": 45.0}),
    against=Against("helix_deg", 10.0, 80.0, "helix angle of the pinion [deg]"),
    show={"curves": [("rate", "pinion shaft"), ("rate", "wheel shaft")], "shown": ["reaction force"], "traces": []},
    sliders=(
        Control("helix_deg", 15.0, 75.0, "deg", "helix of the pinion"),
        Control("torque", 5.0, 50.0, "N m"),
    ),
    attempt="change the helix at the same radii: the ratio changes.",
)
