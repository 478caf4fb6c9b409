"""A run through events: pieces between them, each with its own rows, and what happens from one to the next."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..base.errors import InputError, IntegrationError
from ..base.progress import Progress
from ..constraints.engagement import Strike, check_closed, impulses, joint_at
from ..equations.at_state import coordinate_row, driven_coordinates, load_state
from ..equations.compiled import Compiled, compile_system, holders_of, modes_at
from ..equations.dense_solvers import mass_matrix_of
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
from .closed_stops import Touching, at_rest, struck
from .events import EVENT_VALUE_TOLERANCE, slack_of
from .job import Job

HOP_SLACKS = 10.0  # [1] times what counts as no distance: lower hops end in rest
ENERGY_ROUNDING = 1e-9  # [1] of the kinetic energy after an impact: rounding
EVENTS_MAX, CROWDED_SHARE = 1000, 1e-6  # [events] within this share of a run: they do not come to an end
EVENTS_AT_ONCE_MAX = 20  # [events] at one time and part: more undo each other


class Watched(NamedTuple):
    """A condition, the part that watches for it, and what happens then."""

    part: Any
    watch: Watch


class SwitchedRun:
    """A run of a system with parts that switch: a `Job` from each event to the next."""

    def __init__(
        self, system: Mechanism, start: State, t_end: float, times: np.ndarray | None, options: RunOptions
    ) -> None:
        if not options.method.order:
            raise InputError(
                f"simulate: Kinematic finds poses from drivers alone, and '{system.name(switching(system)[0])}' "
                "switches at loads and impacts; give another method, or leave the part out"
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

    def run(self) -> RunResult:
        """Integrate from event to event until the end, a stop, an error or Ctrl-C."""
        self.begin()
        title = f"simulate to {self.t_end:g} s"
        while not self.stopped_by_jump():
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
            self.count(watched[number])
            self.jumps.append(self.jump(watched[number]))
        return joined(self.pieces, self.jumps)

    def stopped_by_jump(self) -> bool:
        """Return whether the last jump made the condition to stop come true; the run ends behind the jump then."""
        stop = self.options.stop_when
        if stop is None or not self.jumps:
            return False
        last, after = self.pieces[-1], self.evaluate(self.modes)
        before = replace(last, arrays={name: array[-1:] for name, array in last.arrays.items()})
        gaps = [stop.direction * (float(x.measure(stop.measure)[0]) - stop.value) for x in (before, after)]
        found = gaps[0] < 0.0 and gaps[1] > slack_of(stop, self.compiled.model.length, self.speed)
        if found:
            after.record.stopped_by = f"{stop} at t = {self.state.t:.9g} s"
            self.pieces.append(after)
        return found

    def begin(self) -> None:
        """Set the modes of locks at the start, with the impact if the motion starts against a stop."""
        if not self.locks:
            return
        before = self.evaluate(self.modes)
        self.speed = speed_of(before, self.system, self.compiled.model.length)
        compiled, data, pose = self.loaded()
        for part in self.locks:
            name, (x, _) = self.system.name(part), self.motion_of(compiled, data, pose, part)
            slack = self.slack(part, x)
            self.modes = self.modes | {name: part.placed(self.modes[name], x, slack)}
            if (beyond := part.depth(x)) > slack:
                raise InputError(
                    f"{part.what()}: the run starts {beyond:.4g} beyond its limit; start inside, or move the limit"
                )
        jump = self.settle("", "is struck at the start")
        if jump.event.impulses:
            self.pieces.append(before)
            self.jumps.append(jump)

    def job(self) -> tuple[Job, list[Watched]]:
        """Return the job of the next piece, and what it watches besides the condition to stop."""
        watched = [
            Watched(part, watch)
            for part in switching(self.system)
            for watch in part.watched(self.modes[self.system.name(part)])
        ]
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
        job.goes_on = self.state.t > self.start.t
        return job, watched

    def plain(self, piece: RunResult) -> RunResult:
        """Return a piece read by tables without the measures that were watched."""
        compiled = compile_system(self.system, (), self.options.switches, self.modes)
        arrays = piece.arrays | {"coordinate": piece.arrays["coordinate"][:, : compiled.own_coordinates]}
        return replace(piece, compiled=compiled, arrays=arrays)

    def count(self, one: Watched) -> None:
        """Refuse parts that switch for ever at one time."""
        name, last = self.system.name(one.part), self.jumps[-1].event.t if self.jumps else -np.inf
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
            return self.settle(name, action, leaving=one.part if one.part.holds(mode) else None)
        joins = mode.name == OPEN.name
        self.modes = self.modes | {name: self.engaged(one.part) if joins else OPEN}
        return self.settle(name, action, joins)

    def settle(self, name: str, action: str, joins: bool = False, leaving: Lock | None = None) -> Jump:
        """Return the jump where a part switches: first the impact, if there is one, then what holds after it."""
        hit: Strike | None = None
        held = {id(x) for x in self.locks if x.holds(self.modes[self.system.name(x)])}
        found = self.touching()
        bounce = np.array([x.bounce for x in found.locks])
        slow = np.array([self.slow(x) for x in found.locks])
        before = found.rates(found.pose.v)
        one_sided = np.array([x.one_sided for x in found.locks], bool)
        if joins:
            check_closed(found.compiled, found.data, name, found.pose.t)
        if joins or (one_sided & (before < -slow)).any():
            hit, _ = struck(found, bounce)
            self.state = replace(found.pose, v=hit.v)
        rest = self.hold(leaving)
        if hit is not None and (low := self.low_hops(*rest)).any():
            names = [x for x, ends in zip(rest[0].locks, low, strict=True) if ends]
            hit, _ = struck(found, np.where([x in names for x in found.locks], 0.0, bounce))
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
        compiled, data, pose = self.loaded()
        locks, modes = [], []
        for part in self.locks:
            x, rate = self.motion_of(compiled, data, pose, part)
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

    def hold(self, leaving: Lock | None) -> tuple[Touching, np.ndarray, np.ndarray]:
        """Set the modes of all locks by rates, loads and accelerations; return locks, rates and accelerations."""
        compiled, data, pose = self.loaded()
        for part in self.locks:
            name, rate = self.system.name(part), self.motion_of(compiled, data, pose, part)[1]
            self.modes = self.modes | {name: part.moving(self.modes[name], rate, self.slow(part))}
        found = self.touching()
        rates = found.rates(found.pose.v)
        may = np.abs(rates) <= [self.slow(x) for x in found.locks]
        begin = np.array([x is not leaving and x.holds(self.modes[self.system.name(x)]) for x in found.locks], bool)
        free = [x.opened(self.modes[self.system.name(x)]) for x in found.locks]
        if not found.locks:
            return found, rates, rates
        rest = at_rest(found, free, self.evaluate, may, begin)
        self.modes = rest.modes
        return found, rates, rest.away

    def low_hops(self, found: Touching, rates: np.ndarray, away: np.ndarray) -> np.ndarray:
        """Return which stops the motion leaves for hops lower than what is seen of them."""
        one_sided = np.array([x.one_sided for x in found.locks], bool)
        slow = np.array([self.slow(x) for x in found.locks])
        low = HOP_SLACKS * np.array(
            [self.slack(x, m.numbers[0]) for x, m in zip(found.locks, found.modes, strict=True)]
        )
        return one_sided & (rates > slow) & (away < 0.0) & (rates**2 < -2.0 * away * low)

    def evaluate(self, modes: dict[str, Mode]) -> RunResult:
        """Return accelerations and loads at the state in some modes."""
        compiled = compile_system(self.system, (), self.options.switches, modes)
        pose = replace(self.state, modes=modes, notes=())
        options = replace(self.options, stop_when=None)
        return Job(compiled, pose, pose.t, np.array([pose.t]), options).evaluate()

    def motion_of(self, compiled: Compiled, data: Data, pose: State, part: Lock) -> tuple[float, float]:
        """Return value and rate of the coordinate of a lock at a state, which is loaded in ``data``."""
        x, row = coordinate_row(compiled, data, compiled.coordinate(part.coordinate()), pose.t)
        return float(x), float(row @ pose.v)

    def slack(self, part: Lock, x: float) -> float:
        """Return what counts as no distance [rad or m] from the value x."""
        length = self.compiled.model.length if part.coordinate().kind != "angle" else 1.0
        return EVENT_VALUE_TOLERANCE * max(abs(x), length)

    def slow(self, part: Lock) -> float:
        """Return what counts as no rate [rad/s or m/s]."""
        length = self.compiled.model.length
        return EVENT_VALUE_TOLERANCE * self.speed / (length if part.coordinate().kind == "angle" else 1.0)

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


def speed_of(now: RunResult, system: Mechanism, length: float) -> float:
    """Return the speed [m/s] of a motion at its start, or that it has after the length of the model."""
    v, a = (np.abs(now.arrays[name][0]) for name in ("v", "acceleration"))
    turn, pull = length * float(v[:, 3:].max()), float(a[:, :3].max()) + length * float(a[:, 3:].max())
    expected = np.sqrt(max(pull, float(np.linalg.norm(system.gravity))) * length)
    return max(float(v[:, :3].max()), turn, float(expected)) or length


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
