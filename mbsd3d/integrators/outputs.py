"""Samples of a run and its end at a stop condition, both by dense output within an accepted step.

A method hands in two functions of its own: ``dense(m, d, s, own, run, h)`` fills the coefficients F of its dense
output, ``advance_to(m, d, s, own, run, t, x, h)`` brings trial and its rate to t, x after the start of the step h.
"""

import numpy as np

from ..compiler.decorators import inner_kernel, kernel, late_kernel, merged_kernel
from ..dynamics.contact_steps import start_watching
from ..dynamics.spinning import farthest_turn, rate_without_spin, restore_spin
from ..dynamics.state_rates import FACTOR_FROM_OTHER_POSE, PROJECTED, evaluate, project_and_evaluate
from ..dynamics.turning import compare_poses, hermite_of_rotations
from ..kernels.coordinates import coordinate, remember
from ..kernels.kinematics import kinematics
from ..kernels.measures import measure
from ..kernels.rows import row_speed, rows
from ..kernels.vectors import add_scaled, copy, finite
from ..solver.compact_links import set_link_multipliers
from ..solver.saddle_point import SOLVED
from .memory import FULL, NO_SOLUTION, NOT_CLOSING, RUNNING, STOPPED
from .step_control import hermite, interpolate, note_rows, update_scales

EVENT_NEWTON_STEPS = 6  # [steps] of Newton's method to the time of an event; the first uses the dense output
JUMP_MISS_SHARE = 1e-12  # [1] of a step: first try to land behind a jump that a step of the method has missed
EVENT_SCAN_INTERVALS = 8  # [intervals] of a step, or of a radian that a body turns in it, searched for an event
MONOTONE_TURN_MAX = 1.0  # [rad] in a step up to which a measure rises and falls once at most

GOLDEN_RATIO_INVERSE = 0.5 * (np.sqrt(5.0) - 1.0)


@kernel
def write(m, d, s, run, t, y):
    """Store the sample whose evaluation is in d."""
    if s.state.compact == 1:
        set_link_multipliers(m, d, s)
        rows(m, d, t)
    out = run.out[run.now.written]
    out[0] = t
    k = 1
    for j in range(y.shape[0]):
        out[k + j] = y[j]
    k += y.shape[0]
    for i in range(m.body.shape[0]):
        for j in range(6):
            out[k + j] = d.body[i].acceleration[j]
        k += 6
    position, speed = 0.0, 0.0
    for i in range(m.row.shape[0]):
        out[k + i] = d.row[i].lam
        position, speed = max(position, abs(d.row[i].c)), max(speed, abs(row_speed(m, d, i)))
    k += m.row.shape[0]
    for i in range(m.coordinate.shape[0]):
        out[k + i] = coordinate(m, d, i, t)[0]
    k += m.coordinate.shape[0]
    for i in range(m.force.shape[0]):
        out[k + i] = d.force[i].potential
        out[k + m.force.shape[0] + i] = d.force[i].power
    k += 2 * m.force.shape[0]
    out[k], out[k + 1] = position, speed
    run.now.written += 1


@inner_kernel
def output_until(run, t):
    """Return True if the next output time is t or lies before it, or if every step is a sample."""
    due = run.now.next_output < run.times.shape[0] and run.times[run.now.next_output] <= t
    return due or run.task.every_step == 1


@inner_kernel
def evaluate_start(m, d, s, run):
    """Evaluate at the current state after a start, a jump of a signal or a new tree; return RUNNING or a reason."""
    now = run.now
    status, result = project_and_evaluate(m, d, s, now.t, run.y, run.dy, FACTOR_FROM_OTHER_POSE)
    now.evaluations += 1
    if status != PROJECTED:
        return NOT_CLOSING
    if result != SOLVED or not finite(run.dy):
        return NO_SOLUTION
    note_rows(s, run)
    remember(m, d, now.t)
    update_scales(m, d, run)
    start_watching(m, d, run)
    start = now.steps == 0 and now.written == 0 and now.next_output == 0
    if (start or now.fresh == 2) and output_until(run, now.t):
        write(m, d, s, run, now.t, run.y)
        now.next_output += 1
    now.fresh = 0
    return RUNNING


