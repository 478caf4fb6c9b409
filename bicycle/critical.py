"""Critical speeds and self-stable ranges of bicycles from their linear equations, without a grid of speeds.

    M q'' + v C1 q' + (g K0 + v^2 K2) q = 0,   q = (lean, steer),   det(s^2 M + s v C1 + g K0 + v^2 K2) = p(s, v)
    p = a s^4 + b v s^3 + c s^2 + d v s + e,   a and b numbers, c, d and e linear in w = v^2

A leaned bicycle rolls straight on, so that the first column of K2 vanishes and with it the term of e in w^2. By Routh
and Hurwitz, for a > 0 and v > 0, all motions decay if and only if b, c, d, e and ``h = b c d - a d^2 - b^2 e`` are
positive. That can only change at the root of e (capsize, s = 0) or of h (weave, s = +-i omega): where c or d reaches
zero first, h = -a d^2 - b^2 e is negative already. Both are at most quadratic in w, so no range is too narrow to be
found. Arrays of bicycles are solved at once: matrices have shape (..., 2, 2), speeds (...).
"""

from typing import NamedTuple

import numpy as np

Array = np.ndarray
FASTEST = 1e5
"""[m/s] Critical speeds above are what rounding makes of none at all."""


class Quartic(NamedTuple):
    """Coefficients of p: a, b (...,) and c, d, e (..., 2) by rising powers of w."""

    a: Array
    b: Array
    c: Array
    d: Array
    e: Array

    @property
    def h(self) -> Array:
        """(..., 3) b c d - a d^2 - b^2 e by rising powers of w, without its factor w."""
        f, (d0, d1), (e0, e1) = self.b[..., None] * self.c - self.a[..., None] * self.d, ends(self.d), ends(self.e)
        (f0, f1), squared = ends(f), self.b**2
        return np.stack([f0 * d0 - squared * e0, f0 * d1 + f1 * d0 - squared * e1, f1 * d1], axis=-1)

    def at(self, s: Array, v: Array) -> Array:
        """p(s, v)."""
        c, d, e = (value(x, v * v) for x in (self.c, self.d, self.e))
        return (((self.a * s + self.b * v) * s + c) * s + d * v) * s + e


class Range(NamedTuple):
    """Speeds [m/s] between which a bicycle stays upright by itself; ``high`` is infinite if nothing ends it."""

    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.low:.6f} ... {self.high:.6f} m/s" if np.isfinite(self.high) else f"above {self.low:.6f} m/s"


def quartic(M: Array, C1: Array, K0: Array, K2: Array) -> Quartic:
    """The characteristic polynomial, complex for complex matrices (complex step).

    Parameters
    ----------
    M, C1, K0, K2 : (..., 2, 2) ndarray
        Of the linear equations, K0 multiplied by g; the first column of K2 is taken as zero.
    """
    M, C1, K0, K2 = np.broadcast_arrays(M, C1, K0, K2)
    c = np.stack([mixed(M, K0), mixed(M, K2) + mixed(C1, C1) / 2.0], axis=-1)
    d = np.stack([mixed(C1, K0), mixed(C1, K2)], axis=-1)
    e = np.stack([mixed(K0, K0) / 2.0, mixed(K0, K2)], axis=-1)
    return Quartic(mixed(M, M) / 2.0, mixed(M, C1), c, d, e)


def mixed(A: Array, B: Array) -> Array:
    """What stands at x y in det(x A + y B); for A = B twice the determinant."""
    straight = A[..., 0, 0] * B[..., 1, 1] + B[..., 0, 0] * A[..., 1, 1]
    return straight - A[..., 0, 1] * B[..., 1, 0] - B[..., 0, 1] * A[..., 1, 0]


def ends(x: Array) -> tuple[Array, Array]:
    """x[..., 0] and x[..., 1]."""
    return x[..., 0], x[..., 1]


def value(x: Array, w: Array) -> Array:
    """A polynomial with rising coefficients (..., k) at w (...)."""
    result = x[..., -1]
    for k in range(x.shape[-1] - 2, -1, -1):
        result = result * w + x[..., k]
    return result


def slope(x: Array, w: Array) -> Array:
    """Its derivative by w."""
    return value(x[..., 1:] * np.arange(1, x.shape[-1]), w)


