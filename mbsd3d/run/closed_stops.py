"""Find which closed stops and clutches hold: by impulses in an impact, by loads and accelerations at rest."""

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ..base.errors import AssemblyError, IntegrationError
from ..base.rotations import exponential, multiply
from ..constraints.engagement import Strike, strike
from ..constraints.rank import Analysis, surely_independent
from ..dynamics.batch import loads_of_sample
from ..equations.compiled import Compiled
from ..equations.dense_solvers import mass_matrix_of
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
STICKING_TOLERANCE = 1e-6  # [1] of the rank: more than an event misses a dead centre by, where a slide cannot stick
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
    def one_sided(self) -> np.ndarray:
        """Return which locks press one way only."""
        return np.array([x.one_sided for x in self.locks], bool)

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
    before, one_sided = found.rates(found.pose.v), np.flatnonzero(found.one_sided)
    if one_sided.size > TOGETHER_MAX:
        names = ", ".join(f"'{found.compiled.system.name(found.locks[i])}'" for i in one_sided)
        raise IntegrationError(
            f"{one_sided.size} stops are closed at once: {names}", time=found.pose.t,
            advice=f"rigid stops are struck up to {TOGETHER_MAX} at a time; give some of them stiffness=",
        )  # fmt: skip
    leaving = before > IMPULSE_ROUNDING * np.abs(before).max(initial=0.0)
    clashes: list[AssemblyError] = []
    for may_return in (np.zeros(leaving.size, bool), leaving):  # what is thrown back is struck in turn
        hit = impact_of(found, bounce, one_sided, may_return, clashes)
        if hit is not None:
            return hit
    if clashes:
        raise clashes[0]
    raise IntegrationError(
        "no impulses of the stops fit the impact", time=found.pose.t, advice="give the stops stiffness= instead"
    )


def impact_of(
    found: Touching,
    bounce: np.ndarray,
    one_sided: np.ndarray,
    may_return: np.ndarray,
    clashes: list[AssemblyError],
) -> tuple[Strike, np.ndarray] | None:
    """Return the impact that fits the law of `struck`, and which locks take part; None if there is none.

    ``may_return`` (k,): locks that may be left with a rate towards them. ``clashes`` gets the errors of locks whose
    rates contradict each other, as of a stop that throws back and a freewheel.
    """
    before, row, sense = found.rates(found.pose.v), found.row, found.sense
    goal = found.data.row["b"].copy()
    goal[row] = -sense * bounce * before
    others = np.ones(goal.size, bool)
    others[row] = False
    for count in range(one_sided.size + 1):
        for chosen in combinations(one_sided, count):
            active, part = others.copy(), np.isin(np.arange(row.size), chosen)
            active[row[part]] = True
            try:
                hit = strike(found.compiled, found.data, found.pose, active, goal)
            except AssemblyError as error:
                clashes.append(error)
                continue
            pushes, after = -sense * hit.lam[row], found.rates(hit.v)
            small = IMPULSE_ROUNDING * np.abs(hit.lam).max(initial=0.0)
            slow = IMPULSE_ROUNDING * np.abs(np.concatenate([before, after])).max(initial=0.0)
            idle = np.array([i for i in one_sided if not part[i] and not may_return[i]], int)
            if (pushes[part] >= -small).all() and (after[idle] + (bounce * before)[idle] >= -slow).all():
                return hit, part
    return None


def held_down(found: Touching, hit: Strike, part: np.ndarray, low: np.ndarray) -> Strike:
    """Return an impact ``hit``, in which some locks take ``part``, in which others stay that would leave.

    ``low`` (k,): those whose hops are too low to be seen. Where they cannot all stay, as others leave, ``hit`` is kept.
    """
    row, active, goal = found.row, np.ones(found.data.row.size, bool), found.data.row["b"].copy()
    goal[row] = np.where(low, 0.0, found.rows.times(hit.v)[row])
    active[row] = part | low
    try:
        return strike(found.compiled, found.data, found.pose, active, goal)
    except AssemblyError:
        return hit


