"""Explicit Runge-Kutta with projection: a method is its table plus its order; one time loop serves all of them."""

from typing import NamedTuple

import numpy as np

from ..kernels.coordinates import remember
from ..kernels.dynamics import FAR, NEAR, PROJECTED, arrive, evaluate
from ..kernels.jit import inner_kernel, kernel, merged_kernel
from ..kernels.saddle import SOLVED
from ..kernels.vectors import add_scaled, clear, copy, finite
from .base import (
    CHOOSE_ROWS,
    CONDITION,
    DONE,
    EVALUATIONS,
    EVERY,
    FRESH,
    FULL,
    MAX_STEP,
    MIN_STEP,
    NEXT,
    NO_SOLUTION,
    NORMAL_STEP,
    NOT_CLOSING,
    ON_MANIFOLD,
    PASSED,
    REJECTED,
    RETRIED,
    RTOL,
    RUNNING,
    STEP,
    STEP_TOO_SMALL,
    STEPS,
    STIFF,
    T_END,
    T_START,
    WRITTEN,
    T,
    hermite,
    interpolate,
    nearly_singular,
    rows_hold,
    sample,
    start,
    write,
)
from .events import LANDINGS, first_crossing, halt, may_come_true, missing_time
from .scales import LOCAL, references, state_error
from .stiff import is_stiff

PASSAGE_TOLERANCE = 1e-10  # near a singular position, where rounding is amplified and less cannot be had
SHORTEST_PASSAGE = 0.05  # of a normal step: shorter ones would resolve rounding near a singular position


class Table(NamedTuple):
    """Butcher table of an explicit method with n stages; the rate at the end of the step is stage n + 1."""

    A: np.ndarray  # (n, n)
    b: np.ndarray  # (n,)
    c: np.ndarray  # (n,)
    error: np.ndarray  # (2, n) weights of two error estimates, empty for fixed steps
    A_dense: np.ndarray  # (extra, n + 1 + extra) extra stages of the dense output
    c_dense: np.ndarray  # (extra,)
    D: np.ndarray  # (terms, n + 1 + extra) beyond the cubic Hermite terms
    order: int
    steps: int  # number of equal steps, 0 = adaptive
    patience: float  # steps times bodies that a run may still need where stability limits its step; inf = any number


@inner_kernel
def stages(m, d, s, table, run, h):
    """Stage rates K and the trial state; False where a stage has no solution.

    Near a singular position (sigma -> 0 in J) an error eps of a stage state off c = 0 moves the acceleration by
    eps/sigma, and the step would shrink to nothing there. Stages are then projected first: eps becomes eps^2/sigma.
    Closer still, c = 0 met to rounding bends the motion onto another branch within 1e-8 of the singular position; a
    step that spans it does not see that, so steps do not go below SHORTEST_PASSAGE there.
    """
    copy(run.K[0], run.dy)
    t = run.clock[T]
    for i in range(1, table.c.shape[0]):
        copy(run.work, run.y)
        for j in range(i):
            if table.A[i, j] != 0.0:
                add_scaled(run.work, h * table.A[i, j], run.K[j])
        run.count[EVALUATIONS] += 1
        if run.count[ON_MANIFOLD] == 1:
            status, result = arrive(m, d, s, t + table.c[i] * h, run.work, run.K[i], FAR)
            if status != PROJECTED or result != SOLVED:
                return False
        elif evaluate(m, d, s, t + table.c[i] * h, run.work, run.K[i]) != SOLVED:
            return False
    copy(run.work, run.carry)
    for j in range(table.b.shape[0]):
        add_scaled(run.work, h * table.b[j], run.K[j])
    for k in range(run.y.shape[0]):  # compensated sum: what rounding cuts off is added in the next step
        run.trial[k] = run.y[k] + run.work[k]
        run.trial_carry[k] = run.work[k] - (run.trial[k] - run.y[k])
    return True


@inner_kernel
def body_error(m, run, weights, h):
    """`state_error` of the weighted sum of the stages, times h."""
    clear(run.work)
    for j in range(weights.shape[0]):
        if weights[j] != 0.0:
            add_scaled(run.work, h * weights[j], run.K[j])
    return state_error(m, run)