def roots(x: Array) -> Array:
    """(..., 2) real roots of x0 + x1 w + x2 w^2, NaN where there is none; without loss where x2 is small or zero."""
    x0, x1, x2 = np.moveaxis(x, -1, 0)
    with np.errstate(all="ignore"):
        larger = -(x1 + np.copysign(np.sqrt(x1 * x1 - 4.0 * x0 * x2), x1)) / 2.0
        found = np.stack([larger / x2, x0 / larger], -1)
    return np.where(np.isfinite(found), found, np.nan)


def speeds(w: Array) -> Array:
    """[m/s] for w = v^2, NaN where w is not positive or beyond all speeds."""
    with np.errstate(invalid="ignore"):
        return np.sqrt(np.where((w > 0.0) & (w < FASTEST**2), w, np.nan))


def weave(q: Quartic) -> Array:
    """(...) speed [m/s] above which weave no longer grows: h = 0, rising, with omega^2 = d / b > 0; NaN for none."""
    h = q.h
    w = roots(h)
    with np.errstate(all="ignore"):
        oscillates = value(q.d[..., None, :], w) / q.b[..., None] > 0.0
        passed = np.where(oscillates & (slope(h[..., None, :], w) > 0.0), w, np.nan)
    return speeds(np.fmax(passed[..., 0], passed[..., 1]))  # h is quadratic: it rises through one root at most


def weave_rate(q: Quartic, v: Array) -> Array:
    """omega [rad/s] of the weave that neither grows nor decays at the speed v."""
    return np.sqrt(value(q.d, v * v) / q.b)


def capsize(q: Quartic) -> Array:
    """(...) speed [m/s] at which one root is zero: e = 0; NaN for none."""
    with np.errstate(all="ignore"):
        return speeds(-q.e[..., 0] / q.e[..., 1])


def intervals(q: Quartic) -> tuple[Array, Array]:
    """(..., 5) speeds 0 <= v1 <= ... <= inf, NaN for none, and (..., 4) whether it is stable between them."""
    inner = np.sort(np.concatenate([speeds(roots(q.h)), capsize(q)[..., None]], -1), axis=-1)  # NaN go to the end
    edges = np.concatenate([np.zeros_like(inner[..., :1]), inner, np.full_like(inner[..., :1], np.nan)], -1)
    last = np.isnan(edges[..., 1:]) & ~np.isnan(edges[..., :-1])
    edges[..., 1:][last] = np.inf
    with np.errstate(invalid="ignore"):
        middle = np.where(last, 2.0 * edges[..., :-1] + 1.0, (edges[..., :-1] + edges[..., 1:]) / 2.0)
    return edges, decays(q, middle)


def decays(q: Quartic, v: Array) -> Array:
    """Whether all motions decay at the speeds v (..., k) > 0; False where v is NaN."""
    w = v * v
    with np.errstate(invalid="ignore"):
        signs = [value(x[..., None, :], w) > 0.0 for x in (q.c, q.d, q.e, q.h)]
    return np.logical_and.reduce([*signs, (q.b > 0.0)[..., None] & np.ones_like(signs[0])])


def ranges(q: Quartic) -> list[Range]:
    """All self-stable ranges of one bicycle, by rising speed."""
    edges, stable = intervals(q)
    return [Range(float(low), float(high)) for low, high in zip(edges[:-1][stable], edges[1:][stable], strict=True)]


def first_range(q: Quartic) -> tuple[Array, Array]:
    """(low, high) [m/s] (...) of the self-stable range at the lowest speeds; NaN where there is none."""
    edges, stable = intervals(q)
    k = np.argmax(stable, axis=-1)[..., None]
    ends = (np.take_along_axis(edges, k + i, -1)[..., 0] for i in (0, 1))
    low, high = (np.where(stable.any(-1), x, np.nan) for x in ends)
    return low, high


def difference(first: list[Range], second: list[Range]) -> float:
    """Largest difference between the ends of two lists of ranges [m/s]; infinite if they are not equally many."""
    if len(first) != len(second):
        return float("inf")
    ends = zip(np.ravel(first), np.ravel(second), strict=True)
    return max((float(abs(x - y)) for x, y in ends if x != y), default=0.0)  # two infinite ends are equal


def typical_speed(found: list[Range]) -> float:
    """The middle of the first range [m/s], at most 1 m/s above its beginning; 5 m/s if there is none."""
    return min((found[0].low + found[0].high) / 2.0, found[0].low + 1.0) if found else 5.0
