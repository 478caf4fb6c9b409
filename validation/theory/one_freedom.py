"""Mechanisms with one degree of freedom: a physical pendulum, a slider on an arm of constant rate, a universal joint.

Angles of the universal joint count from the pose where the arm of the cross carried by the **input** yoke is normal to
the plane of the shafts; with that arm in the plane, add pi/2.
"""

import numpy as np
from numpy.typing import ArrayLike

from validation.theory.common import EXTENDED, GRAVITY, Array, elliptic_phase, jacobi


def pendulum_frequency(inertia: float, mass: float, distance: float, gravity: float = GRAVITY) -> float:
    """Return the small-oscillation frequency of a physical pendulum, ``w0^2 = m g d / I``.

    ``inertia``: about the hinge axis [kg m^2]; ``mass, distance``: mass [kg] and distance of the centre of mass from
    the hinge axis [m]; ``gravity``: component of gravity normal to the hinge axis: g sin(angle between axis and
    vertical) [m/s^2]. Returns w0 [rad/s]. ValueError if an argument is negative or the inertia is zero.
    """
    if inertia <= 0 or min(mass, distance, gravity) < 0:
        raise ValueError(f"pendulum (inertia {inertia}, mass {mass}, distance {distance}): give positive values")
    return np.sqrt(mass * gravity * distance / inertia)


def pendulum_motion(t: ArrayLike, frequency: float, angle: float, rate: float = 0.0) -> tuple[Array, Array]:
    """Return the angle and rate of a physical pendulum from any start.

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
    """Return k^2 and 1 - k^2 of a pendulum, each without the rounding of the other."""
    speed = (rate / (2 * frequency)) ** 2
    return np.sin(angle / 2) ** 2 + speed, np.cos(angle / 2) ** 2 - speed


def arm_slider(t: ArrayLike, rate: float, radius: float, speed: float = 0.0) -> tuple[Array, Array]:
    """Return the position of a free slider on an arm of constant rate: ``r = r0 cosh(w t) + (v0 / w) sinh(w t)`` [m].

    ``t``: times [s]; ``rate``: rate w of the arm, not zero [rad/s]; ``radius, speed``: distance from the axis [m] and
    radial speed at t = 0 [m/s]. Returns radius, speed: [m], [m/s].
    """
    c, s = np.cosh(rate * np.asarray(t)), np.sinh(rate * np.asarray(t))
    return radius * c + speed / rate * s, radius * rate * s + speed * c


def arm_slider_torque(mass: float, rate: float, radius: ArrayLike, speed: ArrayLike) -> Array:
    """Return the Coriolis torque that keeps the rate of the arm, ``2 m w r r_dot``.

    ``mass, rate``: slider mass [kg] and rate w of the arm [rad/s]; ``radius, speed``: distance from the axis [m] and
    radial speed [m/s]. Returns motor torque on the arm [N m].
    """
    return 2 * mass * rate * np.asarray(radius) * np.asarray(speed)


def cardan_rate(angle: ArrayLike, bend: float, rate: float = 1.0) -> Array:
    """Return the output rate of a universal joint, ``w cos(bend) / (1 - sin^2(bend) sin^2(in))``.

    ``angle``: input angle [rad]; ``bend``: angle between the shafts [rad]; ``rate``: input
    rate; 1 gives the transmission ratio [rad/s]. Returns output rate [rad/s].
    """
    _check_bend(bend)
    return rate * np.cos(bend) / (1 - (np.sin(bend) * np.sin(angle)) ** 2)


def cardan_acceleration(angle: ArrayLike, bend: float, rate: float, acceleration: float = 0.0) -> Array:
    """Return the output angular acceleration, ``i alpha + w^2 cos(b) sin^2(b) sin(2 in) / (1 - sin^2(b) sin^2(in))^2``.

    ``angle``: input angle [rad]; ``bend``: angle b between the shafts [rad];
    ``rate, acceleration``: input rate w [rad/s] and acceleration alpha [rad/s^2]; i is the ratio of
    :func:`cardan_rate`. Returns output acceleration [rad/s^2].
    """
    ratio = cardan_rate(angle, bend)
    return ratio * acceleration + rate**2 * ratio**2 * np.sin(bend) ** 2 * np.sin(2 * np.asarray(angle)) / np.cos(bend)


def cardan_motor_torque(angle: ArrayLike, bend: float, rate: float, inertia: float) -> Array:
    """Return the torque that keeps the input rate constant, from the power balance ``T w = I w_out alpha_out``.

    ``angle``: input angle [rad]; ``bend``: angle between the shafts [rad]; ``rate``: input
    rate w [rad/s]; ``inertia``: axial moment of inertia I of the output shaft [kg m^2]. Returns torque on the input
    shaft [N m].
    """
    return inertia * cardan_acceleration(angle, bend, rate) * cardan_rate(angle, bend)


def _check_bend(bend: float) -> None:
    """Raise ValueError for a universal joint that cannot turn."""
    if not abs(bend) < np.pi / 2:
        raise ValueError(f"bend {bend} rad of the universal joint: must stay below a right angle")
