"""Closed forms of rigid-body mechanics, independent of the package they judge.

Nothing here imports ``mbsd3d``: every function is a formula of its docstring, or a series carried further than double
precision. SI units, radians; world axes have z up; quaternions are (e0, e1, e2, e3), scalar first, body to world.

Symbols used below: ``I_p, I_m, I_q`` principal moments about the centre of mass, ``w`` angular velocity in body axes,
``L`` angular momentum, ``T`` kinetic energy, ``m`` the parameter of elliptic functions (modulus squared) and
``m1 = 1 - m`` its complement. Elliptic functions take ``m1``, because near a separatrix ``m`` rounds to 1 and takes
all digits of the period with it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ellipe, elliprf, elliprj

Array = NDArray[np.floating]

GRAVITY = 9.81
"""Acceleration of free fall used when none is given [m/s^2]."""

EXTENDED = np.longdouble
"""80-bit floats where the machine has them (64-bit elsewhere: results then lose about three digits)."""

TAYLOR_ORDER = 26
TAYLOR_TOLERANCE = 1e-21


def quarter_period(m1: float) -> float:
    """Complete elliptic integral ``K = R_F(0, m1, 1)``, infinite for ``m1 = 0``.

    Parameters
    ----------
    m1 : float
        Complement ``1 - m`` of the parameter, 0 <= m1 <= 1 [-].

    Returns
    -------
    float
        K [-].

    Raises
    ------
    ValueError
        If ``m1`` is outside [0, 1].
    """
    if not 0.0 <= m1 <= 1.0:
        raise ValueError(f"elliptic parameter m1 = {m1}: must lie in [0, 1] (m1 is 1 - m)")
    return np.inf if m1 == 0.0 else float(elliprf(0.0, float(m1), 1.0))


def elliptic_phase(sine: float, cosine: float, m1: float) -> float:
    """Argument u in [-K, K] with ``sn u = sine`` and ``cn u = cosine >= 0``.

    ``u = s R_F(c^2, c^2 + m1 s^2, 1)``. Taking sine *and* cosine keeps the digits near u = K that an angle would lose.

    Parameters
    ----------
    sine, cosine : float
        Values at the wanted argument; ``sine^2 + cosine^2 = 1`` up to rounding [-].
    m1 : float
        Complement of the parameter [-].

    Returns
    -------
    float
        u [-].

    Raises
    ------
    ValueError
        If ``cosine`` is negative.
    """
    if cosine < 0:
        raise ValueError(f"cosine {cosine} of an elliptic phase: reflect the motion so that it is not negative")
    c2 = float(cosine) ** 2
    return float(sine) * float(elliprf(c2, c2 + float(m1) * float(sine) ** 2, 1.0))


class Jacobi(NamedTuple):
    """Jacobi elliptic functions, extended precision, shape of the argument."""

    am: Array
    """Amplitude, continuous over all turns [rad]."""
    sn: Array
    cn: Array
    dn: Array
    turns: Array
    """Nearest whole number of half periods: u = 2 K turns + rest, |rest| <= K."""
    rest: Array


def jacobi(u: ArrayLike, m1: float) -> Jacobi:
    """Jacobi functions by the arithmetic-geometric mean, exact to rounding also for ``m1 -> 0``.

    ``phi_N = 2^N a_N u`` and ``2 phi_(n-1) = phi_n + asin(c_n sin(phi_n) / a_n)`` down to ``am u = phi_0``;
    ``dn^2 = m1 + (1 - m1) cn^2`` has no cancellation. ``m1 = 0``: ``am u = 2 atan(tanh(u / 2))``.

    Parameters
    ----------
    u : array_like
        Argument [-].
    m1 : float
        Complement ``1 - m`` of the parameter [-].

    Returns
    -------
    Jacobi
        am, sn, cn, dn and the split of the argument.
    """
    u = np.asarray(u, dtype=EXTENDED)
    m1 = EXTENDED(m1)
    if m1 == 0.0:
        phi, turns, rest = 2 * np.arctan(np.tanh(u / 2)), np.zeros_like(u), u
    else:
        ratios, mean = _mean_ratios(m1)
        half_turn = _pi() / mean
        turns = np.round(u / half_turn)
        rest = u - half_turn * turns
        phi = 2 ** len(ratios) * mean * rest
        for ratio in reversed(ratios):
            phi = (phi + np.arcsin(np.clip(ratio * np.sin(phi), -1, 1))) / 2
    flip = np.where(turns % 2 == 0, 1, -1)
    sn, cn = flip * np.sin(phi), flip * np.cos(phi)
    return Jacobi(phi + _pi() * turns, sn, cn, np.sqrt(m1 + (1 - m1) * cn**2), turns, rest)


def _mean_ratios(m1: EXTENDED) -> tuple[list[EXTENDED], EXTENDED]:
    """Ratios c_n / a_n (n = 1 ...) and limit of the arithmetic-geometric mean of 1 and sqrt(m1)."""
    a, b, ratios = EXTENDED(1), np.sqrt(m1), []
    while abs(a - b) > 4 * np.finfo(EXTENDED).eps * a:
        a, b, c = (a + b) / 2, np.sqrt(a * b), (a - b) / 2
        ratios.append(c / a)
    return ratios, (a + b) / 2


def _pi() -> EXTENDED:
    """Return pi in extended precision."""
    return 4 * np.arctan(EXTENDED(1))


def rotation_matrix(quaternion: ArrayLike) -> Array:
    """Rotation body to world, ``R = 1 + 2 e0 [e_v]x + 2 [e_v]x^2`` for a unit quaternion.

    Parameters
    ----------
    quaternion : (4,) array_like
        (e0, e1, e2, e3), normalised here [-].

    Returns
    -------
    (3, 3) ndarray
        Rotation matrix [-].
    """
    e = np.asarray(quaternion, dtype=EXTENDED)
    e = e / np.sqrt(np.sum(e * e))
    return np.eye(3, dtype=EXTENDED) + 2 * e[0] * _skew(e[1:]) + 2 * _product(_skew(e[1:]), _skew(e[1:]))


def quaternion(rotation: ArrayLike) -> Array:
    """Unit quaternions of rotation matrices, sign such that the largest component is positive.

    The rows of ``4 e e'`` are sums of entries of R; the row with the largest diagonal is normalised.

    Parameters
    ----------
    rotation : (..., 3, 3) array_like
        Body to world [-].

    Returns
    -------
    (..., 4) ndarray
        Scalar first [-].
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


