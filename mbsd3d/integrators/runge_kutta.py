"""Explicit Runge-Kutta methods with projection: a method is its table and its order; one time loop serves all."""

import numpy as np

from ..compiler.decorators import inner_kernel, kernel, late_kernel
from ..dynamics.contact_steps import may_hide_contact
from ..dynamics.spinning import farthest_turn, find_spins, limit_turn, rate_without_spin, restore_spin
from ..dynamics.state_rates import (
    FACTOR_FROM_OTHER_POSE,
    FACTOR_FROM_THIS_POSE,
    PROJECTED,
    evaluate,
    project_and_evaluate,
    rounding,
)
from ..dynamics.turning import compare_poses, turns_are_certain
from ..kernels.vectors import add_scaled, clear, copy, dot, finite, sub, vec
from ..solver.saddle_point import SOLVED
from .memory import NEW_TREE, NO_SOLUTION, NOT_CLOSING, RUNNING, STEP_TOO_SMALL, STIFF
from .outputs import evaluate_start, outputs
from .step_control import (
    LOCAL_ERROR_SHARE,
    end_of_step,
    go_on,
    good_enough,
    hermite,
    nearly_singular,
    note_rows,
    pass_over_singular,
    rows_hold,
    state_error,
    stuck,
    take_steps,
    way_to_singular,
)

STEP_ERROR_SHARE = 2.0 * LOCAL_ERROR_SHARE  # [1] of rtol: error that a step may have; most have a tenth of it
# [1] of the step that would have this error: the next step; few are then rejected
STEP_SAFETY_FACTOR = 0.75

# [1] gain of rounding near a singular pose, over the smallest pivot of a step; largest rtol for which it counts
PROJECTION_GAIN_MIN, PROJECTION_GAIN_RTOL_MAX = 0.3, 1e-8

# [1] of an acceleration: the most by which the last stage and the end of a step, both at the same time, may differ; and
# of the error that a step may have: a difference that counts
END_DIFFERENCE_MAX, END_DIFFERENCE_MIN = 0.5, 10.0

UNCOUNTED_TURN_MAX = 0.5  # [rad] two bodies turn in a step: below it no turn of a hinge between them is miscounted
NEGLIGIBLE_TURN_MAX = 0.02  # [rad] a body turns in a step: below it any method errs by less than 1e-11 rad
# [1] rtol up to which estimates of high order control the steps, and [steps] from one comparison to the next
CHECKED_RTOL_MAX, CHECK_INTERVAL_STEPS = 1e-5, 4

# [1] h |lambda| above which a component stays unseen only below some hundred tolerances; stability ends at 6.1
STIFFNESS_PRODUCT_MIN = 3.4
# [steps] from one test for stiffness to the next, and [tests] that stop a run or end a suspicion
STIFFNESS_TEST_INTERVAL_STEPS = 32
STIFF_TESTS_TO_STOP, NONSTIFF_TESTS_TO_RESET = 15, 6


@inner_kernel
def stages(m, d, s, own, run, h):
    """Evaluate stage rates K and the trial state; return False where a stage has no solution.

    Near a singular position (sigma -> 0 in J) an error eps of a stage state off c = 0 moves the acceleration by
    eps/sigma, and the step would shrink to nothing there. Stages are then projected first: eps becomes eps^2/sigma.
    Closer still, c = 0 met to rounding bends the motion onto another branch: `pass_over_singular`.
    """
    table, K, t = own.table, own.K, run.now.t
    copy(K[0], run.dy)
    rate_without_spin(m, run, 0.0, run.y, K[0])
    run.rows.least_pivot = run.rows.pivot
    for i in range(1, table.c.shape[0]):
        copy(run.work, run.y)
        for j in range(i):
            if table.A[i, j] != 0.0:
                add_scaled(run.work, h * table.A[i, j], K[j])
        restore_spin(m, run, table.c[i] * h, run.work)
        run.now.evaluations += 1
        if run.rows.on_manifold == 1:
            status, result = project_and_evaluate(m, d, s, t + table.c[i] * h, run.work, K[i], FACTOR_FROM_OTHER_POSE)
            if status != PROJECTED or result != SOLVED:
                return False
        elif evaluate(m, d, s, t + table.c[i] * h, run.work, K[i]) != SOLVED:
            return False
        rate_without_spin(m, run, table.c[i] * h, run.work, K[i])
        run.rows.least_pivot = min(run.rows.least_pivot, s.state.pivot)
    copy(run.work, own.carry)
    for j in range(table.b.shape[0]):
        add_scaled(run.work, h * table.b[j], K[j])
    for k in range(run.y.shape[0]):  # compensated sum: what rounding cuts off is added in the next step
        run.trial[k] = run.y[k] + run.work[k]
        own.trial_carry[k] = run.work[k] - (run.trial[k] - run.y[k])
    restore_spin(m, run, h, run.trial)
    restore_spin(m, run, h, own.trial_carry)
    return True


