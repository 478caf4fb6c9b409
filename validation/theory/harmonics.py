"""Harmonics of the inertia force of a slider-crank, by series and by Fourier transform."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.special import ellipe

from validation.theory.common import Array
from validation.theory.slider_crank import SliderCrank


def slider_crank_coefficients(lam: float, count: int) -> Array:
    """Fourier coefficients of the rod: ``sqrt(1 - lam^2 sin^2 q) = a_0 + sum_k a_2k cos(2 k q)``.

    ``a_2k = sum_(j >= k) C(1/2, j) (-1)^(j+k) 2^(1-2j) C(2j, j-k) lam^(2j)``, all terms of one sign;
    ``a_0 = (2 / pi) E(lam^2)``.

    ``lam``: crank radius over rod length, 0 <= lam < 1 [-]; ``count``: number of coefficients beyond a_0. Returns
    (count + 1,): a_0, a_2, a_4, ... [-]. ValueError if ``lam`` is outside [0, 1).
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

    ``mechanism``: masses and lengths; ``rate``: crank rate w [rad/s]; ``count``: number of even orders;
    ``centripetal``: false drops ``m_c w^2 r_c`` of the crank: what a solver returns that forgets the centripetal force
    of a body whose reference point is not its centre of mass. Returns orders and amplitudes.
    """
    crank = mechanism.crank_mass * mechanism.crank_centre * centripetal
    even = 2 * np.arange(1, count + 1)
    waves = slider_crank_coefficients(mechanism.radius / mechanism.rod_length, count)[1:]
    first = crank + (mechanism.rod_mass + mechanism.piston_mass) * mechanism.radius
    bore = np.concatenate([[first], mechanism.reciprocating * mechanism.rod_length * even**2 * waves])
    across = crank + (1 - mechanism.rod_fraction) * mechanism.rod_mass * mechanism.radius
    return EngineHarmonics(np.concatenate([[1], even]), rate**2 * bore, rate**2 * across)


def harmonic_amplitudes(signal: Callable[[Array], Array], count: int, samples: int = 256) -> Array:
    """Amplitudes of the harmonics 0 ... count of a signal of one turn, by the discrete Fourier transform.

    ``signal``: maps angles (n,) [rad] to values (n,); smooth and of period 2 pi; ``count``: highest harmonic, below
    ``samples / 2``; ``samples``: samples per turn; the error is that of the harmonics beyond ``samples - count``.
    Returns (count + 1,): mean and amplitudes, unit of the signal.
    """
    angles = 2 * np.pi * np.arange(samples) / samples
    spectrum = np.abs(np.fft.rfft(signal(angles))) / samples
    return np.concatenate([spectrum[:1], 2 * spectrum[1 : count + 1]])
