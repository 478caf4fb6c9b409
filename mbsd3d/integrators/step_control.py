"""Steps that all time loops share: their budget and length, scales of errors, checks of rows, dense output."""

import numpy as np

from ..compiler.decorators import inner_kernel, merged_kernel
from ..dynamics.auditing import begin_audit, go_on_auditing
from ..dynamics.contact_steps import advance_contact_watch
from ..dynamics.spinning import restore_spin
from ..dynamics.state_rates import largest_residuals
from ..dynamics.turning import turn_on
from ..kernels.coordinates import remember
from ..kernels.kinds import PROJECTION
from ..kernels.vectors import add_scaled, clear
from ..solver.row_rank import note_independence
from .memory import DONE, FULL, RUNNING

STEP_TIME_RATIO_MIN = 1e-14  # [1] of the time, at t = 0 of the first step: shortest step; 50 units in the last place
INTEGRAL_ROUNDING = 1e-15  # [1] of a work or an impulse: error that every step may have
GRID_TOLERANCE = 1e-9  # [1] of a fixed step: distance of a kink of a signal from the end that counts as none
LOCAL_ERROR_SHARE = 0.1  # [1] of rtol: error of a single step; errors add up over a run

PROJECTION_TOLERANCE = 1e-5  # [1] pivot of a loop row below which a pose is near a singular one
SINGULAR_PROGRESS_MIN = 1e-4  # [1] of the way to a singular pose in a step: less means that the motion ends there
NEAR_SINGULAR_SHARE = 0.1  # [1] of its largest value so far: pivot of a loop row near a singular pose
ERROR_DROP_EXPECTED = 0.25  # [1] of an error that a shorter step leaves, unless rounding is its cause
ERROR_RATIO_MAX = 1e3  # [1] of the allowed error: a step with more is never taken
JUMP_ERROR_MAX = 1e2  # [1] of the allowed error in a step of the least length: it passes a jump of a force


@inner_kernel
def full(run):
    """Return True if the buffer has no room for two more samples and one of an event."""
    return run.now.written >= run.out.shape[0] - 2


@merged_kernel
def take_steps(m, d, s, own, run, budget, start, step):
    """Take up to `budget` steps.

    Return DONE, RUNNING when the budget is used up, or a reason to return to Python.
    """
    for _ in range(budget):
        if run.now.fresh > 0:
            status = start(m, d, s, own, run)
            if status != RUNNING:
                return status
            begin_audit(m, d, s, run)
        if run.now.t >= run.task.t_end:
            return DONE
        if full(run):
            return FULL
        status = step(m, d, s, own, run)
        if status != RUNNING:
            return status
    return RUNNING if run.now.t < run.task.t_end or run.now.fresh > 0 else DONE


@inner_kernel
def least_step(run):
    """Return the shortest step [s]."""
    return STEP_TIME_RATIO_MIN * max(abs(run.now.t), run.task.first_step)


@inner_kernel
def next_turn(run):
    """Return the next time at which a signal turns [s]; infinite if none does before the end."""
    turns, k, least = run.turns, run.now.next_turn, least_step(run)
    while k < turns.shape[0] and turns[k, 1] <= run.now.t + least:
        k += 1
    run.now.next_turn = k
    return turns[k, 0] if k < turns.shape[0] and turns[k, 1] <= run.task.t_end else np.inf


@inner_kernel
def on_grid(run):
    """Return (time at which the current equal step ends, distance that counts as none) [s]."""
    task, k = run.task, run.now.grid + 1
    apart = (task.t_end - task.t_start) / task.steps
    return task.t_end if k >= task.steps else task.t_start + k * apart, GRID_TOLERANCE * apart


