"""Convergence: what a ladder of runs with halved steps tends to, at which order, and how far that can be trusted."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from validation.engines.base import Array

ROUNDING = 1e-12
"""Gaps below this part of a quantity's size are rounding of 10^3 to 10^6 steps: no order is read from them."""
FEWEST = 4
"""Runs that a limit is taken from at least: three give an order, the fourth shows whether it stays."""
LEAST_ORDER = 0.5
"""Below it halving the step hardly helps, and extrapolating would only amplify."""


@dataclass(frozen=True)
class Limit:
    """Limit of a quantity over ever shorter steps, all relative to its size.

    Attributes
    ----------
    values : (n, parts, k) array
        Richardson's limit of the finest runs.
    error : (n,) array
        How uncertain it is up to each sample: by how much the limit moves when the finest run is added, and when it
        is extrapolated with the expected order instead of the observed one.
    order : float or None
        Observed: log2 of the ratio of the last two gaps; None if they are rounding.
    gaps : tuple
        Greatest differences of neighbouring runs.
    """

    values: Array
    error: Array
    order: float | None
    gaps: tuple[float, ...]


def running_max(values: Array) -> Array:
    """(n,) greatest absolute value over all parts up to each sample, of (n, parts, k)."""
    return np.maximum.accumulate(np.abs(values).reshape(len(values), -1).max(axis=1, initial=0.0))


def observed_order(gaps: Sequence[float]) -> float | None:
    """log2 of the ratio of neighbouring gaps, of the last pair above rounding; None if there is none."""
    for coarse, fine in reversed(list(zip(gaps[:-1], gaps[1:], strict=True))):
        if fine > ROUNDING:
            return float(np.log2(coarse / fine)) if coarse > 0.0 else 0.0
    return None


def limit_of(runs: Sequence[Array], expected: float, span: int | None = None, first: int = 0) -> Limit:
    """Limit of three or more runs (n, parts, k), each with half the step of the one before; relative numbers.

    The order is observed from sample ``first`` up to ``span`` (None: all), and used for the extrapolation: with gaps d
    and order p the limit lies d / (2^p - 1) beyond the finest run. Three runs carry two such limits; their distance is
    the error, with what the ``expected`` order would change: an order fitted to two gaps makes their limits agree.

    Raises
    ------
    ValueError
        For fewer than three runs: order and error need three.
    """
    if len(runs) < 3:
        raise ValueError(f"limit_of: {len(runs)} runs; give three or more with halved steps")
    moves = [fine - coarse for coarse, fine in zip(runs[:-1], runs[1:], strict=True)]
    counts = (np.arange(len(runs[0])) >= first)[:, None, None]
    gaps = tuple(float(np.abs(move[first:span]).max(initial=0.0)) for move in moves)
    order, last = observed_order(gaps), running_max(moves[-1] * counts)
    if order is None:
        return Limit(runs[-1], last + ROUNDING, None, gaps)
    if order < LEAST_ORDER:
        return Limit(runs[-1], last + running_max(moves[-2] * counts), order, gaps)
    beyond, usual = (1.0 / (2.0**p - 1.0) for p in (order, expected))
    coarser, finer = (run + beyond * move for run, move in zip(runs[-2:], moves[-2:], strict=True))
    error = running_max((finer - coarser) * counts) + abs(beyond - usual) * last + ROUNDING
    return Limit(finer, error, order, gaps)


def best_limit(runs: Sequence[Array], expected: float, span: int | None = None, first: int = 0) -> Limit:
    """The limit of the first runs, as many as give the smallest error: finer ones may only add rounding.

    An implicit engine divides the errors of its iterations by the step, or by its square in multipliers.
    """
    last = -1 if span is None else span - 1
    found = [limit_of(runs[:count], expected, span, first) for count in range(FEWEST, len(runs) + 1)]
    return min(found, key=lambda limit: limit.error[last])
