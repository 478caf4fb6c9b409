"""Taylor series of second order along a motion: their payload has any leading axes, an axis of 3 or 1 at the end."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Series:
    """Taylor series x(s) = x0 + x1 s + x2 s^2.

    Examples
    --------
    >>> s = Series(np.array([2.0]), np.array([1.0]), np.array([0.0]))
    >>> [float(x) for x in ((s * s).x1[0], (1.0 / s).x1[0])]
    [4.0, -0.25]
    """

    x0: Array
    x1: Array
    x2: Array

    def __add__(self, other: "Series | Array | float") -> "Series":
        other = series(other)
        return Series(self.x0 + other.x0, self.x1 + other.x1, self.x2 + other.x2)

    def __mul__(self, other: "Series | Array | float") -> "Series":
        return bilinear(np.multiply, self, other)

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self) -> "Series":
        return self * -1.0

    def __sub__(self, other: "Series | Array | float") -> "Series":
        return self + series(other) * -1.0

    def __rtruediv__(self, other: "Series | Array | float") -> "Series":
        y0 = 1.0 / self.x0
        y1 = -self.x1 * y0 * y0
        return Series(y0, y1, -(self.x2 * y0 + self.x1 * y1) * y0) * other

    def __truediv__(self, other: "Series") -> "Series":
        return other.__rtruediv__(self)


def series(x: Series | Array | float) -> Series:
    """Return a constant as a series; a series stays as it is."""
    return x if isinstance(x, Series) else Series(np.asarray(x, float), np.zeros(1), np.zeros(1))


def bilinear(function: Callable, a: Series | Array | float, b: Series | Array | float) -> Series:
    """Return the series of a bilinear product."""
    a, b = series(a), series(b)
    return Series(
        function(a.x0, b.x0),
        function(a.x0, b.x1) + function(a.x1, b.x0),
        function(a.x0, b.x2) + function(a.x1, b.x1) + function(a.x2, b.x0),
    )


def dot(a: Series, b: Series) -> Series:
    """Return the series of a . b."""
    return bilinear(lambda x, y: (x * y).sum(axis=-1, keepdims=True), a, b)


def cross(a: Series, b: Series) -> Series:
    """Return the series of a x b."""

    def product(x: Array, y: Array) -> Array:
        shape = np.broadcast_shapes(x.shape, y.shape, (3,))
        return np.cross(np.broadcast_to(x, shape), np.broadcast_to(y, shape))

    return bilinear(product, a, b)


def sqrt(a: Series) -> Series:
    """Return the series of a square root."""
    y0 = np.sqrt(a.x0)
    y1 = a.x1 / (2.0 * y0)
    return Series(y0, y1, (a.x2 - y1 * y1) / (2.0 * y0))


def arctan2(y: Series, x: Series) -> Series:
    """Return the series of the angle of (x, y): theta' = (x y' - y x') / (x^2 + y^2)."""
    n = x.x0**2 + y.x0**2
    turn = (x.x0 * y.x1 - y.x0 * x.x1) / n
    n1 = 2.0 * (x.x0 * x.x1 + y.x0 * y.x1)
    return Series(np.arctan2(y.x0, x.x0), turn, (x.x0 * y.x2 - y.x0 * x.x2) / n - 0.5 * turn * n1 / n)
