"""Functions of time: ramps, sines, polynomials, tables, pulses."""

import csv
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import check_size, short_repr
from ...base.errors import InputError, checks_method_arguments
from ...base.fields import Stored, kept, part_class
from ...base.paths import as_path, read_text
from ...base.wording import counted
from .signal import FiniteNumber, FiniteNumberOrNone, Row, Signal, as_row
from .terms import POLYNOMIAL, SINE, SPLINE, Term

CSV_BYTES_MAX = 64_000_000  # [bytes] of a file of points: a million of them, seconds to read
SPLINE_COEFFICIENT_MAX = 1e90  # [1] coefficients whose squares can be computed with


@part_class(eq=True)
class Ramp(Signal):
    """``f = offset + rate t``, with ``rate`` in the unit of f per second.

    Raises ValueError if a number is not finite.

    >>> float(Ramp(rate=2.0, offset=1.0)(3.0))
    7.0
    """

    rate: FiniteNumber = kept()
    offset: FiniteNumber = kept(default=0.0)

    def terms(self) -> list[Term]:
        """Return the polynomial (offset, rate)."""
        return [Term(POLYNOMIAL, np.array([self.offset, self.rate]))]


@part_class(eq=True)
class Sine(Signal):
    """``f = offset + amplitude sin(2 pi frequency t + phase)``, with ``frequency`` in Hz and ``phase`` in rad.

    Raises ValueError if a number is not finite.

    >>> Sine(amplitude=3.0, frequency=2.0, offset=1.0)([0.0, 0.125])
    array([1., 4.])
    """

    amplitude: FiniteNumber = kept()
    frequency: FiniteNumber = kept()
    phase: FiniteNumber = kept(default=0.0)
    offset: FiniteNumber = kept(default=0.0)

    def terms(self) -> list[Term]:
        """Return the sine, and the polynomial (offset) if there is one."""
        sine = Term(SINE, np.array([self.amplitude, 2.0 * np.pi * self.frequency, self.phase]))
        return [sine, Term(POLYNOMIAL, np.array([self.offset]))] if self.offset else [sine]


def as_coefficients(value: Any, what: str, part: Any) -> tuple[float, ...]:
    """Convert to coefficients, at least one."""
    row = as_row(value, what, part)
    if row.size == 0:
        raise InputError(f"{what} is empty; give at least the constant c0")
    return tuple(row.tolist())


class Coefficients(Stored[ArrayLike, tuple[float, ...]]):
    """Coefficients in ascending powers."""

    accepts = "array_like"
    convert = staticmethod(as_coefficients)


@part_class(eq=True)
class Polynomial(Signal):
    """``f = c0 + c1 t + c2 t^2 + ...`` from coefficients in ascending powers, ``c_k`` in the unit of f per s^k.

    Raises ValueError if there is no coefficient, or one is not a finite number.

    >>> float(Polynomial((1.0, 0.0, 3.0)).derivative(2.0))
    12.0
    """

    coefficients: Coefficients = kept()

    def terms(self) -> list[Term]:
        """Return the polynomial itself."""
        return [Term(POLYNOMIAL, np.array(self.coefficients))]


def column_of(rows: list[list[str]], wanted: str | int, what: str) -> int:
    """Index of a column, by its number from 0 or by its name in the first row."""
    names = [name.strip() for name in rows[0]]
    if isinstance(wanted, str) and wanted in names:
        return names.index(wanted)
    if type(wanted) is int and 0 <= wanted < len(names):
        return wanted
    raise InputError(f"{what}: no column {short_repr(wanted)}; give one of {', '.join(names)}, or a number from 0")


