"""Terms: the rows of numbers that signals are lowered to, and their meaning in Python.

``kernels/signals.py`` holds the compiled counterpart of `evaluate`.
"""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike

from ...base.errors import InputError

POLYNOMIAL, SINE, SPLINE = 0, 1, 2
PULSE_SHARE_MIN = 1e-3  # [1] of the range of a table: what turns back by less is not a pulse


class Term(NamedTuple):
    """One summand of a signal.

    ======================= ==================================================================================
    kind                    data, (k,) float array
    ======================= ==================================================================================
    ``POLYNOMIAL``          c0, c1, ...: ``c0 + c1 t + ...``
    ``SINE``                A, omega [rad/s], phase [rad]: ``A sin(omega t + phase)``
    ``SPLINE``              number of pieces n, breaks (n + 1) [s], then c3, c2, c1, c0 of each piece:
                            ``c3 s^3 + c2 s^2 + c1 s + c0`` with ``s = t - break_i``; the end pieces go on outside
    ======================= ==================================================================================

    ``input`` is (name, value at the start) of the `Input` whose value times ``factor`` the data hold; None = they are
    fixed.
    """

    kind: int
    data: np.ndarray
    input: tuple[str, float] | None = None
    factor: float = 1.0


def evaluate(terms: list[Term], t: ArrayLike, order: int = 0) -> np.ndarray:
    """Sum of terms at times t (...) [s], or its derivative ``d^order f / dt^order``; another order than 0, 1, 2:
    ValueError.
    """
    if order not in (0, 1, 2):
        raise InputError(f"evaluate: order is {order!r}; give 0, 1 or 2")
    t = np.asarray(t, dtype=float)
    return sum((_EVALUATE[term.kind](term.data, t, order) for term in terms), np.zeros(t.shape))


def _polynomial(data: np.ndarray, t: np.ndarray, order: int) -> np.ndarray:
    """Return the derivative of c0 + c1 t + ..."""
    return polynomial.polyval(t, polynomial.polyder(data, order))


def _sine(data: np.ndarray, t: np.ndarray, order: int) -> np.ndarray:
    """Return the derivative of A sin(omega t + phase)."""
    amplitude, omega, phase = data
    wave = np.cos if order == 1 else np.sin
    return (amplitude, amplitude * omega, -amplitude * omega**2)[order] * wave(omega * t + phase)


def _spline(data: np.ndarray, t: np.ndarray, order: int) -> np.ndarray:
    """Return the derivative of the cubic piece that holds t, the first or last one outside."""
    n = int(data[0])
    breaks, pieces = data[1 : n + 2], data[n + 2 :].reshape(n, 4)
    i = np.clip(np.searchsorted(breaks, t, side="right") - 1, 0, n - 1)
    s, (c3, c2, c1, c0) = t - breaks[i], np.moveaxis(pieces[i], -1, 0)
    if order == 0:
        return ((c3 * s + c2) * s + c1) * s + c0
    return (3.0 * c3 * s + 2.0 * c2) * s + c1 if order == 1 else 6.0 * c3 * s + 2.0 * c2


def turning_times(data: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return times (k,) [s] where a spline turns back or becomes or ceases to be flat, and whether f'' jumps there.

    Read at its breaks and between them, where it swings after a sharp corner. Steps of an integrator that end there see
    every pulse, however short it is and however long they are.
    """
    n = int(data[0])
    breaks, second = data[1 : n + 2], 2.0 * data[n + 2 :].reshape(n, 4)[:, 1]
    times = np.append(np.column_stack([breaks[:-1], 0.5 * (breaks[:-1] + breaks[1:])]).ravel(), breaks[-1])
    values = _spline(data, times, 0)
    rise, least = np.diff(values), PULSE_SHARE_MIN * np.ptp(values)
    flat = np.abs(rise) <= PULSE_SHARE_MIN * least
    edges = 1 + np.flatnonzero(flat[1:] != flat[:-1])
    places = np.union1d(edges, 1 + np.flatnonzero(rise[1:] * rise[:-1] < 0.0)).tolist()
    places = [0, *places, 2 * n]
    turns = [places[k] for k in _reversals(values[places].tolist(), least)]
    before = np.nextafter(breaks[1:-1], -np.inf)
    jumps = 2 + 2 * np.flatnonzero(
        np.abs(second[1:] - _spline(data, before, 2)) > PULSE_SHARE_MIN * np.abs(second).max()
    )
    found = np.unique(np.concatenate([edges, turns, jumps])).astype(int)
    return times[found], np.isin(found, jumps)


def _reversals(values: list[float], least: float) -> list[int]:
    """Return the places behind the first one from which the values go back by more than ``least``."""
    found, low, high, rising, falling = [], 0, 0, True, True
    for k, value in enumerate(values):
        if rising:
            high = k if value > values[high] else high
        if falling:
            low = k if value < values[low] else low
        if rising and values[high] - value > least:
            found.append(high)
            low, rising, falling = k, False, True
        elif falling and value - values[low] > least:
            found.append(low)
            high, rising, falling = k, True, False
    return [k for k in found if k > 0]


_EVALUATE = {POLYNOMIAL: _polynomial, SINE: _sine, SPLINE: _spline}


def scaled(term: Term, factor: float) -> Term:
    """Multiply a term by a factor; frequency, phase and breaks stay."""
    first, last = {POLYNOMIAL: (0, None), SINE: (0, 1), SPLINE: (int(term.data[0]) + 2, None)}[term.kind]
    data = term.data.copy()
    data[first:last] *= factor
    return Term(term.kind, data, term.input, factor * term.factor)
