"""A run through events: pieces between them, each with its own rows, and what happens from one to the next."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..base.errors import InputError, IntegrationError
from ..base.progress import Progress
from ..constraints.engagement import Strike, check_closed, impulses, joint_at
from ..equations.at_state import driven_coordinates, load_state
from ..equations.compiled import Compiled, compile_system, holders_of, modes_at
from ..equations.dense_solvers import mass_matrix_of
from ..equations.jacobian import block_rows
from ..kernels.layout import Data
from ..mechanism.engaged import Engaged
from ..mechanism.lock import Lock
from ..mechanism.measures import check_members
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from ..mechanism.switched import SwitchedJoint, engaged_mode
from ..mechanism.switching import OPEN, Mode, Watch, is_switching
from ..results.events import Event
from ..results.joined import Jump, joined
from ..results.record import RunOptions
from ..results.result import RunResult
from .closed_stops import (
    Touching,
    able_to_stick,
    at_rest,
    capacities,
    closed,
    giving_way,
    held_down,
    holding_instead,
    modes_with,
    struck,
    stuck_first,
)
from .events import EVENT_VALUE_TOLERANCE, slack_of
from .job import Job

HOP_SLACKS = 10.0  # [1] times what counts as no distance: lower hops end in rest
ARMED_SLACKS = 10.0  # [1] times what counts as no difference: by that a part that was at rest has gone beyond its limit
MISSED_SLACKS = 100.0  # [1] times what counts as no distance: no event leaves a part that far beyond its limit
CLOSED_SLACKS = 0.1  # [1] times what counts as no distance: a part that is farther from its limit is set there
ENERGY_ROUNDING = 1e-9  # [1] of the kinetic energy after an impact: rounding
EVENTS_MAX, CROWDED_SHARE = 1000, 1e-6  # [events] within this share of a run: they do not come to an end
EVENTS_AT_ONCE_MAX = 20  # [events] at one time and part: more undo each other


class Watched(NamedTuple):
    """A condition, the part that watches for it, and what happens then; ``waits``: once it has been false."""

    part: Any
    watch: Watch
    waits: bool = False


class SwitchedRun:
    """A run of a system with parts that switch: a `Job` from each event to the next."""

    def __init__(
        self, system: Mechanism, start: State, t_end: float, times: np.ndarray | None, options: RunOptions
    ) -> None:
        if not options.method.order:
            raise InputError(
                f"simulate: Kinematic finds poses from drivers alone, and '{system.name(switching(system)[0])}' "
                f"switches at loads and impacts; give another method, or {switching(system)[0].without_events}"
            )
        self.system, self.start, self.t_end, self.times, self.options = system, start, t_end, times, options
        self.state, self.modes = start, modes_at(system, start)
        self.compiled = compile_system(system)
        if start.coordinates is None:
            self.state = replace(start, coordinates=driven_coordinates(self.compiled, start.t))
        self.locks = [part for part in switching(system) if isinstance(part, Lock)]
        self.pieces: list[RunResult] = []
        self.jumps: list[Jump] = []
        self.speed = 0.0  # m/s, the greatest so far, or that accelerations at the start lead to expect
        self.at_once: dict[str, int] = {}
        self.beside: dict[int, tuple[float, float]] = {}  # (value, rate) by id of locks at rest that do not hold
        self.were_false: set[str] = set()  # conditions, with what they do, that were false before the last event

    def run(self) -> RunResult:
        """Integrate from event to event until the end, a stop, an error or Ctrl-C."""
        self.begin()
        title = f"simulate to {self.t_end:g} s"
        while True:
            job, watched = self.job()
            try:
                piece = job.run(Progress(title, self.start.t, self.t_end, self.options.progress))
            except IntegrationError as error:
                if error.solution is not None and self.pieces:
                    error.solution = joined([*self.pieces, self.plain(error.solution)], self.jumps)
                raise
            self.pieces.append(self.plain(piece))
            number = job.fired - (self.options.stop_when is not None)
            if job.fired < 0 or number < 0 or job.interrupted:
                return joined(self.pieces, self.jumps)
            piece.record.stopped_by = None
            if piece.final.t >= self.t_end:
                return joined(self.pieces, self.jumps)
            self.state, self.speed = piece.final, max(self.speed, piece.record.speed)
            one = self.foremost(watched, number)
            self.were_false = self.false_until(job, watched, one)
            self.count(one.part)
            self.jumps.append(self.jump(one))
            self.strike_in_turn()

    def begin(self) -> None:
        """Set the modes of locks at the start, with the impact if the motion starts against a stop."""
        if not self.locks:
            return
        before = self.evaluate(self.modes)
        self.speed = speed_of(before, self.system, self.compiled.model.length)
        for part, (x, _) in zip(self.locks, self.motions(), strict=True):
            name = self.system.name(part)
            slack = self.slack(part, x)
            self.modes = self.modes | {name: part.placed(self.modes[name], x, slack)}
            if (beyond := part.depth(x)) > slack:
                raise InputError(
                    f"{part.what()}: the run starts {beyond:.4g} beyond its limit; start inside, or move the limit"
                )
        jump = self.settle("", "is struck at the start")
        if jump.event.impulses:
            stop = self.options.stop_when
            if stop is not None and stop.direction * (float(before.measure(stop.measure)[0]) - stop.value) < 0.0:
                self.were_false = {str(stop)}
            self.pieces.append(before)
            self.jumps.append(jump)
            self.strike_in_turn()

    def strike_in_turn(self) -> None:
        """Add the impacts that follow at once, where one throws what was leaving a stop back against it."""
        while self.locks:
            found = self.touching()
            slow = np.array([self.slow(x) for x in found.locks])
            thrown = (found.rates(found.pose.v) < -slow) & found.one_sided
            if not thrown.any():
                return
            part = found.locks[int(np.argmax(thrown))]
            self.count(part)
            self.pieces.append(self.evaluate(self.modes))
            self.jumps.append(self.settle(self.system.name(part), "is struck in turn"))

    def job(self) -> tuple[Job, list[Watched]]:
        """Return the job of the next piece, and what it watches besides the condition to stop."""
        watched = [one for part in switching(self.system) for one in self.watched(part)]
        for one in watched:
            check_members(self.system, one.watch.condition.measure, f"'{self.system.name(one.part)}'")
        stop = self.options.stop_when
        measures = [*([] if stop is None else [stop.measure]), *(one.watch.condition.measure for one in watched)]
        compiled = compile_system(self.system, tuple(measures), self.options.switches, self.modes)
        times = self.times
        if times is not None:
            first = [self.state.t] if self.pieces else []
            times = np.array([*first, *times[times > self.state.t]]) if self.pieces else times
        conditions = [one.watch.condition for one in watched]
        job = Job(compiled, self.state, self.t_end, times, self.options, conditions)
        job.goes_on, job.began, job.speed = self.state.t > self.start.t, self.start.t, self.speed
        job.waiting = {k + (stop is not None) for k, one in enumerate(watched) if one.waits}
        names = self.names_of(watched)
        job.were_false = {k for k, name in enumerate(names) if name in self.were_false}
        return job, watched

    def names_of(self, watched: list[Watched]) -> list[str]:
        """Return what tells the conditions of a job apart, in their order there: that to stop comes first."""
        stop = [] if self.options.stop_when is None else [str(self.options.stop_when)]
        return stop + [f"{self.system.name(x.part)}: {x.watch.action} {x.watch.condition}" for x in watched]

    def false_until(self, job: Job, watched: list[Watched], one: Watched) -> set[str]:
        """Return the conditions, but those of locks and of ``one``, that were false until its event.

        Several may come true at one time, or one by the jump of another: each acts. Locks are judged by `settle`.
        """
        names, first = self.names_of(watched), len(job.conditions) - len(watched)
        judged = [isinstance(x.part, Lock) or x.part is one.part for x in watched]
        false = {name for name, armed in zip(names, job.memory.watch["armed"], strict=True) if armed}
        if not job.memory.now["steps"]:  # no time has passed
            false |= self.were_false
        return false - {name for name, known in zip(names[first:], judged, strict=True) if known}

    def watched(self, part: Any) -> list[Watched]:
        """Return what a part watches for now.

        Where a lock is at rest at its limit and does not hold, rounding tells which side it is on. It is watched for
        its limit once it has left it, and from the start for what rounding does not do.
        """
        found: list[Watched] = []
        for watch in part.watched(self.modes[self.system.name(part)]):
            waits = id(part) in self.beside and self.may_hold(watch, *self.beside[id(part)])
            found += [Watched(part, watch, waits), *([Watched(part, self.beyond_rounding(watch))] if waits else [])]
        return found

    def may_hold(self, watch: Watch, x: float, rate: float) -> bool:
        """Return whether a condition of the coordinate of a lock is true or may be so by rounding."""
        one = watch.condition
        value = rate if one.measure.kind == "coordinate rate" else x
        return bool(one.direction * (value - one.value) > -slack_of(one, self.compiled.model.length, self.speed))

    def beyond_rounding(self, watch: Watch) -> Watch:
        """Return a watch that comes true by far more than what counts as no difference, so that it is armed at once."""
        one = watch.condition
        beyond = ARMED_SLACKS * slack_of(one, self.compiled.model.length, self.speed)
        return watch._replace(condition=replace(one, value=one.value + one.direction * beyond))

    def plain(self, piece: RunResult) -> RunResult:
        """Return a piece read by tables without the measures that were watched."""
        compiled = compile_system(self.system, (), self.options.switches, self.modes)
        arrays = piece.arrays | {"coordinate": piece.arrays["coordinate"][:, : compiled.own_coordinates]}
        return replace(piece, compiled=compiled, arrays=arrays)

    def foremost(self, watched: list[Watched], number: int) -> Watched:
        """Return the first part of the system whose rate comes to zero with that of part ``number``, if that does.

        Which of several a method sees first is a matter of rounding.
        """
        if not comes_to_rest(watched[number]):
            return watched[number]
        rates = {id(part): rate for part, (_, rate) in zip(self.locks, self.motions(), strict=True)}
        still = (one for one in watched if comes_to_rest(one) and abs(rates[id(one.part)]) <= self.slow(one.part))
        return next(still, watched[number])

    def count(self, part: Any) -> None:
        """Refuse parts that switch for ever at one time."""
        name, last = self.system.name(part), self.jumps[-1].event.t if self.jumps else -np.inf
        if self.state.t > last:
            self.at_once = {}
        self.at_once[name] = self.at_once.get(name, 0) + 1
        span = CROWDED_SHARE * (self.t_end - self.start.t)
        crowded = len(self.jumps) >= EVENTS_MAX and self.state.t - self.jumps[-EVENTS_MAX].event.t < span
        if self.at_once[name] > EVENTS_AT_ONCE_MAX or crowded:
            names = " and ".join(f"'{other}'" for other in self.at_once)
            raise IntegrationError(
                f"{names} switch again and again at one time", time=self.state.t, part=f"'{name}'",
                solution=joined(self.pieces, self.jumps),
                advice="set the values apart at which they engage and release; give stops stiffness=",
            )  # fmt: skip

    def jump(self, one: Watched) -> Jump:
        """Switch a part, and return what that does to the motion."""
        name, mode, action = self.system.name(one.part), self.modes[self.system.name(one.part)], one.watch.action
        if isinstance(one.part, Lock):
            self.modes = self.modes | {name: one.part.after(mode, one.watch)}
            found = self.settle(name, action, leaving=one.part if one.part.holds(mode) else None)
            became = one.part.outcome(mode, self.modes[name], action)
            return replace(found, event=replace(found.event, action=found.event.action.replace(action, became, 1)))
        joins = mode.name == OPEN.name
        self.modes = self.modes | {name: self.engaged(one.part) if joins else OPEN}
        return self.settle(name, action, joins)

    def settle(self, name: str, action: str, joins: bool = False, leaving: Lock | None = None) -> Jump:
        """Return the jump where a part switches: first the impact, if there is one, then what holds after it."""
        hit: Strike | None = None
        held = {id(x) for x in self.locks if x.holds(self.modes[self.system.name(x)])}
        found = self.at_limits()
        bounce = np.array([x.bounce for x in found.locks])
        slow = np.array([self.slow(x) for x in found.locks])
        before = found.rates(found.pose.v)
        if joins:
            check_closed(found.compiled, found.data, name, found.pose.t)
        if joins or (found.one_sided & (before < -slow)).any():
            hit, _ = struck(found, bounce)
            self.state = replace(found.pose, v=hit.v)
        rest = self.hold(leaving)
        if hit is not None and (low := self.low_hops(*rest)).any():
            names = [x for x, ends in zip(rest[0].locks, low, strict=True) if ends]
            hit, part = struck(found, np.where([x in names for x in found.locks], 0.0, bounce))
            self.state = replace(found.pose, v=hit.v)
            rest = self.hold(leaving)
            if (low := self.low_hops(*rest)).any():  # of what turns about a stop that holds
                names = [x for x, ends in zip(rest[0].locks, low, strict=True) if ends]
                hit = held_down(found, hit, part, np.array([x in names for x in found.locks]))
                self.state = replace(found.pose, v=hit.v)
                self.hold(leaving)
            action = f"{action} and comes to rest"
        if hit is not None:
            self.check_energy(found, hit)
        self.state = replace(self.state, modes=dict(self.modes), notes=())
        parts = {} if hit is None else impulses(found.compiled, found.data, hit.rows, hit.lam)
        name = name or next((x for x in map(self.system.name, self.locks) if x in parts), name)
        action += self.besides(name, held, set(parts))
        if hit is None:
            return Jump(Event(self.state.t, name, action))
        event = Event(self.state.t, name, action, hit.lost, hit.work, parts, self.time_of_rest(name, action))
        return Jump(event, *outer(found.compiled, found.data, hit))

    def check_energy(self, found: Touching, hit: Strike) -> None:
        """Refuse an impact that gives energy, as Newton's law may with several stops of different restitution."""
        kinetic = 0.5 * float(hit.v @ (mass_matrix_of(found.compiled.model, found.data, False) @ hit.v))
        if hit.lost < -ENERGY_ROUNDING * kinetic:
            names = ", ".join(f"'{self.system.name(x)}'" for x in found.locks)
            raise IntegrationError(
                f"the impact of {names} would give {-hit.lost:.3g} J", time=self.state.t,
                solution=joined(self.pieces, self.jumps) if self.pieces else None,
                advice="Newton's law of impact does so with several stops: give them one restitution, or stiffness=",
            )  # fmt: skip

    def besides(self, name: str, held: set[int], struck_too: set[str]) -> str:
        """Return what other locks do at the event of one, in words; ``held``: those that held before it."""
        found = ""
        for x in self.locks:
            other, holds = self.system.name(x), x.holds(self.modes[self.system.name(x)])
            if other == name:
                continue
            if other in struck_too and id(x) not in held:
                found += f", '{other}' is struck"
            if holds != (id(x) in held):
                found += f", '{other}' {'holds' if holds else x.leaves}"
        return found

    def time_of_rest(self, name: str, action: str) -> float | None:
        """Return when bounces have ended that are too low to be seen, by the last two times between them."""
        times = [*(jump.event.t for jump in self.jumps if name in jump.event.impulses), self.state.t]
        if "comes to rest" not in action:
            return None
        if len(times) < 3:
            return self.state.t
        last, before = times[-1] - times[-2], times[-2] - times[-3]
        ratio = last / before
        return self.state.t + last * ratio / (1.0 - ratio) if ratio < 1.0 else self.state.t

    def touching(self) -> Touching:
        """Return the locks that may hold at the state, with tables in which they do."""
        pose = replace(self.state, modes=dict(self.modes), notes=())
        locks, modes = [], []
        for part, (x, rate) in zip(self.locks, self.motions(), strict=True):
            mode = self.modes[self.system.name(part)]
            held = part.touching(mode, x, rate, self.slack(part, x), self.slow(part))
            if held is not None:
                locks.append(part)
                modes.append(held)
        whole = self.modes | dict(zip(map(self.system.name, locks), modes, strict=True))
        compiled = compile_system(self.system, (), self.options.switches, whole)
        data = compiled.data()
        load_state(compiled, data, pose)
        return Touching(locks, modes, compiled, data, pose)

    def at_limits(self) -> Touching:
        """Return the locks that may hold, after those that an event has found beyond their limits are set on them."""
        found = self.touching()
        beyond = -found.sense * found.data.row["c"][found.row]
        slack = np.array([self.slack(x, m.numbers[0]) for x, m in zip(found.locks, found.modes, strict=True)])
        if (beyond > MISSED_SLACKS * slack).any():
            k = int(np.argmax(beyond / slack))
            raise IntegrationError(
                f"'{self.system.name(found.locks[k])}' is {beyond[k]:.3g} {'m' if found.locks[k].in_metres else 'rad'} "
                "beyond its limit: an event was missed", time=self.state.t,
                solution=joined(self.pieces, self.jumps) if self.pieces else None,
                advice="take a smaller rtol or dt, or give it stiffness= where it has one",
            )  # fmt: skip
        if not (beyond > CLOSED_SLACKS * slack).any():
            return found
        self.state = closed(found)
        return self.touching()

    def hold(self, leaving: Lock | None) -> tuple[Touching, np.ndarray, np.ndarray]:
        """Set the modes of all locks by rates, loads and accelerations; return locks, rates and accelerations."""
        motions = dict(zip(map(id, self.locks), self.motions(), strict=True))
        for part in self.locks:
            name, (_, rate) = self.system.name(part), motions[id(part)]
            self.modes = self.modes | {name: part.moving(self.modes[name], rate, self.slow(part))}
        found = self.touching()
        rates = found.rates(found.pose.v)
        self.beside = {}
        if not found.locks:
            return found, rates, rates
        names, slow = [self.system.name(x) for x in found.locks], [self.slow(x) for x in found.locks]
        left = np.array([x is leaving for x in found.locks])
        still = (np.abs(rates) <= slow) & ~left  # where a load has changed its sign all may be zero
        may = able_to_stick(found, still)
        held = np.array([x.holds(self.modes[name]) for x, name in zip(found.locks, names, strict=True)]) & ~left
        free = [
            x.opened(self.modes[name]) if x is not leaving or x.one_sided else self.modes[name]
            for x, name in zip(found.locks, names, strict=True)
        ]
        for k in np.flatnonzero(still & ~may).tolist():
            free[k] = found.locks[k].idle(free[k])
        for k in np.flatnonzero(left & ~found.one_sided).tolist():
            self.let_go(found, k, free, held, may)
        rest = at_rest(found, free, self.evaluate, may, stuck_first(found, held, may))
        waits = {name: x.resting(rest.modes[name], y) for x, name, y in zip(found.locks, names, slow, strict=True)}
        self.modes = rest.modes | waits
        free_at_rest = (np.abs(rates) <= slow) & ~rest.holds
        self.beside = {id(x): motions[id(x)] for x, rests in zip(found.locks, free_at_rest, strict=True) if rests}
        return found, rates, rest.away

    def let_go(self, found: Touching, k: int, free: list[Mode], held: np.ndarray, may: np.ndarray) -> None:
        """Let another lock hold instead of lock k at its limit, or let it go with all that moves along with it.

        A one-sided lock at its limit towards which k gives way takes over: as k goes, it has no acceleration yet.
        """
        gives = giving_way(found, held, k, free[k].numbers[0])
        struck = found.one_sided & may & ~held & (found.sense * gives < 0.0)
        if struck.any():
            j = int(np.argmin(np.where(struck, found.sense * gives, np.inf)))
            free[k], held[j] = found.locks[k].opened(free[k]), True
            return
        most = capacities(found, self.evaluate(self.modes))
        j = holding_instead(found, free, np.where(may & ~held, gives, 0.0), most)
        if j >= 0 and self.bears(found, held | (np.arange(held.size) == j), free, k):
            free[k], held[j] = found.locks[k].opened(free[k]), True
            return
        may &= (gives == 0.0) | found.one_sided
        for i in np.flatnonzero(~found.one_sided).tolist():
            free[i] = found.locks[i].moving(free[i], float(gives[i]), 0.0)

    def bears(self, found: Touching, held: np.ndarray, free: list[Mode], k: int) -> bool:
        """Return whether loads exist where some locks hold and lock k is at its limit: no friction holds itself."""
        modes = [*free[:k], found.locks[k].opened(free[k]), *free[k + 1 :]]
        try:
            self.evaluate(modes_with(found, held, modes))
        except IntegrationError:
            return False
        return True

    def low_hops(self, found: Touching, rates: np.ndarray, away: np.ndarray) -> np.ndarray:
        """Return which stops the motion leaves for hops lower than what is seen of them."""
        slow = np.array([self.slow(x) for x in found.locks])
        low = HOP_SLACKS * np.array(
            [self.slack(x, m.numbers[0]) for x, m in zip(found.locks, found.modes, strict=True)]
        )
        return found.one_sided & (rates > slow) & (away < 0.0) & (rates**2 < -2.0 * away * low)

    def evaluate(self, modes: dict[str, Mode]) -> RunResult:
        """Return accelerations and loads at the state in some modes."""
        compiled = compile_system(self.system, (), self.options.switches, modes)
        pose = replace(self.state, modes=modes, notes=())
        options = replace(self.options, stop_when=None)
        return Job(compiled, pose, pose.t, np.array([pose.t]), options).evaluate()

    def motions(self) -> list[tuple[float, float]]:
        """Return value and rate at the state of what each lock holds, by rows that hold it at 0."""
        held = {self.system.name(part): Mode("held", (0.0,)) for part in self.locks}
        compiled = compile_system(self.system, (), self.options.switches, self.modes | held)
        data = compiled.data()
        load_state(compiled, data, replace(self.state, notes=()))
        rates = block_rows(compiled.model, data).times(self.state.v)
        own = [compiled.rows[id(part)].start for part in self.locks]
        return [(float(data.row["c"][k]), float(rates[k])) for k in own]

    def slack(self, part: Lock, x: float) -> float:
        """Return what counts as no distance [rad or m] from the value x."""
        length = self.compiled.model.length if part.in_metres else 1.0
        return EVENT_VALUE_TOLERANCE * max(abs(x), length)

    def slow(self, part: Lock) -> float:
        """Return what counts as no rate [rad/s or m/s]."""
        length = self.compiled.model.length
        return EVENT_VALUE_TOLERANCE * self.speed / (1.0 if part.in_metres else length)

    def loaded(self) -> tuple[Compiled, Data, State]:
        """Return the tables of the modes now, and their work space at the state."""
        compiled = compile_system(self.system, (), self.options.switches, self.modes)
        data, pose = compiled.data(), replace(self.state, modes=dict(self.modes), notes=())
        load_state(compiled, data, pose)
        return compiled, data, pose

    def engaged(self, part: SwitchedJoint) -> Mode:
        """Return the mode of a joint that engages at the state."""
        if not part.couples:
            compiled, data, pose = self.loaded()
            return engaged_mode(joint_at(compiled, data, part.joint, pose))
        modes = self.modes | {self.system.name(part): engaged_mode(Engaged(part.joint))}
        compiled = compile_system(self.system, (), self.options.switches, modes)
        data = compiled.data()
        load_state(compiled, data, self.state)
        return engaged_mode(Engaged(part.joint, offset=float(data.row["c"][compiled.rows[id(part)]][0])))


