"""Weighting of vertical vibration of seated people by ISO 2631-1, W_k.

H(s) = high pass (0.4 Hz) * low pass (100 Hz) * (1 + s / w3) / (1 + s / (Q4 w4) + s^2 / w4^2)
       * (w5 / w6)^2 (1 + s / (Q5 w5) + s^2 / w5^2) / (1 + s / (Q6 w6) + s^2 / w6^2)
"""

import numpy as np
from scipy.signal import TransferFunction

F3, F4, Q4 = 12.5, 12.5, 0.63
F5, Q5, F6, Q6 = 2.37, 0.91, 3.35, 0.91
LOW_CORNER, HIGH_CORNER = 0.4, 100.0
REACTIONS = ((0.315, "not uncomfortable"), (0.63, "a little uncomfortable"), (1.0, "fairly uncomfortable"),
         (1.6, "uncomfortable"), (2.5, "very uncomfortable"), (np.inf, "extremely uncomfortable"))  # fmt: skip


def quadratic(frequency: float, Q: float) -> np.ndarray:
    """Return the coefficients of ``1 + s / (Q w) + s^2 / w^2``, highest power first."""
    w = 2 * np.pi * frequency
    return np.array([1 / w**2, 1 / (Q * w), 1.0])


def weighting() -> TransferFunction:
    """Return W_k as a transfer function of s."""
    above = np.array([1 / (2 * np.pi * LOW_CORNER) ** 2, 0.0, 0.0])
    numerator = np.polymul(above, [1 / (2 * np.pi * F3), 1.0])
    numerator = (F5 / F6) ** 2 * np.polymul(numerator, quadratic(F5, Q5))
    denominator = np.array([1.0])
    for part in (
        quadratic(LOW_CORNER, np.sqrt(0.5)),
        quadratic(HIGH_CORNER, np.sqrt(0.5)),
        quadratic(F4, Q4),
        quadratic(F6, Q6),
    ):
        denominator = np.polymul(denominator, part)
    return TransferFunction(numerator, denominator)


def weight(frequency: np.ndarray) -> np.ndarray:
    """Return W_k at frequencies [Hz], complex."""
    H, s = weighting(), 2j * np.pi * np.asarray(frequency)
    return np.polyval(H.num, s) / np.polyval(H.den, s)


def verdict(acceleration: float) -> str:
    """Return the likely reaction of people in public transport to a weighted acceleration [m/s^2] (annex C).

    The ranges of the standard overlap; the milder word is taken up to the end of its range.
    """
    return next(word for limit, word in REACTIONS if acceleration <= limit)
