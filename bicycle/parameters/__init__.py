"""Parameters of bicycles: their definition, published sets, parameter files."""

from .definition import MEANING, NOT_NEGATIVE, POSITIVE, SYMBOL, SYMBOLS, TYRES, UNIT, Parameters, is_file, read_values
from .published import Meijaard2007, deviations, entry_of, find, library, named, names

__all__ = [
    "MEANING", "NOT_NEGATIVE", "POSITIVE", "SYMBOL", "SYMBOLS", "TYRES", "UNIT", "Meijaard2007", "Parameters",
    "deviations", "entry_of", "find", "is_file", "library", "named", "names", "read_values",
]  # fmt: skip
