"""Joints that keep two bodies in the relative pose at engagement, instead of the one at the reference pose."""

from dataclasses import KW_ONLY, replace

import numpy as np

from ..base.fields import Number, NumberOrNone, Orientation, Vector, kept, part_class
from ..base.rotations import matched_perpendiculars, matrix, perpendiculars
from ..kernels import kinds
from .bodies import Body, Ground
from .couplings import Coupling
from .joints import Joint
from .motion_protocols import LoadedMotion, Motion
from .primitives import Coordinate, Primitive, TurnRate
from .signals import Constant


@part_class()
class JointOfAnother(Joint):
    """Base class of joints that hold the bodies of another one, which is not itself part of the system."""

    joint: Joint

    @property
    def a(self) -> Body | Ground:
        """Return body a of the joint."""
        return self.joint.a

    @property
    def b(self) -> Body | Ground:
        """Return body b of the joint."""
        return self.joint.b

    def reaction_points(self, solution: Motion) -> np.ndarray:
        return solution.body_point(self.b, self.point())

    def notes(self, solution: LoadedMotion) -> list[str]:
        return []

    def partners(self) -> list[Joint]:
        return self.joint.partners()


@part_class()
class Engaged(JointOfAnother):
    """A joint that engaged at another pose than the reference pose; `System.engage` makes it.

    Points and axes of the joint rest in body a as they were given. In body b they are where they met body b when the
    joint engaged: a point x given for b lies at ``R(turn) x + shift`` of the reference pose. A `Distance` keeps both of
    its points and takes the length of that moment; a coupling keeps the ratio and takes the ``offset`` of that moment.
    Angles and slides of the joint count from the pose at which it engaged.

    Parameters
    ----------
    joint : Joint
        The joint as it was given, which is not itself part of the system.
    shift : (3,) array_like
        [m] world at the reference pose.
    turn : (4,) array_like
        Unit quaternion, world at the reference pose.
    length : float or None
        [m] of a `Distance`.
    offset : float
        [rad or m] of a row that couples hinge coordinates: factor x0 + factor_second x1 = offset.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, System
    >>> bar = Body("bar", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(2.0, 0, 0), omega=(0, 0, 1.5))
    >>> flight = System([bar])
    >>> caught = flight.engage(Revolute(GROUND, bar, at=(1.5, 0, 0), axis=(0, 0, 1), name="pin"), flight.state())
    >>> type(caught.joint).__name__, round(float(caught.state.v[5]), 9)  # 0.1 * 1.5 / (0.1 + 1 * 0.5^2)
    ('Engaged', 0.428571429)
    """

    _: KW_ONLY
    shift: Vector = kept(default=(0.0, 0.0, 0.0))
    turn: Orientation = kept(default=(1.0, 0.0, 0.0, 0.0))
    length: NumberOrNone = kept(default=None, positive=True)
    offset: Number = kept(default=0.0)

    def check(self, what: str) -> None:
        """Check nothing: joint and bodies were checked when the joint was made."""

    def moved_point(self, point: np.ndarray) -> np.ndarray:
        """Return a point of b [m, world at the reference pose]."""
        return point if self.length is not None else matrix(self.turn) @ point + self.shift

    def moved_axis(self, axis: np.ndarray) -> np.ndarray:
        """Return a direction in b, world at the reference pose."""
        return axis if self.length is not None else matrix(self.turn) @ axis

    def rows(self) -> list[Primitive]:
        return [self.moved_row(row) for row in self.joint.rows()]

    def moved_row(self, row: Primitive) -> Primitive:
        """Return a row of the joint with points and axes of b as they engaged."""
        if self.length is not None and row.kind == kinds.DISTANCE:
            return row._replace(values=(self.length,))
        if isinstance(self.joint, Coupling):
            return row._replace(signal=Constant(self.offset))
        on_b = [body is self.b for body in row.bodies]
        return row._replace(
            points=tuple(self.moved_point(x) if own else x for own, x in zip(on_b, row.points, strict=False)),
            axes=tuple(self.moved_axis(x) if own else x for own, x in zip(on_b, row.axes, strict=False)),
            second_axes=tuple(self.moved_axis(x) if own else x for own, x in zip(on_b, row.second_axes, strict=False)),
            coordinates=tuple(self.moved_coordinate(x) for x in row.coordinates),
        )

    def moved_coordinate(self, x: Coordinate) -> Coordinate:
        """Return an angle or slide of the joint that is zero where it engaged."""
        zero_a, zero_b = x.zero_a, x.zero_b
        if x.kind == "angle" and zero_a is None:
            zero_a, zero_b = perpendiculars(x.axis)[0], matched_perpendiculars(x.axis, x.axis_b)[0]
        return replace(
            x, axis_b=self.moved_axis(x.axis_b), point_b=self.moved_point(x.point_b), zero_a=zero_a,
            zero_b=None if zero_b is None else self.moved_axis(zero_b),
        )  # fmt: skip

    def angle(self) -> Coordinate | None:
        found = self.joint.angle()
        return None if found is None else self.moved_coordinate(found)

    def slide(self) -> Coordinate | None:
        found = self.joint.slide()
        return None if found is None else self.moved_coordinate(found)

    def reflected(self) -> list[tuple[Coordinate | TurnRate, float]]:
        return [
            (x if isinstance(x, TurnRate) else self.moved_coordinate(x), inertia)
            for x, inertia in self.joint.reflected()
        ]

    def point(self) -> np.ndarray:
        return self.moved_point(self.joint.point())
