"""A run in segments: each continues from the last state, with inputs set between two segments."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base.checks import MAGNITUDE_MIN, as_tuple, number, short_repr
from ..base.errors import InputError
from ..base.progress import Progress
from ..base.rotations import matrix
from ..compiler.cache_folder import mark_warm
from ..compiler.first_run import announce_compilation
from ..dynamics.auditing import AUDITED_FIELDS
from ..dynamics.state_rates import evaluate
from ..equations.compiled import compile_system, holders_of, set_input, starts, with_history, with_own_inputs
from ..integrators.step_control import STEP_TIME_RATIO_MIN
from ..kernels.measures import measure
from ..mechanism.measures import Measure, check_members
from ..mechanism.mechanism import Mechanism
from ..mechanism.signals.signal import Input
from ..mechanism.state import State
from ..mechanism.switching import is_switching
from ..results.record import Record, RunOptions, Samples
from ..results.result import RunResult, unit_quaternions
from .initial_checks import check_stops
from .job import Job
from .simulation import check_signals, check_steps

SILENT = Progress("", 0.0, 1.0, False)
NO_BUFFER = np.zeros((0, 0))  # in a snapshot: samples in the buffer are taken out before


@dataclass(frozen=True, eq=False, repr=False)
class Snapshot:
    """Where a `Stepper` was at a time, by `Stepper.snapshot`; it never changes, so it can be restored again and again.

    It holds all that later steps depend on: the state with the internal states of forces, turns of hinges, the choice
    of rows, factors and history of the method, its next step, the next turn of a signal, gaps of contacts and limits,
    what inputs are set to; and the samples kept so far.

    >>> from mbsd3d import Body, Stepper, System
    >>> Stepper(System([Body("stone", mass=2.0, inertia=(0.1, 0.1, 0.1))])).snapshot()
    <snapshot: at t = 0 s>
    """

    t: float  # [s]
    owner: "Segments"
    working: tuple  # memory of the run, work space, tree, memory of the method
    history: dict[str, list[tuple[float, ...]]]
    record: Record
    samples: Samples
    seen: list[tuple[int, float, float]]  # by the watch for divergence
    last_event: int
    controllers: tuple = ()  # where the controllers of a stepper were

    def __repr__(self) -> str:
        return f"<snapshot: at t = {self.t:g} s>"

    def __reduce__(self) -> tuple:
        raise InputError(
            "a snapshot is neither copied nor pickled: it belongs to its stepper; give other processes Stepper.state"
        )


def duplicate(x: Any) -> Any:
    """Return a named tuple of arrays, records, numbers and further ones with memory of its own."""
    if isinstance(x, tuple):
        made = [duplicate(one) for one in x]
        return type(x)(*made) if hasattr(x, "_fields") else tuple(made)
    return x.copy() if isinstance(x, np.ndarray | np.void) else x


class Segments(Job):
    """A job whose end is moved on from segment to segment; rows, steps and factors of the method stay what they are.

    ``keep`` says whether the end of each segment is a sample, taken before an input changes there; ``progress`` is
    asked every 0.05 s of work.
    """

    def __init__(self, system: Mechanism, start: State, options: RunOptions, measures: Sequence[Measure] = ()) -> None:
        measures = as_tuple(measures, "Stepper: measures", "a list of mbsd3d.measures")
        for x in measures:
            if not isinstance(x, Measure):
                raise InputError(f"Stepper: measures: {short_repr(x)} is not a measure; build one with mbsd3d.measures")
            check_members(system, x, "Stepper: measures")
        check_no_switching(system)
        compiled = with_own_inputs(compile_system(system, tuple(measures), options.switches))
        self.keep, self.progress = True, SILENT
        self.history: dict[str, list[tuple[float, ...]]] = {
            name: [(start.t, value)] for name, value in starts(compiled).items()
        }
        self.driving = {name: driver_of(system, name) for name in self.history}
        super().__init__(compiled, start, start.t, None, options)
        self.measures = range(len(measures))
        self.last_signal = last_time(system)
        task = self.memory.task
        self.memory = self.memory._replace(times=np.array([start.t, start.t]))
        task.every_step, task.t_end = 0, np.inf  # no horizon: the first step follows from the accelerations alone
        announce_compilation(f"time loop {self.options.method.loop.__name__}")
        self.check_start()
        check_stops(self.compiled, self.data, self.memory.y)
        self.eliminate()
        self.accelerate()
        for x in measures:
            self.check_determined(x, "Stepper: measures")
        self.check_driven()
        self.first_step()

    @property
    def t(self) -> float:
        """Return the time reached so far [s]."""
        return float(self.memory.now["t"])

    @property
    def inputs(self) -> dict[str, float]:
        """Return the value of every input now."""
        return {name: value_now(changes[-1], self.t) for name, changes in self.history.items()}

    def set(self, key: Input | str, value: float, slope: float = 0.0) -> None:
        """Set the value of an input from now on, and its slope [1/s]."""
        name = key.name if isinstance(key, Input) else key
        if not isinstance(name, str) or name not in self.history:
            have = ", ".join(f"'{x}'" for x in self.history) or "none"
            raise InputError(f"Stepper: {short_repr(key)} is not one of the inputs of this system; there are {have}")
        value, slope = number(value, f"Stepper: input '{name}'"), number(slope, f"Stepper: slope of input '{name}'")
        course, changes, t = (value, slope) if slope else (value,), self.history[name], self.t
        if changes[-1][1:] == course and not slope:
            return
        if self.driving[name] is not None:
            raise InputError(
                f"Stepper: input '{name}' prescribes the motion of driver '{self.driving[name]}', and a jump would "
                "tear the joints apart; let it set a force, or a reference of a controller"
            )
        if changes[-1][0] == t:
            changes.pop()
        changes.append((t, *course))
        set_input(self.compiled, name, value, slope, t)
        self.memory.now.fresh = 1

    def advance(self, t: float) -> None:
        """Integrate to time t [s]; the last step ends exactly there."""
        t, run = number(t, "Stepper: t"), self.memory
        now, task = run.now, run.task  # their fields by name: as attributes each takes a microsecond more
        begin, step, rejected, first = float(now["t"]), now["step"], now["rejected"], now["evaluations"] == 0
        if not t - begin > max(STEP_TIME_RATIO_MIN * abs(t), MAGNITUDE_MIN):  # what rounding adds is not a segment
            raise InputError(f"Stepper: t = {t:.9g} s does not lie after {begin:.9g} s; give a later time")
        check_steps(self.options.method, t - begin, "Stepper")
        if t > self.last_signal:
            check_signals(self.compiled, begin, t)
        task["t_end"] = t
        if self.options.method.dt is not None:
            task["steps"] = max(int(np.ceil((t - begin) / self.options.method.dt - 1e-9)), 1)
            task["t_start"], now["grid"] = begin, 0
        if not self.keep and now["written"]:
            self.drain()
        run.times[1], now["next_output"] = t, 0 if first else 1
        self.loop(self.progress)
        if first:
            mark_warm(f"time loop {self.options.method.loop.__name__}")
            mark_warm()
        if now["rejected"] == rejected:
            now["step"] = max(now["step"], step)  # a segment that ends in a short step says nothing about the next one
        if not self.keep:
            now["written"] = 0

    def snapshot(self) -> Snapshot:
        """Return where the run is, with memory of its own."""
        self.drain()
        working = self.memory._replace(out=NO_BUFFER), self.data, self.tree, self.own
        return Snapshot(
            self.t, self, duplicate(working), copied(self.history), self.record.copy(),
            self.samples.copy(), list(self.divergence.seen), self.last_event,
        )  # fmt: skip

    def restore(self, snapshot: Snapshot) -> None:
        """Go back, or on, to where the run was."""
        if not isinstance(snapshot, Snapshot):
            raise InputError(
                f"Stepper: restore: {short_repr(snapshot)} is not a snapshot; give one of Stepper.snapshot()"
            )
        if snapshot.owner is not self:
            raise InputError(
                f"Stepper: restore: {snapshot!r} is of another stepper; restore it there, or start this one from the "
                "State of the other: Stepper(system, other.state)"
            )
        memory, self.data, self.tree, self.own = duplicate(snapshot.working)
        self.memory = memory._replace(out=self.memory.out)
        self.history = copied(snapshot.history)
        for name, changes in self.history.items():
            t, value, slope = (*changes[-1], 0.0)[:3]
            set_input(self.compiled, name, value, slope, t)
        self.record, self.samples = snapshot.record.copy(), snapshot.samples.copy()
        self.divergence.seen, self.last_event = list(snapshot.seen), snapshot.last_event

    def solution(self) -> RunResult:
        """Return the result up to the last sample that was kept."""
        self.drain()
        run, count = self.memory, self.samples.count
        record = replace(
            self.record.copy(), steps=int(run.now.steps),
            rejected=int(run.now.rejected), evaluations=int(run.now.evaluations), seconds=self.record.loop_seconds,
            speed=float(run.now.fastest),
            inputs={name: tuple(changes) for name, changes in self.history.items()},
        )  # fmt: skip
        record.open_audit = tuple(float(run.now[x]) for x in AUDITED_FIELDS)
        record.note_extremes(run.now, self.compiled.system)
        arrays = {name: array[:count].copy() for name, array in self.samples.arrays.items()}
        arrays["t"] = arrays["t"][:, 0]
        compiled = with_history(self.compiled, self.history)
        return RunResult.from_run(compiled, arrays, record, self.start, run.y.copy(), self.t, self.data)

    @property
    def velocities(self) -> np.ndarray:
        """Return the world velocities (r_dot, w) of all bodies (6 n,) [m/s, rad/s]."""
        n, y = self.model.body.size, self.memory.y
        v = y[7 * n : 13 * n].reshape(n, 6).copy()
        v[:, 3:] = np.einsum("bij,bj->bi", matrix(y[: 7 * n].reshape(n, 7)[:, 3:]), v[:, 3:])
        return v.ravel()

    @property
    def state(self) -> State:
        """Return the state at the end of the last segment."""
        n, y = self.model.body.size, self.memory.y
        own = y[13 * n : 13 * n + self.model.z_work]
        coordinates = self.data.coordinate["value"][: self.compiled.own_coordinates].copy()
        return State(self.t, unit_quaternions(y[: 7 * n]), self.velocities, own, coordinates)

    @property
    def measured(self) -> np.ndarray:
        """Return the values of the measures (measures,) now; for a reaction the equations are solved."""
        if (self.model.measure["rows"][: len(self.measures)] > 0).any():
            evaluate(self.model, self.data, self.tree, self.t, self.memory.y, np.empty_like(self.memory.y))
        return np.array([measure(self.model, self.data, i, self.t) for i in self.measures])


def value_now(change: tuple[float, ...], t: float) -> float:
    """Return the value at time t [s] of an input since a change."""
    then, value, slope = (*change, 0.0)[:3]
    return value + slope * (t - then)


def copied(history: dict[str, list[tuple[float, ...]]]) -> dict[str, list[tuple[float, ...]]]:
    """Return a history of inputs whose later changes leave this one as it is."""
    return {name: list(changes) for name, changes in history.items()}


def check_no_switching(system: Mechanism) -> None:
    """Refuse parts that switch at events: rows stay what they are in all segments."""
    parts: tuple[Any, ...] = holders_of(system)
    for part in parts:
        if is_switching(part):
            raise InputError(
                f"Stepper: '{system.name(part)}' ({type(part).__name__}) switches at events, which a run in segments "
                f"does not look for; use simulate from state to state, or {part.without_events}"
            )


def driver_of(system: Mechanism, name: str) -> str | None:
    """Return the name of the driver whose motion follows an input, if there is one."""
    for joint in system.joints:
        for signal in (row.signal for row in joint.primitives if row.signal is not None):
            if any(term.input and term.input[0] == name for term in signal.terms()):
                return system.name(joint)
    return None


def last_time(system: Mechanism) -> float:
    """Return the time [s] until which all signals are defined."""
    signals = [row.signal for joint in system.joints for row in joint.primitives]
    signals += [signal for force in system.forces for signal in force.record().signals]
    return min((signal.interval[1] for signal in signals if signal is not None), default=np.inf)
