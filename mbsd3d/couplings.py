"""Couplings: rows on the angles and slides of other joints."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .joints import Joint, coordinate_of
from .parts import number
from .primitives import Primitive, ratio


@dataclass(frozen=True, eq=False)
class Coupling(Joint):
    """Row on the coordinates of other joints; a and b are those of the joint it acts through."""

    def through(self) -> Joint:
        """The joint whose bodies carry the reaction."""
        raise NotImplementedError

    @property
    def a(self) -> Any:
        """Body a of the joint it acts through."""
        return self.through().a

    @property
    def b(self) -> Any:
        """Body b of the joint it acts through."""
        return self.through().b

    def point(self) -> np.ndarray:
        return self.through().point()

    def partners(self) -> list[Joint]:
        return [self.through()]


@dataclass(frozen=True, eq=False)
class Gear(Coupling):
    """Two hinges turn in a fixed ratio = angle_b / angle_a (1 row); ratio < 0 for an external mesh.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Gear, Revolute, System
    >>> one, two = (Body(name, mass=1.0, inertia=(0.1, 0.1, 0.2)) for name in ("one", "two"))
    >>> a = Revolute(GROUND, one, at=(0, 0, 0), axis=(0, 0, 1), name="a")
    >>> b = Revolute(GROUND, two, at=(0.3, 0, 0), axis=(0, 0, 1), name="b")
    >>> System([one, two], [a, b, Gear(a, b, ratio=-0.5)]).check().mobility
    1
    """

    hinge_a: Joint
    hinge_b: Joint
    ratio: float = field(kw_only=True)

    def through(self) -> Joint:
        return self.hinge_b

    def partners(self) -> list[Joint]:
        return [self.hinge_a, self.hinge_b]

    def check(self, what: str) -> None:
        for hinge in (self.hinge_a, self.hinge_b):
            coordinate_of(hinge, "angle", what)
        if self.hinge_a is self.hinge_b:
            raise ValueError(f"{what}: both hinges are '{self.hinge_a.name}'; give two")
        self.set(ratio=number(self.ratio, f"{what}: ratio"))
        if self.ratio == 0.0:
            raise ValueError(f"{what}: ratio is 0; give angle_b / angle_a, or lock hinge_b with Fixed")

    def rows(self) -> list[Primitive]:
        return [ratio(self.hinge_a.angle(), -self.ratio, self.hinge_b.angle(), 1.0)]


@dataclass(frozen=True, eq=False)
class RackPinion(Coupling):
    """A rack moves by ``radius`` [m] times the angle of a pinion (1 row): slide = radius angle; radius may be < 0.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Prismatic, RackPinion, Revolute, System
    >>> wheel, bar = (Body(name, mass=1.0, inertia=(0.1, 0.1, 0.2)) for name in ("wheel", "bar"))
    >>> a = Revolute(GROUND, wheel, at=(0, 0, 0), axis=(0, 1, 0), name="a")
    >>> b = Prismatic(GROUND, bar, at=(0, 0, 0.2), axis=(1, 0, 0), name="b")
    >>> System([wheel, bar], [a, b, RackPinion(a, b, radius=0.2)]).check().mobility
    1
    """

    pinion: Joint
    rack: Joint
    radius: float = field(kw_only=True)

    def through(self) -> Joint:
        return self.rack

    def partners(self) -> list[Joint]:
        return [self.pinion, self.rack]

    def check(self, what: str) -> None:
        coordinate_of(self.pinion, "angle", what)
        coordinate_of(self.rack, "slide", what)
        self.set(radius=number(self.radius, f"{what}: radius"))

    def rows(self) -> list[Primitive]:
        return [ratio(self.pinion.angle(), -self.radius, self.rack.slide(), 1.0, in_metres=True)]
