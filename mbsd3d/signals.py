"""Functions of time for drivers and forces."""

from .mechanism.signals import Constant, Input, Polynomial, Pulse, Ramp, Scaled, Signal, Sine, Sum, Table, as_signal

__all__ = ["Constant", "Input", "Polynomial", "Pulse", "Ramp", "Scaled", "Signal", "Sine", "Sum", "Table", "as_signal"]
