"""Planar joints: data that lowers to rows of four kinds (coincide, in line, angle, distance)."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mbsd3d.errors import InputError
from mbsd3d.extend import number
from validation.twins.planar import rows as kinds
from validation.twins.planar.bodies import NONE, Body, Ground, Motion, Part, Row, check_bodies, direction, ends, pair


@dataclass(frozen=True, eq=False)
class Joint(Part):
    """What joints and drivers share; reactions are given on body b at `point`."""

    def rows(self) -> list[Row]:
        """The rows of the joint."""
        raise NotImplementedError

    def point(self) -> np.ndarray:
        """Point of b at which the reaction is given, world at the reference pose [m]."""
        raise NotImplementedError

    def partners(self) -> tuple["Joint", ...]:
        """Joints it acts through."""
        return ()


@dataclass(frozen=True, eq=False)
class PointJoint(Joint):
    """A joint of body a and body b at a point."""

    a: Any
    b: Any
    at: Any = field(kw_only=True)

    def check(self, what: str) -> None:
        check_bodies(self, what)
        self.set(at=pair(self.at, f"{what}: at"))

    def point(self) -> np.ndarray:
        return self.at

    def ends(self) -> tuple[float, ...]:
        """The point in both bodies."""
        return (*self.a.local_point(self.at), *self.b.local_point(self.at))

    def coincide(self) -> Row:
        """p_b = p_a (2 rows)."""
        return Row(kinds.COINCIDE, (self.a, self.b), self.ends())


def turn(a: Body | Ground, b: Body, motion: Motion = NONE) -> Row:
    """theta_b - theta_a = f(t), counted from the reference pose."""
    return Row(kinds.ANGLE, (a, b), (a.angle - b.angle,), motion)


class Revolute(PointJoint):
    """A hinge (2 rows)."""

    def rows(self) -> list[Row]:
        return [self.coincide()]


class Fixed(PointJoint):
    """No relative motion (3 rows)."""

    def rows(self) -> list[Row]:
        return [self.coincide(), turn(self.a, self.b)]


@dataclass(frozen=True, eq=False)
class Slider(PointJoint):
    """b slides along an axis of a without turning (2 rows)."""

    axis: Any = field(kw_only=True)

    def check(self, what: str) -> None:
        super().check(what)
        self.set(axis=direction(self.axis, f"{what}: axis"))

    def rows(self) -> list[Row]:
        """across_a . (p_b - p_a) = 0, and no turn."""
        across = self.a.local(np.array([-self.axis[1], self.axis[0]]))
        return [Row(kinds.IN_LINE, (self.a, self.b), (*self.ends(), *across)), turn(self.a, self.b)]


@dataclass(frozen=True, eq=False)
class Distance(Joint):
    """A massless rod between two points (1 row); ``length`` None = as at the reference pose [m]."""

    a: Any
    b: Any
    at_a: Any = field(kw_only=True)
    at_b: Any = field(kw_only=True)
    length: float | None = field(default=None, kw_only=True)

    def check(self, what: str) -> None:
        check_bodies(self, what)
        span = ends(self, what, "the rod has no direction; use Revolute or move one")
        length = span if self.length is None else number(self.length, f"{what}: length", positive=True)
        self.set(length=float(length))

    def point(self) -> np.ndarray:
        return self.at_b

    def rows(self) -> list[Row]:
        a, b = self.a.local_point(self.at_a), self.b.local_point(self.at_b)
        return [Row(kinds.DISTANCE, (self.a, self.b), (*a, *b, self.length))]


@dataclass(frozen=True, eq=False)
class AngleDriver(Joint):
    """The angle of a hinge, counted from the reference pose, follows a motion [rad] (1 row)."""

    through: Any
    motion: Motion

    def check(self, what: str) -> None:
        if not isinstance(self.through, Revolute):
            have = f"'{self.through.name}'" if isinstance(self.through, Joint) else repr(self.through)
            raise InputError(f"{what}: {have} is not a Revolute; give one")
        if not isinstance(self.motion, Motion):
            raise InputError(f"{what}: {self.motion!r} is not a motion; give rate(w), Sine or Polynomial")

    def point(self) -> np.ndarray:
        return self.through.at

    def partners(self) -> tuple[Joint, ...]:
        return (self.through,)

    def rows(self) -> list[Row]:
        return [turn(self.through.a, self.through.b, self.motion)]
