"""What a demo gives: rows of computed numbers beside theory, a figure, runs and views."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import inf, isfinite
from typing import TYPE_CHECKING, NamedTuple

from matplotlib.figure import Figure

from ..base.errors import InputError
from .figure import Panel, figure_of

if TYPE_CHECKING:
    from ..api.solution import Solution


@dataclass(frozen=True)
class Row:
    """One line of a demo's table: a computed number beside its theory.

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
        """Name for programs."""
        return self.key or re.sub(r"\W+", "_", self.quantity).strip("_")

    @property
    def error(self) -> float:
        """|computed - theory|: 0 if both are the same infinity, infinite if one number is not finite."""
        if self.computed == self.theory:
            return 0.0
        error = abs(float(self.computed) - float(self.theory))
        return error if isfinite(error) else inf

    @property
    def passed(self) -> bool:
        """True if the error is finite and within the tolerance."""
        return isfinite(self.error) and self.error <= self.tolerance


class Show(NamedTuple):
    """A run to animate, with options of `Solution.animate`."""

    solution: "Solution"
    options: Mapping[str, object] = {}


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a demo gives: the table, panels, runs and views by the names of their files, and lines to print below."""

    rows: tuple[Row, ...]
    drawn: Callable[[], Sequence[Panel]]
    solutions: Mapping[str, "Solution"]
    noted: Callable[[], tuple[str, ...]] = tuple
    views: Mapping[str, Show] = field(default_factory=dict)
    parameters: Mapping[str, object] = field(default_factory=dict)
    title: str = ""

    @cached_property
    def panels(self) -> Sequence[Panel]:
        """What the figure shows, computed when it is first asked for."""
        return self.drawn()

    @cached_property
    def figure(self) -> Figure:
        """The panels side by side; an InputError where there are none."""
        if not self.panels:
            raise InputError(
                f"'{self.title}' has nothing to draw; give curves in what its measure returns, or run it with all terms"
            )
        return figure_of(self.title, self.panels)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """Lines to print below."""
        return self.noted()

    @cached_property
    def quantities(self) -> dict[str, Row]:
        """The rows by their names."""
        return {row.name: row for row in self.rows}

    @property
    def passed(self) -> bool:
        """True if every row is within its tolerance."""
        return all(row.passed for row in self.rows)
