"""Critical speeds and self-stable ranges of bicycles from their characteristic polynomial, without a grid of speeds.

    p = a s^4 + b v s^3 + c s^2 + d v s + e,   c, d and e linear in w = v^2      (see `bicycle.linear.characteristic`)

By Routh and Hurwitz, for a > 0 and v > 0, all motions decay if and only if b, c, d, e and ``h = b c d - a d^2 - b^2 e``
are positive. That can only change at the root of e (capsize, s = 0) or of h (weave, s = +-i omega): where c or d
reaches zero first, h = -a d^2 - b^2 e is negative already. Both are at most quadratic in w, so no range is too narrow
to be found. Speeds are forward; backwards the spectrum is the negative one, so no speed is stable both ways.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.polynomial.polynomial import polyder

from ..parameters import Parameters
from .characteristic import FASTEST, Array, DoubleRoot, Quartic, double_roots, quartic, value
from .equations import Canonical, canonical
from .general import Build, required_equations


class Range(NamedTuple):
    """Speeds [m/s] between which a bicycle is self-stable; ``high`` is infinite if nothing ends the range."""

    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.low:.6f} ... {self.high:.6f} m/s" if np.isfinite(self.high) else f"above {self.low:.6f} m/s"


def listed(ranges: Sequence[Range]) -> str:
    """Self-stable ranges as text."""
    return ", ".join(map(str, ranges)) or "at no speed"


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
        passed = np.where(oscillates & (value(polyder(h, axis=-1)[..., None, :], w) > 0.0), w, np.nan)
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


@dataclass(frozen=True)
class CriticalSpeeds:
    """The critical speeds of one bicycle [m/s], NaN where there is none.

    Above ``weave`` the weave no longer grows, ``weave_rate`` is its omega there [rad/s]; at ``capsize`` one eigenvalue
    is zero. At ``double_roots`` two real modes meet. In the ranges ``stable`` every motion decays.
    """

    weave: float
    capsize: float
    weave_rate: float
    double_roots: list[DoubleRoot]
    stable: list[Range]

    def __str__(self) -> str:
        weave = f"{self.weave:.12g} m/s, omega {self.weave_rate:.12g} rad/s"
        lines = [
            f"weave     {weave if self.weave > 0.0 else '-'}",
            f"capsize   {f'{self.capsize:.12g} m/s' if self.capsize > 0.0 else '-'}",
            *(f"two modes meet at {x.speed:.12g} m/s, {x.eigenvalue:.12g} 1/s" for x in self.double_roots),
            f"stable    {listed(self.stable)}",
        ]
        return "\n".join(lines)


def critical_speeds(parameters: Parameters, build: Build | None = None, *, speed: float = 5.0) -> CriticalSpeeds:
    """Weave, capsize and double-root speeds and all self-stable ranges, from the characteristic polynomial.

    Parameters
    ----------
    parameters : Parameters
    build : callable or None
        A model, e.g. `bicycle.whipple`; None = the closed form.
    speed : float
        At which the model is linearised [m/s]; see `bicycle.general.linear_equations`.

    Examples
    --------
    >>> from bicycle import Meijaard2007
    >>> round(critical_speeds(Meijaard2007()).weave, 9)
    4.292382536
    """
    return speeds_of(canonical(parameters) if build is None else required_equations(build, parameters, speed))


def speeds_of(linear: Canonical) -> CriticalSpeeds:
    """Critical speeds of linear equations."""
    q = quartic(linear.M, linear.C1, linear.g * linear.K0, linear.K2)
    v = weave(q)
    return CriticalSpeeds(float(v), float(capsize(q)), float(weave_rate(q, v)), double_roots(q), ranges(q))
