"""Bodies and parts of a planar mechanism in world coordinates at a reference pose, and functions of time."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from mbsd3d.errors import InputError
from mbsd3d.extend import number


@dataclass(frozen=True, eq=False)
class Motion:
    """Function of time f(t) = sum c_k t^k + amplitude sin(frequency t + phase), or a spline."""

    interval = (-np.inf, np.inf)
    """Where f is known [s]."""

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
        """Return the first and last time [s]."""
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


class Ground:
    """Frame at rest."""

    name, position, angle = "ground", np.zeros(2), 0.0

    def local(self, vector: np.ndarray) -> np.ndarray:
        """Return the vector unchanged: world axes are ground axes."""
        return np.asarray(vector, dtype=float)

    def local_point(self, point: np.ndarray) -> np.ndarray:
        """Return the point unchanged: world coordinates are ground coordinates [m]."""
        return np.asarray(point, dtype=float)


GROUND = Ground()


@dataclass(frozen=True, eq=False)
class Body:
    """Rigid body in the plane.

    ``mass, inertia``: [kg] > 0, and about the centre of mass [kg m^2] >= 0; 0, a point mass, only where joints keep its
    rate constant; ``com`` (2,): r_G, from the reference point O, body axes [m]; ``position, angle``: O (2,) [m] and the
    direction of the body's x axis [rad] at the reference pose, world; ``velocity, omega``: of O (2,) [m/s] and [rad/s]
    at t = 0; None = from the joints, with least kinetic energy. ValueError naming body, value and remedy.
    """

    name: str
    mass: float
    inertia: float
    com: Any = field(default=(0.0, 0.0), kw_only=True)
    position: Any = field(default=(0.0, 0.0), kw_only=True)
    angle: float = field(default=0.0, kw_only=True)
    velocity: Any = field(default=None, kw_only=True)
    omega: float | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        what = f"body '{self.name}'"
        values: dict[str, Any] = {"mass": number(self.mass, f"{what}: mass", positive=True)}
        values["inertia"] = number(self.inertia, f"{what}: inertia", minimum=0.0)
        values |= {name: pair(getattr(self, name), f"{what}: {name}") for name in ("com", "position")}
        values["angle"] = number(self.angle, f"{what}: angle")
        if self.velocity is not None:
            values["velocity"] = pair(self.velocity, f"{what}: velocity")
        if self.omega is not None:
            values["omega"] = number(self.omega, f"{what}: omega")
        for name, value in values.items():
            object.__setattr__(self, name, value)

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
    bodies: tuple
    values: tuple
    motion: Motion = NONE


@dataclass(frozen=True, eq=False)
class Part:
    """Joint or load: a unique name, and a check of its fields."""

    name: str | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        kind = type(self).__name__
        self.check(f"{kind} '{self.name}'" if self.name else f"{kind} without a name")

    def check(self, what: str) -> None:
        """Validate and convert the fields."""
        raise NotImplementedError

    def set(self, **values: Any) -> None:
        """Write converted values into the frozen fields."""
        for key, value in values.items():
            object.__setattr__(self, key, value)


def check_bodies(part: Any, what: str) -> None:
    """Check that a and b are two bodies."""
    for side in ("a", "b"):
        if not isinstance(getattr(part, side), Body | Ground):
            raise InputError(f"{what}: {side} = {getattr(part, side)!r} is not a planar body; give a Body or GROUND")
    if part.a is part.b:
        raise InputError(f"{what}: joins '{part.a.name}' to itself; give two different bodies")


def ends(part: Any, what: str, remedy: str) -> float:
    """Return the distance of the two end points of a part [m], which must not coincide."""
    part.set(at_a=pair(part.at_a, f"{what}: at_a"), at_b=pair(part.at_b, f"{what}: at_b"))
    span = float(np.hypot(*(part.at_b - part.at_a)))
    if span < 1e-12:
        raise InputError(f"{what}: the end points coincide, {remedy}")
    return span