@inner_kernel
def body_error(m, own, run, weights, h):
    """Return `state_error` of the weighted sum of the stages, times h."""
    clear(run.work)
    for j in range(weights.shape[0]):
        if weights[j] != 0.0:
            add_scaled(run.work, h * weights[j], own.K[j])
    return state_error(m, run)


@inner_kernel
def error_norm(m, own, run, h):
    """Return the estimated local error over STEP_ERROR_SHARE rtol; for DOP853 two of order 5, corrected by order 3."""
    e5 = max(body_error(m, own, run, own.table.error[0], h), body_error(m, own, run, own.table.error[1], h))
    e3 = body_error(m, own, run, own.table.error[2], h)
    if e5 == 0.0 and e3 == 0.0:
        return 0.0
    if not np.isfinite(e5 + e3):
        return np.inf
    unknown = min(PROJECTION_GAIN_RTOL_MAX, PROJECTION_GAIN_MIN * rounding(m, run.y) / run.rows.least_pivot)
    return e5 / np.sqrt(e5 + 0.01 * e3) / max(STEP_ERROR_SHARE * run.task.rtol, unknown)


@inner_kernel
def dense(m, d, s, own, run, h):
    """Set coefficients F of the dense output: cubic Hermite through the projected ends, and the terms of the method."""
    table, K = own.table, own.K
    n = table.c.shape[0]
    copy(run.work, run.trial)
    restore_spin(m, run, -h, run.work)
    copy(K[n], run.trial_rate)
    rate_without_spin(m, run, h, run.trial, K[n])
    hermite(run, h, run.work, K[0], K[n])
    for i in range(table.c_dense.shape[0]):
        stage = n + 1 + i
        copy(run.work, run.y)
        for j in range(stage):
            if table.A_dense[i, j] != 0.0:
                add_scaled(run.work, h * table.A_dense[i, j], K[j])
        restore_spin(m, run, table.c_dense[i] * h, run.work)
        run.now.evaluations += 1
        if evaluate(m, d, s, run.now.t + table.c_dense[i] * h, run.work, K[stage]) != SOLVED:
            return False
        rate_without_spin(m, run, table.c_dense[i] * h, run.work, K[stage])
    for i in range(table.D.shape[0]):
        clear(run.F[3 + i])
        for j in range(table.D.shape[1]):
            if table.D[i, j] != 0.0:
                add_scaled(run.F[3 + i], h * table.D[i, j], K[j])
    return True


@inner_kernel
def advance_to(m, d, s, own, run, t, x, h):
    """Set the trial state at t by one step of length x, projected, with its rate."""
    if not stages(m, d, s, own, run, x):
        return NO_SOLUTION
    status, result = project_and_evaluate(m, d, s, t, run.trial, run.trial_rate, FACTOR_FROM_OTHER_POSE)
    run.now.evaluations += 1
    return RUNNING if status == PROJECTED and result == SOLVED and finite(run.trial_rate) else NO_SOLUTION


@inner_kernel
def step_factor(table, error, most):
    """Return the factor to the next step, within 0.2 ... most."""
    return most if error == 0.0 else min(most, max(0.2, STEP_SAFETY_FACTOR * error ** (-1.0 / table.order)))


@inner_kernel
def retry(run, step):
    """Reject the current step; the next try has another length."""
    run.now.step = step
    run.now.rejected += 1
    run.now.retried = 1


