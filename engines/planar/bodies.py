"""Bodies and parts of a planar mechanism in world coordinates at a reference pose, and functions of time."""

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from mbsd3d.errors import InputError
from mbsd3d.extend import Checked, Number, NumberOrNone, Stored, kept, number, part_class


@dataclass(frozen=True, eq=False)
class Motion:
    """Function of time f(t) = sum c_k t^k + amplitude sin(frequency t + phase), or a spline."""

    @property
    def interval(self) -> tuple[float, float]:
        """Return the first and the last time at which f is known [s]."""
        return -np.inf, np.inf

    def numbers(self) -> tuple:
        """Return the nine numbers of f: c_0 ... c_5, amplitude, frequency [rad/s], phase [rad]."""
        raise NotImplementedError

    def pieces(self) -> np.ndarray:
        """Return the pieces of a spline: start [s] and c_0 ... c_3 of the time since then, shape (pieces, 5)."""
        return np.empty((0, 5))

    def steady(self) -> bool:
        """Return whether f_ddot is zero for all times."""
        return not any(self.numbers()[2:7]) and not self.pieces()[:, 3:].any()


@dataclass(frozen=True, eq=False)
class Polynomial(Motion):
    """Polynomial c_0 + c_1 t + ... of degree 5 at most; a constant rate w is ``Polynomial((0, w))``."""

    coefficients: tuple

    def __post_init__(self) -> None:
        if not 0 < len(self.coefficients) <= 6:
            raise InputError(f"Polynomial: {len(self.coefficients)} coefficients; give 1 to 6")
        values = tuple(number(c, f"Polynomial: c_{k}") for k, c in enumerate(self.coefficients))
        object.__setattr__(self, "coefficients", values)

    def numbers(self) -> tuple:
        return (*self.coefficients, *(0.0,) * (6 - len(self.coefficients)), 0.0, 0.0, 0.0)


def rate(speed: float) -> Polynomial:
    """Return a motion of constant rate, ``speed t`` [rad/s or m/s]."""
    return Polynomial((0.0, speed))


