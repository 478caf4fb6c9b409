"""Angles, ratios and harmonics of universal joints, of one and of two."""

import numpy as np
from numpy.typing import ArrayLike

from validation.theory import cardan_rate
from validation.theory.common import Array
from validation.theory.one_freedom import _check_bend


def cardan_angle(angle: ArrayLike, bend: float) -> Array:
    """Output angle of a universal joint, ``tan(out) = cos(bend) tan(in)``, continuous over all turns.

    Both angles count from the pose where the arm of the cross carried by the **input** yoke is normal to the plane of
    the shafts; with that arm in the plane, add pi/2 to both.

    ``angle``: input angle [rad]; ``bend``: angle between the shafts, |bend| < pi/2 [rad]. Returns output angle [rad].
    ValueError if the shafts are bent by a right angle or more.
    """
    _check_bend(bend)
    s, c = np.sin(angle), np.cos(angle)
    # the lag stays between -pi/2 and pi/2, so no turn is ever lost
    return angle + np.arctan2((np.cos(bend) - 1) * s * c, c * c + np.cos(bend) * s * s)


def cardan_ratio(bend: float) -> float:
    """Greatest over least output rate, ``1 / cos^2(bend)``.

    ``bend``: angle between the shafts [rad]. Returns ratio [-].
    """
    _check_bend(bend)
    return 1 / np.cos(bend) ** 2


def cardan_harmonics(bend: float, count: int) -> Array:
    """Amplitudes of the output rate over its mean at 2, 4, ..., 2 count times shaft speed, ``2 tan^(2k)(bend / 2)``.

    ``cos(b) / (1 - sin^2(b) sin^2(x)) = 1 + 2 sum_k (-q)^k cos(2 k x)``, ``q = tan^2(b / 2)`` (Poisson kernel).

    ``bend``: angle b between the shafts [rad]; ``count``: number of harmonics. Returns (count,): amplitudes [-].
    """
    _check_bend(bend)
    return 2 * np.tan(bend / 2) ** (2 * np.arange(1, count + 1))


def double_cardan_ratio(angle: ArrayLike, first: float, second: float, phasing: float = 0.0) -> Array:
    """Output over input rate of two universal joints, the product of both ratios.

    ``angle``: input angle as in :func:`cardan_angle` [rad]; ``first, second``: bend of the two joints, Z or W
    arrangement alike [rad]; ``phasing``: angle by which the second yoke of the middle shaft is turned from the aligned
    pose, in which equal bends give 1 [rad]. Returns ratio [-].
    """
    middle = cardan_angle(angle, first) + np.pi / 2 + phasing
    return cardan_rate(angle, first) * cardan_rate(middle, second)
