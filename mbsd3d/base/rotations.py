"""Rotations as a user gives them, unit quaternions, rotation matrices, unit vectors and their perpendiculars.

A quaternion is ``e = (e0, e1, e2, e3) = (e0, e_v)``: scalar first, active, body -> world, so ``a_world = R(e) a_body``.
Functions of quaternions but `as_quaternion` work on stacks: any leading dimensions, the last ones hold the object.
"""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from .checks import floats, numbers, short_repr, vector
from .errors import InputError, checks_arguments

WORLD_AXES = np.eye(3)
WORLD_AXES.setflags(write=False)
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
DIRECTION_FORMS = "'x', 'y', 'z' or a vector of three numbers"
ORIENTATION_FORMS = "a unit quaternion (e0, e1, e2, e3), a 3x3 rotation matrix or rotation(axis, angle)"
NORM_ROUNDING = 1e-15  # [1] of the length 1; a vector that is closer to it is kept: normalising twice changes nothing
NORM_TOLERANCE = 1e-6  # [1] of the length 1: numbers typed with seven digits pass, a forgotten normalisation does not
PERPENDICULAR_TOLERANCE = 1e-6  # [1] cosine of an angle that is meant to be right


@checks_arguments
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
        return _quaternion_of_one(values, what)
    if values.shape != (4,):
        raise InputError(f"{what}: shape {values.shape} is not an orientation; give {ORIENTATION_FORMS}")
    norm = math.sqrt(values @ values)
    if abs(norm - 1.0) > NORM_TOLERANCE:
        raise InputError(
            f"{what}: the quaternion {_text(values)} has norm {norm:.9g} instead of 1; "
            f"give rotations.normalize(e) if its direction is right, or rotation(axis, angle)"
        )
    return values if abs(norm - 1.0) < NORM_ROUNDING else values / norm


@checks_arguments
def normalize(e: ArrayLike) -> np.ndarray:
    """Return the unit quaternion e / |e| of e (..., 4), as of one read from a file with four digits.

    ValueError for zero length, another shape or a number that is not finite.

    >>> normalize((0.7, 0.0, 0.7, 0.0)).round(6)
    array([0.707107, 0.      , 0.707107, 0.      ])
    """
    e = _stack(e, 4, "quaternion")
    square = (e * e).sum(axis=-1, keepdims=True)
    _check_nonzero(square)
    return e / np.sqrt(square)


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
    if isinstance(axis, str):
        return np.array(_letter_axis(axis, "rotation: axis"))
    vector = floats(axis, "rotation: axis", DIRECTION_FORMS)
    if vector.shape != (3,):
        raise InputError(f"rotation: axis has shape {vector.shape}; give {DIRECTION_FORMS}")
    largest = np.max(np.abs(vector))
    if largest == 0.0:
        raise InputError("rotation: axis has zero length, its direction is undefined; give a vector that is not zero")
    vector = vector / largest  # first to order 1, so that the squares cannot underflow or overflow
    return vector / np.linalg.norm(vector)


def by_letter(axis: str | ArrayLike, what: str) -> ArrayLike:
    """Return the unit vector of "x", "y" or "z", and what is not a text as it is."""
    return np.array(_letter_axis(axis, what)) if isinstance(axis, str) else axis


def _letter_axis(letter: str, what: str) -> tuple[float, float, float]:
    """Return the axis of a letter."""
    if letter not in AXES:
        raise InputError(f"{what} is {short_repr(letter)}; give {DIRECTION_FORMS}")
    return AXES[letter]


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


def _quaternion_of_one(R: np.ndarray, what: str) -> np.ndarray:
    """Return the unit quaternion (4,) of one matrix (3, 3) as `_largest_column` does, or refuse it; in plain numbers.

    Small arrays would take ten times as long, and a cell of a sweep makes many.
    """
    (a, b, c), (d, f, g), (h, i, j) = R.tolist()
    lengths = abs(a * a + d * d + h * h - 1.0), abs(b * b + f * f + i * i - 1.0), abs(c * c + g * g + j * j - 1.0)
    cosines = abs(a * b + d * f + h * i), abs(a * c + d * g + h * j), abs(b * c + f * g + i * j)
    determinant = a * (f * j - g * i) - b * (d * j - g * h) + c * (d * i - f * h)
    if not (max(*lengths, *cosines) <= NORM_TOLERANCE and determinant > 0.0):
        _check_rotation(R, what)
    squares = 1.0 + a + f + j, 1.0 + a - f - j, 1.0 - a + f - j, 1.0 - a - f + j
    k = squares.index(max(squares))
    column = (
        (squares[0], i - g, c - h, d - b),
        (i - g, squares[1], b + d, c + h),
        (c - h, b + d, squares[2], g + i),
        (d - b, c + h, g + i, squares[3]),
    )[k]
    norm = math.hypot(*column) if column[0] >= 0.0 else -math.hypot(*column)
    return np.array([x / norm for x in column])


