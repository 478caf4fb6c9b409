"""Which of the locks that touch hold: by impulses in an impact, by loads and accelerations at rest."""

from collections.abc import Callable
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ..base.errors import IntegrationError
from ..constraints.engagement import Strike, strike
from ..equations.compiled import Compiled
from ..equations.jacobian import BlockRows, block_rows
from ..kernels.layout import Data
from ..mechanism.lock import Lock
from ..mechanism.state import State
from ..mechanism.switching import OPEN, Mode
from ..results.result import RunResult

TOGETHER_MAX = 8  # [stops] that may be struck at once: all choices among them are tried
IMPULSE_ROUNDING = 1e-9  # [1] of the greatest impulse or rate of an impact: rounding
LOAD_ROUNDING = 1e-9  # [1] of the greatest load or acceleration of the rows: rounding
CONTRADICTION_MIN = 1e-6  # [1] of the accelerations by which rows are missed that contradict each other
CHANGES_MAX = 3  # [1] times the locks: changes of what holds, by loads and accelerations in turn


class Touching(NamedTuple):
    """Locks whose rows may hold at a pose, with the tables in which all of them do."""

    locks: list[Lock]
    modes: list[Mode]  # in which they hold
    compiled: Compiled
    data: Data
    pose: State  # which is loaded in data

    @property
    def row(self) -> np.ndarray:
        """Return the row of each lock."""
        return np.array([self.compiled.rows[id(x)].start for x in self.locks], int)

    @property
    def sense(self) -> np.ndarray:
        """Return the sign of the load with which each presses."""
        return np.array([x.sense(mode) for x, mode in zip(self.locks, self.modes, strict=True)])

    @property
    def rows(self) -> BlockRows:
        """Return all rows."""
        return block_rows(self.compiled.model, self.data)

    @property
    def acceleration_scale(self) -> float:
        """Return the size of accelerations that gravity, the motion and drivers lead to expect [m/s^2, rad/s^2]."""
        model, v = self.compiled.model, np.abs(self.pose.v.reshape(-1, 6))
        rate = max(largest(v[:, 3:]), largest(v[:, :3]) / model.length)
        gravity = float(np.linalg.norm(model.gravity))
        return max(gravity, rate * rate * max(model.length, 1.0), largest(self.data.row["gamma"]))

    def rates(self, v: np.ndarray) -> np.ndarray:
        """Return the rates at which the coordinates leave what they are held by."""
        return self.sense * self.rows.times(v)[self.row]


def struck(found: Touching, bounce: np.ndarray) -> tuple[Strike, np.ndarray]:
    """Return the impact, and which locks take part: ``0 <= P``, ``v' + e v >= 0``, one of both zero.

    P are the impulses of the locks, v and v' the rates away from them before and after, e their restitution (k,).
    """
    before, row, sense = found.rates(found.pose.v), found.row, found.sense
    one_sided = np.flatnonzero([x.one_sided for x in found.locks])
    if one_sided.size > TOGETHER_MAX:
        names = ", ".join(f"'{found.compiled.system.name(found.locks[i])}'" for i in one_sided)
        raise IntegrationError(
            f"{one_sided.size} stops are closed at once: {names}", time=found.pose.t,
            advice=f"rigid stops are struck up to {TOGETHER_MAX} at a time; give some of them stiffness=",
        )  # fmt: skip
    goal = found.data.row["b"].copy()
    goal[row] = -sense * bounce * before
    others = np.ones(goal.size, bool)
    others[row] = False
    for count in range(one_sided.size + 1):
        for chosen in combinations(one_sided, count):
            active, part = others.copy(), np.isin(np.arange(row.size), chosen)
            active[row[part]] = True
            hit = strike(found.compiled, found.data, found.pose, active, goal)
            pushes, after = -sense * hit.lam[row], found.rates(hit.v)
            small = IMPULSE_ROUNDING * np.abs(hit.lam).max(initial=0.0)
            slow = IMPULSE_ROUNDING * np.abs(np.concatenate([before, after])).max(initial=0.0)
            idle = np.array([i for i in one_sided if not part[i]], int)
            if (pushes[part] >= -small).all() and (after[idle] + (bounce * before)[idle] >= -slow).all():
                return hit, part
    raise IntegrationError(
        "no impulses of the stops fit the impact", time=found.pose.t, advice="give the stops stiffness= instead"
    )


