"""The words of a planar mechanism: bodies and parts, in world coordinates at a reference pose."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mbsd3d.extend import number

from .motions import NONE, Motion


def pair(value: ArrayLike, what: str) -> np.ndarray:
    """A finite (2,) array, or a ValueError that names ``what``."""
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != (2,) or not np.isfinite(array).all():
        raise ValueError(f"{what}: {value!r} is not a pair of finite numbers; give (x, y)")
    array.setflags(write=False)
    return array


def direction(value: ArrayLike, what: str) -> np.ndarray:
    """A (2,) unit vector, or a ValueError that names ``what``."""
    array = pair(value, what)
    length = np.hypot(*array)
    if length < 1e-12:
        raise ValueError(f"{what} has zero length; give a direction")
    return array / length


class Ground:
    """The frame at rest."""

    name, position, angle = "ground", np.zeros(2), 0.0

    def local(self, vector: np.ndarray) -> np.ndarray:
        """World axes are ground axes."""
        return np.asarray(vector, dtype=float)

    def local_point(self, point: np.ndarray) -> np.ndarray:
        """World coordinates are ground coordinates."""
        return np.asarray(point, dtype=float)


GROUND = Ground()


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body in the plane.

    Parameters
    ----------
    name : str
    mass, inertia : float
        [kg] > 0, and about the centre of mass [kg m^2] >= 0; 0, a point mass, only where joints keep its rate constant.
    com : (2,) array_like
        r_G, from the reference point O, body axes [m].
    position, angle
        O (2,) [m] and the direction of the body's x axis [rad] at the reference pose, world.
    velocity, omega
        Of O (2,) [m/s] and [rad/s] at t = 0; None = from the joints, with least kinetic energy.

    Raises
    ------
    ValueError
        Naming body, value and remedy.
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
        """R' of a world direction at the reference pose."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        return np.array([[c, s], [-s, c]]) @ vector

    def local_point(self, point: np.ndarray) -> np.ndarray:
        """A world point at the reference pose, from O in body axes [m]."""
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
    """A joint or a load: a name of its own, and a check of its fields."""

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
    """a and b are two bodies."""
    for side in ("a", "b"):
        if not isinstance(getattr(part, side), Body | Ground):
            raise ValueError(f"{what}: {side} = {getattr(part, side)!r} is not a planar body; give a Body or GROUND")
    if part.a is part.b:
        raise ValueError(f"{what}: joins '{part.a.name}' to itself; give two different bodies")