def _skew(a: Array) -> Array:
    """Matrix [a]x with [a]x b = a x b, (3,) -> (3, 3)."""
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]], dtype=np.asarray(a).dtype)


def _product(a: Array, b: Array) -> Array:
    """Matrix product over the last two axes that keeps extended precision."""
    return np.einsum("...ij,...jk->...ik", a, b)


class Attitude(NamedTuple):
    """Motion of a body about a point."""

    omega_body: Array
    """Angular velocity in body axes, (n, 3) [rad/s]."""
    rotation: Array
    """Body to world, (n, 3, 3) [-]."""


class Polhode(NamedTuple):
    """Constants of torque-free rotation in axes (p, m, q): q is the axis the polhode surrounds, m the middle one."""

    axes: Array
    """Rows are the unit vectors of (p, m, q) in body axes, right-handed, (3, 3)."""
    moments: Array
    """(I_p, I_m, I_q) [kg m^2]."""
    amplitudes: Array
    """Signed amplitudes of (cn, sn, dn) [rad/s]."""
    rate: float
    """Argument of the elliptic functions per second, lam [1/s]."""
    m1: float
    phase: float
    """Argument at t = 0 [-]."""
    momentum: float
    """Length of the angular momentum [N m s]."""


def polhode(inertia: ArrayLike, omega: ArrayLike) -> Polhode | None:
    """Constants of the torque-free motion through ``omega``, or None for a steady rotation.

    ``w = (a_p cn u, a_m sn u, a_q dn u)``, ``u = lam t + u0``, with
    ``a_p^2 = (2 T I_q - L^2) / (I_p (I_q - I_p))``, ``a_m^2 = (2 T I_q - L^2) / (I_m (I_q - I_m))``,
    ``a_q^2 = (L^2 - 2 T I_p) / (I_q (I_q - I_p))``, ``lam^2 = (I_q - I_m) (L^2 - 2 T I_p) / (I_p I_m I_q)`` and
    ``m1 = (I_q - I_p) (L^2 - 2 T I_m) / ((I_q - I_m) (L^2 - 2 T I_p))``. Each bracket is a sum over squared rates, so
    no digits cancel: ``2 T I_q - L^2 = I_p (I_q - I_p) w_p^2 + I_m (I_q - I_m) w_m^2``, and so on. q is the axis of
    largest moment if ``L^2 >= 2 T I_m``, else that of the smallest.

    Parameters
    ----------
    inertia : (3,) array_like
        Principal moments about the centre of mass, body axes [kg m^2].
    omega : (3,) array_like
        Angular velocity at t = 0, body axes [rad/s].

    Returns
    -------
    Polhode or None
        None if ``w x I w = 0``: the body then turns steadily.

    Raises
    ------
    ValueError
        If a moment is not positive.
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
    # with the signs of p and q from the start, cn and dn begin positive; Euler's equations then fix that of m
    ap = np.copysign(np.sqrt(near_p / (ip * (iq - ip))), wp)
    aq = np.copysign(np.sqrt(near_q / (iq * (iq - ip))), wq)
    am = np.copysign(np.sqrt(near_p / (im * (iq - im))), ap * aq * (iq - im))
    phase = elliptic_phase(wm / am, wp / ap, m1)
    momentum = np.sqrt(np.sum((inertia * omega) ** 2))
    return Polhode(axes, np.array([ip, im, iq]), np.array([ap, am, aq]), rate, m1, phase, momentum)


def _polhode_axes(inertia: Array, omega: Array) -> Array:
    """Right-handed axes (p, m, q) of the polhode, rows in body axes, (3, 3)."""
    low, middle, high = np.argsort(inertia, kind="stable")
    # L^2 - 2 T I_m decides which axis the polhode surrounds
    excess = np.sum(inertia * (inertia - inertia[middle]) * omega**2)
    p, q = (low, high) if excess >= 0 else (high, low)
    axes = np.zeros((3, 3), dtype=EXTENDED)
    axes[0, p] = axes[2, q] = 1
    axes[1] = np.cross(axes[2], axes[0])
    return axes


def free_body(t: ArrayLike, inertia: ArrayLike, omega: ArrayLike, orientation: ArrayLike = (1, 0, 0, 0)) -> Attitude:
    """Torque-free rotation of any body from any start: elliptic functions and integrals of the third kind.

    Angular velocity as in :func:`polhode`. With l the direction of the angular momentum in axes (p, m, q), the body
    stands at ``R = R_L R_z(phi) R_x(theta) R_z(psi)``, ``l = (sin theta sin psi, sin theta cos psi, cos theta)``, and
    precesses about the angular momentum by

        phi = L t / I_q + L (I_q - I_p) / (I_p I_q lam) [Pi(u) - Pi(u0)],
        Pi(u) = integral of du / (1 + n sn^2 u),  n = I_q (I_m - I_p) / (I_p (I_q - I_m)) > 0.

    Parameters
    ----------
    t : (n,) array_like
        Times [s].
    inertia : (3,) array_like
        Principal moments about the centre of mass, body axes [kg m^2].
    omega : (3,) array_like
        Angular velocity at t = 0, **body** axes [rad/s].
    orientation : (4,) array_like
        Quaternion at t = 0, body to world [-].

    Returns
    -------
    Attitude
        Angular velocity (body axes) and rotation at ``t``.

    Raises
    ------
    ValueError
        If a moment is not positive.
    """
    t = np.atleast_1d(np.asarray(t, dtype=EXTENDED))
    start = rotation_matrix(orientation)
    curve = polhode(inertia, omega)
    if curve is None:
        steady = np.asarray(omega, dtype=EXTENDED)
        return Attitude(np.tile(steady, (len(t), 1)), _product(start, _turn(steady, t)))
    u = jacobi(curve.phase + curve.rate * t, curve.m1)
    rates = curve.amplitudes * np.stack([u.cn, u.sn, u.dn], axis=-1)
    origin = jacobi(curve.phase, curve.m1)
    ip, _, iq = curve.moments
    gain = curve.momentum * (iq - ip) / (ip * iq * curve.rate)
    angle = curve.momentum * t / iq + gain * (_third_kind(u, curve) - _third_kind(origin, curve))
    first = curve.amplitudes * np.stack([origin.cn, origin.sn, origin.dn])
    frame = _momentum_frame(EXTENDED(0), first, curve)
    to_world = _product(start, _product(curve.axes.T, frame.T))
    rotation = _product(_product(to_world, _momentum_frame(angle, rates, curve)), curve.axes)
    return Attitude(_product(rates[:, None, :], curve.axes)[:, 0, :], rotation)


def _third_kind(u: Jacobi, curve: Polhode) -> Array:
    """Integral of du / (1 + n sn^2 u) from 0, ``rest - n sn^3 R_J(cn^2, dn^2, 1, 1 + n sn^2) / 3`` plus whole turns."""
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
    """R_z(phi) R_x(theta) R_z(psi) from the angle phi (n,) and the rates in axes (p, m, q) (n, 3), (n, 3, 3)."""
    lead = curve.moments * rates / curve.momentum
    tilt = np.hypot(lead[..., 0], lead[..., 1])
    sine, cosine, zero = lead[..., 0] / tilt, lead[..., 1] / tilt, np.zeros_like(tilt)
    node = np.stack([cosine, -sine, zero], axis=-1)
    normal = np.stack([lead[..., 2] * sine, lead[..., 2] * cosine, -tilt], axis=-1)
    c, s = np.cos(angle)[..., None], np.sin(angle)[..., None]
    return np.stack([c * node - s * normal, s * node + c * normal, lead], axis=-2)


def _turn(omega: Array, t: Array) -> Array:
    """Rotations by the angle |omega| t about omega, (n, 3, 3)."""
    speed = np.sqrt(np.sum(omega * omega))
    axis = omega / speed if speed > 0 else omega
    angle = (speed * t)[:, None, None]
    cross = _skew(axis)
    return np.eye(3, dtype=EXTENDED) + np.sin(angle) * cross + (1 - np.cos(angle)) * _product(cross, cross)


def flip_interval(inertia: ArrayLike, omega: ArrayLike) -> float:
    """Time between two flips of the middle axis, ``2 K / lam``.

    Parameters
    ----------
    inertia : (3,) array_like
        Principal moments about the centre of mass, body axes [kg m^2].
    omega : (3,) array_like
        Angular velocity at any instant, body axes [rad/s].

    Returns
    -------
    float
        Interval [s]; infinite on the separatrix and for a steady rotation.
    """
    curve = polhode(inertia, omega)
    return np.inf if curve is None else float(2 * quarter_period(float(curve.m1)) / curve.rate)


def free_symmetric_body(
    t: ArrayLike, transverse: float, axial: float, omega: ArrayLike, orientation: ArrayLike = (1, 0, 0, 0)
) -> Attitude:
    """Torque-free body with symmetry axis z: ``R = R_0 exp([L_0] t / A) exp([e_z] w_z (1 - C / A) t)``.

    Parameters
    ----------
    t : (n,) array_like
        Times [s].
    transverse, axial : float
        A > 0 and C >= 0 about the centre of mass; C = 0 is a rod [kg m^2].
    omega : (3,) array_like
        Angular velocity at t = 0, body axes [rad/s].
    orientation : (4,) array_like
        Quaternion at t = 0 [-].

    Returns
    -------
    Attitude
        Angular velocity (body axes) and rotation at ``t``.

    Raises
    ------
    ValueError
        If ``transverse`` is not positive or ``axial`` is negative.
    """
    if transverse <= 0 or axial < 0:
        raise ValueError(f"moments ({transverse}, {axial}): transverse must be positive and axial not negative")
    t = np.atleast_1d(np.asarray(t, dtype=EXTENDED))
    omega = np.asarray(omega, dtype=EXTENDED)
    precession = np.array([omega[0], omega[1], axial * omega[2] / transverse], dtype=EXTENDED)
    spin = _turn(np.array([0, 0, omega[2] * (1 - EXTENDED(axial) / EXTENDED(transverse))], dtype=EXTENDED), t)
    rotation = _product(_product(rotation_matrix(orientation), _turn(precession, t)), spin)
    return Attitude(np.einsum("nji,j->ni", spin, omega), rotation)


def free_rod_point(
    t: ArrayLike, centre: ArrayLike, velocity: ArrayLike, arm: ArrayLike, omega: ArrayLike
) -> tuple[Array, Array]:
    """Point of a free thin rod: ``r = r_G + v t + s cos(w t) + (w x s) sin(w t) / |w|``.

    Parameters
    ----------
    t : (n,) array_like
        Times [s].
    centre, velocity : (3,) array_like
        Centre of mass at t = 0 [m] and its velocity [m/s], world.
    arm : (3,) array_like
        From the centre of mass to the point at t = 0, along the rod, world [m].
    omega : (3,) array_like
        Angular velocity, at right angles to the rod, world [rad/s].

    Returns
    -------
    position, velocity : (n, 3) ndarray
        Of the point, world [m], [m/s].

    Raises
    ------
    ValueError
        If ``omega`` has a component along the rod.
    """
    t = np.atleast_1d(np.asarray(t, dtype=float))[:, None]
    centre, velocity, arm, omega = (np.asarray(a, dtype=float) for a in (centre, velocity, arm, omega))
    speed = np.linalg.norm(omega)
    if abs(arm @ omega) > 1e-12 * np.linalg.norm(arm) * speed:
        raise ValueError(f"omega {omega} of the rod: remove the component along the rod, it turns nothing")
    side = np.cross(omega, arm)
    swing = np.sinc(speed * t / np.pi) * t
    position = centre + velocity * t + arm * np.cos(speed * t) + side * swing
    return position, velocity - arm * speed**2 * swing + side * np.cos(speed * t)


def spinning_body(
    t: ArrayLike,
    inertia: ArrayLike,
    omega: ArrayLike,
    orientation: ArrayLike = (1, 0, 0, 0),
    weight_moment: ArrayLike = (0, 0, 0),
) -> Attitude:
    """Body about a fixed point under its weight (or free), by Taylor series in extended precision.

    ``I w_dot = -w x I w - M x g3`` and ``g_i_dot = g_i x w``, where ``g_i`` are the world axes in body axes (rows of R)
    and ``M = m g s``. The series of order 26 follow from Cauchy products; the step keeps the last term below 1e-21.
    Close to a separatrix rounding to 80 bits still grows to 1e-10 in twenty flips; :func:`free_body` does not suffer.

    Parameters
    ----------
    t : (n,) array_like
        Times, ascending from t >= 0 [s].
    inertia : (3,) or (3, 3) array_like
        About the fixed point (or the centre of mass of a free body), body axes [kg m^2].
    omega : (3,) array_like
        Angular velocity at t = 0, body axes [rad/s].
    orientation : (4,) array_like
        Quaternion at t = 0 [-].
    weight_moment : (3,) array_like
        Weight times vector from the fixed point to the centre of mass, body axes; gravity is along -z [N m].

    Returns
    -------
    Attitude
        Angular velocity (body axes) and rotation at ``t``.

    Raises
    ------
    ValueError
        If ``t`` is negative or not ascending.
    """
    t = np.atleast_1d(np.asarray(t, dtype=EXTENDED))
    if t[0] < 0 or np.any(np.diff(t) < 0):
        raise ValueError("times of the Taylor series: sort them, starting at or after 0")
    inertia = np.asarray(inertia, dtype=EXTENDED)
    inertia = np.diag(inertia) if inertia.ndim == 1 else inertia
    constants = (inertia, _inverse(inertia), np.asarray(weight_moment, dtype=EXTENDED))
    state = np.vstack([np.asarray(omega, dtype=EXTENDED), rotation_matrix(orientation)])
    now, states = EXTENDED(0), []
    for until in t:
        while now < until:
            series = _taylor_series(state, *constants)
            step = min(_taylor_step(series), until - now)
            state = np.sum(series * step ** np.arange(len(series))[:, None, None], axis=0)
            now = now + step
        states.append(state)
    return Attitude(np.array(states)[:, 0], np.array(states)[:, 1:])


def _taylor_series(state: Array, inertia: Array, inverse: Array, weight_moment: Array) -> Array:
    """Taylor coefficients of (w, g1, g2, g3) at ``state``, (order + 1, 4, 3)."""
    series = np.zeros((TAYLOR_ORDER + 1, 4, 3), dtype=EXTENDED)
    momentum = np.zeros((TAYLOR_ORDER + 1, 3), dtype=EXTENDED)
    series[0] = state
    for n in range(TAYLOR_ORDER):
        momentum[n] = np.einsum("ij,j->i", inertia, series[n, 0])
        backward = series[n::-1, 0] if n else series[:1, 0]
        # every row x obeys x_dot = x x w, the momentum too, apart from the moment of the weight
        known = np.concatenate([momentum[: n + 1, None], series[: n + 1, 1:]], axis=1)
        rates = np.sum(_cross(known, backward[:, None]), axis=0)
        rates[0] -= _cross(weight_moment, series[n, 3])
        rates[0] = np.einsum("ij,j->i", inverse, rates[0])
        series[n + 1] = rates / (n + 1)
    return series


def _taylor_step(series: Array) -> EXTENDED:
    """Step for which the last two terms stay below the tolerance times the state."""
    sizes = np.abs(series).max(axis=(1, 2))
    orders = np.array([TAYLOR_ORDER - 1, TAYLOR_ORDER])
    last = np.maximum(sizes[orders], np.finfo(EXTENDED).tiny)
    return np.min((TAYLOR_TOLERANCE * sizes[0] / last) ** (EXTENDED(1) / orders))


def _cross(a: Array, b: Array) -> Array:
    """Cross product over the last axis (faster than numpy's on small arrays)."""
    a0, a1, a2 = a[..., 0], a[..., 1], a[..., 2]
    b0, b1, b2 = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0], axis=-1)


