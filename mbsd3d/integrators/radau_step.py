"""Time loop of Radau IIA: stages by Newton's method, the error of a step, its length."""

import numpy as np

from ..compiler.decorators import inner_kernel, kernel
from ..dynamics.contact_steps import may_hide_contact
from ..dynamics.spinning import find_turns
from ..dynamics.state_rates import FACTOR_FROM_OTHER_POSE, PROJECTED, evaluate, project_and_evaluate, rounding
from ..dynamics.turning import compare_poses, turns_are_certain
from ..kernels.kinds import PROJECTION
from ..kernels.vectors import copy, finite
from ..solver.saddle_point import SOLVED
from .memory import NEW_TREE, NO_SOLUTION, NOT_CLOSING, NOT_CONVERGED, RUNNING, STEP_TOO_SMALL
from .newton import lu_factor, lu_solve
from .outputs import along_cubic, cubic, evaluate_start, outputs
from .step_control import (
    LOCAL_ERROR_SHARE,
    end_of_step,
    go_on,
    good_enough,
    note_rows,
    rows_hold,
    state_error,
    take_steps,
)

ITERATIONS = 10  # [iterations] of Newton's method in one attempt
NEWTON_RESIDUAL_SHARE = 0.1  # [1] of the local error allowed: what Newton's method may leave
JACOBIAN_REUSE_CONTRACTION = 0.1  # [1] contraction up to which the Jacobian is kept for the next step
STEP_GROWTH_MIN = 1.2  # [1] growth below which the step is kept, and with it the factors
DIFFERENCE_SHARE = 1.5e-8  # [1] of the unit of a coordinate: step of the differences for the Jacobian, root of rounding


@inner_kernel
def tolerance(run):
    """Return the error allowed by the estimate of order 3, for a step of order 5 within LOCAL_ERROR_SHARE rtol."""
    return LOCAL_ERROR_SHARE * run.task.rtol ** (2.0 / 3.0)


@inner_kernel
def unit(m, run, k):
    """Return the size of coordinate k of y against which its errors count."""
    n = m.body.shape[0]
    if k < 7 * n:
        return m.length if k % 7 < 3 else 1.0
    if k < 13 * n:
        return run.now.speed if (k - 7 * n) % 6 < 3 else run.now.turn
    return max(run.unit[k - 13 * n], abs(run.y[k]))


@inner_kernel
def state_rate(m, d, s, t, y, dy):
    """Evaluate dy at (t, y); return False where it has no solution. Rows that repeat others are evaluated on c = 0.

    There alone they agree: at a distance e from it the accelerations that they ask for would differ by O(1) / e, and
    no matrix would do. Projected, y changes; the rate on c = 0 is the same function, and smooth.
    """
    if m.stabilisation == PROJECTION and s.state.rank < s.loop.shape[0]:
        projected, solved = project_and_evaluate(m, d, s, t, y, dy, FACTOR_FROM_OTHER_POSE)
        return projected == PROJECTED and solved == SOLVED
    return evaluate(m, d, s, t, y, dy) == SOLVED


@inner_kernel
def differentiate(m, d, s, run, g):
    """Compute J = df/dy at the start of the step by forward differences, accurate enough for Newton's method."""
    N = g.J.shape[0]
    for j in range(N):
        copy(run.work, run.y)
        run.work[j] += DIFFERENCE_SHARE * unit(m, run, j)
        step = run.work[j] - run.y[j]
        run.now.evaluations += 1
        if not state_rate(m, d, s, run.now.t, run.work, run.work_rate):
            return False
        for i in range(N):
            g.J[i, j] = (run.work_rate[i] - run.dy[i]) / step
    g.past.jacobian, g.past.factored = 1, 0.0
    return True


@inner_kernel
def factor_systems(g, h):
    """Factorise real/h - J and pair/h - J."""
    N = g.J.shape[0]
    for i in range(N):
        for j in range(N):
            g.R[i, j] = -g.J[i, j]
            g.P[i, j] = -g.J[i, j]
        g.R[i, i] += g.real / h
        g.P[i, i] += g.pair / h
    g.past.factored = h
    return lu_factor(g.R, g.exchange_real, N) and lu_factor(g.P, g.exchange_pair, N)


@inner_kernel
def first_guess(g, h):
    """Extrapolate Z by the polynomial of the last step, and set W = T^-1 Z."""
    N, ratio = g.J.shape[0], h / g.past.step if g.past.step > 0.0 else 0.0
    for k in range(N):
        a, b, c = g.old[0, k], g.old[1, k], g.old[2, k]
        for i in range(3):
            x = 1.0 + ratio * g.c[i]
            g.Z[i, k] = a * (x - 1.0) + b * (x * x - 1.0) + c * (x * x * x - 1.0) if ratio > 0.0 else 0.0
        for i in range(3):
            g.W[i, k] = g.inverse[i, 0] * g.Z[0, k] + g.inverse[i, 1] * g.Z[1, k] + g.inverse[i, 2] * g.Z[2, k]


