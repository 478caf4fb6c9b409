"""What a constant rate does: to a slider on an arm that turns, and to a quaternion whose rate is frozen."""

import numpy as np
from numpy.typing import ArrayLike

from validation.theory.common import Array


def arm_slider(t: ArrayLike, rate: float, radius: float, speed: float = 0.0) -> tuple[Array, Array]:
    """Free slider on an arm turning at a constant rate: ``r = r0 cosh(w t) + (v0 / w) sinh(w t)``.

    ``t``: times [s]; ``rate``: rate w of the arm, not zero [rad/s]; ``radius, speed``: distance from the axis [m] and
    radial speed at t = 0 [m/s]. Returns radius, speed: [m], [m/s].
    """
    c, s = np.cosh(rate * np.asarray(t)), np.sinh(rate * np.asarray(t))
    return radius * c + speed / rate * s, radius * rate * s + speed * c


def arm_slider_torque(mass: float, rate: float, radius: ArrayLike, speed: ArrayLike) -> Array:
    """Coriolis torque that keeps the rate of the arm, ``2 m w r r_dot``.

    ``mass, rate``: slider mass [kg] and rate w of the arm [rad/s]; ``radius, speed``: distance from the axis [m] and
    radial speed [m/s]. Returns motor torque on the arm [N m].
    """
    return 2 * mass * rate * np.asarray(radius) * np.asarray(speed)


def ghost_quaternion(t: ArrayLike, omega: ArrayLike) -> Array:
    """What a quaternion becomes if its rate is frozen: ``e = 1 + t e_dot(0) = (1, w t / 2)``.

    ``t`` (n,): times [s]; ``omega`` (3,): angular velocity [rad/s]. Returns (n, 4): not of unit length [-].
    """
    t = np.atleast_1d(np.asarray(t, dtype=float))
    return np.concatenate([np.ones((len(t), 1)), t[:, None] * np.asarray(omega, dtype=float) / 2], axis=1)


def ghost_angle(turns: ArrayLike) -> Array:
    """Rotation angle of the frozen quaternion, ``2 atan(pi turns)``: it never passes pi.

    ``turns``: true revolutions [-]. Returns angle [rad].
    """
    return 2 * np.arctan(np.pi * np.asarray(turns))


def ghost_norm(turns: ArrayLike) -> Array:
    """Length of the frozen quaternion, ``sqrt(1 + (pi turns)^2)``.

    ``turns``: true revolutions [-]. Returns length, 1 for a rotation [-].
    """
    return np.hypot(1.0, np.pi * np.asarray(turns))
