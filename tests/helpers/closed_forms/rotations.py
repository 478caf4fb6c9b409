"""Tops and free bodies in closed form, and the quaternion whose rate is frozen: what only tests ask."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from validation.theory import elliptic_phase, jacobi, polhode, quarter_period, rotation_matrix
from validation.theory.common import Array, Attitude, product, turn


def sleeping_spin(transverse: float, axial: float, weight_moment: float) -> float:
    """Least spin of a stable upright top, ``C^2 w3^2 = 4 A m g l``.

    ``transverse, axial``: A and C about the fixed point [kg m^2]; ``weight_moment``: m g l [N m]. Returns w3 [rad/s].
    """
    return 2 * np.sqrt(transverse * weight_moment) / axial


class Nutation(NamedTuple):
    """Height ``u = cos(tilt) = lowest + (highest - lowest) sn^2(rate t + phase)`` of a heavy symmetric top."""

    lowest: float
    highest: float
    third: float
    """Third root of the cubic, >= 1."""
    rate: float
    """[1/s]"""
    m1: float
    phase: float

    @property
    def period(self) -> float:
        """Time from one lowest point to the next, ``2 K / rate`` [s]."""
        return 2 * quarter_period(self.m1) / self.rate

    def height(self, t: ArrayLike) -> Array:
        """Cosine of the tilt at the times ``t`` [s]."""
        sn = jacobi(self.phase + self.rate * np.asarray(t, dtype=np.longdouble), self.m1).sn
        return (self.lowest + (self.highest - self.lowest) * sn**2).astype(float)


def nutation(
    transverse: float, axial: float, spin: float, weight_moment: float, tilt: float, tilt_rate: float, precession: float
) -> Nutation:
    """Nutation of a heavy symmetric top from its cubic.

    ``u_dot^2 = (alpha - beta u)(1 - u^2) - (b - a u)^2`` with ``a = C w3 / A``, ``b = a u0 + W sin^2(tilt)``,
    ``beta = 2 m g l / A``, ``alpha = tilt_rate^2 + W^2 sin^2(tilt) + beta u0``; ``rate^2 = beta (u3 - u1) / 4`` and
    ``m = (u2 - u1) / (u3 - u1)``.

    ``transverse, axial``: A and C about the fixed point [kg m^2]; ``spin``: axial component w3 of the angular velocity
    [rad/s]; ``weight_moment``: m g l > 0 [N m]; ``tilt, tilt_rate, precession``: angle of the axis from the vertical
    [rad], its rate and the precession W at t = 0 [rad/s]. Returns roots, rate and phase. ValueError if
    ``weight_moment`` is not positive.
    """
    if weight_moment <= 0:
        raise ValueError(f"weight_moment {weight_moment} of the top: must be positive (measure the tilt from the top)")
    start, sine = np.cos(tilt), np.sin(tilt)
    a, beta = axial * spin / transverse, 2 * weight_moment / transverse
    b, alpha = a * start + precession * sine**2, tilt_rate**2 + (precession * sine) ** 2 + beta * start
    cubic = [beta, -(alpha + a * a), 2 * a * b - beta, alpha - b * b]
    low, high, third = np.sort(np.roots(cubic).real)
    rate, m1 = np.sqrt(beta * (third - low)) / 2, (third - high) / (third - low)
    return Nutation(low, high, third, rate, m1, _nutation_phase(start, low, high, -sine * tilt_rate, m1))


def _nutation_phase(start: float, low: float, high: float, climb: float, m1: float) -> float:
    """Argument at t = 0; a start at rest is a turning point exactly, which rounded roots would miss by 1e-8."""
    if climb == 0.0:
        return quarter_period(m1) if high - start < start - low else 0.0
    share = np.clip((start - low) / (high - low), 0.0, 1.0)
    return elliptic_phase(np.copysign(np.sqrt(share), climb), np.sqrt(1 - share), m1)


def flip_interval(inertia: ArrayLike, omega: ArrayLike) -> float:
    """Time between two flips of the middle axis, ``2 K / lam``.

    ``inertia`` (3,): principal moments about the centre of mass, body axes [kg m^2]; ``omega`` (3,): angular velocity
    at any instant, body axes [rad/s]. Returns interval [s]; infinite on the separatrix and for a steady rotation.
    """
    curve = polhode(inertia, omega)
    return np.inf if curve is None else float(2 * quarter_period(float(curve.m1)) / curve.rate)


def free_symmetric_body(
    t: ArrayLike, transverse: float, axial: float, omega: ArrayLike, orientation: ArrayLike = (1, 0, 0, 0)
) -> Attitude:
    """Torque-free body with symmetry axis z: ``R = R_0 exp([L_0] t / A) exp([e_z] w_z (1 - C / A) t)``.

    ``t`` (n,): times [s]; ``transverse, axial``: A > 0 and C >= 0 about the centre of mass; C = 0 is a rod [kg m^2];
    ``omega`` (3,): angular velocity at t = 0, body axes [rad/s]; ``orientation`` (4,): quaternion at t = 0 [-]. Returns
    angular velocity (body axes) and rotation at ``t``. ValueError if ``transverse`` is not positive or ``axial`` is
    negative.
    """
    if transverse <= 0 or axial < 0:
        raise ValueError(f"moments ({transverse}, {axial}): transverse must be positive and axial not negative")
    t = np.atleast_1d(np.asarray(t, dtype=np.longdouble))
    omega = np.asarray(omega, dtype=np.longdouble)
    precession = np.array([omega[0], omega[1], axial * omega[2] / transverse], dtype=np.longdouble)
    spin = turn(
        np.array([0, 0, omega[2] * (1 - np.longdouble(axial) / np.longdouble(transverse))], dtype=np.longdouble), t
    )
    rotation = product(product(rotation_matrix(orientation), turn(precession, t)), spin)
    return Attitude(np.einsum("nji,j->ni", spin, omega), rotation)


def quaternion(rotation: ArrayLike) -> Array:
    """Unit quaternions of rotation matrices, sign such that the largest component is positive.

    The rows of ``4 e e'`` are sums of entries of R; the row with the largest diagonal is normalised.

    ``rotation`` (..., 3, 3): body to world [-]. Returns (..., 4): scalar first [-].
    """
    R = np.asarray(rotation)
    outer = np.empty(R.shape[:-2] + (4, 4), dtype=R.dtype)
    trace = np.trace(R, axis1=-2, axis2=-1)
    outer[..., 0, 0] = 1 + trace
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        outer[..., i + 1, i + 1] = 1 + 2 * R[..., i, i] - trace
        outer[..., 0, i + 1] = outer[..., i + 1, 0] = R[..., k, j] - R[..., j, k]
        outer[..., i + 1, j + 1] = outer[..., j + 1, i + 1] = R[..., i, j] + R[..., j, i]
    best = np.argmax(np.diagonal(outer, axis1=-2, axis2=-1), axis=-1)
    row = np.take_along_axis(outer, best[..., None, None], axis=-2)[..., 0, :]
    return row / np.sqrt(np.sum(row * row, axis=-1, keepdims=True))


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
