"""What this package raises: wrong input is a `ValueError`, failures of runs are an `MbsError`, which is one too."""

from .base.errors import AssemblyError, EquilibriumError, IntegrationError, MbsError, SweepError

__all__ = ["AssemblyError", "EquilibriumError", "IntegrationError", "MbsError", "SweepError"]
