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
    """A point of b slides on a line fixed in a, and b turns freely about it (2 rows).

    Parameters
    ----------
    a, b : Body or GROUND
        The bodies; the reaction is that of a on b.
    at : (3,)
        The point of b, and one of the line [m], world axes at the reference pose.
    axis : "x", "y", "z" or (3,)
        Direction of the line, fixed in a, world axes at the reference pose; any length.
    at_b : (3,), optional
        Actual point of b, if the bodies do not fit as built; the first run moves it into place.
    name : str, optional
        For results and messages; "PointOnLine 1" and so on by default.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, PointOnLine, System, simulate
    >>> bob = Body("bob", mass=2.0, inertia=(0.01, 0.01, 0.01), position=(0.0, 0.0, -0.5))
    >>> wire = PointOnLine(GROUND, bob, at=(0, 0, 0), axis=(1, 0, 0), name="wire")
    >>> run = simulate(System([bob], [wire]), 1.0, output=11)
    >>> run.reaction(wire).force[-1].round(6).tolist()  # carries the weight, and nothing along the line
    [0.0, 0.0, 19.62]
    """

    def rows(self) -> list[Primitive]:
        return self.line_rows()

    def angle(self) -> None:
        return None


@part_class()
class PointOnPlane(PointJoint):
    """A point of b moves in a plane fixed in a, and b turns freely about it (1 row).

    Parameters
    ----------
    a, b : Body or GROUND
        The bodies; the reaction is that of a on b.
    at : (3,)
        The point of b, and one of the plane [m], world axes at the reference pose.
    normal : "x", "y", "z" or (3,)
        Normal of the plane, fixed in a, world axes at the reference pose; any length.
    at_b : (3,), optional
        Actual point of b, if the bodies do not fit as built; the first run moves it into place.
    name : str, optional
        For results and messages; "PointOnPlane 1" and so on by default.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, PointOnPlane, System, simulate
    >>> puck = Body("puck", mass=0.5, inertia=(0.01, 0.01, 0.01))
    >>> slope = PointOnPlane(GROUND, puck, at=(0, 0, 0), normal=(-0.6, 0.0, 0.8), name="slope")
    >>> run = simulate(System([puck], [slope]), 1.0, output=11)
    >>> run.position(puck)[-1].round(6).tolist()  # down the slope of 36.9 degrees: g sin(36.9 degrees) t^2 / 2 along it
    [-2.3544, 0.0, -1.7658]
    """

    _: KW_ONLY
    normal: Direction = kept()

    def rows(self) -> list[Primitive]:
        return [in_plane(self.a, self.b, self.normal, self.at, self.at_b)]


ENDS_GAP_MIN = 1e-12  # [m] between end points, so that their line has a direction


def span(part: Any) -> float:
    """Return the distance between the end points ``at_a`` and ``at_b`` of a part [m]."""
    d = part.at_b - part.at_a
    return math.sqrt(d.dot(d))


def ends_coincide(part: Any) -> bool:
    """Return whether the end points of a part are too close for a direction."""
    return span(part) < ENDS_GAP_MIN


@part_class()
class Distance(Joint):
    """A massless rod between a point of a and a point of b keeps their distance (1 row).

    Parameters
    ----------
    a, b : Body or GROUND
        The bodies.
    at_a, at_b : (3,)
        Ends of the rod [m], fixed in a and in b, world axes at the reference pose.
    length : float, optional
        [m]; by default the distance of the ends at the reference pose.
    name : str, optional
        For results and messages; "Distance 1" and so on by default.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Distance, System, accelerations
    >>> bob = Body("bob", mass=1.2, inertia=(0.01, 0.01, 0.01), position=(0.3, 0.0, -0.4))
    >>> rod = Distance(GROUND, bob, at_a=(0, 0, 0), at_b=(0.3, 0.0, -0.4), name="rod")
    >>> force = accelerations(System([bob], [rod])).reaction(rod).force[0]  # on bob, along the rod
    >>> rod.length, force.round(4).tolist()  # m g cos(36.9 degrees) = 9.4176 N
    (0.5, [-5.6506, 0.0, 7.5341])
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
    """An axis of b stays parallel to an axis of a, while the points move freely (2 rows).

    Parameters
    ----------
    a, b : Body or GROUND
        The bodies; the reaction is that of a on b.
    axis : "x", "y", "z" or (3,)
        Direction fixed in a, world axes at the reference pose; any length.
    axis_b : "x", "y", "z" or (3,), optional
        Actual direction in b, if the bodies do not fit as built; the first run turns it into place.
    name : str, optional
        For results and messages; "Parallel 1" and so on by default.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Parallel, System, simulate
    >>> tray = Body("tray", mass=1.2, inertia=(0.02, 0.03, 0.04), omega=(0, 0, 5.0))
    >>> run = simulate(System([tray], [Parallel(GROUND, tray, axis="z", name="level")]), 1.0, output=11)
    >>> run.position(tray)[-1].round(6).tolist(), run.omega(tray)[-1].round(6).tolist()  # falls, spins, stays level
    ([0.0, 0.0, -4.905], [0.0, 0.0, 5.0])
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
    """Return the second axis, made perpendicular to the first one."""
    x, y = part.axis_a, unit(value, what)
    if abs(x @ y) > PERPENDICULAR_TOLERANCE:
        angle = np.degrees(np.arccos(x @ y))
        raise InputError(f"{what.removesuffix(': axis_b')}: the axes enclose {angle:.6g} degrees; give 90 degrees")
    return locked(make_perpendicular(x, y))


