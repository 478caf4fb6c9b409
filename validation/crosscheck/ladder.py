"""A twin run with ever shorter steps, until its limit is known well enough or the time is up."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from validation.engines.base import EngineFailed, Motion

from .limits import limit_of
from .quantities import quantities

INTERVALS = 32
"""Samples of a comparison less the start: enough to see where motions part; a power of two, as all step counts are."""
FEWEST, MOST_STEPS = 4, 2**21
"""Runs with halved steps that a limit is taken from at least (three give an order, four its change), and steps."""


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
    ladder, began, steps, last = Ladder(twin), time.perf_counter(), first, 0.0
    while True:
        start = time.perf_counter()
        try:
            motion = twin.run(t_end, steps, INTERVALS)
        except EngineFailed as error:
            if ladder.runs:
                ladder.stopped = f"{steps} steps: {error}"
                break
            ladder.failed.append(f"{steps} steps: {error}")
        else:
            ladder.runs.append(motion)
            ladder.steps.append(steps)
        last, spent = time.perf_counter() - start, time.perf_counter() - began
        report(min(spent / budget, 1.0))
        if len(ladder.runs) >= FEWEST and known_to(ladder, system, size) <= target:
            ladder.stopped = f"the limit is known to {target:.0e}"
            break
        if spent + 2.2 * last > budget and (len(ladder.runs) >= FEWEST or spent > 3.0 * budget or not ladder.runs):
            ladder.stopped = f"{budget:g} s are up"
            break
        if 2 * steps > MOST_STEPS:
            ladder.stopped = f"{MOST_STEPS} steps"
            break
        steps *= 2
    if len(ladder.runs) < FEWEST:
        raise EngineFailed(reason(ladder, t_end))
    return ladder


def known_to(ladder: Ladder, system: Any, size: Any) -> float:
    """How uncertain the limit of poses and velocities is at the end, relative."""
    runs = [quantities(system, motion, size) for motion in ladder.runs[-FEWEST:]]
    worst = 0.0
    for name in ("position", "rotation", "velocity", "angular velocity"):
        values = [run[name].values / run[name].scale for run in runs]
        worst = max(worst, float(limit_of(values, ladder.twin.order).error[-1]))
    return worst


def reason(ladder: Ladder, t_end: float) -> str:
    """Why there is no limit."""
    tried = f"{len(ladder.runs)} of {FEWEST} runs with halved steps up to {t_end:g} s ended well"
    said = ladder.failed[-1] if ladder.failed else ladder.stopped
    return f"{tried} ({said})"
