"""One shaft drives two wheels at different rates with the same torque."""

import numpy as np

from mbsd3d import GROUND, Body, GearMesh, Revolute, SpeedDriver, System, Torque, simulate
from mbsd3d.shapes import Box, Cylinder

from ..form import Ablation, Against, Beat, Control, Demo, Measured, Quantity, Symbol
from ..moments import share
from .helical_thrust import teeth

LOAD_TORQUE = 100.0  # [N m] the road's resistance at the right wheel


def mechanism(*, R=0.05, r=0.03, carrier=40.0, left=10.0) -> System:
    """Build side gears R [m] about x, a pin gear r [m] about y in a carrier; rates [rad/s] of carrier and left wheel
    given.
    """
    side = np.column_stack([(0, 0, 1), (0, 1, 0), (-1, 0, 0)])
    pin_frame = np.column_stack([(1, 0, 0), (0, 0, -1), (0, 1, 0)])
    cage = Body("carrier", 2.0, (0.02, 0.02, 0.02), shape=(Box((0.06 * r, 2.9 * R, 0.3 * R), at=(-1.3 * r, 0, 0)),
                Cylinder(0.1 * R, 2.9 * R, "y")))  # fmt: skip
    wheels = {
        name: Body(f"{name} wheel", 1.0, (0.01, 0.01, 0.01), position=(sign * r, 0, 0), orientation=side,
                   shape=[*teeth(R, 24, 0, 0.25), Cylinder(0.15 * R, 2 * R, at=(0, 0, -sign * R))])
        for name, sign in (("left", -1), ("right", 1))
    }  # fmt: skip
    pin = Body("pin", 0.3, (1e-3, 1e-3, 1e-3), position=(0, R, 0), orientation=pin_frame, shape=teeth(r, 14, 0, 0.3))
    axle = Revolute(GROUND, cage, at=(0, 0, 0), axis=(1, 0, 0), name="drive")
    spin = Revolute(cage, pin, at=(0, R, 0), axis=(0, 1, 0), name="pin axle")
    joints = [axle, spin, SpeedDriver(GROUND, cage, axis=(1, 0, 0), speed=carrier, name="engine")]
    for name, sign in (("left", -1), ("right", 1)):
        hinge = Revolute(GROUND, wheels[name], at=(sign * r, 0, 0), axis=(1, 0, 0), name=name)
        joints += [hinge, GearMesh(hinge, spin, at=(sign * r, R, 0), carrier=cage, name=f"{name} mesh")]
    joints.append(SpeedDriver(GROUND, wheels["left"], axis=(1, 0, 0), speed=left, name="left road"))
    load = Torque(wheels["right"], (-LOAD_TORQUE, 0, 0), name="right road")
    return System([cage, pin, *wheels.values()], joints, [load], gravity=(0, 0, 0))


def theory(*, carrier, left):
    """Return the rates by Willis: seen from the carrier both wheels turn oppositely, w_L + w_R = 2 w_C; the pin is a
    balance: T_L = T_R.
    """
    return {"right_rate_rad_s": 2 * carrier - left, "left_over_right_torque": 1.0}


def measure(build, terms) -> Measured:
    """Measure the rate of the right wheel, and the ratio of the torques of left and right wheel."""
    run = simulate(build(), 0.5, rtol=1e-12, output=201, **terms)
    values = {
        "right_rate_rad_s": run.omega("right wheel")[:, 0].mean(),
        "left_over_right_torque": run.effort("left road").mean() / -LOAD_TORQUE,
    }
    return Measured(values, [run])


demo = Demo(
    __name__,
    title="The differential",
    question="How can one shaft drive two wheels that turn at different rates with the same torque?",
    beats=(
        Beat(0.0, "In a curve."),
        Beat(share(0.5), "The left wheel loses ..."),
        Beat(share(1.0), "... what the right one gains: 10 and 70, the mean is that of the engine."),
    ),
    why="In a curve the outer wheel has the longer way. The engine turns only the carrier of a pin gear that meshes "
    "with both side gears. The pin pushes both with the same force, like a balance, and by turning on its own "
    "axle it lets one wheel gain what the other loses. That is also why a car stands still if one wheel is on "
    "ice.",
    equation="w_L + w_R = 2 w_C, T_L = T_R",
    symbols={
        "w_L": Symbol("left wheel", "rad/s", curve=(0, 0)),
        "w_R": Symbol("right wheel", "rad/s", curve=(1, 0)),
        "w_C": Symbol("carrier, which the engine turns", "rad/s", "carrier"),
        "T_L": Symbol("torque on the left wheel", "N m"),
        "T_R": Symbol("torque on the right wheel", "N m"),
    },
    source="Willis, Principles of Mechanism (1841); Shigley, Mechanical Engineering Design, ch. 13",
    quantities={
        "right_rate_rad_s": Quantity("rate of the right wheel", "rad/s"),
        "left_over_right_torque": Quantity("left over right torque"),
    },
    ablation=Ablation("curve", "straight on all turns as one piece", {"left": 40.0}),
    against=Against("left", 0.0, 80.0, "rate of the left wheel [rad/s]"),
    show={"curves": [("rate", "left"), ("rate", "right")], "traces": [], "speed": 0.05},
    ranges={"R": (0.04, 0.06), "r": (0.02, 0.035)},
    sliders=(
        Control("left", -40.0, 90.0, "rad/s", "left wheel"),
        Control("carrier", 10.0, 60.0, "rad/s", "cage"),
    ),
    attempt="hold the left wheel: the right one runs at twice the rate of the cage.",
)
