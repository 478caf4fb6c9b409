"""Geometry of gear trains in general axes."""

import numpy as np

from helpers.models import across, direction, moved_reference, random_orientation
from mbsd3d import (
    Body,
    Constant,
    Torque,
)
from mbsd3d.rotations import matrix


class Frame:
    """Right-handed general axes x, y, z and an origin; geometry of the tests is written in them."""

    def __init__(self, seed):
        rng = np.random.default_rng(seed)
        self.z = direction(rng)
        self.x = across(rng, self.z)
        self.y = np.cross(self.z, self.x)
        self.R = np.column_stack([self.x, self.y, self.z])
        self.origin = rng.normal(size=3)

    def at(self, *p):
        """World point."""
        return self.origin + self.R @ np.array(p, float)

    def to(self, *a):
        """World direction."""
        return self.R @ np.array(a, float)

    def local(self, vectors):
        """Components in the frame."""
        return np.asarray(vectors) @ self.R


def rotor(name, at, axis, moment, mass=1.3, seed=0):
    """A body of revolution, centre of mass at ``at``, about ``axis``, in general body axes from a general O."""
    rng = np.random.default_rng([seed, len(name)])
    e = random_orientation(rng)
    spin = matrix(e).T @ axis / np.linalg.norm(axis)
    inertia = 0.8 * moment * np.eye(3) + 0.2 * moment * np.outer(spin, spin)
    return moved_reference(Body(name, mass, inertia, position=at, orientation=e), 0.4 * direction(rng))


def torque(body, axis, value):
    """A constant torque about a world axis."""
    return Torque(body, tuple(Constant(float(x)) for x in value * np.asarray(axis)))


R_A, R_B, ALPHA, BETA = 0.11, 0.27, np.radians(22.0), np.radians(17.0)
