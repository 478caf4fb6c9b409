"""Motions that grow without end, fed by feedback or custom forces: stopped before they take for ever."""

from collections.abc import Callable

import numpy as np

from ..base.errors import IntegrationError
from ..equations.compiled import Compiled
from ..integrators.memory import Run
from ..kernels.layout import Data
from ..mechanism.forces.custom import FunctionForce
from ..mechanism.forces.feedback import StateFeedback
from ..results.result import RunResult

SPEED_MAX = 1e5  # [1/s] of the length of the model: a rim at 1e5 rad/s, three times the fastest turbines
SPEED_GROWTH_MAX = 100.0  # [1] of the speed at the start: planets are fast from the beginning
STEPS_BEFORE_CHECK = 2000  # so that half of them can show a growth
RECENT_TIME_SHARE = 0.1  # [1] of the time so far: the last half of the steps of a growing motion fall within
APART = 1.01  # times the steps of the last look are those of the next one that is kept: a run may be a million slices


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
        """True for a motion that grows without end, given the state, the steps so far and the greatest speed so far.

        Asked of systems with an active force only.
        """
        n = self.compiled.model.body.size
        speed = max(speed, float(np.abs(y[7 * n : 13 * n].reshape(n, 2, 3)[:, 0]).max()))
        if not self.seen or steps > APART * self.seen[-1][0]:
            self.seen.append((steps, t, speed))
        if speed > max(SPEED_MAX * self.compiled.model.length, SPEED_GROWTH_MAX * self.seen[0][2]):
            return True
        _, t_half, speed_half = next(
            entry for entry in reversed(self.seen) if entry[0] <= steps / 2 or entry is self.seen[0]
        )
        lately = t - t_half <= RECENT_TIME_SHARE * (t - self.t_start)
        return steps > STEPS_BEFORE_CHECK and lately and speed > 1.8 * speed_half

    def check(self, run: Run, data: Data, solution: Callable[[], RunResult]) -> None:
        """IntegrationError for a motion that grows without end."""
        now = run.now
        if self.active and self.diverges(run.y, int(now.steps), float(now.t), float(now.speed)):
            raise self.error(data, float(now.t), solution())

    def error(self, data: Data, t: float, solution: RunResult) -> IntegrationError:
        """The error that names the active force of greatest power."""
        forces, power = self.compiled.system.forces, np.abs(data.force["power"][self.active])
        worst = self.active[int(np.argmax(np.where(np.isfinite(power), power, np.inf)))]
        return IntegrationError(
            "the motion grows without end",
            time=t,
            part=f"force '{self.compiled.system.name(forces[worst])}'",
            solution=solution,
            advice="check the sign and size of its gains or parameters, or end the run earlier",
        )
