"""A universal joint: rate and acceleration of its output, torque of the motor that keeps the input rate.

Angles count from the pose where the arm of the cross carried by the **input** yoke is normal to the plane of shafts;
with that arm in the plane, add pi/2.
"""

import numpy as np
from numpy.typing import ArrayLike

from validation.theory.common import Array


def cardan_rate(angle: ArrayLike, bend: float, rate: float = 1.0) -> Array:
    """Output rate of a universal joint, ``w cos(bend) / (1 - sin^2(bend) sin^2(in))``.

    ``angle``: input angle [rad]; ``bend``: angle between the shafts [rad]; ``rate``: input
    rate; 1 gives the transmission ratio [rad/s]. Returns output rate [rad/s].
    """
    _check_bend(bend)
    return rate * np.cos(bend) / (1 - (np.sin(bend) * np.sin(angle)) ** 2)


def cardan_acceleration(angle: ArrayLike, bend: float, rate: float, acceleration: float = 0.0) -> Array:
    """Output angular acceleration, ``i alpha + w^2 cos(b) sin^2(b) sin(2 in) / (1 - sin^2(b) sin^2(in))^2``.

    ``angle``: input angle [rad]; ``bend``: angle b between the shafts [rad];
    ``rate, acceleration``: input rate w [rad/s] and acceleration alpha [rad/s^2]; i is the ratio of
    :func:`cardan_rate`. Returns output acceleration [rad/s^2].
    """
    ratio = cardan_rate(angle, bend)
    return ratio * acceleration + rate**2 * ratio**2 * np.sin(bend) ** 2 * np.sin(2 * np.asarray(angle)) / np.cos(bend)


def cardan_motor_torque(angle: ArrayLike, bend: float, rate: float, inertia: float) -> Array:
    """Torque that keeps the input rate constant, from the power balance ``T w = I w_out alpha_out``.

    ``angle``: input angle [rad]; ``bend``: angle between the shafts [rad]; ``rate``: input
    rate w [rad/s]; ``inertia``: axial moment of inertia I of the output shaft [kg m^2]. Returns torque on the input
    shaft [N m].
    """
    return inertia * cardan_acceleration(angle, bend, rate) * cardan_rate(angle, bend)


def _check_bend(bend: float) -> None:
    """Refuse a universal joint that cannot turn."""
    if not abs(bend) < np.pi / 2:
        raise ValueError(f"bend {bend} rad of the universal joint: must stay below a right angle")