@inner_kernel
def next_inside(run, h):
    """Return the time of the next sample within the step h, or in each radian of spin where steps are samples."""
    now = run.now
    if run.task.every_step == 0:
        return run.times[now.next_output] if now.next_output < run.times.shape[0] else np.inf
    parts = 1 + int(farthest_turn(run, h))
    return now.t + h * (now.inside + 1) / parts if now.inside + 1 < parts else np.inf


@inner_kernel
def samples_before(m, d, s, run, h, t_last):
    """Store the samples of the step before t_last, each projected; return RUNNING, FULL or NO_SOLUTION."""
    t = next_inside(run, h)
    while t < t_last:
        if run.now.written == run.out.shape[0] - 2:
            return FULL
        interpolate(m, run, h, (t - run.now.t) / h, run.work)
        status, result = project_and_evaluate(m, d, s, t, run.work, run.work_rate, FACTOR_FROM_OTHER_POSE)
        if status != PROJECTED or result != SOLVED:
            return NO_SOLUTION
        run.rows.lowest = min(run.rows.lowest, s.state.pivot)  # samples may lie nearer to singular positions than steps
        write(m, d, s, run, t, run.work)
        if run.task.every_step == 1:
            run.now.inside += 1
        else:
            run.now.next_output += 1
        t = next_inside(run, h)
    run.now.inside = 0
    return RUNNING


@inner_kernel
def condition(m, d, s, run, t, y):
    """Return the signed distance of the stop condition, which holds when it is >= 0; work_rate is overwritten."""
    if m.measure[run.task.condition].rows > 0:  # a reaction, which the equations give
        run.now.evaluations += 1
        if evaluate(m, d, s, t, y, run.work_rate) != SOLVED:
            return np.nan
    else:
        kinematics(m, d, y)
    return run.task.direction * (measure(m, d, run.task.condition, t) - run.task.stop)


@inner_kernel
def slope(m, d, s, run, t, y, dy, h):
    """Return the rate of the condition at (t, y), by a forward difference along the motion; work is overwritten."""
    dt = 1e-6 * h
    copy(run.work, y)
    add_scaled(run.work, dt, dy)
    later = condition(m, d, s, run, t + dt, run.work)
    return (later - condition(m, d, s, run, t, y)) / dt


@late_kernel
def may_come_true(m, d, s, run, h, t_new) -> bool:
    """Return True if the condition holds at the end of the step, may hold within it, or is not armed."""
    unsure = run.now.armed == 0 or run.now.hop > 0.0 or farthest_turn(run, h) > MONOTONE_TURN_MAX
    if unsure or condition(m, d, s, run, t_new, run.trial) >= 0.0:
        return True
    rises = slope(m, d, s, run, run.now.t, run.y, run.dy, h) > 0.0
    return rises and slope(m, d, s, run, t_new, run.trial, run.trial_rate, h) < 0.0


@inner_kernel
def condition_inside(m, d, s, run, h, x):
    """Return the condition by dense output at the fraction x of the step."""
    interpolate(m, run, h, x, run.work)
    return condition(m, d, s, run, run.now.t + x * h, run.work)


