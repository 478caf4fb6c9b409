"""Fully driven systems: at every sample the pose by assembly, velocity and acceleration by linear solves."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..kernels.coordinates import remember
from ..kernels.dynamics import FAR, PROJECTED, arrive, evaluate
from ..kernels.jit import inner_kernel, kernel, merged_kernel
from ..kernels.saddle import SOLVED
from ..kernels.vectors import add_scaled, copy, finite
from .base import (
    CHOOSE_ROWS,
    CONDITION,
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
    hermite,
    rows_hold,
    start,
    write,
)
from .events import LANDINGS, first_crossing, halt, may_come_true, missing_time
from .scales import references

TURN_PER_POSE = 0.3  # rad between poses: Newton stays on its branch


@dataclass(frozen=True)
class Kinematic:
    """No ODE: for systems whose drivers determine the whole motion (rank of the rows = 6 per body).

    Work, impulse and own states of forces are integrated over the poses by the trapezoidal rule, of order 2: more
    samples or a smaller ``max_step`` make them as exact as needed. All else does not depend on the distance of poses.
    ``max_step`` [s] bounds the distance between poses, so that Newton stays on its branch. A condition to stop is
    watched between the poses too, on cubics through them.

    Examples
    --------
    >>> from mbsd3d import GROUND, AngleDriver, Body, Kinematic, Ramp, Revolute, System, simulate
    >>> arm = Body("arm", mass=2.0, inertia=(0.1, 0.1, 0.1), position=(0.5, 0, 0))
    >>> hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")
    >>> motor = AngleDriver(hinge, Ramp(3.0))
    >>> turn = simulate(System([arm], [hinge, motor]), 0.7, method=Kinematic(), output=8)
    >>> round(float(turn.angle(hinge)[-1]), 9), round(float(turn.acceleration(arm)[0, 0]), 9)  # w t, -l w^2
    (2.1, -4.5)
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


@merged_kernel
def correct(m, run, h):
    """Work and own states of the trial, predicted by the rate at the last pose, by the mean of both rates."""
    for i in range(13 * m.body.shape[0], run.trial.shape[0]):
        run.trial[i] += 0.5 * h * (run.work_rate[i] - run.dy[i])


@merged_kernel
def event(m, d, run, h, t_new):
    """Time from the last pose to where the condition comes true before the next one, -1 if it does not."""
    if not may_come_true(m, d, run, h, t_new, run.work_rate):
        return -1.0
    hermite(run, h, run.work_rate)
    return h * first_crossing(m, d, run, h, t_new)


@inner_kernel
def land(m, d, s, run, h, x):
    """End the run where the condition comes true, x after the last pose: Newton on the time, a pose each."""
    t = run.clock[T]
    for left in range(LANDINGS, 0, -1):
        predict(m, run, x)
        status, result = arrive(m, d, s, t + x, run.trial, run.work_rate, FAR)
        run.count[EVALUATIONS] += 1
        if status != PROJECTED:
            return NOT_CLOSING
        if result != SOLVED or not finite(run.work_rate):
            return NO_SOLUTION
        correct(m, run, x)
        dt = missing_time(m, d, run, h, t + x, run.work_rate)
        if left == 1 or abs(dt) <= 1e-16 * h:
            break
        x = min(max(x + dt, 0.0), h)
    return halt(m, d, s, run, t + x)


@merged_kernel
def expected_turn(m, run, h):
    """Largest angle a body may turn within h: by the greatest angular velocity so far and the present acceleration."""
    n, alpha = m.body.shape[0], 0.0
    for i in range(n):
        for j in range(3):
            alpha = max(alpha, abs(run.dy[7 * n + 6 * i + 3 + j]))
    return h * run.clock[TURN] + 0.5 * h * h * alpha


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
        pieces = max(1, int(np.ceil(max(expected_turn(m, run, h) / TURN_PER_POSE, h / run.clock[MAX_STEP]))))
        for piece in range(pieces):
            t = t_new if piece == pieces - 1 else run.clock[T] + h / pieces
            predict(m, run, t - run.clock[T])
            status, result = arrive(m, d, s, t, run.trial, run.work_rate, FAR)
            run.count[EVALUATIONS] += 1
            if status != PROJECTED:
                return NOT_CLOSING
            if result != SOLVED or not finite(run.work_rate):
                return NO_SOLUTION
            correct(m, run, t - run.clock[T])
            if run.count[CONDITION] >= 0:
                x = event(m, d, run, t - run.clock[T], t)
                if x >= 0.0:
                    return land(m, d, s, run, t - run.clock[T], x)
                evaluate(m, d, s, t, run.trial, run.work_rate)  # the work space belongs to the pose again
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