def closed(found: Touching) -> State:
    """Return the pose next to the one at hand, in the sense of kinetic energy, at which all rows are closed."""
    pose, c = found.pose, found.data.row["c"]
    move = strike(found.compiled, found.data, replace(pose, v=0.0 * pose.v), goal=-c).v.reshape(-1, 6)
    r, e = np.split(pose.q.reshape(-1, 7), [3], axis=1)
    return replace(pose, q=np.hstack([r + move[:, :3], multiply(exponential(move[:, 3:]), e)]).ravel())


class AtRest(NamedTuple):
    """State of closed stops and clutches at rest."""

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
    sticks = np.array([x.sticks for x in found.locks])
    both_ways = ~found.one_sided
    instead: tuple[np.ndarray, list[Mode]] | None = None  # of the choice at hand, if no loads meet it
    for _ in range(CHANGES_MAX * (row.size + 1) + row.size):
        modes = modes_with(found, holds, free)
        try:
            now = evaluate(modes)
        except IntegrationError:  # of what it has made hold, friction elsewhere would hold itself
            if instead is None:
                raise
            may = may & ~(holds & ~instead[0])
            (holds, free), instead = instead, None
            continue
        instead = None
        missed = found.rows.times(now.arrays["acceleration"][0].ravel()) - found.data.row["gamma"]
        a, size = missed[row], max(size, largest(now.arrays["acceleration"]), balanced(found, now))
        if contradicts(found, missed, holds, size):
            yielding = np.flatnonzero(holds & both_ways).tolist()
            if not yielding:
                if (chosen := one_sided_at_rest(found, free, evaluate, may, size)) is not None:
                    return chosen
                break
            holds, free = holds & ~both_ways, slipping(found, free, holds, yielding, evaluate)
            continue
        lam, rows = now.arrays["lam"][0], now.compiled.rows
        load = np.array([-lam[rows[id(x)].start] if held else 0.0 for x, held in zip(found.locks, holds, strict=True)])
        little = LOAD_ROUNDING * max(float(np.abs(lam).max(initial=0.0)), 1e-300)
        slow = LOAD_ROUNDING * size
        most = capacities(found, now)
        excess = np.array([x.excess(*of) for x, *of in zip(found.locks, load, found.modes, most, strict=True)])
        yields = holds & (excess > np.where(sticks, LOAD_ROUNDING * (most + LOAD_ROUNDING * largest(lam)), little))
        back = np.array([x.returns(y, *both) for x, y, *both in zip(found.locks, a, found.modes, free, strict=True)])
        closes = may & ~holds & (back > slow)
        turns = both_ways & ~may & ~holds & (back > slow)
        if turns.any():  # as the rest of the mechanism moves
            given = zip(found.locks, free, a, turns, strict=True)
            free = [x.moving(mode, y, 0.0) if turn else mode for x, mode, y, turn in given]
            continue
        if not (yields.any() or closes.any()):
            started = [
                mode if held else x.starts(y, slow, mode, bool(able and holds.any()))
                for x, y, mode, held, able in zip(found.locks, a, free, holds, may, strict=True)
            ]
            if started == free:
                return AtRest(modes, holds, sense * a)
            free = started
            continue
        k = int(np.argmax(np.where(yields, excess, -np.inf) if yields.any() else np.where(closes, back, -np.inf)))
        if yields.any() and sticks[k]:
            gives = giving_way(found, holds, k, -load[k])
            j = holding_instead(found, free, np.where(may & ~holds, gives, 0.0), most)
            if j >= 0:
                gone = found.locks[k].yielding(found.modes[k], float(load[k]))
                instead = holds & (np.arange(row.size) != k), [*free[:k], gone, *free[k + 1 :]]
                free = [*free[:k], found.locks[k].opened(gone), *free[k + 1 :]]
                holds = holds ^ np.isin(np.arange(row.size), (j, k))
                continue
        instead = None if yields.any() else (holds, free)
        holds = holds ^ (np.arange(row.size) == k)
        if yields.any():
            free = [*free[:k], found.locks[k].yielding(found.modes[k], float(load[k])), *free[k + 1 :]]
    names = ", ".join(f"'{found.compiled.system.name(x)}'" for x in found.locks)
    raise IntegrationError(
        f"it is not determined which of {names} hold",
        time=found.pose.t,
        advice="give friction yields= instead" if sticks.any() else "give stops stiffness= instead",
    )


