"""Time loop of generalised alpha: one step by Newton's method, its local error, and its data for the next step."""

import numpy as np

from ..compiler.decorators import inner_kernel, kernel
from ..dynamics.contact_steps import may_hide_contact
from ..dynamics.spinning import find_turns
from ..dynamics.state_rates import (
    FACTOR_FROM_OTHER_POSE,
    PROJECTED,
    audit_rates,
    project_and_evaluate,
    project_positions,
    project_velocities,
    rounding,
)
from ..dynamics.turning import compare_poses, turns_are_certain
from ..kernels.kinds import PROJECTION
from ..kernels.kinematics import displace_body, rotation_matrix
from ..kernels.vectors import copy, finite, put, rotate, scale
from ..solver.saddle_point import SOLVED
from .memory import NEW_TREE, NO_SOLUTION, NOT_CLOSING, NOT_CONVERGED, RUNNING, STEP_TOO_SMALL
from .newton import fill_matrix, filtered, lu_factor, residual, solve_for_correction
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

ITERATIONS = 12  # [iterations] of Newton's method in one attempt
REFACTOR_CONTRACTION = 0.2  # [1] contraction of Newton's method above which its matrix is factorised again
ROUNDING_CONTRACTION = 0.5  # [1] contraction above which a correction as small as rounding is rounding
# [1] rtol up to which a step may err its full share: below it, the residual of Newton's method would count. Beyond, the
# share falls with this power of the excess, to a tenth at 1e-3: there the many steps err all that they may.
FINE_RTOL_MAX = 1e-8
COARSE_RTOL_EXPONENT = -0.2
NEWTON_RESIDUAL_SHARE = 1e-3  # [1] of rtol: what Newton's method may leave of a velocity, in the scales of the error
MULTIPLIER_GROWTH_MAX = 10.0  # [1] of the multipliers in a step: more comes from stiff elements that oscillate
STEP_GROWTH_MIN = 1.3  # [1] growth below which the step is kept, and with it the matrix


@inner_kernel
def velocities(run, g, c, h, first):
    """Set velocities and z of the trial state from entry `first` on, and a at the end of the step."""
    for k in range(first, run.y.shape[0]):
        a = g.rate[k] + h * g.shift[k]
        a_new = ((1.0 - c.alpha_f) * g.newton.rate[k] + c.alpha_f * g.rate[k] - c.alpha_m * a) / (1.0 - c.alpha_m)
        g.mean[k] = run.y[k] + h * ((0.5 - c.beta) * a + c.beta * a_new)
        run.trial[k] = run.y[k] + h * ((1.0 - c.gamma) * a + c.gamma * a_new)
        g.a[k] = a_new
        g.jerk_new[k] = (a_new - a) / h


@kernel
def trial_state(m, d, s, run, g, c, t, h):
    """Set the trial state at t for the rates in g.newton, on c = 0; return False if there is no solution."""
    n, y = m.body.shape[0], run.y
    velocities(run, g, c, h, 7 * n)
    for i in range(n):
        q, u = 7 * i, 7 * n + 6 * i
        for j in range(q, q + 7):
            run.trial[j] = y[j]
        R = rotation_matrix(y[q + 3], y[q + 4], y[q + 5], y[q + 6])
        turn = scale(h, (g.mean[u + 3], g.mean[u + 4], g.mean[u + 5]))
        put(g.newton.move[i], turn)
        displace_body(run.trial, q, scale(h, (g.mean[u], g.mean[u + 1], g.mean[u + 2])), rotate(R, turn))
    run.now.evaluations += 1
    return (
        m.stabilisation != PROJECTION or project_positions(m, d, s, t, run.trial, FACTOR_FROM_OTHER_POSE) == PROJECTED
    )


@inner_kernel
def correct(m, s, run, w, h_v):
    """Subtract the correction w.x from the unknowns; return its largest velocity in the scales of the error."""
    n, nz, largest = m.body.shape[0], m.z_work, 0.0
    speed, turn = run.now.speed, run.now.turn
    for j in range(6 * n + nz):
        w.rate[7 * n + j] -= w.x[j]
        unit = speed if j % 6 < 3 else turn
        if j >= 6 * n:
            unit = max(run.unit[j - 6 * n], abs(run.y[7 * n + j]))
        size = abs(h_v * w.x[j]) / unit
        if not size <= largest:  # NaN counts
            largest = size
    for i in range(s.used.shape[0]):
        w.lam[s.used[i]] -= w.x[6 * n + nz + i]
    return largest


@inner_kernel
def predict(g, c, h, steady):
    """Predict rates and multipliers: those at the start, or rates with which the pose moves on with v.

    Where the start rings in a stiff force, v_dot h^2 is large and the first guess far away: the steady one is not.
    """
    copy(g.newton.rate, g.rate)
    copy(g.newton.lam, g.lam)
    if steady:
        for k in range(g.rate.shape[0]):
            a = g.rate[k] + h * g.shift[k]
            a_new = a * (1.0 - 0.5 / c.beta)
            g.newton.rate[k] = ((1.0 - c.alpha_m) * a_new + c.alpha_m * a - c.alpha_f * g.rate[k]) / (1.0 - c.alpha_f)
        g.past.matrix = 0