def _text(values: np.ndarray) -> str:
    """Write numbers as a user would type them."""
    return np.array2string(values, separator=", ", precision=9).replace("\n", "")


def multiply(p: ArrayLike, q: ArrayLike) -> np.ndarray:
    """Return p q (..., 4), first q, then p: ``matrix(multiply(p, q)) = matrix(p) matrix(q)``.

    ``p q = (p0 q0 - p_v'q_v, p0 q_v + q0 p_v + p_v x q_v)``
    """
    p, q = _stack(p, 4, "quaternion"), _stack(q, 4, "quaternion")
    p0, p_v, q0, q_v = p[..., :1], p[..., 1:], q[..., :1], q[..., 1:]
    scalar = p0 * q0 - np.sum(p_v * q_v, axis=-1, keepdims=True)
    (p1, p2, p3), (q1, q2, q3) = ((x[..., 1], x[..., 2], x[..., 3]) for x in (p, q))
    across = np.stack([p2 * q3 - p3 * q2, p3 * q1 - p1 * q3, p1 * q2 - p2 * q1], axis=-1)  # faster than np.cross
    return np.concatenate([scalar, p0 * q_v + q0 * p_v + across], axis=-1)


def conjugate(e: ArrayLike) -> np.ndarray:
    """Return the conjugate ``(e0, -e_v)`` (..., 4): the inverse rotation, world -> body."""
    return _stack(e, 4, "quaternion") * np.array([1.0, -1.0, -1.0, -1.0])


def exponential(theta: ArrayLike) -> np.ndarray:
    """Return the quaternion (..., 4) of a rotation vector [rad]: ``(cos(|theta|/2), sin(|theta|/2) theta/|theta|)``.

    Exact for the smallest angles and for zero.
    """
    theta = _stack(theta, 3, "rotation vector")
    half = 0.5 * np.linalg.norm(theta, axis=-1, keepdims=True)
    # numpy's sinc(x) is sin(pi x)/(pi x), and 1 at x = 0
    return np.concatenate([np.cos(half), 0.5 * np.sinc(half / np.pi) * theta], axis=-1)


def logarithm(e: ArrayLike) -> np.ndarray:
    """Return the shortest rotation vector (..., 3) [rad] of a quaternion of any length, the inverse of `exponential`.

    ``theta = 2 atan2(|e_v|, e0) e_v/|e_v|`` with the sign of e chosen such that e0 >= 0; zero is a ValueError.
    """
    e = _stack(e, 4, "quaternion")
    _check_nonzero(np.sum(e * e, axis=-1))
    e = np.where(e[..., :1] < 0.0, -e, e)
    scalar, vector = e[..., :1], e[..., 1:]
    norm = np.linalg.norm(vector, axis=-1, keepdims=True)
    # below the smallest normal number the norm is rounded to zero; there atan2(n, e0)/n is 1/e0
    small = norm < np.finfo(float).tiny
    factor = np.where(small, 1.0 / np.where(small, scalar, 1.0), np.arctan2(norm, scalar) / np.where(small, 1.0, norm))
    return 2.0 * factor * vector


def H(e: ArrayLike) -> np.ndarray:
    """Return H (..., 4, 3) of ``e_dot = H(e) omega / 2``, omega in world axes: ``H = [-e_v' ; e0 1 - [e_v]x]``.

    Linear in e, so ``H_dot = H(e_dot)``; ``H'H = 1`` for unit quaternions.
    """
    e = _stack(e, 4, "quaternion")
    lower = e[..., :1, None] * np.eye(3) - skew(e[..., 1:])
    return np.concatenate([-e[..., None, 1:], lower], axis=-2)


def skew(a: ArrayLike) -> np.ndarray:
    """Return ``[a]x`` (..., 3, 3), the matrix of the cross product: ``skew(a) b = a x b``."""
    a = _stack(a, 3, "vector")
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    out = np.zeros((*a.shape, 3))
    out[..., 0, 1], out[..., 0, 2], out[..., 1, 2] = -z, y, -x
    out[..., 1, 0], out[..., 2, 0], out[..., 2, 1] = z, -y, x
    return out


