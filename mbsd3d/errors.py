"""What this package raises, all of it an `MbsError`: wrong input is an `InputError`, the others are failures."""

from .base.errors import (
    ArgumentError,
    AssemblyError,
    EquilibriumError,
    InputError,
    IntegrationError,
    MbsError,
    NameMissingError,
    SweepError,
)

__all__ = [
    "ArgumentError",
    "AssemblyError",
    "EquilibriumError",
    "InputError",
    "IntegrationError",
    "MbsError",
    "NameMissingError",
    "SweepError",
]
