"""Pairs of bodies as machines have them: hinges, sliders, ball joints. A joint is data that lowers to rows."""

from dataclasses import KW_ONLY
from typing import Any

import numpy as np

from ...base.errors import InputError
from ...base.fields import Direction, Number, kept, locked, part_class
from ...base.rotations import PERPENDICULAR_TOLERANCE, cross, make_perpendicular, perpendiculars, unit
from ..primitives import Coordinate, Primitive, coincide, in_plane, perpendicular, ratio
from .joint import AxisJoint, PointJoint, angle_of, slide_of


class Spherical(PointJoint):
    """The points coincide (3 rows).

    >>> from mbsd3d import GROUND, Body, Spherical
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> sum(row.n_rows for row in Spherical(GROUND, part, at=(0.1, 0.2, 0.3)).rows())
    3
    """

    def rows(self) -> list[Primitive]:
        return [coincide(self.a, self.b, self.at, self.at_b)]


@part_class()
class Revolute(AxisJoint):
    """A hinge: the points coincide and the axes are parallel (5 rows).

    With ``reflected_inertia`` I [kg m^2] its angle has a kinetic energy I angle_dot^2 / 2 of its own: that of a fast,
    light rotor behind a gear of ratio N, I = N^2 times its inertia ("armature" in MuJoCo). What such a rotor feels of
    the turning of body a is left out: its torque is -I angle_ddot on b and the opposite one on a. It is no body: energy
    counts it, momentum does not.

    >>> from mbsd3d import GROUND, Body, Revolute
    >>> door = Body("door", mass=20.0, inertia=(8.0, 9.0, 1.0), position=(0.45, 0.0, 1.0))
    >>> sum(row.n_rows for row in Revolute(GROUND, door, at=(0, 0, 0), axis=(0, 0, 1)).rows())
    5
    """

    _: KW_ONLY
    reflected_inertia: Number = kept(default=0.0, minimum=0.0)

    def rows(self) -> list[Primitive]:
        return [coincide(self.a, self.b, self.at, self.at_b), *self.parallel_rows()]

    def slide(self) -> None:
        return None

    def reflected(self) -> list[tuple[Coordinate, float]]:
        return [(angle_of(self), self.reflected_inertia)] if self.reflected_inertia else []


def square_to_axis_a(value: Any, what: str, part: Any) -> np.ndarray:
    """Return the second axis of a cross, made perpendicular to the first one."""
    what, x, y = what.removesuffix(": axis_b"), part.axis_a, unit(value, what)
    off = cross(x, y)
    if off @ off < 1e-12:
        raise InputError(f"{what}: axis_a and axis_b are parallel; a cross needs two perpendicular axes")
    if abs(x @ y) > PERPENDICULAR_TOLERANCE:
        angle = np.degrees(np.arccos(x @ y))
        raise InputError(f"{what}: axis_a and axis_b enclose {angle:.6g} degrees; give perpendicular axes")
    return locked(make_perpendicular(x, y))


@part_class()
class Universal(PointJoint):
    """Cardan joint: the points coincide and ``axis_a`` of a stays perpendicular to ``axis_b`` of b (4 rows).

    If they are off square by up to 1e-6, ``axis_b`` is squared to ``axis_a``.

    >>> from mbsd3d import GROUND, Body, Universal
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> cross = Universal(GROUND, part, at=(0.1, 0.2, 0.3), axis_a=(1, 2, 2), axis_b=(2, 1, -2))
    >>> sum(row.n_rows for row in cross.rows())
    4
    """

    _: KW_ONLY
    axis_a: Direction = kept()
    axis_b: Direction = kept(by=square_to_axis_a)

    def rows(self) -> list[Primitive]:
        return [coincide(self.a, self.b, self.at, self.at_b), perpendicular(self.a, self.b, self.axis_a, self.axis_b)]


@part_class()
class Prismatic(AxisJoint):
    """b slides along the axis without turning (5 rows).

    With ``reflected_mass`` m [kg] its slide has a kinetic energy m slide_dot^2 / 2 of its own: see `Revolute`.

    >>> from mbsd3d import GROUND, Body, Prismatic
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> sum(row.n_rows for row in Prismatic(GROUND, part, at=(0.1, 0.2, 0.3), axis=(1, 2, 2)).rows())
    5
    """

    _: KW_ONLY
    reflected_mass: Number = kept(default=0.0, minimum=0.0)

    def rows(self) -> list[Primitive]:
        return [*self.line_rows(), *self.parallel_rows(), self.no_turn_row()]

    def angle(self) -> None:
        return None

    def reflected(self) -> list[tuple[Coordinate, float]]:
        return [(slide_of(self), self.reflected_mass)] if self.reflected_mass else []


class Cylindrical(AxisJoint):
    """b slides along the axis and turns about it (4 rows).

    >>> from mbsd3d import GROUND, Body, Cylindrical
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> sum(row.n_rows for row in Cylindrical(GROUND, part, at=(0.1, 0.2, 0.3), axis=(1, 2, 2)).rows())
    4
    """

    def rows(self) -> list[Primitive]:
        return [*self.line_rows(), *self.parallel_rows()]


@part_class()
class Planar(PointJoint):
    """b moves in a plane fixed in a, turning about its normal only (3 rows).

    >>> from mbsd3d import GROUND, Body, Planar
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> sum(row.n_rows for row in Planar(GROUND, part, at=(0.1, 0.2, 0.3), normal=(1, 2, 2)).rows())
    3
    """

    _: KW_ONLY
    normal: Direction = kept()

    def rows(self) -> list[Primitive]:
        flat = [perpendicular(self.a, self.b, x, self.normal) for x in perpendiculars(self.normal)]
        return [in_plane(self.a, self.b, self.normal, self.at, self.at_b), *flat]

    def angle(self) -> Coordinate:
        return Coordinate("angle", self.a, self.b, self.normal, self.normal)


class Fixed(PointJoint):
    """No relative motion (6 rows).

    >>> from mbsd3d import GROUND, Body, Fixed
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> sum(row.n_rows for row in Fixed(GROUND, part, at=(0.1, 0.2, 0.3)).rows())
    6
    """

    def rows(self) -> list[Primitive]:
        x, y, z = np.eye(3)
        locks = [perpendicular(self.a, self.b, u, w) for u, w in ((x, y), (y, z), (z, x))]
        return [coincide(self.a, self.b, self.at, self.at_b), *locks]


@part_class()
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

    _: KW_ONLY
    pitch: Number = kept()

    def rows(self) -> list[Primitive]:
        lead = ratio(slide_of(self), 1.0, angle_of(self), -self.pitch / (2 * np.pi), in_metres=True)
        return [*self.line_rows(), *self.parallel_rows(), lead]
