"""Unit vectors and their perpendiculars."""

import math

import numpy as np
from numpy.typing import ArrayLike

from .checks import vector
from .errors import InputError
from .rotations import NORM_ROUNDING

WORLD_AXES = np.eye(3)
PERPENDICULAR_TOLERANCE = 1e-6  # [1] cosine of an angle that is meant to be right


def unit(value: ArrayLike, what: str) -> np.ndarray:
    """Return a (3,) unit vector along ``value``, which is kept if it is one; zero length is a ValueError."""
    axis = vector(value, what)
    length = math.sqrt(axis @ axis)
    if length < 1e-12:
        raise InputError(f"{what} has zero length; give a direction")
    if abs(length - 1.0) < NORM_ROUNDING:
        return axis
    axis = axis / length
    axis.setflags(write=False)
    return axis


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the cross product of two (3,) vectors; np.cross spends twenty times as long on finding out that they are."""
    (x, y, z), (u, v, w) = a.tolist(), b.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


def crosses(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the cross product a x b of stacks (..., 3)."""
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[..., i] = a[..., j] * b[..., k] - a[..., k] * b[..., j]
    return out


def squared(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the unit vector y, perpendicular to x where it is so to 1e-6, as typed digits are; y itself elsewhere."""
    off = float(x @ y)
    if not NORM_ROUNDING < abs(off) <= PERPENDICULAR_TOLERANCE:
        return y
    y = y - off * x
    return y / np.sqrt(y @ y)


def perpendiculars(axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return x and y with (x, y, axis) right-handed and orthonormal; axis is a unit vector."""
    size = [abs(a) for a in axis.tolist()]
    x = cross(axis, WORLD_AXES[size.index(min(size))])
    x /= np.sqrt(x @ x)
    return x, cross(axis, x)


def matched_perpendiculars(axis: np.ndarray, axis_b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the perpendiculars of axis_b that are nearest to those of axis."""
    x, _ = perpendiculars(axis)
    x_b = x - axis_b * (x @ axis_b)
    x_b /= np.sqrt(x_b @ x_b)
    return x_b, cross(axis_b, x_b)
