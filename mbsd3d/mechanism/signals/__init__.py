"""Functions of time for drivers and forces: sums of polynomials, sines, pulses and cubic splines."""

from .signal import (
    Constant,
    Scaled,
    Signal,
    SignalField,
    SignalOrNone,
    Sum,
    ThreeSignals,
    ThreeSignalsOrFree,
    as_signal,
    check_interval,
    signal_of,
)
