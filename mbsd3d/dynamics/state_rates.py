"""State rates, and projections of positions and velocities onto the constraints.

    [ M(q)  J' ] [ v_dot ]   [ Q(q, v, z, t) - h(q, v) ]
    [ J     0  ] [  lam  ] = [ gamma(q, v, t)          ]        e_dot = H(e) w / 2,   rows J v = b

`evaluate` is the right side of the ODE; `project_positions` puts q on c = 0, `project_velocities` v on J v = b, both in
the metric of M.
"""

import math

import numpy as np

from ..compiler.decorators import inner_kernel, kernel, merged_kernel
from ..compiler.late import late
from ..kernels.kinds import PROJECTION
from ..kernels.kinematics import displace, kinematics, normalise, pack_motion, push_velocities, rates
from ..kernels.rows import row_speed, rows, rows_of
from ..kernels.vectors import add, add6, add_scaled, clear, cross, pair, put, put6, scale, sub, vec
from ..solver.compact_joints import ACCELERATIONS, GAPS, NOTHING, SPEEDS, larger, largest_gap
from ..solver.compact_links import go_down, go_up, mark_regular, set_link_multipliers, store_ground_reaction
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
    return scale(1.0 / total, centre) if total.real > 0.0 else centre


@inner_kernel
def audit_rates(m, d, dy):
    """Set the rates of the audit states: work of forces and drivers, impulse, angular impulse about the centre of mass.

    Joints between bodies cannot change the momentum of the whole: only applied loads and reactions of the ground count.
    """
    z = 13 * m.body.shape[0] + m.z_impulse
    clear(dy[z : z + 6])
    for k in range(m.row.shape[0]):
        audit_row(m, d, k, dy)
    audit_loads(m, d, dy)


@inner_kernel
def audit_row(m, d, k, dy):
    """Set the rate of the work of a driven row, and add the reaction of the ground in a row to the rates of impulse."""
    z, ground, row = 13 * m.body.shape[0], m.body.shape[0], m.row[k]
    if row.drive >= 0:
        dy[z + m.z_drive + row.drive] = -d.row[k].lam * d.row[k].b
    for slot in range(4):
        if row.body[slot] == ground:
            for j in range(6):
                dy[z + m.z_impulse + j] += d.row[k].J[slot, j] * d.row[k].lam


@inner_kernel
def audit_evaluation(m, d, s, dy):
    """Set the rates of the audit states after an evaluation, whose rows a compact tree has not formed."""
    if s.state.compact == 1:
        z = 13 * m.body.shape[0] + m.z_impulse
        store_ground_reaction(m, d, s, dy[z : z + 6])
        for i in range(s.loop.shape[0]):
            audit_row(m, d, s.loop[i].row, dy)
        audit_loads(m, d, dy)
    else:
        audit_rates(m, d, dy)


@inner_kernel
def audit_loads(m, d, dy):
    """Add what forces do to the rates of the audit states, which hold the reactions of the ground about its origin."""
    z, ground = 13 * m.body.shape[0], m.body.shape[0]
    for j in range(m.z_work):
        dy[z + j] = d.state_rate[j]
    for f in range(m.force.shape[0]):
        dy[z + m.z_work + f] = d.force[f].power
    impulse, centre = dy[z + m.z_impulse : z + m.z_impulse + 6], centre_of_mass(m, d)
    for i in range(m.reflected.shape[0]):
        load = m.reflected[i].inertia * (d.reflected[i].bias + reflected_acceleration(m, d, i, d.body["acceleration"]))
        for end in range(2):
            if m.reflected[i].body[end] == ground:
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


@inner_kernel
def place(m, d, s, t, y):
    """Evaluate kinematics, the rates of reflected inertias, and the rows that no link of a compact tree holds."""
    kinematics(m, d, y)
    if s.loose.shape[0] > 0 or m.reflected.shape[0] > 0:
        rows_of(m, d, s.loose, t)


@inner_kernel
def finish_compact(m, d, s, t, dy, anew):
    """Compute accelerations and all state rates of a compact tree, whose factor is made ``anew`` or at hand."""
    loads(m, d, t)
    if not go_down(m, d, s, ACCELERATIONS, anew):
        return False
    go_up(m, d, s, ACCELERATIONS)
    rates(m, d, dy)
    audit_evaluation(m, d, s, dy)
    return True


