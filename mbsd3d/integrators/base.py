"""What every time loop shares: the run's memory, sampling of outputs, and the reasons to come back to Python."""

from typing import NamedTuple

import numpy as np

from ..kernels.coordinates import coordinate, remember
from ..kernels.dynamics import PROJECTED, arrive, evaluate, skipped_residual
from ..kernels.jit import inner_kernel
from ..kernels.kinds import PROJECTION
from ..kernels.kinematics import kinematics
from ..kernels.probes import measure
from ..kernels.rows import row_speed
from ..kernels.saddle import SOLVED, smallest_pivot
from ..kernels.vectors import add_scaled, clear, copy, finite

RUNNING, DONE, STOPPED, FULL, CHOOSE_ROWS, PASSED, STEP_TOO_SMALL, NOT_CLOSING, NO_SOLUTION = range(9)

# places in Run.clock and Run.count
T, STEP, T_START, T_END, SPEED, TURN, MIN_STEP, MAX_STEP = range(8)
RESIDUAL, RTOL, TOLERANCE, PIVOT, STOP, SIGN, SMALLEST, NORMAL_STEP = range(8, 16)
STEPS, REJECTED, EVALUATIONS, WRITTEN, NEXT, FRESH, CONDITION, EVERY, ON_MANIFOLD = range(9)

LANDINGS = 6  # Newton steps to the time of an event, each a step of the method; the first is good to its dense output
SCAN = 8  # parts of a step that are searched for an event
GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
NEARLY_SINGULAR = 1e-2  # pivot / diagonal of S below which a rejected step switches to stages on the manifold


class Run(NamedTuple):
    """Memory of one run; arrays are written in place by the time loop."""

    y: np.ndarray  # (ny,) state (q, u, z) at clock[T]
    dy: np.ndarray  # (ny,) its rate
    trial: np.ndarray  # (ny,) state at the end of the step being tried
    work: np.ndarray  # (ny,) stage or sample state
    work_rate: np.ndarray  # (ny,)
    carry: np.ndarray  # (ny,) what rounding cut off y: unstable motions amplify it by up to 1e9
    trial_carry: np.ndarray  # (ny,)
    K: np.ndarray  # (stages, ny) stage rates; K[n_stages] is the rate at the end of the step
    F: np.ndarray  # (terms, ny) dense output of the last step
    clock: np.ndarray  # (16,) see T ... NORMAL_STEP
    count: np.ndarray  # (9,) see STEPS ... ON_MANIFOLD
    times: np.ndarray  # (requested,) output times
    out: np.ndarray  # (capacity, width) samples: t, y, accelerations (6n), lam (m), hinge coordinates, potential and
    # power of the forces, largest |c| and |J v - b| over all rows


@inner_kernel
def write(m, d, run, t, y):
    """Store the sample whose evaluation is in d."""
    out = run.out[run.count[WRITTEN]]
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
    run.count[WRITTEN] += 1


@inner_kernel
def start(m, d, s, run):
    """Evaluate at the present state after a start or a new choice of rows; RUNNING or a reason to stop."""
    status, result = arrive(m, d, s, run.clock[T], run.y, run.dy)
    run.count[EVALUATIONS] += 1
    if status != PROJECTED:
        return NOT_CLOSING
    if result != SOLVED or not finite(run.dy):
        return NO_SOLUTION
    remember(m, d, run.clock[T])
    run.count[FRESH] = 0
    if run.count[STEPS] == 0 and run.count[WRITTEN] == 0 and run.count[NEXT] == 0:
        if run.count[EVERY] == 1 or (run.times.shape[0] > 0 and run.times[0] <= run.clock[T]):
            write(m, d, run, run.clock[T], run.y)
            run.count[NEXT] = 1
    return RUNNING


@inner_kernel
def hermite(run, h, dy_new):
    """Coefficients F of the cubic through both ends of the step."""
    for k in range(run.y.shape[0]):
        step = run.trial[k] - run.y[k]
        run.F[0, k] = step
        run.F[1, k] = h * run.dy[k] - step
        run.F[2, k] = 2.0 * step - h * (dy_new[k] + run.dy[k])


@inner_kernel
def interpolate(run, x, y):
    """Dense output of the last step at the fraction x of it (Horner form of Hairer, Norsett, Wanner)."""
    clear(y)
    terms = run.F.shape[0]
    for i in range(terms):
        f = run.F[terms - 1 - i]
        weight = x if (terms - 1 - i) % 2 == 0 else 1.0 - x
        for j in range(y.shape[0]):
            y[j] = (y[j] + f[j]) * weight
    add_scaled(y, 1.0, run.y)


@inner_kernel
def sample(m, d, s, run, t_old, h, t):
    """Project and evaluate the dense output at t, and store it; False if that fails."""
    interpolate(run, (t - t_old) / h, run.work)
    status, result = arrive(m, d, s, t, run.work, run.work_rate)
    if status != PROJECTED or result != SOLVED:
        return False
    write(m, d, run, t, run.work)
    return True


