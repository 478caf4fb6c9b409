"""Algebra of quaternions: products, exponential and logarithm, H(e); on stacks, scalar first."""

import numpy as np
from numpy.typing import ArrayLike


def multiply(p: ArrayLike, q: ArrayLike) -> np.ndarray:
    """Product of quaternions, ``matrix(multiply(p, q)) = matrix(p) matrix(q)``.

    ``p q = (p0 q0 - p_v'q_v, p0 q_v + q0 p_v + p_v x q_v)``

    Parameters
    ----------
    p, q : (..., 4) array_like
        Quaternions; leading dimensions are broadcast.

    Returns
    -------
    (..., 4) ndarray
        The product: first q, then p.

    Raises
    ------
    ValueError
        If a last dimension is not 4.
    """
    p, q = _stack(p, 4, "quaternion"), _stack(q, 4, "quaternion")
    p0, p_v, q0, q_v = p[..., :1], p[..., 1:], q[..., :1], q[..., 1:]
    scalar = p0 * q0 - np.sum(p_v * q_v, axis=-1, keepdims=True)
    return np.concatenate([scalar, p0 * q_v + q0 * p_v + np.cross(p_v, q_v)], axis=-1)


def conjugate(e: ArrayLike) -> np.ndarray:
    """Conjugate ``(e0, -e_v)``: the inverse rotation, world -> body.

    Parameters
    ----------
    e : (..., 4) array_like
        Quaternion.

    Returns
    -------
    (..., 4) ndarray
        Its conjugate.

    Raises
    ------
    ValueError
        If the last dimension is not 4.
    """
    return _stack(e, 4, "quaternion") * np.array([1.0, -1.0, -1.0, -1.0])


def exponential(theta: ArrayLike) -> np.ndarray:
    """Unit quaternion of a rotation vector: ``e = (cos(|theta|/2), sin(|theta|/2) theta/|theta|)``.

    Parameters
    ----------
    theta : (..., 3) array_like
        Axis times angle [rad]; exact for the smallest angles and for zero.

    Returns
    -------
    (..., 4) ndarray
        Unit quaternion.

    Raises
    ------
    ValueError
        If the last dimension is not 3.
    """
    theta = _stack(theta, 3, "rotation vector")
    half = 0.5 * np.linalg.norm(theta, axis=-1, keepdims=True)
    # numpy's sinc(x) is sin(pi x)/(pi x), and 1 at x = 0
    return np.concatenate([np.cos(half), 0.5 * np.sinc(half / np.pi) * theta], axis=-1)


def logarithm(e: ArrayLike) -> np.ndarray:
    """Shortest rotation vector of a quaternion, the inverse of `exponential` for ``|theta| <= pi``.

    ``theta = 2 atan2(|e_v|, e0) e_v/|e_v|`` after the sign of e is chosen such that e0 >= 0.

    Parameters
    ----------
    e : (..., 4) array_like
        Quaternion; its length does not matter.

    Returns
    -------
    (..., 3) ndarray
        Axis times angle [rad].

    Raises
    ------
    ValueError
        If the last dimension is not 4 or a quaternion is zero.
    """
    e = _nonzero_quaternion(e)
    e = np.where(e[..., :1] < 0.0, -e, e)
    scalar, vector = e[..., :1], e[..., 1:]
    norm = np.linalg.norm(vector, axis=-1, keepdims=True)
    # below the smallest normal number the norm is rounded to zero; there atan2(n, e0)/n is 1/e0
    small = norm < np.finfo(float).tiny
    factor = np.where(small, 1.0 / np.where(small, scalar, 1.0), np.arctan2(norm, scalar) / np.where(small, 1.0, norm))
    return 2.0 * factor * vector


def H(e: ArrayLike) -> np.ndarray:
    """Matrix of ``e_dot = H(e) omega / 2`` with omega in world axes: ``H = [-e_v' ; e0 1 - [e_v]x]``.

    Linear in e, so ``H_dot = H(e_dot)``; ``H'H = 1`` for unit quaternions.

    Parameters
    ----------
    e : (..., 4) array_like
        Quaternion, or its time derivative.

    Returns
    -------
    (..., 4, 3) ndarray
        H.

    Raises
    ------
    ValueError
        If the last dimension is not 4.
    """
    e = _stack(e, 4, "quaternion")
    lower = e[..., :1, None] * np.eye(3) - skew(e[..., 1:])
    return np.concatenate([-e[..., None, 1:], lower], axis=-2)


def skew(a: ArrayLike) -> np.ndarray:
    """Matrix of the cross product: ``skew(a) b = a x b``.

    Parameters
    ----------
    a : (..., 3) array_like
        Vector.

    Returns
    -------
    (..., 3, 3) ndarray
        ``[a]x``, antisymmetric.

    Raises
    ------
    ValueError
        If the last dimension is not 3.
    """
    a = _stack(a, 3, "vector")
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    out = np.zeros((*a.shape, 3))
    out[..., 0, 1], out[..., 0, 2], out[..., 1, 2] = -z, y, -x
    out[..., 1, 0], out[..., 2, 0], out[..., 2, 1] = z, -y, x
    return out


def _check_nonzero(square: float | np.ndarray) -> None:
    """Refuse quaternions whose squares are zero or not finite."""
    if not (0.0 < square < np.inf if isinstance(square, float) else np.all((square > 0.0) & np.isfinite(square))):
        raise ValueError("quaternion: one is zero or not finite and is no orientation; give unit quaternions")


def _nonzero_quaternion(e: ArrayLike) -> np.ndarray:
    """Stack of quaternions of which none is zero or contains NaN."""
    e = _stack(e, 4, "quaternion")
    _check_nonzero(np.sum(e * e, axis=-1))
    return e


def _stack(values: ArrayLike, length: int, what: str) -> np.ndarray:
    """Float array whose last dimension has the given length."""
    array = np.asarray(values, dtype=float)
    if array.ndim == 0 or array.shape[-1] != length:
        raise ValueError(f"{what}: shape {array.shape} is wrong; give (..., {length})")
    return array
