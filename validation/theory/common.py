"""Precision and constants of the closed forms; rotations and products in extended precision; elliptic functions."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import elliprf

Array = NDArray[np.floating]

GRAVITY = 9.81  # Acceleration of free fall used when none is given [m/s^2]

EXTENDED = np.longdouble
"""80-bit floats where the machine has them (64-bit elsewhere: results then lose about three digits)."""


def rotation_matrix(quaternion: ArrayLike) -> Array:
    """Return the rotation body to world, ``R = 1 + 2 e0 [e_v]x + 2 [e_v]x^2`` for a unit quaternion.

    ``quaternion`` (4,): (e0, e1, e2, e3), normalised here [-]. Returns (3, 3): rotation matrix [-].
    """
    e = np.asarray(quaternion, dtype=EXTENDED)
    e = e / np.sqrt(np.sum(e * e))
    return np.eye(3, dtype=EXTENDED) + 2 * e[0] * skew(e[1:]) + 2 * product(skew(e[1:]), skew(e[1:]))


class Attitude(NamedTuple):
    """Motion of a body about a point."""

    omega_body: Array  # Angular velocity in body axes, (n, 3) [rad/s]
    rotation: Array  # Body to world, (n, 3, 3) [-]


def turn(omega: Array, t: Array) -> Array:
    """Return rotations by the angle |omega| t about omega, (n, 3, 3)."""
    speed = np.sqrt(np.sum(omega * omega))
    axis = omega / speed if speed > 0 else omega
    angle = (speed * t)[:, None, None]
    cross = skew(axis)
    return np.eye(3, dtype=EXTENDED) + np.sin(angle) * cross + (1 - np.cos(angle)) * product(cross, cross)


def skew(a: Array) -> Array:
    """Return the matrix [a]x with [a]x b = a x b, (3,) -> (3, 3)."""
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]], dtype=np.asarray(a).dtype)


def product(a: Array, b: Array) -> Array:
    """Return the matrix product over the last two axes that keeps extended precision."""
    return np.einsum("...ij,...jk->...ik", a, b)


def cross(a: Array, b: Array) -> Array:
    """Return the cross product over the last axis (faster than numpy's on small arrays)."""
    a0, a1, a2 = a[..., 0], a[..., 1], a[..., 2]
    b0, b1, b2 = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0], axis=-1)


def quarter_period(m1: float) -> float:
    """Return the complete elliptic integral ``K = R_F(0, m1, 1)``, infinite for ``m1 = 0``.

    ``m1``: complement ``1 - m`` of the parameter, 0 <= m1 <= 1 [-]. Returns K [-]. ValueError if ``m1`` is outside [0,
    1].
    """
    if not 0.0 <= m1 <= 1.0:
        raise ValueError(f"elliptic parameter m1 = {m1}: must lie in [0, 1] (m1 is 1 - m)")
    return np.inf if m1 == 0.0 else float(elliprf(0.0, float(m1), 1.0))


def elliptic_phase(sine: float, cosine: float, m1: float) -> float:
    """Return the argument u in [-K, K] with ``sn u = sine`` and ``cn u = cosine >= 0``.

    ``u = s R_F(c^2, c^2 + m1 s^2, 1)``. Taking sine *and* cosine keeps the digits near u = K that an angle would lose.

    ``sine, cosine``: values at the wanted argument; ``sine^2 + cosine^2 = 1`` up to rounding [-]; ``m1``: complement of
    the parameter [-]. Returns u [-]. ValueError if ``cosine`` is negative.
    """
    if cosine < 0:
        raise ValueError(f"cosine {cosine} of an elliptic phase: reflect the motion so that it is not negative")
    c2 = float(cosine) ** 2
    return float(sine) * float(elliprf(c2, c2 + float(m1) * float(sine) ** 2, 1.0))


class Jacobi(NamedTuple):
    """Jacobi elliptic functions, extended precision, shape of the argument."""

    am: Array  # Amplitude, continuous over all turns [rad]
    sn: Array
    cn: Array
    dn: Array
    turns: Array  # Nearest whole number of half periods: u = 2 K turns + rest, |rest| <= K
    rest: Array


def jacobi(u: ArrayLike, m1: float) -> Jacobi:
    """Evaluate the Jacobi functions by the arithmetic-geometric mean, exact to rounding also for ``m1 -> 0``.

    ``phi_N = 2^N a_N u`` and ``2 phi_(n-1) = phi_n + asin(c_n sin(phi_n) / a_n)`` down to ``am u = phi_0``;
    ``dn^2 = m1 + (1 - m1) cn^2`` has no cancellation. ``m1 = 0``: ``am u = 2 atan(tanh(u / 2))``.

    ``u``: argument [-]; ``m1``: complement ``1 - m`` of the parameter [-]. Returns am, sn, cn, dn and the split of the
    argument.
    """
    u = np.asarray(u, dtype=EXTENDED)
    complement = EXTENDED(m1)
    if complement == 0.0:
        phi, turns, rest = 2 * np.arctan(np.tanh(u / 2)), np.zeros_like(u), u
    else:
        ratios, mean = _mean_ratios(complement)
        half_turn = _pi() / mean
        turns = np.round(u / half_turn)
        rest = u - half_turn * turns
        phi = 2 ** len(ratios) * mean * rest
        for ratio in reversed(ratios):
            phi = (phi + np.arcsin(np.clip(ratio * np.sin(phi), -1, 1))) / 2
    flip = np.where(turns % 2 == 0, 1, -1)
    sn, cn = flip * np.sin(phi), flip * np.cos(phi)
    return Jacobi(phi + _pi() * turns, sn, cn, np.sqrt(complement + (1 - complement) * cn**2), turns, rest)


def _mean_ratios(m1: EXTENDED) -> tuple[list[EXTENDED], EXTENDED]:
    """Return the ratios c_n / a_n (n = 1 ...) and limit of the arithmetic-geometric mean of 1 and sqrt(m1)."""
    a, b, ratios = EXTENDED(1), np.sqrt(m1), []
    while abs(a - b) > 4 * np.finfo(EXTENDED).eps * a:
        a, b, c = (a + b) / 2, np.sqrt(a * b), (a - b) / 2
        ratios.append(c / a)
    return ratios, (a + b) / 2


def _pi() -> EXTENDED:
    """Return pi in extended precision."""
    return 4 * np.arctan(EXTENDED(1))
