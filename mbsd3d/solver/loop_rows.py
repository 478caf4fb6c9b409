"""Loop-closure rows and rows on more than two bodies: S lam = rhs on what the tree leaves of them.

    S = sum over links of G N D^-1 N'G',   (S + mu) lam_k+1 = rhs + mu lam_k

Rows may repeat each other: mu keeps the factor regular, the sweeps take it away again where S resists. Off c = 0 such
rows contradict each other by as little as the state is off, and a direction in which S has only that little would
answer with a large multiplier: so where rows are nearly dependent, the right side is first replaced by what S reaches.
"""

import numpy as np

from ..compiler.decorators import fused_kernel, inner_kernel, late_kernel
from ..kernels.vectors import add_scaled, clear, copy
from .row_rank import PIVOT_UNKNOWN, REDUNDANT_PIVOT_MAX, independence, note_independence

# [1] times the compliance of the heaviest body of the loop: mu. Singular values of J below its root are released.
PROXIMAL_FACTOR = 1e-8
WEAK_PIVOT_RATIO = 1e-2  # [1] of its largest value so far: pivot below which the right side is filtered
# [mu] diagonal of a row that nothing in the tree yields to, as one out of the plane of a planar mechanism
IDLE_ROW_DIAGONAL_MAX = 1e-4
# [1] times the square of the gap, as a share of the compliance: the most that a row resists only since c is not 0
GAPING_ROW_FACTOR = 100.0
REFINEMENT_STEPS_USUAL = 1  # [steps] of refinement that remove mu from the solution
REFINEMENT_STEPS_MAX = 40  # [steps] near a singular pose or where rows have small pivots
SWEEP_CONVERGENCE = 1e-15  # [1] of the right side: change of the residual that ends the refinement
PIVOT_RATIO_MAX = 3e5  # [1] largest diagonal over least pivot: beyond, S leaves 1e-16 times it of the digits of J
# [1] largest diagonal over least pivot from which S alone has too few digits, and [mu] least pivot it is judged by
GRADED_MATRIX_RATIO = 1e6
REGULAR_PIVOT_MIN = 1e7
PIVOT_ROUNDING = 1e-14  # [1] of the diagonal: rounding of a pivot


@inner_kernel
def assemble_loops(s):
    """Assemble the lower triangle of S from the factored links."""
    S = s.skyline[0]
    clear(S)
    for i in range(s.link.shape[0]):
        link = s.link[i]
        first = link.entry
        for e in range(first, first + link.entries):
            line = s.entry[e].line
            for k in range(link.rows, 6):
                share = s.entry[e].e[k] * link.inverse[k]
                for f in range(first, e + 1):
                    S[line + s.entry[f].place] += share * s.entry[f].e[k]


@inner_kernel
def gap_of_links(m, d, s):
    """Return the largest scaled |c| of the rows of the links."""
    largest = 0.0
    for i in range(s.joint.shape[0]):
        k = s.joint[i].row
        largest = max(largest, abs(d.row[k].c.real) * m.row[k].scale)
    return largest


@inner_kernel
def note_gap(m, d, s, of_links):
    """Record how far the rows are off c = 0 where loop rows are factored, as they may be in a stage of a step.

    ``of_links``: as far as the gap of the rows of the links is known.
    """
    s.state.gap = of_links
    for i in range(s.loop.shape[0] if s.state.idle == 1 else 0):
        k = s.loop[i].row
        s.state.gap = max(s.state.gap, abs(d.row[k].c.real) * m.row[k].scale)


@inner_kernel
def start_group(s, begin, end):
    """Factor the lines of a group in the columns of earlier groups, and form what these leave of S in its own."""
    S, L, loop = s.skyline[0], s.skyline[1], s.loop
    first = loop[begin].first
    for i in range(begin, end):
        line = loop[i].line
        loop[i].at = i
        for k in range(first, begin):
            other, total = loop[k].line, S[line + loop[k].at]
            for j in range(max(first, loop[k].first), k if L[other + k] != 0.0 else 0):  # 0: row k is left out
                total -= L[line + j] * L[other + j]
            L[line + k] = total * L[other + k]
        for k in range(begin, i + 1):
            other, total = loop[k].line, S[line + k]
            for j in range(first, begin):
                total -= L[line + j] * L[other + j]
            L[line + k] = total