@inner_kernel
def condition(m, d, run, t, y):
    """Signed distance of the stop condition: it holds when this is >= 0."""
    kinematics(m, d, y)
    return run.clock[SIGN] * (measure(m, d, run.count[CONDITION], t) - run.clock[STOP])


@inner_kernel
def slope(m, d, run, t, y, dy, h):
    """Rate of the condition at (t, y), by a forward difference along the motion; work is overwritten."""
    dt = 1e-6 * h
    copy(run.work, y)
    add_scaled(run.work, dt, dy)
    later = condition(m, d, run, t + dt, run.work)
    return (later - condition(m, d, run, t, y)) / dt


@inner_kernel
def may_come_true(m, d, run, h, t_new, dy_new):
    """True if the condition holds at the end of the step, or rises at its start and falls at its end."""
    if condition(m, d, run, t_new, run.trial) >= 0.0:
        return True
    rises = slope(m, d, run, run.clock[T], run.y, run.dy, h) > 0.0
    return rises and slope(m, d, run, t_new, run.trial, dy_new, h) < 0.0


@inner_kernel
def condition_inside(m, d, run, h, x):
    """The condition by dense output at the fraction x of the step."""
    interpolate(run, x, run.work)
    return condition(m, d, run, run.clock[T] + x * h, run.work)


@inner_kernel
def locate(m, d, run, h, low, high):
    """Fraction of the step at which the condition comes true between low and high, by bisection."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        if condition_inside(m, d, run, h, middle) >= 0.0:
            high = middle
        else:
            low = middle
        if high - low < 1e-15:
            break
    return high


@inner_kernel
def first_crossing(m, d, run, h, t_new):
    """Fraction of the step at which the condition first comes true, by dense output; -1 if it does not.

    Looked for at SCAN points and at the peak between them: two peaks less than h/SCAN apart may pass for one.
    """
    place, greatest = 0.0, -np.inf
    for k in range(1, SCAN + 1):
        x = k / SCAN
        g = condition_inside(m, d, run, h, x) if k < SCAN else condition(m, d, run, t_new, run.trial)
        if g >= 0.0:
            return locate(m, d, run, h, (k - 1) / SCAN, x)
        if g > greatest:
            place, greatest = x, g
    low, high = max(0.0, place - 1.0 / SCAN), min(1.0, place + 1.0 / SCAN)
    for _ in range(60):  # golden section
        x, x_high = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        g, g_high = condition_inside(m, d, run, h, x), condition_inside(m, d, run, h, x_high)
        if max(g, g_high) >= 0.0:
            return locate(m, d, run, h, low, x if g >= 0.0 else x_high)
        if g > g_high:
            high = x_high
        else:
            low = x
    return -1.0


@inner_kernel
def missing_time(m, d, run, h, t, dy):
    """Time from t until the condition comes true, by Newton from trial and its rate; 0 where that leads astray."""
    dt = -condition(m, d, run, t, run.trial) / slope(m, d, run, t, run.trial, dy, h)
    return dt if abs(dt) <= 0.1 * h else 0.0


@inner_kernel
def halt(m, d, s, run, t):
    """End the run at t, where trial has been accepted as the state at which the condition comes true."""
    evaluate(m, d, s, t, run.trial, run.dy)
    write(m, d, run, t, run.trial)
    remember(m, d, t)
    copy(run.y, run.trial)
    run.clock[T] = t
    run.count[STEPS] += 1
    return STOPPED


@inner_kernel
def references(m, d, run):
    """Greatest speed relative to the mean and greatest angular velocity so far: the scales of velocity errors."""
    n = m.body.shape[0]
    x, y, z = 0.0, 0.0, 0.0
    for i in range(n):
        v = d.body[i].velocity
        x, y, z = x + v[0] / n, y + v[1] / n, z + v[2] / n
    for i in range(n):
        v, w = d.body[i].velocity, d.body[i].w
        speed = np.sqrt((v[0] - x) ** 2 + (v[1] - y) ** 2 + (v[2] - z) ** 2)
        turn = np.sqrt(w[0] ** 2 + w[1] ** 2 + w[2] ** 2)
        run.clock[SPEED] = max(run.clock[SPEED], speed, m.length * turn)
        run.clock[TURN] = max(run.clock[TURN], turn)


@inner_kernel
def rows_hold(m, d, s, run):
    """True while the chosen rows are well independent and the skipped ones are satisfied."""
    run.clock[RESIDUAL] = 0.0
    if m.singular == 0:
        run.clock[SMALLEST] = smallest_pivot(s)
        if run.clock[SMALLEST] > NEARLY_SINGULAR:
            run.count[ON_MANIFOLD] = 0
        if run.clock[SMALLEST] < run.clock[PIVOT]:
            return False
        run.clock[PIVOT] = max(run.clock[PIVOT], min(1e-8, 1e-4 * run.clock[SMALLEST]))  # ready for the next one
    if s.skipped.shape[0] > 0 and m.stabilisation == PROJECTION:
        position, speed = skipped_residual(m, d, s)
        run.clock[RESIDUAL] = position
        return position <= run.clock[TOLERANCE] and speed <= run.clock[TOLERANCE] * max(
            run.clock[SPEED], run.clock[TURN]
        )
    return True
