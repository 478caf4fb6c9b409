"""Signals as functions of time for Exudyn to call."""

from collections.abc import Callable
from typing import Any

from mbsd3d.extend import evaluate


def follow(signal: Any, order: int = 0) -> Callable[[float], float]:
    """f(t) or a derivative; a table goes on outside its interval, where differences at its ends ask for it."""
    terms = signal.terms()
    return lambda t: float(evaluate(terms, t, order))