def _inverse(matrix: Array) -> Array:
    """Inverse of a (3, 3) matrix by its adjugate, in extended precision."""
    a, b, c = matrix
    adjugate = np.stack([_cross(b, c), _cross(c, a), _cross(a, b)], axis=-1)
    return adjugate / np.sum(a * adjugate[:, 0])


def steady_precession(
    transverse: float, axial: float, spin: float, weight_moment: float, tilt: float
) -> tuple[float, float]:
    """Slow and fast precession rate W of a symmetric top, roots of ``A W^2 cos(tilt) - C w3 W + m g l = 0``.

    Parameters
    ----------
    transverse, axial : float
        A and C about the **fixed point** [kg m^2].
    spin : float
        Axial component w3 of the angular velocity (own spin plus W cos(tilt)) [rad/s].
    weight_moment : float
        m g l, l from the fixed point to the centre of mass [N m].
    tilt : float
        Angle of the axis from the vertical [rad].

    Returns
    -------
    slow, fast : float
        [rad/s]; the fast one is infinite for a horizontal axis.

    Raises
    ------
    ValueError
        If the spin is too small for any steady precession.
    """
    momentum, quadratic = axial * spin, transverse * np.cos(tilt)
    discriminant = momentum**2 - 4 * quadratic * weight_moment
    if discriminant < 0 or momentum == 0:
        needed = 2 * np.sqrt(max(quadratic * weight_moment, 0.0)) / axial
        raise ValueError(f"spin {spin} rad/s of the top: steady precession needs at least {needed} rad/s")
    # the sum of equal signs first: the small root would cancel in the textbook formula
    larger = momentum + np.copysign(np.sqrt(discriminant), momentum)
    fast = np.inf if abs(quadratic) < 1e-15 * transverse else larger / (2 * quadratic)
    return 2 * weight_moment / larger, fast


