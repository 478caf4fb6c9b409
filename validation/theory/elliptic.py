"""Elliptic integrals and Jacobi functions, exact to rounding up to the separatrix."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import elliprf

from validation.theory.common import EXTENDED, Array


def quarter_period(m1: float) -> float:
    """Complete elliptic integral ``K = R_F(0, m1, 1)``, infinite for ``m1 = 0``.

    ``m1``: complement ``1 - m`` of the parameter, 0 <= m1 <= 1 [-]. Returns K [-]. ValueError if ``m1`` is outside [0,
    1].
    """
    if not 0.0 <= m1 <= 1.0:
        raise ValueError(f"elliptic parameter m1 = {m1}: must lie in [0, 1] (m1 is 1 - m)")
    return np.inf if m1 == 0.0 else float(elliprf(0.0, float(m1), 1.0))


def elliptic_phase(sine: float, cosine: float, m1: float) -> float:
    """Argument u in [-K, K] with ``sn u = sine`` and ``cn u = cosine >= 0``.

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
    """Jacobi functions by the arithmetic-geometric mean, exact to rounding also for ``m1 -> 0``.

    ``phi_N = 2^N a_N u`` and ``2 phi_(n-1) = phi_n + asin(c_n sin(phi_n) / a_n)`` down to ``am u = phi_0``;
    ``dn^2 = m1 + (1 - m1) cn^2`` has no cancellation. ``m1 = 0``: ``am u = 2 atan(tanh(u / 2))``.

    ``u``: argument [-]; ``m1``: complement ``1 - m`` of the parameter [-]. Returns am, sn, cn, dn and the split of the
    argument.
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
