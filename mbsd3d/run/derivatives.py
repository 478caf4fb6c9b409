"""Derivatives of the samples of a run by parameters of its model: of tables, start, times and condition to stop.

The numbers at p are differenced at p + k h, k = -2 ... 2, by a formula of fourth order, which leaves little more than
rounding; the equations are differentiated along the steps of the run (`integrators.replay`). An event moves by
dt = -(dm/dp)/(dm/dt), and with it what is read there.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ..base.errors import GradientError, InputError
from ..base.progress import Progress
from ..dynamics.contact_steps import watched_gaps
from ..dynamics.state_rates import FACTOR_FROM_OTHER_POSE, evaluate, project_and_evaluate
from ..equations.at_state import pack
from ..equations.compiled import Compiled, link
from ..integrators import memory
from ..integrators.memory import Stages, allocate_run
from ..integrators.outputs import write
from ..integrators.replay import (
    NOT_OF_THE_MOTION,
    TABLES,
    VECTORS,
    arrive,
    complex_tables,
    differentiate_measure,
    gaps_ahead,
    gaps_at,
    new_columns,
    numbers_of,
    replay,
    structure_of,
)
from ..kernels.layout import (
    BODY,
    COORDINATE,
    FORCE,
    MEASURE,
    PRIMITIVE,
    REFLECTED,
    ROW,
    SIGNAL,
    TERM,
    Data,
    Model,
    Tree,
    table,
)
from ..mechanism.forces.custom import FunctionForce
from ..mechanism.state import State
from ..results.record import QUANTITIES, RunOptions
from ..results.result import RunResult, unit_quaternions
from .events import EVENT_VALUE_TOLERANCE, rate_of_measure, slack_of, turns_of_signals
from .initial_checks import with_jumps
from .job import Job

OFFSETS = (-2, -1, 1, 2)  # [steps] from p at which a model is built
FOURTH_ORDER = np.array([1.0, -8.0, 8.0, -1.0]) / 12.0  # weights of the values there, over the step
SECOND_ORDER = np.array([0.0, -1.0, 1.0, 0.0]) / 2.0
EVEN = np.array([1.0, -4.0, -4.0, 1.0]) / 4.0  # of values less those at p: slope s of a kink s |p|, nothing of p^2
BACKWARD = np.array([137.0 / 60.0, -5.0, 5.0, -10.0 / 3.0, 1.25, -0.2])  # of fifth order, at 0, -1, ... -5 steps
SAMPLE_STEP_SHARE = 0.01  # [1] of the mean step: step of differences in time, at which the fifth order errs by 1e-12
KINK_RATIO_MAX = 1e-3  # [1] by which two orders of a smooth difference may differ,
KINK_ROUNDING = 1e-8  # [1] and of the number itself, where it has no slope
EVEN_RATIO = 1e3  # [1] of that, of the even part, which is of lower order
ROUNDING = 2e-15  # [1] of the largest of all numbers over the step, by which those are rounded that vanish
# [1] of the derivatives of the equations by a parameter: how far two ways may differ, and of the largest quantity
LOST_RATIO_MAX, COMPARED_ROUNDING = 1e-4, 1e-10
COMPARED_MOTION_MAX = 0.02  # [m or 1] of bodies by a step of a parameter, up to which both are compared
REPLAY_RATIO_MAX = 1e3  # [1] of rtol: distance of the replay from its run, beyond which it is another motion
GRAZING_MARGIN_MIN = 1e-8  # [1] of the scale of a measure: how far it would go on past the value of its condition;
GRAZING_RTOL_RATIO_MIN = 1e3  # [1] and over rtol: below it the time of the event is known to few digits only
CONTACT_RTOL_MAX = 1e-7  # [1] of a run with contacts: beyond it derivatives err by percents where values do by 1e-6
# [1] of the mean step and [roundings] of the time from an end before a touch to it; [halvings] to find it
HOP_SHARE, HOP_ROUNDINGS, TOUCH_HALVINGS = 1e-12, 4, 52
GAP_ROUNDINGS = 32  # [roundings] of the largest place, by which a gap errs at most
TOUCHES_MAX = 100  # [touches] in a step
CROWDED_SHARE = 1e-9  # [1] of the mean step: shorter ones, which go over a jump of a force, are taken together
SAME_TIME_RATIO = 1e-14  # [1] of the time: a shorter step changes nothing
SAMPLED = QUANTITIES[1:-1]  # all but the time and the residual
TABLE_FIELDS: dict[str, list[Any]] = dict(
    zip(TABLES, (BODY, PRIMITIVE, ROW, COORDINATE, REFLECTED, FORCE, SIGNAL, TERM, MEASURE), strict=True)
)
REPLAY_CHUNK = 64  # [steps] between two returns to Python, for progress and Ctrl-C


class RecordedJob(Job):
    """A run that notes where its steps end, one call of the compiled loop a step, and its trees."""

    def __init__(self, *given: Any) -> None:
        self.ends: list[float] = []  # s, of the steps
        self.restarts: dict[int, float] = {}  # number of steps before it -> time [s] from which the next one goes on
        self.trees: list[tuple[int, Tree]] = []  # number of steps before it, and the tree
        super().__init__(*given)

    def call(self, budget: int) -> int:
        """Take up to ``budget`` steps, one at a time, and note their ends."""
        status = memory.RUNNING
        while budget > 0 and status == memory.RUNNING:
            status = self.step()
            budget -= 1
        return status

    def step(self) -> int:
        """Take one step and note its end."""
        run, now = self.memory, self.memory.now
        steps, t = int(now["steps"]), float(now["t"])
        status = super().call(1)
        if int(now["steps"]) > steps or (status == memory.STOPPED and float(now["t"]) > t):
            turned = now["fresh"] == 2  # a signal turns at the end of the step
            self.ends.append(float(run.turns[int(now["next_turn"]), 0] if turned else now["t"]))
            if turned:
                self.restarts[len(self.ends)] = float(now["t"])
        return status

    def eliminate(self, loaded: bool = False) -> None:
        """Build the spanning tree, and note from which step on; columns need the rows and the factor of any tree."""
        super().eliminate(loaded)
        self.tree.state["compact"] = 0
        self.trees.append((len(self.ends), self.tree))


@dataclass(frozen=True, eq=False)
class Lowered:
    """A model with its start before it runs, and all numbers on which the run depends."""

    compiled: Compiled
    start: State
    # tables, state, times at which signals turn, output times with the end, values of the conditions
    parts: tuple[np.ndarray, ...]
    structure: bytes  # what stands where in them
    coordinate: np.ndarray  # hinge coordinates at the start; of the model at p
    spare: Data  # work space for all models beside p

    @classmethod
    def of(cls, job: Job) -> "Lowered":
        """Return the numbers of a job."""
        run, values = job.memory, np.array([one.value for one in job.conditions])
        times = np.append(run.times, run.task["t_end"])
        parts = (run.y.copy(), run.turns[:, 0].copy(), times, values)
        tables, structure = tables_apart(job.model, parts)
        coordinate, spare = job.data.coordinate.copy(), job.compiled.data()
        return cls(job.compiled, job.start, (tables, *parts), structure, coordinate, spare)

    def beside(
        self, compiled: Compiled, start: State, t_end: float, times: np.ndarray | None, options: RunOptions
    ) -> "Lowered":
        """Return the numbers of a model beside this one, as those of its job would be."""
        turns = with_jumps(turns_of_signals(compiled.model, start.t), compiled.system, start.t)
        ends = np.array([t_end]) if times is None else np.append(times, t_end)
        values = np.array([] if options.stop_when is None else [options.stop_when.value])
        parts = (pack(compiled, start), turns[:, 0].copy(), ends, values)
        tables, structure = tables_apart(compiled.model, parts)
        link(compiled.system, compiled.model, float)
        return Lowered(compiled, start, (tables, *parts), structure, self.coordinate, self.spare)


def tables_apart(model: Model, parts: tuple[np.ndarray, ...]) -> tuple[np.ndarray, bytes]:
    """Return the numbers of the tables, as `numbers_of`, and all that must be equal for ``parts`` to be alike."""
    if model.force.dtype.hasobject:  # without the compiler
        numbers, whole = numbers_of(model), np.concatenate([x.ravel() for x in structure_of(model)])
    else:
        pieces = [getattr(model, name) for name in (*TABLES, *VECTORS)]
        words = np.concatenate([x.view(float) for x in pieces])
        on, left_out, fixed = places_in_words(tuple([x.size for x in pieces]))
        numbers, whole = words[on], words.view(np.int64)[fixed]
        numbers[left_out] = 0.0
    sizes = np.array([x.size for x in (numbers, *parts)])
    return numbers, sizes.tobytes() + whole.tobytes()


@lru_cache(maxsize=32)
def places_in_words(sizes: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the words of the numbers of tables of some sizes, which of these the motion leaves out, and all others."""
    numbers: list[np.ndarray] = []
    left_out: list[np.ndarray] = []
    fixed: list[np.ndarray] = []
    first = 0
    for name, size in zip((*TABLES, *VECTORS), sizes, strict=True):
        if name in VECTORS:
            numbers.append(np.arange(first, first + size))
            left_out.append(np.zeros(size, bool))
            first += size
            continue
        own = table(TABLE_FIELDS[name], 0).dtype
        places = first + np.arange(size * own.itemsize // 8).reshape(size, own.itemsize // 8)
        first += places.size
        for field, (x, offset, *_) in (own.fields or {}).items():
            place = places[:, offset // 8 : (offset + x.itemsize) // 8].ravel()
            out = (name, field) in NOT_OF_THE_MOTION
            if x.base.kind == "f":
                numbers.append(place)
                left_out.append(np.full(place.size, out))
            elif not out:
                fixed.append(place)
    return np.concatenate(numbers), np.concatenate(left_out), np.concatenate(fixed)


def same_structure(one: Lowered, other: Lowered) -> bool:
    """Return True if two models differ in their numbers only."""
    return one.structure == other.structure


def difference(values: Mapping[int, Any], step: float, what: str, size: float) -> np.ndarray:
    """Return the derivative by a parameter from values at p + k step; GradientError for a kink or a jump at p."""
    given = np.array([values[k] for k in (0, *OFFSETS)])
    found, moving = np.zeros(given.shape[1:]), ~(given == given[0]).all(axis=0)  # limits that stay may be infinite
    if not moving.any():
        return found
    centre, stack = given[0, moving], given[1:, moving]
    exact, lower = (weights @ stack / step for weights in (FOURTH_ORDER, SECOND_ORDER))
    largest = np.abs(given, where=np.isfinite(given), out=np.zeros_like(given)).max(initial=0.0)
    noise = KINK_ROUNDING * np.abs(stack).max(axis=0) / size + ROUNDING * largest / step
    bend = np.abs(EVEN @ (stack - centre)) / step
    bad = np.abs(exact - lower) > KINK_RATIO_MAX * np.abs(exact) + noise
    bad |= bend > KINK_RATIO_MAX * np.abs(exact) + EVEN_RATIO * noise
    if bad.any() or not np.isfinite(exact).all():
        raise GradientError(f"{what} has a kink or jumps there", advice="take the gradient at another point")
    found[moving] = exact
    return found


@dataclass(frozen=True, eq=False)
class Parameter:
    """A parameter, the step of its differences, and the models beside p."""

    name: str
    step: float
    size: float  # typical value, the unit of rounding
    beside: Mapping[int, Lowered]  # at p + k step, and at p itself

    def changes(self) -> list[np.ndarray]:
        """Return the derivatives of the parts of `Lowered`."""
        what = f"the model by '{self.name}'"
        return [
            difference({k: one.parts[i] for k, one in self.beside.items()}, self.step, what, self.size)
            for i in range(len(self.beside[1].parts))
        ]


def check_differentiable(job: Job) -> None:
    """Raise an InputError for models that have no derivatives by parameters here."""
    system, method = job.compiled.system, job.options.method
    for name in job.compiled.modes:
        part = next(x for x in (*system.joints, *system.forces) if system.name(x) == name)
        raise InputError(
            f"gradient: {type(part).__name__} '{name}' switches at events, by which no derivative is taken; leave it "
            "out, or use differences"
        )
    for force, rows in zip(system.forces, job.model.force["rows"], strict=True):
        if rows:
            raise InputError(
                f"gradient: {type(force).__name__} '{system.name(force)}' depends on a reaction, by which no "
                "derivative is taken; leave it out, or use differences"
            )
    if method.order and not isinstance(job.own, Stages):
        raise InputError(f"gradient: {type(method).__name__} has no derivatives; give DOP853(), RK4(dt) or Kinematic()")
    if job.record.tolerance:
        raise InputError("gradient: as_built leaves rows out by a tolerance; give a system that closes")


@dataclass(frozen=True, eq=False)
class SampleDerivatives:
    """Samples of a run and their derivatives by some parameters."""

    job: RecordedJob
    result: RunResult
    parameters: list[Parameter]
    arrays: dict[str, np.ndarray]  # quantity of QUANTITIES but the residual -> (k, samples, width)

    def beside(self, j: int, by: float, model: Lowered) -> RunResult:
        """Return the run with the samples moved along their derivatives by a change of parameter j, and a model."""
        found = raw_arrays(self.result)
        for name, change in self.arrays.items():
            found[name] = found[name] + by * change[j]
        found["t"] = found["t"][:, 0]
        n = self.job.model.body.size
        found["y"][:, : 7 * n] = unit_quaternions(found["y"][:, : 7 * n]).reshape(-1, 7 * n)
        data = self.job.data
        data.coordinate["value"] = found["coordinate"][-1]
        end = (found["y"][-1].copy(), float(found["t"][-1]))
        return RunResult.from_run(model.compiled, found, self.result.record, model.start, *end, data)

    def motion(self, j: int) -> float:
        """Return how far the samples move by a step in parameter j, in radians and units of the model [1]."""
        n, parameter = self.job.model.body.size, self.parameters[j]
        poses = np.abs(self.arrays["y"][j, :, : 7 * n].reshape(-1, n, 7)) * parameter.step
        turn, shift = 2.0 * poses[..., 3:].max(initial=0.0), poses[..., :3].max(initial=0.0) / self.job.model.length
        return float(max(turn, shift))


def raw_arrays(result: RunResult) -> dict[str, np.ndarray]:
    """Return the samples of a run as `RunResult.from_run` takes them, the times (samples, 1)."""
    count, found = result.t.size, {name: result.arrays["state" if name == "y" else name] for name in QUANTITIES}
    return {name: array.reshape(count, -1) for name, array in found.items()}


class Replay:
    """The replay of a recorded run with the derivatives by its parameters."""

    def __init__(
        self, job: RecordedJob, before: Lowered, result: RunResult, parameters: list[Parameter], hop: float = 1.0
    ) -> None:
        self.hop = hop * HOP_SHARE
        self.job, self.result, self.parameters = job, result, parameters
        changes = [one.changes() for one in parameters]
        tables, y, turns, times, values = (np.array(x) for x in zip(*changes, strict=True))
        self.turns, self.times, self.values = turns, times, values
        self.own = job.own if isinstance(job.own, Stages) else None
        stages = 0 if self.own is None else self.own.table.c.size
        self.complex = complex_tables(job.model)
        self.data, varied = job.compiled.data(), job.compiled.data(complex)
        for i, force in enumerate(job.compiled.system.forces):
            if isinstance(force, FunctionForce):
                self.complex.model.force["address"][i, 1] = force.address(complex, complex)
        self.varied = varied._replace(coordinate=self.data.coordinate, unwrap_time=self.data.unwrap_time)
        self.columns = new_columns(job.model, self.complex, tables, y, stages, result.t.size)
        self.start, self.tree = before, job.trees[0][1]
        self.data.coordinate[:], self.data.unwrap_time[0] = before.coordinate, before.start.t
        width = sum(array.shape[1] for array in raw_arrays(result).values())
        contacts = watched_gaps(job.compiled.system.forces)
        self.run = allocate_run(
            before.parts[1].copy(), job.model.body.size, np.zeros(0), 1, width, 0, contacts=contacts
        )
        self.run.rows["pivot"], self.next_sample, self.contacts = 1.0, 0, len(contacts)
        self.run.now["t"] = before.start.t

    def samples(self, progress: Progress) -> SampleDerivatives:
        """Return the derivatives of all samples."""
        with progress:
            if self.own is None:
                self.poses(progress)
            else:
                self.steps(progress)
                self.check_replay()
            self.check_complex()
        return SampleDerivatives(self.job, self.result, self.parameters, self.arrays())

    def arrive(self, t: float, sample: int) -> None:
        """Project state and columns at a time [s], and keep a sample where its number is not -1."""
        real = (self.job.model, self.data, self.tree)
        self.judge(arrive(*real, self.complex.model, self.varied, self.run, self.columns, t, sample), t)

    def judge(self, status: int, t: float) -> None:
        """Raise a GradientError if the replay has no solution."""
        if status != memory.RUNNING or not np.isfinite(self.columns.Y).all():
            raise GradientError(
                f"the equations have no derivative at t = {t:.6g} s", advice="end the run before it, or use differences"
            )

    def poses(self, progress: Progress) -> None:
        """Find the derivatives of each sample of driven poses; of integrals over them there are none."""
        n, states = self.job.model.body.size, self.result.arrays["state"]
        for i, t in enumerate(self.result.t):
            self.data.coordinate["value"], self.data.unwrap_time[0] = self.result.arrays["coordinate"][i], t
            self.data.coordinate["rate"] = 0.0
            self.run.y[:], self.columns.Y[:] = states[i], 0.0
            self.arrive(float(t), i)
            progress.update(float(t))
        self.columns.out[:, :, 13 * n : states.shape[1]] = np.nan

    def steps(self, progress: Progress) -> None:
        """Go through the steps of the run, split at its samples and where bodies touch and lift off."""
        job, t, trees = self.job, self.start.start.t, dict(self.job.trees)
        self.tree = trees[0]
        self.arrive(t, self.sample_at(t))
        nodes: list[tuple[float, int]] = []
        ends = np.array(job.ends)
        crowded = np.diff(ends, append=np.inf) < CROWDED_SHARE * self.mean_step()  # steps over a jump of a force
        for number, end in enumerate(job.ends, 1):
            special = number in job.restarts or number in trees
            if crowded[number - 1] and not special:
                continue
            if self.contacts:
                self.pass_contacts(end)
            nodes += [*self.samples_until(end), (end, self.sample_at(end))]
            if special or self.contacts or len(nodes) >= REPLAY_CHUNK or number == len(job.ends):
                self.take(nodes)
                nodes = []
                self.tree = trees.get(number, self.tree)
                if number in job.restarts:
                    moved = self.turns[:, np.flatnonzero(self.start.parts[2] == end)].sum(axis=1)
                    self.jump(job.restarts[number], moved)
                elif number in trees and number < len(job.ends):
                    self.arrive(end, -1)
                progress.update(end)

    def samples_until(self, t: float) -> list[tuple[float, int]]:
        """Return (time [s], number) of the samples that come next, before t."""
        first = self.next_sample
        while self.next_sample < self.result.t.size and self.result.t[self.next_sample] < t - self.apart(t):
            self.next_sample += 1
        return [(float(self.result.t[i]), i) for i in range(first, self.next_sample)]

    def sample_at(self, t: float) -> int:
        """Return the number of the next sample if it lies at t, else -1."""
        i, times = self.next_sample, self.result.t
        if i == times.size or abs(times[i] - t) > self.apart(t):
            return -1
        self.next_sample += 1
        return i

    def pass_contacts(self, end: float) -> None:
        """Go past all times up to ``end`` at which contacts begin or end: no step may have stages on both sides."""
        run = self.run
        for _ in range(TOUCHES_MAX):
            t = float(run.now["t"])
            before, after = self.touching(0.0), self.touching(end - t)
            changes = np.flatnonzero(before != after)
            if not changes.size:
                return
            found = [self.touch_ahead(k, end - t, bool(before[k])) for k in changes.tolist()]
            self.check_touch(int(changes[0]), end)
            k, at = int(changes[np.argmin(found)]), t + min(found)
            hop = self.hop_over(k, at)
            if at - hop > t:
                self.take([*self.samples_until(at - hop), (at - hop, self.sample_at(at - hop))])
            moved = np.zeros(len(self.parameters)) if before[k] else self.touch_shifts(k, float(run.now["t"]))
            self.jump(at + hop, moved)
            if at + hop >= end:
                return
        raise GradientError("contacts begin and end again and again", time=end, advice="end the run before it")

    def hop_over(self, k: int, at: float) -> float:
        """Return the time [s] from before a touch of contact k, or behind it, at which its gap is not 0 by rounding."""
        self.touching(at - float(self.run.now["t"]))
        rate, step = abs(float(self.run.gaps[k, 1, 1])), self.mean_step()
        places = self.run.y[: 7 * self.job.model.body.size].reshape(-1, 7)[:, :3]
        rounding = GAP_ROUNDINGS * float(np.spacing(np.abs(places).max(initial=self.job.model.length)))
        of_gap = rounding / rate if rounding < CROWDED_SHARE * step * rate else CROWDED_SHARE * step
        return self.hop * step + HOP_ROUNDINGS * float(np.spacing(at)) + of_gap

    def check_touch(self, k: int, t: float) -> None:
        """Raise a GradientError for a contact in a run of too loose a tolerance."""
        job, rtol = self.job, self.result.record.rtol
        if job.options.method.dt is None and rtol > CONTACT_RTOL_MAX:
            force = job.compiled.system.forces[int(self.run.contacts[k, 0])]
            raise GradientError(
                f"rtol {rtol:g} is too loose for the derivative of a run in which {type(force).__name__} "
                f"'{job.compiled.system.name(force)}' begins or ends to touch",
                time=t, advice=f"give rtol={CONTACT_RTOL_MAX:g} or less",
            )  # fmt: skip

    def closeness(self, x: float) -> np.ndarray:
        """Return the loads (contacts,) a time x [s] ahead where surfaces overlap, else the distance below 0."""
        if x > 0.0:
            gaps_ahead(self.job.model, self.data, self.tree, self.own, self.run, x)
        else:
            gaps_at(self.job.model, self.data, self.run, float(self.run.now["t"]), self.run.y)
        gaps = self.run.gaps[:, 1]
        return np.where(gaps[:, 0] < 0.0, gaps[:, 3], -gaps[:, 0])

    def touching(self, x: float) -> np.ndarray:
        """Return which contacts press a time x [s] ahead."""
        return self.closeness(x) > 0.0

    def touch_ahead(self, k: int, most: float, touching: bool) -> float:
        """Return the time [s] from now up to ``most`` at which contact k begins, or ends if it is ``touching``."""
        low, high = 0.0, most
        for _ in range(TOUCH_HALVINGS):
            middle = 0.5 * (low + high)
            if self.touching(middle)[k] == touching:
                low = middle
            else:
                high = middle
        return high

    def touch_shifts(self, k: int, t: float) -> np.ndarray:
        """Return the derivatives (k,) of the time at which contact k begins, just after t."""
        run, found = self.run, np.zeros(len(self.parameters))
        for j, parameter in enumerate(self.parameters):
            gaps = []
            for i in OFFSETS:
                other = parameter.beside[i]
                data = other.spare
                data.coordinate[:], data.unwrap_time[:] = self.data.coordinate, self.data.unwrap_time
                gaps_at(other.compiled.model, data, run, t, run.y + i * parameter.step * self.columns.Y[j])
                gaps.append(run.gaps[k, 1, 0])
            found[j] = FOURTH_ORDER @ np.array(gaps) / parameter.step
        gaps_at(self.job.model, self.data, run, t, run.y)
        return -found / run.gaps[k, 1, 1]

    def apart(self, t: float) -> float:
        """Return within what two times [s] near t are one."""
        return SAME_TIME_RATIO * max(abs(t), float(self.job.memory.task["t_end"]) - self.start.start.t)

    def take(self, nodes: list[tuple[float, int]]) -> None:
        """Take the steps that end at some times [s], with the number of the sample there or -1."""
        if not nodes:
            return
        times, samples = (np.array(x) for x in zip(*nodes, strict=True))
        real = (self.job.model, self.data, self.tree)
        status = replay(
            *real, self.complex.model, self.varied, self.own, self.run, self.columns, times, samples.astype(np.int64)
        )
        self.judge(status, float(self.run.now["t"]))

    def jump(self, t: float, moved: np.ndarray) -> None:
        """Go on at t, a moment later, behind a jump of y_dot at a time that moves with the parameters.

        By dt = ``moved``; there dy jumps by (y_dot before - y_dot after) dt.
        """
        run, columns, hop = self.run, self.columns, t - float(self.run.now["t"])
        between = [*self.samples_until(t), (t, self.sample_at(t))]
        samples = [sample for _, sample in between if sample >= 0]
        run.y[:] += hop * run.dy
        Y, before = columns.Y + hop * columns.rate, run.dy.copy()
        columns.Y[:] = Y
        self.arrive(t, -1)
        columns.Y[:] = Y + np.outer(moved, before - run.dy)
        self.arrive(t, samples[0] if samples else -1)
        for other in samples[1:]:
            columns.out[other], columns.states[other] = columns.out[samples[0]], columns.states[samples[0]]

    def check_replay(self) -> None:
        """Raise a GradientError where the replay has left the run: it was near a singular pose, or is chaotic."""
        n, limit = self.job.model.body.size, REPLAY_RATIO_MAX * self.result.record.rtol
        states = self.result.arrays["state"]
        for what in (slice(0, 7 * n), slice(7 * n, 13 * n)):
            size = np.abs(states[:, what]).max(initial=1e-300)
            apart = np.abs(self.columns.states[:, what] - states[:, what]).max(axis=1, initial=0.0) / size
            if (apart > limit).any():
                raise GradientError(
                    f"the run cannot be repeated: it differs by {apart.max():.1g} from its own steps",
                    time=float(self.result.t[np.argmax(apart > limit)]),
                    advice="it is chaotic or near a singular pose there; end it before, or give a smaller rtol",
                )

    def check_complex(self) -> None:
        """Raise a GradientError where a complex step and differences of the same equations disagree.

        So does a function that takes no complex numbers, as one with ``abs``, or that reads a parameter past the model.
        """
        for i in sorted({self.result.t.size // 2, self.result.t.size - 1}):
            for j, parameter in enumerate(self.parameters):
                lost = self.lost(i, j)
                if not lost.any():
                    continue
                system = self.job.compiled.system
                of_force = lost[-2 * len(system.forces) :].reshape(2, -1).any(axis=0) if system.forces else lost[:0]
                what = "the equations"
                if of_force.any():
                    force = system.forces[int(np.argmax(of_force))]
                    what = f"{type(force).__name__} '{system.name(force)}'"
                raise GradientError(
                    f"the derivative of {what} by '{parameter.name}' is lost",
                    time=float(self.result.t[i]),
                    advice="write its function for complex numbers, without abs and comparisons of them, and let it "
                    "read what depends on a parameter from its parameters",
                )

    def lost(self, i: int, j: int) -> np.ndarray:
        """Return which quantities of sample i have another derivative by parameter j than differences of them."""
        ny, parameter, t = self.run.y.size, self.parameters[j], float(self.result.t[i])
        step, moves, y = parameter.step, self.columns.out[i, j, :ny], raw_arrays(self.result)["y"][i]
        found = self.columns.out[i, j, ny:]
        motion = np.abs(moves[: 7 * self.job.model.body.size]).max() * step
        if motion > COMPARED_MOTION_MAX * max(1.0, self.job.model.length):
            return np.zeros(found.size, bool)
        others = [(k, parameter.beside[k]) for k in OFFSETS]
        beside = [self.sample(x.compiled.model, x.spare, t, y + k * step * moves, i)[ny:] for k, x in others]
        exact, lower = (weights @ np.array(beside) / step for weights in (FOURTH_ORDER, SECOND_ORDER))
        noise = COMPARED_ROUNDING * np.abs(beside).max(initial=0.0) / parameter.size
        smooth = np.abs(exact - lower) <= LOST_RATIO_MAX * np.abs(exact) + noise
        return smooth & ~(np.abs(found - exact) <= LOST_RATIO_MAX * np.abs(exact).max(initial=0.0) + noise)

    def sample(self, model: Model, data: Data, t: float, y: np.ndarray, i: int) -> np.ndarray:
        """Return the quantities of a sample by the equations of a model, hinge angles near those of sample i."""
        run = self.run
        data.coordinate["value"], data.unwrap_time[0] = self.result.arrays["coordinate"][i], t
        data.coordinate["rate"] = 0.0
        evaluate(model, data, self.tree, t, y, np.empty_like(y))
        run.now["written"] = 0
        write(model, data, self.tree, run, t, y)
        return run.out[0, 1:-2].copy()

    def arrays(self) -> dict[str, np.ndarray]:
        """Return the derivatives of the samples by name, at samples that move with the parameters."""
        widths = [array.shape[1] for name, array in raw_arrays(self.result).items() if name in SAMPLED]
        pieces = np.split(self.columns.out.transpose(1, 0, 2), np.cumsum(widths)[:-1], axis=2)
        found = dict(zip(SAMPLED, pieces, strict=True))
        shift = self.shifts()
        for i in np.flatnonzero(shift.any(axis=0)):
            for name, rate in zip(SAMPLED, np.split(self.rates(int(i)), np.cumsum(widths)[:-1]), strict=True):
                found[name][:, i] += np.outer(shift[:, i], rate)
        found["t"] = shift[:, :, None]
        return found

    def shifts(self) -> np.ndarray:
        """Return the derivatives (k, samples) of the sample times."""
        result, times = self.result, self.times
        shift = np.zeros((len(self.parameters), result.t.size))
        given = self.start.parts[3]
        for i, t in enumerate(result.t):
            if (at := np.flatnonzero(given == t)).size:
                shift[:, i] = times[:, at[0]]
        if self.job.fired >= 0:
            shift[:, result.t >= result.t[-1]] = self.event()[:, None]
        return shift

    def rates(self, i: int) -> np.ndarray:
        """Return the rates of all quantities at sample i, from before it, since a contact may begin there."""
        t, y = float(self.result.t[i]), raw_arrays(self.result)["y"][i]
        step, rate = SAMPLE_STEP_SHARE * self.mean_step(), np.empty_like(y)
        self.data.coordinate["value"], self.data.coordinate["rate"] = raw_arrays(self.result)["coordinate"][i], 0.0
        self.data.unwrap_time[0] = t
        evaluate(self.job.model, self.data, self.tree, t, y, rate)
        own = self.job.model, self.job.data
        found = [self.sample(*own, t - k * step, y - k * step * rate, i) for k in range(BACKWARD.size)]
        return np.concatenate([rate, (BACKWARD @ np.array(found) / step)[y.size :]])

    def mean_step(self) -> float:
        """Return the mean step of the run [s]."""
        return (float(self.result.t[-1]) - self.start.start.t) / max(len(self.job.ends), 1)

    def event(self) -> np.ndarray:
        """Return the derivatives (k,) of the time of the event that ended the run; GradientError where it is grazed."""
        job, t, y, dy, one = self.job, float(self.run.now["t"]), self.run.y, self.run.dy, self.job.conditions[0]
        step = SAMPLE_STEP_SHARE * self.mean_step()
        rate = rate_of_measure(job.compiled, self.data, self.tree, t, y, dy, step, 0)
        before, dy_before = y - step * dy, np.empty_like(dy)
        project_and_evaluate(job.model, self.data, self.tree, t - step, before, dy_before, FACTOR_FROM_OTHER_POSE)
        bend = (rate - rate_of_measure(job.compiled, self.data, self.tree, t - step, before, dy_before, step, 0)) / step
        scale = slack_of(one, job.model.length, float(job.memory.now["speed"])) / EVENT_VALUE_TOLERANCE
        margin = max(GRAZING_MARGIN_MIN, GRAZING_RTOL_RATIO_MIN * self.result.record.rtol)
        if rate * rate <= 2.0 * abs(bend) * margin * scale:
            raise GradientError(
                f"the event {one} is grazed: {one.measure.label} turns back {rate * rate / (2.0 * abs(bend)):.1g} "
                f"{one.measure.unit} behind its value",
                time=t, advice="give a value that is passed farther from where it turns, or a smaller rtol",
            )  # fmt: skip
        found = np.empty(len(self.parameters))
        complex_ = self.complex.model, self.varied
        good = differentiate_measure(job.model, self.data, self.tree, *complex_, self.run, self.columns, 0, found)
        self.judge(memory.RUNNING if good else memory.NO_SOLUTION, t)
        return (self.values[:, 0] - found) / rate