class AtRest(NamedTuple):
    """What holds where locks touch without a rate."""

    modes: dict[str, Mode]  # of the whole system
    holds: np.ndarray  # (k,)
    away: np.ndarray  # (k,) accelerations away from what would hold


def at_rest(
    found: Touching, free: list[Mode], evaluate: Callable[[dict[str, Mode]], RunResult], may: np.ndarray,
    begin: np.ndarray,
) -> AtRest:  # fmt: skip
    """Return which of the locks hold: each presses or its coordinate leaves, ``0 <= load``, ``a >= 0``, one of both 0.

    One that holds both ways does so up to its torque, and slips in the sense in which it yields. ``may``: which may
    hold; ``free``: their modes where they do not; ``begin``: those that are tried first; ``evaluate(modes)``:
    accelerations and loads at once.
    """
    row, sense = found.row, found.sense
    free, holds, size = list(free), begin & may, found.acceleration_scale
    for _ in range(CHANGES_MAX * (row.size + 1)):
        modes = modes_with(found, holds, free)
        now = evaluate(modes)
        missed = found.rows.times(now.arrays["acceleration"][0].ravel()) - found.data.row["gamma"]
        a, size = missed[row], max(size, largest(now.arrays["acceleration"]))
        if contradicts(found, missed, holds, size):
            yielding = [i for i in np.flatnonzero(holds).tolist() if not found.locks[i].one_sided]
            if not yielding:
                break
            holds = holds & [x.one_sided for x in found.locks]
            for i in yielding:  # they slip as the rest of the mechanism moves
                free[i] = OPEN
            moved = evaluate(modes_with(found, holds, free)).arrays["acceleration"][0].ravel()
            for i in yielding:
                along = (found.rows.times(moved) - found.data.row["gamma"])[row[i]]
                free[i] = found.locks[i].yielding(found.modes[i], -float(along))
            continue
        lam, rows = now.arrays["lam"][0], now.compiled.rows
        load = np.array([-lam[rows[id(x)].start] if held else 0.0 for x, held in zip(found.locks, holds, strict=True)])
        little = LOAD_ROUNDING * max(float(np.abs(lam).max(initial=0.0)), 1e-300)
        slow = LOAD_ROUNDING * size
        excess = np.array([x.excess(y, mode) for x, y, mode in zip(found.locks, load, found.modes, strict=True)])
        yields = holds & (excess > little)
        back = np.array([x.returns(y, *both) for x, y, *both in zip(found.locks, a, found.modes, free, strict=True)])
        closes = may & ~holds & (back > slow)
        if not (yields.any() or closes.any()):
            return AtRest(modes, holds, sense * a)
        k = int(np.argmax(np.where(yields, excess, -np.inf) if yields.any() else np.where(closes, back, -np.inf)))
        holds = holds ^ (np.arange(row.size) == k)
        if yields.any():
            free[k] = found.locks[k].yielding(found.modes[k], float(load[k]))
    names = ", ".join(f"'{found.compiled.system.name(x)}'" for x in found.locks)
    raise IntegrationError(
        f"it is not determined which of {names} hold", time=found.pose.t, advice="give stops stiffness= instead"
    )


def contradicts(found: Touching, missed: np.ndarray, holds: np.ndarray, size: float) -> bool:
    """Return whether accelerations, of a ``size``, miss rows that are there, since these ask for different ones."""
    there = np.ones(missed.size, bool)
    there[found.row[~holds]] = False
    return bool(largest(missed[there]) > CONTRADICTION_MIN * size)


def modes_with(found: Touching, holds: np.ndarray, free: list[Mode]) -> dict[str, Mode]:
    """Return the modes of the system in which some of the locks hold, and the others have those in ``free``."""
    chosen = (mode if held else other for mode, held, other in zip(found.modes, holds, free, strict=True))
    return dict(found.compiled.modes) | dict(zip(map(found.compiled.system.name, found.locks), chosen, strict=True))


def largest(values: np.ndarray) -> float:
    """Return the largest absolute value, 0 of none."""
    return float(np.abs(values).max(initial=0.0))
