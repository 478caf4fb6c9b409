"""Bodies: frozen descriptions of rigid parts at one reference pose, in world coordinates."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import Frozen, check_name, number, vector
from ..base.errors import explaining_methods
from ..base.mass_properties import check_inertia
from ..base.rotations import as_quaternion, matrix
from .shapes.homogeneous import as_shape


class Ground:
    """The fixed frame; its axes are the world axes."""

    name = "ground"
    position = np.zeros(3)
    com = np.zeros(3)
    centre = np.zeros(3)
    orientation = np.array([1.0, 0.0, 0.0, 0.0])

    def __repr__(self) -> str:
        return "GROUND"

    def __reduce__(self) -> str:
        return "GROUND"

    def local_point(self, point: ArrayLike) -> np.ndarray:
        """The point itself: ground axes are world axes."""
        return np.asarray(point, float)

    def local_axis(self, axis: np.ndarray) -> np.ndarray:
        """The axis itself."""
        return vector(axis, "local_axis: axis")


GROUND = Ground()


@explaining_methods
@dataclass(frozen=True, eq=False, repr=False)
class Body(Frozen):
    """A rigid body at the reference pose.

    Parameters
    ----------
    name : str
        Unique in its system; results can be asked for by name.
    mass : float
        [kg] >= 0; 0 is legal where the constraints still determine the motion.
    inertia : (3,) or (3, 3) array_like
        About the centre of mass, body axes [kg m^2]; principal moments obey the triangle rule.
    com : (3,) array_like
        r_G, centre of mass from the reference point O, body axes [m].
    position : (3,) array_like
        Reference point O at the reference pose, world [m].
    orientation : (4,) or (3, 3) array_like
        Unit quaternion (e0, e1, e2, e3), scalar first, body -> world, or a rotation matrix; see `rotation`.
    velocity, omega : (3,) array_like or None
        Velocity of O [m/s] and angular velocity [rad/s] at the start, world axes; None = solved from the constraints
        with least kinetic energy.
    shape : Shape, list of Shape, str or (k, 3) array_like, optional
        How the body is drawn: one or more of `mbsd3d.shapes`; "ellipsoid", "box" or "cylinder", the homogeneous solid
        with its mass and inertia; a polyline in body axes from O [m]. None = the ellipsoid. Only drawn: mass and
        inertia are as given.

    Raises
    ------
    ValueError
        Naming the body, the value and the remedy.

    Examples
    --------
    >>> Body("top", mass=15.0, inertia=(0.234375, 0.46875, 0.234375), position=(0, 1, 0)).mass
    15.0
    """

    name: str
    mass: float
    inertia: ArrayLike
    com: ArrayLike = field(default=(0.0, 0.0, 0.0), kw_only=True)
    position: ArrayLike = field(default=(0.0, 0.0, 0.0), kw_only=True)
    orientation: ArrayLike = field(default=(1.0, 0.0, 0.0, 0.0), kw_only=True)
    velocity: ArrayLike | None = field(default=None, kw_only=True)
    omega: ArrayLike | None = field(default=None, kw_only=True)
    shape: Any = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        check_name(self.name, "body")
        what = f"body '{self.name}'"
        mass = number(self.mass, f"{what}: mass", minimum=0.0)
        self._store(
            mass=mass,
            inertia=check_inertia(self.inertia, mass, what),
            com=vector(self.com, f"{what}: com"),
            position=vector(self.position, f"{what}: position"),
            velocity=None if self.velocity is None else vector(self.velocity, f"{what}: velocity"),
            omega=None if self.omega is None else vector(self.omega, f"{what}: omega"),
            orientation=as_quaternion(self.orientation, f"{what}: orientation"),
        )
        self._store(shape=as_shape(self))

    def __repr__(self) -> str:
        return f"Body('{self.name}', mass={self.mass:g})"

    @cached_property
    def axes(self) -> np.ndarray:
        """R at the reference pose, body -> world; read-only."""
        R = matrix(self.orientation)
        R.setflags(write=False)
        return R

    @cached_property
    def centre(self) -> np.ndarray:
        """Centre of mass r + R r_G at the reference pose, world [m]; read-only."""
        centre = self.position + self.axes @ self.com
        centre.setflags(write=False)
        return centre

    def local_point(self, point: ArrayLike) -> np.ndarray:
        """R'(p - r): a world point at the reference pose in body axes from O [m]."""
        return self.axes.T @ (vector(point, "local_point: point") - self.position)

    def local_axis(self, axis: np.ndarray) -> np.ndarray:
        """R' a: a world direction at the reference pose in body axes."""
        return self.axes.T @ vector(axis, "local_axis: axis")


@dataclass(frozen=True, eq=False)
class Part(Frozen):
    """Base class of joints and force elements: a name, and fields that are checked and converted once."""

    name: str | None = field(default=None, kw_only=True)

    role: ClassVar[str] = "part"

    def __post_init__(self) -> None:
        kind = type(self).__name__
        if self.name is not None:
            check_name(self.name, kind)
        self.check(f"{self.role} '{self.name}' ({kind})" if self.name else f"{kind} without a name")

    set = Frozen._store

    def check(self, what: str) -> None:
        """Validate and convert the fields; errors start with ``what``."""
        raise NotImplementedError


def called(part: Body | Part) -> str:
    """A part by its type and name, for messages."""
    return f"{type(part).__name__} '{part.name}'" if part.name else f"a {type(part).__name__} without a name"