def sleeping_spin(transverse: float, axial: float, weight_moment: float) -> float:
    """Least spin of a stable upright top, ``C^2 w3^2 = 4 A m g l``.

    Parameters
    ----------
    transverse, axial : float
        A and C about the fixed point [kg m^2].
    weight_moment : float
        m g l [N m].

    Returns
    -------
    float
        w3 [rad/s].
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
        sn = jacobi(self.phase + self.rate * np.asarray(t, dtype=EXTENDED), self.m1).sn
        return (self.lowest + (self.highest - self.lowest) * sn**2).astype(float)


def nutation(
    transverse: float,
    axial: float,
    spin: float,
    weight_moment: float,
    tilt: float,
    tilt_rate: float,
    precession: float,
) -> Nutation:
    """Nutation of a heavy symmetric top from its cubic.

    ``u_dot^2 = (alpha - beta u)(1 - u^2) - (b - a u)^2`` with ``a = C w3 / A``, ``b = a u0 + W sin^2(tilt)``,
    ``beta = 2 m g l / A``, ``alpha = tilt_rate^2 + W^2 sin^2(tilt) + beta u0``; ``rate^2 = beta (u3 - u1) / 4`` and
    ``m = (u2 - u1) / (u3 - u1)``.

    Parameters
    ----------
    transverse, axial : float
        A and C about the fixed point [kg m^2].
    spin : float
        Axial component w3 of the angular velocity [rad/s].
    weight_moment : float
        m g l > 0 [N m].
    tilt, tilt_rate, precession : float
        Angle of the axis from the vertical [rad], its rate and the precession W at t = 0 [rad/s].

    Returns
    -------
    Nutation
        Roots, rate and phase.

    Raises
    ------
    ValueError
        If ``weight_moment`` is not positive.
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


