"""Joints: data that lowers to rows of a few primitives. A new joint is one class here.

Every joint connects body ``a`` to body ``b``; points and axes are in world coordinates at the reference pose.
``at_b``, ``axis_b`` say where the part on ``b`` really is, where it was built differently.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ..base.checks import number, vector
from ..base.directions import cross, matched_perpendiculars, perpendiculars, unit
from ..kernels import kinds
from .bodies import Body, Ground, Part
from .primitives import Coordinate, Primitive, coincide, in_plane, perpendicular, ratio


@dataclass(frozen=True, eq=False)
class Joint(Part):
    """What all joints and drivers share: two bodies, a name, rows, and perhaps an angle or a slide.

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
                raise ValueError(f"{what}: {side} = {getattr(self, side)!r} is not a body; give a Body or GROUND")
        if self.a is self.b:
            raise ValueError(f"{what}: joins '{self.a.name}' to itself; give two different bodies")

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

    def reaction_points(self, solution: Any) -> np.ndarray:
        """(samples, 3) world points at which the reaction is given: `point`, carried by body b."""
        return solution.body_point(self.b, self.point())

    def partners(self) -> list["Joint"]:
        """Other joints that this one acts through; they must be in the system too."""
        return []


@dataclass(frozen=True, eq=False)
class PointJoint(Joint):
    """A joint at a point."""

    a: Any
    b: Any
    at: Any = field(kw_only=True)
    at_b: Any = field(default=None, kw_only=True)

    def check(self, what: str) -> None:
        super().check(what)
        at = vector(self.at, f"{what}: at")
        self.set(at=at, at_b=at if self.at_b is None else vector(self.at_b, f"{what}: at_b"))

    def point(self) -> np.ndarray:
        return self.at_b


@dataclass(frozen=True, eq=False)
class AxisJoint(PointJoint):
    """A joint at a point with an axis."""

    axis: Any = field(kw_only=True)
    axis_b: Any = field(default=None, kw_only=True)

    def check(self, what: str) -> None:
        super().check(what)
        axis = unit(self.axis, f"{what}: axis")
        self.set(axis=axis, axis_b=axis if self.axis_b is None else unit(self.axis_b, f"{what}: axis_b"))

    def angle(self) -> Coordinate:
        return Coordinate("angle", self.a, self.b, self.axis, self.axis_b)

    def slide(self) -> Coordinate:
        return Coordinate("slide", self.a, self.b, self.axis, self.axis_b, self.at, self.at_b)

    def parallel_rows(self) -> list[Primitive]:
        """axis_b stays along axis_a (2 rows)."""
        return [perpendicular(self.a, self.b, x, self.axis_b) for x in perpendiculars(self.axis)]

    def line_rows(self) -> list[Primitive]:
        """The point of b stays on the axis in a (2 rows)."""
        return [in_plane(self.a, self.b, x, self.at, self.at_b) for x in perpendiculars(self.axis)]

    def no_turn_row(self) -> Primitive:
        """No rotation of b about the axis relative to a (1 row)."""
        x, _ = perpendiculars(self.axis)
        _, y_b = matched_perpendiculars(self.axis, self.axis_b)
        return perpendicular(self.a, self.b, x, y_b)


class Spherical(PointJoint):
    """The points coincide (3 rows).

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Spherical
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> sum(row.n_rows for row in Spherical(GROUND, part, at=(0.1, 0.2, 0.3)).rows())
    3
    """

    def rows(self) -> list[Primitive]:
        return [coincide(self.a, self.b, self.at, self.at_b)]


class Revolute(AxisJoint):
    """A hinge: the points coincide and the axes are parallel (5 rows).

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute
    >>> door = Body("door", mass=20.0, inertia=(8.0, 9.0, 1.0), position=(0.45, 0.0, 1.0))
    >>> sum(row.n_rows for row in Revolute(GROUND, door, at=(0, 0, 0), axis=(0, 0, 1)).rows())
    5
    """

    def rows(self) -> list[Primitive]:
        return [coincide(self.a, self.b, self.at, self.at_b), *self.parallel_rows()]

    def slide(self) -> None:
        return None


@dataclass(frozen=True, eq=False)
class Universal(PointJoint):
    """Cardan joint: the points coincide and ``axis_a`` of a stays perpendicular to ``axis_b`` of b (4 rows).

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Universal
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> cross = Universal(GROUND, part, at=(0.1, 0.2, 0.3), axis_a=(1, 2, 2), axis_b=(2, 1, -2))
    >>> sum(row.n_rows for row in cross.rows())
    4
    """

    axis_a: Any = field(kw_only=True)
    axis_b: Any = field(kw_only=True)

    def check(self, what: str) -> None:
        super().check(what)
        x, y = unit(self.axis_a, f"{what}: axis_a"), unit(self.axis_b, f"{what}: axis_b")
        if np.linalg.norm(cross(x, y)) < 1e-6:
            raise ValueError(f"{what}: axis_a and axis_b are parallel; a cross needs two perpendicular axes")
        if abs(x @ y) > 1e-6:
            angle = np.degrees(np.arccos(x @ y))
            raise ValueError(f"{what}: axis_a and axis_b enclose {angle:.6g} degrees; give perpendicular axes")
        self.set(axis_a=x, axis_b=y)

    def rows(self) -> list[Primitive]:
        return [coincide(self.a, self.b, self.at, self.at_b), perpendicular(self.a, self.b, self.axis_a, self.axis_b)]