@inner_kernel
def end_of_step(run):
    """Return (t_new, h) of the next step, which lands on t_end, where a signal turns and, if fixed, where bodies touch.

    H = 0: none is short enough.
    """
    task, t, turn, least = run.task, run.now.t, next_turn(run), least_step(run)
    if task.steps > 0:
        end, close = on_grid(run)
        t_new = turn if turn <= end + close else end
        t_new = min(t_new, t + run.now.longest)
        return t_new, max(t_new - t, least)
    h = min(run.now.step, task.max_step, run.now.longest)
    if h < least:
        if run.now.forced > 0:
            return t, 0.0
        h, run.now.forced = least, 1
    last = min(turn, task.t_end)
    t_new = last if t + 1.01 * h >= last else t + h
    return t_new, max(t_new - t, min(h, least))  # rounding of t makes no step too short


@inner_kernel
def pass_turn(run):
    """Continue behind the end of the step where the second derivative of a signal jumps there."""
    k = run.now.next_turn
    if k < run.turns.shape[0] and run.turns[k, 0] == run.now.t < run.turns[k, 1]:
        run.now.t = run.turns[k, 1]
        run.now.fresh = 2


@inner_kernel
def go_on(m, d, s, run, t_new):
    """Make the end of a step, which is in d, the start of the next one."""
    remember(m, d, t_new)
    update_scales(m, d, run)
    go_on_auditing(m, d, s, run, t_new - run.now.t)
    run.now.t = t_new
    run.now.steps += 1
    advance_contact_watch(run)
    if run.now.forced == 1:
        run.now.forced, run.now.step = 2, max(run.now.step, least_step(run))
    else:
        run.now.forced = 0
    if run.task.steps > 0:
        end, close = on_grid(run)
        run.now.grid += t_new >= end - close
    pass_turn(run)


@inner_kernel
def update_scales(m, d, run):
    """Update the largest speed relative to the mean, the largest angular velocity, and the units of z."""
    n, before = m.body.shape[0], run.now.speed
    x, y, z = 0.0, 0.0, 0.0
    for i in range(n):
        v = d.body[i].velocity
        x, y, z = x + v[0] / n, y + v[1] / n, z + v[2] / n
    for i in range(n):
        v, w = d.body[i].velocity, d.body[i].w
        speed = np.sqrt((v[0] - x) ** 2 + (v[1] - y) ** 2 + (v[2] - z) ** 2)
        turn = np.sqrt(w[0] ** 2 + w[1] ** 2 + w[2] ** 2)
        run.now.fastest = max(run.now.fastest, speed, m.length * turn)
        run.now.speed = max(run.now.speed, run.now.fastest)
        run.now.turn = max(run.now.turn, turn)
    for j in range(m.state.shape[0] if run.now.speed > before or run.now.fresh > 0 else 0):
        run.unit[j] = m.state[j].unit * run.now.speed ** m.state[j].power


@inner_kernel
def state_error(m, run):
    """Return the largest square in run.work over bodies and states: |dr|/L, angle, |dv|, |dw|, z, in their units."""
    n, x = m.body.shape[0], run.work
    shorter, slower, calmer = 1.0 / m.length**2, 1.0 / run.now.speed**2, 1.0 / run.now.turn**2
    worst, total = 0.0, 0.0
    for i in range(n):
        q, u = 7 * i, 7 * n + 6 * i
        shift = shorter * (x[q] ** 2 + x[q + 1] ** 2 + x[q + 2] ** 2)
        angle = 4.0 * (x[q + 3] ** 2 + x[q + 4] ** 2 + x[q + 5] ** 2 + x[q + 6] ** 2)
        linear = slower * (x[u] ** 2 + x[u + 1] ** 2 + x[u + 2] ** 2)
        angular = calmer * (x[u + 3] ** 2 + x[u + 4] ** 2 + x[u + 5] ** 2)
        worst = max(worst, shift, angle, linear, angular)
        total += shift + angle + linear + angular
    for j in range(m.state.shape[0]):
        least = (
            1.0 if j < m.z_work else INTEGRAL_ROUNDING / (LOCAL_ERROR_SHARE * run.task.rtol)
        )  # internal states come in any size
        error = (x[13 * n + j] / max(run.unit[j], least * abs(run.y[13 * n + j]))) ** 2
        worst = max(worst, error)
        total += error
    return worst if total * 0.0 == 0.0 else np.inf  # infinite or NaN


