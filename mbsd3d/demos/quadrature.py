"""Integrals and equations of theory: oscillations between two turning points, own equations of motion."""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from ..base.errors import InputError

QUADRATURE_POINTS_MAX = 2**17  # [1] points of a quadrature


def swing(square: Callable, low: float, high: float, *values: Callable) -> list[float]:
    """Return the time from one turning point to the other [s], and integrals of functions of x over that time.

    x_dot^2 = square(x) > 0 between its simple roots low and high. With x = middle + half sin u both ends are smooth,
    and the midpoint rule converges exponentially: points are doubled until nothing changes.
    """

    def sums(points: int) -> np.ndarray:
        u = np.pi * ((np.arange(points) + 0.5) / points - 0.5)
        x = 0.5 * (low + high) + 0.5 * (high - low) * np.sin(u)
        dt = np.pi / points * 0.5 * (high - low) * np.cos(u) / np.sqrt(square(x))
        return np.array([dt.sum(), *(dt @ value(x) for value in values)])

    points, found, change = 100, sums(100), np.inf
    while points < QUADRATURE_POINTS_MAX:
        points *= 2
        finer = sums(points)
        last, change = change, np.max(abs(finer - found) / (abs(finer).max() * 1e-3 + abs(finer)))
        if change > 0.3 * last and change < 1e-9:  # down to rounding, which more points only make worse
            break
        found = finer
    return found.tolist()


def turning_point(square: Callable, inside: float, step: float, limit: float) -> float:
    """Return the first root of square(x) from a place where it is positive, searched in steps up to a limit."""
    x = inside
    while abs(x - inside) < limit:
        if square(x + step) <= 0.0:
            return float(brentq(square, x, x + step, xtol=1e-15, rtol=1e-15))
        x += step
    raise InputError("the motion does not turn back, so it is no swing: give a smaller kick")


def motion(rate: Callable, y: np.ndarray, times: np.ndarray, rtol: float = 3e-14) -> np.ndarray:
    """Integrate y_dot = rate(t, y) by scipy at a tolerance near rounding; times[0] is the start; shape (times, n).

    An InputError where the end does not lie after it, or where no step is small enough.
    """
    if not times[-1] > times[0]:
        raise InputError(f"the motion ends at {times[-1]:g} s, which is not after its start; give a later time")
    if not np.isfinite(rate(times[0], y)).all():
        raise InputError("the equations of the theory have no finite rates at the start; stay nearer to the defaults")
    found = solve_ivp(rate, (times[0], times[-1]), y, method="DOP853", rtol=rtol, atol=rtol / 30, t_eval=times)
    if not found.success:
        raise InputError("the equations of the theory end before the motion does; stay nearer to the defaults")
    return found.y.T


def quaternion_rate(e: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Return the rate of a unit quaternion (scalar first, body -> world) for an angular velocity w in body axes."""
    e0, e1, e2, e3 = e
    p, q, r = w
    return 0.5 * np.array(
        [-e1 * p - e2 * q - e3 * r, e0 * p + e2 * r - e3 * q, e0 * q + e3 * p - e1 * r, e0 * r + e1 * q - e2 * p]
    )


def cross(a: Sequence[float], b: Sequence[float]) -> tuple[float, float, float]:
    """Return a x b of plain numbers."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def dot(a: Sequence[float], b: Sequence[float]) -> float:
    """Return a . b of plain numbers."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
