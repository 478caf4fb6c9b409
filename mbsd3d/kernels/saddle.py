"""The saddle point ``[M J'; J 0] [x; lam] = [top; bottom]`` over the chosen rows, by the Schur complement.

``M_b = U'U`` with ``U (r_dot, w) = (sqrt(m) v_G, I_p^1/2 C'R'w)``, v_G = r_dot + w x s: the dense reference-point
block is inverted by a shift to G and a scaling. With Y = J U^-1 (six numbers per row and body) and y = U^-T top

    S lam = Y y - bottom,   S = Y Y',   x = U^-1 (y - Y' lam).

S is sparse like the graph of joints; it is stored as a skyline in reverse Cuthill-McKee order and factored in place.
Models with a body without mass or with a singular inertia go through the dense matrix instead.
"""

import numpy as np

from .jit import allocating_kernel, fused_kernel, inner_kernel, kernel, merged_kernel
from .vectors import add, clear, cross, mat, pair, put, put6, rotate, rotate_back, scale, sub, vec

SOLVED, BAD_PIVOT, NOT_FINITE = 0, 1, 2


@merged_kernel
def to_scaled(inv_sqrt_mass, A, s, force, moment):
    """U^-T (force, moment about O) of a body."""
    return scale(inv_sqrt_mass, force), rotate(A, add(moment, cross(force, s)))


@inner_kernel
def put_solution(fixed, body, linear, angular):
    """acceleration, alpha := U^-1 (linear, angular), the angular part in world and in body axes."""
    alpha = rotate_back(mat(fixed.inv_sqrt_inertia), angular)
    w = rotate(mat(body.R), alpha)
    put(body.alpha, alpha)
    put6(body.acceleration, add(scale(fixed.inv_sqrt_mass, linear), cross(vec(body.s), w)), w)


@merged_kernel
def row_on_body(row, block):
    """(force, moment about O) of a unit multiplier of a row on the body of a block; both slots if it has two."""
    force, moment = pair(row.J[block.slot])
    if block.twin >= 0:
        more_force, more_moment = pair(row.J[block.twin])
        force, moment = add(force, more_force), add(moment, more_moment)
    return force, moment


@fused_kernel
def assemble_schur(m, d, s):
    """Y = J U^-1 of the chosen rows and the lower triangle of S = Y Y' into the skyline, body by body."""
    clear(s.skyline)
    for i in range(m.body.shape[0]):
        inv_sqrt_mass, A, arm = m.body[i].inv_sqrt_mass, mat(d.body[i].A), vec(d.body[i].s)  # in registers
        for e in range(s.body_first[i], s.body_first[i + 1]):
            block = s.block[e]
            force, moment = row_on_body(d.row[block.row], block)
            x, y = to_scaled(inv_sqrt_mass, A, arm, force, moment)
            put6(block.Y, x, y)
            line = block.line
            for f in range(s.body_first[i], e + 1):
                Y = s.block[f].Y
                s.skyline[line + s.block[f].place] += (
                    x[0] * Y[0] + x[1] * Y[1] + x[2] * Y[2] + y[0] * Y[3] + y[1] * Y[4] + y[2] * Y[5]
                )


@fused_kernel
def factor_skyline(s):
    """Cholesky factor L of S in place (S = L L', symmetric also for complex steps); False on a pivot <= 0 or NaN.

    The diagonal holds 1 / L_ii: dividing once per row instead of once per entry takes a third of the time off.
    """
    L = s.skyline
    for i in range(s.place.shape[0]):
        line_i, first_i = s.place[i].line, s.place[i].first
        pivot = L[line_i + i]
        s.place[i].s_ii = pivot
        limit = 1e-15 * pivot.real
        for j in range(first_i, i):
            line_j = s.place[j].line
            total = L[line_i + j]
            for k in range(max(first_i, s.place[j].first), j):
                total -= L[line_i + k] * L[line_j + k]
            total *= L[line_j + j]
            pivot -= total * total
            L[line_i + j] = total
        if not pivot.real > limit:
            return False
        L[line_i + i] = 1.0 / np.sqrt(pivot)
    return True


@inner_kernel
def smallest_pivot(s):
    """Smallest pivot relative to its diagonal of S: what is left of a row that is nearly dependent on those before."""
    smallest = 1.0
    for i in range(s.place.shape[0]):
        inverse = s.skyline[s.place[i].line + i]
        smallest = min(smallest, (1.0 / (inverse * inverse * s.place[i].s_ii)).real)
    return smallest


@fused_kernel
def solve_skyline(s):
    """rhs := S^-1 rhs by L and L'."""
    L, rhs = s.skyline, s.rhs
    for i in range(s.place.shape[0]):
        total, line = rhs[i], s.place[i].line
        for k in range(s.place[i].first, i):
            total -= L[line + k] * rhs[k]
        rhs[i] = total * L[line + i]
    for i in range(s.place.shape[0] - 1, -1, -1):
        line = s.place[i].line
        x = rhs[i] * L[line + i]
        rhs[i] = x
        for k in range(s.place[i].first, i):
            rhs[k] -= L[line + k] * x


