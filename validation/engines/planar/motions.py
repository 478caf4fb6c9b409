"""Functions of time for planar drivers and loads."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from mbsd3d.extend import number


@dataclass(frozen=True, eq=False)
class Motion:
    """f(t) = sum c_k t^k + amplitude sin(frequency t + phase), or a spline."""

    interval = (-np.inf, np.inf)
    """Where f is known [s]."""

    def numbers(self) -> tuple:
        """The nine numbers of f: c_0 ... c_5, amplitude, frequency [rad/s], phase [rad]."""
        raise NotImplementedError

    def pieces(self) -> np.ndarray:
        """(pieces, 5) of a spline: start [s] and c_0 ... c_3 of the time since then."""
        return np.empty((0, 5))

    def steady(self) -> bool:
        """Whether f_ddot is zero for all times."""
        return not any(self.numbers()[2:7]) and not self.pieces()[:, 3:].any()


@dataclass(frozen=True, eq=False)
class Polynomial(Motion):
    """c_0 + c_1 t + ... of degree 5 at most; a constant rate w is ``Polynomial((0, w))``."""

    coefficients: tuple

    def __post_init__(self) -> None:
        if not 0 < len(self.coefficients) <= 6:
            raise ValueError(f"Polynomial: {len(self.coefficients)} coefficients; give 1 to 6")
        values = tuple(number(c, f"Polynomial: c_{k}") for k, c in enumerate(self.coefficients))
        object.__setattr__(self, "coefficients", values)

    def numbers(self) -> tuple:
        return (*self.coefficients, *(0.0,) * (6 - len(self.coefficients)), 0.0, 0.0, 0.0)


def rate(speed: float) -> Polynomial:
    """A constant rate, ``speed t`` [rad/s or m/s]."""
    return Polynomial((0.0, speed))


@dataclass(frozen=True, eq=False)
class Sine(Motion):
    """amplitude sin(frequency t + phase), frequency in rad/s."""

    amplitude: float
    frequency: float
    phase: float = 0.0

    def __post_init__(self) -> None:
        for name in ("amplitude", "frequency", "phase"):
            object.__setattr__(self, name, number(getattr(self, name), f"Sine: {name}"))

    def numbers(self) -> tuple:
        return (*(0.0,) * 6, self.amplitude, self.frequency, self.phase)


@dataclass(frozen=True, eq=False)
class Table(Motion):
    """Cubic spline through values at times [s], four at least, not-a-knot at its ends."""

    times: Any
    values: Any

    def __post_init__(self) -> None:
        times, values = np.array(self.times, dtype=float), np.array(self.values, dtype=float)
        if times.ndim != 1 or times.size < 4 or values.shape != times.shape:
            raise ValueError(
                f"Table: times {times.shape}, values {values.shape}; give two rows of four numbers or more"
            )
        if not (np.isfinite(values).all() and np.isfinite(times).all() and (np.diff(times) > 0).all()):
            raise ValueError("Table: times do not increase or a number is not finite; sort the points, leave such out")
        for name, array in (("times", times), ("values", values)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @property
    def interval(self) -> tuple[float, float]:
        """First and last time [s]."""
        return float(self.times[0]), float(self.times[-1])

    def numbers(self) -> tuple:
        return (0.0,) * 9

    def pieces(self) -> np.ndarray:
        return np.column_stack([self.times[:-1], CubicSpline(self.times, self.values).c[::-1].T])


NONE, UNIT = Polynomial((0.0,)), Polynomial((1.0,))
