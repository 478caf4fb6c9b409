"""Options of a run, and the record of its statistics, which the certificate judges."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import number, short_repr
from ..base.errors import InputError
from ..equations.compiled import History, Switches
from ..integrators.dop853 import DOP853
from ..integrators.method import Method
from ..mechanism.measures import Condition
from ..mechanism.mechanism import Mechanism

RankEvent = tuple[float, int, str, bool]  # time [s], rows kept, reason, whether the row set changed


@dataclass(frozen=True)
class RunOptions:
    """Options of a run as `mbsd3d.simulate` takes them, checked; one record from the call to the result.

    Output, condition to stop and progress are not compared: a file does not keep them.
    ValueError for an option of the wrong kind or range.
    """

    method: Method = DOP853()  # noqa: RUF009 - frozen
    rtol: float = 1e-8
    output: int | ArrayLike | None = field(default=None, compare=False)  # samples, their times [s]; None = every step
    stop_when: Condition | None = field(default=None, compare=False)
    as_built: float | None = None  # [m], within which redundant rows may be violated
    progress: bool | str | None = field(default=None, compare=False)
    switches: Switches = field(default_factory=Switches)

    def __post_init__(self) -> None:
        check_method(self.method)
        if not 1e-13 <= number(self.rtol, "simulate: rtol") <= 0.1:
            raise InputError(f"simulate: rtol {self.rtol:g} is outside 1e-13 ... 0.1; give a number in this range")
        if self.stop_when is not None and not isinstance(self.stop_when, Condition):
            raise InputError(
                f"simulate: stop_when {short_repr(self.stop_when)} is not a condition; "
                "write e.g. measures.angle(hinge) > 1.2"
            )
        if self.as_built is not None:
            object.__setattr__(self, "as_built", number(self.as_built, "as_built", positive=True))


def check_method(method: Any) -> None:
    """Raise a ValueError for anything but a method of integration."""
    if Method not in type(method).__mro__ and (isinstance(method, type) or not isinstance(method, Method)):
        names = "DOP853, RK4, GeneralizedAlpha, RadauIIA, Kinematic"
        raise InputError(f"simulate: method {short_repr(method)} is unknown; give one of {names}, e.g. DOP853()")


class HasOptions:
    """Anything that keeps the options of its run."""

    options: RunOptions

    @property
    def rtol(self) -> float:
        """Return the relative tolerance of the run."""
        return self.options.rtol

    @property
    def switches(self) -> Switches:
        """Return the teaching switches of the run."""
        return self.options.switches


@dataclass
class Record(HasOptions):
    """Statistics of a run: its options, steps, evaluations and how it ended."""

    options: RunOptions
    tolerance: float = 0.0  # within which redundant rows may be violated, in model lengths; 0 = as_built not given
    steps: int = 0  # accepted
    rejected: int = 0
    evaluations: int = 0
    svd_calls: int = 0  # choices of rows
    rank_events: list[RankEvent] = field(default_factory=list)
    seconds: float = 0.0  # the whole run
    loop_seconds: float = 0.0  # of these, in the compiled time loop
    rows_left_out: int | None = None  # redundant rows at the last choice; None = not chosen
    nearest: float = 1.0  # least pivot of the loop rows over its largest: how near the run came to a singular position
    open_audit: tuple[float, ...] = (0.0, 0.0, 0.0)  # J, N s, N m s by which two quadratures of fixed steps differ
    about_centre: bool = False  # the angular impulse is about the centre of mass, not the origin as in older files
    speed: float = 0.0  # m/s, greatest of all steps, relative to the mean of all bodies
    miscount: float | None = None  # rad, the most a hinge turned in a step otherwise than by the mean of its rates
    missed: float = 0.0  # rad, the most a body turned otherwise than by its angular velocity, over the run
    missed_by: str = ""  # that body
    farthest: float = 0.0  # rad, the farthest a body turned in a step
    farthest_by: str = ""  # that body
    jump: float = 0.0  # what velocities change in fixed steps in which bodies touch, over the greatest, added up
    jump_by: str = ""  # the contact or stop of the most
    overlap: float = 0.0  # the deepest of a sphere in a sphere or a round bar, over the sum of their radii
    overlap_by: str = ""  # that contact
    stopped_by: str | None = None
    never_armed: str | None = None  # the condition to stop that has not been false since the start
    inputs: History = field(default_factory=dict)
    coupled: tuple[str, ...] = ()  # how controllers in FMUs were coupled, and the energy that passed

    def copy(self) -> "Record":
        """Return a record that does not change when this one does."""
        return replace(self, rank_events=list(self.rank_events))

    @property
    def method(self) -> Method:
        """Return the method of integration."""
        return self.options.method

    @property
    def kinematic(self) -> bool:
        """Return whether nothing is integrated: the poses follow from the drivers."""
        return self.method.order == 0

    def note_extremes(self, now: Mapping[str, Any] | np.record, system: Mechanism) -> None:
        """Take over how far bodies turned, how well orientations follow from rates, and what contacts changed."""
        bodies = system.bodies
        self.miscount, self.missed, self.farthest = (float(now[x]) for x in ("miscount", "missed", "farthest"))
        self.missed_by, self.farthest_by = bodies[int(now["missed_by"])].name, bodies[int(now["farthest_by"])].name
        if now["jump"] > 0.0:
            self.jump, self.jump_by = float(now["jump"]), system.name(system.forces[int(now["jump_by"])])
        if now["overlap"] > 0.0:
            self.overlap, self.overlap_by = float(now["overlap"]), system.name(system.forces[int(now["overlap_by"])])


MOST_NUMBERS = 2**30  # that the samples of a run may hold: 8 GB
BUFFER_NUMBERS = 2**21  # [numbers] (16 MB) the buffer of the time loop may hold
BUFFER_SAMPLES_MIN = 16  # [samples] it holds at least
QUANTITIES = ("t", "y", "acceleration", "lam", "coordinate", "potential", "power", "residual")


def buffer_size(wanted: int, width: int) -> int:
    """Return how many samples the buffer holds: those wanted, if there is room."""
    return min(wanted, max(BUFFER_SAMPLES_MIN, BUFFER_NUMBERS // width))


class Samples:
    """Arrays (samples, width) of the quantities of a run, by name.

    ``widths``: numbers per sample of each of QUANTITIES; ``expected``: samples to make room for, more make the arrays
    grow.
    """

    def __init__(self, widths: tuple[int, ...], expected: int) -> None:
        self.count = 0
        self.arrays = {name: np.empty((expected, width)) for name, width in zip(QUANTITIES, widths, strict=True)}

    def take(self, rows: np.ndarray) -> None:
        """Copy samples (k, sum of widths)."""
        column, count = 0, self.count + rows.shape[0]
        for array in self.arrays.values():
            room, width = array.shape
            if room < count:
                array.resize((max(count, room + room // 4), width), refcheck=False)  # in place where it can
            array[self.count : count] = rows[:, column : column + width]
            column += width
        self.count = count

    def copy(self) -> "Samples":
        """Return the samples so far with memory of their own, without spare room."""
        other = Samples(tuple(array.shape[1] for array in self.arrays.values()), 0)
        other.count = self.count
        other.arrays = {name: array[: self.count].copy() for name, array in self.arrays.items()}
        return other

    def finished(self) -> dict[str, np.ndarray]:
        """Return the arrays without spare room; no samples can be taken after this."""
        for array in self.arrays.values():
            array.resize((self.count, array.shape[1]), refcheck=False)
        return dict(self.arrays)
