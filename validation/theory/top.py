"""Heavy tops: any body by Taylor series, steady precession of the symmetric one; a disc that rolls on a circle."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from validation.theory.common import EXTENDED, GRAVITY, Array, Attitude, cross, rotation_matrix

TAYLOR_ORDER = 26
TAYLOR_TOLERANCE = 1e-21


def spinning_body(
    t: ArrayLike,
    inertia: ArrayLike,
    omega: ArrayLike,
    orientation: ArrayLike = (1, 0, 0, 0),
    weight_moment: ArrayLike = (0, 0, 0),
) -> Attitude:
    """Integrate a body about a fixed point under its weight (or free), by Taylor series in extended precision.

    ``I w_dot = -w x I w - M x g3`` and ``g_i_dot = g_i x w``, where ``g_i`` are the world axes in body axes (rows of R)
    and ``M = m g s``. The series of order 26 follow from Cauchy products; the step keeps the last term below 1e-21.
    Close to a separatrix rounding to 80 bits still grows to 1e-10 in twenty flips; :func:`free_body` does not suffer.

    ``t`` (n,): times, ascending from t >= 0 [s]; ``inertia`` (3,): about the fixed point (or the centre of mass of a
    free body), body axes [kg m^2]; ``omega`` (3,): angular velocity at t = 0, body axes [rad/s]; ``orientation`` (4,):
    quaternion at t = 0 [-]; ``weight_moment`` (3,): weight times vector from the fixed point to the centre of mass,
    body axes; gravity is along -z [N m]. Returns angular velocity (body axes) and rotation at ``t``. ValueError if
    ``t`` is negative or not ascending.
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
    """Return the taylor coefficients of (w, g1, g2, g3) at ``state``, (order + 1, 4, 3)."""
    series = np.zeros((TAYLOR_ORDER + 1, 4, 3), dtype=EXTENDED)
    momentum = np.zeros((TAYLOR_ORDER + 1, 3), dtype=EXTENDED)
    series[0] = state
    for n in range(TAYLOR_ORDER):
        momentum[n] = np.einsum("ij,j->i", inertia, series[n, 0])
        backward = series[n::-1, 0] if n else series[:1, 0]
        # every row x obeys x_dot = x x w, the momentum too, apart from the moment of the weight
        known = np.concatenate([momentum[: n + 1, None], series[: n + 1, 1:]], axis=1)
        rates = np.sum(cross(known, backward[:, None]), axis=0)
        rates[0] -= cross(weight_moment, series[n, 3])
        rates[0] = np.einsum("ij,j->i", inverse, rates[0])
        series[n + 1] = rates / (n + 1)
    return series


def _taylor_step(series: Array) -> EXTENDED:
    """Return the step for which the last two terms stay below the tolerance times the state."""
    sizes = np.abs(series).max(axis=(1, 2))
    orders = np.array([TAYLOR_ORDER - 1, TAYLOR_ORDER])
    last = np.maximum(sizes[orders], np.finfo(EXTENDED).tiny)
    return np.min((TAYLOR_TOLERANCE * sizes[0] / last) ** (EXTENDED(1) / orders))


def _inverse(matrix: Array) -> Array:
    """Return the inverse of a (3, 3) matrix by its adjugate, in extended precision."""
    a, b, c = matrix
    adjugate = np.stack([cross(b, c), cross(c, a), cross(a, b)], axis=-1)
    return adjugate / np.sum(a * adjugate[:, 0])


def steady_precession(
    transverse: float, axial: float, spin: float, weight_moment: float, tilt: float
) -> tuple[float, float]:
    """Return the slow and fast precession rate W of a symmetric top, roots of ``A W^2 cos(tilt) - C w3 W + m g l = 0``.

    ``transverse, axial``: A and C about the **fixed point** [kg m^2]; ``spin``: axial component w3 of the angular
    velocity (own spin plus W cos(tilt)) [rad/s]; ``weight_moment``: m g l, l from the fixed point to the centre of mass
    [N m]; ``tilt``: angle of the axis from the vertical [rad]. Returns slow, fast: [rad/s]; the fast one is infinite
    for a horizontal axis. ValueError if the spin is too small for any steady precession.
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


class RollingCircle(NamedTuple):
    """Steady circular rolling of a disc."""

    precession: float  # Rate about the vertical, > 0 [rad/s]
    spin: float
    """Own rotation about the disc axis relative to the precessing frame, opposite in sign to the precession [rad/s]."""
    centre_radius: float  # Radius of the circle of the disc centre [m]
    centre_height: float  # [m]

    @property
    def period(self) -> float:
        """Return the time for one round [s]."""
        return 2 * np.pi / self.precession


def rolling_circle(
    mass: float, radius: float, transverse: float, axial: float, circle: float, lean: float, gravity: float = GRAVITY
) -> RollingCircle:
    """Return the motion of a thin disc rolling without slip on a horizontal circle, leaning inwards by a constant angle
    b.

    Moment of momentum about the centre of mass, with rho = R - r sin(b) and spin = -W R / r:
    ``W^2 (m r rho + C rho / r + A sin b) = m g r tan b``.

    ``mass, radius``: of the disc [kg], r [m]; ``transverse, axial``: A (a diameter) and C (the axis) about the centre
    of mass [kg m^2]; ``circle``: radius R of the track of the contact point [m]; ``lean``: angle b of the disc plane
    from the vertical, 0 < b < pi/2 [rad]; ``gravity``: [m/s^2]. Returns rates, radius and height of the disc centre.
    ValueError if no such motion exists.
    """
    rho = circle - radius * np.sin(lean)
    inertia = mass * radius * rho + axial * rho / radius + transverse * np.sin(lean)
    if not 0 < lean < np.pi / 2 or inertia <= 0:
        raise ValueError(f"lean {lean} rad on a circle of {circle} m: lean inwards, by less than pi/2")
    precession = np.sqrt(mass * gravity * radius * np.tan(lean) / inertia)
    return RollingCircle(precession, -precession * circle / radius, rho, radius * np.cos(lean))