@inner_kernel
def exchange(s, i, k, end):
    """Swap rows i < k of a group, together with their columns."""
    L, loop = s.skyline[1], s.loop
    line_i, line_k = loop[i].line, loop[k].line
    loop[i].at, loop[k].at = loop[k].at, loop[i].at
    for j in range(loop[i].first, i):
        L[line_i + j], L[line_k + j] = L[line_k + j], L[line_i + j]
    for j in range(i + 1, k):
        line = loop[j].line
        L[line + i], L[line_k + j] = L[line_k + j], L[line + i]
    for j in range(k + 1, end):
        line = loop[j].line
        L[line + i], L[line + k] = L[line + k], L[line + i]
    L[line_i + i], L[line_k + k] = L[line_k + k], L[line_i + i]


@inner_kernel
def pivot_of(s, i):
    """Return the pivot in units of the row's mu, zero for a row that nothing yields to; set L_ii.

    Rows known to repeat others are left out: off c = 0 they contradict them.
    """
    L, row = s.skyline[1], s.loop[i]
    at = s.loop[row.at]
    diagonal, place = s.skyline[0][at.line + row.at].real, row.line + i
    gaping = GAPING_ROW_FACTOR / PROXIMAL_FACTOR * s.state.gap**2
    if diagonal < max(IDLE_ROW_DIAGONAL_MAX, at.idle * gaping) * at.mu:
        L[place] *= 0.0  # so its multiplier is zero, and it is not seen by the rows after it
        return 0.0
    pivot, floor = L[place] + at.mu, at.mu + PIVOT_ROUNDING * diagonal
    if not pivot.real >= floor:  # rounding: the row repeats others
        pivot = pivot * 0.0 + floor
    share = pivot.real / at.mu
    repeats = (
        s.state.soft == 0
        and max(row.most, share) < REDUNDANT_PIVOT_MAX
        and (row.most > 0.0 or share < 1.0 + gaping)  # one that has yielded nothing may begin to, from a singular pose
    )
    L[place] = 0.0 * pivot if repeats else 1.0 / np.sqrt(pivot)
    return share


@inner_kernel
def factor_group(s, begin, end):
    """Compute the Cholesky factor of a group of S + mu, largest pivot first, so that redundant rows come last."""
    L, loop = s.skyline[1], s.loop
    for i in range(begin, end):
        best, most = i, -np.inf
        for k in range(i, end):
            size = L[loop[k].line + k].real / loop[loop[k].at].mu
            if size > most:
                best, most = k, size
        if best > i:
            exchange(s, i, best, end)
        loop[i].pivot = pivot_of(s, i)
        inverse = L[loop[i].line + i]
        for k in range(i + 1, end):
            line = loop[k].line
            L[line + i] *= inverse
            for j in range(i + 1, k + 1 if inverse != 0.0 else 0):
                L[line + j] -= L[line + i] * L[loop[j].line + i]


@inner_kernel
def substitute(s, x):
    """Solve x := (S + mu)^-1 x by the factor."""
    L, loop, z = s.skyline[1], s.loop, s.vector[4]
    for i in range(loop.shape[0]):
        line, total = loop[i].line, x[loop[i].at]
        for k in range(loop[i].first, i if L[line + i] != 0.0 else 0):
            total -= L[line + k] * z[k]
        z[i] = total * L[line + i]
    for i in range(loop.shape[0] - 1, -1, -1):
        line = loop[i].line
        value = z[i] * L[line + i]
        for k in range(loop[i].first, i if value != 0.0 else 0):
            z[k] -= L[line + k] * value
        x[loop[i].at] = value


@inner_kernel
def least_independent(s):
    """Return the least pivot of the rows that repeat no others, times mu."""
    least = np.inf
    for i in range(s.loop.shape[0]):
        row = s.loop[i]
        used = s.skyline[1][row.line + i] != 0.0
        if used and (s.state.soft == 1 or max(row.most, row.pivot) > REDUNDANT_PIVOT_MAX):
            least = min(least, row.pivot)
    return least


