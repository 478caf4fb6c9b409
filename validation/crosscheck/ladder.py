"""A twin run with ever shorter steps, until its limit is known well enough or the time is up."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from validation.engines.base import EngineFailed, Motion, finite

from .limits import FEWEST, best_limit
from .quantities import POSES, quantities

INTERVALS = 32
"""Samples of a comparison less the start: enough to see where motions part; a power of two, as all step counts are."""
MOST_STEPS = 2**21
IDLE = 2
"""Finer runs in vain, after which rounding is all that is left."""


@dataclass
class Ladder:
    """Runs of a twin over one time, the coarsest first.

    Attributes
    ----------
    runs : list of Motion
    steps : list of int
    failed : list of str
        What coarser runs than these ended with: a step too long for the engine is no difference.
    stopped : str
        Why there are no finer runs.
    """

    twin: Any
    runs: list[Motion] = field(default_factory=list)
    steps: list[int] = field(default_factory=list)
    failed: list[str] = field(default_factory=list)
    stopped: str = ""


def first_steps(span: float, rate: float) -> int:
    """Steps of the coarsest run: a power of two, ten to a radian of the fastest turn, two to a sample at least."""
    return int(2 ** np.ceil(np.log2(max(2 * INTERVALS, 10.0 * span * rate))))


def fastest_rate(motion: Motion) -> float:
    """Greatest rate [1/s] at which velocities change their direction or spins turn, from a motion."""
    turn = float(np.abs(motion.omega).max(initial=0.0))
    change = np.linalg.norm(np.gradient(motion.velocity, motion.t, axis=0), axis=-1).max(initial=0.0)
    speed = np.linalg.norm(motion.velocity, axis=-1).max(initial=0.0)
    return max(turn, float(change / speed) if speed else 0.0)


def climb(
    twin: Any, system: Any, t_end: float, first: int, size: Any, target: float, budget: float,
    report: Callable[[float], None],
) -> Ladder:  # fmt: skip
    """Halve the step until the limit of poses and velocities is known to ``target``, or ``budget`` seconds are up.

    Raises
    ------
    EngineFailed
        If not enough runs end well.
    """
    ladder, began, steps, known = Ladder(twin), time.perf_counter(), first, []
    while not ladder.stopped:
        start = time.perf_counter()
        try:
            ladder.runs.append(finite(twin.run(t_end, steps, INTERVALS), twin.engine))
            ladder.steps.append(steps)
        except EngineFailed as error:
            ladder.failed.append(f"{steps} steps: {error}")
        if len(ladder.runs) >= FEWEST:
            known.append(known_to(ladder, system, size))
        spent, last = time.perf_counter() - began, time.perf_counter() - start
        report(min(spent / budget, 1.0))
        steps *= 2
        ladder.stopped = why_stop(ladder, known, target, spent, last, budget, steps)
    if len(ladder.runs) < FEWEST:
        raise EngineFailed(reason(ladder, t_end))
    return ladder


def why_stop(
    ladder: Ladder, known: list[float], target: float, spent: float, last: float, budget: float, steps: int
) -> str:
    """Why no finer run is made; "" to go on. The next run takes twice the time of the last one."""
    if known and known[-1] <= target:
        return f"the limit is known to {target:.0e}"
    if len(known) > IDLE and known[-1] >= 0.9 * known[-1 - IDLE]:
        return "finer steps only add rounding"
    if ladder.runs and steps // 2 not in ladder.steps:
        return ladder.failed[-1]  # it ran with longer steps
    late = spent + 2.2 * last > budget
    if late and (known or not ladder.runs or spent > 3.0 * budget):
        return f"{budget:g} s are up"
    return f"{MOST_STEPS} steps are the most" if steps > MOST_STEPS else ""


def known_to(ladder: Ladder, system: Any, size: Any) -> float:
    """How uncertain the limit of poses and velocities is at the end, relative."""
    runs = [quantities(system, motion, size) for motion in ladder.runs]
    worst = 0.0
    for name in POSES:
        values = [run[name].values / run[name].scale for run in runs]
        worst = max(worst, float(best_limit(values, ladder.twin.order).error[-1]))
    return worst


def reason(ladder: Ladder, t_end: float) -> str:
    """Why there is no limit."""
    tried = f"{len(ladder.runs)} of {FEWEST} runs with halved steps up to {t_end:g} s ended well"
    said = ladder.failed[-1] if ladder.failed else ladder.stopped
    return f"{tried} ({said})"
