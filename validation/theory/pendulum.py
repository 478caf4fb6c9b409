"""Physical pendulum of any amplitude, and the force in the hinges of a body on a fixed axis."""

import numpy as np
from numpy.typing import ArrayLike

from validation.theory.common import EXTENDED, GRAVITY, Array
from validation.theory.elliptic import elliptic_phase, jacobi, quarter_period


def pendulum_frequency(inertia: float, mass: float, distance: float, gravity: float = GRAVITY) -> float:
    """Small-oscillation frequency of a physical pendulum, ``w0^2 = m g d / I``.

    ``inertia``: about the hinge axis [kg m^2]; ``mass, distance``: mass [kg] and distance of the centre of mass from
    the hinge axis [m]; ``gravity``: component of gravity normal to the hinge axis: g sin(angle between axis and
    vertical) [m/s^2]. Returns w0 [rad/s]. ValueError if an argument is negative or the inertia is zero.
    """
    if inertia <= 0 or min(mass, distance, gravity) < 0:
        raise ValueError(f"pendulum (inertia {inertia}, mass {mass}, distance {distance}): give positive values")
    return np.sqrt(mass * gravity * distance / inertia)


def pendulum_period(frequency: float, angle: float, rate: float = 0.0) -> float:
    """Period of a pendulum of any amplitude: full swing ``4 K(k^2) / w0``, or one turn ``2 K(1 / k^2) / (k w0)``.

    ``k^2 = sin^2(angle / 2) + (rate / 2 w0)^2``; k > 1 means that it goes over the top.

    ``frequency``: small-oscillation frequency w0 [rad/s]; ``angle, rate``: state at any instant, angle from the lowest
    position [rad], [rad/s]. Returns period [s].
    """
    k2, m1 = _pendulum_modulus(frequency, angle, rate)
    if k2 <= 1:
        return 4 * quarter_period(m1) / frequency
    return 2 * quarter_period(-m1 / k2) / (np.sqrt(k2) * frequency)


def pendulum_motion(t: ArrayLike, frequency: float, angle: float, rate: float = 0.0) -> tuple[Array, Array]:
    """Angle and rate of a physical pendulum from any start.

    Swinging (k <= 1): ``sin(phi / 2) = +-k sn(u | k^2)``, ``phi_dot = +-2 k w0 cn u``, ``u = w0 t + u0``.
    Turning (k > 1): ``phi = +-2 am(u | 1 / k^2)``, ``phi_dot = +-2 k w0 dn u``, ``u = k w0 t + u0``.

    ``t``: times [s]; ``frequency``: small-oscillation frequency w0 [rad/s]; ``angle, rate``: state at t = 0, angle from
    the lowest position [rad], [rad/s]. Returns angle, rate: [rad] (continuous over turns), [rad/s].
    """
    t = np.asarray(t, dtype=EXTENDED)
    k2, m1 = _pendulum_modulus(frequency, angle, rate)
    k, sense = np.sqrt(k2), np.copysign(1.0, rate)
    if k == 0:
        return np.zeros(t.shape), np.zeros(t.shape)
    if k2 <= 1:
        branch = 2 * np.pi * np.round(angle / (2 * np.pi))
        phase = elliptic_phase(sense * np.sin((angle - branch) / 2) / k, abs(rate) / (2 * frequency * k), m1)
        u = jacobi(phase + frequency * t, m1)
        swing = branch + sense * 2 * np.arcsin(np.clip(k * u.sn, -1, 1))
        return swing.astype(float), (sense * 2 * k * frequency * u.cn).astype(float)
    half, m1 = sense * angle / 2, -m1 / k2
    turns = np.round(half / np.pi)
    phase = elliptic_phase(np.sin(half - np.pi * turns), np.cos(half - np.pi * turns), m1)
    u = jacobi(phase + k * frequency * t, m1)
    return (sense * 2 * (u.am + np.pi * turns)).astype(float), (sense * 2 * k * frequency * u.dn).astype(float)


def _pendulum_modulus(frequency: float, angle: float, rate: float) -> tuple[float, float]:
    """k^2 and 1 - k^2 of a pendulum, each without the rounding of the other."""
    speed = (rate / (2 * frequency)) ** 2
    return np.sin(angle / 2) ** 2 + speed, np.cos(angle / 2) ** 2 - speed


def hinge_force(
    mass: float, arm: ArrayLike, axis: ArrayLike, rate: float, acceleration: float, gravity: ArrayLike
) -> Array:
    """Total force of its hinges on a body that turns about a fixed axis, ``m (alpha u x s + w^2 u x (u x s) - g)``.

    ``mass``: [kg]; ``arm`` (3,): s from any point of the axis to the centre of mass, world [m]; ``axis`` (3,): unit
    vector u, world [-]; ``rate, acceleration``: angular rate w [rad/s] and acceleration alpha about the axis [rad/s^2];
    ``gravity`` (3,): world [m/s^2]. Returns (3,): force, world [N].
    """
    side = np.cross(axis, arm)
    return mass * (acceleration * side + rate**2 * np.cross(axis, side) - np.asarray(gravity))