@kernel
def factor(m, d, s):
    """Prepare `solve` at the present rows; SOLVED or BAD_PIVOT. The dense path has nothing to prepare."""
    if m.singular == 1:
        return SOLVED
    assemble_schur(m, d, s)
    return SOLVED if factor_skyline(s) else BAD_PIVOT


@inner_kernel
def solve(m, d, s):
    """acceleration, lam := solution for the right sides top, bottom (top is used up)."""
    for k in s.skipped:
        d.row[k].lam = 0.0
    if m.singular == 1:
        return solve_dense(m, d, s)
    for i in range(s.place.shape[0]):
        s.rhs[i] = -d.row[s.place[i].row].bottom
    for i in range(m.body.shape[0]):
        top = d.body[i].top
        force, moment = pair(top)
        linear, angular = to_scaled(m.body[i].inv_sqrt_mass, mat(d.body[i].A), vec(d.body[i].s), force, moment)
        put6(top, linear, add(angular, rotate(mat(m.body[i].inv_sqrt_inertia), vec(d.body[i].turn))))
        for e in range(s.body_first[i], s.body_first[i + 1]):
            Y = s.block[e].Y
            s.rhs[s.block[e].place] += (
                Y[0] * top[0] + Y[1] * top[1] + Y[2] * top[2] + Y[3] * top[3] + Y[4] * top[4] + Y[5] * top[5]
            )
    solve_skyline(s)
    for i in range(m.body.shape[0]):
        top = d.body[i].top
        for e in range(s.body_first[i], s.body_first[i + 1]):
            Y, lam = s.block[e].Y, s.rhs[s.block[e].place]
            for j in range(6):
                top[j] -= Y[j] * lam
        linear, angular = pair(top)
        put_solution(m.body[i], d.body[i], linear, angular)
    for i in range(s.place.shape[0]):
        d.row[s.place[i].row].lam = s.rhs[i]
    return SOLVED


@inner_kernel
def mass_block(fixed, body, K, i):
    """K[i:i+6, i:i+6] = [[m 1, -m [s]x], [m [s]x, I_O]], I_O = R I_G R' + m [s]x[s]x'."""
    R, s, mass = mat(body.R), vec(body.s), fixed.mass
    for j in range(3):
        unit = (1.0 if j == 0 else 0.0, 1.0 if j == 1 else 0.0, 1.0 if j == 2 else 0.0)
        turned = scale(mass, cross(s, unit))  # column j of m [s]x
        inertia = rotate(R, rotate(mat(fixed.inertia), rotate_back(R, unit)))
        steiner = sub(inertia, cross(s, turned))
        K[i + j, i + j] = mass
        for k in range(3):
            K[i + 3 + k, i + j] = turned[k]
            K[i + j, i + 3 + k] = turned[k]
            K[i + 3 + k, i + 3 + j] = steiner[k]


@allocating_kernel
def solve_dense(m, d, s):
    """The saddle point as one dense matrix: for singular mass matrices, where only the whole is regular."""
    n, c = 6 * m.body.shape[0], s.place.shape[0]
    K = np.zeros((n + c, n + c), s.skyline.dtype)
    rhs = np.zeros(n + c, s.skyline.dtype)
    for i in range(m.body.shape[0]):
        mass_block(m.body[i], d.body[i], K, 6 * i)
        force, moment = pair(d.body[i].top)
        moment = add(moment, rotate(mat(d.body[i].R), vec(d.body[i].turn)))
        for j in range(3):
            rhs[6 * i + j] = force[j]
            rhs[6 * i + 3 + j] = moment[j]
    for i in range(c):
        k = s.place[i].row
        rhs[n + i] = d.row[k].bottom
        for slot in range(4):
            b = m.row[k].body[slot]
            if 0 <= b < m.body.shape[0]:
                for j in range(6):
                    K[n + i, 6 * b + j] += d.row[k].J[slot, j]
                    K[6 * b + j, n + i] += d.row[k].J[slot, j]
    for i in range(n + c):
        if not np.isfinite(rhs[i].real):
            return NOT_FINITE
    x = np.linalg.solve(K, rhs)
    for i in range(m.body.shape[0]):
        for j in range(6):
            d.body[i].acceleration[j] = x[6 * i + j]
        put(d.body[i].alpha, rotate_back(mat(d.body[i].R), (x[6 * i + 3], x[6 * i + 4], x[6 * i + 5])))
    for i in range(c):
        d.row[s.place[i].row].lam = x[n + i]
    return SOLVED
