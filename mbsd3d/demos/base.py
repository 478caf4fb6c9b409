"""Results of a demo: rows of computed numbers with their theory, a figure, runs and views."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import inf, isfinite
from typing import TYPE_CHECKING, NamedTuple

from matplotlib.figure import Figure

from ..base.errors import InputError
from ..base.wording import yes_or_no
from .figure import Panel, figure_of

if TYPE_CHECKING:
    from ..api.solution import Solution
    from ..api.viewable import AnimateOptions

YES_OR_NO = "yes or no"  # in place of the unit, of 1 and 0


@dataclass(frozen=True)
class Row:
    """Line of a demo's table: a computed number and its theory.

    Examples
    --------
    >>> Row("period", 2.0000001, 2.0, 1e-6, "s").passed
    True
    """

    quantity: str
    computed: float
    theory: float
    tolerance: float  # largest accepted |computed - theory|
    unit: str = ""  # e.g. "N m"; "" for a pure number
    key: str = ""  # name in tables for programs; "" = made of the quantity

    @property
    def name(self) -> str:
        """Return the name of the quantity for programs."""
        return self.key or re.sub(r"\W+", "_", self.quantity).strip("_")

    @property
    def label(self) -> str:
        """Return the quantity with its unit."""
        return f"{self.quantity} [{self.unit}]" if self.unit not in ("", YES_OR_NO) else self.quantity

    def text(self, value: float, form: Callable[[float], str]) -> str:
        """Format the computed value, or that of theory, by a function for numbers."""
        return yes_or_no(value) if self.unit == YES_OR_NO else form(value)

    @property
    def error(self) -> float:
        """Return |computed - theory|: 0 if both are the same infinity, infinite if one number is not finite."""
        if self.computed == self.theory:
            return 0.0
        error = abs(float(self.computed) - float(self.theory))
        return error if isfinite(error) else inf

    @property
    def passed(self) -> bool:
        """Return whether the error is finite and within the tolerance."""
        return isfinite(self.error) and self.error <= self.tolerance


class Show(NamedTuple):
    """Run to animate, with options of `Solution.animate`."""

    solution: "Solution"
    options: "AnimateOptions" = {}


@dataclass(frozen=True, eq=False)
class Outcome:
    """Results of a demo: the table, panels, runs and views by the names of their files, and lines to print below."""

    rows: tuple[Row, ...]
    drawn: Callable[[], Sequence[Panel]]
    solutions: Mapping[str, "Solution"]
    noted: Callable[[], tuple[str, ...]] = tuple
    views: Mapping[str, Show] = field(default_factory=dict)
    parameters: Mapping[str, object] = field(default_factory=dict)
    title: str = ""

    @cached_property
    def panels(self) -> Sequence[Panel]:
        """Return the panels of the figure, computed at the first request."""
        return self.drawn()

    @cached_property
    def figure(self) -> Figure:
        """Return the panels side by side as a figure; raise InputError where there are none."""
        if not self.panels:
            raise InputError(
                f"'{self.title}' has nothing to draw; give curves in what its measure returns, or run it with all terms"
            )
        return figure_of(self.title, self.panels)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """Return the lines to print below the table."""
        return self.noted()

    @cached_property
    def quantities(self) -> dict[str, Row]:
        """Return the rows by their names."""
        return {row.name: row for row in self.rows}

    @property
    def passed(self) -> bool:
        """Return whether every row is within its tolerance."""
        return all(row.passed for row in self.rows)
