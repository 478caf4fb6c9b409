"""An open chain of hinges and a spatial four-bar, with what their bodies have in common."""

import numpy as np

from mbsd3d import (
    GROUND,
    Body,
    Revolute,
    Spherical,
    System,
    Universal,
    rotation,
)
from mbsd3d.rotations import matrix

INERTIA = (0.02, 0.05, 0.06)

AXIS = np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8])


def arm(n=3):
    """An open chain of hinges with general axes and r_G != 0."""
    bodies, joints, before = [], [], GROUND
    for k in range(n):
        axis = matrix(rotation((1.0, 2.0, 3.0), 0.7 * k)) @ AXIS
        at = np.array([0.4 * k, 0.1 * k**2, -0.2 * k])
        body = Body(f"link {k}", mass=1.0 + k, inertia=INERTIA, com=(0.05, -0.03, 0.02), position=at + (0.2, 0.1, 0.05))
        joints.append(Revolute(before, body, at=at, axis=axis, name=f"hinge {k}"))
        bodies.append(body)
        before = body
    return System(bodies=bodies, joints=joints)


def four_bar():
    """A spatial crank-rocker: revolute, spherical, universal, revolute."""
    crank = Body("crank", mass=1.0, inertia=INERTIA, com=(0.02, 0.01, 0.03), position=(0.1, 0.0, 0.0))
    coupler = Body("coupler", mass=1.5, inertia=INERTIA, com=(0.03, 0.01, -0.02), position=(0.5, 0.05, -0.05))
    rocker = Body("rocker", mass=2.0, inertia=INERTIA, com=(0.01, -0.02, 0.04), position=(0.72, 0.1, 0.08))
    joints = [
        Revolute(GROUND, crank, at=(0, 0, 0), axis=(0, 0, 1), name="drive"),
        Spherical(crank, coupler, at=(0.2, 0, 0)),
        Universal(coupler, rocker, at=(0.85, 0.1, -0.13), axis_a=(0.2, 0, 1.0), axis_b=(0, 1, 0)),
        Revolute(GROUND, rocker, at=(0.6, 0.1, 0.3), axis=(0, 1, 0), name="output"),
    ]
    return System(bodies=[crank, coupler, rocker], joints=joints)
