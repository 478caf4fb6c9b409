"""Joints of machines: hinges, sliders, ball joints. A joint is data that is compiled to rows."""

from dataclasses import KW_ONLY
from typing import Any

import numpy as np

from ...base.errors import InputError
from ...base.fields import Direction, Number, kept, locked, part_class
from ...base.rotations import PERPENDICULAR_TOLERANCE, cross, make_perpendicular, matrix, perpendiculars, unit
from ..primitives import Coordinate, Primitive, TurnRate, coincide, in_plane, perpendicular, ratio
from .joint import AxisJoint, PointJoint, angle_of, slide_of


@part_class()
class Spherical(PointJoint):
    """A ball joint: the points coincide (3 rows, 3 degrees of freedom: all rotations).

    With ``reflected_inertia`` I its rotation has a kinetic energy I |w_b - w_a|^2 / 2 of its own: that of rotors behind
    gears about three axes that are perpendicular to each other, see `Revolute`. Its torque on b is -I times the rate of
    w_b - w_a in the axes of b, or of a, which are the same; the opposite one acts on a.

    Parameters
    ----------
    a, b : Body or GROUND
        The bodies; angle, slide and reaction are those of b relative to a.
    at : (3,)
        Point of the joint [m], world axes at the reference pose.
    at_b : (3,), optional
        Actual point of b, if the bodies do not fit as built; the first run moves it into place.
    reflected_inertia : float
        [kg m^2], 0 or more.
    name : str, optional
        For results and messages; "Spherical 1" and so on by default.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Spherical, System, simulate
    >>> bob = Body("bob", mass=2.0, inertia=(0.02, 0.03, 0.01), position=(0.6, 0.0, 0.8), omega=(0, 0, 2.0))
    >>> run = simulate(System([bob], [Spherical(GROUND, bob, at=(0, 0, 1.6), name="ball")]), 1.0, output=101)
    >>> force = run.reaction("ball").force  # of the joint on bob [N], world axes, over time
    >>> force.shape, bool(force[0, 2] > 0.0)
    ((101, 3), True)
    """

    _: KW_ONLY
    reflected_inertia: Number = kept(default=0.0, minimum=0.0)

    def rows(self) -> list[Primitive]:
        return [coincide(self.a, self.b, self.at, self.at_b)]

    def reflected(self) -> list[tuple[Coordinate | TurnRate, float]]:
        I = self.reflected_inertia
        return [(TurnRate(self.a, self.b, axis), I) for axis in matrix(self.b.orientation).T] if I else []


@part_class()
class Revolute(AxisJoint):
    """A hinge: the points coincide and the axes are parallel (5 rows, 1 degree of freedom: the angle).

    With ``reflected_inertia`` I its angle has a kinetic energy I angle_dot^2 / 2 of its own: that of a fast, light
    rotor behind a gear of ratio N, I = N^2 times its inertia ("armature" in MuJoCo). The effect of the rotation
    of body a on the rotor is neglected: its torque is -I angle_ddot on b and the opposite one on a. The rotor is not a
    body: it enters the energy, but not the momentum.

    Parameters
    ----------
    a, b : Body or GROUND
        The bodies; angle, slide and reaction are those of b relative to a.
    at : (3,)
        Point of the joint [m], world axes at the reference pose.
    axis : "x", "y", "z" or (3,)
        Direction of the hinge, fixed in a, world axes at the reference pose; any length.
    at_b, axis_b : (3,), optional
        Actual point and axis of b, if the bodies do not fit as built; the first run moves them into place.
    reflected_inertia : float
        [kg m^2], 0 or more.
    name : str, optional
        For results and messages; "Revolute 1" and so on by default.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, System, simulate
    >>> arm = Body("arm", mass=3.0, inertia=(0.01, 0.25, 0.25), position=(0.5, 0.0, 0.0))
    >>> hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis="y", name="hinge")
    >>> run = simulate(System([arm], [hinge]), 1.0, output=101)
    >>> # largest angle [rad], upward force at the start [N]
    >>> float(run.angle(hinge).max().round(3)), float(run.reaction(hinge).force[0, 2].round(2))
    (3.142, 7.36)
    """

    _: KW_ONLY
    reflected_inertia: Number = kept(default=0.0, minimum=0.0)

    def rows(self) -> list[Primitive]:
        return [coincide(self.a, self.b, self.at, self.at_b), *self.parallel_rows()]

    def slide(self) -> None:
        return None

    def reflected(self) -> list[tuple[Coordinate | TurnRate, float]]:
        return [(angle_of(self), self.reflected_inertia)] if self.reflected_inertia else []


