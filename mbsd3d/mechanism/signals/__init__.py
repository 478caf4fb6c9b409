"""Functions of time for drivers and forces: sums of polynomials, sines, pulses and cubic splines."""

from .curves import Polynomial, Pulse, Ramp, Sine, Table
from .input import Input
from .signal import Constant, Scaled, Signal, Sum, as_signal, check_interval, three_signals