def modes_at_rest(system: Mechanism, start: State, options: RunOptions) -> dict[str, Mode]:
    """Return the modes at a state in which what sticks holds or slips; those of other parts stay."""
    run = SwitchedRun(system, start, start.t, None, options)
    run.locks = [x for x in run.locks if x.sticks]
    run.speed = speed_of(run.evaluate(run.modes), system, run.compiled.model.length)
    run.hold(None)
    return run.modes


def speed_of(now: RunResult, system: Mechanism, length: float) -> float:
    """Return the speed [m/s] of a motion at its start, or that it has after the length of the model."""
    v, a = (np.abs(now.arrays[name][0]) for name in ("v", "acceleration"))
    turn, pull = length * float(v[:, 3:].max()), float(a[:, :3].max()) + length * float(a[:, 3:].max())
    expected = np.sqrt(max(pull, float(np.linalg.norm(system.gravity))) * length)
    return max(float(v[:, :3].max()), turn, float(expected)) or length


def comes_to_rest(one: Watched) -> bool:
    """Return whether a lock is watched for a rate that becomes zero."""
    found = one.watch.condition
    return isinstance(one.part, Lock) and found.measure.kind == "coordinate rate" and found.value == 0.0


def switching(system: Mechanism) -> list[Any]:
    """Return the parts of a system that switch."""
    return [part for part in holders_of(system) if is_switching(part)]


def outer(compiled: Compiled, data: Data, struck: Strike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return what an impact adds: work of each driven row [J], impulse from outside [N s] and about the centre."""
    model, n, mass = compiled.model, compiled.model.body.size, compiled.model.body["mass"]
    driven = np.flatnonzero(model.row["drive"] >= 0)
    work = np.zeros(driven.size)
    work[model.row["drive"][driven]] = -struck.lam[driven] * data.row["b"][driven]
    force, moment = np.split(struck.momenta.reshape(n, 6), 2, axis=1)
    r = data.body["r"][:n]
    centre = mass @ (r + data.body["s"][:n]) / max(float(mass.sum()), 1e-300)
    return work, force.sum(axis=0), (moment + np.cross(r - centre, force)).sum(axis=0)
