"""State rates, and projections of positions and velocities onto the constraints.

    [ M(q)  J' ] [ v_dot ]   [ Q(q, v, z, t) - h(q, v) ]
    [ J     0  ] [  lam  ] = [ gamma(q, v, t)          ]        e_dot = H(e) w / 2,   rows J v = b

`evaluate` is the right side of the ODE; `project_positions` puts q on c = 0, `project_velocities` v on J v = b, both in
the metric of M.
"""

import numpy as np

from ..compiler.decorators import inner_kernel, kernel
from ..compiler.late import late
from ..kernels.kinds import PROJECTION
from ..kernels.kinematics import displace, kinematics, normalise, push_velocities, rates
from ..kernels.rows import row_speed, rows
from ..kernels.vectors import add, add6, add_scaled, cross, pair, put, put6, scale, sub, vec
from ..solver.saddle_point import SOLVED, factor, reflected_acceleration, solve, solve_refined
from .applied_forces import loads, right_sides
from .joint_friction import settle_friction

PROJECTED, NOT_CLOSED, UNSOLVED = 0, 1, 2
SINGULAR_PIVOT = 1e-4  # [1] pivot of a loop row below which the row may be released
RELEASED_ROW_GAP = 1e-10  # [1] residual of a released row up to which it stays released
# Pose that the factorisation at hand belongs to; plain ints would be compiled a second time.
FACTOR_FROM_OTHER_POSE, FACTOR_FROM_THIS_POSE = np.int64(0), np.int64(1)


@inner_kernel
def centre_of_mass(m, d):
    """Return the centre of mass of all bodies [m]; the origin if none has a mass."""
    total, centre = 0.0, (0.0, 0.0, 0.0)
    for i in range(m.body.shape[0]):
        mass, body = m.body[i].mass, d.body[i]
        total += mass
        centre = add(centre, scale(mass, add(vec(body.r), vec(body.s))))
    return scale(1.0 / total, centre) if total > 0.0 else centre


@inner_kernel
def audit_rates(m, d, dy):
    """Set the rates of the audit states: work of forces and drivers, impulse, angular impulse about the centre of mass.

    Joints between bodies cannot change the momentum of the whole: only applied loads and reactions of the ground count.
    """
    z = 13 * m.body.shape[0]
    for j in range(m.z_work):
        dy[z + j] = d.state_rate[j]
    for f in range(m.force.shape[0]):
        dy[z + m.z_work + f] = d.force[f].power
    for k in range(m.row.shape[0]):
        if m.row[k].drive >= 0:
            dy[z + m.z_drive + m.row[k].drive] = -d.row[k].lam * d.row[k].b
    impulse, centre = dy[z + m.z_impulse : z + m.z_impulse + 6], centre_of_mass(m, d)
    for j in range(6):
        impulse[j] = 0.0
    ground = m.body.shape[0]
    for k in range(m.row.shape[0]):
        for slot in range(4):
            if m.row[k].body[slot] == ground:
                for j in range(6):
                    impulse[j] += d.row[k].J[slot, j] * d.row[k].lam
    for i in range(m.reflected.shape[0]):
        load = m.reflected[i].inertia * (d.reflected[i].bias + reflected_acceleration(m, d, i, d.body["acceleration"]))
        for end in range(2):
            if m.coordinate[m.reflected[i].coordinate].body[end] == ground:
                add_scaled(impulse, load, d.reflected[i].J[end])
    force, moment = pair(impulse)
    put6(impulse, force, sub(moment, cross(centre, force)))
    for i in range(ground):
        force, moment = pair(d.body[i].Q)
        add6(impulse, force, add(moment, cross(sub(vec(d.body[i].r), centre), force)))


@kernel
def accelerate(m, d, s, t):
    """Solve for v_dot and lam with the current rows, loads and factorisation."""
    loads(m, d, t)
    return solve_for_loads(m, d, s)


@kernel
def solve_for_loads(m, d, s):
    """Solve for v_dot and lam with the loads in Q, and for the friction that depends on lam."""
    right_sides(m, d)
    status = solve_refined(m, d, s)
    return settle_friction(m, d, s) if status == SOLVED and m.frictions > 0 else status


@inner_kernel
def finish(m, d, s, t, dy):
    """Compute accelerations and all state rates from the current rows and factorisation."""
    status = accelerate(m, d, s, t)
    if status == SOLVED:
        rates(m, d, dy)
        audit_rates(m, d, dy)
    return status


