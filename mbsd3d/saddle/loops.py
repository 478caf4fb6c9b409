"""Rows that close loops, and rows on more than two bodies: S lam = rhs on what the tree leaves of them.

    S = sum over links of G N D^-1 N'G',   (S + mu) lam_k+1 = rhs + mu lam_k

Rows may repeat each other: mu keeps the factor regular, the sweeps take it away again where S resists. Off c = 0 such
rows contradict each other by as little as the state is off, and a direction in which S has only that little would
answer with a large multiplier: so where rows are nearly dependent, the right side is first replaced by what S reaches.
"""

import numpy as np

from ..kernels.jit import fused_kernel, inner_kernel, merged_kernel
from ..kernels.vectors import add_scaled, clear, copy

PROXIMAL = (
    1e-8  # times the compliance of the heaviest body of the loop, mu: J's singular values below its root are let go
)
WEAK = 1e-2  # pivots below this share of the largest that they have been: the right side is filtered
UNFELT = 1e-4  # times mu: diagonals below it belong to rows that nothing in the tree yields to, as out of a plane
FELT = 1e4  # times mu: pivots that have never been above it belong to rows that repeat others
REPEATS, SOFT = 1.001, 1e7  # times mu: pivots between these may need more than one sweep, which leaves (mu / pivot)^2
SWEEPS, MORE_SWEEPS = 1, 40  # as a rule; at most, where rows are soft
SETTLED = 1e-15  # of the right side: change of the residual that ends the sweeps
GRADED = 1e6  # largest diagonal over least pivot: S alone has too few digits then,
REGULAR = 1e7  # times mu: pivots below it are judged as if they were this
FLOOR = 1e-14  # of the diagonal: what rounding leaves of a pivot


@merged_kernel
def assemble_loops(s):
    """The lower triangle of S from the factored links."""
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
def independence(s):
    """How far the least of the independent rows has fallen: a power of two, the share of its largest pivot so far.

    Which rows come out as independent changes along the motion, how many does not: all but that many may have no pivot.
    """
    shares, now = s.shares, 0
    clear(shares)
    for i in range(s.loop.shape[0]):
        row = s.loop[i]
        most = max(row.most, row.pivot)
        if row.off == 0 and most > FELT * row.mu:
            fallen = -np.log2(row.pivot / most)
            k = shares.shape[0] - 1
            shares[int(fallen) if 0.0 <= fallen < k else k] += 1
            now += row.pivot > FELT * row.mu
    s.state.independent = now
    left = s.state.rank
    for k in range(shares.shape[0]):
        left -= shares[k]
        if left <= 0:
            return 0.5**k
    return 0.5 ** shares.shape[0]


@inner_kernel
def factor_loops(s):
    """Cholesky factor of S + mu (symmetric also for complex steps); notes how independent its rows are."""
    S, L, loop = s.skyline[0], s.skyline[1], s.loop
    s.state.weak, s.state.soft, softest, least = 0, 0, 0.0, np.inf
    for i in range(loop.shape[0]):
        line_i, first_i, mu = loop[i].line, loop[i].first, loop[i].mu
        diagonal = S[line_i + i]
        softest = max(softest, diagonal.real / mu)
        pivot = diagonal + mu
        for j in range(first_i, i):
            line_j = loop[j].line
            total = S[line_i + j]
            for k in range(max(first_i, loop[j].first), j):
                total -= L[line_i + k] * L[line_j + k]
            total *= L[line_j + j]
            pivot -= total * total
            L[line_i + j] = total
        if diagonal.real < UNFELT * mu:
            loop[i].off, loop[i].pivot = 1, 0.0
            L[line_i + i] = 0.0 * pivot  # so its multiplier is zero, and it is not seen by the rows after it
            continue
        loop[i].off = 0
        floor = mu + FLOOR * diagonal.real
        if not pivot.real >= floor:  # rounding: the row repeats others
            pivot = pivot * 0.0 + floor
        most, least = max(loop[i].most, pivot.real), min(least, pivot.real / mu)
        loop[i].pivot = pivot.real
        if pivot.real < WEAK * most or most < FELT * mu:
            s.state.weak = 1
        if REPEATS * mu < pivot.real < SOFT * mu:
            s.state.soft = 1
        L[line_i + i] = 1.0 / np.sqrt(pivot)
    s.state.pivot = independence(s) if s.state.weak == 1 else 1.0
    if softest > GRADED * max(least, REGULAR):
        s.state.dense, s.state.pivot = 1, 1.0


@fused_kernel
def substitute(s, x):
    """x := (S + mu)^-1 x by the factor."""
    L = s.skyline[1]
    for i in range(s.loop.shape[0]):
        total, line = x[i], s.loop[i].line
        for k in range(s.loop[i].first, i):
            total -= L[line + k] * x[k]
        x[i] = total * L[line + i]
    for i in range(s.loop.shape[0] - 1, -1, -1):
        line = s.loop[i].line
        value = x[i] * L[line + i]
        x[i] = value
        for k in range(s.loop[i].first, i):
            x[k] -= L[line + k] * value


@fused_kernel
def subtract_product(s, x, y):
    """y -= S x"""
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
    """True where ``step``, the new residual, is that of the sweep before, which it replaces."""
    real, imag, change_real, change_imag = 0.0, 0.0, 0.0, 0.0
    for i in range(rhs.shape[0]):
        change = step[i] - residual[i]
        change_real, change_imag = max(change_real, abs(change.real)), max(change_imag, abs(change.imag))
        real, imag = max(real, abs(rhs[i].real)), max(imag, abs(rhs[i].imag))
        residual[i] = step[i]
    return change_real <= SETTLED * real and change_imag <= SETTLED * imag


@inner_kernel
def sweeps(s, count):
    """lam := S^-1 rhs by proximal sweeps, until what they leave no longer changes."""
    rhs, lam, residual, step = s.vector[0], s.vector[1], s.vector[2], s.vector[3]
    copy(lam, rhs)
    copy(residual, rhs)
    substitute(s, lam)
    for _ in range(count):
        copy(step, rhs)
        subtract_product(s, lam, step)
        if count > SWEEPS and settled(rhs, residual, step):
            break
        substitute(s, step)
        add_scaled(lam, 1.0, step)


@merged_kernel
def solve_loops(s):
    """rhs := multipliers of the loop rows."""
    rhs, lam, step = s.vector[0], s.vector[1], s.vector[3]
    count = MORE_SWEEPS if s.state.soft == 1 else SWEEPS
    sweeps(s, count)
    if s.state.weak == 1:
        clear(step)
        subtract_product(s, lam, step)
        for i in range(step.shape[0]):
            rhs[i] = -step[i]  # S lam, the part that S can reach
        sweeps(s, count)
    copy(rhs, lam)
