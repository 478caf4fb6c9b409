"""A wheel that only wobbles on a nearly equal one gears down a hundred to one."""

import numpy as np

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    ConstantVelocity,
    GearMesh,
    Kinematic,
    Parallel,
    Ramp,
    Revolute,
    System,
    shapes,
    simulate,
)

from ..form import Ablation, Against, Beat, Control, Demo, Measured, Quantity, Symbol, require
from ..moments import share


def mechanism(*, tilt_deg=10.0, fixed_cone_deg=82.0, L=0.1, omega=100.0) -> System:
    """Build a crank about z at omega [rad/s], plate on its tilted axis rolling on a fixed cone, output about z."""
    tilt, cone = np.radians(tilt_deg), np.radians(fixed_cone_deg)
    axis, pitch = (np.sin(tilt), 0, np.cos(tilt)), L * np.array([-np.sin(cone), 0, np.cos(cone)])
    frame = np.column_stack([(np.cos(tilt), 0, -np.sin(tilt)), (0, 1, 0), axis])
    bar = shapes.Cylinder(0.06 * L, 0.8 * L, at=(0, 0, -0.4 * L))
    crank = Body("crank", 1.0, (0.01, 0.01, 0.01), shape=bar)
    height = L * np.cos(cone + tilt)
    rim = (shapes.Torus(L * np.sin(cone + tilt), 0.03 * L, at=(0, 0, height)), shapes.Box((2 * L, 0.06 * L, 0.04 * L)))
    plate = Body("plate", 1.0, (0.01, 0.01, 0.02), orientation=frame, shape=rim)
    pointer = (shapes.Box((0.7 * L, 0.05 * L, 0.04 * L), at=(0.3 * L, 0, 0.5 * L)),
               shapes.Cylinder(0.06 * L, 0.5 * L, at=(0, 0, 0.3 * L)))  # fmt: skip
    output = Body("output", 1.0, (0.01, 0.01, 0.01), shape=pointer)
    turn = Revolute(GROUND, crank, at=(0, 0, 0), axis=(0, 0, 1), name="input")
    wobble = Revolute(crank, plate, at=(0, 0, 0), axis=axis, name="wobble")
    joints = [
        turn,
        AngleDriver(turn, Ramp(omega), name="motor"),
        wobble,
        GearMesh(turn, wobble, at=pitch, name="mesh"),
        ConstantVelocity(plate, output, at=(0, 0, 0), axis_a=axis, axis_b=(0, 0, 1), name="joint"),
        Parallel(GROUND, output, axis=(0, 0, 1), name="output bearing"),
    ]
    return System([crank, plate, output], joints, gravity=(0, 0, 0))


def theory(*, tilt_deg, fixed_cone_deg, omega):
    """Return the ratio of rolling cones: the plate's teeth per turn over those of the fixed gear are sin(d2 + tilt)/sin
    d2.
    """
    require(0 < fixed_cone_deg < 180 - abs(tilt_deg), f"demo 'nutating_gear': fixed_cone_deg = {fixed_cone_deg:g}; the "
            "two cones need half angles between 0 and 180 degrees")  # fmt: skip
    cone, tilt = np.radians(fixed_cone_deg), np.radians(tilt_deg)
    return {"output_rate_rad_s": omega * (1 - np.sin(cone) / np.sin(cone + tilt))}


def measure(build, terms, *, omega) -> Measured:
    """Measure the rate of the output over ten turns of the crank."""
    run = simulate(build(), 10 * 2 * np.pi / abs(omega), method=Kinematic(), output=401, **terms)
    return Measured({"output_rate_rad_s": run.omega("output")[:, 2].mean()}, [run])


demo = Demo(
    __name__,
    title="The nutating gear",
    question="How can two nearly equal wheels, one of them only wobbling, gear down a hundred to one?",
    beats=(
        Beat(0.0, "The plate only wobbles."),
        Beat(share(0.5), "Five wobbles ..."),
        Beat(share(1.0), "... ten, and the output has turned by 33 degrees."),
    ),
    why="A tilted plate does not spin, it wobbles: its lowest point runs round and rolls on a fixed wheel. After one "
    "round it has turned only by the difference of the two rims, which are nearly of the same length, and a "
    "joint hands on this small turn. A small tilt makes a slow output: a large ratio from two wheels.",
    equation="output = w (1 - sin d / sin(d + tilt)); d: half angle of the fixed cone",
    symbols={
        "w": Symbol("turn of the input", "rad/s", "omega"),
        "d": Symbol("half angle of the fixed cone", "deg", "fixed_cone_deg"),
    },
    source="rolling cones: Goldstein, Classical Mechanics, 5.6; Litvin, Fuentes, Gear Geometry and Applied Theory",
    quantities={"output_rate_rad_s": Quantity("rate of the output", "rad/s")},
    ablation=Ablation("tilt", "a plate that hardly wobbles hardly turns", {"tilt_deg": 1.0}),
    against=Against("tilt_deg", 1.0, 15.0, "tilt of the plate [deg]"),
    show={"curves": [("omega", "output")], "traces": [], "speed": 0.05},
    ranges={"fixed_cone_deg": (75.0, 84.0)},
    sliders=(
        Control("tilt_deg", 2.0, 18.0, "deg", "wobble"),
        Control("fixed_cone_deg", 76.0, 84.0, "deg", "fixed cone"),
    ),
    attempt="wobble it more: the output goes faster, up to 10 degrees, and then slower again.",
)
