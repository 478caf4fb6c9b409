"""Independence of loop rows: a pivot of S + mu far above mu belongs to an independent row.

Which rows are found independent changes along the motion, how many does not. A pivot near mu belongs to a row that
repeats others, or to one along which S resists little.
"""

import numpy as np

from ..compiler.decorators import inner_kernel, late_kernel
from ..kernels.vectors import clear

REDUNDANT_PIVOT_MAX = 1e4  # [mu] pivots that have never been above it belong to rows that repeat others
SINGLE_SWEEP_PIVOT_MIN = 1e7  # [mu] pivots below it may need more than one refinement step, which leaves (mu / pivot)^2
REDUNDANT_ROW_TOLERANCE = 1e-3  # [1] resistance of S along a row: below it the row repeats others
DIRECTION_PART_MIN = 1e-6  # [1] of the largest: parts of a direction of least resistance, whose squares count
PIVOT_UNKNOWN = -1  # pivot before the first state


@inner_kernel
def fallen(row, classes):
    """Return (class, share): how far a pivot has fallen, as a power of two and as a share of its largest value."""
    share = row.pivot / max(row.most, row.pivot)
    return min(int(-np.log2(share)) if share > 0.0 else classes, classes - 1), share


@inner_kernel
def independence(s):
    """Return the share of its largest pivot that the least of the independent rows has left.

    Which rows are found independent changes along the motion, how many does not: all but that many may have no pivot.
    """
    shares, loop = s.shares, s.loop
    clear(shares)
    for i in range(loop.shape[0]):
        if max(loop[i].most, loop[i].pivot) > REDUNDANT_PIVOT_MAX:
            shares[fallen(loop[i], shares.shape[0])[0]] += 1
    left, last = s.state.rank, -1
    while left > 0 and last < shares.shape[0] - 1:
        last += 1
        left -= shares[last]
    least = 1.0
    for i in range(loop.shape[0]):
        if max(loop[i].most, loop[i].pivot) > REDUNDANT_PIVOT_MAX:
            k, share = fallen(loop[i], shares.shape[0])
            if k <= last:
                least = min(least, share)
    return least if left <= 0 else 0.5 ** shares.shape[0]


@inner_kernel
def substitute_unit(s, i, z):
    """Return (begin, end) of z := (S + mu)^-1 e of row i, zero before and outside.

    z decays from loop to loop and is cut off below `DIRECTION_PART_MIN`, so a row costs the same in any mechanism.
    """
    L, loop = s.skyline[1], s.loop
    begin, end, j, total = loop[i].first, loop[i].last + 1, i, 0.0
    z[loop[i].at] = 1.0
    while j < end:  # forward: x with L x = e, and e'z = |x|^2
        row = loop[j]
        x = z[row.at]
        for k in range(max(row.first, i), j):
            x -= L[row.line + k] * z[loop[k].at]
        x *= L[row.line + j]
        z[row.at] = x
        total += x.real * x.real
        if x.real * x.real > DIRECTION_PART_MIN**2 * total:
            end = max(end, row.last + 1)
        j += 1
    own = np.sqrt(loop[loop[i].at].mu) * total
    while j > begin:
        j -= 1
        row = loop[j]
        x = z[row.at] * L[row.line + j]
        z[row.at] = x
        if np.sqrt(loop[row.at].mu) * abs(x.real) > DIRECTION_PART_MIN * own:
            begin = min(begin, row.first)
            for k in range(row.first, j):
                z[loop[k].at] -= L[row.line + k] * x
    return begin, end


@inner_kernel
def resists(s, i):
    """Return whether S resists along row i, whose pivot is near mu; off c = 0 redundant rows do so too.

    z = (S + mu)^-1 e is nearly the direction along which S resists least: z'Sz / z'mu z = z'e / z'mu z - 1.
    """
    z, L, row = s.vector[3], s.skyline[1], s.loop[i]
    place, mu = row.line + i, s.loop[row.at].mu
    kept = L[place]
    L[place] = 1.0 / np.sqrt(row.pivot * mu)  # also where it is left out
    begin, end = substitute_unit(s, i, z)
    L[place] = kept
    own, held = z[row.at].real, 0.0
    for k in range(begin, end):
        held += s.loop[k].mu * z[k].real * z[k].real
        z[k] *= 0.0
    return own > (1.0 + REDUNDANT_ROW_TOLERANCE) * held


@late_kernel
def note_independence(s):
    """Record what the factor at a state with c = 0 says of the rows."""
    s.state.soft, s.state.idle, independent = 0, 0, 0
    clear(s.vector[3])
    for i in range(s.loop.shape[0]):
        row = s.loop[i]
        row.most = max(row.most, row.pivot)
        s.loop[row.at].idle = 1 if row.pivot == 0.0 else 0
        if row.pivot == 0.0 or row.most == 0.0:
            s.state.idle = 1
        independent += row.pivot > REDUNDANT_PIVOT_MAX
        if 0.0 < row.pivot < SINGLE_SWEEP_PIVOT_MIN and resists(s, i):
            s.state.soft = 1
    s.state.rank = max(s.state.rank, independent)