@inner_kernel
def starts_to_turn(m, run, h, most):
    """Return True if a body turns farther than ``most`` [rad] by its poses, or its angular velocity at the end.

    The greatest angular velocity so far says nothing of a fixed step in which the motion begins.
    """
    n = m.body.shape[0]
    for i in range(n):
        q, w = 7 * i + 3, vec(run.trial[7 * n + 6 * i + 3 : 7 * n + 6 * i + 6])
        cosine = 0.0  # of half the turn
        for j in range(4):
            cosine += run.y[q + j] * run.trial[q + j]
        if max(4.0 * (1.0 - cosine * cosine), h * h * dot(w, w)) > most * most:
            return True
    return False


@late_kernel
def misses_its_end(m, own, run, h) -> bool:
    """Return True if a body accelerates otherwise at the end of a step than in its last stage, which is at that time.

    The first stages count neither in the result nor in its error. Where they alone meet a contact, it throws the
    later ones past it, and all that counts is a flight to an end in the midst of the other body. Near a singular pose
    accelerations differ by the rounding of the stages: there it is not asked.
    """
    n, last = m.body.shape[0], own.K[own.table.c.shape[0] - 1]
    copy(run.work, run.trial_rate)
    rate_without_spin(m, run, h, run.trial, run.work)
    for i in range(n):
        for part in range(2):
            u = 7 * n + 6 * i + 3 * part
            start, stage, end = vec(own.K[0][u : u + 3]), vec(last[u : u + 3]), vec(run.work[u : u + 3])
            apart = sub(end, stage)
            largest = max(dot(start, start), dot(stage, stage), dot(end, end))
            allowed = END_DIFFERENCE_MIN * STEP_ERROR_SHARE * run.task.rtol * (run.now.turn if part else run.now.speed)
            if dot(apart, apart) > max(END_DIFFERENCE_MAX**2 * largest, (allowed / h) ** 2):
                return True
    return False


@inner_kernel
def attempt(m, d, s, own, run):
    """Return (RUNNING, t_new, h, error) after a step within the tolerance, projected, or why there is none."""
    fixed = run.task.steps > 0
    while True:
        run.rows.planned = 0.0
        if not fixed:
            limit_turn(m, run)
        if nearly_singular(run) and not fixed:
            pass_over_singular(run, own.table.gap, own.table.c[1])
        t_new, h = end_of_step(run)
        if h == 0.0 or stuck(run, h):
            return STEP_TOO_SMALL, t_new, h, 0.0
        if not fixed:
            find_spins(m, run, h)
        solved = stages(m, d, s, own, run, h)
        error = error_norm(m, own, run, h) if solved and not fixed else 0.0
        judged = solved and np.isfinite(error)
        if not (judged and good_enough(run, h, error)):
            if fixed:
                return NO_SOLUTION, t_new, h, error
            if nearly_singular(run) and run.rows.on_manifold == 0:
                run.rows.on_manifold = 1
                retry(run, h)  # the error was that of stages off c = 0
            else:
                retry(run, h * step_factor(own.table, error, 10.0) if judged else 0.2 * h)
            continue
        status, result = project_and_evaluate(
            m, d, s, t_new, run.trial, run.trial_rate, FACTOR_FROM_THIS_POSE - run.rows.on_manifold
        )
        run.now.evaluations += 1
        if status == PROJECTED and result == SOLVED and finite(run.trial_rate) and finite(run.trial):
            if not fixed and not nearly_singular(run) and misses_its_end(m, own, run, h):
                retry(run, 0.2 * h)
                continue
            few = h * run.now.fastest < UNCOUNTED_TURN_MAX * m.length and not (
                fixed and starts_to_turn(m, run, h, UNCOUNTED_TURN_MAX)
            )
            if (few or turns_are_certain(m, d, run, t_new, h)) and not may_hide_contact(m, d, run, h, False):
                return RUNNING, t_new, h, error
            continue
        if fixed:
            return NOT_CLOSING if status != PROJECTED else NO_SOLUTION, t_new, h, error
        retry(run, 0.2 * h)


