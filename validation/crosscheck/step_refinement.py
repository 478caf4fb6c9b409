"""Runs of an engine with ever shorter steps, and their limit: its order, and its uncertainty."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mbsd3d import System
from mbsd3d.errors import InputError
from validation.crosscheck.mbsd3d_runs import BASIC_QUANTITIES, quantities, running_max
from validation.twins.base import Array, EngineFailed, Motion, finite

INTERVAL_COUNT = 32
"""Samples of a comparison less the start: enough to see where motions part; a power of two, as all step counts are."""
STEPS_MAX = 2**21
IDLE_RUNS_MAX = 2  # [1] finer runs without improvement, after which only rounding is left
LIMIT_ROUNDING = 1e-12
"""Gaps below this part of a quantity's size are rounding of 10^3 to 10^6 steps: no order is read from them."""
RUNS_MIN = 4  # [1] runs of a limit: three give an order, the fourth shows whether it stays
ORDER_MIN = 0.5  # [1] below it halving the step hardly helps, and extrapolating would only amplify


@dataclass(frozen=True)
class Limit:
    """Limit of a quantity over ever shorter steps, all relative to its size.

    ``values`` (n, parts, k): Richardson's limit of the finest runs; ``error`` (n,): how uncertain it is up to each
    sample: by how much the limit moves when the finest run is added, and when it is extrapolated with the expected
    order instead of the observed one; ``order``: observed: log2 of the ratio of the last two gaps; None if they are
    rounding; ``gaps``: greatest differences of neighbouring runs.
    """

    values: Array
    error: Array
    order: float | None
    gaps: tuple[float, ...]


def observed_order(gaps: Sequence[float]) -> float | None:
    """Return log2 of the ratio of neighbouring gaps, of the last pair above rounding; None if all are rounding."""
    for coarse, fine in reversed(list(zip(gaps[:-1], gaps[1:], strict=True))):
        if fine > LIMIT_ROUNDING:
            return float(np.log2(coarse / fine)) if coarse > 0.0 else 0.0
    return None


def limit_of(runs: Sequence[Array], expected: float, span: int | None = None, first: int = 0) -> Limit:
    """Extrapolate the limit of three or more runs (n, parts, k), each with half the step of the one before; relative
    numbers.

    The order is observed from sample ``first`` up to ``span`` (None: all), and used for the extrapolation: with gaps d
    and order p the limit lies d / (2^p - 1) beyond the finest run. Three runs carry two such limits; their distance is
    the error, with what the ``expected`` order would change: an order fitted to two gaps makes their limits agree.

    ValueError for fewer than three runs: order and error need three.
    """
    if len(runs) < 3:
        raise InputError(f"limit_of: {len(runs)} runs; give three or more with halved steps")
    moves = [fine - coarse for coarse, fine in zip(runs[:-1], runs[1:], strict=True)]
    counts = (np.arange(len(runs[0])) >= first)[:, None, None]
    gaps = tuple(float(np.abs(move[first:span]).max(initial=0.0)) for move in moves)
    order, last = observed_order(gaps), running_max(moves[-1] * counts)
    if order is None:
        return Limit(runs[-1], last + LIMIT_ROUNDING, None, gaps)
    if order < ORDER_MIN:
        return Limit(runs[-1], last + running_max(moves[-2] * counts), order, gaps)
    beyond, usual = (1.0 / (2.0**p - 1.0) for p in (order, expected))
    coarser, finer = (run + beyond * move for run, move in zip(runs[-2:], moves[-2:], strict=True))
    error = running_max((finer - coarser) * counts) + abs(beyond - usual) * last + LIMIT_ROUNDING
    return Limit(finer, error, order, gaps)


def best_limit(runs: Sequence[Array], expected: float, span: int | None = None, first: int = 0) -> Limit:
    """Return the limit of the first runs, as many as give the smallest error: finer ones may only add rounding.

    An implicit engine divides the errors of its iterations by the step, or by its square in multipliers.
    """
    last = -1 if span is None else span - 1
    found = [limit_of(runs[:count], expected, span, first) for count in range(RUNS_MIN, len(runs) + 1)]
    return min(found, key=lambda limit: limit.error[last])