@inner_kernel
def solve_step(m, d, s, run, g, c, t, h):
    """Solve for rates and multipliers at the end of the step by Newton's method; return True if it converges.

    The matrix is kept over steps of the same size and recomputed if it contracts too slowly. It belongs to
    velocities that meet J v = b: at others, rows that repeat each other differ, and what is open of lam would grow.
    """
    w, n = g.newton, m.body.shape[0]
    size = 6 * n + m.z_work + s.used.shape[0]
    change = (1.0 - c.alpha_f) / (1.0 - c.alpha_m)
    h_v, h_q = h * c.gamma * change, h * h * c.beta * change
    reach = 1.0 + m.length / (h * run.now.speed)  # rounding of q is one of v, divided by h
    fixed = run.task.steps > 0  # dt alone sets the error
    held = NEWTON_RESIDUAL_SHARE * (min(run.task.rtol, 1e-8) / run.task.steps if fixed else run.task.rtol)
    tolerance = max(held, 10.0 * reach * rounding(m, run.y))
    kept, stale, before = g.past.matrix == 1, g.past.matrix == 0, 0.0
    for k in range(ITERATIONS):
        if not trial_state(m, d, s, run, g, c, t, h):
            return False
        residual(m, d, s, t, run.trial, w.rate, w.lam, h_v, w.x)
        if stale:
            g.past.matrix = 0
            if m.stabilisation == PROJECTION and project_velocities(m, d, s, run.trial) != PROJECTED:
                return False
            fill_matrix(m, d, s, w, t, run.trial, h_q, h_v)
            if not lu_factor(w.A, w.pivot, size):
                return False
            g.past.matrix, g.past.matrix_step, stale = 1, h, False
        solve_for_correction(m, s, w)
        moved = correct(m, s, run, w, h_v)
        contraction = moved / before if before > 0.0 else 0.1
        if not np.isfinite(moved) or (kept and k == 1 and moved > max(before, tolerance)):  # a kept matrix leads astray
            return False
        left = moved * contraction / (1.0 - contraction) if contraction < 0.9 else moved
        done = min(moved, left) <= tolerance
        if fixed:  # what is left has the same sign in every step and adds up: on to where rounding ends the contraction
            done = left <= held or (moved <= tolerance and (contraction > ROUNDING_CONTRACTION or k == ITERATIONS - 1))
        if done:
            return converged(m, d, s, run, g, c, t, h, h_v)
        stale = k > 0 and contraction > REFACTOR_CONTRACTION
        before = moved
    return False


@inner_kernel
def converged(m, d, s, run, g, c, t, h, h_v):
    """Set the trial state of the converged rates, with the audit states (work, impulse) by the same formula."""
    w = g.newton
    if not trial_state(m, d, s, run, g, c, t, h):
        return False
    residual(m, d, s, t, run.trial, w.rate, w.lam, h_v, w.x)
    for k in range(m.row.shape[0]):
        d.row[k].lam = w.lam[k]
    audit_rates(m, d, w.rate)
    velocities(run, g, c, h, 13 * m.body.shape[0])
    return finite(run.trial)


@inner_kernel
def local_error(m, d, s, run, g, c, h):
    """Return the estimated local error over the allowed one, filtered by the matrix: stiff motion does not count."""
    n, e = m.body.shape[0], run.work
    for k in range(7 * n, e.shape[0]):
        e[k] = c.error_q * h**3 * g.jerk_new[k]
    filtered(m, d, s, g.newton, e)
    for i in range(n):
        q, u = 7 * i, 7 * n + 6 * i
        for j in range(3):
            e[q + j] = e[u + j]
            e[q + 3 + j] = 0.5 * e[u + 3 + j]  # quaternion of a small rotation
        e[q + 6] = 0.0
    for k in range(7 * n, e.shape[0]):
        second = g.jerk_new[k] if g.past.first == 1 else 2.0 * h * (g.jerk_new[k] - g.jerk[k]) / (h + g.past.step)
        e[k] = c.error_v * h**2 * second
    filtered(m, d, s, g.newton, e)
    return np.sqrt(state_error(m, run)) / (
        LOCAL_ERROR_SHARE * run.task.rtol * max(run.task.rtol / FINE_RTOL_MAX, 1.0) ** COARSE_RTOL_EXPONENT
    )


@inner_kernel
def solve_from_guesses(m, d, s, run, g, c, t, h):
    """Solve the step as `solve_step` with the kept matrix, else with a new one, else from the steady guess."""
    kept = g.past.matrix == 1 and abs(g.past.matrix_step - h) <= 1e-6 * h
    g.past.matrix = 1 if kept else 0
    predict(g, c, h, False)
    if solve_step(m, d, s, run, g, c, t, h):
        return True
    g.past.matrix = 0
    if kept:
        predict(g, c, h, False)
        if solve_step(m, d, s, run, g, c, t, h):
            return True
    predict(g, c, h, True)
    return solve_step(m, d, s, run, g, c, t, h)


