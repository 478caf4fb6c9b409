"""A spatial double pendulum and a driven wheel: what tests of files, pictures and pages show."""

from mbsd3d import (
    GROUND,
    Body,
    Ramp,
    Revolute,
    Sine,
    SpeedDriver,
    Spherical,
    SpringDamper,
    System,
    Torque,
    Universal,
    rotation,
)

UPPER_ARM, LOWER_ARM, WHEEL = "upper arm", "lower arm", "wheel"


def pendulum() -> System:
    """A spatial double pendulum with r_G != 0 on a universal joint, pulled by a spring, and a driven wheel."""
    upper = Body(
        UPPER_ARM,
        1.2,
        (0.02, 0.03, 0.011),
        com=(0.05, -0.02, -0.25),
        position=(0.1, 0.2, 0.3),
        orientation=rotation((1, 2, 3), 0.7),
    )
    lower = Body(
        LOWER_ARM,
        0.7,
        (0.012, 0.02, 0.01),
        com=(0.01, 0.03, -0.2),
        position=(0.3, 0.1, -0.2),
        orientation=rotation((3, -1, 2), 0.31),
    )
    wheel = Body(WHEEL, 0.5, (0.01, 0.01, 0.02), position=(-0.4, 0.3, 0.2), orientation=rotation("x", 0.2))
    axis = (0.1, 0.7, 1.3)
    joints = [
        Spherical(GROUND, upper, at=(0.1, 0.2, 0.3), name="shoulder"),
        Universal(upper, lower, at=(0.3, 0.1, -0.2), axis_a=(1, 0, 1), axis_b=(1, 3, -1), name="elbow"),
        Revolute(GROUND, wheel, at=(-0.4, 0.3, 0.2), axis=axis, name="axle"),
        SpeedDriver(GROUND, wheel, axis=axis, speed=Ramp(3.0, 1.0) + 2.0 * Sine(0.3, 4.0), name="motor"),
    ]
    forces = [
        SpringDamper(GROUND, lower, at_a=(0.5, 0.5, 0.5), at_b=(0.32, 0.1, -0.4), stiffness=40.0, damping=0.3),
        Torque(upper, (0.0, Sine(0.4, 3.0), 0.1), frame="body"),
    ]
    return System([upper, lower, wheel], joints, forces, gravity=(0.1, 0.0, -9.7))
