"""Fully driven systems: at every sample the pose by assembly, velocity and acceleration by linear solves."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..kernels.coordinates import remember
from ..kernels.dynamics import PROJECTED, arrive
from ..kernels.jit import inner_kernel, kernel
from ..kernels.saddle import SOLVED
from ..kernels.vectors import add_scaled, copy, finite
from .base import (
    CHOOSE_ROWS,
    DONE,
    EVALUATIONS,
    FRESH,
    FULL,
    MAX_STEP,
    NEXT,
    NO_SOLUTION,
    NOT_CLOSING,
    RUNNING,
    STEPS,
    TURN,
    WRITTEN,
    T,
    references,
    rows_hold,
    start,
    write,
)


@dataclass(frozen=True)
class Kinematic:
    """No ODE: for systems whose drivers determine the whole motion (rank of the rows = 6 per body).

    ``max_step`` [s] bounds the distance between poses, so that Newton stays on its branch.
    """

    max_step: float = np.inf

    order = 0

    def __post_init__(self) -> None:
        if not self.max_step > 0.0:
            raise ValueError(f"Kinematic: max_step {self.max_step} is not positive; give a time > 0")

    @property
    def loop(self) -> Callable:
        """The compiled loop over the output times."""
        return follow

    def own(self, compiled: Any, table: None) -> tuple:
        """What the loop takes beside model, work space, rows and run."""
        return ()


@inner_kernel
def predict(m, run, h):
    """Trial pose from the last one: y + h dy + h^2/2 d2y for positions, the rotation by its angular velocity."""
    n = m.body.shape[0]
    copy(run.trial, run.y)
    add_scaled(run.trial, h, run.dy)
    for i in range(n):
        for j in range(3):
            run.trial[7 * i + j] += 0.5 * h * h * run.dy[7 * n + 6 * i + j]


@kernel
def follow(m, d, s, run, budget):
    """Visit the output times; DONE, RUNNING after `budget` poses, or a reason to come back to Python."""
    if run.count[FRESH] == 1:
        status = start(m, d, s, run)
        if status != RUNNING:
            return status
        references(m, d, run)
    for _ in range(budget):
        if run.count[NEXT] >= run.times.shape[0]:
            return DONE
        if run.count[WRITTEN] >= run.out.shape[0] - 2:
            return FULL
        t_new = run.times[run.count[NEXT]]
        h = t_new - run.clock[T]
        pieces = max(1, int(np.ceil(max(h * run.clock[TURN] / 0.3, h / run.clock[MAX_STEP]))))  # 0.3 rad per Newton
        for piece in range(pieces):
            t = t_new if piece == pieces - 1 else run.clock[T] + h / pieces
            predict(m, run, t - run.clock[T])
            status, result = arrive(m, d, s, t, run.trial, run.work_rate)
            run.count[EVALUATIONS] += 1
            if status != PROJECTED:
                return NOT_CLOSING
            if result != SOLVED or not finite(run.work_rate):
                return NO_SOLUTION
            remember(m, d, t)
            references(m, d, run)
            copy(run.y, run.trial)
            copy(run.dy, run.work_rate)
            run.clock[T] = t
            run.count[STEPS] += 1
        write(m, d, run, t_new, run.y)
        run.count[NEXT] += 1
        if not rows_hold(m, d, s, run):
            return CHOOSE_ROWS
    return RUNNING