@inner_kernel
def locate(m, d, s, run, h, low, high):
    """Return the fraction of the step at which the condition comes true between low and high, by bisection."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        if condition_inside(m, d, s, run, h, middle) >= 0.0:
            high = middle
        else:
            low = middle
        if high - low < 1e-15:
            break
    return high


@late_kernel
def first_crossing(m, d, s, run, h, t_new) -> float:
    """Return the fraction of the step at which the condition first comes true, by dense output; -1 for none.

    Looked for at many points and at the peak between them: two peaks less than h/SCAN apart may pass for one.
    """
    if run.now.hop > 0.0:
        return run.now.hop / h if run.now.hop <= h else -1.0
    parts = EVENT_SCAN_INTERVALS * (1 + int(farthest_turn(run, h)))
    place, greatest, first = 0.0, -np.inf, 0.0 if run.now.armed == 1 else 2.0
    for k in range(1, parts + 1):
        x = k / parts
        g = condition_inside(m, d, s, run, h, x) if k < parts else condition(m, d, s, run, t_new, run.trial)
        if x < first:
            first = x if g < -run.task.slack else 2.0
        elif g >= 0.0:
            return locate(m, d, s, run, h, (k - 1) / parts, x)
        if x >= first and g > greatest:
            place, greatest = x, g
    if first > 1.0:
        return -1.0
    low, high = max(first, place - 1.0 / parts), min(1.0, place + 1.0 / parts)
    for _ in range(60):  # golden section
        x, x_high = high - GOLDEN_RATIO_INVERSE * (high - low), low + GOLDEN_RATIO_INVERSE * (high - low)
        g, g_high = condition_inside(m, d, s, run, h, x), condition_inside(m, d, s, run, h, x_high)
        if max(g, g_high) >= 0.0:
            return locate(m, d, s, run, h, low, x if g >= 0.0 else x_high)
        if g > g_high:
            high = x_high
        else:
            low = x
    return -1.0


@late_kernel
def watch_on(m, d, s, run, t_new):
    """Arm the condition at the end of a step where it is false; the rest of a hop begins there."""
    run.now.hop = max(run.now.hop - (t_new - run.now.t), 0.0)
    if run.now.armed == 0 and condition(m, d, s, run, t_new, run.trial) < -run.task.slack:
        run.now.armed = 1


@late_kernel
def missing_time(m, d, s, run, h, t) -> float:
    """Return the time from t until the condition comes true, by Newton's method from trial; 0 where that fails."""
    dt = -condition(m, d, s, run, t, run.trial) / slope(m, d, s, run, t, run.trial, run.trial_rate, h)
    return dt if abs(dt) <= 0.1 * h else 0.0


@late_kernel
def has_jumped(m, d, s, run, h, x) -> bool:
    """Return whether the condition is true by more than its slack at a fraction of the step found by bisection."""
    return condition_inside(m, d, s, run, h, x) > run.task.slack


@late_kernel
def holds_at_end(m, d, s, run, t) -> bool:
    """Return whether the condition is true at the trial state."""
    return condition(m, d, s, run, t, run.trial) >= 0.0


@merged_kernel
def land(m, d, s, own, run, h, x, advance_to):
    """Return (RUNNING, time) with the state where the condition comes true in trial, near x after the start.

    Newton on the time, each with a step of the method itself where its dense output would be less exact. Where the
    condition jumps, as a load does at the touch of a damped stop, bisection has found the time: the state is behind it.
    """
    t, behind = run.now.t, JUMP_MISS_SHARE * h
    jumps = run.now.hop == 0.0 and has_jumped(m, d, s, run, h, x / h)
    for left in range(EVENT_NEWTON_STEPS, 0, -1):
        status = advance_to(m, d, s, own, run, t + x, x, h)
        if status != RUNNING:
            return status, t
        if jumps:
            if left == 1 or holds_at_end(m, d, s, run, t + x):
                break
            x, behind = min(x + behind, h), 100.0 * behind
            continue
        dt = missing_time(m, d, s, run, h, t + x)
        if left == 1 or run.now.hop > 0.0 or abs(dt) <= 1e-16 * h:
            break
        x = min(max(x + dt, 0.0), h)
    return RUNNING, t + x


@late_kernel
def halt(m, d, s, run, t) -> int:
    """End the run at t, where trial has been accepted as the state at which the condition becomes true."""
    compare_poses(m, run, t - run.now.t)
    evaluate(m, d, s, t, run.trial, run.dy)
    write(m, d, s, run, t, run.trial)
    remember(m, d, t)
    copy(run.y, run.trial)
    run.now.t = t
    run.now.steps += 1
    return STOPPED