class Prismatic(AxisJoint):
    """b slides along the axis without turning (5 rows).

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Prismatic
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> sum(row.n_rows for row in Prismatic(GROUND, part, at=(0.1, 0.2, 0.3), axis=(1, 2, 2)).rows())
    5
    """

    def rows(self) -> list[Primitive]:
        return [*self.line_rows(), *self.parallel_rows(), self.no_turn_row()]

    def angle(self) -> None:
        return None


class Cylindrical(AxisJoint):
    """b slides along the axis and turns about it (4 rows).

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Cylindrical
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> sum(row.n_rows for row in Cylindrical(GROUND, part, at=(0.1, 0.2, 0.3), axis=(1, 2, 2)).rows())
    4
    """

    def rows(self) -> list[Primitive]:
        return [*self.line_rows(), *self.parallel_rows()]


@dataclass(frozen=True, eq=False)
class Planar(PointJoint):
    """b moves in a plane fixed in a, turning about its normal only (3 rows).

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Planar
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> sum(row.n_rows for row in Planar(GROUND, part, at=(0.1, 0.2, 0.3), normal=(1, 2, 2)).rows())
    3
    """

    normal: Any = field(kw_only=True)

    def check(self, what: str) -> None:
        super().check(what)
        self.set(normal=unit(self.normal, f"{what}: normal"))

    def rows(self) -> list[Primitive]:
        flat = [perpendicular(self.a, self.b, x, self.normal) for x in perpendiculars(self.normal)]
        return [in_plane(self.a, self.b, self.normal, self.at, self.at_b), *flat]

    def angle(self) -> Coordinate:
        return Coordinate("angle", self.a, self.b, self.normal, self.normal)


class Fixed(PointJoint):
    """No relative motion (6 rows).

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Fixed
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> sum(row.n_rows for row in Fixed(GROUND, part, at=(0.1, 0.2, 0.3)).rows())
    6
    """

    def rows(self) -> list[Primitive]:
        x, y, z = np.eye(3)
        locks = [perpendicular(self.a, self.b, u, w) for u, w in ((x, y), (y, z), (z, x))]
        return [coincide(self.a, self.b, self.at, self.at_b), *locks]


class PointOnLine(AxisJoint):
    """A point of b slides on a line fixed in a (2 rows).

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, PointOnLine
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> sum(row.n_rows for row in PointOnLine(GROUND, part, at=(0.1, 0.2, 0.3), axis=(1, 2, 2)).rows())
    2
    """

    def rows(self) -> list[Primitive]:
        return self.line_rows()

    def angle(self) -> None:
        return None


@dataclass(frozen=True, eq=False)
class PointOnPlane(PointJoint):
    """A point of b moves in a plane fixed in a (1 row).

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, PointOnPlane
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> sum(row.n_rows for row in PointOnPlane(GROUND, part, at=(0.1, 0.2, 0.3), normal=(1, 2, 2)).rows())
    1
    """

    normal: Any = field(kw_only=True)

    def check(self, what: str) -> None:
        super().check(what)
        self.set(normal=unit(self.normal, f"{what}: normal"))

    def rows(self) -> list[Primitive]:
        return [in_plane(self.a, self.b, self.normal, self.at, self.at_b)]


@dataclass(frozen=True, eq=False)
class Distance(Joint):
    """A massless rod between a point of a and a point of b keeps their distance (1 row).

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Distance
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> round(Distance(GROUND, part, at_a=(0, 0, 0), at_b=(0.3, 0.0, 0.4)).length, 12)
    0.5
    """

    a: Any
    b: Any
    at_a: Any = field(kw_only=True)
    at_b: Any = field(kw_only=True)
    length: float | None = field(default=None, kw_only=True)

    def check(self, what: str) -> None:
        super().check(what)
        at_a, at_b = vector(self.at_a, f"{what}: at_a"), vector(self.at_b, f"{what}: at_b")
        span = np.linalg.norm(at_b - at_a)
        length = span if self.length is None else number(self.length, f"{what}: length", positive=True)
        if span < 1e-12:
            raise ValueError(f"{what}: the end points coincide, so the rod has no direction; use Spherical or move one")
        self.set(at_a=at_a, at_b=at_b, length=float(length))

    def point(self) -> np.ndarray:
        return self.at_b

    def rows(self) -> list[Primitive]:
        return [Primitive(kinds.DISTANCE, (self.a, self.b), points=(self.at_a, self.at_b), values=(self.length,))]