def square_to_axis_a(value: Any, what: str, part: Any) -> np.ndarray:
    """Return the second axis of a cross, made perpendicular to the first one."""
    x, y = part.axis_a, unit(value, what)
    if abs(x @ y) > PERPENDICULAR_TOLERANCE:
        what, off = what.removesuffix(": axis_b"), cross(x, y)
        if off @ off < 1e-12:
            raise InputError(f"{what}: axis_a and axis_b are parallel; a cross needs two perpendicular axes")
        angle = np.degrees(np.arccos(x @ y))
        raise InputError(f"{what}: axis_a and axis_b enclose {angle:.6g} degrees; give perpendicular axes")
    return locked(make_perpendicular(x, y))


@part_class()
class Universal(PointJoint):
    """Cardan joint: the points coincide and the axes of its cross stay perpendicular (4 rows, 2 degrees of freedom).

    One arm of the cross, ``axis_a``, turns in a, the other one, ``axis_b``, in b. If they deviate from a right
    angle by up to 1e-6, ``axis_b`` is made perpendicular to ``axis_a``.

    Parameters
    ----------
    a, b : Body or GROUND
        The bodies; angle, slide and reaction are those of b relative to a.
    at : (3,)
        Point of the joint [m], world axes at the reference pose.
    axis_a, axis_b : "x", "y", "z" or (3,)
        Directions of the arms, fixed in a and in b, world axes at the reference pose.
    at_b : (3,), optional
        Actual point of b, if the bodies do not fit as built; the first run moves it into place.
    name : str, optional
        For results and messages; "Universal 1" and so on by default.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, System, Universal
    >>> pole = Body("pole", mass=1.2, inertia=(0.2, 0.2, 0.01), position=(0.0, 0.0, 0.7))
    >>> cross = Universal(GROUND, pole, at=(0, 0, 0), axis_a="x", axis_b="y", name="cross")
    >>> System([pole], [cross]).check().mobility  # it tips both ways, and cannot twist
    2
    """

    _: KW_ONLY
    axis_a: Direction = kept()
    axis_b: Direction = kept(by=square_to_axis_a)

    def rows(self) -> list[Primitive]:
        return [coincide(self.a, self.b, self.at, self.at_b), perpendicular(self.a, self.b, self.axis_a, self.axis_b)]


@part_class()
class Prismatic(AxisJoint):
    """A slider: b slides along the axis without turning (5 rows, 1 degree of freedom: the slide).

    With ``reflected_mass`` m its slide has a kinetic energy m slide_dot^2 / 2 of its own: see `Revolute`.

    Parameters
    ----------
    a, b : Body or GROUND
        The bodies; angle, slide and reaction are those of b relative to a.
    at : (3,)
        Point of the joint [m], world axes at the reference pose.
    axis : "x", "y", "z" or (3,)
        Direction of the slide, fixed in a, world axes at the reference pose; any length.
    at_b, axis_b : (3,), optional
        Actual point and axis of b, if the bodies do not fit as built; the first run moves them into place.
    reflected_mass : float
        [kg], 0 or more.
    name : str, optional
        For results and messages; "Prismatic 1" and so on by default.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Prismatic, System, simulate
    >>> sled = Body("sled", mass=5.0, inertia=(0.1, 0.1, 0.1), position=(0.0, 0.0, 0.2))
    >>> track = Prismatic(GROUND, sled, at=(0, 0, 0), axis=(3, 0, -4), name="track")  # a slope of 53 degrees
    >>> run = simulate(System([sled], [track]), 1.0, output=11)
    >>> float(run.slide(track)[-1].round(6))  # 4/5 g / 2
    3.924
    """

    _: KW_ONLY
    reflected_mass: Number = kept(default=0.0, minimum=0.0)

    def rows(self) -> list[Primitive]:
        return [*self.line_rows(), *self.parallel_rows(), self.no_turn_row()]

    def angle(self) -> None:
        return None

    def reflected(self) -> list[tuple[Coordinate | TurnRate, float]]:
        return [(slide_of(self), self.reflected_mass)] if self.reflected_mass else []


