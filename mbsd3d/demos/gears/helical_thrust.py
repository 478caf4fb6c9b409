"""Oblique teeth push their shafts lengthwise."""

import numpy as np

from mbsd3d import GROUND, Body, GearMesh, Revolute, SpeedDriver, System, Torque, shapes, simulate

from ..form import Ablation, Against, Beat, Control, Demo, Measured, Quantity, Symbol, require
from ..moments import share

PINION_RATE = 3.0  # [rad/s] of the pinion; nothing depends on it


def mechanism(*, torque=50.0, radius=0.05, helix_deg=25.0, pressure_deg=20.0) -> System:
    """Build a pinion of a pitch radius [m] driven by a torque [N m], and a wheel twice as large at constant speed."""
    place = np.array([3 * radius, 0, 0])
    moments = (0.01, 0.01, 0.02)
    pinion = Body("pinion", 2.0, moments, shape=teeth(radius, 16, helix_deg))
    wheel = Body("wheel", 2.0, moments, position=place, shape=teeth(2 * radius, 32, -helix_deg))
    one = Revolute(GROUND, pinion, at=(0, 0, 0), axis=(0, 0, 1), name="pinion shaft")
    two = Revolute(GROUND, wheel, at=place, axis=(0, 0, 1), name="wheel shaft")
    angles = {"pressure_angle": np.radians(pressure_deg), "helix_angle": np.radians(helix_deg)}
    mesh = GearMesh(one, two, at=(radius, 0, 0), name="mesh", **angles)
    brake = SpeedDriver(GROUND, wheel, axis=(0, 0, 1), speed=-PINION_RATE / 2, name="brake")
    return System([pinion, wheel], [one, two, mesh, brake], [Torque(pinion, (0, 0, torque))], gravity=(0, 0, 0))


def teeth(radius, count, helix_deg, width=0.6):
    """Draw a wheel with oblique teeth."""
    found = [shapes.Cylinder(0.95 * radius, width * radius)]
    for a in 2 * np.pi * np.arange(count) / count:
        out, around = np.array([np.cos(a), np.sin(a), 0]), np.array([-np.sin(a), np.cos(a), 0])
        lean = np.radians(helix_deg)
        along = np.cos(lean) * np.array([0, 0, 1.0]) + np.sin(lean) * around
        frame = np.column_stack([out, np.cross(along, out), along])
        size = (0.16 * radius, 2.2 * radius / count, width * radius)
        found.append(shapes.Box(size, at=0.98 * radius * out, orientation=frame))
    return found


def theory(*, torque, radius, helix_deg, pressure_deg):
    """Return F_t = T/r, F_a = F_t tan(helix), F_r = F_t tan(pressure)/cos(helix)."""
    require(abs(helix_deg) < 90, f"demo 'helical_thrust': helix_deg = {helix_deg:g}; give less than 90")
    force, helix = abs(torque) / radius, np.radians(abs(helix_deg))
    return {"axial_N": force * np.tan(helix), "radial_N": force * np.tan(np.radians(pressure_deg)) / np.cos(helix)}


def measure(build, terms) -> Measured:
    """Measure the components of the tooth force along the shafts and along the line of centres."""
    run = simulate(build(), 2 * np.pi / PINION_RATE, output=61, **terms)
    radial, _, axial = abs(run.reaction("mesh").force.mean(axis=0))
    return Measured({"axial_N": axial, "radial_N": radial}, [run])


demo = Demo(
    __name__,
    title="The thrust of helical gears",
    question="Why do helical gears push their shafts lengthwise?",
    beats=(
        Beat(0.0, "The force between the teeth leans along the shaft."),
        Beat(share(0.5), "466 of 1000 N push the shaft lengthwise."),
    ),
    why="Teeth push at right angles to their flanks. Oblique teeth run more quietly, because they come into contact "
    "little by little, but their flanks face partly along the shaft, and so does their force. Bearings must hold "
    "it; teeth in the shape of a V cancel it.",
    equation="F_t = T / r; F_a = F_t tan(helix); F_r = F_t tan(pressure) / cos(helix)",
    symbols={
        "F_t": Symbol("force round the wheel", "N", curve=(0, 1), arrow="reaction force"),
        "F_a": Symbol("force along the shaft", "N", curve=(0, 2), arrow="reaction force"),
        "F_r": Symbol("force between the shafts", "N", curve=(0, 0), arrow="reaction force"),
        "T": Symbol("torque", "N m", "torque"),
        "r": Symbol("wheel", "m", "radius"),
    },
    source="Shigley, Mechanical Engineering Design, ch. 13; ISO 21771",
    quantities={"axial_N": Quantity("force along the shafts", "N"), "radial_N": Quantity("force between them", "N")},
    ablation=Ablation("helix", "straight teeth do not push along the shaft", {"helix_deg": 0.0}),
    against=Against("helix_deg", 0.0, 45.0, "helix angle [deg]"),
    show={"curves": [("reaction", "mesh")], "shown": ["reaction force"], "traces": []},
    sliders=(
        Control("helix_deg", 0.0, 45.0, "deg", "helix"),
        Control("pressure_deg", 10.0, 30.0, "deg", "pressure angle"),
    ),
    attempt="cut the teeth straight: the push along the shaft goes.",
)