def cardan_angle(angle: ArrayLike, bend: float) -> Array:
    """Output angle of a universal joint, ``tan(out) = cos(bend) tan(in)``, continuous over all turns.

    Both angles count from the pose where the arm of the cross carried by the **input** yoke is normal to the plane of
    the shafts; with that arm in the plane, add pi/2 to both.

    Parameters
    ----------
    angle : array_like
        Input angle [rad].
    bend : float
        Angle between the shafts, |bend| < pi/2 [rad].

    Returns
    -------
    ndarray
        Output angle [rad].

    Raises
    ------
    ValueError
        If the shafts are bent by a right angle or more.
    """
    _check_bend(bend)
    s, c = np.sin(angle), np.cos(angle)
    # the lag stays between -pi/2 and pi/2, so no turn is ever lost
    return angle + np.arctan2((np.cos(bend) - 1) * s * c, c * c + np.cos(bend) * s * s)


def cardan_rate(angle: ArrayLike, bend: float, rate: float = 1.0) -> Array:
    """Output rate of a universal joint, ``w cos(bend) / (1 - sin^2(bend) sin^2(in))``.

    Parameters
    ----------
    angle : array_like
        Input angle as in :func:`cardan_angle` [rad].
    bend : float
        Angle between the shafts [rad].
    rate : float
        Input rate; 1 gives the transmission ratio [rad/s].

    Returns
    -------
    ndarray
        Output rate [rad/s].
    """
    _check_bend(bend)
    return rate * np.cos(bend) / (1 - (np.sin(bend) * np.sin(angle)) ** 2)


def cardan_acceleration(angle: ArrayLike, bend: float, rate: float, acceleration: float = 0.0) -> Array:
    """Output angular acceleration, ``i alpha + w^2 cos(b) sin^2(b) sin(2 in) / (1 - sin^2(b) sin^2(in))^2``.

    Parameters
    ----------
    angle : array_like
        Input angle as in :func:`cardan_angle` [rad].
    bend : float
        Angle b between the shafts [rad].
    rate, acceleration : float
        Input rate w [rad/s] and acceleration alpha [rad/s^2]; i is the ratio of :func:`cardan_rate`.

    Returns
    -------
    ndarray
        Output acceleration [rad/s^2].
    """
    ratio = cardan_rate(angle, bend)
    return ratio * acceleration + rate**2 * ratio**2 * np.sin(bend) ** 2 * np.sin(2 * np.asarray(angle)) / np.cos(bend)


def cardan_motor_torque(angle: ArrayLike, bend: float, rate: float, inertia: float) -> Array:
    """Torque that keeps the input rate constant, from the power balance ``T w = I w_out alpha_out``.

    Parameters
    ----------
    angle : array_like
        Input angle as in :func:`cardan_angle` [rad].
    bend : float
        Angle between the shafts [rad].
    rate : float
        Input rate w [rad/s].
    inertia : float
        Axial moment of inertia I of the output shaft [kg m^2].

    Returns
    -------
    ndarray
        Torque on the input shaft [N m].
    """
    return inertia * cardan_acceleration(angle, bend, rate) * cardan_rate(angle, bend)


def cardan_ratio(bend: float) -> float:
    """Greatest over least output rate, ``1 / cos^2(bend)``.

    Parameters
    ----------
    bend : float
        Angle between the shafts [rad].

    Returns
    -------
    float
        Ratio [-].
    """
    _check_bend(bend)
    return 1 / np.cos(bend) ** 2


def cardan_harmonics(bend: float, count: int) -> Array:
    """Amplitudes of the output rate over its mean at 2, 4, ..., 2 count times shaft speed, ``2 tan^(2k)(bend / 2)``.

    ``cos(b) / (1 - sin^2(b) sin^2(x)) = 1 + 2 sum_k (-q)^k cos(2 k x)``, ``q = tan^2(b / 2)`` (Poisson kernel).

    Parameters
    ----------
    bend : float
        Angle b between the shafts [rad].
    count : int
        Number of harmonics.

    Returns
    -------
    (count,) ndarray
        Amplitudes [-].
    """
    _check_bend(bend)
    return 2 * np.tan(bend / 2) ** (2 * np.arange(1, count + 1))


