"""Newton's and Euler's equations of one stone on a table, in plain numbers: rolling without slip, or sliding.

The stone is an ellipsoid of half axes r, thickened by a tube; all vectors have its axes. n is the vertical, w the
angular velocity, and from the lowest point to the centre of the surface leads

    a = D n / h + tube n,   h = sqrt(n'D n),   D = diag(r^2)
"""

from collections.abc import Sequence

import numpy as np

from .form import require
from .quadrature import cross, dot, motion

Numbers = Sequence[float]


def solved(rows: Sequence[Numbers], *loads: Numbers) -> list[list[float]]:
    """Solve ``rows x = load`` for each load by Cramer's rule."""
    first, second, third = rows
    minors = cross(second, third), cross(third, first), cross(first, second)
    size = dot(first, minors[0])
    return [[sum(load[k] * minors[k][i] for k in range(3)) / size for i in range(3)] for load in loads]


def rolled(
    times: np.ndarray, *, m: float, g: float, I: np.ndarray, radii: Numbers, tube: float = 0.0,
    n: Numbers, w: Numbers, arm: float = 0.0, rtol: float = 1e-11,
) -> np.ndarray:  # fmt: skip
    """Integrate n, w and the turn about the vertical, without slip, the centre of mass in the centre, shape (times, 7).

    Inertia I (3, 3) [kg m^2]; ``arm`` [m]: the moment arm N acts against rolling.

        (I - m S(a)^2) w' = -w x I w - m a x (w x (a' + w x a) + g n) - arm N w_h / |w_h|,   w_h = w - n n.w
        N = m n.(g n + w' x a + w x (a' + w x a))
    """
    inertia, D = np.asarray(I).tolist(), [r * r for r in radii]

    def rate(_: float, y: np.ndarray) -> list[float]:
        n, w = y[:3].tolist(), y[3:6].tolist()  # plain numbers: ten times faster here
        n_dot, h = cross(n, w), sum(D[k] * n[k] * n[k] for k in range(3)) ** 0.5
        disc = [D[k] * n[k] / h for k in range(3)]
        growth = dot(n_dot, disc) / h
        a = [disc[k] + tube * n[k] for k in range(3)]
        a_dot = [D[k] * n_dot[k] / h - growth * disc[k] + tube * n_dot[k] for k in range(3)]
        turn, upright = cross(w, a), dot(n, w)
        pull = cross(w, [a_dot[k] + turn[k] for k in range(3)])
        spin, lever = cross(w, [dot(row, w) for row in inertia]), cross(a, [pull[k] + g * n[k] for k in range(3)])
        square, flat = dot(a, a), [w[k] - upright * n[k] for k in range(3)]
        rows = [[inertia[i][k] + m * ((i == k) * square - a[i] * a[k]) for k in range(3)] for i in range(3)]
        against = [arm * x / (dot(flat, flat) ** 0.5 or 1.0) for x in flat]
        free, per_N = solved(rows, [-spin[k] - m * lever[k] for k in range(3)], against)
        lift = cross(a, n)
        N = m * (g + dot(n, pull) + dot(lift, free)) / (1.0 + m * dot(lift, per_N))
        return [*n_dot, *(free[k] - N * per_N[k] for k in range(3)), upright]

    return motion(rate, np.array([*n, *w, 0.0]), times, rtol)


def slid(
    times: np.ndarray, *, m: float, g: float, I: Numbers, radii: Numbers, com: Numbers, k: float, c: float,
    mu: float, creep: float, n: Numbers, w: Numbers, v: Numbers, height: float,
) -> np.ndarray:  # fmt: skip
    """Integrate n, w, the velocity v of the centre of mass G and its height z, on a compliant table, shape (times, 10).

    Principal moments I (3,); ``com`` leads from the centre of the surface to G, s = -a - com from G to the table.

        m (v' + w x v) = F - m g n,  I w' = -w x I w + s x F,  F = N (n - mu V / sqrt(V'V + creep^2))
        N = k d + c d' >= 0 where d = -(z + n.s) > 0,  V = (1 - n n')(v + w x s)
    """
    require(creep > 0, f"friction has no direction at rest: give creep above 0, not {creep}")
    D = [r * r for r in radii]

    def rate(_: float, y: np.ndarray) -> list[float]:
        n, w, v, z = y[:3].tolist(), y[3:6].tolist(), y[6:9].tolist(), float(y[9])
        h = sum(D[i] * n[i] * n[i] for i in range(3)) ** 0.5
        s = [-D[i] * n[i] / h - com[i] for i in range(3)]
        turn, carried = cross(w, s), cross(w, v)
        slip, depth = [v[i] + turn[i] for i in range(3)], -(z + dot(n, s))
        fall = dot(n, slip)
        slip = [slip[i] - fall * n[i] for i in range(3)]
        N = max(0.0, k * depth - c * fall) if depth > 0 else 0.0
        share = mu / (dot(slip, slip) + creep * creep) ** 0.5
        F = [N * (n[i] - share * slip[i]) for i in range(3)]
        spin, moment = cross(w, [I[i] * w[i] for i in range(3)]), cross(s, F)
        w_dot = [(moment[i] - spin[i]) / I[i] for i in range(3)]
        return [*cross(n, w), *w_dot, *(F[i] / m - g * n[i] - carried[i] for i in range(3)), dot(n, v)]

    return motion(rate, np.array([*n, *w, *v, height]), times, 1e-11)