@merged_kernel
def error_norm(m, table, run, h):
    """Estimated local error in units of LOCAL rtol (DOP853: fifth-order estimate corrected by the third-order one)."""
    e5 = body_error(m, run, table.error[0], h)
    e3 = body_error(m, run, table.error[1], h)
    if e5 == 0.0 and e3 == 0.0:
        return 0.0
    if not np.isfinite(e5 + e3):
        return np.inf
    tolerance = LOCAL * run.clock[RTOL]
    if run.count[ON_MANIFOLD] == 1:
        tolerance = max(tolerance, PASSAGE_TOLERANCE)
    return e5 / np.sqrt(e5 + 0.01 * e3) / tolerance


@merged_kernel
def dense(m, d, s, table, run, h):
    """Coefficients F of the dense output: cubic Hermite through the projected ends, plus the method's own terms."""
    n = table.c.shape[0]
    hermite(run, h, run.K[n])
    for i in range(table.c_dense.shape[0]):
        stage = n + 1 + i
        copy(run.work, run.y)
        for j in range(stage):
            if table.A_dense[i, j] != 0.0:
                add_scaled(run.work, h * table.A_dense[i, j], run.K[j])
        run.count[EVALUATIONS] += 1
        if evaluate(m, d, s, run.clock[T] + table.c_dense[i] * h, run.work, run.K[stage]) != SOLVED:
            return False
    for i in range(table.D.shape[0]):
        clear(run.F[3 + i])
        for j in range(table.D.shape[1]):
            if table.D[i, j] != 0.0:
                add_scaled(run.F[3 + i], h * table.D[i, j], run.K[j])
    return True


@merged_kernel
def land(m, d, s, table, run, h, x):
    """Time at which the condition comes true, with the state there in trial: steps of length x from the start.

    As exact as the method, where dense output of lower order would be less; NaN if such a step has no solution.
    A method without stages (weights b zero) has its dense output only.
    """
    n, t = table.c.shape[0], run.clock[T]
    for left in range(LANDINGS, 0, -1):
        if np.sum(table.b) == 0.0:
            interpolate(run, x / h, run.trial)
        elif not stages(m, d, s, table, run, x):
            return np.nan
        status, result = arrive(m, d, s, t + x, run.trial, run.K[n], FAR)
        run.count[EVALUATIONS] += 1
        if status != PROJECTED or result != SOLVED or not finite(run.K[n]):
            return np.nan
        dt = missing_time(m, d, run, h, t + x, run.K[n])
        if left == 1 or abs(dt) <= 1e-16 * h:
            break
        x = min(max(x + dt, 0.0), h)
    return t + x


@merged_kernel
def outputs(m, d, s, table, run, t_new, h):
    """Store the samples that fall into the accepted step; RUNNING, STOPPED, FULL or NO_SOLUTION."""
    t_last, stopped, watched = t_new, False, run.count[CONDITION] >= 0
    inside = run.count[NEXT] < run.times.shape[0] and run.times[run.count[NEXT]] < t_new
    suspect = watched and may_come_true(m, d, run, h, t_new, run.K[table.c.shape[0]])
    if inside or suspect:
        if not dense(m, d, s, table, run, h):
            return NO_SOLUTION
        x = first_crossing(m, d, run, h, t_new) if suspect else -1.0
        stopped = x >= 0.0
        if stopped:
            t_last = land(m, d, s, table, run, h, x * h)
        t_old = run.clock[T]
        while run.count[NEXT] < run.times.shape[0] and run.times[run.count[NEXT]] < t_last:
            if run.count[WRITTEN] == run.out.shape[0] - 2:
                return FULL
            if not sample(m, d, s, run, t_old, h, run.times[run.count[NEXT]]):
                return NO_SOLUTION
            run.count[NEXT] += 1
    if stopped:
        return halt(m, d, s, run, t_last) if np.isfinite(t_last) else NO_SOLUTION
    if inside or watched:
        evaluate(m, d, s, t_new, run.trial, run.work_rate)  # the work space belongs to the end of the step again
    wanted = run.count[NEXT] < run.times.shape[0] and run.times[run.count[NEXT]] <= t_new
    if wanted or run.count[EVERY] == 1:
        write(m, d, run, t_new, run.trial)
        run.count[NEXT] += 1
    return RUNNING


