"""What a run notes about itself; a solution keeps it, files store it, the certificate judges by it."""

from dataclasses import dataclass, field
from typing import Any

from .integrators.dop853 import DOP853
from .integrators.driven import Kinematic
from .integrators.generalized_alpha import GeneralizedAlpha
from .integrators.rk4 import RK4
from .model import Switches

METHODS = (DOP853, RK4, GeneralizedAlpha, Kinematic)


@dataclass
class Record:
    """What a run did, for the certificate."""

    method: Any  # one of METHODS
    rtol: float
    switches: Switches
    tolerance: float = 0.0  # within which redundant rows may be violated, in model lengths; 0 = as_built not given
    kinematic: bool = False
    steps: int = 0  # accepted
    rejected: int = 0
    evaluations: int = 0
    svd_calls: int = 0  # choices of rows
    rank_events: list = field(default_factory=list)  # (time [s], rows kept, reason, whether the row set changed)
    seconds: float = 0.0  # the whole run
    loop_seconds: float = 0.0  # of these, in the compiled time loop
    rows_left_out: int | None = None  # redundant rows at the last choice; None = not chosen
    stopped_by: str | None = None
