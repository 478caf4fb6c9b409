"""Slider on an arm that turns at a constant rate."""

import numpy as np
from numpy.typing import ArrayLike

from validation.theory.common import Array


def arm_slider(t: ArrayLike, rate: float, radius: float, speed: float = 0.0) -> tuple[Array, Array]:
    """Free slider on an arm turning at a constant rate: ``r = r0 cosh(w t) + (v0 / w) sinh(w t)``.

    Parameters
    ----------
    t : array_like
        Times [s].
    rate : float
        Rate w of the arm, not zero [rad/s].
    radius, speed : float
        Distance from the axis [m] and radial speed at t = 0 [m/s].

    Returns
    -------
    radius, speed : ndarray
        [m], [m/s].
    """
    c, s = np.cosh(rate * np.asarray(t)), np.sinh(rate * np.asarray(t))
    return radius * c + speed / rate * s, radius * rate * s + speed * c


def arm_slider_torque(mass: float, rate: float, radius: ArrayLike, speed: ArrayLike) -> Array:
    """Coriolis torque that keeps the rate of the arm, ``2 m w r r_dot``.

    Parameters
    ----------
    mass, rate : float
        Slider mass [kg] and rate w of the arm [rad/s].
    radius, speed : array_like
        Distance from the axis [m] and radial speed [m/s].

    Returns
    -------
    ndarray
        Motor torque on the arm [N m].
    """
    return 2 * mass * rate * np.asarray(radius) * np.asarray(speed)