@dataclass
class Ladder:
    """Runs of an engine over one time, the coarsest first.

    ``failed``: how coarser runs ended; a step too long for the engine does not count as a difference; ``stopped``: why
    there are no finer runs.
    """

    twin: Any
    runs: list[Motion] = field(default_factory=list)
    steps: list[int] = field(default_factory=list)
    failed: list[str] = field(default_factory=list)
    stopped: str = ""


def first_steps(span: float, rate: float) -> int:
    """Return the steps of the coarsest run: a power of two, ten to a radian of the fastest turn, two to a sample at
    least.
    """
    return int(2 ** np.ceil(np.log2(max(2 * INTERVAL_COUNT, 10.0 * span * rate))))


def fastest_rate(motion: Motion) -> float:
    """Return the greatest rate [1/s] at which velocities change their direction or bodies rotate, from a motion."""
    turn = float(np.abs(motion.omega).max(initial=0.0))
    change = np.linalg.norm(np.gradient(motion.velocity, motion.t, axis=0), axis=-1).max(initial=0.0)
    speed = np.linalg.norm(motion.velocity, axis=-1).max(initial=0.0)
    return max(turn, float(change / speed) if speed else 0.0)


def climb(
    twin: Any, system: System, t_end: float, first: int, size: Any, target: float, budget: float,
    report: Callable[[float], None],
) -> Ladder:  # fmt: skip
    """Halve the step until the limit of poses and velocities is known to ``target``, or ``budget`` seconds are used.

    EngineFailed if not enough runs end well.
    """
    ladder, began, steps, known = Ladder(twin), time.thread_time(), first, []
    while not ladder.stopped:
        start = time.thread_time()
        try:
            ladder.runs.append(finite(twin.run(t_end, steps, INTERVAL_COUNT), twin.engine))
            ladder.steps.append(steps)
        except EngineFailed as error:
            ladder.failed.append(f"{steps} steps: {error}")
        if len(ladder.runs) >= RUNS_MIN:
            known.append(known_to(ladder, system, size))
        spent, last = time.thread_time() - began, time.thread_time() - start
        report(min(spent / budget, 1.0))
        steps *= 2
        ladder.stopped = why_stop(ladder, known, target, spent, last, budget, steps)
    if len(ladder.runs) < RUNS_MIN:
        raise EngineFailed(reason(ladder, t_end))
    return ladder


def why_stop(
    ladder: Ladder, known: list[float], target: float, spent: float, last: float, budget: float, steps: int
) -> str:
    """Return why no finer run is made; "" to continue. The next run takes twice the time of the last one."""
    if known and known[-1] <= target:
        return f"the limit is known to {target:.0e}"
    if len(known) > IDLE_RUNS_MAX and known[-1] >= 0.9 * known[-1 - IDLE_RUNS_MAX]:
        return "finer steps only add rounding"
    if ladder.runs and steps // 2 not in ladder.steps:
        return ladder.failed[-1]  # it ran with longer steps
    late = spent + 2.2 * last > budget
    if late and (known or not ladder.runs or spent > 3.0 * budget):
        return f"{budget:g} s are up"
    return f"{STEPS_MAX} steps are the most" if steps > STEPS_MAX else ""


def known_to(ladder: Ladder, system: System, size: Any) -> float:
    """Return the relative uncertainty of the limit of poses and velocities at the end."""
    runs = [quantities(system, motion, size) for motion in ladder.runs]
    worst = 0.0
    for name in BASIC_QUANTITIES:
        values = [run[name].values / run[name].scale for run in runs]
        worst = max(worst, float(best_limit(values, ladder.twin.order).error[-1]))
    return worst


def reason(ladder: Ladder, t_end: float) -> str:
    """Return why there is no limit."""
    tried = f"{len(ladder.runs)} of {RUNS_MIN} runs with halved steps up to {t_end:g} s ended well"
    said = ladder.failed[-1] if ladder.failed else ladder.stopped
    return f"{tried} ({said})"