def is_number(text: str) -> bool:
    """Return True if a cell of a table holds a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True


@checks_method_arguments
@part_class()
class Table(Signal):
    """Cubic spline through measured points (not-a-knot: the third derivative is continuous next to both ends).

    At least four strictly increasing ``times`` [s], with one value each. ValueError if the lengths differ, a number is
    not finite, there are fewer than four, or the times do not increase.

    >>> cube = Table([0.0, 1.0, 2.0, 4.0], [0.0, 1.0, 8.0, 64.0])
    >>> round(float(cube(3.0)), 12), cube.interval
    (27.0, (0.0, 4.0))
    """

    times: Row = kept()
    values: Row = kept()

    @classmethod
    def from_csv(cls, path: str | Path, *, times: str | int = 0, values: str | int = 1) -> Self:
        """The table in two columns of a CSV file, with commas between numbers, as `Solution.to_csv` writes it.

        Columns by their names in the first row, or by their numbers from 0; a first row of numbers is one of the
        table. Units are those of the file: s, and that of the quantity driven.

        Raises
        ------
        ValueError
            If the file or a column does not exist, or a line has no number in it.
        """
        found = as_path(path, "force.csv")
        rows = [row for row in csv.reader(read_text(found, CSV_BYTES_MAX, "table").splitlines()) if row]
        places = [column_of(rows, wanted, f"Table: '{found}'") for wanted in (times, values)]
        counts = [is_number(rows[0][place]) for place in places]
        titles = not any(counts) or isinstance(times, str) or isinstance(values, str)
        numbers: list[list[float]] = []
        for k, row in enumerate(rows):
            try:
                numbers.append([float(row[place]) for place in places])
            except (ValueError, IndexError):
                if k > 0 or not titles:
                    line = ",".join(row)
                    raise InputError(
                        f"Table: '{found}': row {k + 1}, {short_repr(line)}, has no two numbers; "
                        "correct it, or name others"
                    ) from None
        both = np.array(numbers).reshape(-1, 2)
        return cls(both[:, 0], both[:, 1])

    def check(self, what: str) -> None:
        times, values = self.times, self.values
        if times.size != values.size:
            raise InputError(
                f"Table: {counted(times.size, 'time')} but {counted(values.size, 'value')}; give one value per time"
            )
        if times.size < 4:
            raise InputError(f"Table: {counted(times.size, 'point')}; a cubic spline needs 4 (Ramp, Polynomial: fewer)")
        late = np.flatnonzero(np.diff(times) <= 0.0)
        if late.size:
            i = late[0]
            raise InputError(
                f"Table: times[{i + 1}] = {times[i + 1]:.9g} does not come after times[{i}] = {times[i]:.9g}; "
                f"sort the points and keep one per time"
            )
        check_size(times, "Table: times")
        if np.abs(values).max() >= SPLINE_COEFFICIENT_MAX * min(np.diff(times).min(), 1.0) ** 3:
            raise InputError(
                f"Table: times as near as {np.diff(times).min():.3g} s with values up to {np.abs(values).max():.3g} "
                "make a spline too steep to compute with; check the units, or leave points out"
            )

    @property
    def interval(self) -> tuple[float, float]:
        """Return the first and last time of the table [s]."""
        return float(self.times[0]), float(self.times[-1])

    def terms(self) -> list[Term]:
        """Return the spline."""
        return [self._term]

    @cached_property
    def _term(self) -> Term:
        from scipy.interpolate import CubicSpline  # a tenth of a second, for tables alone

        pieces = CubicSpline(self.times, self.values, bc_type="not-a-knot").c.T
        return Term(SPLINE, np.concatenate([[len(pieces)], self.times, pieces.ravel()]))


@part_class(eq=True)
class Pulse(Signal):
    """From zero to ``height`` and back; zero before ``start`` [s] and again ``duration`` >= 2 edge [s] later (None = a
    step).

    Rise and fall take the time ``edge`` > 0 [s] each and have no corners: ``height (3 s^2 - 2 s^3)`` of its share s.
    The integral of the pulse is ``height (duration - edge)``. ValueError for other times or numbers that are not
    finite.

    >>> Pulse(height=3.0, start=1.0, edge=0.1, duration=0.5)([0.9, 1.05, 1.2, 1.6]).round(12)
    array([0. , 1.5, 3. , 0. ])
    """

    height: FiniteNumber = kept()
    start: FiniteNumber = kept()
    edge: FiniteNumber = kept()
    duration: FiniteNumberOrNone = kept(default=None)

    def check(self, what: str) -> None:
        if not self.edge > 0.0:
            raise InputError(f"Pulse: edge is {self.edge:g} s; give a positive time")
        if abs(self.height) >= SPLINE_COEFFICIENT_MAX * min(self.edge, 1.0) ** 3:
            raise InputError(f"Pulse: an edge of {self.edge:g} s is too steep to compute with; give a longer one")
        if self.duration is not None and not self.duration >= 2.0 * self.edge:
            raise InputError(f"Pulse: duration is {self.duration:g} s; give at least two edges, {2.0 * self.edge:g} s")

    def terms(self) -> list[Term]:
        """Return zero, rise, height, fall and zero as cubic pieces; a step ends with its height."""
        a, b, h = self.start, self.edge, self.height
        rise, level, zero = (-2.0 * h / b**3, 3.0 * h / b**2, 0.0, 0.0), (0.0, 0.0, 0.0, h), (0.0,) * 4
        pieces = {a - b: zero, a: rise, a + b: level}  # those next to the ends go on for ever
        if self.duration is not None:
            end = a + self.duration
            fall = max(end - b, a + b)  # right after the rise it takes the place of the level
            pieces |= {fall: (-rise[0], -rise[1], 0.0, h), end: zero}
        breaks = [*pieces, max(pieces) + b]
        return [Term(SPLINE, np.concatenate([[len(pieces)], breaks, np.ravel(list(pieces.values()))]))]
