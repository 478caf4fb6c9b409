"""Rows that close loops, and rows on more than two bodies: S lam = rhs on what the tree leaves of them.

    S = sum over links of G N D^-1 N'G',   (S + mu) lam_k+1 = rhs + mu lam_k

Rows may repeat each other: mu keeps the factor regular, the sweeps take it away again where S resists. Off c = 0 such
rows contradict each other by as little as the state is off, and a direction in which S has only that little would answer
with a large multiplier: so where rows are nearly dependent the right side is first replaced by what S can reach.
"""

import numpy as np

from .jit import fused_kernel, inner_kernel
from .vectors import clear, copy

LET_GO = 1e-6  # pivots below this share of their diagonal belong to rows that repeat others
WEAK = 1e-3  # pivots below this share: the right side is filtered
FELT = 1e2  # times mu: diagonals below it belong to rows that nothing in the tree yields to
SWEEPS = 2
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


@fused_kernel
def factor_loops(s):
    """Cholesky factor of S + mu (symmetric also for complex steps); notes how independent its rows are."""
    L = s.lower
    copy(L, s.skyline)
    s.state.weak, s.state.pivot = 0, 1.0
    for i in range(s.loop.shape[0]):
        line_i, first_i = s.loop[i].line, s.loop[i].first
        diagonal = L[line_i + i]
        s.loop[i].s_ii = diagonal
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
        share = pivot.real / (diagonal.real + s.loop[i].mu) if diagonal.real > FELT * s.loop[i].mu else 0.0
        if share < WEAK:
            s.state.weak = 1
        if LET_GO < share < s.state.pivot:
            s.state.pivot = share
        L[line_i + i] = 1.0 / np.sqrt(pivot)


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
    sweeps(s, SWEEPS)
    if s.state.weak == 1:
        for i in range(s.loop.shape[0]):
            s.rhs[i] = 0.0
            s.lam[i] = -s.lam[i]
        subtract_product(s, s.lam, s.rhs)  # rhs := S lam, the part that S can reach
        sweeps(s, SWEEPS)
    copy(s.rhs, s.lam)
