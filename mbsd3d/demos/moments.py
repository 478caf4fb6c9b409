"""Moments of a run at which something happens, found in it: for the beats of a demo."""

from collections.abc import Callable

import numpy as np

from ..api.solution import Solution

Moment = Callable[[Solution], float]


def share(part: float) -> Moment:
    """Return the moment at a part of the run: 0 its start, 1 its end."""
    return lambda run: float(run.t[0] + part * (run.t[-1] - run.t[0]))


def first(condition: Callable[[Solution], np.ndarray]) -> Moment:
    """Return the first moment at which a condition (one value a sample) holds; the end where it never does."""

    def moment(run: Solution) -> float:
        return float(run.t[np.append(np.flatnonzero(condition(run)), -1)[0]])

    return moment


def most(quantity: Callable[[Solution], np.ndarray]) -> Moment:
    """Return the moment at which a quantity (one value a sample) is greatest."""
    return lambda run: float(run.t[int(np.argmax(quantity(run)))])