@dataclass(frozen=True, eq=False)
class Sine(Motion):
    """Sine function amplitude sin(frequency t + phase), frequency in rad/s."""

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
            raise InputError(
                f"Table: times {times.shape}, values {values.shape}; give two rows of four numbers or more"
            )
        if not (np.isfinite(values).all() and np.isfinite(times).all() and (np.diff(times) > 0).all()):
            raise InputError("Table: times do not increase or a number is not finite; sort the points, leave such out")
        for name, array in (("times", times), ("values", values)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @property
    def interval(self) -> tuple[float, float]:
        return float(self.times[0]), float(self.times[-1])

    def numbers(self) -> tuple:
        return (0.0,) * 9

    def pieces(self) -> np.ndarray:
        return np.column_stack([self.times[:-1], CubicSpline(self.times, self.values).c[::-1].T])


NONE, UNIT = Polynomial((0.0,)), Polynomial((1.0,))


def pair(value: ArrayLike, what: str) -> np.ndarray:
    """Return a finite (2,) array; raise ValueError that names ``what`` for others."""
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != (2,) or not np.isfinite(array).all():
        raise InputError(f"{what}: {value!r} is not a pair of finite numbers; give (x, y)")
    array.setflags(write=False)
    return array


def direction(value: ArrayLike, what: str) -> np.ndarray:
    """Return a (2,) unit vector; raise ValueError that names ``what`` for others."""
    array = pair(value, what)
    length = np.hypot(*array)
    if length < 1e-12:
        raise InputError(f"{what} has zero length; give a direction")
    return array / length


class Pair(Stored[ArrayLike, np.ndarray]):
    """Two finite numbers, of the plane."""

    @staticmethod
    def convert(value: ArrayLike, what: str, part: object) -> np.ndarray:
        """Return a finite (2,) array."""
        return pair(value, what)


class PairOrNone(Stored[ArrayLike | None, np.ndarray | None]):
    """Two finite numbers, or None."""

    @staticmethod
    def convert(value: ArrayLike | None, what: str, part: object) -> np.ndarray | None:
        """Return a finite (2,) array, or None."""
        return None if value is None else pair(value, what)


class PairOrDerived(Stored[ArrayLike | None, np.ndarray]):
    """Two finite numbers; None = what follows from other fields."""

    @staticmethod
    def convert(value: ArrayLike, what: str, part: object) -> np.ndarray:
        """Return a finite (2,) array."""
        return pair(value, what)


class Direction(Stored[ArrayLike, np.ndarray]):
    """Direction in the plane, kept as a unit vector."""

    @staticmethod
    def convert(value: ArrayLike, what: str, part: object) -> np.ndarray:
        """Return a (2,) unit vector."""
        return direction(value, what)


class Ground:
    """Frame at rest."""

    name, position, com, angle = "ground", np.zeros(2), np.zeros(2), 0.0

    def local(self, vector: np.ndarray) -> np.ndarray:
        """Return the vector unchanged: world axes are ground axes."""
        return np.asarray(vector, dtype=float)

    def local_point(self, point: np.ndarray) -> np.ndarray:
        """Return the point unchanged: world coordinates are ground coordinates [m]."""
        return np.asarray(point, dtype=float)


GROUND = Ground()


@part_class()
class Body(Checked):
    """Rigid body in the plane.

    ``mass, inertia``: [kg] > 0, and about the centre of mass [kg m^2] >= 0; 0, a point mass, only where joints keep its
    rate constant; ``com`` (2,): r_G, from the reference point O, body axes [m]; ``position, angle``: O (2,) [m] and the
    direction of the body's x axis [rad] at the reference pose, world; ``velocity, omega``: of O (2,) [m/s] and [rad/s]
    at t = 0; None = from the joints, with least kinetic energy. ValueError naming body, value and remedy.
    """

    name: str
    mass: Number = kept(positive=True)
    inertia: Number = kept(minimum=0.0)
    _: KW_ONLY
    com: Pair = kept(default=(0.0, 0.0))
    position: Pair = kept(default=(0.0, 0.0))
    angle: Number = kept(default=0.0)
    velocity: PairOrNone = kept(default=None)
    omega: NumberOrNone = kept(default=None)

    def what(self) -> str:
        """Return the name of the body, at the start of errors."""
        return f"body '{self.name}'"

    def local(self, vector: np.ndarray) -> np.ndarray:
        """Return R' of a world direction at the reference pose."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        return np.array([[c, s], [-s, c]]) @ vector

    def local_point(self, point: np.ndarray) -> np.ndarray:
        """Return a world point at the reference pose, from O in body axes [m]."""
        return self.local(np.asarray(point, dtype=float) - self.position)


@dataclass(frozen=True, eq=False)
class Row:
    """Data of a constraint: kind, bodies (body b second), up to eight numbers, motion; COINCIDE counts two rows."""

    kind: int
    bodies: tuple[Body | Ground, ...]
    values: tuple[float, ...]
    motion: Motion = NONE


class Member(Stored[Body | Ground, Body | Ground]):
    """Body on which a part acts, or the ground."""

    @staticmethod
    def convert(value: object, what: str, part: object) -> Body | Ground:
        """Return the body itself; raise ValueError for what is none."""
        if not isinstance(value, Body | Ground):
            raise InputError(f"{what} = {value!r} is not a planar body; give a Body or GROUND")
        return value


@part_class()
class Part(Checked):
    """Joint or load with a unique name."""

    _: KW_ONLY
    name: str | None = None

    def what(self) -> str:
        """Return kind and name of the part, at the start of errors."""
        return f"{type(self).__name__} '{self.name}'" if self.name else f"{type(self).__name__} without a name"


@part_class()
class Between(Part):
    """Part that acts between two bodies."""

    a: Member = kept()
    b: Member = kept()

    def check(self, what: str) -> None:
        """Check that the two bodies differ."""
        if self.a is self.b:
            raise InputError(f"{what}: joins '{self.a.name}' to itself; give two different bodies")


@part_class()
class TwoPoint(Between):
    """Part that acts between a point of a and a point of b, world at the reference pose [m]."""

    _: KW_ONLY
    at_a: Pair = kept()
    at_b: Pair = kept()

    coincident: ClassVar[str]
    """What is wrong where the points coincide, and the remedy."""

    @property
    def span(self) -> float:
        """Return the distance of the two points at the reference pose [m]."""
        return float(np.hypot(*(self.at_b - self.at_a)))

    def check(self, what: str) -> None:
        """Check that bodies and points differ."""
        super().check(what)
        if self.span < 1e-12:
            raise InputError(f"{what}: the end points coincide, {self.coincident}")

    def ends(self) -> tuple[np.ndarray, np.ndarray]:
        """Return both points in the axes of their bodies [m]."""
        return self.a.local_point(self.at_a), self.b.local_point(self.at_b)
