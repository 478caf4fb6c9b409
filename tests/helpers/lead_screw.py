"""A spindle, a nut and a rail in general position, with their motion in closed form."""

import numpy as np

from mbsd3d import GROUND, Body, Prismatic, Revolute, Screw, System, Torque, rotation
from mbsd3d.rotations import matrix


def lead_screw():
    """Return (system, hinge, state, angle(t)) of a spindle that moves a nut on a rail; 4 of 15 rows repeat others."""
    axis, lead, torque, rate = np.array([0.36, -0.48, 0.8]), 0.09, 0.7, 9.0
    turned, g = matrix(rotation((1, 0.2, -0.4), 0.7)), np.array([0.4, -0.8, -9.6])
    spindle = Body(
        "spindle", 2.0, (0.05, 0.07, 0.06), com=turned.T @ (np.array([0.1, 0.2, -0.1]) + 0.3 * axis),
        position=(-0.1, -0.2, 0.1), orientation=turned,
    )  # fmt: skip
    nut = Body("nut", 1.3, (0.01, 0.02, 0.015), com=(0.1, -0.05, 0.07), position=(0.3, 0.1, 0.2))
    hinge = Revolute(GROUND, spindle, at=(0, 0, 0), axis=axis)
    joints = [
        hinge,
        Prismatic(GROUND, nut, at=(0.2, 0.3, 0.1), axis=axis),
        Screw(spindle, nut, at=(0, 0, 0), axis=axis, pitch=lead),
    ]
    system = System([spindle, nut], joints, [Torque(spindle, torque * axis)], gravity=g)
    p, own = -lead / (2 * np.pi), turned.T @ axis
    gain = (torque + 1.3 * p * (g @ axis)) / (own @ np.diag((0.05, 0.07, 0.06)) @ own + 1.3 * p**2)
    return system, hinge, system.assemble(rates={hinge: rate}), lambda t: rate * t + gain * t**2 / 2
