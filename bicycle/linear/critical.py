"""Critical speeds and self-stable ranges of bicycles from their characteristic polynomial, without a grid of speeds.

    M q'' + v C1 q' + (g K0 + v^2 K2) q = 0,   q = (lean, steer),   det(s^2 M + s v C1 + g K0 + v^2 K2) = p(s, v)
    p = a s^4 + b v s^3 + c s^2 + d v s + e,   a and b numbers, c, d and e linear in w = v^2

A leaned bicycle rolls straight on, so the first column of K2 vanishes and with it the term of e in w^2. By Routh and
Hurwitz, for a > 0 and v > 0, all motions decay if and only if b, c, d, e and ``h = b c d - a d^2 - b^2 e`` are
positive. That can only change at the root of e (capsize, s = 0) or of h (weave, s = +-i omega): where c or d reaches
zero first, h = -a d^2 - b^2 e is negative already. Both are at most quadratic in w, so no range is too narrow to be
found. Speeds are forward; backwards the spectrum is the negative one, so no speed is stable both ways.

Arrays of bicycles are handled at once: matrices have shape (..., 2, 2), speeds (...).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.polynomial import polyder, polyval

from mbsd3d.errors import InputError
from mbsd3d.extend import Result

from ..model.mechanism import whipple
from ..parameters import Parameters
from .equations import Canonical, canonical
from .general import Build, required_equations

Array = np.ndarray
SPEED_MAX = 1e5  # [m/s] higher speeds are rounding: there is no such root
ZERO_INERTIA_RATIO = 1e-13
"""Of the steer, relative to all mass at the wheelbase: rounding leaves 1e-16, a point mass 1 mm off the axis 1e-7."""


def value(x: Array, w: Array | complex) -> Array:
    """Evaluate polynomials with rising coefficients x (..., k) at w (...)."""
    return polyval(w, np.moveaxis(x, -1, 0), tensor=False)


class Quartic(NamedTuple):
    """Coefficients of p: a, b (...,) and c, d, e (..., 2) by rising powers of w."""

    a: Array
    b: Array
    c: Array
    d: Array
    e: Array

    @property
    def h(self) -> Array:
        """Return b c d - a d^2 - b^2 e by rising powers of w, without its factor w, shape (..., 3)."""
        f = self.b[..., None] * self.c - self.a[..., None] * self.d
        (f0, f1), (d0, d1), (e0, e1) = (np.moveaxis(x, -1, 0) for x in (f, self.d, self.b[..., None] ** 2 * self.e))
        return np.stack([f0 * d0 - e0, f0 * d1 + f1 * d0 - e1, f1 * d1], axis=-1)

    def at(self, v: Array | complex) -> Array:
        """Return p at the speed v, by rising powers of s, shape (..., 5)."""
        c, d, e = (value(x, v * v) for x in (self.c, self.d, self.e))
        return np.stack(np.broadcast_arrays(e, d * v, c, self.b * v, self.a), axis=-1)


def quartic(M: Array, C1: Array, K0: Array, K2: Array) -> Quartic:
    """Return p for matrices (..., 2, 2), real or complex; K0 is multiplied by g, the first column of K2 is taken as
    zero.
    """
    M, C1, K0, K2 = np.broadcast_arrays(M, C1, K0, K2)
    c = np.stack([mixed(M, K0), mixed(M, K2) + mixed(C1, C1) / 2.0], axis=-1)
    d = np.stack([mixed(C1, K0), mixed(C1, K2)], axis=-1)
    e = np.stack([mixed(K0, K0) / 2.0, mixed(K0, K2)], axis=-1)
    return Quartic(mixed(M, M) / 2.0, mixed(M, C1), c, d, e)


def mixed(A: Array, B: Array) -> Array:
    """Return the coefficient of x y in det(x A + y B); for A = B twice the determinant."""
    straight = A[..., 0, 0] * B[..., 1, 1] + B[..., 0, 0] * A[..., 1, 1]
    return straight - A[..., 0, 1] * B[..., 1, 0] - B[..., 0, 1] * A[..., 1, 0]


def polynomial(parameters: Parameters | SimpleNamespace) -> Quartic:
    """Return p of a bicycle with knife-edge wheels, in closed form; numbers may be arrays (...) or complex.

    Raises
    ------
    ValueError
        For round tyres, or where no mass resists lean or steer.
    """
    found = canonical(parameters)
    q = quartic(found.M, found.C1, np.asarray(found.g)[..., None, None] * found.K0, found.K2)
    masses = parameters.mR + parameters.mB + parameters.mH + parameters.mF
    if not np.all(np.real(q.a) > ZERO_INERTIA_RATIO * np.real(found.M[..., 0, 0] * masses * parameters.w**2)):
        raise InputError(
            f"bicycle '{getattr(parameters, 'name', '')}': lean or steer has no inertia, so there are fewer than two "
            "freedoms; give masses off the ground and off the steer axis"
        )
    return q


def model_polynomial(parameters: Parameters, build: Build = whipple, *, check: bool = True) -> Quartic:
    """Return p from the general model, also with round tyres; see `bicycle.general.linear_equations`."""
    linear = required_equations(build, parameters, check=check)
    return quartic(linear.M, linear.C1, linear.K0, linear.K2)


class DoubleRoot(NamedTuple):
    """Speed [m/s] at which two real modes meet: ``eigenvalue`` [1/s] counts twice there."""

    speed: float
    eigenvalue: float


def double_roots(q: Quartic) -> list[DoubleRoot]:
    """Return all speeds > 0 at which two real modes of one bicycle meet, rising.

    The roots of the discriminant are only starts: it is of high degree. Newton solves p = 0, dp/ds = 0 for (s, v).
    """
    unit = float(np.sqrt(abs(q.c[0] / (q.c[1] or 1.0)))) or 1.0  # of speeds, so that powers stay of one size
    found = []
    for w in (
        discriminant(q, unit).trim().roots().astype(complex)
    ):  # what rounding leaves of higher powers adds starts only
        if 0.0 < w.real < (SPEED_MAX / unit) ** 2 and abs(w.imag) < 1e-4 * abs(w):
            found += [x for x in [meeting(q, unit * np.sqrt(w.real))] if x]
    found.sort()
    return [x for k, x in enumerate(found) if not k or x.speed - found[k - 1].speed > 1e-9 * x.speed]


def discriminant(q: Quartic, unit: float) -> Polynomial:
    """Return the discriminant of p(s), a polynomial in (v / unit)^2: odd powers of v enter by b v and d v only."""
    w = Polynomial([0.0, unit**2])
    a, b, c, d, e = q.a, q.b, *(x[0] + x[1] * w for x in (q.c, q.d, q.e))
    bb, bd, dd = b * b * w, b * d * w, d * d * w
    return (
        256 * a**3 * e**3 - 192 * a**2 * bd * e**2 - 128 * a**2 * c**2 * e**2 + 144 * a**2 * c * dd * e
        - 27 * a**2 * dd**2 + 144 * a * bb * c * e**2 - 6 * a * bb * dd * e - 80 * a * bd * c**2 * e
        + 18 * a * bd * c * dd + 16 * a * c**4 * e - 4 * a * c**3 * dd - 27 * bb**2 * e**2
        + 18 * bb * bd * c * e - 4 * bb * bd * dd - 4 * bb * c**3 * e + bb * c**2 * dd
    )  # fmt: skip


def meeting(q: Quartic, v: float) -> DoubleRoot | None:
    """Return a real double root by Newton from a speed nearby; None if the iteration leads nowhere."""
    p = Polynomial(q.at(v))
    s = min(p.deriv().roots(), key=lambda s: abs(p(s))).real
    for _ in range(30):
        p = Polynomial(q.at(v))
        slope, bend = p.deriv(), p.deriv(2)
        by_v = Polynomial([2 * v * q.e[1], q.d[0] + 3 * v * v * q.d[1], 2 * v * q.c[1], q.b])
        J = np.array([[slope(s), by_v(s)], [bend(s), by_v.deriv()(s)]])
        try:
            step = np.linalg.solve(J, np.array([-p(s), -slope(s)], dtype=float))
        except np.linalg.LinAlgError:
            return None
        s, v = s + step[0], v + step[1]
        if np.abs(step / [abs(s) + 1e-300, abs(v) + 1e-300]).max() < 1e-15:
            break
    p = Polynomial(q.at(v))
    terms = np.abs(p.coef) @ np.abs(s) ** np.arange(5)
    return DoubleRoot(float(v), float(s)) if v > 0.0 and abs(p(s)) < 1e-12 * terms else None


class Range(NamedTuple):
    """Speeds [m/s] between which a bicycle is self-stable; ``high`` is infinite if nothing ends the range."""

    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.low:.6f} ... {self.high:.6f} m/s" if np.isfinite(self.high) else f"above {self.low:.6f} m/s"


def listed(ranges: Sequence[Range]) -> str:
    """Return self-stable ranges as text."""
    return ", ".join(map(str, ranges)) or "at no speed"


def roots(x: Array) -> Array:
    """Return the real roots of x0 + x1 w + x2 w^2, NaN where complex, without cancellation for small x2, shape (...,
    2).
    """
    x0, x1, x2 = np.moveaxis(x, -1, 0)
    with np.errstate(all="ignore"):
        larger = -(x1 + np.copysign(np.sqrt(x1 * x1 - 4.0 * x0 * x2), x1)) / 2.0
        found = np.stack([larger / x2, x0 / larger], -1)
    return np.where(np.isfinite(found), found, np.nan)


def speeds(w: Array) -> Array:
    """Return the speeds [m/s] of w = v^2, NaN where w is not positive or too large for a speed."""
    with np.errstate(invalid="ignore"):
        return np.sqrt(np.where((w > 0.0) & (w < SPEED_MAX**2), w, np.nan))


def weave(q: Quartic) -> Array:
    """Return the speed [m/s] above which weave no longer grows: h = 0, rising, with omega^2 = d / b > 0; NaN for
    none."""
    h = q.h
    w = roots(h)
    with np.errstate(all="ignore"):
        oscillates = value(q.d[..., None, :], w) / q.b[..., None] > 0.0
        passed = np.where(oscillates & (value(polyder(h, axis=-1)[..., None, :], w) > 0.0), w, np.nan)
    return speeds(np.fmax(passed[..., 0], passed[..., 1]))  # h is quadratic: it rises through one root at most


def weave_rate(q: Quartic, v: Array) -> Array:
    """Return omega [rad/s] of the weave that neither grows nor decays at the speed v."""
    return np.sqrt(value(q.d, v * v) / q.b)


def capsize(q: Quartic) -> Array:
    """Return the speed [m/s] at which one root is zero: e = 0; NaN for none."""
    with np.errstate(all="ignore"):
        return speeds(-q.e[..., 0] / q.e[..., 1])


def intervals(q: Quartic) -> tuple[Array, Array]:
    """Return speeds 0 <= v1 <= ... <= inf (..., 5), NaN for none, and whether the bicycle is stable between them (...,
    4).
    """
    inner = np.sort(np.concatenate([speeds(roots(q.h)), capsize(q)[..., None]], -1), axis=-1)  # NaN go to the end
    edges = np.concatenate([np.zeros_like(inner[..., :1]), inner, np.full_like(inner[..., :1], np.nan)], -1)
    last = np.isnan(edges[..., 1:]) & ~np.isnan(edges[..., :-1])
    edges[..., 1:][last] = np.inf
    with np.errstate(invalid="ignore"):
        middle = np.where(last, 2.0 * edges[..., :-1] + 1.0, (edges[..., :-1] + edges[..., 1:]) / 2.0)
    return edges, decays(q, middle)


def decays(q: Quartic, v: Array) -> Array:
    """Return whether all motions decay at the speeds v (..., k) > 0; False where v is NaN."""
    w = v * v
    with np.errstate(invalid="ignore"):
        signs = [value(x[..., None, :], w) > 0.0 for x in (q.c, q.d, q.e, q.h)]
    return np.logical_and.reduce(signs)  # h = b (c d - b e) - a d^2 is positive with c, d and e only where b is


def ranges(q: Quartic) -> list[Range]:
    """Return all self-stable ranges of one bicycle, by rising speed."""
    return ranges_between(*intervals(q))


def ranges_between(edges: Array, stable: Array) -> list[Range]:
    """Return the self-stable ranges of one bicycle from its `intervals`."""
    return [Range(float(low), float(high)) for low, high in zip(edges[:-1][stable], edges[1:][stable], strict=True)]


def first_range(q: Quartic) -> tuple[Array, Array]:
    """Return (low, high) [m/s] (...) of the self-stable range at the lowest speeds; NaN if no speed is stable."""
    return first_between(*intervals(q))


def first_between(edges: Array, stable: Array) -> tuple[Array, Array]:
    """Return (low, high) [m/s] (...) of the first self-stable range of `intervals`; NaN for none."""
    k = np.argmax(stable, axis=-1)[..., None]
    low, high = (np.take_along_axis(edges, k + i, -1)[..., 0] for i in (0, 1))
    some = stable.any(-1)
    return np.where(some, low, np.nan), np.where(some, high, np.nan)


def difference(first: list[Range], second: list[Range]) -> float:
    """Return the largest difference between the ends of two lists of ranges [m/s]; infinite for lists of different
    length.
    """
    if len(first) != len(second):
        return float("inf")
    ends = zip(np.ravel(first), np.ravel(second), strict=True)
    return max((float(abs(x - y)) for x, y in ends if x != y), default=0.0)  # two infinite ends are equal


def typical_speed(found: list[Range]) -> float:
    """Return the middle of the first range [m/s], at most 1 m/s above its beginning; 5 m/s without a range."""
    return min((found[0].low + found[0].high) / 2.0, found[0].low + 1.0) if found else 5.0


@dataclass(frozen=True, repr=False)
class CriticalSpeeds(Result):
    """Critical speeds of one bicycle [m/s], NaN for those it does not have.

    Above ``weave`` the weave no longer grows, ``weave_rate`` is its omega there [rad/s]; at ``capsize`` one eigenvalue
    is zero. At ``double_roots`` two real modes meet. In the ranges ``stable`` every motion decays.
    """

    weave: float
    capsize: float
    weave_rate: float
    double_roots: list[DoubleRoot]
    stable: list[Range]

    def __str__(self) -> str:
        weave = f"{self.weave:.12g} m/s, omega {self.weave_rate:.12g} rad/s" if self.weave > 0.0 else "-"
        capsize = f"{self.capsize:.12g} m/s" if self.capsize > 0.0 else "-"
        meet = [f"two modes meet at {x.speed:.12g} m/s, {x.eigenvalue:.12g} 1/s" for x in self.double_roots]
        return "\n".join([f"weave     {weave}", f"capsize   {capsize}", *meet, f"stable    {listed(self.stable)}"])


def critical_speeds(parameters: Parameters, build: Build | None = None, *, speed: float = 5.0) -> CriticalSpeeds:
    """Compute weave, capsize and double-root speeds and all self-stable ranges, from the characteristic polynomial.

    Parameters
    ----------
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
    """Return the critical speeds of linear equations."""
    q = quartic(linear.M, linear.C1, linear.g * linear.K0, linear.K2)
    v = weave(q)
    return CriticalSpeeds(float(v), float(capsize(q)), float(weave_rate(q, v)), double_roots(q), ranges(q))