@late
@kernel
def evaluate_compact(m, d, s, t, y, dy) -> bool:
    """Evaluate as `evaluate` does, without multipliers of links, for a compact tree; False where a pivot vanishes."""
    place(m, d, s, t, y)
    mark_regular(s)
    return finish_compact(m, d, s, t, dy, 1)


@late
@kernel
def evaluate(m, d, s, t, y, dy) -> int:
    """Evaluate dy = dy/dt at (t, y); return SOLVED or the reason why there is none.

    Of a compact tree it sets the multipliers of loop rows only: the others are those of `set_link_multipliers`.
    """
    if s.state.compact == 1:
        if evaluate_compact(m, d, s, t, y, dy):
            return SOLVED
        s.state.compact = 0
    kinematics(m, d, y)
    rows(m, d, t)
    factor(m, d, s)
    return finish(m, d, s, t, dy)


@inner_kernel
def largest_residual(m, d, s):
    """Return the largest scaled |c| of the rows in use (units of the model's length, radians)."""
    largest = 0.0
    for k in s.used:
        largest = larger(largest, abs(d.row[k].c) * m.row[k].scale)
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
def residual_of_rows(m, d, s, t, y):
    """Evaluate the rows of a pose; return their largest residual."""
    kinematics(m, d, y)
    rows(m, d, t)
    return largest_residual(m, d, s)


@inner_kernel
def factor_rows(m, d, s):
    """Factorise; what is left to do where that fails `solve` does."""
    factor(m, d, s)
    return True


@inner_kernel
def newton_step(m, d, s, y):
    """Take one Newton step on c = 0 with the current factor."""
    for k in range(m.row.shape[0]):
        d.row[k].bottom = -d.row[k].c
    if correction(m, d, s) != SOLVED:
        return False
    displace(m, d, y)
    return True


@merged_kernel
def close(m, d, s, t, y, near, residual_of, factorise, step):
    """Project y onto c = 0 as `project_positions` does, by the rows or by the links of a compact tree."""
    normalise(m, y)
    floor = rounding(m, y)
    residual, fresh = residual_of(m, d, s, t, y), False
    if near == FACTOR_FROM_THIS_POSE and residual > floor:
        if not step(m, d, s, y):
            return UNSOLVED
        residual = residual_of(m, d, s, t, y)
    for _ in range(12):
        if not factorise(m, d, s):
            return UNSOLVED
        fresh = True
        if residual <= floor:
            break
        if not step(m, d, s, y):
            return UNSOLVED
        before, residual = residual, residual_of(m, d, s, t, y)
        fresh = before <= 1e3 * floor  # moved by rounding only
        if residual > 0.25 * before:  # no progress: at rounding level, or not closing
            break
    if not fresh and not factorise(m, d, s):
        return UNSOLVED
    enough = 1e3 * floor if s.state.pivot > SINGULAR_PIVOT else max(1e3 * floor, RELEASED_ROW_GAP)
    return PROJECTED if residual <= enough else NOT_CLOSED


@kernel
def project_positions(m, d, s, t, y, near):
    """Project y onto c = 0 by mass-weighted Newton steps, to rounding; the factor then belongs to the projected y.

    ``near`` = NEAR: the factor at hand belongs to a pose close by, such as the last stage of a step. A first step
    with it leaves c smaller by that distance, mostly to rounding: one new factor, of the projected pose, is enough.
    """
    return close(m, d, s, t, y, near, residual_of_rows, factor_rows, newton_step)


@kernel
def project_velocities(m, d, s, y):
    """Project the velocities onto J v = b, weighted by mass, with the current factor."""
    for k in range(m.row.shape[0]):
        d.row[k].bottom = -row_speed(m, d, k)
    if correction(m, d, s) != SOLVED:
        return UNSOLVED
    push_velocities(m, d, y)
    return PROJECTED


@kernel
def load_motion(m, d, t, q, v, y):
    """Set y[:13 n] from poses q and world velocities v, and evaluate kinematics and rows there."""
    pack_motion(q, v, y)
    kinematics(m, d, y)
    rows(m, d, t)


