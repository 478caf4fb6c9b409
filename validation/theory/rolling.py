"""Steady rolling of a leaning disc on a circle."""

from typing import NamedTuple

import numpy as np

from validation.theory.common import GRAVITY


class RollingCircle(NamedTuple):
    """Steady circular rolling of a disc."""

    precession: float
    """Rate about the vertical, > 0 [rad/s]."""
    spin: float
    """Own rotation about the disc axis relative to the precessing frame, opposite in sign to the precession [rad/s]."""
    centre_radius: float
    """Radius of the circle of the disc centre [m]."""
    centre_height: float
    """[m]"""

    @property
    def period(self) -> float:
        """Time for one round [s]."""
        return 2 * np.pi / self.precession


def rolling_circle(
    mass: float, radius: float, transverse: float, axial: float, circle: float, lean: float, gravity: float = GRAVITY
) -> RollingCircle:
    """Thin disc rolling without slip on a horizontal circle, leaning inwards by a constant angle b.

    Moment of momentum about the centre of mass, with rho = R - r sin(b) and spin = -W R / r:
    ``W^2 (m r rho + C rho / r + A sin b) = m g r tan b``.

    Parameters
    ----------
    mass, radius : float
        Of the disc [kg], r [m].
    transverse, axial : float
        A (a diameter) and C (the axis) about the centre of mass [kg m^2].
    circle : float
        Radius R of the track of the contact point [m].
    lean : float
        Angle b of the disc plane from the vertical, 0 < b < pi/2 [rad].
    gravity : float
        [m/s^2].

    Returns
    -------
    RollingCircle
        Rates, radius and height of the disc centre.

    Raises
    ------
    ValueError
        If no such motion exists.
    """
    rho = circle - radius * np.sin(lean)
    inertia = mass * radius * rho + axial * rho / radius + transverse * np.sin(lean)
    if not 0 < lean < np.pi / 2 or inertia <= 0:
        raise ValueError(f"lean {lean} rad on a circle of {circle} m: lean inwards, by less than pi/2")
    precession = np.sqrt(mass * gravity * radius * np.tan(lean) / inertia)
    return RollingCircle(precession, -precession * circle / radius, rho, radius * np.cos(lean))