def double_cardan_angle(angle: ArrayLike, first: float, second: float, phasing: float = 0.0) -> Array:
    """Output angle of two universal joints with a shaft between them, all three shafts in one plane.

    Aligned yokes on the middle shaft (``phasing = 0``) run the second joint backwards:
    ``tan(out) = cos(first) tan(in) / cos(second)``, so equal bends give out = in, ratio 1.

    Parameters
    ----------
    angle : array_like
        Input angle as in :func:`cardan_angle` [rad].
    first, second : float
        Bend of the two joints, Z or W arrangement alike [rad].
    phasing : float
        Angle by which the second yoke of the middle shaft is turned from the aligned pose [rad].

    Returns
    -------
    ndarray
        Output angle, 0 at input angle 0 [rad].
    """
    quarter = np.pi / 2 + phasing
    return cardan_angle(cardan_angle(angle, first) + quarter, second) - cardan_angle(quarter, second)


def double_cardan_ratio(angle: ArrayLike, first: float, second: float, phasing: float = 0.0) -> Array:
    """Output over input rate of two universal joints, the product of both ratios.

    Parameters
    ----------
    angle : array_like
        Input angle as in :func:`cardan_angle` [rad].
    first, second, phasing : float
        As in :func:`double_cardan_angle` [rad].

    Returns
    -------
    ndarray
        Ratio [-].
    """
    middle = cardan_angle(angle, first) + np.pi / 2 + phasing
    return cardan_rate(angle, first) * cardan_rate(middle, second)


def _check_bend(bend: float) -> None:
    """Refuse a universal joint that cannot turn."""
    if not abs(bend) < np.pi / 2:
        raise ValueError(f"bend {bend} rad of the universal joint: must stay below a right angle")


def pendulum_frequency(inertia: float, mass: float, distance: float, gravity: float = GRAVITY) -> float:
    """Small-oscillation frequency of a physical pendulum, ``w0^2 = m g d / I``.

    Parameters
    ----------
    inertia : float
        About the hinge axis [kg m^2].
    mass, distance : float
        Mass [kg] and distance of the centre of mass from the hinge axis [m].
    gravity : float
        Component of gravity normal to the hinge axis: g sin(angle between axis and vertical) [m/s^2].

    Returns
    -------
    float
        w0 [rad/s].

    Raises
    ------
    ValueError
        If an argument is negative or the inertia is zero.
    """
    if inertia <= 0 or min(mass, distance, gravity) < 0:
        raise ValueError(f"pendulum (inertia {inertia}, mass {mass}, distance {distance}): give positive values")
    return np.sqrt(mass * gravity * distance / inertia)


def pendulum_period(frequency: float, angle: float, rate: float = 0.0) -> float:
    """Period of a pendulum of any amplitude: full swing ``4 K(k^2) / w0``, or one turn ``2 K(1 / k^2) / (k w0)``.

    ``k^2 = sin^2(angle / 2) + (rate / 2 w0)^2``; k > 1 means that it goes over the top.

    Parameters
    ----------
    frequency : float
        Small-oscillation frequency w0 [rad/s].
    angle, rate : float
        State at any instant, angle from the lowest position [rad], [rad/s].

    Returns
    -------
    float
        Period [s].
    """
    k2, m1 = _pendulum_modulus(frequency, angle, rate)
    if k2 <= 1:
        return 4 * quarter_period(m1) / frequency
    return 2 * quarter_period(-m1 / k2) / (np.sqrt(k2) * frequency)


def pendulum_motion(t: ArrayLike, frequency: float, angle: float, rate: float = 0.0) -> tuple[Array, Array]:
    """Angle and rate of a physical pendulum from any start.

    Swinging (k <= 1): ``sin(phi / 2) = +-k sn(u | k^2)``, ``phi_dot = +-2 k w0 cn u``, ``u = w0 t + u0``.
    Turning (k > 1): ``phi = +-2 am(u | 1 / k^2)``, ``phi_dot = +-2 k w0 dn u``, ``u = k w0 t + u0``.

    Parameters
    ----------
    t : array_like
        Times [s].
    frequency : float
        Small-oscillation frequency w0 [rad/s].
    angle, rate : float
        State at t = 0, angle from the lowest position [rad], [rad/s].

    Returns
    -------
    angle, rate : ndarray
        [rad] (continuous over turns), [rad/s].
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

    Parameters
    ----------
    mass : float
        [kg].
    arm : (3,) array_like
        s from any point of the axis to the centre of mass, world [m].
    axis : (3,) array_like
        Unit vector u, world [-].
    rate, acceleration : float
        Angular rate w [rad/s] and acceleration alpha about the axis [rad/s^2].
    gravity : (3,) array_like
        World [m/s^2].

    Returns
    -------
    (3,) ndarray
        Force, world [N].
    """
    side = np.cross(axis, arm)
    return mass * (acceleration * side + rate**2 * np.cross(axis, side) - np.asarray(gravity))


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


