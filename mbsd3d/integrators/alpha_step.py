"""One step of generalised alpha: the state at its end, Newton's method for it, and its local error."""

import numpy as np

from ..kernels.dynamics import FAR, PROJECTED, audit_rates, close, rounding
from ..kernels.jit import inner_kernel, kernel, merged_kernel
from ..kernels.kinds import PROJECTION
from ..kernels.kinematics import displace_body, rotation_matrix
from ..kernels.vectors import copy, finite, put, rotate, scale
from .alpha_memory import FIRST, LAST, MADE, OF_MATRIX
from .base import EVALUATIONS, RTOL, SPEED, TURN
from .newton import fill_matrix, filtered, lu_factor, lu_solve, residual
from .scales import LOCAL, state_error

ITERATIONS = 12  # of Newton's method in one attempt
SLOW = 0.2  # contraction above which the matrix is made anew
NEWTON = 1e-3  # of rtol is what Newton's method may leave of a velocity, relative to the scales of the error


@inner_kernel
def glide(run, g, c, h, first):
    """Velocities and z of the trial state from entry `first` on, and a at the end of the step."""
    for k in range(first, run.y.shape[0]):
        a = g.rate[k] + h * g.shift[k]
        a_new = ((1.0 - c.alpha_f) * g.newton.rate[k] + c.alpha_f * g.rate[k] - c.alpha_m * a) / (1.0 - c.alpha_m)
        g.mean[k] = run.y[k] + h * ((0.5 - c.beta) * a + c.beta * a_new)
        run.trial[k] = run.y[k] + h * ((1.0 - c.gamma) * a + c.gamma * a_new)
        g.a[k] = a_new
        g.jerk_new[k] = (a_new - a) / h


@kernel
def move(m, d, s, run, g, c, t, h):
    """The trial state at t for the rates in g.newton, on c = 0; False where the joints cannot be closed."""
    n, y = m.body.shape[0], run.y
    glide(run, g, c, h, 7 * n)
    for i in range(n):
        q, u = 7 * i, 7 * n + 6 * i
        for j in range(q, q + 7):
            run.trial[j] = y[j]
        R = rotation_matrix(y[q + 3], y[q + 4], y[q + 5], y[q + 6])
        turn = scale(h, (g.mean[u + 3], g.mean[u + 4], g.mean[u + 5]))
        put(g.newton.move[i], turn)
        displace_body(run.trial, q, scale(h, (g.mean[u], g.mean[u + 1], g.mean[u + 2])), rotate(R, turn))
    run.count[EVALUATIONS] += 1
    return m.stabilisation != PROJECTION or close(m, d, s, t, run.trial, FAR) == PROJECTED


@merged_kernel
def correct(m, s, run, w, h_v):
    """Subtract the correction w.x from the unknowns; its largest velocity in the scales of the error."""
    n, nz, largest = m.body.shape[0], m.z_work, 0.0
    speed, turn = run.clock[SPEED], run.clock[TURN]
    for j in range(6 * n + nz):
        w.rate[7 * n + j] -= w.x[j]
        unit = speed if j % 6 < 3 else turn
        if j >= 6 * n:
            own = m.state[j - 6 * n]
            unit = max(own.unit * speed**own.power, abs(run.y[7 * n + j]))
        size = abs(h_v * w.x[j]) / unit
        if not size <= largest:  # NaN counts
            largest = size
    for i in range(s.place.shape[0]):
        w.lam[s.place[i].row] -= w.x[6 * n + nz + i]
    return largest


@inner_kernel
def predict(run, g, c, h, steady):
    """First guess of the rates and multipliers: those at the start, or rates that let the pose go on with v.

    Where the start rings in a stiff force, v_dot h^2 is large and the first guess far away: the steady one is not.
    """
    copy(g.newton.rate, g.rate)
    copy(g.newton.lam, g.lam)
    if steady:
        for k in range(g.rate.shape[0]):
            a = g.rate[k] + h * g.shift[k]
            a_new = a * (1.0 - 0.5 / c.beta)
            g.newton.rate[k] = ((1.0 - c.alpha_m) * a_new + c.alpha_m * a - c.alpha_f * g.rate[k]) / (1.0 - c.alpha_f)
        g.flag[MADE] = 0


@inner_kernel
def solve_step(m, d, s, run, g, c, t, h):
    """Newton's method for the rates and multipliers at the end of the step from their guess; True if it converges.

    The matrix is kept over steps of the same size and made anew where it contracts by less than SLOW.
    """
    w, n = g.newton, m.body.shape[0]
    size = 6 * n + m.z_work + s.place.shape[0]
    change = (1.0 - c.alpha_f) / (1.0 - c.alpha_m)
    h_v, h_q = h * c.gamma * change, h * h * c.beta * change
    reach = 1.0 + m.length / (h * run.clock[SPEED])  # rounding of q is one of v, divided by h
    held = run.clock[RTOL] if g.table.steps == 0 else min(run.clock[RTOL], 1e-8)  # fixed steps: dt alone sets the error
    tolerance = max(NEWTON * held, 10.0 * reach * rounding(m, run.y))
    stale = g.flag[MADE] == 0 or abs(g.h[OF_MATRIX] - h_v) > 1e-6 * h_v
    before = 0.0
    for k in range(ITERATIONS):
        if not move(m, d, s, run, g, c, t, h):
            return False
        residual(m, d, s, t, run.trial, w.rate, w.lam, h_v, w.x)
        if stale:
            g.flag[MADE] = 0
            fill_matrix(m, d, s, w, t, run.trial, h_q, h_v)
            if not lu_factor(w.A, w.pivot, size):
                return False
            g.flag[MADE], g.h[OF_MATRIX], stale = 1, h_v, False
        lu_solve(w.A, w.pivot, w.x, size)
        moved = correct(m, s, run, w, h_v)
        if not np.isfinite(moved):
            return False
        contraction = moved / before if before > 0.0 else 0.1
        if moved <= tolerance or (contraction < 0.9 and moved * contraction / (1.0 - contraction) <= tolerance):
            return arrived(m, d, s, run, g, c, t, h, h_v)
        stale = k > 0 and contraction > SLOW
        before = moved
    return False


@merged_kernel
def arrived(m, d, s, run, g, c, t, h, h_v):
    """The trial state of the converged rates, with the audit states (work, impulse) by the same formula."""
    w = g.newton
    if not move(m, d, s, run, g, c, t, h):
        return False
    residual(m, d, s, t, run.trial, w.rate, w.lam, h_v, w.x)
    for k in range(m.row.shape[0]):
        d.row[k].lam = w.lam[k]
    audit_rates(m, d, w.rate)
    glide(run, g, c, h, 13 * m.body.shape[0])
    return finite(run.trial)


@merged_kernel
def local_error(m, d, s, run, g, c, h):
    """Estimated local error in units of LOCAL rtol, seen through the matrix: unresolved stiff motion does not count."""
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
        second = g.jerk_new[k] if g.flag[FIRST] == 1 else 2.0 * h * (g.jerk_new[k] - g.jerk[k]) / (h + g.h[LAST])
        e[k] = c.error_v * h**2 * second
    filtered(m, d, s, g.newton, e)
    return np.sqrt(state_error(m, run)) / (LOCAL * run.clock[RTOL])