@inner_kernel
def stage_rates(m, d, s, run, g, h):
    """Evaluate K_i = f(t + c_i h, y + Z_i); return False where a stage has no solution."""
    for i in range(3):
        copy(run.work, run.y)
        for k in range(g.J.shape[0]):
            run.work[k] += g.Z[i, k]
        run.now.evaluations += 1
        if not state_rate(m, d, s, run.now.t + g.c[i] * h, run.work, g.K[i]):
            return False
    return True


@inner_kernel
def correct(m, run, g, h):
    """Take one Newton correction of W and Z; return its size in the units of errors."""
    N = g.J.shape[0]
    for k in range(N):
        a, b, c = g.K[0, k], g.K[1, k], g.K[2, k]
        inverse = g.inverse
        g.x[k] = inverse[0, 0] * a + inverse[0, 1] * b + inverse[0, 2] * c - g.real / h * g.W[0, k]
        re = inverse[1, 0] * a + inverse[1, 1] * b + inverse[1, 2] * c
        im = inverse[2, 0] * a + inverse[2, 1] * b + inverse[2, 2] * c
        g.x_pair[k] = re + 1j * im - g.pair / h * (g.W[1, k] + 1j * g.W[2, k])
    lu_solve(g.R, g.exchange_real, g.x, N)
    lu_solve(g.P, g.exchange_pair, g.x_pair, N)
    largest = 0.0
    for k in range(N):
        g.W[0, k] += g.x[k]
        g.W[1, k] += g.x_pair[k].real
        g.W[2, k] += g.x_pair[k].imag
    for k in range(N, run.work.shape[0]):
        run.work[k] = 0.0
    for i in range(3):
        for k in range(N):
            run.work[k] = g.T[i, 0] * g.x[k] + g.T[i, 1] * g.x_pair[k].real + g.T[i, 2] * g.x_pair[k].imag
            g.Z[i, k] += run.work[k]
        largest = max(largest, np.sqrt(state_error(m, run)))
    return largest


@inner_kernel
def collocate(m, d, s, run, g, h):
    """Return (True, iterations) when the stages of a step are found."""
    fixed = run.task.steps > 0  # dt alone sets the error, and what is left adds up
    enough = NEWTON_RESIDUAL_SHARE * LOCAL_ERROR_SHARE * (min(run.task.rtol, 1e-8) if fixed else run.task.rtol)
    allowed = enough / run.task.steps if fixed else enough
    least = 20.0 * rounding(m, run.y)
    eta, before = 1.0, 0.0  # the contraction of an earlier step says nothing of what a first correction leaves
    for k in range(ITERATIONS):
        if not stage_rates(m, d, s, run, g, h):
            return False, k
        moved = correct(m, run, g, h)
        if not np.isfinite(moved):
            return False, k
        if k > 0:
            contraction = moved / before if before > 0.0 else 0.0
            g.past.contraction = contraction
            if contraction >= 1.0 and not (fixed and moved > least):
                return moved <= least, k + 1
            eta = contraction / (1.0 - contraction) if contraction < 1.0 else 1.0
            # it will not get there; of fixed steps none is shorter, and positions follow a turn one iteration later
            if not fixed and moved * contraction ** (ITERATIONS - 1 - k) * eta > max(enough, least):
                return False, k
        if eta * moved <= allowed or (k > 0 and eta * moved <= least) or moved == 0.0:
            return True, k + 1
        before = moved
    return eta * before <= enough, ITERATIONS


@inner_kernel
def stages(m, d, s, run, g, h):
    """Solve as `collocate` with the current matrix, else with a new one."""
    if g.past.jacobian == -1 and not differentiate(m, d, s, run, g):
        return False, 0
    for _ in range(2):
        if abs(g.past.factored - h) > 1e-10 * h and not factor_systems(g, h):
            return False, 0
        first_guess(g, h)
        found, iterations = collocate(m, d, s, run, g, h)
        if found or g.past.jacobian == 1:
            break
        g.past.contraction = 1.0
        if not differentiate(m, d, s, run, g):
            return False, iterations
    return found, iterations


@inner_kernel
def end_of_stages(m, d, s, run, g, h):
    """Set the trial state y + Z_3, and the audit states by the same quadrature, of rates after the last correction.

    False where a stage has no solution.
    """
    N = g.J.shape[0]
    if not stage_rates(m, d, s, run, g, h):
        return False
    for k in range(run.y.shape[0]):
        if k >= N:
            for i in range(3):
                g.Z[i, k] = h * (g.A[i, 0] * g.K[0, k] + g.A[i, 1] * g.K[1, k] + g.A[i, 2] * g.K[2, k])
        run.trial[k] = run.y[k] + g.Z[2, k]
    return True


