"""Rotations as a user gives them, unit quaternions and rotation matrices.

A quaternion is ``e = (e0, e1, e2, e3) = (e0, e_v)``: scalar first, active, body -> world, so ``a_world = R(e) a_body``.
All functions but `as_quaternion` work on stacks: any number of leading dimensions, the last ones hold the object.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from .checks import floats, shown
from .errors import InputError, explaining
from .quaternions import _check_nonzero, _stack

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


ORIENTATION_FORMS = "a unit quaternion (e0, e1, e2, e3), a 3x3 rotation matrix or rotation(axis, angle)"


NORM_ROUNDING = (
    1e-15  # [1] of the length 1; a vector that is closer to it is kept, so normalising twice changes nothing
)


NORM_TOLERANCE = 1e-6  # [1] of the length 1: numbers typed with seven digits pass, a forgotten normalisation does not


@explaining
def rotation(axis: str | ArrayLike, angle: ArrayLike, degrees: bool = False) -> np.ndarray:
    """Return the quaternion, body -> world, of a rotation about ``axis``: ``(cos(angle/2), sin(angle/2) axis/|axis|)``.

    ``axis`` is "x", "y", "z" or a vector (3,) of any length, right-hand rule; ``angle`` (...) [rad], or in degrees if
    ``degrees``. Returns (..., 4). ValueError for another axis, one of zero length, or a number that is not finite.

    >>> rotation("z", 180, degrees=True).round(12)
    array([0., 0., 0., 1.])
    """
    half = 0.5 * floats(angle, "rotation: angle", "a number")
    half = np.deg2rad(half) if degrees else half
    return np.concatenate([np.cos(half)[..., None], np.sin(half)[..., None] * _unit_axis(axis)], axis=-1)


def as_quaternion(orientation: ArrayLike, what: str = "orientation") -> np.ndarray:
    """Return the unit quaternion (4,) of an orientation, with the sign it was given; ``what`` names it in errors.

    ``orientation``: a unit quaternion (4,), scalar first, or a rotation matrix (3, 3), body -> world, exact to 1e-6;
    the rest is normalised away. ValueError for another shape, a number that is not finite, a length other than 1, or a
    matrix that is not orthonormal or is left-handed.
    """
    values = floats(orientation, what, ORIENTATION_FORMS)
    if values.shape == (3, 3):
        _check_rotation(values, what)
        return _largest_column(values)
    if values.shape != (4,):
        raise InputError(f"{what}: shape {values.shape} is not an orientation; give {ORIENTATION_FORMS}")
    norm = math.sqrt(values @ values)
    if abs(norm - 1.0) > NORM_TOLERANCE:
        raise InputError(
            f"{what}: the quaternion {_text(values)} has norm {norm:.9g} instead of 1; "
            f"divide it by its norm, or give rotation(axis, angle)"
        )
    return values if abs(norm - 1.0) < NORM_ROUNDING else values / norm


def matrix(e: ArrayLike) -> np.ndarray:
    """Return R (..., 3, 3), body -> world: ``R(e) = ((e0^2 - e_v'e_v) 1 + 2 e_v e_v' + 2 e0 [e_v]x) / e'e``.

    The length of e (..., 4) does not matter; zero or another shape is a ValueError.
    """
    e = _stack(e, 4, "quaternion")
    single = e.ndim == 1
    a, x, y, z = e.tolist() if single else (e[..., i] for i in range(4))  # floats: a tenth of the time of arrays of one
    aa, xx, yy, zz = a * a, x * x, y * y, z * z
    square = aa + xx + yy + zz
    _check_nonzero(square)
    rows = (
        (aa + xx - yy - zz, 2.0 * (x * y - a * z), 2.0 * (x * z + a * y)),
        (2.0 * (x * y + a * z), aa - xx + yy - zz, 2.0 * (y * z - a * x)),
        (2.0 * (x * z - a * y), 2.0 * (y * z + a * x), aa - xx - yy + zz),
    )
    if single:
        return np.array(rows) / square
    R = np.empty((*e.shape[:-1], 3, 3), e.dtype)
    for i in range(3):
        for j in range(3):
            R[..., i, j] = rows[i][j]
    R /= square[..., None, None]
    return R


def quaternion_from_matrix(R: ArrayLike) -> np.ndarray:
    """Return the unit quaternion (..., 4) with ``matrix(e) = R`` and ``e0 >= 0``.

    R (..., 3, 3), body -> world, must be right-handed, finite and orthonormal to 1e-6, else a ValueError.
    """
    R = floats(R, "R", "a 3x3 rotation matrix")
    if R.shape[-2:] != (3, 3):
        raise InputError(f"R: shape {R.shape} is not a rotation matrix; give (..., 3, 3)")
    _check_rotation(R, "R")
    return _largest_column(R)


def _unit_axis(axis: str | ArrayLike) -> np.ndarray:
    """Return the (3,) unit vector of a letter or of a vector of any length."""
    remedy = "'x', 'y', 'z' or a vector of three numbers"
    if isinstance(axis, str):
        if axis not in AXES:
            raise InputError(f"rotation: axis is {shown(axis)}; give {remedy}")
        return np.array(AXES[axis])
    vector = floats(axis, "rotation: axis", remedy)
    if vector.shape != (3,):
        raise InputError(f"rotation: axis has shape {vector.shape}; give {remedy}")
    largest = np.max(np.abs(vector))
    if largest == 0.0:
        raise InputError("rotation: axis has zero length, its direction is undefined; give a vector that is not zero")
    vector = vector / largest  # first to order 1, so that the squares cannot underflow or overflow
    return vector / np.linalg.norm(vector)


def _check_rotation(R: np.ndarray, what: str) -> None:
    """Refuse a matrix that is not orthonormal, and by name one that is left-handed."""
    error = np.max(np.abs(np.swapaxes(R, -1, -2) @ R - np.eye(3)), initial=0.0)
    if error > NORM_TOLERANCE:
        raise InputError(
            f"{what}: the matrix is not orthonormal, R'R differs from 1 by {error:.3g}; "
            f"its columns must be the body's axes as perpendicular unit vectors"
        )
    if np.any(np.linalg.det(R) < 0.0):
        raise InputError(
            f"{what}: the matrix is left-handed (determinant -1), a reflection and no rotation; "
            f"reverse one axis or exchange two of its columns"
        )


def _largest_column(R: np.ndarray) -> np.ndarray:
    """Return unit quaternions of rotation matrices: the largest column of ``4 e e'``, sums of entries of R."""
    (a, b, c), (d, f, g), (h, i, j) = np.moveaxis(R, (-2, -1), (0, 1))
    products = np.array([
        [1.0 + a + f + j, i - g, c - h, d - b],
        [i - g, 1.0 + a - f - j, b + d, c + h],
        [c - h, b + d, 1.0 - a + f - j, g + i],
        [d - b, c + h, g + i, 1.0 - a - f + j],
    ])  # fmt: skip
    products = np.moveaxis(products, (0, 1), (-2, -1))
    largest = np.argmax(np.diagonal(products, axis1=-2, axis2=-1), axis=-1)
    column = np.take_along_axis(products, largest[..., None, None], axis=-1)[..., 0]
    column = np.where(column[..., :1] < 0.0, -column, column)
    return column / np.linalg.norm(column, axis=-1, keepdims=True)


def _text(values: np.ndarray) -> str:
    """Write numbers as a user would type them."""
    return np.array2string(values, separator=", ", precision=9).replace("\n", "")
