"""A run: the compiled time loop in chunks, the choice of rows between them, and the samples."""

import math
import time
from collections.abc import Collection, Sequence

import numpy as np

from ..base.concurrency import turn_passed_on
from ..base.errors import AssemblyError, InputError, IntegrationError
from ..base.progress import Progress
from ..compiler.cache_folder import mark_warm
from ..compiler.first_run import announce_compilation, wait_for_second
from ..constraints.conflicting_drivers import rivals
from ..constraints.idle_rotations import check_spins, find_idle_rotations
from ..constraints.rank import choose_rows, tree_over_rows
from ..dynamics.auditing import AUDITED_FIELDS
from ..dynamics.contact_steps import watched_gaps
from ..dynamics.state_rates import FACTOR_FROM_OTHER_POSE, PROJECTED, project_and_evaluate, rate_of_motion
from ..equations.at_state import check_quaternions, driven_coordinates, load_rows, load_state, unmet, worst_joint
from ..equations.compiled import Compiled
from ..equations.jacobian import scaled_rows
from ..equations.tree import repeated_rows, surely_regular, tree_at_start
from ..integrators import memory
from ..integrators.memory import Run, allocate_run
from ..integrators.outputs import write
from ..integrators.step_control import PROJECTION_TOLERANCE
from ..kernels.coordinates import remember
from ..kernels.kinds import PROJECTION
from ..kernels.layout import Tree
from ..mechanism.drivers import SpeedDriver
from ..mechanism.forces.custom import check_runnable
from ..mechanism.measures import Condition, Measure
from ..mechanism.state import State
from ..results.reactions import NOT_DETERMINED, RunRows, group_of, is_unique
from ..results.record import MOST_NUMBERS, Record, RunOptions, Samples, buffer_size
from ..results.result import RunResult
from ..solver.saddle_point import SOLVED
from .events import armed_at_start, check_digits, comes_true_at_start, slack_of, step_that_sees_waves, turns_of_signals
from .failure_causes import (
    FAILURES,
    DivergenceWatch,
    at_end_of_curve,
    contradiction,
    driven_to,
    find_nonfinite_part,
    singular_start,
    singular_there,
)
from .friction import RestWatch, check_friction_loads, check_slipping, find_held_friction
from .initial_checks import (
    MemoryWatch,
    check_balance,
    check_initial_penetration,
    check_stops,
    longest_step,
    with_jumps,
)
from .stiffness import check_forces

CHUNK_SECONDS = 0.05  # s of kernel time between two returns to Python, for progress and Ctrl-C
BUFFER_SAMPLES = 1024  # between two returns to Python where every step is a sample
SINGULAR_EXIT_CODES = memory.STEP_TOO_SMALL, memory.NOT_CONVERGED  # which a singular pose may cause


