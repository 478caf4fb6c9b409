"""Functions of time for drivers and forces: sums of polynomials, sines, pulses and cubic splines.

A signal is lowered to `terms`, rows of numbers that Python and the kernels evaluate alike; it has no other evaluation,
so what a user plots is what the model is driven by.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from .signal_terms import POLYNOMIAL, SINE, SPLINE, Term, evaluate, scaled

EVERYWHERE = (-np.inf, np.inf)


class Signal(ABC):
    """A function of time f(t), twice differentiable, in the unit of what it drives; t in s.

    Signals add up, with each other and with numbers, and are multiplied by numbers.

    >>> swing = 0.5 + 2 * Sine(amplitude=0.1, frequency=1.0)
    >>> round(float(swing(0.25)), 12)
    0.7
    """

    __array_ufunc__ = None  # a numpy number on the left leaves the operation to the signal

    @abstractmethod
    def terms(self) -> list[Term]:
        """Summands of f: what the kernels evaluate."""

    @property
    def interval(self) -> tuple[float, float]:
        """First and last time at which f is defined [s]."""
        return EVERYWHERE

    def __call__(self, t: ArrayLike) -> np.ndarray:
        """f(t) at times of any shape [s]; ValueError outside `interval`."""
        return self._at(t, 0)

    def derivative(self, t: ArrayLike) -> np.ndarray:
        """df/dt at times of any shape [s]; ValueError outside `interval`."""
        return self._at(t, 1)

    def second_derivative(self, t: ArrayLike) -> np.ndarray:
        """d2f/dt2 at times of any shape [s]; ValueError outside `interval`."""
        return self._at(t, 2)

    def _at(self, t: ArrayLike, order: int) -> np.ndarray:
        t = np.asarray(t, dtype=float)
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


@dataclass(frozen=True)
class Constant(Signal):
    """``f = value``.

    Raises ValueError if ``value`` is not a finite number.

    >>> Constant(2.5).derivative([0.0, 1.0])
    array([0., 0.])
    """

    value: float

    def __post_init__(self) -> None:
        _store_finite(self, "value")

    def terms(self) -> list[Term]:
        """The polynomial (value)."""
        return [Term(POLYNOMIAL, np.array([self.value]))]


@dataclass(frozen=True)
class Ramp(Signal):
    """``f = offset + rate t``, with ``rate`` in the unit of f per second.

    Raises ValueError if a number is not finite.

    >>> float(Ramp(rate=2.0, offset=1.0)(3.0))
    7.0
    """

    rate: float
    offset: float = 0.0

    def __post_init__(self) -> None:
        _store_finite(self, "rate", "offset")

    def terms(self) -> list[Term]:
        """The polynomial (offset, rate)."""
        return [Term(POLYNOMIAL, np.array([self.offset, self.rate]))]


@dataclass(frozen=True)
class Sine(Signal):
    """``f = offset + amplitude sin(2 pi frequency t + phase)``, with ``frequency`` in Hz and ``phase`` in rad.

    Raises ValueError if a number is not finite.

    >>> Sine(amplitude=3.0, frequency=2.0, offset=1.0)([0.0, 0.125])
    array([1., 4.])
    """

    amplitude: float
    frequency: float
    phase: float = 0.0
    offset: float = 0.0

    def __post_init__(self) -> None:
        _store_finite(self, "amplitude", "frequency", "phase", "offset")

    def terms(self) -> list[Term]:
        """The sine, and the polynomial (offset) if there is one."""
        sine = Term(SINE, np.array([self.amplitude, 2.0 * np.pi * self.frequency, self.phase]))
        return [sine, Term(POLYNOMIAL, np.array([self.offset]))] if self.offset else [sine]


@dataclass(frozen=True)
class Polynomial(Signal):
    """``f = c0 + c1 t + c2 t^2 + ...`` from coefficients in ascending powers, ``c_k`` in the unit of f per s^k.

    Raises ValueError if there is no coefficient, or one is not a finite number.

    >>> float(Polynomial((1.0, 0.0, 3.0)).derivative(2.0))
    12.0
    """

    coefficients: tuple[float, ...]

    def __post_init__(self) -> None:
        values = _row(self.coefficients, "Polynomial: coefficients")
        if values.size == 0:
            raise ValueError("Polynomial: coefficients is empty; give at least the constant c0")
        object.__setattr__(self, "coefficients", tuple(values.tolist()))

    def terms(self) -> list[Term]:
        """The polynomial itself."""
        return [Term(POLYNOMIAL, np.array(self.coefficients))]


@dataclass(frozen=True, eq=False)
class Table(Signal):
    """Cubic spline through measured points (not-a-knot: the third derivative is continuous next to both ends).

    Parameters
    ----------
    times : (n,) array_like
        At least four strictly increasing times [s].
    values : (n,) array_like
        Value at each of them.

    Raises
    ------
    ValueError
        If the lengths differ, a number is not finite, there are fewer than four, or the times do not increase.

    Examples
    --------
    >>> cube = Table([0.0, 1.0, 2.0, 4.0], [0.0, 1.0, 8.0, 64.0])
    >>> round(float(cube(3.0)), 12), cube.interval
    (27.0, (0.0, 4.0))
    """

    times: np.ndarray
    values: np.ndarray

    def __post_init__(self) -> None:
        times, values = _row(self.times, "Table: times"), _row(self.values, "Table: values")
        if times.size != values.size:
            raise ValueError(f"Table: {times.size} times but {values.size} values; give one value per time")
        if times.size < 4:
            raise ValueError(f"Table: {times.size} points; a cubic spline needs 4 (Ramp, Polynomial: fewer)")
        late = np.flatnonzero(np.diff(times) <= 0.0)
        if late.size:
            i = late[0]
            raise ValueError(
                f"Table: times[{i + 1}] = {times[i + 1]:.9g} does not come after times[{i}] = {times[i]:.9g}; "
                f"sort the points and keep one per time"
            )
        times.flags.writeable = values.flags.writeable = False
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "values", values)

    @property
    def interval(self) -> tuple[float, float]:
        """First and last time of the table [s]."""
        return float(self.times[0]), float(self.times[-1])

    def terms(self) -> list[Term]:
        """The spline."""
        return [self._term]

    @cached_property
    def _term(self) -> Term:
        pieces = CubicSpline(self.times, self.values, bc_type="not-a-knot").c.T
        return Term(SPLINE, np.concatenate([[len(pieces)], self.times, pieces.ravel()]))


@dataclass(frozen=True)
class Pulse(Signal):
    """From zero to ``height`` and back; zero before ``start`` and again ``duration`` later.

    Rise and fall take the time ``edge`` each and have no corners: ``height (3 s^2 - 2 s^3)`` of its share s.
    The integral of the pulse is ``height (duration - edge)``.

    Parameters
    ----------
    height : float
        In the unit of f.
    start, edge : float
        [s]; edge > 0.
    duration : float or None
        [s] >= 2 edge; None = a step, it does not fall.

    Raises
    ------
    ValueError
        If a number is not finite, the edge is not positive or the duration is below two edges.

    Examples
    --------
    >>> Pulse(height=3.0, start=1.0, edge=0.1, duration=0.5)([0.9, 1.05, 1.2, 1.6]).round(12)
    array([0. , 1.5, 3. , 0. ])
    """

    height: float
    start: float
    edge: float
    duration: float | None = None

    def __post_init__(self) -> None:
        _store_finite(self, "height", "start", "edge", *(() if self.duration is None else ("duration",)))
        if not self.edge > 0.0:
            raise ValueError(f"Pulse: edge is {self.edge:g} s; give a positive time")
        if self.duration is not None and not self.duration >= 2.0 * self.edge:
            raise ValueError(f"Pulse: duration is {self.duration:g} s; give at least two edges, {2.0 * self.edge:g} s")

    def terms(self) -> list[Term]:
        """Zero, rise, height, fall and zero as cubic pieces; a step ends with its height."""
        a, b, h = self.start, self.edge, self.height
        rise, level, zero = (-2.0 * h / b**3, 3.0 * h / b**2, 0.0, 0.0), (0.0, 0.0, 0.0, h), (0.0,) * 4
        pieces = {a - b: zero, a: rise, a + b: level}  # those next to the ends go on for ever
        if self.duration is not None:
            end = a + self.duration
            fall = max(end - b, a + b)  # right after the rise it takes the place of the level
            pieces |= {fall: (-rise[0], -rise[1], 0.0, h), end: zero}
        breaks = [*pieces, max(pieces) + b]
        return [Term(SPLINE, np.concatenate([[len(pieces)], breaks, np.ravel(list(pieces.values()))]))]


@dataclass(frozen=True)
class Sum(Signal):
    """Sum of signals; ``a + b`` makes it.

    Raises ValueError if the intervals of two tables have no time in common.

    >>> Ramp(1.0) + 2.0 == Sum((Ramp(1.0), Constant(2.0)))
    True
    """

    signals: tuple[Signal, ...]

    def __post_init__(self) -> None:
        start, end = self.interval
        if not start < end:
            raise ValueError(
                f"sum of signals: one starts at {start:.9g} s, when another has ended at {end:.9g} s; "
                f"give tables of the same interval"
            )

    @property
    def interval(self) -> tuple[float, float]:
        """Where all of them are defined [s]."""
        starts, ends = zip(*(signal.interval for signal in self.signals), strict=True)
        return max(starts), min(ends)

    def terms(self) -> list[Term]:
        """The terms of all."""
        return [term for signal in self.signals for term in signal.terms()]


@dataclass(frozen=True)
class Scaled(Signal):
    """``factor`` times a signal; ``2 * signal`` and ``-signal`` make it.

    Raises ValueError if ``factor`` is not a finite number.

    >>> 2.0 * Ramp(1.0) == Scaled(Ramp(1.0), 2.0)
    True
    """

    signal: Signal
    factor: float

    def __post_init__(self) -> None:
        _store_finite(self, "factor")

    @property
    def interval(self) -> tuple[float, float]:
        """That of the signal [s]."""
        return self.signal.interval

    def terms(self) -> list[Term]:
        """The terms of the signal with the numbers that are linear in f multiplied."""
        return [scaled(term, self.factor) for term in self.signal.terms()]


def as_signal(value: "Signal | float", what: str) -> Signal:
    """A signal as it is, a number as a `Constant`.

    Parameters
    ----------
    value : Signal or float
        In the unit of what it drives.
    what : str
        Name of the quantity in error messages, e.g. ``"driver 'motor': speed"``.

    Returns
    -------
    Signal
        The function of time.

    Raises
    ------
    ValueError
        If it is neither, or a number that is not finite.
    """
    remedy = "give a finite number or a signal (Constant, Ramp, Sine, Polynomial, Pulse, Table or a sum of them)"
    if isinstance(value, Signal):
        return value
    if not isinstance(value, Real):
        raise ValueError(f"{what} is {value!r}; {remedy}; any other function can be sampled into a Table")
    if not np.isfinite(value):
        raise ValueError(f"{what} is {value}; {remedy}")
    return Constant(value)


def check_interval(signal: Signal, start: float, end: float, what: str) -> None:
    """Refuse a run that leaves the interval on which a signal is defined.

    Parameters
    ----------
    signal : Signal
        The function of time.
    start, end : float
        First and last time of the run [s]; 1e-9 of the interval may be missing, the rounding of a last step.
    what : str
        Name of the quantity in error messages, e.g. ``"driver 'motor'"``.

    Raises
    ------
    ValueError
        If it does.
    """
    first, last = signal.interval
    margin = 1e-9 * (last - first)
    if not (start >= first - margin and end <= last + margin):
        raise ValueError(
            f"{what}: the table covers {first:.9g} s to {last:.9g} s and is asked for {start:.9g} s to {end:.9g} s; "
            f"extend the table or stay inside it"
        )


def _store_finite(signal: Signal, *names: str) -> None:
    """Store the named fields as floats, or say which one is not a finite number."""
    for name in names:
        value = getattr(signal, name)
        if not isinstance(value, Real) or not np.isfinite(value):
            raise ValueError(f"{type(signal).__name__}: {name} is {value!r}; give a finite number")
        object.__setattr__(signal, name, float(value))


def _row(values: ArrayLike, what: str) -> np.ndarray:
    """Own copy of a row of finite floats."""
    try:
        row = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{what} {values!r} is not numeric; give a row of finite numbers") from None
    if row.ndim != 1:
        raise ValueError(f"{what} has shape {row.shape}; give a row of finite numbers")
    if not np.all(np.isfinite(row)):
        raise ValueError(f"{what}[{np.flatnonzero(~np.isfinite(row))[0]}] is not finite; give a row of finite numbers")
    return row
