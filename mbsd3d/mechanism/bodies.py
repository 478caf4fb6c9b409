"""Bodies: frozen descriptions of rigid parts at one reference pose, in world coordinates."""

from collections.abc import Sequence
from dataclasses import KW_ONLY
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import check_name, short_repr, vector
from ..base.errors import InputError, checks_method_arguments
from ..base.fields import (
    Checked,
    Frozen,
    Inertia,
    Number,
    Orientation,
    Truth,
    Vector,
    VectorOrNone,
    kept,
    part_class,
)
from ..base.rotations import matrix
from .shapes.homogeneous import ShapeOfBody


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
        """Return the point unchanged: the axes of the ground are the world axes."""
        return np.asarray(point, float)

    def local_axis(self, axis: np.ndarray) -> np.ndarray:
        """Return the axis unchanged: the axes of the ground are the world axes."""
        return vector(axis, "local_axis: axis")


GROUND = Ground()


@checks_method_arguments
@part_class(repr=False)
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
    inertia_as_given : bool
        Take moments that break the triangle rule: no body has them, but if none is negative the motion is defined, and
        models of other programs have them.

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
    mass: Number = kept(minimum=0.0)
    inertia: Inertia = kept()
    _: KW_ONLY
    com: Vector = kept(default=(0.0, 0.0, 0.0))
    position: Vector = kept(default=(0.0, 0.0, 0.0))
    orientation: Orientation = kept(default=(1.0, 0.0, 0.0, 0.0))
    velocity: VectorOrNone = kept(default=None)
    omega: VectorOrNone = kept(default=None)
    shape: ShapeOfBody = kept(default=None)
    inertia_as_given: Truth = kept(default=False)

    def what(self) -> str:
        check_name(self.name, "body")
        return f"body '{self.name}'"

    def __repr__(self) -> str:
        return f"Body('{self.name}', mass={self.mass:g})"

    @cached_property
    def axes(self) -> np.ndarray:
        """Return R at the reference pose (3, 3), body -> world; read-only."""
        R = matrix(self.orientation)
        R.setflags(write=False)
        return R

    @cached_property
    def centre(self) -> np.ndarray:
        """Return the centre of mass r + R r_G at the reference pose, world [m]; read-only."""
        centre = self.position + self.axes @ self.com
        centre.setflags(write=False)
        return centre

    def local_point(self, point: ArrayLike) -> np.ndarray:
        """Return R'(p - r): a world point at the reference pose in body axes from O [m]."""
        return self.axes.T @ (vector(point, "local_point: point") - self.position)

    def local_axis(self, axis: np.ndarray) -> np.ndarray:
        """Return R'a: a world direction at the reference pose in body axes."""
        return self.axes.T @ vector(axis, "local_axis: axis")


@part_class()
class Part(Checked):
    """Base class of joints and force elements: a name, and fields that are checked and converted once."""

    _: KW_ONLY
    name: str | None = None

    role: ClassVar[str] = "part"

    def bodies(self) -> Sequence[Body | Ground]:
        """Return the bodies the part acts on."""
        raise NotImplementedError

    def partners(self) -> Sequence["Part"]:
        """Return joints and forces the part refers to; they must be in the system too."""
        return ()

    def what(self) -> str:
        kind = type(self).__name__
        if self.name is None:
            return f"{kind} without a name"
        check_name(self.name, kind)
        return f"{self.role} '{self.name}' ({kind})"


def as_body(value: Any, what: str, part: Any) -> Body:
    """Accept a body."""
    if not isinstance(value, Body):
        raise InputError(f"{what} = {short_repr(value)} is not a body; give a Body")
    return value


def as_body_or_ground(value: Any, what: str, part: Any) -> Body | Ground:
    """Accept a body or the ground."""
    if not isinstance(value, (Body, Ground)):
        raise InputError(f"{what} = {short_repr(value)} is not a body; give a Body or GROUND")
    return value


def describe_part(part: Body | Part) -> str:
    """Return the type and name of a part, as error messages quote them."""
    return f"{type(part).__name__} '{part.name}'" if part.name else f"a {type(part).__name__} without a name"
