"""A number that is set from outside while a model runs."""

from typing import TypeVar

import numpy as np

from ...base.checks import check_name
from ...base.errors import InputError
from ...base.fields import kept, part_class
from .signal import FiniteNumber, Signal
from .terms import POLYNOMIAL, Term


@part_class(eq=True)
class Input(Signal):
    """``f = value`` until `Stepper.set` gives another number, which holds until the next one.

    Parameters
    ----------
    name : str
        Name to set it by; signals of one name are one input.
    value : float
        At the start, in the unit of what it drives; `simulate` keeps it.

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
        """The polynomial (value)."""
        return [Term(POLYNOMIAL, np.array([self.value]), (self.name, self.value))]


InputOrName = TypeVar("InputOrName", bound=Input | str)  # key of a mapping: type checkers take dict[str, ...] then
