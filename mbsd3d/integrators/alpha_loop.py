"""The time loop of generalised alpha: steps within the tolerance, their outputs, what one step hands to the next."""

import numpy as np

from ..kernels.coordinates import remember
from ..kernels.dynamics import FAR, PROJECTED, arrive
from ..kernels.jit import inner_kernel, kernel, merged_kernel
from ..kernels.saddle import SOLVED
from ..kernels.vectors import copy
from .alpha_memory import FIRST, LAST, MADE
from .alpha_step import local_error, predict, solve_step
from .base import (
    CHOOSE_ROWS,
    DONE,
    FRESH,
    FULL,
    MIN_STEP,
    NO_SOLUTION,
    NOT_CLOSING,
    NOT_CONVERGED,
    REJECTED,
    RUNNING,
    STEP,
    STEPS,
    T_END,
    WRITTEN,
    T,
    rows_hold,
    start,
)
from .runge_kutta import end_of_step, outputs
from .scales import references

SAME_STEP = 1.3  # growth below which the step, and with it the matrix, is kept


@merged_kernel
def attempt(m, d, s, run, g, c):
    """(RUNNING, t_new, h) after a step within the tolerance, or why there is none; adapts the step."""
    rejected, fixed = False, g.table.steps > 0
    while True:
        t_new, h = end_of_step(g.table, run)
        if h < run.clock[MIN_STEP]:
            return NOT_CONVERGED, t_new, h
        error = np.inf
        predict(run, g, c, h, False)
        solved = solve_step(m, d, s, run, g, c, t_new, h)
        if not solved:
            predict(run, g, c, h, True)
            solved = solve_step(m, d, s, run, g, c, t_new, h)
        if solved:
            error = 0.0 if fixed else local_error(m, d, s, run, g, c, h)
        elif fixed:
            return NOT_CONVERGED, t_new, h
        factor = 0.25
        if np.isfinite(error):
            factor = min(3.0, max(0.2, 0.9 * max(error, 1e-9) ** (-1.0 / 3.0)))
        if error <= 1.0:
            factor = min(factor, 1.0) if rejected else factor
            run.clock[STEP] = h if 0.95 < factor < SAME_STEP else h * factor
            return RUNNING, t_new, h
        run.clock[STEP] = h * min(factor, 0.8)
        run.count[REJECTED] += 1
        rejected = True


@inner_kernel
def ends(m, run, g, h):
    """Rates at both ends that make the dense output: velocities and z quadratic with the slopes of a."""
    for k in range(7 * m.body.shape[0], run.y.shape[0]):
        slope = (run.trial[k] - run.y[k]) / h
        run.dy[k] = slope - 0.5 * h * g.jerk_new[k]
        run.K[1, k] = slope + 0.5 * h * g.jerk_new[k]
    copy(run.K[0], run.dy)


@merged_kernel
def keep(m, run, g, c, t_new, h):
    """The end of the step becomes the start of the next one."""
    n, w = m.body.shape[0], g.newton
    theta = g.weights.alpha_m - g.weights.alpha_f
    for k in range(7 * n, run.y.shape[0]):
        if g.flag[FIRST] == 1:
            g.shift[k] = theta * (w.rate[k] - g.rate[k]) / h
        else:
            g.shift[k] = (g.a[k] - w.rate[k]) / h
    copy(g.jerk, g.jerk_new)
    copy(g.rate, w.rate)
    copy(g.lam, w.lam)
    copy(run.y, run.trial)
    copy(run.dy, run.K[1])
    if g.flag[FIRST] == 1:
        g.flag[FIRST], g.flag[MADE] = 0, 0  # other weights from now on
    g.h[LAST] = h
    run.clock[T] = t_new
    run.count[STEPS] += 1


@merged_kernel
def step(m, d, s, g, run):
    """One accepted step with its outputs; RUNNING or a reason to come back to Python."""
    c = g.first if g.flag[FIRST] == 1 else g.weights
    status, t_new, h = attempt(m, d, s, run, g, c)
    if status != RUNNING:
        return status
    projected, solved = arrive(m, d, s, t_new, run.trial, run.K[1], FAR)
    if projected != PROJECTED:
        return NOT_CLOSING
    if solved != SOLVED:
        return NO_SOLUTION
    ends(m, run, g, h)
    status = outputs(m, d, s, g.table, run, t_new, h)
    if status != RUNNING:
        return status
    remember(m, d, t_new)
    references(m, d, run)
    keep(m, run, g, c, t_new, h)
    return RUNNING if rows_hold(m, d, s, run) else CHOOSE_ROWS


@merged_kernel
def begin(m, d, s, g, run):
    """Rates and multipliers of the start, or of a new choice of rows."""
    status = start(m, d, s, run)
    if status == RUNNING:
        references(m, d, run)
        copy(g.rate, run.dy)
        for k in range(g.shift.shape[0]):
            g.shift[k] = 0.0
        for k in range(m.row.shape[0]):
            g.lam[k] = d.row[k].lam
        g.flag[FIRST], g.flag[MADE] = 1, 0
    return status


@kernel
def integrate(m, d, s, g, run, budget):
    """Take up to `budget` steps; DONE, RUNNING when the budget is used up, or a reason to come back to Python."""
    if run.count[FRESH] == 1:
        status = begin(m, d, s, g, run)
        if status != RUNNING:
            return status
    for _ in range(budget):
        if run.clock[T] >= run.clock[T_END]:
            return DONE
        if run.count[WRITTEN] >= run.out.shape[0] - 2:
            return FULL
        status = step(m, d, s, g, run)
        if status != RUNNING:
            return status
    return RUNNING if run.clock[T] < run.clock[T_END] else DONE