@inner_kernel
def nearly_singular(run):
    """Return True where loop rows were nearly dependent at the end of the last step, but not always."""
    return run.rows.pivot < NEAR_SINGULAR_SHARE


@inner_kernel
def stuck(run, h):
    """Return True close to a singular pose where motion ends, as at a dead centre: rounding holds steps far from it."""
    return run.rows.pivot < PROJECTION_TOLERANCE and h < SINGULAR_PROGRESS_MIN * run.rows.ahead < np.inf


@inner_kernel
def note_rows(s, run):
    """Record what the factor at the end of an accepted step says of its rows."""
    rows = run.rows
    rows.pivot, rows.worn = s.state.pivot, s.state.worn
    rows.lowest = min(rows.lowest, rows.pivot)
    if s.loop.shape[0] > 0:
        note_independence(s)
    if not nearly_singular(run):
        rows.on_manifold = 0


@inner_kernel
def way_to_singular(before, now, h):
    """Return the time to where the pivots vanish, after a step h: they fall with the square of the distance."""
    return h / (np.sqrt(before / now) - 1.0) if 0.0 < now < before else np.inf


@inner_kernel
def pass_over_singular(run, gap, first):
    """Shorten a step so that a singular pose ahead lies in the widest gap between stages.

    At a distance x from it a pose known to rounding leaves the acceleration known to rounding / x^3 only. The next
    step is as long as this one would have been.
    """
    step, ahead = run.now.step, run.rows.ahead
    low, high = gap
    middle, margin = 0.5 * (low + high), 0.15 * (high - low)
    at_hand = ahead < first * step  # close to stages in any case
    if at_hand or low + margin < ahead / step < high - margin or ahead > (1.0 + middle) * step:
        return
    run.now.step = ahead / middle if ahead < middle * step else ahead - middle * step
    run.rows.planned = step


@inner_kernel
def good_enough(run, h, error):
    """Return True for a step within the tolerance, or over a jump or a singular pose that shorter steps do not mend.

    Their stages lie nearer to it, so rounding counts for more: by shortening on and on the run would end there.
    """
    allowed = JUMP_ERROR_MAX if run.now.forced == 1 else 1.0
    if error <= allowed or run.rows.on_manifold == 0 or run.rows.ahead >= h:
        return error <= allowed
    before = run.rows.missed
    run.rows.missed = error
    return before > 0.0 and ERROR_DROP_EXPECTED * before < error < ERROR_RATIO_MAX


@inner_kernel
def rows_hold(m, d, s, run):
    """Return True while the rows of the tree are well independent and those left out are satisfied."""
    rows, tolerance = run.rows, run.task.tolerance
    rows.residual = 0.0
    if rows.worn == 1:
        return False
    if s.skipped.shape[0] > 0 and m.stabilisation == PROJECTION:
        position, speed = largest_residuals(m, d, s.skipped)
        rows.residual = position
        return position <= tolerance and speed <= tolerance * max(run.now.speed, run.now.turn)
    return True


@inner_kernel
def hermite(run, h, end, rate, end_rate):
    """Set coefficients F of the cubic from run.y to the end of the step, with the rates there."""
    for k in range(run.y.shape[0]):
        step = end[k] - run.y[k]
        run.F[0, k] = step
        run.F[1, k] = h * rate[k] - step
        run.F[2, k] = 2.0 * step - h * (end_rate[k] + rate[k])


@inner_kernel
def interpolate(m, run, h, x, y):
    """Set the dense output of the last step at the fraction x of it (Horner form of Hairer, Norsett, Wanner)."""
    clear(y)
    terms = run.F.shape[0]
    for i in range(terms):
        f = run.F[terms - 1 - i]
        weight = x if (terms - 1 - i) % 2 == 0 else 1.0 - x
        for j in range(y.shape[0]):
            y[j] = (y[j] + f[j]) * weight
    if run.now.rotating == 1:
        turn_on(m, run, y)
    add_scaled(y, 1.0, run.y)
    restore_spin(m, run, x * h, y)
