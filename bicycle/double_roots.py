"""Speeds at which two modes of a bicycle meet, from the discriminant of its characteristic polynomial."""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial

from .critical import FASTEST, Quartic


class DoubleRoot(NamedTuple):
    """Two real modes meet at a speed [m/s]: ``eigenvalue`` [1/s] counts twice there."""

    speed: float
    eigenvalue: float


def discriminant(q: Quartic) -> Polynomial:
    """Of p(s, v) as a polynomial in s; a polynomial in w = v^2, since v stands in b v and d v only."""
    w = Polynomial([0.0, 1.0])
    a, b, c, d, e = q.a, q.b, *(Polynomial(x) for x in (q.c, q.d, q.e))
    bb, bd, dd = b * b * w, b * d * w, d * d * w
    return (
        256 * a**3 * e**3 - 192 * a**2 * bd * e**2 - 128 * a**2 * c**2 * e**2 + 144 * a**2 * c * dd * e
        - 27 * a**2 * dd**2 + 144 * a * bb * c * e**2 - 6 * a * bb * dd * e - 80 * a * bd * c**2 * e
        + 18 * a * bd * c * dd + 16 * a * c**4 * e - 4 * a * c**3 * dd - 27 * bb**2 * e**2
        + 18 * bb * bd * c * e - 4 * bb * bd * dd - 4 * bb * c**3 * e + bb * c**2 * dd
    )  # fmt: skip


def double_roots(q: Quartic) -> list[DoubleRoot]:
    """All speeds > 0 at which two real modes meet, rising.

    The roots of the discriminant are only starts: it is of high degree. Newton solves p = 0, dp/ds = 0 for (s, v).

    Parameters
    ----------
    q : Quartic
        Of one bicycle.

    Returns
    -------
    list of DoubleRoot
    """
    scale = float(np.sqrt(abs(q.c[0] / (q.c[1] or 1.0)))) or 1.0  # of speeds, so that powers stay of one size
    scaled = discriminant(q._replace(b=q.b * scale, c=grown(q.c, scale), d=grown(q.d, scale) * scale,
                                     e=grown(q.e, scale)))  # fmt: skip
    found = []
    for w in scaled.trim().roots():  # what rounding leaves of higher powers adds starts only
        if 0.0 < w.real < (FASTEST / scale) ** 2 and abs(w.imag) < 1e-4 * abs(w):
            found += [x for x in [meeting(q, scale * np.sqrt(w.real))] if x]
    distinct = []
    for x in sorted(found):
        if not distinct or x.speed - distinct[-1].speed > 1e-9 * x.speed:
            distinct.append(x)
    return distinct


def grown(x: np.ndarray, scale: float) -> np.ndarray:
    """Coefficients in w / scale^2."""
    return x * scale ** (2.0 * np.arange(x.size))


def polynomial(q: Quartic, v: float) -> Polynomial:
    """p(s, v) in s."""
    c, d, e = (x[0] + x[1] * v * v for x in (q.c, q.d, q.e))
    return Polynomial([e, d * v, c, q.b * v, q.a])


def meeting(q: Quartic, v: float) -> DoubleRoot | None:
    """Newton from a speed nearby to a real double root; None if it leads nowhere."""
    p = polynomial(q, v)
    s = min(p.deriv().roots(), key=lambda s: abs(p(s))).real
    for _ in range(30):
        p = polynomial(q, v)
        slope, bend = p.deriv(), p.deriv(2)
        by_v = Polynomial([2 * v * q.e[1], q.d[0] + 3 * v * v * q.d[1], 2 * v * q.c[1], q.b])
        J = np.array([[slope(s), by_v(s)], [bend(s), by_v.deriv()(s)]])
        try:
            step = np.linalg.solve(J, [-p(s), -slope(s)])
        except np.linalg.LinAlgError:
            return None
        s, v = s + step[0], v + step[1]
        if np.abs(step / [abs(s) + 1e-300, abs(v) + 1e-300]).max() < 1e-15:
            break
    terms = np.abs(polynomial(q, v).coef) @ np.abs(s) ** np.arange(5)
    return DoubleRoot(float(v), float(s)) if v > 0.0 and abs(polynomial(q, v)(s)) < 1e-12 * terms else None