@inner_kernel
def accept(own, run, h, error):
    """Make the end of the step the start of the next one, whose length follows from the error."""
    copy(own.carry, own.trial_carry)
    copy(run.y, run.trial)
    copy(run.dy, run.trial_rate)
    if run.task.steps == 0:
        factor = step_factor(own.table, error, 1.0 if run.now.retried == 1 else 10.0)
        if nearly_singular(run):  # nearer to it rounding counts for more, and a shorter step would have no less of it
            factor = max(factor, 1.0)
        run.now.step = max(h * factor, run.rows.planned)
    run.now.retried = 0
    if not nearly_singular(run):
        run.rows.missed = 0.0


@inner_kernel
def fastest_rate(m, own, run, h):
    """Return h |lambda| from the last stage Y and the end y of the step, both at t + h: h |f(y) - f(Y)| / |y - Y|."""
    table, n = own.table, own.table.c.shape[0]
    clear(run.work)
    for j in range(n):
        add_scaled(run.work, h * (table.b[j] - table.A[n - 1, j]), own.K[j])
    apart = state_error(m, run)
    copy(run.work, run.dy)
    rate_without_spin(m, run, h, run.y, run.work)
    add_scaled(run.work, -1.0, own.K[n - 1])
    return h * np.sqrt(state_error(m, run) / apart) if apart > 0.0 else 0.0


@late_kernel
def is_stiff(m, own, run, h) -> bool:
    """Return True where stability limits the steps time and again, and the rest of the run would take too long."""
    found = run.stiffness
    if found.suspicious == 0 and run.now.steps % STIFFNESS_TEST_INTERVAL_STEPS > 0:
        return False
    if fastest_rate(m, own, run, h) > STIFFNESS_PRODUCT_MIN + 2.0 * farthest_turn(
        run, h
    ):  # nutation is no faster than twice a spin
        found.suspicious += 1
        found.calm = 0
    else:
        found.calm += 1
        if found.calm == NONSTIFF_TESTS_TO_RESET:
            found.suspicious = 0
            found.calm = 0
    left = (run.task.t_end - run.now.t) / max(h, run.now.step) * m.body.shape[0]  # one short step alone says little
    return found.suspicious >= STIFF_TESTS_TO_STOP and left > found.patience


@inner_kernel
def verdict(m, d, s, own, run, h):
    """Return RUNNING, or what Python must look at after a step: the tree of the rows, or stiffness."""
    if not rows_hold(m, d, s, run):
        return NEW_TREE
    if run.task.steps == 0 and run.stiffness.patience < np.inf and is_stiff(m, own, run, h):
        return STIFF
    return RUNNING


@inner_kernel
def is_compared(m, run, h):
    """Return True for a step whose poses are compared with angular velocities."""
    if h * run.now.turn <= NEGLIGIBLE_TURN_MAX:
        return run.task.steps > 0 and starts_to_turn(m, run, h, NEGLIGIBLE_TURN_MAX)
    return run.task.steps > 0 or run.task.rtol > CHECKED_RTOL_MAX or run.now.steps % CHECK_INTERVAL_STEPS == 0


@inner_kernel
def step(m, d, s, own, run):
    """Take one accepted step with its outputs; return RUNNING or a reason to return to Python."""
    status, t_new, h, error = attempt(m, d, s, own, run)
    if status != RUNNING:
        return status
    before = run.rows.pivot
    note_rows(s, run)
    run.rows.ahead = way_to_singular(before, run.rows.pivot, h)
    status = outputs(m, d, s, own, run, t_new, h, dense, advance_to)
    if status != RUNNING:
        return status
    if is_compared(m, run, h):
        compare_poses(m, run, h)
    accept(own, run, h, error)
    go_on(m, d, s, run, t_new)
    return verdict(m, d, s, own, run, h)


@inner_kernel
def start(m, d, s, own, run):
    """Set the rate of the start."""
    return evaluate_start(m, d, s, run)


@kernel
def advance(m, d, s, own, run, budget):
    """Integrate as `take_steps` does."""
    return take_steps(m, d, s, own, run, budget, start, step)