@kernel
def largest_residuals(m, d, some) -> tuple[float, float]:
    """Return the largest scaled |c| and |J v - b| of some rows, after kinematics and rows."""
    position, speed = 0.0, 0.0
    for k in some:
        position = larger(position, abs(d.row[k].c) * m.row[k].scale)
        speed = larger(speed, abs(row_speed(m, d, k)) * m.row[k].scale)
    return position, speed


@kernel
def start_velocities(m, d, s, y, v) -> int:
    """Project zero velocities onto J v = b with the current factor, twice: the second time from rounding.

    Sets v (6 n,), world.
    """
    for _ in range(2):
        if project_velocities(m, d, s, y) != PROJECTED:
            return UNSOLVED
        kinematics(m, d, y)
    for i in range(m.body.shape[0]):
        put6(v[6 * i :], vec(d.body[i].velocity), vec(d.body[i].w))
    return PROJECTED


@kernel
def rate_of_motion(n, y, dy, length) -> float:
    """Return how fast the motion of n bodies changes [1/s], by velocities and their rates; NaN may come out."""
    mean, moved, spin, turning, force = (0.0, 0.0, 0.0), 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        mean = add(mean, scale(1.0 / n, vec(y[7 * n + 6 * i :])))
    for i in range(n):
        for j in range(3):
            k = 7 * n + 6 * i + j
            moved, force = max(moved, abs(y[k] - mean[j])), max(force, abs(dy[k]))
            spin, turning = max(spin, abs(y[k + 3])), max(turning, abs(dy[k + 3]))
    return spin + math.sqrt(turning) + moved / length + math.sqrt(force / length)


@inner_kernel
def residual_of_links(m, d, s, t, y):
    """Evaluate the pose of a compact tree; return the largest residual of its joints."""
    place(m, d, s, t, y)
    largest = largest_gap(m, d, s)
    for i in range(s.loop.shape[0]):
        k = s.loop[i].row
        largest = larger(largest, abs(d.row[k].c) * m.row[k].scale)
    return largest


@inner_kernel
def factor_compact(m, d, s):
    """Factorise a compact tree; False where a pivot vanishes."""
    mark_regular(s)
    return go_down(m, d, s, NOTHING, 1)


@inner_kernel
def newton_step_of_links(m, d, s, y):
    """Take one Newton step on c = 0 of a compact tree with the current factor."""
    if not go_down(m, d, s, GAPS, 0):
        return False
    go_up(m, d, s, GAPS)
    displace(m, d, y)
    return True


@late
@kernel
def project_compact(m, d, s, t, y, dy, near) -> int:
    """Project y and evaluate there, for a compact tree; UNSOLVED where a pivot vanishes."""
    status = close(m, d, s, t, y, near, residual_of_links, factor_compact, newton_step_of_links)
    if status != PROJECTED:
        return status
    go_down(m, d, s, SPEEDS, 0)
    go_up(m, d, s, SPEEDS)
    push_velocities(m, d, y)
    place(m, d, s, t, y)
    finish_compact(m, d, s, t, dy, 0)
    set_link_multipliers(m, d, s)
    return PROJECTED


@late
@kernel
def project_and_evaluate(m, d, s, t, y, dy, near) -> tuple[int, int]:
    """Project y if the model asks for it, and evaluate there; return (projection status, evaluation status).

    ``near`` as in `project_positions`.
    """
    if m.stabilisation != PROJECTION:
        return PROJECTED, evaluate(m, d, s, t, y, dy)
    if s.state.compact == 1:
        status = project_compact(m, d, s, t, y, dy, near)
        if status != UNSOLVED:
            return status, SOLVED
        s.state.compact, near = 0, FACTOR_FROM_OTHER_POSE
    status = project_positions(m, d, s, t, y, near)
    if status == PROJECTED:
        status = project_velocities(m, d, s, y)
    if status != PROJECTED:
        return status, SOLVED
    kinematics(m, d, y)
    rows(m, d, t)  # gamma depends on the new velocities; the factor is still that of y's pose
    return PROJECTED, finish(m, d, s, t, dy)
