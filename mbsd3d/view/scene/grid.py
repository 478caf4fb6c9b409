"""Round lengths: the cells of the ground grid, and how they are written."""

import numpy as np

STEPS = np.array([1.0, 2.0, 5.0, 10.0])


def round_up(length: float) -> float:
    """1, 2 or 5 times a power of ten, not below ``length``."""
    steps = STEPS * 10.0 ** np.floor(np.log10(length))
    return float(f"{steps[steps >= length][0]:.1g}")


def round_down(length: float) -> float:
    """1, 2 or 5 times a power of ten, not above ``length``."""
    steps = STEPS * 10.0 ** np.floor(np.log10(length))
    return float(f"{steps[steps <= length * (1.0 + 1e-9)][-1]:.1g}")


def length_text(length: float) -> str:
    """A length with a unit in which it is a usual number."""
    unit, factor = ("mm", 1e3) if length < 0.01 else ("km", 1e-3) if length >= 1000.0 else ("m", 1.0)
    return f"{length * factor:g} {unit}"
