"""Algebra of quaternions, scalar first: products, exponential and logarithm, H(e).

All functions take stacks: quaternions (..., 4) and vectors (..., 3), array_like, leading dimensions broadcast. Another
last dimension is a ValueError.
"""

import numpy as np
from numpy.typing import ArrayLike

from .checks import numbers
from .errors import InputError


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
    if not np.all((square > 0.0) & (square < np.inf)):
        raise InputError("quaternion: one is zero or not finite, not an orientation; give unit quaternions")


def _stack(values: ArrayLike, length: int, what: str) -> np.ndarray:
    """Return a float array whose last dimension has the given length."""
    array = numbers(values, what)
    if array.ndim == 0 or array.shape[-1] != length:
        raise InputError(f"{what}: shape {array.shape} is wrong; give (..., {length})")
    return array
