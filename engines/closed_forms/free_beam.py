"""A uniform beam with free ends in closed form: bending and torsion."""

import numpy as np
from scipy.optimize import brentq


def bending_roots(count: int) -> np.ndarray:
    """Return the roots k L > 0 of ``cosh(k L) cos(k L) = 1``; the frequencies grow as their squares; shape (count,)."""
    wanted = (np.arange(1, count + 1) + 0.5) * np.pi
    return np.array(
        [brentq(lambda x: np.cos(x) - 1 / np.cosh(x), root - 0.5, root + 0.5, xtol=1e-14) for root in wanted]
    )


def bending_shape(root: float, s: np.ndarray) -> np.ndarray:
    """Return the deflection at s = x / L from 0 to 1; its mean square over the length is 1.

    ``cosh + cos - g (sinh + sin)`` of k x, ``g = (cosh - cos) / (sinh - sin)`` of k L; the parts that grow are taken
    together, so that they do not cancel.
    """
    x, s = root, np.asarray(s)
    g = (np.cosh(x) - np.cos(x)) / (np.sinh(x) - np.sin(x))
    return ((1 - g) * np.exp(x * s) + (1 + g) * np.exp(-x * s)) / 2 + np.cos(x * s) - g * np.sin(x * s)


def torsion_shape(number: int, s: np.ndarray) -> np.ndarray:
    """Return the rotation in mode 1, 2 ...; its mean square is 1; frequencies grow as the number."""
    return np.sqrt(2.0) * np.cos(number * np.pi * np.asarray(s))