class Cylindrical(AxisJoint):
    """b slides along the axis and turns about it (4 rows, 2 freedoms: slide and angle).

    Parameters
    ----------
    a, b : Body or GROUND
        The bodies; angle, slide and reaction are those of b relative to a.
    at : (3,)
        Point of the joint [m], world axes at the reference pose.
    axis : "x", "y", "z" or (3,)
        Its direction, fixed in a, world axes at the reference pose; any length.
    at_b, axis_b : (3,), optional
        Actual point and axis of b, if the bodies do not fit as built; the first run moves them into place.
    name : str, optional
        For results and messages; "Cylindrical 1" and so on by default.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Cylindrical, System
    >>> rod = Body("rod", mass=0.4, inertia=(0.01, 0.01, 0.001), position=(0.2, 0.1, 0.5))
    >>> sleeve = Cylindrical(GROUND, rod, at=(0.2, 0.1, 0), axis="z", name="sleeve")
    >>> state = System([rod], [sleeve]).assemble(angles={"sleeve": 7.0}, slides={"sleeve": 0.1})
    >>> round(float(state.q[2]), 12)
    0.6
    """

    def rows(self) -> list[Primitive]:
        return [*self.line_rows(), *self.parallel_rows()]


@part_class()
class Planar(PointJoint):
    """b moves in a plane fixed in a and turns about its normal only (3 rows, 3 freedoms).

    Parameters
    ----------
    a, b : Body or GROUND
        The bodies; angle, slide and reaction are those of b relative to a.
    at : (3,)
        Point of the joint [m], world axes at the reference pose.
    normal : "x", "y", "z" or (3,)
        Normal of the plane through ``at``, fixed in a, world axes at the reference pose.
    at_b : (3,), optional
        Actual point of b, if the bodies do not fit as built; the first run moves it into place.
    name : str, optional
        For results and messages; "Planar 1" and so on by default.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Planar, System
    >>> puck = Body("puck", mass=0.2, inertia=(1e-4, 1e-4, 2e-4), velocity=(1.0, 0.0, 0.0))
    >>> System([puck], [Planar(GROUND, puck, at=(0, 0, 0), normal="z")]).check().mobility
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
    """A weld: no relative motion (6 rows); its reaction is what the weld carries.

    Parameters
    ----------
    a, b : Body or GROUND
        The bodies; angle, slide and reaction are those of b relative to a.
    at : (3,)
        Point of the joint [m], world axes at the reference pose.
    at_b : (3,), optional
        Actual point of b, if the bodies do not fit as built; the first run moves it into place.
    name : str, optional
        For results and messages; "Fixed 1" and so on by default.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Fixed, System, accelerations
    >>> beam = Body("beam", mass=10.0, inertia=(0.1, 3.0, 3.0), position=(1.0, 0.0, 0.0))
    >>> wall = Fixed(GROUND, beam, at=(0, 0, 0), name="wall")
    >>> reaction = accelerations(System([beam], [wall])).reaction(wall)
    >>> reaction.force[0].round(3).tolist(), reaction.moment[0].round(3).tolist()  # m g, and m g times 1 m
    ([0.0, 0.0, 98.1], [0.0, -98.1, 0.0])
    """

    def rows(self) -> list[Primitive]:
        x, y, z = np.eye(3)
        locks = [perpendicular(self.a, self.b, u, w) for u, w in ((x, y), (y, z), (z, x))]
        return [coincide(self.a, self.b, self.at, self.at_b), *locks]


@part_class()
class Screw(AxisJoint):
    """A nut on a thread: b advances along the axis by ``pitch`` per turn (5 rows): slide = pitch angle / (2 pi).

    Parameters
    ----------
    a, b : Body or GROUND
        The bodies; angle, slide and reaction are those of b relative to a.
    at : (3,)
        Point of the axis [m], world axes at the reference pose.
    axis : "x", "y", "z" or (3,)
        Direction of the screw, fixed in a, world axes at the reference pose; any length.
    pitch : float
        Advance per turn [m]; negative for a left-hand thread.
    at_b, axis_b : (3,), optional
        Actual point and axis of b, if the bodies do not fit as built; the first run moves them into place.
    name : str, optional
        For results and messages; "Screw 1" and so on by default.

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