@inner_kernel
def cubic(m, d, s, own, run, h):
    """Set the dense output of methods without their own: a cubic through both ends of the step and their rates.

    That of an orientation is one of rotation vectors beside the mean rotation (`find_turns`): bodies may turn far.
    """
    copy(run.work, run.trial)
    restore_spin(m, run, -h, run.work)
    copy(run.work_rate, run.dy)
    rate_without_spin(m, run, 0.0, run.y, run.work_rate)
    end_rate = run.F[2]
    copy(end_rate, run.trial_rate)
    rate_without_spin(m, run, h, run.trial, end_rate)
    hermite(run, h, run.work, run.work_rate, end_rate)
    hermite_of_rotations(m, run, h, run.work)
    return True


@inner_kernel
def along_cubic(m, d, s, own, run, t, x, h):
    """Set the trial state at t by that cubic, x after the start of the step, projected, with its rate."""
    interpolate(m, run, h, x / h, run.trial)
    status, result = project_and_evaluate(m, d, s, t, run.trial, run.trial_rate, FACTOR_FROM_OTHER_POSE)
    run.now.evaluations += 1
    return RUNNING if status == PROJECTED and result == SOLVED and finite(run.trial_rate) else NO_SOLUTION


@late_kernel
def select(run, k):
    """Make condition k the one at hand."""
    one, task, now = run.watch[k], run.task, run.now
    task.condition, task.stop, task.direction, task.slack = one.measure, one.stop, one.direction, one.slack
    now.hop, now.armed = one.hop, one.armed


@late_kernel
def suspects(m, d, s, run, h, t_new) -> int:
    """Return how many conditions may come true in the step, and mark them."""
    found = 0
    for k in range(run.watch.shape[0]):
        select(run, k)
        run.watch[k].suspect = int(may_come_true(m, d, s, run, h, t_new))
        found += run.watch[k].suspect
    return found


@late_kernel
def first_of_all(m, d, s, run, h, t_new) -> float:
    """Return the fraction of the step at which the first condition comes true, which is then at hand; -1 for none."""
    run.now.fired, first = -1, -1.0
    for k in range(run.watch.shape[0]):
        if run.watch[k].suspect == 1:
            select(run, k)
            x = first_crossing(m, d, s, run, h, t_new)
            if x >= 0.0 and (first < 0.0 or x < first):
                run.now.fired, first = k, x
    if run.now.fired >= 0:
        select(run, run.now.fired)
    return first


@late_kernel
def watch_all_on(m, d, s, run, t_new):
    """Arm conditions that are false at the end of a step; the first one is at hand then."""
    for k in range(run.watch.shape[0] - 1, -1, -1):
        select(run, k)
        watch_on(m, d, s, run, t_new)
        run.watch[k].hop, run.watch[k].armed = run.now.hop, run.now.armed


@merged_kernel
def outputs(m, d, s, own, run, t_new, h, dense, advance_to):
    """Store the samples of the accepted step; return RUNNING, STOPPED, FULL or NO_SOLUTION."""
    t_last, stopped, watched = t_new, False, run.watch.shape[0] > 0
    inside = next_inside(run, h) < t_new
    suspect = watched and suspects(m, d, s, run, h, t_new) > 0
    if inside or suspect:
        if not dense(m, d, s, own, run, h):
            return NO_SOLUTION
        x = first_of_all(m, d, s, run, h, t_new) if suspect else -1.0
        stopped = x >= 0.0
        if stopped:
            status, t_last = land(m, d, s, own, run, h, x * h, advance_to)
            if status != RUNNING:
                return status
        status = samples_before(m, d, s, run, h, t_last)
        if status != RUNNING:
            return status
    if stopped:
        return halt(m, d, s, run, t_last)
    if watched:
        watch_all_on(m, d, s, run, t_new)
    if inside or watched:
        evaluate(m, d, s, t_new, run.trial, run.work_rate)  # the work space belongs to the end of the step again
    if output_until(run, t_new):
        write(m, d, s, run, t_new, run.trial)
        run.now.next_output += 1
    return RUNNING
