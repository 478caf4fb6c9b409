"""Solution of the saddle point ``[M J'; J 0] [x; lam] = [top; bottom]`` over all rows in use.

Bodies and the joints of a spanning tree are eliminated from the leaves to the roots (`articulated`), rows that close
loops by what the tree leaves of them (`loop_rows`). Rows may be redundant. Where a pivot of the tree vanishes (bodies
without inertia that only a loop holds), the whole is solved as one dense matrix. A free body needs neither.
"""

import numpy as np

from ..compiler.decorators import allocating_kernel, inner_kernel, kernel
from ..compiler.late import late
from ..kernels.vectors import add, add_scaled, mat, pair, put, put6, rotate, rotate_back, sub, vec
from .articulated import body_inertia, factor_links, load_links, move_links
from .loop_rows import PROXIMAL_FACTOR, factor_loops, gap_of_links, note_gap, solve_loops
from .spatial_inertia import times

SOLVED, NOT_FINITE = 0, 1
DENSE_REFINEMENT_STEPS = 3  # [steps] of iterative refinement of the dense matrix; two reach rounding


@kernel
def factor(m, d, s):
    """Factorise the saddle-point matrix for the rows at the current state."""
    s.state.dense, s.state.worn, s.state.graded, s.state.weak, s.state.pivot = 0, 0, 0, 0, 1.0
    if s.state.apart == 1:
        s.state.dense = 1
        return
    factor_links(m, d, s)
    if s.state.dense == 0 and s.loop.shape[0] > 0:
        note_gap(m, d, s, gap_of_links(m, d, s) if s.state.idle == 1 else 0.0)
        factor_loops(s)


@kernel
def solve(m, d, s):
    """Solve for acceleration and lam with the right sides top and bottom."""
    for k in s.skipped:
        d.row[k].lam = 0.0
    if s.state.dense == 1:
        return solve_dense(m, d, s)
    for i in range(s.loop.shape[0]):
        s.vector[0, i] = -d.row[s.loop[i].row].bottom
    load_links(m, d, s)
    if s.loop.shape[0] > 0:
        solve_loops(s)
    for i in range(s.loop.shape[0]):
        d.row[s.loop[i].row].lam = s.vector[0, i]
    move_links(m, d, s)
    return SOLVED


@inner_kernel
def solve_refined(m, d, s):
    """Solve as `solve` does; with a correction by the residual where S has too few digits."""
    status = solve(m, d, s)
    return refine(m, d, s) if status == SOLVED and s.state.graded == 1 else status


@inner_kernel
def fill_dense(m, d, s, K, rhs):
    """Fill K0 = [M / w  J'; J  0] over the rows in use and the right side [top / w; bottom], w the heaviest inertia.

    So the unknowns are the accelerations and lam / w, and pivots of rows that repeat others are not lost beside w.
    """
    n, c, per_weight = 6 * m.body.shape[0], s.used.shape[0], s.state.mu / PROXIMAL_FACTOR
    for i in range(m.body.shape[0]):
        body = d.body[i]
        A, B, C = body_inertia(m.body[i], body)
        force, moment = pair(body.top)
        moment = add(moment, rotate(mat(body.R), vec(body.turn)))
        for j in range(3):
            rhs[6 * i + j] = per_weight * force[j]
            rhs[6 * i + 3 + j] = per_weight * moment[j]
            for k in range(3):
                K[6 * i + j, 6 * i + k] = per_weight * A[3 * j + k]
                K[6 * i + j, 6 * i + 3 + k] = per_weight * B[3 * j + k]
                K[6 * i + 3 + k, 6 * i + j] = per_weight * B[3 * j + k]
                K[6 * i + 3 + j, 6 * i + 3 + k] = per_weight * C[3 * j + k]
    for i in range(m.reflected.shape[0]):
        on = m.reflected[i].body
        for one in range(2):
            for other in range(2):
                if on[one] < m.body.shape[0] and on[other] < m.body.shape[0]:
                    for j in range(6):
                        share = per_weight * m.reflected[i].inertia * d.reflected[i].J[one, j]
                        for k in range(6):
                            K[6 * on[one] + j, 6 * on[other] + k] += share * d.reflected[i].J[other, k]
    for i in range(c):
        k = s.used[i]
        rhs[n + i] = d.row[k].bottom
        for slot in range(4):
            b = m.row[k].body[slot]
            if 0 <= b < m.body.shape[0]:
                for j in range(6):
                    K[n + i, 6 * b + j] += d.row[k].J[slot, j]
                    K[6 * b + j, n + i] += d.row[k].J[slot, j]


