"""Planar joints: data that lowers to rows of four kinds (coincide, in line, angle, distance)."""

from dataclasses import KW_ONLY
from typing import ClassVar

import numpy as np

from engines.planar import rows as kinds
from engines.planar.bodies import (
    NONE,
    Between,
    Body,
    Direction,
    Ground,
    Motion,
    Pair,
    PairOrDerived,
    Part,
    Row,
    TwoPoint,
)
from mbsd3d.errors import InputError
from mbsd3d.extend import Number, NumberOrDerived, derive, kept, part_class


@part_class()
class Joint(Part):
    """Base of joints and drivers; reactions are given on body b at `point`."""

    def rows(self) -> list[Row]:
        """Return the constraint rows of the joint."""
        raise NotImplementedError

    def point(self) -> np.ndarray:
        """Return the point of b at which the reaction is given, world at the reference pose [m]."""
        raise NotImplementedError

    def partners(self) -> tuple["Joint", ...]:
        """Return the joints through which the joint acts."""
        return ()


@part_class()
class PointJoint(Between, Joint):
    """Joint of body a and body b at a point."""

    _: KW_ONLY
    at: Pair = kept()

    def point(self) -> np.ndarray:
        return self.at

    def ends(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the point in the axes of both bodies [m]."""
        return self.a.local_point(self.at), self.b.local_point(self.at)

    def coincide(self) -> Row:
        """Return the rows p_b = p_a (2 rows)."""
        a, b = self.ends()
        return Row(kinds.COINCIDE, (self.a, self.b), (*a, *b))


def turn(factors: tuple[float, ...], bodies: tuple[Body | Ground, ...], motion: Motion = NONE) -> Row:
    """Return the row sum f_k (theta_k - theta_k at the reference pose) = f(t)."""
    offset = -sum(f * body.angle for f, body in zip(factors, bodies, strict=True))
    return Row(kinds.ANGLE, bodies, (*factors, *(0.0,) * (4 - len(factors)), offset), motion)


class Revolute(PointJoint):
    """Hinge (2 rows)."""

    def rows(self) -> list[Row]:
        return [self.coincide()]


class Fixed(PointJoint):
    """Joint without relative motion (3 rows)."""

    def rows(self) -> list[Row]:
        return [self.coincide(), turn((-1.0, 1.0), (self.a, self.b))]


@part_class()
class Slider(PointJoint):
    """Joint in which b slides along an axis of a without turning (2 rows)."""

    _: KW_ONLY
    axis: Direction = kept()

    def along(self, axis: np.ndarray, motion: Motion = NONE) -> Row:
        """Return the row axis_a . (p_b - p_a) = f(t)."""
        a, b = self.ends()
        return Row(kinds.IN_LINE, (self.a, self.b), (*a, *b, *self.a.local(axis), 0.0, 0.0), motion)

    def rows(self) -> list[Row]:
        across = np.array([-self.axis[1], self.axis[0]])
        return [self.along(across), turn((-1.0, 1.0), (self.a, self.b))]


@part_class()
class Distance(TwoPoint, Joint):
    """Massless rod between two points (1 row); ``length`` None = as at the reference pose [m]."""

    _: KW_ONLY
    length: NumberOrDerived = kept(default=None, positive=True, derived=lambda rod: rod.span)

    coincident = "the rod has no direction; use Revolute or move one"

    def point(self) -> np.ndarray:
        return self.at_b

    def rows(self) -> list[Row]:
        a, b = self.ends()
        return [Row(kinds.DISTANCE, (self.a, self.b), (*a, *b, self.length))]


@part_class()
class Rolling(PointJoint):
    """Disc of b that rolls without slip on the line of a through ``at`` along ``along`` (2 rows).

    With n the normal towards the disc and t = (n_y, -n_x): n . (C - P) = radius and t . (C - P) + radius theta is
    constant, where theta is the angle of b relative to a.

    ``at, along`` (2,): a point of the line and its direction, world [m], [-]; ``radius``: [m] > 0, the distance of the
    centre from the line at the reference pose; ``centre`` (2,): of the disc, world [m]; None = centre of mass.
    ValueError if the disc does not touch the line at the reference pose.
    """

    _: KW_ONLY
    along: Direction = kept()
    radius: Number = kept(positive=True)
    centre: PairOrDerived = kept(
        default=None, derived=lambda disc: disc.b.position + disc.b.local(np.eye(2)).T @ disc.b.com
    )

    def check(self, what: str) -> None:
        super().check(what)
        if isinstance(self.b, Ground):
            raise InputError(f"{what}: the ground cannot roll; give (ground, body)")
        along, radius = self.along, self.radius
        gap = along[0] * (self.centre - self.at)[1] - along[1] * (self.centre - self.at)[0]
        if abs(abs(gap) - radius) > 1e-9 * radius:
            raise InputError(
                f"{what}: radius {radius:.12g} m, but the centre is {abs(gap):.12g} m from the line; make them equal"
            )
        derive(self, along=along if gap > 0 else -along)

    def normal(self) -> np.ndarray:
        """Return the normal of the line, towards the disc, world at the reference pose."""
        return np.array([-self.along[1], self.along[0]])

    def point(self) -> np.ndarray:
        return self.centre - self.radius * self.normal()

    def rows(self) -> list[Row]:
        ends = (*self.a.local_point(self.at), *self.b.local_point(self.centre))
        n, t = self.a.local(self.normal()), self.a.local(self.along)
        turned = self.along @ (self.centre - self.at) + self.radius * (self.b.angle - self.a.angle)
        touch = Row(kinds.IN_LINE, (self.a, self.b), (*ends, *n, 0.0, -self.radius))
        return [touch, Row(kinds.IN_LINE, (self.a, self.b), (*ends, *t, self.radius, -turned))]


def check_kind(joint: object, kind: type, what: str) -> None:
    """Check that a joint is of the kind; raise ValueError for others."""
    if not isinstance(joint, kind):
        have = f"'{joint.name}' ({type(joint).__name__})" if isinstance(joint, Joint) else repr(joint)
        raise InputError(f"{what}: {have} is not a {kind.__name__}; give one")


@part_class()
class Gear(Joint):
    """Gear of two hinges with a fixed ratio = angle_b / angle_a (1 row); ratio < 0 for an external mesh."""

    hinge_a: Revolute
    hinge_b: Revolute
    _: KW_ONLY
    ratio: Number = kept()

    def check(self, what: str) -> None:
        check_kind(self.hinge_a, Revolute, what)
        check_kind(self.hinge_b, Revolute, what)
        if self.hinge_a is self.hinge_b:
            raise InputError(f"{what}: both hinges are '{self.hinge_a.name}'; give two")
        if self.ratio == 0.0:
            raise InputError(f"{what}: ratio is 0; give angle_b / angle_a")

    def point(self) -> np.ndarray:
        return self.hinge_b.at

    def partners(self) -> tuple[Joint, ...]:
        return self.hinge_a, self.hinge_b

    def rows(self) -> list[Row]:
        a, b = self.hinge_a, self.hinge_b
        return [turn((-1.0, 1.0, self.ratio, -self.ratio), (b.a, b.b, a.a, a.b))]


@part_class()
class Driver(Joint):
    """Prescribed motion of a joint, counted from the reference pose; `Solution.effort` is its drive force or torque."""

    through: PointJoint
    motion: Motion

    kind: ClassVar[type[PointJoint]] = Revolute

    def check(self, what: str) -> None:
        check_kind(self.through, self.kind, what)
        if not isinstance(self.motion, Motion):
            raise InputError(f"{what}: {self.motion!r} is not a motion; give rate(w), Sine or Polynomial")

    def point(self) -> np.ndarray:
        return self.through.at

    def partners(self) -> tuple[Joint, ...]:
        return (self.through,)


class AngleDriver(Driver):
    """Prescribed angle of a hinge [rad] (1 row)."""

    def rows(self) -> list[Row]:
        return [turn((-1.0, 1.0), (self.through.a, self.through.b), self.motion)]


class SlideDriver(Driver):
    """Prescribed displacement of a slider [m] (1 row)."""

    through: Slider
    kind = Slider

    def rows(self) -> list[Row]:
        return [self.through.along(self.through.axis, self.motion)]
