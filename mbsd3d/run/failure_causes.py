"""Find why a run failed: a part with values that are not finite, conflicting drivers, a singular pose or divergence."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..base.errors import IntegrationError
from ..constraints.conflicting_drivers import Contradiction, find_contradiction
from ..constraints.singularity import INFINITESIMAL, describe_singularity
from ..dynamics.applied_forces import loads
from ..equations.at_state import load_rows
from ..equations.compiled import Compiled
from ..integrators import memory
from ..integrators.memory import Run
from ..kernels.layout import Data
from ..mechanism.drivers import AngleDriver, Driver, LengthDriver, OrientationDriver, PositionDriver, SlideDriver
from ..mechanism.forces.by_table import ByTable
from ..mechanism.forces.custom import FunctionForce
from ..mechanism.forces.feedback import StateFeedback
from ..mechanism.forces.rope import OverPulleys
from ..mechanism.joints.curve_contact import CurveContact
from ..mechanism.state import State
from ..results.result import RunResult
from .initial_checks import exception_of

NOT_FINITE = "a part returns values that are not finite"
OFF_PULLEY = "the rope comes off a pulley, where its wrap falls below 0"
NO_TANGENT = "there is no tangent: an end or a pulley has moved into another pulley"
CURVE_END_SHARE = 1e-6  # [1] of the length of a curve: within this distance of an end its point has reached it
START_TIME_SHARE = 1e-4  # [1] of the time of a run: one that ends before has not left its start
BRANCH_ADVICE = "the motion branches here; start from a nearby pose and shift the drivers with it; see system.check()"
FAILURES = {
    memory.STEP_TOO_SMALL: (
        "the step size fell below its limit",
        "a force is discontinuous or the motion is singular at this time: give a CustomForce times= at which it jumps, "
        "smooth the force, or choose an earlier t_end",
    ),
    memory.NOT_CLOSING: (
        "the constraint equations have no solution near the last pose",
        "a singular or locked position; see system.check()",
    ),
    memory.NO_SOLUTION: (
        "the equations have no finite solution",
        "check the forces and masses; where the steps are of fixed length, take a smaller dt",
    ),
    memory.FULL: ("the sample buffer is full: every step was stored", "give output=, a number of samples or times"),
    memory.NOT_CONVERGED: (
        "Newton's method did not converge in this step", "take a smaller dt, or dt=None for adaptive steps",
    ),
}  # fmt: skip
UNITS = {AngleDriver: "rad", SlideDriver: "m", PositionDriver: "m", LengthDriver: "m", OrientationDriver: "rad"}
SPEED_MAX = 1e5  # [1/s] of the length of the model: a rim at 1e5 rad/s, three times the fastest turbines
SPEED_GROWTH_MAX = 100.0  # [1] of the speed at the start: planets are fast from the beginning
STEPS_BEFORE_CHECK = 2000  # so that half of them can show a growth
RECENT_TIME_SHARE = 0.1  # [1] of the time so far: the last half of the steps of a growing motion fall within
WATCHED_STEPS_RATIO = 1.01  # [1] of the steps at the last entry kept: a run may be a million segments


def driven_to(compiled: Compiled, t: float) -> str:
    """Return the drivers, with the positions that they prescribe at t."""
    drivers = list({id(driver): driver for driver, _ in compiled.drives}.values())
    return " and ".join(
        f"driver '{compiled.system.name(x)}' ({type(x).__name__}){prescribed_positions(x, t)}" for x in drivers
    )


def prescribed_positions(driver: Driver, t: float) -> str:
    """Return the position that a driver prescribes; nothing for one that prescribes a speed."""
    unit = UNITS.get(type(driver))
    values = [float(row.signal(t)) for row in driver.primitives if row.signal is not None]
    return f" at {', '.join(f'{value:.6g}' for value in values)} {unit}" if unit and values else ""


def at_end_of_curve(compiled: Compiled, data: Data, h: float) -> str | None:
    """Name of a joint whose point comes to the end of an open curve within a time step h, if any."""
    for joint in compiled.system.joints:
        if isinstance(joint, CurveContact) and not joint.closed:
            last = data.coordinate[compiled.coordinate(joint.way)]
            near = joint.start + last["value"] + last["rate"] * h
            if not CURVE_END_SHARE * joint.line.length < near < (1.0 - CURVE_END_SHARE) * joint.line.length:
                return f"joint '{compiled.system.name(joint)}'"
    return None


def singular_start(
    compiled: Compiled, start: State, t: float = -np.inf, t_end: float = np.inf
) -> tuple[str, str] | None:  # fmt: skip
    """Return (what is wrong with the pose at the start of a run that ended at t, advice), if the run has not left it.

    What moves infinitesimally there is the reason also for a run that ends later.
    """
    what = describe_singularity(compiled, start)
    if what.startswith(INFINITESIMAL):
        return f"the mobility at the start is {what}", "see system.check()"
    stays = t - start.t <= START_TIME_SHARE * (t_end - start.t)
    return (f"the pose at the start is {what}", BRANCH_ADVICE) if what and stays else None


def singular_there(compiled: Compiled, start: State, y: np.ndarray, t: float) -> str:
    """Describe what is singular about the pose that a run has come to; "" for a regular one."""
    return describe_singularity(compiled, replace(start, t=t, q=y[: start.q.size]))


def probe_times(t: float, h: float) -> tuple[float, ...]:
    """Return times at which what ends a run shows: t, where it ended, and after a step h or a small share of t."""
    return (t, t + 1e-9 * max(abs(t), 1.0), t + max(h, 0.0), t + 1e-3 * max(abs(t), 1.0))


def contradiction(compiled: Compiled, data: Data, y: np.ndarray, t: float, h: float) -> Contradiction | None:
    """Return drivers whose signals part from t on, long after the start: two motions for one degree of freedom."""
    for later in probe_times(t, h) if len(compiled.drives) > 1 else ():
        load_rows(compiled, data, y, later)
        if not np.isfinite(data.row["J"]).all():
            return None
        clash = find_contradiction(compiled, data, later, later)
        if clash is not None and len(clash.drivers) > 1:
            return clash
    return None


class Blamed(NamedTuple):
    """Part with values that are not finite, and the name of these values."""

    part: str
    what: str


def find_nonfinite_part(
    compiled: Compiled, data: Data, y: np.ndarray, t: float, h: float, dy: np.ndarray
) -> Blamed | None:
    """Return the joint or force whose numbers are not finite at t, or just after it along the rates dy, if any."""
    for later in probe_times(t, h):
        moved = y + (later - t) * dy if np.isfinite(dy).all() else y
        load_rows(compiled, data, moved, later)
        loads(compiled.model, data, later)
        for joint in compiled.system.joints:
            rows = compiled.rows[id(joint)]
            if not np.isfinite(data.row["gamma"][rows]).all() or not np.isfinite(data.row["c"][rows]).all():
                return Blamed(f"joint '{compiled.system.name(joint)}'", NOT_FINITE)
        for k, force in enumerate(compiled.system.forces):
            own = compiled.model.force[k]
            rates = data.state_rate[own["state"] : own["state"] + own["states"]]
            known = data.force["power"][k], data.force["potential"][k], *rates
            if not np.isfinite(known).all():
                fails = what_fails(compiled, k, moved, later, rates, data.force["potential"][k])
                return Blamed(f"force '{compiled.system.name(force)}'", fails)
    return None


def what_fails(compiled: Compiled, k: int, y: np.ndarray, t: float, rates: np.ndarray, stored: float) -> str:
    """Return the exception that the function of a force raises, or which of its numbers are not finite.

    ``stored`` [J] is its energy.
    """
    force = compiled.system.forces[k]
    if isinstance(force, FunctionForce) and (error := exception_of(compiled, k, y, t)):
        return f"its function raises {type(error).__name__}{f': {error}' if str(error) else ''}"
    if isinstance(force, ByTable) and force.beyond == "refuse":
        low, high = force.points[[0, -1], 0]
        return f"its table from {low:g} to {high:g} ends; give more points, or beyond='hold' or 'line'"
    if isinstance(force, OverPulleys):
        return OFF_PULLEY if np.isfinite(stored) else NO_TANGENT
    if not np.isfinite(rates).all():
        names = ", ".join(
            f"'{name}'" for name, rate in zip(force.state_names(), rates, strict=True) if rate * 0.0 != 0.0
        )
        return f"{NOT_FINITE}: the rate of its state {names}"
    return NOT_FINITE


class DivergenceWatch:
    """Watches the greatest speed of a run.

    In a motion that grows like exp(k t) by turning, the number of steps grows with the angle, so half of them are
    spent on the last doubling of the speed, within ln 2 / k. No machine doubles its greatest speed so far in the last
    half of thousands of steps and a tenth of its time, and none reaches `SPEED_MAX` from slow motion. Only systems with
    an active force are judged.
    """

    def __init__(self, compiled: Compiled, t_start: float) -> None:
        forces = compiled.system.forces
        self.active = [i for i, force in enumerate(forces) if isinstance(force, StateFeedback | FunctionForce)]
        self.compiled, self.t_start = compiled, t_start
        self.seen: list[tuple[int, float, float]] = []  # steps, time, greatest speed

    def diverges(self, y: np.ndarray, steps: int, t: float, speed: float) -> bool:
        """Return whether a motion grows without end, given the state, the steps so far and the greatest speed so far.

        Asked of systems with an active force only.
        """
        n = self.compiled.model.body.size
        speed = max(speed, float(np.abs(y[7 * n : 13 * n].reshape(n, 2, 3)[:, 0]).max()))
        if not self.seen or steps > WATCHED_STEPS_RATIO * self.seen[-1][0]:
            self.seen.append((steps, t, speed))
        if speed > max(SPEED_MAX * self.compiled.model.length, SPEED_GROWTH_MAX * self.seen[0][2]):
            return True
        _, t_half, speed_half = next(
            entry for entry in reversed(self.seen) if entry[0] <= steps / 2 or entry is self.seen[0]
        )
        lately = t - t_half <= RECENT_TIME_SHARE * (t - self.t_start)
        return steps > STEPS_BEFORE_CHECK and lately and speed > 1.8 * speed_half

    def check(self, run: Run, data: Data, solution: Callable[[], RunResult]) -> None:
        """Raise an IntegrationError for a motion that grows without end."""
        now = run.now
        if self.active and self.diverges(run.y, int(now.steps), float(now.t), float(now.speed)):
            raise self.error(data, float(now.t), solution())

    def error(self, data: Data, t: float, solution: RunResult) -> IntegrationError:
        """Return the error that names the active force of greatest power."""
        forces, power = self.compiled.system.forces, np.abs(data.force["power"][self.active])
        worst = self.active[int(np.argmax(np.where(np.isfinite(power), power, np.inf)))]
        return IntegrationError(
            "the motion grows without end",
            time=t,
            part=f"force '{self.compiled.system.name(forces[worst])}'",
            solution=solution,
            advice="check the sign and size of its gains or parameters, or end the run earlier",
        )
