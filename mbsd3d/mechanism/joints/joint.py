"""Base classes of joints: two bodies, points and axes (world coordinates at the reference pose), rows, maybe an angle.

``at_b``, ``axis_b`` give the part on ``b`` as built, where that differs.
"""

from dataclasses import KW_ONLY
from functools import cached_property
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from ...base.checks import short_repr
from ...base.errors import InputError
from ...base.fields import Direction, DirectionOrDerived, Vector, VectorOrDerived, kept, part_class
from ...base.rotations import matched_perpendiculars, perpendiculars
from ...base.wording import with_article
from ..bodies import Body, Ground, Part, as_body_or_ground, describe_part
from ..motion_protocols import LoadedMotion, Motion
from ..primitives import Coordinate, Primitive, TurnRate, in_plane, perpendicular


@part_class()
class Joint(Part):
    """Base class of joints and drivers: two bodies, a name, rows, and optionally an angle or a slide.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Joint, Revolute
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> hinge = Revolute(GROUND, part, at=(0.1, 0.2, 0.3), axis=(1, 2, 2))
    >>> isinstance(hinge, Joint), [row.n_rows for row in hinge.rows()]  # coincide, two dots
    (True, [3, 1, 1])
    """

    role = "joint"

    if TYPE_CHECKING:

        @property
        def a(self) -> Body | Ground:
            """Return the first body."""

        @property
        def b(self) -> Body | Ground:
            """Return the body that carries the reaction."""

    def check(self, what: str) -> None:
        as_body_or_ground(self.a, f"{what}: a", self)
        as_body_or_ground(self.b, f"{what}: b", self)
        if self.a is self.b:
            raise InputError(f"{what}: joins '{self.a.name}' to itself; give two different bodies")

    def bodies(self) -> tuple[Body | Ground, ...]:
        """Return all bodies the joint acts on."""
        return self._bodies

    @cached_property
    def _bodies(self) -> tuple[Body | Ground, ...]:
        """Return `bodies`, collected once."""
        return tuple({id(body): body for row in self.primitives for body in row.bodies}.values())

    def rows(self) -> list[Primitive]:
        """Return the primitives of the joint."""
        raise NotImplementedError

    @cached_property
    def primitives(self) -> tuple[Primitive, ...]:
        """Return `rows`, made once."""
        return tuple(self.rows())

    def angle(self) -> Coordinate | None:
        """Return the angle of b relative to a about the joint's axis, if it has one."""
        return None

    def slide(self) -> Coordinate | None:
        """Return the displacement of b relative to a along the joint's axis, if it has one."""
        return None

    def reflected(self) -> list[tuple[Coordinate | TurnRate, float]]:
        """Return coordinates x of the joint with I [kg m^2 or kg] of their own kinetic energies I x_dot^2 / 2."""
        return []

    def point(self) -> np.ndarray:
        """Return the point of body b at which the reaction is given (world, reference pose)."""
        return self.b.position

    def reaction_points(self, solution: Motion) -> np.ndarray:
        """Return (samples, 3) world points at which the reaction is given: `point`, carried by body b."""
        return solution.body_point(self.b, self.point())

    def notes(self, solution: LoadedMotion) -> list[str]:
        """Return the notes that the certificate adds for this joint."""
        return []

    def held(self) -> "Joint":
        """Return the joint that the part stands for: itself, of a switched joint the one that it switches."""
        return self

    def partners(self) -> list["Joint"]:
        """Return the other joints that this one acts through; they must be in the system too."""
        return []


@part_class()
class PointJoint(Joint):
    """A joint at a point."""

    a: Body | Ground
    b: Body | Ground
    _: KW_ONLY
    at: Vector = kept()
    at_b: VectorOrDerived = kept(default=None, derived=attrgetter("at"))

    def point(self) -> np.ndarray:
        return self.at_b


@part_class()
class AxisJoint(PointJoint):
    """A joint at a point with an axis."""

    _: KW_ONLY
    axis: Direction = kept()
    axis_b: DirectionOrDerived = kept(default=None, derived=attrgetter("axis"))

    def angle(self) -> Coordinate | None:
        return self._angle

    @cached_property
    def _angle(self) -> Coordinate:
        """Return `angle`, made once."""
        return Coordinate("angle", self.a, self.b, self.axis, self.axis_b)

    def slide(self) -> Coordinate | None:
        return self._slide

    @cached_property
    def _slide(self) -> Coordinate:
        """Return `slide`, made once."""
        return Coordinate("slide", self.a, self.b, self.axis, self.axis_b, self.at, self.at_b)

    @cached_property
    def across(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the two directions in a across the axis."""
        return perpendiculars(self.axis)

    def parallel_rows(self) -> list[Primitive]:
        """Keep axis_b along axis_a (2 rows)."""
        return [perpendicular(self.a, self.b, x, self.axis_b) for x in self.across]

    def line_rows(self) -> list[Primitive]:
        """Keep the point of b on the axis in a (2 rows)."""
        return [in_plane(self.a, self.b, x, self.at, self.at_b) for x in self.across]

    def no_turn_row(self) -> Primitive:
        """Keep b from turning about the axis relative to a (1 row)."""
        x, _ = self.across
        _, y_b = matched_perpendiculars(self.axis, self.axis_b)
        return perpendicular(self.a, self.b, x, y_b)


def coordinate_of(part: Any, kind: str, what: str) -> Coordinate:
    """Return the angle or slide of a joint, or raise a ValueError that names both."""
    if not isinstance(part, Joint):
        raise InputError(f"{what}: {short_repr(part)} is not a joint; give the part itself")
    found: Coordinate | None = getattr(part, kind)()
    if found is None:
        example = "Revolute or Cylindrical" if kind == "angle" else "Prismatic or Cylindrical"
        raise InputError(
            f"{what}: {describe_part(part)} has no {kind}; give a joint that has one, e.g. {with_article(example)}"
        )
    return found


def angle_of(joint: Joint) -> Coordinate:
    """Return the angle of a joint that has one."""
    return coordinate_of(joint, "angle", "angle_of")


def slide_of(joint: Joint) -> Coordinate:
    """Return the slide of a joint that has one."""
    return coordinate_of(joint, "slide", "slide_of")