@dataclass(frozen=True)
class SliderCrank:
    """Slider-crank without offset: crank about the origin, piston on the bore axis u, v at right angles to it.

    The crank stands at ``q`` from u towards v; the rod leans by ``sin(phi) = lam sin(q)``, lam = R / L.

    Parameters
    ----------
    radius, rod_length : float
        Crank radius R and rod length L > R [m].
    crank_mass, crank_centre : float
        Mass [kg] and distance of its centre of mass from the axis, towards the pin [m].
    rod_mass, rod_fraction, rod_inertia : float
        Mass [kg], distance of the centre of mass from the crankpin over L [-], inertia about it [kg m^2].
    piston_mass : float
        [kg].
    crank_inertia : float
        About the centre of mass of the crank; enters only with an angular acceleration [kg m^2].

    Raises
    ------
    ValueError
        If the crank is as long as the rod or longer.
    """

    radius: float
    rod_length: float
    crank_mass: float
    crank_centre: float
    rod_mass: float
    rod_fraction: float
    rod_inertia: float
    piston_mass: float
    crank_inertia: float = 0.0

    def __post_init__(self) -> None:
        if not 0 < self.radius < self.rod_length:
            raise ValueError(f"rod_length {self.rod_length} m: must exceed the crank radius {self.radius} m")

    @property
    def reciprocating(self) -> float:
        """Mass that moves with the piston, ``m_p + f m_r`` [kg]."""
        return self.piston_mass + self.rod_fraction * self.rod_mass

    @property
    def rotating_moment(self) -> float:
        """Mass moment that turns with the pin, ``m_c r_c + (1 - f) m_r R`` [kg m]."""
        return self.crank_mass * self.crank_centre + (1 - self.rod_fraction) * self.rod_mass * self.radius


def slider_crank_coefficients(lam: float, count: int) -> Array:
    """Fourier coefficients of the rod: ``sqrt(1 - lam^2 sin^2 q) = a_0 + sum_k a_2k cos(2 k q)``.

    ``a_2k = sum_(j >= k) C(1/2, j) (-1)^(j+k) 2^(1-2j) C(2j, j-k) lam^(2j)``, all terms of one sign;
    ``a_0 = (2 / pi) E(lam^2)``.

    Parameters
    ----------
    lam : float
        Crank radius over rod length, 0 <= lam < 1 [-].
    count : int
        Number of coefficients beyond a_0.

    Returns
    -------
    (count + 1,) ndarray
        a_0, a_2, a_4, ... [-].

    Raises
    ------
    ValueError
        If ``lam`` is outside [0, 1).
    """
    if not 0 <= lam < 1:
        raise ValueError(f"lam = {lam}: the rod must be longer than the crank, 0 <= lam < 1")
    return np.array([2 / np.pi * ellipe(lam**2)] + [_rod_coefficient(lam, k) for k in range(1, count + 1)])


def _rod_coefficient(lam: float, k: int) -> float:
    """a_2k by its series; each term follows from the one before."""
    term, total, j = 2.0 * (lam / 2) ** (2 * k), 0.0, k
    for i in range(k):
        term *= (0.5 - i) / (i + 1)
    while abs(term) > 1e-18 * abs(total):
        total += term
        term *= lam**2 * (j - 0.5) * (2 * j + 1) / (2 * (j + 1 - k) * (j + 1 + k))
        j += 1
    return total


class EngineHarmonics(NamedTuple):
    """Amplitudes of the inertia force of one cylinder on the block."""

    orders: Array
    """1, 2, 4, 6, ... times crank speed."""
    bore: Array
    """Signed amplitudes of cos(order q) along the bore, positive towards the head [N]."""
    across: float
    """Amplitude of sin(q) at right angles to the bore, the only one [N]."""


def slider_crank_harmonics(
    mechanism: SliderCrank, rate: float, count: int, centripetal: bool = True
) -> EngineHarmonics:
    """Harmonics of the block force at constant crank rate.

    ``F_u = w^2 [(m_c r_c + m_r R + m_p R) cos q + (m_p + f m_r) L sum_k (2k)^2 a_2k cos(2 k q)]``,
    ``F_v = w^2 (m_c r_c + (1 - f) m_r R) sin q``.

    Parameters
    ----------
    mechanism : SliderCrank
        Masses and lengths.
    rate : float
        Crank rate w [rad/s].
    count : int
        Number of even orders.
    centripetal : bool
        False drops ``m_c w^2 r_c`` of the crank: what a solver returns that forgets the centripetal force of a body
        whose reference point is not its centre of mass.

    Returns
    -------
    EngineHarmonics
        Orders and amplitudes.
    """
    crank = mechanism.crank_mass * mechanism.crank_centre * centripetal
    even = 2 * np.arange(1, count + 1)
    waves = slider_crank_coefficients(mechanism.radius / mechanism.rod_length, count)[1:]
    first = crank + (mechanism.rod_mass + mechanism.piston_mass) * mechanism.radius
    bore = np.concatenate([[first], mechanism.reciprocating * mechanism.rod_length * even**2 * waves])
    across = crank + (1 - mechanism.rod_fraction) * mechanism.rod_mass * mechanism.radius
    return EngineHarmonics(np.concatenate([[1], even]), rate**2 * bore, rate**2 * across)


class _CrankPaths(NamedTuple):
    """Positions of the moving parts over the crank angle, first and second derivative, components (u, v)."""

    crank: Array
    """Centre of mass of the crank, (3, n, 2): value, d/dq, d2/dq2 [m]."""
    rod: Array
    piston: Array
    lean: Array
    """Rod angle phi, (3, n) [rad]."""
    direction: Array
    """Unit vector from crankpin to piston, (n, 2)."""


def _crank_paths(mechanism: SliderCrank, angle: Array) -> _CrankPaths:
    """Kinematics of the slider-crank at the crank angles (n,)."""
    lam = mechanism.radius / mechanism.rod_length
    c, s = np.cos(angle), np.sin(angle)
    pin = np.stack([np.stack([c, s], -1), np.stack([-s, c], -1), np.stack([-c, -s], -1)])
    sine = lam * s
    cosine = np.sqrt(1 - sine**2)
    first = lam * c / cosine
    second = (sine * first**2 - lam * s) / cosine
    along, across = np.stack([cosine, -sine], -1), np.stack([-sine, -cosine], -1)
    swing = np.stack([along, first[:, None] * across, second[:, None] * across - first[:, None] ** 2 * along])
    rod = mechanism.radius * pin + mechanism.rod_fraction * mechanism.rod_length * swing
    piston = mechanism.radius * pin + mechanism.rod_length * swing
    return _CrankPaths(mechanism.crank_centre * pin, rod, piston, np.stack([np.arcsin(sine), first, second]), along)


