"""Rows that close loops, and rows on more than two bodies: S lam = rhs on what the tree leaves of them.

    S = sum over links of G N D^-1 N'G',   (S + mu) lam_k+1 = rhs + mu lam_k

Rows may repeat each other: mu keeps the factor regular, the sweeps take it away again where S resists. Off c = 0 such
rows contradict each other by as little as the state is off, and a direction in which S has only that little would answer
with a large multiplier: so where rows are nearly dependent the right side is first replaced by what S can reach.
"""

import numpy as np

from .jit import fused_kernel, inner_kernel
from .vectors import clear, copy

WEAK = 1e-2  # pivots below this share of the largest that they have been: the right side is filtered
FELT = 1e4  # times mu: pivots that have never been above it belong to rows that repeat others
SWEEPS, MORE_SWEEPS = 1, 6
FLOOR = 1e-14  # of the diagonal: what rounding leaves of a pivot


@inner_kernel
def assemble_loops(s):
    """The lower triangle of S from the factored links."""
    clear(s.skyline)
    for i in range(s.link.shape[0]):
        link = s.link[i]
        first = link.entry
        for e in range(first, first + link.entries):
            one = s.entry[e]
            for f in range(first, e + 1):
                other = s.entry[f]
                total = 0.0 * one.G[0]
                for k in range(link.rows, 6):
                    total += one.e[k] * other.e[k] * link.inverse[k]
                s.skyline[one.line + other.place] += total


@inner_kernel
def independence(s):
    """How far the least of the independent rows has fallen: a power of two, the share of its largest pivot so far.

    Which rows come out as independent changes along the motion, how many does not: all but that many may have no pivot.
    """
    shares, now = s.shares, 0
    clear(shares)
    for i in range(s.loop.shape[0]):
        row = s.loop[i]
        if row.most > FELT * row.mu:
            shares[min(int(-np.log2(row.pivot / row.most)), shares.shape[0] - 1)] += 1
            now += row.pivot > FELT * row.mu
    s.state.rank = max(s.state.rank, now)
    left = s.state.rank
    for k in range(shares.shape[0]):
        left -= shares[k]
        if left <= 0:
            return 0.5**k
    return 0.5 ** shares.shape[0]


@fused_kernel
def factor_loops(s):
    """Cholesky factor of S + mu (symmetric also for complex steps); notes how independent its rows are."""
    L = s.lower
    copy(L, s.skyline)
    s.state.weak = 0
    for i in range(s.loop.shape[0]):
        line_i, first_i = s.loop[i].line, s.loop[i].first
        diagonal = L[line_i + i]
        pivot = diagonal + s.loop[i].mu
        for j in range(first_i, i):
            line_j = s.loop[j].line
            total = L[line_i + j]
            for k in range(max(first_i, s.loop[j].first), j):
                total -= L[line_i + k] * L[line_j + k]
            total *= L[line_j + j]
            pivot -= total * total
            L[line_i + j] = total
        floor = s.loop[i].mu + FLOOR * diagonal.real
        if not pivot.real >= floor:  # rounding: the row repeats others
            pivot = pivot * 0.0 + floor
        most = max(s.loop[i].most, pivot.real)
        s.loop[i].most = most
        s.loop[i].pivot = pivot.real
        if pivot.real < WEAK * most or most < FELT * s.loop[i].mu:
            s.state.weak = 1
        L[line_i + i] = 1.0 / np.sqrt(pivot)
    s.state.pivot = independence(s) if s.state.weak == 1 else 1.0


@fused_kernel
def substitute(s, x):
    """x := (S + mu)^-1 x by the factor."""
    L = s.lower
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
    S = s.skyline
    for i in range(s.loop.shape[0]):
        line, value = s.loop[i].line, x[i]
        total = S[line + i] * value
        for k in range(s.loop[i].first, i):
            total += S[line + k] * x[k]
            y[k] -= S[line + k] * value
        y[i] -= total


@inner_kernel
def sweeps(s, count):
    """s.lam := S^-1 rhs by proximal sweeps; rhs is kept."""
    copy(s.lam, s.rhs)
    substitute(s, s.lam)
    for _ in range(count):
        copy(s.step, s.rhs)
        subtract_product(s, s.lam, s.step)
        substitute(s, s.step)
        for i in range(s.loop.shape[0]):
            s.lam[i] += s.step[i]


@inner_kernel
def solve_loops(s):
    """rhs := multipliers of the loop rows."""
    count = SWEEPS if s.state.pivot > WEAK else MORE_SWEEPS
    sweeps(s, count)
    if s.state.weak == 1:
        for i in range(s.loop.shape[0]):
            s.rhs[i] = 0.0
            s.lam[i] = -s.lam[i]
        subtract_product(s, s.lam, s.rhs)  # rhs := S lam, the part that S can reach
        sweeps(s, count)
    copy(s.rhs, s.lam)