@part_class()
class Perpendicular(Joint):
    """A direction of b stays perpendicular to a direction of a, while the points move freely (1 row).

    If they deviate from a right angle by up to 1e-6, ``axis_b`` is made perpendicular to ``axis_a``.

    Parameters
    ----------
    a, b : Body or GROUND
        The bodies; the reaction is that of a on b.
    axis_a, axis_b : "x", "y", "z" or (3,)
        Directions fixed in a and in b, world axes at the reference pose; any length.
    name : str, optional
        For results and messages; "Perpendicular 1" and so on by default.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Perpendicular, System, simulate
    >>> arrow = Body("arrow", mass=0.4, inertia=(0.01, 0.03, 0.03), omega=(0.5, 0.0, 3.0))
    >>> level = Perpendicular(GROUND, arrow, axis_a="z", axis_b="x", name="level")
    >>> run = simulate(System([arrow], [level]), 1.0, output=11)
    >>> abs(run.rotation(arrow)[:, 2, 0]).max() < 1e-9  # its x axis stays horizontal
    np.True_
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
    """Constant-velocity joint between two shafts: the points coincide, without rotation about the bisector (4 rows).

    With n the common normal of the shafts: x_a . y_b - y_a . x_b = 0 for x = n, y = axis x n on both sides. Both shafts
    turn at the same rate at any angle between them.

    Parameters
    ----------
    a, b : Body or GROUND
        The bodies; the reaction is that of a on b.
    at : (3,)
        Centre of the joint [m], world axes at the reference pose.
    axis_a, axis_b : "x", "y", "z" or (3,)
        Directions of the shafts, fixed in a and in b, both along the flow of power, less than 90 degrees apart; world
        axes at the reference pose.
    at_b : (3,), optional
        Actual point of b, if the bodies do not fit as built; the first run moves it into place.
    name : str, optional
        For results and messages; "ConstantVelocity 1" and so on by default.

    Raises
    ------
    ValueError
        If the axes enclose 90 degrees or more.

    Examples
    --------
    >>> from mbsd3d import GROUND, AngleDriver, Body, ConstantVelocity, Kinematic, Ramp, Revolute, System, simulate
    >>> one = Body("one", mass=1.0, inertia=(0.1, 0.2, 0.2), position=(-0.5, 0, 0))
    >>> two = Body("two", mass=1.0, inertia=(0.2, 0.2, 0.2), position=(0.4, 0.3, 0))
    >>> bearing = Revolute(GROUND, one, at=(-0.5, 0, 0), axis="x", name="in")
    >>> out = Revolute(GROUND, two, at=(0.4, 0.3, 0), axis=(0.8, 0.6, 0), name="out")
    >>> joint = ConstantVelocity(one, two, at=(0, 0, 0), axis_a="x", axis_b=(0.8, 0.6, 0))
    >>> system = System([one, two], [bearing, out, joint, AngleDriver(bearing, Ramp(10.0))])
    >>> run = simulate(system, 1.0, method=Kinematic(), output=201)
    >>> rate = run.rate("out")  # at 36.9 degrees a Cardan joint would vary from 8 to 12.5 rad/s
    >>> float(rate.min().round(9)), float(rate.max().round(9))
    (10.0, 10.0)
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