@late_kernel
def factor_loops(s):
    """Factor S + mu, group after group, and judge how independent its rows are; symmetric for complex steps too."""
    assemble_loops(s)
    loop, begin = s.loop, 0
    while begin < loop.shape[0]:
        start_group(s, begin, loop[begin].end)
        factor_group(s, begin, loop[begin].end)
        begin = loop[begin].end
    s.state.weak, softest, least = 0, 0.0, np.inf
    for i in range(loop.shape[0]):
        row = loop[i]
        if row.pivot == 0.0:
            if row.most > REDUNDANT_PIVOT_MAX:  # at a singular pose of a mechanism built along the axes
                s.state.weak = 1
            continue
        softest, least = max(softest, s.skyline[0][row.line + i].real / row.mu), min(least, row.pivot)
        if row.pivot < WEAK_PIVOT_RATIO * row.most or (
            max(row.most, row.pivot) < REDUNDANT_PIVOT_MAX and s.skyline[1][row.line + i] != 0.0
        ):
            s.state.weak = 1
    if s.state.soft == PIVOT_UNKNOWN:
        note_independence(s)
    s.state.pivot = independence(s) if s.state.weak == 1 or s.state.soft == 1 else 1.0
    if softest > GRADED_MATRIX_RATIO * max(least, REGULAR_PIVOT_MIN):
        s.state.dense, s.state.pivot = 1, 1.0
    elif s.state.pivot > WEAK_PIVOT_RATIO and softest > PIVOT_RATIO_MAX * least_independent(
        s
    ):  # else rows are let go instead
        s.state.graded = 1


@fused_kernel
def subtract_product(s, x, y):
    """Subtract y -= S x."""
    S = s.skyline[0]
    for i in range(s.loop.shape[0]):
        line, value = s.loop[i].line, x[i]
        total = S[line + i] * value
        for k in range(s.loop[i].first, i):
            total += S[line + k] * x[k]
            y[k] -= S[line + k] * value
        y[i] -= total


@inner_kernel
def settled(rhs, residual, step):
    """Return True where ``step``, the new residual, equals that of the step before; store it in ``residual``."""
    real, imag, change_real, change_imag = 0.0, 0.0, 0.0, 0.0
    for i in range(rhs.shape[0]):
        change = step[i] - residual[i]
        change_real, change_imag = max(change_real, abs(change.real)), max(change_imag, abs(change.imag))
        real, imag = max(real, abs(rhs[i].real)), max(imag, abs(rhs[i].imag))
        residual[i] = step[i]
    return change_real <= SWEEP_CONVERGENCE * real and change_imag <= SWEEP_CONVERGENCE * imag


@inner_kernel
def sweeps(s, count):
    """Solve lam := S^-1 rhs by refinement steps with S + mu, until the residual no longer changes."""
    rhs, lam, residual, step = s.vector[0], s.vector[1], s.vector[2], s.vector[3]
    copy(lam, rhs)
    copy(residual, rhs)
    substitute(s, lam)
    for _ in range(count):
        copy(step, rhs)
        subtract_product(s, lam, step)
        if count > REFINEMENT_STEPS_USUAL and settled(rhs, residual, step):
            break
        substitute(s, step)
        add_scaled(lam, 1.0, step)


@late_kernel
def solve_loops(s):
    """Solve for the multipliers of the loop rows, in place of rhs."""
    rhs, lam, step = s.vector[0], s.vector[1], s.vector[3]
    count = REFINEMENT_STEPS_MAX if s.state.soft == 1 or s.state.pivot < WEAK_PIVOT_RATIO else REFINEMENT_STEPS_USUAL
    sweeps(s, count)
    if s.state.weak == 1:
        clear(step)
        subtract_product(s, lam, step)
        for i in range(step.shape[0]):
            rhs[i] = -step[i]  # S lam, the part that S can reach
        sweeps(s, count)
    copy(rhs, lam)