@inner_kernel
def estimate(m, run, g, h, rate):
    """Return the error over its tolerance, (real/h - J)^-1 (rate + sum_i e_i Z_i / h), which damps stiffness."""
    N, e = g.J.shape[0], run.work
    for k in range(e.shape[0]):
        e[k] = rate[k] + (g.error[0] * g.Z[0, k] + g.error[1] * g.Z[1, k] + g.error[2] * g.Z[2, k]) / h
        if k >= N:
            e[k] *= h / g.real
    for k in range(N):
        g.x[k] = e[k]
    lu_solve(g.R, g.exchange_real, g.x, N)
    for k in range(N):
        e[k] = g.x[k]
    return np.sqrt(state_error(m, run)) / tolerance(run)


@inner_kernel
def local_error(m, d, s, run, g, h, careful):
    """Return the estimate; where it rejects and ``careful``, again with the rate at y + error, for stiff errors."""
    error = estimate(m, run, g, h, run.dy)
    if careful and error > 1.0:
        for k in range(run.y.shape[0]):
            run.work[k] += run.y[k]
        run.now.evaluations += 1
        if not state_rate(m, d, s, run.now.t, run.work, run.work_rate):
            return np.inf
        error = estimate(m, run, g, h, run.work_rate)
    return error


@inner_kernel
def attempt(m, d, s, run, g):
    """Return (RUNNING, t_new, h) after a step within the tolerance, or the reason for rejecting it; adapt the step."""
    rejected, fixed = False, run.task.steps > 0
    while True:
        t_new, h = end_of_step(run)
        if h == 0.0:
            return STEP_TOO_SMALL, t_new, h
        solved, iterations = stages(m, d, s, run, g, h)
        if not solved or not end_of_stages(m, d, s, run, g, h):
            if fixed:
                return NOT_CONVERGED, t_new, h
            run.now.step, rejected = 0.5 * h, True
            run.now.rejected += 1
            continue
        error = 0.0 if fixed else local_error(m, d, s, run, g, h, rejected or g.past.step == 0.0)
        safety = 0.9 * (2.0 * ITERATIONS + 1.0) / (2.0 * ITERATIONS + iterations)
        factor = min(8.0, max(0.2, safety * max(error, 1e-12) ** -0.25)) if np.isfinite(error) else 0.2
        if good_enough(run, h, error):
            factor = min(factor, 1.0) if rejected else factor
            run.now.step = h if 0.99 < factor < STEP_GROWTH_MIN else h * factor
            return RUNNING, t_new, h
        run.now.step, rejected = h * min(factor, 0.9), True
        run.now.rejected += 1


@inner_kernel
def accept(run, g, h):
    """Make the end of the step the start of the next one."""
    for k in range(g.J.shape[0]):
        for i in range(3):
            g.old[i, k] = g.spread[i, 0] * g.Z[0, k] + g.spread[i, 1] * g.Z[1, k] + g.spread[i, 2] * g.Z[2, k]
    copy(run.y, run.trial)
    copy(run.dy, run.trial_rate)
    g.past.step = h
    g.past.jacobian = 0 if g.past.contraction < JACOBIAN_REUSE_CONTRACTION else -1


@inner_kernel
def step(m, d, s, g, run):
    """Take one accepted step with its outputs; return RUNNING or a reason to return to Python."""
    status, t_new, h = attempt(m, d, s, run, g)
    if status != RUNNING:
        return status
    projected, solved = project_and_evaluate(m, d, s, t_new, run.trial, run.trial_rate, FACTOR_FROM_OTHER_POSE)
    if projected != PROJECTED:
        return NOT_CLOSING
    if solved != SOLVED or not finite(run.trial_rate):
        return NO_SOLUTION
    if not turns_are_certain(m, d, run, t_new, h) or may_hide_contact(m, d, run, h, True):
        return RUNNING
    note_rows(s, run)
    find_turns(m, run, h)
    status = outputs(m, d, s, g, run, t_new, h, cubic, along_cubic)
    if status != RUNNING:
        return status
    compare_poses(m, run, h)
    accept(run, g, h)
    go_on(m, d, s, run, t_new)
    return RUNNING if rows_hold(m, d, s, run) else NEW_TREE


@inner_kernel
def restart(m, d, s, g, run):
    """Set the rate of the start, without a matrix and without a step before."""
    status = evaluate_start(m, d, s, run)
    g.past.jacobian, g.past.step, g.past.contraction = -1, 0.0, 1.0
    return status


@kernel
def collocation(m, d, s, g, run, budget):
    """Integrate as `take_steps` does."""
    return take_steps(m, d, s, g, run, budget, restart, step)
