"""Single conditions between two bodies: a point on a line, a distance, a direction."""

import math
from dataclasses import KW_ONLY
from operator import attrgetter
from typing import Any

import numpy as np

from ...base.errors import InputError
from ...base.fields import Direction, DirectionOrDerived, NumberOrDerived, Vector, kept, locked, part_class
from ...base.rotations import PERPENDICULAR_TOLERANCE, make_perpendicular, perpendiculars, unit
from ...kernels import kinds
from ..bodies import Body, Ground
from ..primitives import Coordinate, Primitive, coincide, in_plane, perpendicular
from .joint import AxisJoint, Joint, PointJoint


class PointOnLine(AxisJoint):
    """A point of b slides on a line fixed in a (2 rows).

    >>> from mbsd3d import GROUND, Body, PointOnLine
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> sum(row.n_rows for row in PointOnLine(GROUND, part, at=(0.1, 0.2, 0.3), axis=(1, 2, 2)).rows())
    2
    """

    def rows(self) -> list[Primitive]:
        return self.line_rows()

    def angle(self) -> None:
        return None


@part_class()
class PointOnPlane(PointJoint):
    """A point of b moves in a plane fixed in a (1 row).

    >>> from mbsd3d import GROUND, Body, PointOnPlane
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> sum(row.n_rows for row in PointOnPlane(GROUND, part, at=(0.1, 0.2, 0.3), normal=(1, 2, 2)).rows())
    1
    """

    _: KW_ONLY
    normal: Direction = kept()

    def rows(self) -> list[Primitive]:
        return [in_plane(self.a, self.b, self.normal, self.at, self.at_b)]


ENDS_GAP_MIN = 1e-12  # [m] between end points, so that their line has a direction


def span(part: Any) -> float:
    """Distance between the end points ``at_a`` and ``at_b`` of a part [m]."""
    d = part.at_b - part.at_a
    return math.sqrt(d.dot(d))


def ends_coincide(part: Any) -> bool:
    """Return whether the end points of a part are too close for a direction."""
    return span(part) < ENDS_GAP_MIN


@part_class()
class Distance(Joint):
    """A massless rod between a point of a and a point of b keeps their distance (1 row).

    >>> from mbsd3d import GROUND, Body, Distance
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> round(Distance(GROUND, part, at_a=(0, 0, 0), at_b=(0.3, 0.0, 0.4)).length, 12)
    0.5
    """

    a: Body | Ground
    b: Body | Ground
    _: KW_ONLY
    at_a: Vector = kept()
    at_b: Vector = kept()
    length: NumberOrDerived = kept(default=None, positive=True, derived=span)

    def check(self, what: str) -> None:
        super().check(what)
        if ends_coincide(self):
            raise InputError(f"{what}: the end points coincide, so the rod has no direction; use Spherical or move one")

    def point(self) -> np.ndarray:
        return self.at_b

    def rows(self) -> list[Primitive]:
        return [Primitive(kinds.DISTANCE, (self.a, self.b), points=(self.at_a, self.at_b), values=(self.length,))]


@part_class()
class Parallel(Joint):
    """An axis of b stays parallel to an axis of a (2 rows).

    >>> from mbsd3d import GROUND, Body, Parallel
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> sum(row.n_rows for row in Parallel(GROUND, part, axis=(1, 2, 2)).rows())
    2
    """

    a: Body | Ground
    b: Body | Ground
    _: KW_ONLY
    axis: Direction = kept()
    axis_b: DirectionOrDerived = kept(default=None, derived=attrgetter("axis"))

    def rows(self) -> list[Primitive]:
        return [perpendicular(self.a, self.b, x, self.axis_b) for x in perpendiculars(self.axis)]

    def angle(self) -> Coordinate:
        return Coordinate("angle", self.a, self.b, self.axis, self.axis_b)


def square_to_axis_a(value: Any, what: str, part: Any) -> np.ndarray:
    """The second axis, squared to the first one."""
    x, y = part.axis_a, unit(value, what)
    if abs(x @ y) > PERPENDICULAR_TOLERANCE:
        angle = np.degrees(np.arccos(x @ y))
        raise InputError(f"{what.removesuffix(': axis_b')}: the axes enclose {angle:.6g} degrees; give 90 degrees")
    return locked(make_perpendicular(x, y))


@part_class()
class Perpendicular(Joint):
    """``axis_b`` of b stays perpendicular to ``axis_a`` of a (1 row), squared if off by up to 1e-6.

    >>> from mbsd3d import GROUND, Body, Perpendicular
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> sum(row.n_rows for row in Perpendicular(GROUND, part, axis_a=(1, 2, 2), axis_b=(2, 1, -2)).rows())
    1
    """

    a: Body | Ground
    b: Body | Ground
    _: KW_ONLY
    axis_a: Direction = kept()
    axis_b: Direction = kept(by=square_to_axis_a)

    def rows(self) -> list[Primitive]:
        return [perpendicular(self.a, self.b, self.axis_a, self.axis_b)]


@part_class()
class ConstantVelocity(PointJoint):
    """Constant-velocity joint between shafts along ``axis_a`` and ``axis_b``: no turn about their bisector (4 rows).

    With n the common normal of the shafts: x_a . y_b - y_a . x_b = 0 for x = n, y = axis x n on both sides.

    >>> from mbsd3d import GROUND, Body, ConstantVelocity
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> joint = ConstantVelocity(GROUND, part, at=(0, 0, 0), axis_a=(1, 0, 0), axis_b=(0.8, 0.6, 0))
    >>> sum(row.n_rows for row in joint.rows())
    4
    """

    _: KW_ONLY
    axis_a: Direction = kept()
    axis_b: Direction = kept()

    def check(self, what: str) -> None:
        super().check(what)
        if self.axis_a @ self.axis_b < 1e-6:
            raise InputError(f"{what}: axis_a and axis_b enclose 90 degrees or more; point both along the power flow")

    def rows(self) -> list[Primitive]:
        normal = np.cross(self.axis_a, self.axis_b)
        bend = np.linalg.norm(normal)
        n = normal / bend if bend > 1e-9 else perpendiculars(self.axis_a)[0]
        y_a, y_b = np.cross(self.axis_a, n), np.cross(self.axis_b, n)
        turn = Primitive(kinds.DOT_DIFFERENCE, (self.a, self.b), axes=(n, n), second_axes=(y_a, y_b), in_metres=False)
        return [coincide(self.a, self.b, self.at, self.at_b), turn]