@dataclass(frozen=True, eq=False)
class Parallel(Joint):
    """An axis of b stays parallel to an axis of a (2 rows).

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Parallel
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> sum(row.n_rows for row in Parallel(GROUND, part, axis=(1, 2, 2)).rows())
    2
    """

    a: Any
    b: Any
    axis: Any = field(kw_only=True)
    axis_b: Any = field(default=None, kw_only=True)

    def check(self, what: str) -> None:
        super().check(what)
        axis = unit(self.axis, f"{what}: axis")
        self.set(axis=axis, axis_b=axis if self.axis_b is None else unit(self.axis_b, f"{what}: axis_b"))

    def rows(self) -> list[Primitive]:
        return [perpendicular(self.a, self.b, x, self.axis_b) for x in perpendiculars(self.axis)]

    def angle(self) -> Coordinate:
        return Coordinate("angle", self.a, self.b, self.axis, self.axis_b)


@dataclass(frozen=True, eq=False)
class Perpendicular(Joint):
    """``axis_b`` of b stays perpendicular to ``axis_a`` of a (1 row).

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Perpendicular
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> sum(row.n_rows for row in Perpendicular(GROUND, part, axis_a=(1, 2, 2), axis_b=(2, 1, -2)).rows())
    1
    """

    a: Any
    b: Any
    axis_a: Any = field(kw_only=True)
    axis_b: Any = field(kw_only=True)

    def check(self, what: str) -> None:
        super().check(what)
        x, y = unit(self.axis_a, f"{what}: axis_a"), unit(self.axis_b, f"{what}: axis_b")
        if abs(x @ y) > 1e-6:
            raise ValueError(f"{what}: the axes enclose {np.degrees(np.arccos(x @ y)):.6g} degrees; give 90 degrees")
        self.set(axis_a=x, axis_b=y)

    def rows(self) -> list[Primitive]:
        return [perpendicular(self.a, self.b, self.axis_a, self.axis_b)]


@dataclass(frozen=True, eq=False)
class ConstantVelocity(PointJoint):
    """Constant-velocity joint between shafts along ``axis_a`` and ``axis_b``: no turn about their bisector (4 rows).

    With n the common normal of the shafts: x_a . y_b - y_a . x_b = 0 for x = n, y = axis x n on both sides.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, ConstantVelocity
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> joint = ConstantVelocity(GROUND, part, at=(0, 0, 0), axis_a=(1, 0, 0), axis_b=(0.8, 0.6, 0))
    >>> sum(row.n_rows for row in joint.rows())
    4
    """

    axis_a: Any = field(kw_only=True)
    axis_b: Any = field(kw_only=True)

    def check(self, what: str) -> None:
        super().check(what)
        axis_a, axis_b = unit(self.axis_a, f"{what}: axis_a"), unit(self.axis_b, f"{what}: axis_b")
        if axis_a @ axis_b < 1e-6:
            raise ValueError(f"{what}: axis_a and axis_b enclose 90 degrees or more; point both along the power flow")
        self.set(axis_a=axis_a, axis_b=axis_b)

    def rows(self) -> list[Primitive]:
        normal = np.cross(self.axis_a, self.axis_b)
        bend = np.linalg.norm(normal)
        n = normal / bend if bend > 1e-9 else perpendiculars(self.axis_a)[0]
        y_a, y_b = np.cross(self.axis_a, n), np.cross(self.axis_b, n)
        turn = Primitive(kinds.DOT_DIFFERENCE, (self.a, self.b), axes=(n, n), second_axes=(y_a, y_b), in_metres=False)
        return [coincide(self.a, self.b, self.at, self.at_b), turn]


@dataclass(frozen=True, eq=False)
class Screw(AxisJoint):
    """b advances along the axis by ``pitch`` [m] per turn (5 rows): slide = pitch angle / (2 pi).

    Examples
    --------
    >>> from math import pi
    >>> from mbsd3d import GROUND, Body, Screw, System
    >>> nut = Body("nut", mass=0.4, inertia=(0.1, 0.1, 0.2), position=(0.2, 0.1, 0.5))
    >>> thread = Screw(GROUND, nut, at=(0.2, 0.1, 0.5), axis=(0, 0, 1), pitch=0.01, name="thread")
    >>> state = System([nut], [thread]).assemble(angles={"thread": 2 * pi})
    >>> round(float(state.q[2]), 12)  # one turn lifts it by the pitch
    0.51
    """

    pitch: float = field(kw_only=True)

    def check(self, what: str) -> None:
        super().check(what)
        self.set(pitch=number(self.pitch, f"{what}: pitch"))

    def rows(self) -> list[Primitive]:
        lead = ratio(self.slide(), 1.0, self.angle(), -self.pitch / (2 * np.pi), in_metres=True)
        return [*self.line_rows(), *self.parallel_rows(), lead]


def coordinate_of(part: Any, kind: str, what: str) -> Coordinate:
    """The angle or slide of a joint, or a ValueError that names both."""
    found = getattr(part, kind)() if isinstance(part, Joint) else None
    if found is None:
        have = f"{part.name!r} ({type(part).__name__})" if isinstance(part, Joint) else repr(part)
        example = "Revolute or Cylindrical" if kind == "angle" else "Prismatic or Cylindrical"
        raise ValueError(f"{what}: {have} has no {kind}; give a joint that has one, e.g. a {example}")
    return found