@inner_kernel
def end_of_step(table, run):
    """(t_new, h): the next step, landing exactly on t_end."""
    t, t_end = run.clock[T], run.clock[T_END]
    if table.steps > 0:
        k = run.count[STEPS] + 1
        t_new = t_end if k == table.steps else run.clock[T_START] + k * (t_end - run.clock[T_START]) / table.steps
        return t_new, t_new - t
    h = min(run.clock[STEP], run.clock[MAX_STEP])
    t_new = t_end if t + 1.01 * h >= t_end else t + h
    return t_new, t_new - t


@merged_kernel
def step(m, d, s, table, run):
    """One accepted step with its outputs; RUNNING or a reason to come back to Python."""
    n = table.c.shape[0]
    while True:
        t_new, h = end_of_step(table, run)
        if h < run.clock[MIN_STEP]:
            return STEP_TOO_SMALL
        solved = stages(m, d, s, table, run, h)
        error = 0.0
        if solved and table.steps == 0:
            error = error_norm(m, table, run, h)
        floor = SHORTEST_PASSAGE * run.clock[NORMAL_STEP] if run.count[ON_MANIFOLD] == 1 else 0.0
        passed = solved and error > 1.0 and h <= floor and np.isfinite(error)
        if not solved or not (error <= 1.0 or passed):
            if table.steps > 0:
                return NO_SOLUTION
            judged = solved and np.isfinite(error)
            factor = max(0.2, 0.9 * error ** (-1.0 / table.order)) if judged else 0.2
            run.clock[STEP] = max(h * factor, 0.999 * floor) if judged else h * factor
            run.count[REJECTED] += 1
            run.count[RETRIED] = 1
            if nearly_singular(run):
                run.count[ON_MANIFOLD] = 1
            continue
        status, result = arrive(m, d, s, t_new, run.trial, run.K[n], NEAR - run.count[ON_MANIFOLD])
        run.count[EVALUATIONS] += 1
        if status == PROJECTED and result == SOLVED and finite(run.K[n]) and finite(run.trial):
            break
        if table.steps > 0:
            return NOT_CLOSING if status != PROJECTED else NO_SOLUTION
        run.clock[STEP] = 0.2 * h
        run.count[REJECTED] += 1
        run.count[RETRIED] = 1
    status = outputs(m, d, s, table, run, t_new, h)
    if status != RUNNING:
        return status
    remember(m, d, t_new)
    references(m, d, run)
    copy(run.carry, run.trial_carry)
    copy(run.y, run.trial)
    copy(run.dy, run.K[n])
    run.clock[T] = t_new
    run.count[STEPS] += 1
    if table.steps == 0:
        factor = 10.0 if error == 0.0 else min(10.0, max(0.2, 0.9 * error ** (-1.0 / table.order)))
        run.clock[STEP] = h * (min(1.0, factor) if run.count[RETRIED] == 1 else factor)
    run.count[RETRIED] = 0
    was_near = run.count[ON_MANIFOLD] == 1
    if not rows_hold(m, d, s, run):
        return CHOOSE_ROWS
    if not nearly_singular(run):
        run.clock[NORMAL_STEP] = h
    if table.steps == 0 and table.patience < np.inf and is_stiff(m, table, run, h):
        return STIFF
    return PASSED if was_near and run.count[ON_MANIFOLD] == 0 else RUNNING


@kernel
def advance(m, d, s, table, run, budget):
    """Take up to `budget` steps; DONE, RUNNING when the budget is used up, or a reason to come back to Python."""
    if run.count[FRESH] == 1:
        status = start(m, d, s, run)
        if status != RUNNING:
            return status
        references(m, d, run)
    for _ in range(budget):
        if run.clock[T] >= run.clock[T_END]:
            return DONE
        if run.count[WRITTEN] >= run.out.shape[0] - 2:
            return FULL
        status = step(m, d, s, table, run)
        if status != RUNNING:
            return status
    return RUNNING if run.clock[T] < run.clock[T_END] else DONE
