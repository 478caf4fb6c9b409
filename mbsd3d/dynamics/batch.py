"""Post-processing of all samples of a run: wrenches of rows on a body, and residuals of the equations."""

from ..compiler.decorators import inner_kernel, kernel
from ..kernels.kinematics import kinematics, rotation_matrix
from ..kernels.rows import row_speed, rows
from ..kernels.vectors import (
    add,
    add_scaled,
    clear,
    cross,
    dot,
    mat,
    pair,
    put,
    put6,
    rotate,
    rotate_back,
    scale,
    sub,
    turning,
    vec,
)
from ..solver.saddle_point import factor, reflected_acceleration, solve, subtract_known
from .applied_forces import loads, right_sides


@inner_kernel
def coordinates_of_sample(m, d, t, coordinates):
    """Set the hinge coordinates that angles count turns from, and curves are searched from."""
    for i in range(m.coordinate.shape[0]):
        d.coordinate[i].value = coordinates[i]
    d.unwrap_time[0] = t


@inner_kernel
def rows_of_sample(m, d, t, state, coordinates):
    """Evaluate kinematics and rows at a sample; hinge coordinates count turns, curves are searched from them."""
    coordinates_of_sample(m, d, t, coordinates)
    kinematics(m, d, state)
    rows(m, d, t)


@inner_kernel
def hold_multipliers(m, d, lam):
    """Set the multipliers, which laws of friction read."""
    for k in range(m.row.shape[0]):
        d.row[k].lam = lam[k]


@kernel
def loads_of_sample(m, d, t, state, coordinates, lam):
    """Evaluate kinematics and loads at a sample; rows where friction reads them."""
    if m.frictions > 0:
        rows_of_sample(m, d, t, state, coordinates)
        hold_multipliers(m, d, lam)
    else:
        coordinates_of_sample(m, d, t, coordinates)
        kinematics(m, d, state)
    loads(m, d, t)


@kernel
def loads_of_samples(m, d, times, states, coordinates, lam, v, body, wrench, power, rates, shown):
    """Set what the only force element of a model does at every sample.

    wrench (samples, 6): force and moment about O on a body; power (samples,) that all bodies get; rates (samples, k) of
    its internal states; shown (samples, 12): what its law shows.
    """
    first = m.force[0].state
    for i in range(times.shape[0]):
        loads_of_sample(m, d, times[i], states[i], coordinates[i], lam[i])
        power[i] = 0.0
        for k in range(m.body.shape[0]):
            for j in range(6):
                power[i] += d.body[k].Q[j] * v[i, k, j]
        for j in range(6):
            wrench[i, j] = d.body[body].Q[j]
        for j in range(rates.shape[1]):
            rates[i, j] = d.state_rate[first + j]
        for j in range(shown.shape[1]):
            shown[i, j] = d.force[0].shown[j]


@kernel
def joint_wrenches(m, d, times, states, coordinates, lam, parts, out):
    """Set out (k, samples, 6) = force and moment about O of k joints on their bodies b: minus the sum of J' lam.

    parts (k, 3): first row of the joint, end of its rows, index of b.
    """
    for i in range(times.shape[0]):
        rows_of_sample(m, d, times[i], states[i], coordinates[i])
        for part in range(parts.shape[0]):
            for j in range(6):
                out[part, i, j] = 0.0
            for k in range(parts[part, 0], parts[part, 1]):
                for slot in range(4):
                    if m.row[k].body[slot] == parts[part, 2]:
                        for j in range(6):
                            out[part, i, j] -= d.row[k].J[slot, j] * lam[i, k]


@kernel
def at_body_point(m, states, body, local, wrenches, out):
    """Set out (samples, 9) = force, moment about a point of a body, and that point, world.

    local (3,): the point, body axes from O; wrenches (samples, 6): force and moment about O.
    """
    for i in range(states.shape[0]):
        arm, origin, q = vec(local), (0.0, 0.0, 0.0), 7 * body
        if body < m.body.shape[0]:
            y = states[i]
            arm = rotate(rotation_matrix(y[q + 3], y[q + 4], y[q + 5], y[q + 6]), arm)
            origin = (y[q], y[q + 1], y[q + 2])
        force, moment = pair(wrenches[i])
        put6(out[i], force, sub(moment, cross(arm, force)))
        put(out[i, 6:], add(origin, arm))


@kernel
def joint_reactions(m, d, times, states, coordinates, lam, parts, local, wrenches, out):
    """Set the wrenches (k, samples, 6) of `joint_wrenches` and out (k, samples, 9) of `at_body_point`, of k joints.

    local (k, 3): the points of the joints, body axes of b from O.
    """
    joint_wrenches(m, d, times, states, coordinates, lam, parts, wrenches)
    for part in range(parts.shape[0]):
        at_body_point(m, states, parts[part, 2], local[part], wrenches[part], out[part])


