"""Loads of a planar mechanism: force, spring, torsion spring."""

from dataclasses import KW_ONLY
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from engines.planar import rows as kinds
from engines.planar.bodies import GROUND, UNIT, Between, Body, Motion, Pair, PairOrDerived, Part, Row, TwoPoint, pair
from mbsd3d.errors import InputError
from mbsd3d.extend import Number, NumberOrDerived, kept, part_class


class Load(Part):
    """Base of loads."""

    def load(self) -> Row:
        """Return kind, bodies and numbers of the load."""
        raise NotImplementedError


def as_body(value: object, what: str, part: object) -> Body:
    """Return the body itself; raise ValueError for what is none."""
    if not isinstance(value, Body):
        raise InputError(f"{what}: {value!r} is not a planar body; give a Body")
    return value


def as_local_point(value: ArrayLike, what: str, part: Any) -> np.ndarray:
    """Return a world point at the reference pose in the axes of the body of a part [m]."""
    return part.body.local_point(pair(value, what))


@part_class()
class Force(Load):
    """Force (2,) [N] at a point of a body (None: centre of mass) and torque [N m], times ``motion`` of time.

    Components along the axes of the world or, with ``frame`` "body", along those of the body.
    """

    body: Body = kept(by=as_body)
    force: Pair = kept(default=(0.0, 0.0))
    _: KW_ONLY
    torque: Number = kept(default=0.0)
    at: PairOrDerived = kept(default=None, by=as_local_point, derived=lambda force: force.body.com)  # in body axes
    frame: str = "world"
    motion: Motion = UNIT

    def check(self, what: str) -> None:
        if self.frame not in ("world", "body"):
            raise InputError(f"{what}: frame {self.frame!r} is unknown; give 'world' or 'body'")

    def load(self) -> Row:
        axes = self.body if self.frame == "body" else GROUND
        return Row(kinds.FORCE, (axes, self.body), (*self.force, *self.at, self.torque), self.motion)


@part_class()
class Spring(TwoPoint, Load):
    """Spring and damper between two points: tension ``k (l - l0) + c l_dot``; ``length`` None = as at the reference."""

    _: KW_ONLY
    stiffness: Number = kept(minimum=0.0)
    damping: Number = kept(default=0.0, minimum=0.0)
    length: NumberOrDerived = kept(default=None, minimum=0.0, derived=lambda spring: spring.span)

    coincident = "a spring needs a direction; move one"

    def load(self) -> Row:
        a, b = self.ends()
        return Row(kinds.SPRING, (self.a, self.b), (*a, *b, self.stiffness, self.damping, self.length))


@part_class()
class TorsionSpring(Between, Load):
    """Torque ``-k (angle - angle0) - c rate`` on b, the angle of b relative to a counted from the reference pose."""

    _: KW_ONLY
    stiffness: Number = kept(minimum=0.0)
    damping: Number = kept(default=0.0, minimum=0.0)
    angle: Number = kept(default=0.0)

    def load(self) -> Row:
        rest = self.angle + self.b.angle - self.a.angle
        return Row(kinds.TORSION, (self.a, self.b), (self.stiffness, self.damping, rest))
