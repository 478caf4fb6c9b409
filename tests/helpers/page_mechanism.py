"""A mechanism in general position with names that try to break a page, for the tests of what is seen."""

from mbsd3d import (
    GROUND,
    Body,
    Revolute,
    Sine,
    SpeedDriver,
    Spherical,
    SpringDamper,
    System,
    Universal,
    rotation,
    shapes,
)

CRANK, ARM, TAIL, BEAD = (
    "Kurbel \"ä/ö\" & 'ß'",
    "<b>Schwinge</b>",
    "</script><script>throw 1</script>",
    "Perle ☂ \\u0041",
)
PINK = "#ff00ff"  # a hue of its own: neither the palette nor paper nor ink has it


def mechanism() -> System:
    """A driven crank, an arm on a universal joint, a tail on a ball held by a spring, and a bead that flies alone."""
    crank = Body(
        CRANK, 1.3, (0.02, 0.03, 0.011), com=(0.02, 0.12, -0.04), position=(0.1, 0.2, 0.3),
        orientation=rotation((1, 2, 3), 0.7), shape=shapes.Box((0.1, 0.36, 0.06)),
    )  # fmt: skip
    elbow, ball = crank.position + (0.22, 0.21, 0.05), crank.position + (0.45, 0.1, -0.2)
    arm = Body(
        ARM, 0.7, (0.012, 0.012, 0.004), com=(0.11, -0.05, -0.12), position=elbow,
        orientation=rotation((3, -1, 2), 0.1), shape=shapes.Cylinder(0.04, 0.2, axis=(0.11, -0.05, -0.12)),
    )  # fmt: skip
    tail = Body(TAIL, 0.4, (0.003, 0.005, 0.004), com=(0.05, 0.08, -0.1), position=ball)
    bead = Body(
        BEAD, 0.2, (1e-4, 1.1e-4, 1.2e-4), com=(0.01, -0.02, 0.015), position=(-0.45, 0.2, 0.15),
        velocity=(0.3, 0.4, 3.3), omega=(4.0, 1.0, -2.0), shape=shapes.Sphere(0.05, colour=PINK),
    )  # fmt: skip
    axis = (0.2, -0.3, 1.0)
    joints = [
        Revolute(GROUND, crank, at=(0.1, 0.2, 0.3), axis=axis, name="<i>Lager</i> 1/2"),
        Universal(crank, arm, at=elbow, axis_a=(1, 0, 1), axis_b=(1, 3, -1), name="Kreuz"),
        Spherical(arm, tail, at=ball, name="Kugel"),
        SpeedDriver(GROUND, crank, axis=axis, speed=Sine(2.5, 3.0), name="Antrieb"),
    ]
    spring = SpringDamper(GROUND, tail, at_a=(0.9, 0.5, 0.5), at_b=ball + (0.05, 0.1, -0.1), stiffness=20, damping=0.2)
    return System([crank, arm, tail, bead], joints, [spring])