@late
@kernel
def evaluate(m, d, s, t, y, dy) -> int:
    """Evaluate dy = dy/dt at (t, y); return SOLVED or the reason why there is none."""
    kinematics(m, d, y)
    rows(m, d, t)
    factor(m, d, s)
    return finish(m, d, s, t, dy)


@inner_kernel
def largest_residual(m, d, s):
    """Return the largest scaled |c| of the rows in use (units of the model's length, radians)."""
    largest = 0.0
    for k in s.used:
        size = abs(d.row[k].c) * m.row[k].scale
        if largest == largest and not size <= largest:  # NaN counts, and stays
            largest = size
    return largest


@inner_kernel
def rounding(m, y):
    """Return the rounding of a scaled residual: 1e-15 of the farthest coordinate in units of the model's length."""
    reach = 0.0
    for i in range(m.body.shape[0]):
        for j in range(3):
            reach = max(reach, abs(y[7 * i + j]))
    return 1e-15 * (1.0 + reach / m.length)


@inner_kernel
def correction(m, d, s):
    """Solve for the smallest displacement (in the metric of M) with J dx = bottom."""
    for i in range(m.body.shape[0]):
        top = d.body[i].top
        for j in range(6):
            top[j] = 0.0
        put(d.body[i].turn, (0.0, 0.0, 0.0))
    return solve(m, d, s)


@inner_kernel
def newton_step(m, d, s, t, y):
    """Take one Newton step on c = 0 with the current factor, and evaluate the rows of the new pose."""
    for k in range(m.row.shape[0]):
        d.row[k].bottom = -d.row[k].c
    if correction(m, d, s) != SOLVED:
        return False
    displace(m, d, y)
    kinematics(m, d, y)
    rows(m, d, t)
    return True


@kernel
def project_positions(m, d, s, t, y, near):
    """Project y onto c = 0 by mass-weighted Newton steps, to rounding; the factor then belongs to the projected y.

    ``near`` = NEAR: the factor at hand belongs to a pose close by, such as the last stage of a step. A first step
    with it leaves c smaller by that distance, mostly to rounding: one new factor, of the projected pose, is enough.
    """
    normalise(m, y)
    kinematics(m, d, y)
    rows(m, d, t)
    floor = rounding(m, y)
    residual, fresh = largest_residual(m, d, s), False
    if near == FACTOR_FROM_THIS_POSE and residual > floor:
        if not newton_step(m, d, s, t, y):
            return UNSOLVED
        residual = largest_residual(m, d, s)
    for _ in range(12):
        factor(m, d, s)
        fresh = True
        if residual <= floor:
            break
        if not newton_step(m, d, s, t, y):
            return UNSOLVED
        before, residual = residual, largest_residual(m, d, s)
        fresh = before <= 1e3 * floor  # moved by rounding only
        if residual > 0.25 * before:  # no progress: at rounding level, or not closing
            break
    if not fresh:
        factor(m, d, s)
    enough = 1e3 * floor if s.state.pivot > SINGULAR_PIVOT else max(1e3 * floor, RELEASED_ROW_GAP)
    return PROJECTED if residual <= enough else NOT_CLOSED


@kernel
def project_velocities(m, d, s, y):
    """Project the velocities onto J v = b, weighted by mass, with the current factor."""
    for k in range(m.row.shape[0]):
        d.row[k].bottom = -row_speed(m, d, k)
    if correction(m, d, s) != SOLVED:
        return UNSOLVED
    push_velocities(m, d, y)
    return PROJECTED


@late
@kernel
def project_and_evaluate(m, d, s, t, y, dy, near) -> tuple[int, int]:
    """Project y if the model asks for it, and evaluate there; return (projection status, evaluation status).

    ``near`` as in `project_positions`.
    """
    if m.stabilisation != PROJECTION:
        return PROJECTED, evaluate(m, d, s, t, y, dy)
    status = project_positions(m, d, s, t, y, near)
    if status == PROJECTED:
        status = project_velocities(m, d, s, y)
    if status != PROJECTED:
        return status, SOLVED
    kinematics(m, d, y)
    rows(m, d, t)  # gamma depends on the new velocities; the factor is still that of y's pose
    return PROJECTED, finish(m, d, s, t, dy)


@inner_kernel
def skipped_residual(m, d, s):
    """Return the largest scaled |c| and |J v - b| of the rows left out, after projection."""
    position, speed = 0.0, 0.0
    for i in range(s.skipped.shape[0]):
        k = s.skipped[i]
        position = max(position, abs(d.row[k].c) * m.row[k].scale)
        speed = max(speed, abs(row_speed(m, d, k)) * m.row[k].scale)
    return position, speed
