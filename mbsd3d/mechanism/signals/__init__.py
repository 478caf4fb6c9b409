"""Functions of time for drivers and forces: sums of polynomials, sines, pulses and cubic splines."""

from .signal import Constant, Scaled, Signal, Sum, as_signal, check_interval, three_signals
