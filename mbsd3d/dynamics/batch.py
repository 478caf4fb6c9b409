"""Post-processing over all samples of a run: wrenches of rows on a body, and the equations checked once more."""

from ..compiler.jit import inner_kernel, kernel
from ..kernels.kinematics import kinematics
from ..kernels.rows import rows
from ..kernels.vectors import add, cross, dot, mat, pair, rotate, rotate_back, scale, sub, turning, vec
from .loads import loads


@inner_kernel
def rows_of_sample(m, d, t, state, coordinates):
    """Kinematics and rows at a sample; its hinge coordinates count turns, and curves are searched from them."""
    for i in range(m.coordinate.shape[0]):
        d.coordinate[i].value = coordinates[i]
    d.unwrap_time[0] = t
    kinematics(m, d, state)
    rows(m, d, t)


@kernel
def wrenches(m, d, times, states, coordinates, lam, first, last, body, out):
    """out (samples, 6) = force and moment about O of body from the rows first:last: minus the sum of J' lam."""
    for i in range(times.shape[0]):
        rows_of_sample(m, d, times[i], states[i], coordinates[i])
        for j in range(6):
            out[i, j] = 0.0
        for k in range(first, last):
            for slot in range(4):
                if m.row[k].body[slot] == body:
                    for j in range(6):
                        out[i, j] -= d.row[k].J[slot, j] * lam[i, k]


@kernel
def body_residual(fixed, body, acceleration, out):
    """out = residuals of m a_G = F [N] and I_G alpha + w x I_G w = M_G [N m], sizes of both; body.Q holds F, M_O."""
    R, w, s = mat(body.R), vec(body.w), vec(body.s)
    r_ddot, alpha = pair(acceleration)
    a_G = add(r_ddot, add(cross(alpha, s), turning(w, s)))
    force, moment_O = pair(body.Q)
    moment = sub(moment_O, cross(s, force))
    inertia = mat(fixed.inertia)
    spin = rotate(R, rotate(inertia, rotate_back(R, w)))
    euler = add(rotate(R, rotate(inertia, rotate_back(R, alpha))), cross(w, spin))
    lost_force, lost_moment = sub(force, scale(fixed.mass, a_G)), sub(moment, euler)
    lever = cross(s, force)
    out[0] = dot(lost_force, lost_force) ** 0.5
    out[1] = dot(lost_moment, lost_moment) ** 0.5
    out[2] = fixed.mass * dot(a_G, a_G) ** 0.5 + dot(force, force) ** 0.5
    out[3] = dot(euler, euler) ** 0.5 + dot(lever, lever) ** 0.5


@kernel
def newton_euler(m, d, times, states, coordinates, accelerations, lam, out):
    """out (samples, n, 4): `body_residual` of every body, with the true terms whatever the teaching switches drop."""
    n = m.body.shape[0]
    for k in range(times.shape[0]):
        rows_of_sample(m, d, times[k], states[k], coordinates[k])
        loads(m, d, times[k])
        for row in range(m.row.shape[0]):
            for slot in range(4):
                i = m.row[row].body[slot]
                if i >= 0:
                    for j in range(6):
                        d.body[i].Q[j] -= d.row[row].J[slot, j] * lam[k, row]
        for i in range(n):
            body_residual(m.body[i], d.body[i], accelerations[k, i], out[k, i])


@kernel
def row_defects(m, d, times, states, coordinates, accelerations, out):
    """out (samples,): largest |J v_dot - gamma| with the true gamma: rows that the accelerations do not respect."""
    for k in range(times.shape[0]):
        rows_of_sample(m, d, times[k], states[k], coordinates[k])
        out[k] = 0.0
        for row in range(m.row.shape[0]):
            total = -d.row[row].gamma
            for slot in range(4):
                i = m.row[row].body[slot]
                if 0 <= i < m.body.shape[0]:
                    for j in range(6):
                        total += d.row[row].J[slot, j] * accelerations[k, i, j]
            out[k] = max(out[k], abs(total) * m.row[row].scale)
