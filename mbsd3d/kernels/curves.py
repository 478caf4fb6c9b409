"""Curves fixed in a body: where a point of another body is nearest to one, and where one is highest over a direction.

A curve x(s) is made of pieces of fifth degree, in body axes from O; s is its length. In ``Model.number`` it has

    n pieces, period (0: open), k groups, s_0 ... s_n, then per piece k groups of 3 components of 6 coefficients

with the highest power first, in s - s_i. Group 0 is x, the others are directions that go along with it.
"""

import math

from .jit import inner_kernel
from .vectors import dot, scale, sub

GROUP = 18  # numbers of a group of a piece
CLOSE = 1e-8  # of a piece: from there one more step of Newton's method is exact
BEYOND = 1e-6  # of a piece: so far past the end of an open curve is the end, by rounding


@inner_kernel
def power(data, k, u):
    """c5 u^5 + ... + c0 and three derivatives."""
    c5, c4, c3, c2, c1, c0 = data[k], data[k + 1], data[k + 2], data[k + 3], data[k + 4], data[k + 5]
    return (
        ((((c5 * u + c4) * u + c3) * u + c2) * u + c1) * u + c0,
        (((5.0 * c5 * u + 4.0 * c4) * u + 3.0 * c3) * u + 2.0 * c2) * u + c1,
        ((20.0 * c5 * u + 12.0 * c4) * u + 6.0 * c3) * u + 2.0 * c2,
        (60.0 * c5 * u + 24.0 * c4) * u + 6.0 * c3,
    )


@inner_kernel
def group(data, k, u):
    """Value and three derivatives of a group of a piece, as vectors."""
    x, y, z = power(data, k, u), power(data, k + 6, u), power(data, k + 12, u)
    return (x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2]), (x[3], y[3], z[3])


@inner_kernel
def slope(data, k, u, e, weight):
    """f = x' . (e - weight x) and its derivative."""
    x, t, t_rate, _ = group(data, k, u)
    rest = sub(e, scale(weight, x))
    return dot(t, rest), dot(t_rate, rest) - weight * dot(t, t)


@inner_kernel
def piece_of(data, breaks, n, s):
    """Number of the piece that holds s, the first or last one outside."""
    low, high = 0, n - 1
    while low < high:
        middle = (low + high + 1) // 2
        if data[breaks + middle] <= s:
            low = middle
        else:
            high = middle - 1
    return low


@inner_kernel
def search(data, first, e, weight, expected):
    """(s, where its piece starts, s within the piece) at which x' . (e - weight x) falls through zero.

    weight 1: the point of the curve nearest to e; 0: its highest along e. The search goes downhill from ``expected``,
    so it stays on the branch; s counts the turns of a closed curve, and is not a number past the end of an open one.
    """
    n, period, breaks, size = int(data[first]), data[first + 1], first + 3, GROUP * int(data[first + 2])
    pieces, real = breaks + n + 1, (e[0].real, e[1].real, e[2].real)
    turns = period * math.floor((expected - data[breaks]) / period) if period > 0.0 else 0.0
    j = piece_of(data, breaks, n, expected - turns)
    for _ in range(n):
        width = data[breaks + j + 1] - data[breaks + j]
        if slope(data, pieces + size * j, width, real, weight)[0] > 0.0 and (period > 0.0 or j < n - 1):
            j += 1
            if j == n:
                j, turns = 0, turns + period
        elif slope(data, pieces + size * j, 0.0, real, weight)[0] < 0.0 and (period > 0.0 or j > 0):
            j -= 1
            if j < 0:
                j, turns = n - 1, turns - period
        else:
            break
    at, start, width = pieces + size * j, data[breaks + j], data[breaks + j + 1] - data[breaks + j]
    low = -BEYOND * width if period == 0.0 and j == 0 else 0.0
    high = (1.0 + BEYOND) * width if period == 0.0 and j == n - 1 else width
    left = slope(data, at, low, real, weight)[0] < 0.0 or slope(data, at, high, real, weight)[0] > 0.0
    u = min(max(expected - turns - start, low), high)
    for _ in range(60):
        f, rate = slope(data, at, u, real, weight)
        if f > 0.0:
            low = u
        else:
            high = u
        step = u - f / rate
        if not low < step < high:
            step = 0.5 * (low + high)
        done = abs(step - u) <= CLOSE * width
        u = step
        if done:
            break
    f, rate = slope(data, at, u, e, weight)  # of e as it is: complex in a complex step
    within = u - f / rate + (math.nan if left and period == 0.0 else 0.0)
    return turns + start + within, at, within