@inner_kernel
def body_residual(fixed, body, acceleration, out):
    """Set residuals of m a_G = F [N] and I_G alpha + w x I_G w = M_G [N m], and sizes of both; body.Q holds F, M_O."""
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


@inner_kernel
def acceleration_defect(m, d, k, acceleration):
    """Return J v_dot - gamma of row k."""
    row = d.row[k]
    total = -row.gamma
    for slot in range(4):
        i = m.row[k].body[slot]
        if 0 <= i < m.body.shape[0]:
            for j in range(6):
                total += row.J[slot, j] * acceleration[i, j]
    return total


@inner_kernel
def row_defects(m, d, acceleration, out):
    """Set out (3,) = largest c, J v - b, J v_dot - gamma of all primitives, scaled by the model's length.

    Of the rows of a primitive the Euclidean norm: the three of a point are along axes that say nothing of it.
    """
    clear(out)
    for p in range(m.primitive.shape[0]):
        first = m.primitive[p].row
        position, speed, defect = 0.0, 0.0, 0.0
        for k in range(first, first + m.primitive[p].rows):
            position += (d.row[k].c * m.row[k].scale) ** 2
            speed += (row_speed(m, d, k) * m.row[k].scale) ** 2
            defect += (acceleration_defect(m, d, k, acceleration) * m.row[k].scale) ** 2
        for j, square in enumerate((position, speed, defect)):
            size = square**0.5
            if out[j] == out[j] and not size <= out[j]:  # NaN counts, and stays
                out[j] = size


@inner_kernel
def newton_euler(m, d, t, acceleration, lam, out):
    """Set out (n, 4) = `body_residual` of every body under its loads, and its joints' -J' lam and rotors."""
    hold_multipliers(m, d, lam)
    loads(m, d, t)
    for k in range(m.row.shape[0]):
        for slot in range(4):
            i = m.row[k].body[slot]
            if i >= 0:
                for j in range(6):
                    d.body[i].Q[j] -= d.row[k].J[slot, j] * lam[k]
    for i in range(m.reflected.shape[0]):
        load = m.reflected[i].inertia * (d.reflected[i].bias + reflected_acceleration(m, d, i, acceleration))
        for end in range(2):
            add_scaled(d.body[m.reflected[i].body[end]].Q, -load, d.reflected[i].J[end])
    for i in range(m.body.shape[0]):
        body_residual(m.body[i], d.body[i], acceleration[i], out[i])


@kernel
def equation_residuals(m, d, times, states, coordinates, accelerations, lam, bodies, joints):
    """Set bodies (samples, n, 4): `newton_euler`, joints (samples, 3): `row_defects`, ignoring teaching switches."""
    for k in range(times.shape[0]):
        rows_of_sample(m, d, times[k], states[k], coordinates[k])
        row_defects(m, d, accelerations[k], joints[k])
        newton_euler(m, d, times[k], accelerations[k], lam[k], bodies[k])


@kernel
def refinements(m, d, s, instants, states, coordinates, accelerations, lam, first, units, size, which):
    """Compute what a step of iterative refinement changes, from sample ``first`` on.

    size (samples, 3): largest change of an acceleration, of a multiplier, and least pivot of the rows that close loops
    over its largest; which (samples, 2): body and row of the changes. units (2 + rows,): of a_O, alpha, multipliers.
    Returns the sample at which rows of a joint have become dependent, so that another tree is due, or the number of
    samples.
    """
    for k in range(first, instants.shape[0]):
        rows_of_sample(m, d, instants[k], states[k], coordinates[k])
        factor(m, d, s)
        if s.state.worn == 1 and k > first:
            return k
        hold_multipliers(m, d, lam[k])
        loads(m, d, instants[k])
        right_sides(m, d)
        subtract_known(m, d, accelerations[k], lam[k])
        solve(m, d, s)
        size[k, 0], size[k, 1], size[k, 2] = 0.0, 0.0, s.state.pivot
        for i in range(m.body.shape[0]):
            a, alpha = pair(d.body[i].acceleration)
            change = max(dot(a, a) ** 0.5 / units[0], dot(alpha, alpha) ** 0.5 / units[1])
            if not change <= size[k, 0]:
                size[k, 0], which[k, 0] = change, i
        for i in range(m.row.shape[0]):
            change = abs(d.row[i].lam) / units[2 + i]
            if not change <= size[k, 1]:
                size[k, 1], which[k, 1] = change, i
    return instants.shape[0]