def _check_nonzero(square: float | np.ndarray) -> None:
    """Refuse quaternions whose squares are zero or not finite."""
    if not (0.0 < square < math.inf if isinstance(square, float) else np.all((square > 0.0) & (square < np.inf))):
        raise InputError("quaternion: one is zero or not finite, not an orientation; give unit quaternions")


def _stack(values: ArrayLike, length: int, what: str) -> np.ndarray:
    """Return a float array whose last dimension has the given length."""
    array = numbers(values, what)
    if array.ndim == 0 or array.shape[-1] != length:
        raise InputError(f"{what}: shape {array.shape} is wrong; give (..., {length})")
    return array


def unit(value: str | ArrayLike, what: str) -> np.ndarray:
    """Return a (3,) unit vector along ``value``, "x", "y", "z" or three numbers; a unit vector is kept.

    ValueError for another letter and for zero length.
    """
    if isinstance(value, str):
        return np.array(_letter_axis(value, what))
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
    """Return the cross product of two (3,) vectors; np.cross takes twenty times as long."""
    (x, y, z), (u, v, w) = a.tolist(), b.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


def crosses(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the cross product a x b of stacks (..., 3)."""
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[..., i] = a[..., j] * b[..., k] - a[..., k] * b[..., j]
    return out


def make_perpendicular(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the unit vector y, perpendicular to x where it is so to 1e-6, as typed digits are; y itself elsewhere."""
    off = float(x @ y)
    if not NORM_ROUNDING < abs(off) <= PERPENDICULAR_TOLERANCE:
        return y
    y = y - off * x
    return y / np.sqrt(y @ y)


def perpendiculars(axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return x and y, read-only, with (x, y, axis) right-handed and orthonormal; axis (3,) is a unit vector."""
    found = CARRIED.get()
    return _perpendiculars(np.asarray(axis, float).tobytes()) if found is None else found.next_to(axis)


class Carried:
    """Perpendiculars that follow their axes smoothly while a computation is repeated with other numbers.

    Within `again`, call k takes what call k of the first time found, turned off the new axis. Otherwise each takes the
    world axis that is least along the axis, and so jumps where that becomes another one.
    """

    def __init__(self) -> None:
        self.known: list[np.ndarray] = []
        self.calls: Iterator[np.ndarray] | None = None

    @contextmanager
    def again(self) -> Iterator[None]:
        """Note the perpendiculars that are made within the block or, from the second time on, take those."""
        self.calls = iter(self.known) if self.known else None
        before = CARRIED.set(self)
        try:
            yield
        finally:
            CARRIED.reset(before)

    def next_to(self, axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return what the next call gets."""
        z = np.array(axis, float)
        known = None if self.calls is None else next(self.calls, None)
        if known is None:
            found = _perpendiculars(z.tobytes())
            if self.calls is None:
                self.known.append(found[0])
            return found
        return _beside(known, z)


CARRIED: ContextVar[Carried | None] = ContextVar("perpendiculars that are carried along", default=None)


@lru_cache(maxsize=1024)
def _perpendiculars(axis: bytes) -> tuple[np.ndarray, np.ndarray]:
    """Return the perpendiculars, read-only, of an axis by its bytes: parts of a mechanism share few axes."""
    z = np.frombuffer(axis)
    size = [abs(a) for a in z.tolist()]
    x = cross(z, WORLD_AXES[size.index(min(size))])
    x /= math.sqrt(x @ x)
    y = cross(z, x)
    x.setflags(write=False)
    y.setflags(write=False)
    return x, y


def matched_perpendiculars(axis: np.ndarray, axis_b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the perpendiculars of axis_b, read-only, that are nearest to those of axis."""
    if CARRIED.get() is not None:
        return _beside(perpendiculars(axis)[0], np.asarray(axis_b, float))
    return _matched_perpendiculars(np.asarray(axis, float).tobytes(), np.asarray(axis_b, float).tobytes())


@lru_cache(maxsize=1024)
def _matched_perpendiculars(axis: bytes, axis_b: bytes) -> tuple[np.ndarray, np.ndarray]:
    """Return them, read-only, by the bytes of both axes."""
    return _beside(_perpendiculars(axis)[0], np.frombuffer(axis_b))


def _beside(x: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the perpendiculars of z, read-only, that are nearest to x."""
    x = x - z * (x @ z)
    x /= math.sqrt(x @ x)
    y = cross(z, x)
    x.setflags(write=False)
    y.setflags(write=False)
    return x, y