def slider_crank_torque(
    mechanism: SliderCrank,
    angle: ArrayLike,
    rate: float,
    *,
    gravity: ArrayLike = (0.0, 0.0),
    acceleration: float = 0.0,
) -> Array:
    """Driving torque by virtual power, ``T = sum m x' . (x'' w^2 + x' alpha - g) + J phi' (phi'' w^2 + phi' alpha)``.

    A dash is d/dq; at constant rate this is ``d/dt`` of the kinetic energy minus the power of gravity, over w.

    Parameters
    ----------
    mechanism : SliderCrank
        Masses and lengths.
    angle : (n,) array_like
        Crank angle q [rad].
    rate, acceleration : float
        Crank rate w [rad/s] and acceleration alpha [rad/s^2].
    gravity : (2,) array_like
        Components along the bore (u, towards the head) and across it (v) [m/s^2].

    Returns
    -------
    (n,) ndarray
        Torque on the crank [N m].
    """
    paths = _crank_paths(mechanism, np.atleast_1d(np.asarray(angle, dtype=float)))
    masses = (mechanism.crank_mass, mechanism.rod_mass, mechanism.piston_mass)
    torque = mechanism.crank_inertia * acceleration
    for mass, (_, first, second) in zip(masses, paths[:3], strict=True):
        inertial = second * rate**2 + first * acceleration - np.asarray(gravity)
        torque = torque + mass * np.sum(first * inertial, axis=-1)
    _, first, second = paths.lean
    return torque + mechanism.rod_inertia * first * (second * rate**2 + first * acceleration)


class CrankLoads(NamedTuple):
    """Forces in a slider-crank, components (u, v), (n, 2) [N], and the driving torque."""

    bearing: Array
    """Of the block on the crank."""
    crankpin: Array
    """Of the crank on the rod."""
    wristpin: Array
    """Of the rod on the piston."""
    guide: Array
    """Of the bore on the piston, (n,), along v [N]."""
    torque: Array
    """On the crank, (n,) [N m]."""


def slider_crank_loads(
    mechanism: SliderCrank,
    angle: ArrayLike,
    rate: float,
    *,
    gravity: ArrayLike = (0.0, 0.0),
    acceleration: float = 0.0,
    centripetal: bool = True,
) -> CrankLoads:
    """Forces in pins, bearing and bore by Newton and Euler, part by part from the piston to the crank.

    Parameters
    ----------
    mechanism : SliderCrank
        Masses and lengths.
    angle : (n,) array_like
        Crank angle q [rad].
    rate, acceleration : float
        Crank rate w [rad/s] and acceleration [rad/s^2].
    gravity : (2,) array_like
        Components along the bore (u, towards the head) and across it (v) [m/s^2].
    centripetal : bool
        False drops ``m_c w^2 r_c`` of the crank, which falsifies the bearing force only.

    Returns
    -------
    CrankLoads
        Forces and torque.
    """
    angle, g = np.atleast_1d(np.asarray(angle, dtype=float)), np.asarray(gravity, dtype=float)
    paths = _crank_paths(mechanism, angle)
    crank, rod, piston = (p[2] * rate**2 + p[1] * acceleration for p in paths[:3])
    if not centripetal:
        crank = paths.crank[1] * acceleration
    d, length = paths.direction, mechanism.rod_length
    load = mechanism.rod_mass * (rod - g)
    along = mechanism.piston_mass * (piston[:, 0] - g[0])
    # moment about the centre of mass of the rod, whose angle from u is -phi
    spin = -mechanism.rod_inertia * (paths.lean[2] * rate**2 + paths.lean[1] * acceleration)
    across = (d[:, 1] * along - spin / length - mechanism.rod_fraction * _cross2(d, load)) / d[:, 0]
    wristpin = np.stack([along, across], axis=-1)
    crankpin = wristpin + load
    bearing = crankpin + mechanism.crank_mass * (crank - g)
    pin = mechanism.radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    about_axis = mechanism.crank_inertia + mechanism.crank_mass * mechanism.crank_centre**2
    weight = _cross2(paths.crank[0], mechanism.crank_mass * g)
    torque = about_axis * acceleration + _cross2(pin, crankpin) - weight
    return CrankLoads(bearing, crankpin, wristpin, -mechanism.piston_mass * g[1] - across, torque)


def _cross2(a: Array, b: Array) -> Array:
    """Component of a x b out of the plane, (n, 2) -> (n,)."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def block_force(mechanism: SliderCrank, angle: ArrayLike, rate: float, centripetal: bool = True) -> Array:
    """Inertia force on the block at constant crank rate, minus bearing and guide force without gravity.

    Parameters
    ----------
    mechanism : SliderCrank
        Masses and lengths.
    angle : (n,) array_like
        Crank angle q [rad].
    rate : float
        Crank rate [rad/s].
    centripetal : bool
        As in :func:`slider_crank_loads`.

    Returns
    -------
    (n, 2) ndarray
        Along the bore and across it [N].
    """
    loads = slider_crank_loads(mechanism, angle, rate, centripetal=centripetal)
    across = loads.bearing[:, 1] + loads.guide
    return -np.stack([loads.bearing[:, 0], across], axis=-1)


def harmonic_amplitudes(signal: Callable[[Array], Array], count: int, samples: int = 256) -> Array:
    """Amplitudes of the harmonics 0 ... count of a signal of one turn, by the discrete Fourier transform.

    Parameters
    ----------
    signal : callable
        Maps angles (n,) [rad] to values (n,); smooth and of period 2 pi.
    count : int
        Highest harmonic, below ``samples / 2``.
    samples : int
        Samples per turn; the error is that of the harmonics beyond ``samples - count``.

    Returns
    -------
    (count + 1,) ndarray
        Mean and amplitudes, unit of the signal.
    """
    angles = 2 * np.pi * np.arange(samples) / samples
    spectrum = np.abs(np.fft.rfft(signal(angles))) / samples
    return np.concatenate([spectrum[:1], 2 * spectrum[1 : count + 1]])


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