@inner_kernel
def attempt(m, d, s, run, g, c):
    """Return (RUNNING, t_new, h) after a step within the tolerance, or the reason for rejecting it; adapt the step."""
    rejected, fixed = False, run.task.steps > 0
    while True:
        t_new, h = end_of_step(run)
        if h == 0.0:
            return STEP_TOO_SMALL, t_new, h
        solved = solve_from_guesses(m, d, s, run, g, c, t_new, h)
        if fixed and not solved:
            return NOT_CONVERGED, t_new, h
        error = np.inf
        if solved:
            error = 0.0 if fixed else local_error(m, d, s, run, g, c, h)
        factor = 0.25
        if np.isfinite(error):
            factor = min(3.0, max(0.2, 0.9 * max(error, 1e-9) ** (-1.0 / 3.0)))
        if good_enough(run, h, error):
            factor = min(factor, 1.0) if rejected else factor
            run.now.step = h if 0.95 < factor < STEP_GROWTH_MIN else h * factor
            return RUNNING, t_new, h
        run.now.step = h * min(factor, 0.8)
        run.now.rejected += 1
        rejected = True


@inner_kernel
def end_rates(m, run, g, h):
    """Set the rates at both ends for the dense output: velocities and z quadratic with the slopes of a."""
    for k in range(7 * m.body.shape[0], run.y.shape[0]):
        slope = (run.trial[k] - run.y[k]) / h
        run.dy[k] = slope - 0.5 * h * g.jerk_new[k]
        run.trial_rate[k] = slope + 0.5 * h * g.jerk_new[k]


@inner_kernel
def keep_multipliers(m, d, g):
    """Keep the multipliers of the step as the next guess, those of the saddle point where others have grown.

    Rows that repeat others leave a part of lam open. A first iteration, which does not meet J v = b yet, adds to it in
    every step, until the matrix belongs to forces a thousand times as large as there are.
    """
    own, end, w = 0.0, 0.0, g.newton
    for k in range(m.row.shape[0]):
        own = max(own, abs(w.lam[k]) / m.row[k].scale)
        end = max(end, abs(d.row[k].lam) / m.row[k].scale)
    for k in range(m.row.shape[0]):
        g.lam[k] = d.row[k].lam if own > MULTIPLIER_GROWTH_MAX * end else w.lam[k]


@inner_kernel
def accept(m, d, run, g, h):
    """Make the end of the step the start of the next one."""
    n, w = m.body.shape[0], g.newton
    theta = g.weights.alpha_m - g.weights.alpha_f
    for k in range(7 * n, run.y.shape[0]):
        if g.past.first == 1:
            g.shift[k] = theta * (w.rate[k] - g.rate[k]) / h
        else:
            g.shift[k] = (g.a[k] - w.rate[k]) / h
    copy(g.jerk, g.jerk_new)
    copy(g.rate, w.rate)
    keep_multipliers(m, d, g)
    copy(run.y, run.trial)
    copy(run.dy, run.trial_rate)
    if g.past.first == 1:
        g.past.first, g.past.matrix = 0, 0  # other weights from now on
    g.past.step = h


@inner_kernel
def step(m, d, s, g, run):
    """Take one accepted step with its outputs; return RUNNING or a reason to return to Python."""
    c = g.first if g.past.first == 1 else g.weights
    status, t_new, h = attempt(m, d, s, run, g, c)
    if status != RUNNING:
        return status
    projected, solved = project_and_evaluate(m, d, s, t_new, run.trial, run.trial_rate, FACTOR_FROM_OTHER_POSE)
    if projected != PROJECTED:
        return NOT_CLOSING
    if solved != SOLVED:
        return NO_SOLUTION
    if not turns_are_certain(m, d, run, t_new, h) or may_hide_contact(m, d, run, h, True):
        return RUNNING
    end_rates(m, run, g, h)
    note_rows(s, run)
    find_turns(m, run, h)
    status = outputs(m, d, s, g, run, t_new, h, cubic, along_cubic)
    if status != RUNNING:
        return status
    compare_poses(m, run, h)
    accept(m, d, run, g, h)
    go_on(m, d, s, run, t_new)
    return RUNNING if rows_hold(m, d, s, run) else NEW_TREE


@inner_kernel
def restart(m, d, s, g, run):
    """Set rates and multipliers of the start, or of a new choice of rows."""
    status = evaluate_start(m, d, s, run)
    if status == RUNNING:
        copy(g.rate, run.dy)
        for k in range(g.shift.shape[0]):
            g.shift[k] = 0.0
        for k in range(m.row.shape[0]):
            g.lam[k] = d.row[k].lam
        g.past.first, g.past.matrix = 1, 0
    return status


@kernel
def integrate(m, d, s, g, run, budget):
    """Integrate as `take_steps` does."""
    return take_steps(m, d, s, g, run, budget, restart, step)
