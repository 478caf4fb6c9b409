"""Functions of time for drivers and forces."""

from .mechanism.signals import (
    Constant,
    Polynomial,
    Pulse,
    Ramp,
    Scaled,
    Signal,
    Sine,
    Sum,
    Table,
    as_signal,
    check_interval,
)  # fmt: skip

__all__ = [
    "Constant", "Polynomial", "Pulse", "Ramp", "Scaled", "Signal", "Sine", "Sum", "Table", "as_signal",
    "check_interval",
]  # fmt: skip
