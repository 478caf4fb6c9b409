"""Functions of time for drivers and forces: sums of polynomials, sines, pulses and cubic splines."""

from .signal import (
    Constant as Constant,
)
from .signal import (
    Scaled as Scaled,
)
from .signal import (
    Signal as Signal,
)
from .signal import (
    SignalField as SignalField,
)
from .signal import (
    SignalOrNone as SignalOrNone,
)
from .signal import (
    Sum as Sum,
)
from .signal import (
    ThreeSignals as ThreeSignals,
)
from .signal import (
    ThreeSignalsOrFree as ThreeSignalsOrFree,
)
from .signal import (
    as_signal as as_signal,
)
from .signal import (
    check_interval as check_interval,
)
from .signal import (
    signal_of as signal_of,
)