def slipping(
    found: Touching, free: list[Mode], holds: np.ndarray, yielding: list[int],
    evaluate: Callable[[dict[str, Mode]], RunResult],
) -> list[Mode]:  # fmt: skip
    """Return the modes of locks that do not hold, where some that do slip as the rest of the mechanism moves."""
    slips = np.isin(np.arange(holds.size), yielding)
    opened = [OPEN if slip else mode for mode, slip in zip(free, slips, strict=True)]
    moved = evaluate(modes_with(found, holds & ~slips, opened)).arrays["acceleration"][0].ravel()
    along = (found.rows.times(moved) - found.data.row["gamma"])[found.row]
    return [
        x.yielding(held, -float(a)) if slip else mode
        for x, held, mode, a, slip in zip(found.locks, found.modes, opened, along, slips, strict=True)
    ]


def one_sided_at_rest(
    found: Touching, free: list[Mode], evaluate: Callable[[dict[str, Mode]], RunResult], may: np.ndarray, size: float
) -> AtRest | None:
    """Return the first choice of one-sided locks in which each that holds presses, and no other one closes.

    Where a driver takes a part away from one lock by another one, both cannot hold: loads do not tell which does.
    """
    able = np.flatnonzero(may & found.one_sided)
    for count in range(min(able.size, TOGETHER_MAX) + 1):
        for chosen in combinations(able, count):
            holds = np.isin(np.arange(may.size), chosen)
            if (fits := fitting(found, free, evaluate, may, holds, LOAD_ROUNDING * size)) is not None:
                return fits
    return None


def fitting(
    found: Touching, free: list[Mode], evaluate: Callable[[dict[str, Mode]], RunResult], may: np.ndarray,
    holds: np.ndarray, slow: float,
) -> AtRest | None:  # fmt: skip
    """Return a choice of locks that hold if each presses and no other one closes; what slips does so as it moves."""
    for _ in range(2):
        modes = modes_with(found, holds, free)
        now = evaluate(modes)
        missed = found.rows.times(now.arrays["acceleration"][0].ravel()) - found.data.row["gamma"]
        if contradicts(found, missed, holds, slow / LOAD_ROUNDING):
            return None
        a, lam, rows = missed[found.row], now.arrays["lam"][0], now.compiled.rows
        back = np.array([x.returns(y, *both) for x, y, *both in zip(found.locks, a, found.modes, free, strict=True)])
        back = np.where(may & ~holds, back, 0.0)
        turns = (back > slow) & ~found.one_sided
        if not turns.any():
            break
        given = zip(found.locks, free, a, turns, strict=True)
        free = [x.moving(mode, y, 0.0) if turn else mode for x, mode, y, turn in given]
    held = [(x, mode) for x, mode, one in zip(found.locks, found.modes, holds, strict=True) if one]
    pulls = [x.excess(-lam[rows[id(x)].start], mode, 0.0) > LOAD_ROUNDING * largest(lam) for x, mode in held]
    if any(pulls) or (back > slow).any():
        return None
    return AtRest(modes, holds, found.sense * a)


def balanced(found: Touching, now: RunResult) -> float:
    """Return the largest acceleration that the load of a row alone would give to a body at a state [m/s^2, rad/s^2].

    Accelerations are what is left of these: they have their rounding.
    """
    model, joints = found.compiled.model, found.compiled.model.row.size - found.row.size
    inertia = mass_matrix_of(model, found.data, False).diagonal().reshape(-1, 6)
    body, J, _ = found.rows.take(slice(joints))
    each = np.abs(J * now.arrays["lam"][0][:joints, None, None])
    moved = (body >= 0) & (body < inertia.shape[0])
    return largest(each[moved] / np.maximum(inertia[body[moved]], 1e-300))


