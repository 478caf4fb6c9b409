"""Base classes of joints: two bodies, points and axes (world coordinates at the reference pose), rows, maybe an angle.

``at_b``, ``axis_b`` give the part on ``b`` as built, where that differs.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import shown, vector
from ...base.directions import matched_perpendiculars, perpendiculars, unit
from ...base.errors import InputError
from ..bodies import Body, Ground, Part, called
from ..motion import LoadedMotion, Motion
from ..primitives import Coordinate, Primitive, in_plane, perpendicular


@dataclass(frozen=True, eq=False)
class Joint(Part):
    """Base class of joints and drivers: two bodies, a name, rows, and perhaps an angle or a slide.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Joint, Revolute
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> hinge = Revolute(GROUND, part, at=(0.1, 0.2, 0.3), axis=(1, 2, 2))
    >>> isinstance(hinge, Joint), [row.n_rows for row in hinge.rows()]  # coincide, two dots
    (True, [3, 1, 1])
    """

    role = "joint"

    def check(self, what: str) -> None:
        """Validate and convert the fields; errors start with ``what``."""
        for side in ("a", "b"):
            if not isinstance(getattr(self, side), Body | Ground):
                raise InputError(f"{what}: {side} = {shown(getattr(self, side))} is not a body; give a Body or GROUND")
        if self.a is self.b:
            raise InputError(f"{what}: joins '{self.a.name}' to itself; give two different bodies")

    def bodies(self) -> list:
        """All bodies the joint acts on."""
        return list({id(body): body for row in self.primitives for body in row.bodies}.values())

    def rows(self) -> list[Primitive]:
        """The primitives of the joint."""
        raise NotImplementedError

    @cached_property
    def primitives(self) -> tuple[Primitive, ...]:
        """`rows`, made once: whoever asks a joint that is part of a system reads these."""
        return tuple(self.rows())

    def angle(self) -> Coordinate | None:
        """The angle of b relative to a about the joint's axis, if it has one."""
        return None

    def slide(self) -> Coordinate | None:
        """The displacement of b relative to a along the joint's axis, if it has one."""
        return None

    def point(self) -> np.ndarray:
        """Point of body b at which the reaction is given (world, reference pose)."""
        return self.b.position

    def reaction_points(self, solution: Motion) -> np.ndarray:
        """(samples, 3) world points at which the reaction is given: `point`, carried by body b."""
        return solution.body_point(self.b, self.point())

    def notes(self, solution: LoadedMotion) -> list[str]:
        """What the certificate says of the joint besides."""
        return []

    def partners(self) -> list["Joint"]:
        """Other joints that this one acts through; they must be in the system too."""
        return []


@dataclass(frozen=True, eq=False)
class PointJoint(Joint):
    """A joint at a point."""

    a: Body | Ground
    b: Body | Ground
    at: ArrayLike = field(kw_only=True)
    at_b: ArrayLike | None = field(default=None, kw_only=True)

    def check(self, what: str) -> None:
        super().check(what)
        at = vector(self.at, f"{what}: at")
        self.set(at=at, at_b=at if self.at_b is None else vector(self.at_b, f"{what}: at_b"))

    def point(self) -> np.ndarray:
        return self.at_b


@dataclass(frozen=True, eq=False)
class AxisJoint(PointJoint):
    """A joint at a point with an axis."""

    axis: ArrayLike = field(kw_only=True)
    axis_b: ArrayLike | None = field(default=None, kw_only=True)

    def check(self, what: str) -> None:
        super().check(what)
        axis = unit(self.axis, f"{what}: axis")
        self.set(axis=axis, axis_b=axis if self.axis_b is None else unit(self.axis_b, f"{what}: axis_b"))

    def angle(self) -> Coordinate:
        return Coordinate("angle", self.a, self.b, self.axis, self.axis_b)

    def slide(self) -> Coordinate:
        return Coordinate("slide", self.a, self.b, self.axis, self.axis_b, self.at, self.at_b)

    @cached_property
    def across(self) -> tuple[np.ndarray, np.ndarray]:
        """Two directions in a across the axis."""
        return perpendiculars(self.axis)

    def parallel_rows(self) -> list[Primitive]:
        """axis_b stays along axis_a (2 rows)."""
        return [perpendicular(self.a, self.b, x, self.axis_b) for x in self.across]

    def line_rows(self) -> list[Primitive]:
        """The point of b stays on the axis in a (2 rows)."""
        return [in_plane(self.a, self.b, x, self.at, self.at_b) for x in self.across]

    def no_turn_row(self) -> Primitive:
        """No rotation of b about the axis relative to a (1 row)."""
        x, _ = self.across
        _, y_b = matched_perpendiculars(self.axis, self.axis_b)
        return perpendicular(self.a, self.b, x, y_b)


def coordinate_of(part: Any, kind: str, what: str) -> Coordinate:
    """The angle or slide of a joint, or a ValueError that names both."""
    if not isinstance(part, Joint):
        raise InputError(f"{what}: {shown(part)} is not a joint; give the part itself")
    found = getattr(part, kind)()
    if found is None:
        example = "Revolute or Cylindrical" if kind == "angle" else "Prismatic or Cylindrical"
        raise InputError(f"{what}: {called(part)} has no {kind}; give a joint that has one, e.g. a {example}")
    return found
