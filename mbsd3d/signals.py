"""Functions of time for drivers and forces."""

from .mechanism.signals.curves import Polynomial as Polynomial
from .mechanism.signals.curves import Pulse as Pulse
from .mechanism.signals.curves import Ramp as Ramp
from .mechanism.signals.curves import Sine as Sine
from .mechanism.signals.curves import Table as Table
from .mechanism.signals.signal import Constant as Constant
from .mechanism.signals.signal import Input as Input
from .mechanism.signals.signal import Scaled as Scaled
from .mechanism.signals.signal import Signal as Signal
from .mechanism.signals.signal import Sum as Sum
from .mechanism.signals.signal import as_signal as as_signal