@late
@allocating_kernel
def solve_dense(m, d, s) -> int:
    """Solve the dense matrix K0 - mu, with refinement steps x += (K0 - mu)^-1 (b - K0 x) that remove mu."""
    n, c = 6 * m.body.shape[0], s.used.shape[0]
    K, rhs = np.zeros((n + c, n + c), d.row["c"].dtype), np.zeros(n + c, d.row["c"].dtype)
    fill_dense(m, d, s, K, rhs)
    for i in range(n + c):
        if not np.isfinite(rhs[i].real):
            return NOT_FINITE
    regular = K.copy()
    for i in range(c):
        regular[n + i, n + i] -= PROXIMAL_FACTOR / m.row[s.used[i]].scale ** 2
    try:
        inverse = np.linalg.inv(regular)
    except Exception:  # singular: masses and rows that leave a motion undetermined
        return NOT_FINITE
    x = inverse @ rhs
    for sweep in range(2 * DENSE_REFINEMENT_STEPS):
        if sweep == DENSE_REFINEMENT_STEPS:
            rhs[n:] = (K @ x)[n:]  # rows that contradict each other ask for what accelerations can meet
            x = inverse @ rhs
        x += inverse @ (rhs - K @ x)
    for i in range(m.body.shape[0]):
        for j in range(6):
            d.body[i].acceleration[j] = x[6 * i + j]
        put(d.body[i].alpha, rotate_back(mat(d.body[i].R), (x[6 * i + 3], x[6 * i + 4], x[6 * i + 5])))
    for i in range(c):
        d.row[s.used[i]].lam = x[n + i] * (PROXIMAL_FACTOR / s.state.mu)
    return SOLVED


@inner_kernel
def reflected_acceleration(m, d, i, acceleration):
    """Return J a, the acceleration of the coordinate of reflected inertia i without its bias, for a (n, 6)."""
    on, total = m.reflected[i].body, 0.0 * d.reflected[i].bias
    for end in range(2):
        if on[end] < m.body.shape[0]:
            for j in range(6):
                total += d.reflected[i].J[end, j] * acceleration[on[end], j]
    return total


@inner_kernel
def subtract_known(m, d, acceleration, lam):
    """Subtract [top; bottom] -= [M J'; J 0] [acceleration; lam]."""
    n = m.body.shape[0]
    for i in range(n):
        body = d.body[i]
        A, B, C = body_inertia(m.body[i], body)
        inertial, turning_part = times(A, B, C, pair(acceleration[i]))
        force, moment = pair(body.top)
        put6(body.top, sub(force, inertial), sub(moment, turning_part))
    for i in range(m.reflected.shape[0]):
        load = m.reflected[i].inertia * reflected_acceleration(m, d, i, acceleration)
        for end in range(2):
            b = m.reflected[i].body[end]
            for j in range(6 if b < n else 0):
                d.body[b].top[j] -= load * d.reflected[i].J[end, j]
    for k in range(m.row.shape[0]):
        row = d.row[k]
        for slot in range(4):
            i = m.row[k].body[slot]
            if 0 <= i < n:
                for j in range(6):
                    d.body[i].top[j] -= row.J[slot, j] * lam[k]
                    row.bottom -= row.J[slot, j] * acceleration[i, j]


@late
@allocating_kernel
def refine(m, d, s) -> int:
    """Correct acceleration, alpha and lam by the residual of the whole saddle point.

    S = J M^-1 J' has the square of the condition of J. The residual knows no S, so a solution with d digits gets 2 d,
    up to those that the condition of J leaves.
    """
    n = m.body.shape[0]
    known, alpha, lam = d.body["acceleration"][:n].copy(), d.body["alpha"][:n].copy(), d.row["lam"].copy()
    subtract_known(m, d, known, lam)
    status = solve(m, d, s)
    for i in range(n):
        add_scaled(d.body[i].acceleration, 1.0, known[i])
        add_scaled(d.body[i].alpha, 1.0, alpha[i])
    for k in range(lam.shape[0]):
        d.row[k].lam += lam[k]
    return status
