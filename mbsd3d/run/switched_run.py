"""A run through events: pieces between them, each with its own rows, and what happens from one to the next."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..base.errors import InputError, IntegrationError
from ..base.progress import Progress
from ..constraints.engagement import Strike, check_closed, impulses, joint_at, strike
from ..equations.at_state import load_state
from ..equations.compiled import Compiled, compile_system, holders_of, modes_at
from ..kernels.layout import Data
from ..mechanism.engaged import Engaged
from ..mechanism.mechanism import Mechanism
from ..mechanism.measures import check_members
from ..mechanism.state import State
from ..mechanism.switched import SwitchedJoint, engaged_mode
from ..mechanism.switching import OPEN, Mode, Switching, Watch
from ..results.events import Event
from ..results.joined import Jump, joined
from ..results.record import RunOptions
from ..results.result import RunResult
from .job import Job

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
        self.pieces: list[RunResult] = []
        self.jumps: list[Jump] = []
        self.at_once: dict[str, int] = {}

    def run(self) -> RunResult:
        """Integrate from event to event until the end, a stop, an error or Ctrl-C."""
        while True:
            job, watched = self.job()
            try:
                piece = job.run(Progress(f"simulate to {self.t_end:g} s", self.start.t, self.t_end, self.options.progress))
            except IntegrationError as error:
                if error.solution is not None and self.pieces:
                    error.solution = joined([*self.pieces, self.plain(error.solution)], self.jumps)
                raise
            self.pieces.append(self.plain(piece))
            number = job.fired - (self.options.stop_when is not None)
            if job.fired < 0 or number < 0 or piece.record.stopped_by is None:
                return joined(self.pieces, self.jumps)
            if piece.final.t >= self.t_end:
                return joined(self.pieces, self.jumps)
            self.pieces[-1].record.stopped_by = None
            self.state = piece.final
            self.count(watched[number])
            self.jumps.append(self.jump(watched[number]))

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
        return Job(compiled, self.state, self.t_end, times, self.options, conditions), watched

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
        if self.at_once[name] > EVENTS_AT_ONCE_MAX:
            names = " and ".join(f"'{other}'" for other in self.at_once)
            raise IntegrationError(
                f"{names} switch again and again at one time", time=self.state.t, part=f"'{name}'",
                solution=joined(self.pieces, self.jumps) if self.pieces else None,
                advice="their conditions undo each other: set the values apart at which they engage and release",
            )  # fmt: skip

    def jump(self, one: Watched) -> Jump:
        """Switch a part, and return what that does to the motion."""
        name = self.system.name(one.part)
        if self.modes[name].name != OPEN.name:
            self.modes = self.modes | {name: OPEN}
            self.state = replace(self.state, modes=dict(self.modes), notes=())
            return Jump(Event(self.state.t, name, one.watch.action))
        self.modes = self.modes | {name: self.engaged(one.part)}
        compiled, data, pose = self.loaded()
        check_closed(compiled, data, name, pose.t)
        struck = strike(compiled, data, pose)
        self.state = replace(pose, v=struck.v)
        parts = impulses(compiled, data, struck.rows, struck.lam)
        event = Event(pose.t, name, one.watch.action, struck.lost, struck.work, parts)
        return Jump(event, *outer(compiled, data, struck))

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


def switching(system: Mechanism) -> list[Any]:
    """Return the parts of a system that switch."""
    return [part for part in holders_of(system) if isinstance(part, Switching)]


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
