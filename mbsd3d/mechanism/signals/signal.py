"""Base class of signals: values and derivatives, sums, multiples, and numbers as constant signals.

A signal is lowered to `terms`, rows of numbers that Python and the kernels evaluate alike; it has no other evaluation,
so the plotted signal is the one that drives the model.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from itertools import chain
from numbers import Real
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import MAGNITUDE_MAX, as_tuple, check_name, floats, number, short_repr
from ...base.errors import InputError
from ...base.fields import Checked, Stored, derive, kept, locked, or_none, part_class
from .terms import POLYNOMIAL, Term, evaluate, scaled

ALL_TIMES = (-np.inf, np.inf)


class Signal(Checked, ABC):
    """A function of time f(t), twice differentiable, in the unit of the driven quantity; t in s.

    Signals can be added to each other and to numbers, and multiplied by numbers.

    >>> from mbsd3d import Sine
    >>> swing = 0.5 + 2 * Sine(amplitude=0.1, frequency=1.0)
    >>> round(float(swing(0.25)), 12)
    0.7
    """

    __array_ufunc__ = None  # a numpy number on the left leaves the operation to the signal

    @abstractmethod
    def terms(self) -> list[Term]:
        """Return the summands of f: what the kernels evaluate."""

    @property
    def interval(self) -> tuple[float, float]:
        """Return the first and last time at which f is defined [s]."""
        return ALL_TIMES

    def __call__(self, t: ArrayLike) -> np.ndarray:
        """Return f(t) at times of any shape [s]; ValueError outside `interval`."""
        return self._at(t, 0)

    def derivative(self, t: ArrayLike) -> np.ndarray:
        """Return df/dt at times of any shape [s]; ValueError outside `interval`."""
        return self._at(t, 1)

    def second_derivative(self, t: ArrayLike) -> np.ndarray:
        """Return d2f/dt2 at times of any shape [s]; ValueError outside `interval`."""
        return self._at(t, 2)

    def _at(self, t: ArrayLike, order: int) -> np.ndarray:
        t = floats(t, f"{type(self).__name__}: t", "times [s]")
        if t.size:
            check_interval(self, t.min(), t.max(), type(self).__name__)
        return evaluate(self.terms(), t, order)

    def __add__(self, other: "Signal | float") -> "Signal":
        if not isinstance(other, (Signal, Real)):
            return NotImplemented
        return Sum((self, as_signal(other, "sum of signals")))

    def __radd__(self, other: float) -> "Signal":
        return self + other

    def __sub__(self, other: "Signal | float") -> "Signal":
        return self + -other

    def __rsub__(self, other: float) -> "Signal":
        return -self + other

    def __neg__(self) -> "Signal":
        return Scaled(self, -1.0)

    def __mul__(self, factor: float) -> "Signal":
        return Scaled(self, factor) if isinstance(factor, Real) else NotImplemented

    def __rmul__(self, factor: float) -> "Signal":
        return self * factor


def finite(value: Any, what: str, part: Any) -> float:
    """Return a finite real number whose square is finite."""
    real: Any = value if isinstance(value, float | Real) else np.nan
    if real != real or abs(real) == np.inf:
        raise InputError(f"{what} is {short_repr(value)}; give a finite number")
    return number(real, what)


class FiniteNumber(Stored[float, float]):
    """A finite number of a signal."""

    accepts, file_type = "float", float
    convert = staticmethod(finite)


class FiniteNumberOrNone(Stored[float | None, float | None]):
    """A finite number of a signal, or None."""

    accepts, file_type = "float | None", float | None
    convert = staticmethod(or_none(finite))


@part_class(eq=True)
class Constant(Signal):
    """``f = value``.

    Raises ValueError if ``value`` is not a finite number.

    >>> Constant(2.5).derivative([0.0, 1.0])
    array([0., 0.])
    """

    value: FiniteNumber = kept()

    def terms(self) -> list[Term]:
        """Return the polynomial (value)."""
        return [Term(POLYNOMIAL, np.array([self.value]))]


def as_summands(value: Any, what: str, part: Any) -> tuple[Signal, ...]:
    """Return the signals of a sum, none of which is a sum itself."""
    signals = as_tuple(value, what, "a tuple of signals")
    if not signals or not all(isinstance(signal, Signal) for signal in signals):
        raise InputError(f"{what} {short_repr(value)}; give a tuple of signals")
    return tuple(chain.from_iterable(map(_summands, signals)))


class Summands(Stored[Sequence[Signal], tuple[Signal, ...]]):
    """Summands of a sum of signals."""

    accepts, role, file_type = "Sequence[Signal]", "signal", list[dict[str, Any]]
    convert = staticmethod(as_summands)


@part_class(eq=True)
class Sum(Signal):
    """Sum of signals; ``a + b`` makes it. Nested sums, and multiples of sums, are flattened.

    Raises ValueError if the intervals of two tables have no time in common.

    >>> from mbsd3d import Ramp
    >>> Ramp(1.0) + 2.0 == Sum((Ramp(1.0), Constant(2.0)))
    True
    """

    signals: Summands = kept()

    def check(self, what: str) -> None:
        start, end = self.interval
        if not start < end:
            raise InputError(
                f"sum of signals: one starts at {start:.9g} s, when another has ended at {end:.9g} s; "
                f"give tables of the same interval"
            )

    @property
    def interval(self) -> tuple[float, float]:
        """Return the time interval [s] on which all summands are defined."""
        starts, ends = zip(*(signal.interval for signal in self.signals), strict=True)
        return max(starts), min(ends)

    def terms(self) -> list[Term]:
        """Return the terms of all summands, one after the other."""
        return [term for signal in self.signals for term in signal.terms()]


@part_class(eq=True)
class Scaled(Signal):
    """``factor`` times a signal; ``2 * signal`` and ``-signal`` make it. A multiple of a multiple is one.

    Raises ValueError if ``factor`` is not a finite number.

    >>> from mbsd3d import Ramp
    >>> 2.0 * Ramp(1.0) == Scaled(Ramp(1.0), 2.0)
    True
    """

    signal: Signal
    factor: FiniteNumber = kept()

    def check(self, what: str) -> None:
        if isinstance(self.signal, Scaled):
            factor = finite(self.signal.factor * self.factor, f"{what}: factor", self)
            derive(self, signal=self.signal.signal, factor=factor)

    @property
    def interval(self) -> tuple[float, float]:
        """Return the time interval [s] on which the signal is defined."""
        return self.signal.interval

    def terms(self) -> list[Term]:
        """Return the terms of the signal with the numbers that are linear in f multiplied."""
        return [scaled(term, self.factor) for term in self.signal.terms()]


def _summands(signal: Signal) -> Sequence[Signal]:
    """Return what a signal is a sum of, so that signals made by loops are no deeper than their parts."""
    if isinstance(signal, Sum):
        return signal.signals
    if isinstance(signal, Scaled) and isinstance(signal.signal, Sum):
        return [Scaled(one, signal.factor) for one in signal.signal.signals]
    return (signal,)


def as_signal(value: "Signal | float", what: str) -> Signal:
    """Return a signal as it is, a finite number as a `Constant`; else raise a ValueError that starts with ``what``."""
    remedy = "give a finite number or a signal (Constant, Ramp, Sine, Polynomial, Pulse, Table, Input or a sum of them)"
    if isinstance(value, Signal):
        return value
    if type(value) is float and abs(value) <= MAGNITUDE_MAX:
        return Constant(value)
    if not isinstance(value, Real):
        raise InputError(f"{what} is {short_repr(value)}; {remedy}; any other function can be sampled into a Table")
    if value != value or abs(value) == np.inf:
        raise InputError(f"{what} is {value}; {remedy}")
    return Constant(number(value, what))


def signal_of(value: Any, what: str, part: Any) -> Signal:
    """Accept a signal."""
    return as_signal(value, what)


def three_signals_of(value: Any, what: str, part: Any) -> tuple[Signal | None, ...]:
    """Accept three signals."""
    return three_signals(value, what)


def three_or_free(value: Any, what: str, part: Any) -> tuple[Signal | None, ...]:
    """Accept three signals, or None for free directions, but not for all of them."""
    signals = three_signals(value, what, free=True)
    if not any(signals):
        raise InputError(f"{what.removesuffix(': signal')}: all three directions are free; give at least one signal")
    return signals


def three_signals(value: Any, what: str, free: bool = False) -> tuple[Signal | None, ...]:
    """Convert three components, each a number or a signal, or None where ``free`` allows it."""
    try:
        x, y, z = value
    except (TypeError, ValueError):
        none = " (None = free)" if free else ""
        raise InputError(f"{what}: give three components, three signals or numbers{none}") from None
    named = zip("xyz", (x, y, z), strict=True)
    return tuple(None if free and s is None else as_signal(s, f"{what} along {k}") for k, s in named)


class SignalField(Stored[Signal | float, Signal]):
    """A signal, or a number that is kept as a `Constant`."""

    accepts, role, file_type = "Signal | float", "signal", dict | float
    convert = staticmethod(signal_of)


class SignalOrNone(Stored[Signal | float | None, Signal | None]):
    """A signal, a number, or None."""

    accepts, role, file_type = "Signal | float | None", "signal", dict | float | None
    convert = staticmethod(or_none(signal_of))


class ThreeSignals(Stored[Sequence[Signal | float] | np.ndarray, tuple[Signal, Signal, Signal]]):
    """Three signals or numbers."""

    accepts, role, file_type = "Sequence[Signal | float] | array_like", "signal", list[dict[str, Any] | float]
    convert = staticmethod(three_signals_of)


class ThreeSignalsOrFree(Stored[Sequence[Signal | float | None], tuple[Signal | None, Signal | None, Signal | None]]):
    """Three signals, numbers, or None where a direction is free."""

    accepts, role, file_type = "Sequence[Signal | float | None]", "signal", list[dict[str, Any] | float | None]
    convert = staticmethod(three_or_free)


def check_interval(signal: Signal, start: float, end: float, what: str) -> None:
    """Raise a ValueError for a run from ``start`` to ``end`` [s] that leaves the interval on which a signal is defined.

    1e-9 of the interval may be missing, the rounding of a last step; ``what`` names the part, "driver 'motor'".
    """
    first, last = signal.interval
    margin = 1e-9 * (last - first)
    if not (start >= first - margin and end <= last + margin):
        raise InputError(
            f"{what}: the table covers {first:.9g} s to {last:.9g} s and is asked for {start:.9g} s to {end:.9g} s; "
            f"extend the table or stay inside it"
        )


def as_row(values: Any, what: str, part: Any) -> np.ndarray:
    """Return a new row of finite floats."""
    row = floats(values, what, "a row of finite numbers")
    if row.ndim != 1:
        raise InputError(f"{what} has shape {row.shape}; give a row of finite numbers")
    return locked(row)


class Row(Stored[ArrayLike, np.ndarray]):
    """A row of finite numbers."""

    accepts = "array_like"
    convert = staticmethod(as_row)


@part_class(eq=True)
class Input(Signal):
    """``f = value`` until `Stepper.set` gives another number, which holds, or goes on with a slope, until the next one.

    Parameters
    ----------
    name : str
        Name used to set it; signals of the same name are one input.
    value : float
        Initial value, in the unit of the driven quantity; `simulate` keeps it.

    Raises
    ------
    ValueError
        If there is no name, or the value is not a finite number.

    Examples
    --------
    >>> throttle = Input("throttle", 0.5)
    >>> float((2.0 * throttle + 1.0)(3.0))
    2.0
    """

    name: str
    value: FiniteNumber = kept(default=0.0)

    def check(self, what: str) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise InputError(f"Input: name {self.name!r}; give a text, e.g. Input('throttle')")
        check_name(self.name, "Input:")

    def terms(self) -> list[Term]:
        """Return the polynomial (value, slope)."""
        return [Term(POLYNOMIAL, np.array([self.value, 0.0]), (self.name, self.value))]


InputOrName = TypeVar("InputOrName", bound=Input | str)  # key of a mapping: type checkers take dict[str, ...] then