def giving_way(found: Touching, holds: np.ndarray, k: int, sense: float) -> np.ndarray:
    """Return the rates of the coordinates of all locks where lock k gives way in a sense, of least kinetic energy."""
    active, goal = np.ones(found.data.row.size, bool), np.zeros(found.data.row.size)
    active[found.row[~holds]] = False
    active[found.row[k]], goal[found.row[k]] = True, np.sign(sense)
    motion = strike(found.compiled, found.data, replace(found.pose, v=0.0 * found.pose.v), active, goal).v
    rates = found.rows.times(motion)[found.row]
    return np.where(np.abs(rates) > LOAD_ROUNDING * largest(rates), rates, 0.0)


def holding_instead(found: Touching, free: list[Mode], rates: np.ndarray, most: np.ndarray) -> int:
    """Return the lock with the greatest power that would help a motion with these rates, -1 if there is none."""
    powers = [abs(rate * y) if x.helps(mode, rate) else 0.0
              for x, mode, rate, y in zip(found.locks, free, rates, most, strict=True)]  # fmt: skip
    return int(np.argmax(powers)) if max(powers) > 0.0 else -1


def capacities(found: Touching, now: RunResult) -> np.ndarray:
    """Return the loads of the own laws of the locks with the multipliers at a state that is evaluated."""
    data, forces = now.compiled.data(), now.compiled.system.forces
    arrays = now.arrays
    loads_of_sample(now.compiled.model, data, now.t[0], arrays["state"][0], arrays["coordinate"][0], arrays["lam"][0])
    return data.force["load"][[forces.index(x) for x in found.locks]]


def able_to_stick(found: Touching, may: np.ndarray) -> np.ndarray:
    """Return which locks may hold: those both ways, only where joints and drivers alone do not decide their motion."""
    wanted = np.flatnonzero(may & ~found.one_sided)
    base = rows_with(found, np.zeros(may.size, bool))
    together = [*base, *found.row[wanted]]
    if not wanted.size or surely_independent(scaled_rows_of(found, together), STICKING_TOLERANCE):
        return may
    rank, able = rank_of(found, base), may.copy()
    for i in wanted:
        able[i] = rank_of(found, [*base, found.row[i]]) > rank
    return able


def stuck_first(found: Touching, held: np.ndarray, may: np.ndarray) -> np.ndarray:
    """Return which locks hold to begin with: those ``held``, and of those that stick as many as are independent."""
    chosen = held.copy()
    wanted = np.flatnonzero(may & ~held & [x.sticks for x in found.locks])
    rows = rows_with(found, held)
    if not wanted.size or surely_independent(scaled_rows_of(found, [*rows, *found.row[wanted]]), STICKING_TOLERANCE):
        chosen[wanted] = True
        return chosen
    rank = rank_of(found, rows)
    for i in wanted:
        more = rank_of(found, [*rows, found.row[i]])
        if more > rank:
            rows, rank, chosen[i] = [*rows, found.row[i]], more, True
    return chosen


def rows_with(found: Touching, held: np.ndarray) -> list[int]:
    """Return the numbers of the rows of all joints and drivers, and of the locks that are held."""
    there = np.ones(found.data.row.size, bool)
    there[found.row[~held]] = False
    return np.flatnonzero(there).tolist()


def scaled_rows_of(found: Touching, rows: list[int]) -> BlockRows:
    """Return some of the rows, scaled to the length of the model."""
    model = found.compiled.model
    return found.rows.scaled(model.row["scale"], model.length).take(np.sort(rows))


def rank_of(found: Touching, rows: list[int]) -> int:
    """Return the rank of some of the rows."""
    return Analysis(scaled_rows_of(found, rows), STICKING_TOLERANCE).rank


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
    """Return the largest absolute value, 0 for an empty array."""
    return float(np.abs(values).max(initial=0.0))
