"""What this package raises: wrong input is a `ValueError`, failures of runs are an `MbsError`, which is one too."""

from .base.errors import ArgumentError, AssemblyError, EquilibriumError, IntegrationError, MbsError, SweepError

__all__ = ["ArgumentError", "AssemblyError", "EquilibriumError", "IntegrationError", "MbsError", "SweepError"]
