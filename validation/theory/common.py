"""Array type, precision and constants of the closed forms; rotations and products that keep extended precision."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.floating]

GRAVITY = 9.81  # Acceleration of free fall used when none is given [m/s^2]

EXTENDED = np.longdouble
"""80-bit floats where the machine has them (64-bit elsewhere: results then lose about three digits)."""


def rotation_matrix(quaternion: ArrayLike) -> Array:
    """Rotation body to world, ``R = 1 + 2 e0 [e_v]x + 2 [e_v]x^2`` for a unit quaternion.

    ``quaternion`` (4,): (e0, e1, e2, e3), normalised here [-]. Returns (3, 3): rotation matrix [-].
    """
    e = np.asarray(quaternion, dtype=EXTENDED)
    e = e / np.sqrt(np.sum(e * e))
    return np.eye(3, dtype=EXTENDED) + 2 * e[0] * skew(e[1:]) + 2 * product(skew(e[1:]), skew(e[1:]))


class Attitude(NamedTuple):
    """Motion of a body about a point."""

    omega_body: Array  # Angular velocity in body axes, (n, 3) [rad/s]
    rotation: Array  # Body to world, (n, 3, 3) [-]


def turn(omega: Array, t: Array) -> Array:
    """Rotations by the angle |omega| t about omega, (n, 3, 3)."""
    speed = np.sqrt(np.sum(omega * omega))
    axis = omega / speed if speed > 0 else omega
    angle = (speed * t)[:, None, None]
    cross = skew(axis)
    return np.eye(3, dtype=EXTENDED) + np.sin(angle) * cross + (1 - np.cos(angle)) * product(cross, cross)


def skew(a: Array) -> Array:
    """Matrix [a]x with [a]x b = a x b, (3,) -> (3, 3)."""
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]], dtype=np.asarray(a).dtype)


def product(a: Array, b: Array) -> Array:
    """Matrix product over the last two axes that keeps extended precision."""
    return np.einsum("...ij,...jk->...ik", a, b)


def cross(a: Array, b: Array) -> Array:
    """Cross product over the last axis (faster than numpy's on small arrays)."""
    a0, a1, a2 = a[..., 0], a[..., 1], a[..., 2]
    b0, b1, b2 = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0], axis=-1)
