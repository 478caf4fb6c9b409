"""Checks of input: errors name the value and the remedy."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike


class Frozen:
    """Base of frozen dataclasses that check and convert their fields when they are made."""

    def _store(self, **values: Any) -> None:
        """Write converted values into the fields; arrays become read-only."""
        for name, value in values.items():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
            object.__setattr__(self, name, value)


def vector(value: ArrayLike, what: str) -> np.ndarray:
    """A finite (3,) float array, or a ValueError that names ``what``."""
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{what}: expected three numbers, got {value!r}") from None
    if array.shape != (3,):
        raise ValueError(f"{what}: expected three numbers, got {value!r}")
    if not np.isfinite(array).all():
        raise ValueError(f"{what}: not finite: {array.tolist()}; give finite numbers")
    array.setflags(write=False)
    return array


def number(value: float, what: str, *, minimum: float | None = None, positive: bool = False) -> float:
    """A finite float within its range, or a ValueError that names ``what``."""
    try:
        x = float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{what}: expected a number, got {value!r}") from None
    if not np.isfinite(x):
        raise ValueError(f"{what}: not finite ({x}); give a finite number")
    if positive and x <= 0.0:
        raise ValueError(f"{what}: {x} is not positive; give a number > 0")
    if minimum is not None and x < minimum:
        raise ValueError(f"{what}: {x} is below {minimum}; give a number >= {minimum}")
    return x


def sequence(values: Any, what: str) -> tuple[float, ...]:
    """Finite numbers."""
    try:
        given = tuple(values)
    except TypeError:
        raise ValueError(f"{what}: {values!r} is not a sequence of numbers; give a tuple") from None
    return tuple(number(value, f"{what} no. {k + 1}") for k, value in enumerate(given))
