"""Torque-free rotation of any body."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import elliprj

from validation.theory.common import (
    EXTENDED,
    Array,
    Attitude,
    Jacobi,
    elliptic_phase,
    jacobi,
    product,
    quarter_period,
    rotation_matrix,
    turn,
)


class Polhode(NamedTuple):
    """Constants of torque-free rotation in axes (p, m, q): q is the axis the polhode surrounds, m the middle one."""

    axes: Array  # Rows are the unit vectors of (p, m, q) in body axes, right-handed, (3, 3)
    moments: Array  # (I_p, I_m, I_q) [kg m^2]
    amplitudes: Array  # Signed amplitudes of (cn, sn, dn) [rad/s]
    rate: float  # Argument of the elliptic functions per second, lam [1/s]
    m1: float
    phase: float  # Argument at t = 0 [-]
    momentum: float  # Length of the angular momentum [N m s]


def polhode(inertia: ArrayLike, omega: ArrayLike) -> Polhode | None:
    """Return the constants of the torque-free motion through ``omega``, or None for a steady rotation.

    ``w = (a_p cn u, a_m sn u, a_q dn u)``, ``u = lam t + u0``, with
    ``a_p^2 = (2 T I_q - L^2) / (I_p (I_q - I_p))``, ``a_m^2 = (2 T I_q - L^2) / (I_m (I_q - I_m))``,
    ``a_q^2 = (L^2 - 2 T I_p) / (I_q (I_q - I_p))``, ``lam^2 = (I_q - I_m) (L^2 - 2 T I_p) / (I_p I_m I_q)`` and
    ``m1 = (I_q - I_p) (L^2 - 2 T I_m) / ((I_q - I_m) (L^2 - 2 T I_p))``. Each bracket is a sum over squared rates, so
    no digits cancel: ``2 T I_q - L^2 = I_p (I_q - I_p) w_p^2 + I_m (I_q - I_m) w_m^2``, and so on. q is the axis of
    largest moment if ``L^2 >= 2 T I_m``, else the axis of the smallest.

    ``inertia`` (3,): principal moments about the centre of mass, body axes [kg m^2]; ``omega`` (3,): angular velocity
    at t = 0, body axes [rad/s]. Returns None if ``w x I w = 0``: the body then turns steadily. ValueError if a moment
    is not positive.
    """
    inertia, omega = np.asarray(inertia, dtype=EXTENDED), np.asarray(omega, dtype=EXTENDED)
    if inertia.shape != (3,) or np.any(inertia <= 0):
        raise ValueError(f"inertia {inertia}: give three positive principal moments in body axes")
    if not np.any(np.cross(omega, inertia * omega)):
        return None
    axes = _polhode_axes(inertia, omega)
    (ip, im, iq), (wp, wm, wq) = np.abs(axes) @ inertia, axes @ omega
    near_p = ip * (iq - ip) * wp**2 + im * (iq - im) * wm**2
    near_q = im * (im - ip) * wm**2 + iq * (iq - ip) * wq**2
    gap = ip * (ip - im) * wp**2 + iq * (iq - im) * wq**2
    rate = np.sqrt((iq - im) * near_q / (ip * im * iq))
    m1 = np.clip((iq - ip) * gap / ((iq - im) * near_q), 0, 1)
    # with the signs of p and q from the start, cn and dn begin positive; Euler's equations then fix the sign of m
    ap = np.copysign(np.sqrt(near_p / (ip * (iq - ip))), wp)
    aq = np.copysign(np.sqrt(near_q / (iq * (iq - ip))), wq)
    am = np.copysign(np.sqrt(near_p / (im * (iq - im))), ap * aq * (iq - im))
    phase = elliptic_phase(wm / am, wp / ap, m1)
    momentum = np.sqrt(np.sum((inertia * omega) ** 2))
    return Polhode(axes, np.array([ip, im, iq]), np.array([ap, am, aq]), rate, m1, phase, momentum)


def _polhode_axes(inertia: Array, omega: Array) -> Array:
    """Return right-handed axes (p, m, q) of the polhode, rows in body axes, (3, 3)."""
    low, middle, high = np.argsort(inertia, kind="stable")
    # L^2 - 2 T I_m decides which axis the polhode surrounds
    excess = np.sum(inertia * (inertia - inertia[middle]) * omega**2)
    p, q = (low, high) if excess >= 0 else (high, low)
    axes = np.zeros((3, 3), dtype=EXTENDED)
    axes[0, p] = axes[2, q] = 1
    axes[1] = np.cross(axes[2], axes[0])
    return axes


def free_body(t: ArrayLike, inertia: ArrayLike, omega: ArrayLike, orientation: ArrayLike = (1, 0, 0, 0)) -> Attitude:
    """Compute torque-free rotation of any body from any start: elliptic functions and integrals of the third kind.

    Angular velocity as in :func:`polhode`. With l the direction of the angular momentum in axes (p, m, q), the body
    has ``R = R_L R_z(phi) R_x(theta) R_z(psi)``, ``l = (sin theta sin psi, sin theta cos psi, cos theta)``, and
    precesses about the angular momentum by

        phi = L t / I_q + L (I_q - I_p) / (I_p I_q lam) [Pi(u) - Pi(u0)],
        Pi(u) = integral of du / (1 + n sn^2 u),  n = I_q (I_m - I_p) / (I_p (I_q - I_m)) > 0.

    ``t`` (n,): times [s]; ``inertia`` (3,): principal moments about the centre of mass, body axes [kg m^2]; ``omega``
    (3,): angular velocity at t = 0, **body** axes [rad/s]; ``orientation`` (4,): quaternion at t = 0, body to world
    [-]. Returns angular velocity (body axes) and rotation at ``t``. ValueError if a moment is not positive.
    """
    t = np.atleast_1d(np.asarray(t, dtype=EXTENDED))
    start = rotation_matrix(orientation)
    curve = polhode(inertia, omega)
    if curve is None:
        steady = np.asarray(omega, dtype=EXTENDED)
        return Attitude(np.tile(steady, (len(t), 1)), product(start, turn(steady, t)))
    u = jacobi(curve.phase + curve.rate * t, curve.m1)
    rates = curve.amplitudes * np.stack([u.cn, u.sn, u.dn], axis=-1)
    origin = jacobi(curve.phase, curve.m1)
    ip, _, iq = curve.moments
    gain = curve.momentum * (iq - ip) / (ip * iq * curve.rate)
    angle = curve.momentum * t / iq + gain * (_third_kind(u, curve) - _third_kind(origin, curve))
    first = curve.amplitudes * np.stack([origin.cn, origin.sn, origin.dn])
    frame = _momentum_frame(np.zeros((), EXTENDED), first, curve)
    to_world = product(start, product(curve.axes.T, frame.T))
    rotation = product(product(to_world, _momentum_frame(angle, rates, curve)), curve.axes)
    return Attitude(product(rates[:, None, :], curve.axes)[:, 0, :], rotation)


def _third_kind(u: Jacobi, curve: Polhode) -> Array:
    """Return the integral of du / (1 + n sn^2 u) from 0, ``rest - n sn^3 R_J(cn^2, dn^2, 1, 1 + n sn^2) / 3`` plus
    whole turns.
    """
    ip, im, iq = curve.moments
    n = float(iq * (im - ip) / (ip * (iq - im)))
    sine = np.where(u.turns % 2 == 0, u.sn, -u.sn).astype(float)
    carlson = elliprj(u.cn.astype(float) ** 2, u.dn.astype(float) ** 2, 1.0, 1 + n * sine**2)
    part = u.rest - n * sine**3 * carlson / 3
    if curve.m1 == 0:
        return part
    whole = quarter_period(float(curve.m1)) - n * elliprj(0.0, float(curve.m1), 1.0, 1 + n) / 3
    return part + 2 * u.turns * whole


def _momentum_frame(angle: Array, rates: Array, curve: Polhode) -> Array:
    """Return R_z(phi) R_x(theta) R_z(psi) from the angle phi (n,) and the rates in axes (p, m, q) (n, 3), shape (n, 3,
    3).
    """
    lead = curve.moments * rates / curve.momentum
    tilt = np.hypot(lead[..., 0], lead[..., 1])
    sine, cosine, zero = lead[..., 0] / tilt, lead[..., 1] / tilt, np.zeros_like(tilt)
    node = np.stack([cosine, -sine, zero], axis=-1)
    normal = np.stack([lead[..., 2] * sine, lead[..., 2] * cosine, -tilt], axis=-1)
    c, s = np.cos(angle)[..., None], np.sin(angle)[..., None]
    return np.stack([c * node - s * normal, s * node + c * normal, lead], axis=-2)
