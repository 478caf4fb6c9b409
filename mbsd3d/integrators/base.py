"""What every time loop shares: the run's memory, sampling of outputs, and the reasons to come back to Python."""

from typing import NamedTuple

import numpy as np

from ..kernels.coordinates import coordinate, remember
from ..kernels.dynamics import FAR, PROJECTED, arrive, skipped_residual
from ..kernels.jit import inner_kernel, merged_kernel
from ..kernels.kinds import PROJECTION
from ..kernels.rows import row_speed
from ..kernels.saddle import SOLVED, smallest_pivot
from ..kernels.vectors import add_scaled, clear, finite

RUNNING, DONE, STOPPED, FULL, CHOOSE_ROWS, PASSED, STEP_TOO_SMALL, NOT_CLOSING, NO_SOLUTION = range(9)
NOT_CONVERGED, STIFF = 9, 10

# places in Run.clock and Run.count
T, STEP, T_START, T_END, SPEED, TURN, MIN_STEP, MAX_STEP = range(8)
RESIDUAL, RTOL, TOLERANCE, PIVOT, STOP, SIGN, SMALLEST, NORMAL_STEP, USUAL = range(8, 17)
STEPS, REJECTED, EVALUATIONS, WRITTEN, NEXT, FRESH, CONDITION, EVERY, ON_MANIFOLD = range(9)
STIFF_TESTS, CALM_TESTS = 9, 10
RETRIED = 11  # the step at hand has been rejected before: it may not grow

# A rejected step switches to stages on the manifold where the smallest pivot / diagonal of S is below this share of the
# largest that the run has seen, and always below the second number: some mechanisms never have more than 1e-3.
NEARLY_SINGULAR, SINGULAR = 0.1, 1e-5


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
    clock: np.ndarray  # (17,) see T ... USUAL
    count: np.ndarray  # (12,) see STEPS ... RETRIED
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


@merged_kernel
def start(m, d, s, run):
    """Evaluate at the present state after a start or a new choice of rows; RUNNING or a reason to stop."""
    status, result = arrive(m, d, s, run.clock[T], run.y, run.dy, FAR)
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


@merged_kernel
def sample(m, d, s, run, t_old, h, t):
    """Project and evaluate the dense output at t, and store it; False if that fails."""
    interpolate(run, (t - t_old) / h, run.work)
    status, result = arrive(m, d, s, t, run.work, run.work_rate, FAR)
    if status != PROJECTED or result != SOLVED:
        return False
    write(m, d, run, t, run.work)
    return True


@inner_kernel
def nearly_singular(run):
    """True where the chosen rows were close to depending on each other at the end of the last step."""
    return run.clock[SMALLEST] < max(SINGULAR, NEARLY_SINGULAR * run.clock[USUAL])


@inner_kernel
def rows_hold(m, d, s, run):
    """True while the chosen rows are well independent and the skipped ones are satisfied."""
    run.clock[RESIDUAL] = 0.0
    if m.singular == 0:
        run.clock[SMALLEST] = smallest_pivot(s)
        run.clock[USUAL] = max(run.clock[USUAL], run.clock[SMALLEST])
        if not nearly_singular(run):
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