class Job:
    """A run: the compiled time loop is called in chunks; between them samples are collected."""

    tree: Tree  # of the equations; `eliminate` makes it
    interrupted = False  # by Ctrl-C
    goes_on = False  # from an event: the condition to stop may hold there, if it has not been false before
    waiting: Collection[int] = ()  # numbers of conditions that act once they have been false, whatever is at the start
    were_false: Collection[int] = ()  # numbers of conditions that were false before: those true at the start act there
    began = np.inf  # s, when the whole run did, of which this may be a part
    speed = 0.0  # m/s, the greatest of the run before, by which conditions are judged; 0: that expected here

    def __init__(
        self, compiled: Compiled, start: State, t_end: float, times: np.ndarray | None, options: RunOptions,
        watched: Sequence[Condition] = (),
    ) -> None:  # fmt: skip
        self.conditions = ([] if options.stop_when is None else [options.stop_when]) + [*watched]
        self.compiled, self.model, self.start, self.options = compiled, compiled.model, start, options
        check_runnable(compiled.system)
        self.divergence = DivergenceWatch(compiled, start.t)
        self.rests = RestWatch(compiled, options.method.dt)
        self.data = compiled.data()
        as_built = 0.0 if options.as_built is None else options.as_built / self.model.length
        self.record = Record(options, as_built, about_centre=True)
        self.own = self.options.method.start(self.model, compiled.data)
        coordinates = driven_coordinates(compiled, start.t) if start.coordinates is None else start.coordinates
        if coordinates.size > compiled.own_coordinates:
            coordinates = coordinates[: compiled.own_coordinates]  # what another run measured is not known here
        if coordinates is not start.coordinates:
            start = State(start.t, start.q, start.v, start.z, coordinates)
        y = load_state(compiled, self.data, start)
        self.memory = self.new_run(y, t_end, times)
        self.functions = MemoryWatch(compiled, y, start.t)
        self.last_event = -1

    def new_run(self, y: np.ndarray, t_end: float, times: np.ndarray | None) -> Run:
        """Allocate the arrays of the compiled time loop and set its task."""
        m, method, n, t = self.model, self.options.method, self.model.body.size, self.start.t
        widths = (1, y.size, 6 * n, m.row.size, m.coordinate.size, m.force.size, m.force.size, 2)
        capacity = buffer_size(BUFFER_SAMPLES if times is None else times.size + 1, sum(widths)) + 2
        self.samples = Samples(widths, capacity if times is None else times.size + 1)
        run = allocate_run(
            y, self.model.body.size, np.zeros(0) if times is None else times, capacity, sum(widths), method.dense_terms,
            turns_of_signals(m, t),
            watched_gaps(self.compiled.system.forces),
            m.state.size - m.z_work,
            len(self.conditions),
        )  # fmt: skip
        run = run._replace(turns=with_jumps(run.turns, self.compiled.system, t))
        task, now = run.task, run.now  # their fields by name: as attributes each takes a microsecond more
        task["t_start"], task["t_end"], task["rtol"] = t, t_end, self.options.rtol
        task["tolerance"] = max(self.record.tolerance, 1e-9)
        task["steps"] = 0 if method.dt is None else max(int(np.ceil((t_end - t) / method.dt - 1e-9)), 1)
        task["max_step"] = longest_step(method, self.compiled.system)
        if len(self.conditions) > (self.options.stop_when is not None) and method.dt is None:
            task["max_step"] = min(task["max_step"], step_that_sees_waves(m))  # what switches watches loads
        task["every_step"], task["condition"] = times is None, -1
        for k, one in enumerate(self.conditions):
            run.watch["measure"][k], run.watch["stop"][k], run.watch["direction"][k] = k, one.value, one.direction
        if self.conditions:
            first = self.conditions[0]
            task["condition"], task["stop"], task["direction"] = 0, first.value, first.direction
        now["t"], now["fresh"], now["fired"], now["longest"] = t, 1, -1, np.inf
        run.rows["pivot"], run.rows["lowest"], run.rows["ahead"] = 1.0, 1.0, np.inf
        run.stiffness["patience"] = method.patience
        return run

    def run(self, progress: Progress) -> RunResult:
        """Call the time loop until the end, a stop, an error or Ctrl-C."""
        began, loop = time.perf_counter(), f"time loop {self.options.method.loop.__name__}"
        announce_compilation(loop)
        try:
            with progress:
                self.check_start()
                check_stops(self.compiled, self.data, self.memory.y)
                self.eliminate(loaded=True)
                check_friction_loads(self.rows_at_start())
                self.accelerate()
                self.check_driven()
                self.first_step()
                self.check_condition()
                if self.fired < 0:
                    self.loop(progress)
                else:
                    self.sample_start()
                    self.record.stopped_by = self.reason()
                mark_warm(loop)
                mark_warm()
        except KeyboardInterrupt:
            self.interrupted = True
            self.record.stopped_by = f"interrupted at t = {self.memory.now['t']:.6g} s"
        self.record.seconds = time.perf_counter() - began
        return self.solution()

    def evaluate(self) -> RunResult:
        """Evaluate one sample at the start, without integrating."""
        self.check_start()
        self.eliminate(loaded=True)
        check_friction_loads(self.rows_at_start())
        check_slipping(self.compiled, self.data, self.memory.y, self.start.t, "accelerations")
        self.sample_start()
        return self.solution()

    def sample_start(self) -> None:
        """Evaluate the state at the start and write it as a sample."""
        model, data, run, t = self.model, self.data, self.memory, self.start.t
        projected, solved = project_and_evaluate(model, data, self.tree, t, run.y, run.dy, FACTOR_FROM_OTHER_POSE)
        run.now["evaluations"] += 1
        self.note_independence()
        if projected != PROJECTED:
            self.fail(memory.NOT_CLOSING)
        if solved != SOLVED or not np.isfinite(run.dy).all():
            self.fail(memory.NO_SOLUTION)
        remember(model, data, t)
        write(model, data, self.tree, run, t, run.y)

    def loop(self, progress: Progress) -> None:
        """Call the loop in chunks of about `CHUNK_SECONDS`, the first of a millisecond; shorter to watch divergence."""
        run, budget = self.memory, 16 if self.divergence.active else max(16, 1000 // self.model.body.size)
        wait_for_second()
        while True:
            began = time.perf_counter()
            status = self.call(budget)
            spent = time.perf_counter() - began
            self.record.loop_seconds += spent
            progress.update(run.now["t"])
            self.divergence.check(run, self.data, self.solution)
            self.functions.check(float(run.now["t"]), self.solution)
            self.rests.check(run, self.data, self.tree, status == memory.DONE, self.solution)
            if status == memory.RUNNING:
                budget = int(np.clip(budget * CHUNK_SECONDS / max(spent, 1e-6), budget / 4, 4 * budget)) or 1
            elif status == memory.FULL:
                self.drain()
                if self.samples.count * run.out.shape[1] > MOST_NUMBERS:
                    self.fail(memory.FULL)
            elif status == memory.NEW_TREE:
                self.eliminate_anew()
            elif status == memory.STIFF:
                check_forces(self.compiled, run.y, run.now["t"], run.now["step"], self.solution)
                run.stiffness["patience"] = np.inf
            elif status == memory.STOPPED:
                self.record.stopped_by = self.reason()
                return
            elif status == memory.DONE:
                return
            else:
                self.fail(status)

    def call(self, budget: int) -> int:
        """Call the compiled loop of the method for up to ``budget`` steps; return its status."""
        with turn_passed_on():
            return self.options.method.loop(self.model, self.data, self.tree, self.own, self.memory, budget)

    def eliminate(self, loaded: bool = False) -> None:
        """Build the spanning tree at the present state, over all rows; of parts as built, over independent rows.

        ``loaded``: the work space holds the rows of that state, as it does at the start.
        """
        run = self.memory
        if not loaded:
            load_rows(self.compiled, self.data, run.y, run.now["t"])
        if not math.isfinite(self.data.row["J"].sum()):
            self.fail(memory.NO_SOLUTION)
        if self.record.tolerance == 0.0 and run.now["steps"] == 0:
            self.tree = tree_at_start(self.compiled, self.data, run.y[: self.start.q.size], self.start.t)
        else:
            self.record.svd_calls += self.record.tolerance > 0.0
            self.tree = tree_over_rows(self.model, self.data, self.record.tolerance)
        self.record.rows_left_out = int(self.tree.skipped.size + self.tree.loop.size)
        run.now["fresh"] = max(run.now["fresh"], 1)

    def eliminate_anew(self) -> None:
        """Build a new tree: rows of a joint have become dependent, or rows left out are violated, which is an event."""
        if self.memory.now["steps"] == self.last_event:
            self.fail(memory.NOT_CLOSING)  # the tree before did not last a single step
        self.last_event = int(self.memory.now["steps"])
        self.eliminate()
        if self.memory.rows["residual"] > 0.0:
            self.record.rank_events.append(
                (float(self.memory.now["t"]), self.tree.used.size, "rows left out violated", True)
            )

    def accelerate(self) -> None:
        """Compute the accelerations at the start, and with their factorisation whether rows repeat others."""
        run = self.memory
        project_and_evaluate(
            self.model, self.data, self.tree, self.start.t, run.y.copy(), run.dy, FACTOR_FROM_OTHER_POSE
        )
        self.note_independence()

    def note_independence(self) -> None:
        """Record that no row repeats others where all pivots of the factor at hand say so: no rank is needed then."""
        if self.record.tolerance == 0.0 and surely_regular(self.tree):
            self.record.rows_left_out = 0

    def check_driven(self) -> None:
        """Raise an InputError where Kinematic() lacks rows that determine all positions."""
        if not (self.record.kinematic and self.model.stabilisation):
            return
        need, rows = 6 * self.model.body.size, self.model.row["holonomic"]
        repeated = repeated_rows(self.tree)
        if repeated is not None and rows.all():
            rows = rows[repeated:]
        elif self.record.rows_left_out != 0:
            load_rows(self.compiled, self.data, self.memory.y, self.start.t)
            rows = rows[choose_rows(self.model, self.data)]
        holonomic = int(rows.sum())
        if holonomic < need:
            speed = [j for j in self.compiled.system.joints if isinstance(j, SpeedDriver)]
            hint = "replace SpeedDriver by AngleDriver" if speed else "add drivers, or use DOP853()"
            if singular := singular_start(self.compiled, self.start):
                raise InputError(f"Kinematic: {'; '.join(singular)}")
            spins = find_idle_rotations(self.compiled, self.data, scaled_rows(self.model, self.data))
            if spins:
                hint = f"{spins[0].text}: {spins[0].remedy}"
            raise InputError(
                f"Kinematic: {need - holonomic} of {need} degrees of freedom are not determined by joints and drivers "
                "at "
                f"position level; {hint}"
            )

    def first_step(self) -> None:
        """Set the scales of velocity errors and the first step [s] from the accelerations at the start."""
        run, model, n = self.memory, self.model, self.model.body.size
        now, task = run.now, run.task
        horizon = task["t_end"] - now["t"]
        whole, found = task["t_end"] - min(self.began, now["t"]), rate_of_motion(n, run.y, run.dy, model.length)
        # what is not finite fails later; a run without horizon may start at rest
        rate = max(found if math.isfinite(found) else 1.0, 1.0 / whole) or 1.0
        if self.options.stop_when is None:
            check_digits(float(task["t_end"]), rate)
        now["speed"], now["turn"] = rate * model.length, rate
        if self.record.kinematic:
            turning = run.y[7 * n : 13 * n].reshape(n, 6)[:, 3:]
            now["turn"] = np.abs(turning).max(initial=0.0)  # what it does turn, for the distance of poses
        share = 0.5 * task["rtol"] ** (1.0 / (self.options.method.order or 8))
        now["step"] = task["first_step"] = min(horizon, share / rate)

    def check_start(self) -> None:
        """Check the start: a projected run needs a consistent state, what the user gave is not moved silently."""
        check_quaternions(self.compiled.system, self.start)
        self.functions.check_start()
        check_balance(self.compiled, self.memory.y, self.start.t)
        check_initial_penetration(self.compiled, self.memory.y)
        if self.model.stabilisation != PROJECTION:
            return
        missed = unmet(self.compiled, self.data, self.start.v, max(1e-8, self.record.tolerance))
        if missed is not None:
            residual, unit = missed
            part, size = worst_joint(self.compiled, residual)
            raise AssemblyError(
                f"the state does not meet a joint ({unit})",
                part=part, residual=size, time=self.start.t,
                advice="start from system.assemble(), or close a joint in a motion by system.engage(joint, state); "
                "simulate parts out of line with as_built or stabilisation='none'",
            )  # fmt: skip
        if self.model.singular:
            check_spins(self.compiled, self.data)
        clash = rivals(self.compiled, self.data, self.start.t, self.memory.task["t_end"])
        if clash is not None and not self.record.tolerance:
            raise clash.error()

    def check_condition(self) -> None:
        """Arm the conditions, unless one just comes true at the start: then it waits until it has been false.

        One that was false before the event at which a run goes on has come true by it, and acts at once.
        """
        run, now, task = self.memory, self.memory.now, self.memory.task
        for k in reversed(range(len(self.conditions))):
            one, asked = self.conditions[k], self.conditions[k] is self.options.stop_when
            self.check_determined(one.measure, "simulate: stop_when" if asked else "simulate")
            slack = slack_of(one, self.model.length, self.speed or float(now["speed"]))
            found = 0, slack, 0.0
            if k not in self.waiting:
                may_hold = self.goes_on or not asked or k in self.were_false
                found = armed_at_start(self.compiled, self.data, self.tree, run, k, one, slack, may_hold)
            now["armed"], task["slack"], now["hop"] = found
            run.watch["armed"][k], run.watch["slack"][k], run.watch["hop"][k] = found
            if k in self.were_false and not found[0]:
                if comes_true_at_start(self.compiled, self.data, self.tree, run, k, one, slack):
                    now["fired"] = k

    @property
    def fired(self) -> int:
        """Return the number of the condition that ended the run, -1 for none."""
        return int(self.memory.now["fired"])

    def reason(self) -> str:
        """Return the condition that ended the run, and when, in words."""
        return f"{self.conditions[max(self.fired, 0)]} at t = {self.memory.now['t']:.9g} s"

    def check_determined(self, measure: Measure, what: str) -> None:
        """Raise an InputError for a reaction that the constraints do not determine at the start."""
        if measure.joint is None:
            return
        if not is_unique(self.compiled, self.rows_at_start().probes(), group_of(self.compiled, [measure.joint])):
            raise InputError(f"{what}: {measure.label} {NOT_DETERMINED}")

    def rows_at_start(self) -> RunRows:
        """Return the rows at the start."""
        return RunRows(
            self.compiled, np.array([self.start.t]), self.memory.y[None], self.data.coordinate["value"][None].copy(),
            self.record,
        )  # fmt: skip

    def drain(self) -> None:
        """Copy the samples out of the full buffer and empty it."""
        self.samples.take(self.memory.out[: int(self.memory.now["written"])])
        self.memory.now["written"] = 0

    def solution(self) -> RunResult:
        """Return the result up to the last sample."""
        self.drain()
        run, record = self.memory, self.record
        now = dict(zip(run.now.dtype.names or (), run.now.tolist(), strict=True))  # a field of a record takes longer
        record.steps, record.rejected = now["steps"], now["rejected"]
        record.evaluations, record.nearest = now["evaluations"], float(run.rows["lowest"])
        record.speed = now["fastest"]
        record.open_audit = tuple(now[x] for x in AUDITED_FIELDS)
        record.note_extremes(now, self.compiled.system)
        if self.options.stop_when is not None and now["armed"] == 0 and record.steps:
            record.never_armed = str(self.options.stop_when)
        arrays = self.samples.finished()
        arrays["t"] = arrays["t"][:, 0]
        return RunResult.from_run(self.compiled, arrays, record, self.start, run.y.copy(), now["t"], self.data)

    def fail(self, status: int) -> None:
        """Raise an IntegrationError with time, part, advice and what was computed."""
        t = float(self.memory.now["t"])
        solution = self.solution()
        dt = self.options.method.dt
        here = (self.compiled, self.data, self.memory.y, t, float(dt or self.memory.now["step"]))
        blamed, clash = find_nonfinite_part(*here, self.memory.dy), contradiction(*here)
        part = blamed.part if blamed else None
        what, advice = FAILURES[status]
        held = find_held_friction(self.compiled, self.data, self.memory.y, t)
        ended = at_end_of_curve(self.compiled, self.data, float(self.memory.now["step"]))
        if ended:
            part, what, advice = ended, "the contact comes to the end of its curve", "give a longer one, or end the run"
        elif part is None and held is not None:
            part, what, advice = held
        elif part is None and clash is not None:
            part, what, advice = clash.who, f"contradictory drivers: they {clash.what}", clash.advice
        elif part is None and (singular := singular_start(self.compiled, self.start, t, self.memory.task["t_end"])):
            what, advice = singular
        elif (
            part is None
            and self.compiled.drives
            and (status == memory.NOT_CLOSING or self.memory.rows["pivot"] < PROJECTION_TOLERANCE)
        ):
            part = f"{driven_to(self.compiled, t)}, where the mechanism locks or passes a singular position"
            advice = "drive it less far, or the other way; see system.check()"
            if dt is not None:
                advice = f"take a smaller dt than {dt:g} s, {advice}"
        elif status in SINGULAR_EXIT_CODES and (pose := singular_there(self.compiled, self.start, here[2], t)):
            what = f"{what}: the pose is {pose}"
        elif part is None and status == memory.NOT_CLOSING and dt is not None:
            advice = f"the step of {dt:g} s is too long, or the position singular: take a smaller dt"
        elif blamed:
            what, advice = blamed.what, "correct its parameters or function, or end the run earlier"
        raise IntegrationError(what, time=t, part=part, solution=solution, advice=advice)
