"""What a quaternion becomes whose rate is frozen at the start."""

import numpy as np
from numpy.typing import ArrayLike

from validation.theory.common import Array


def ghost_quaternion(t: ArrayLike, omega: ArrayLike) -> Array:
    """What a quaternion becomes if its rate is frozen: ``e = 1 + t e_dot(0) = (1, w t / 2)``.

    Parameters
    ----------
    t : (n,) array_like
        Times [s].
    omega : (3,) array_like
        Angular velocity [rad/s].

    Returns
    -------
    (n, 4) ndarray
        Not of unit length [-].
    """
    t = np.atleast_1d(np.asarray(t, dtype=float))
    return np.concatenate([np.ones((len(t), 1)), t[:, None] * np.asarray(omega, dtype=float) / 2], axis=1)


def ghost_angle(turns: ArrayLike) -> Array:
    """Rotation angle of the frozen quaternion, ``2 atan(pi turns)``: it never passes pi.

    Parameters
    ----------
    turns : array_like
        True revolutions [-].

    Returns
    -------
    ndarray
        Angle [rad].
    """
    return 2 * np.arctan(np.pi * np.asarray(turns))


def ghost_norm(turns: ArrayLike) -> Array:
    """Length of the frozen quaternion, ``sqrt(1 + (pi turns)^2)``.

    Parameters
    ----------
    turns : array_like
        True revolutions [-].

    Returns
    -------
    ndarray
        Length, 1 for a rotation [-].
    """
    return np.hypot(1.0, np.pi * np.asarray(turns))
