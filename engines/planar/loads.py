"""Loads of a planar mechanism: force, spring, torsion spring."""

from dataclasses import dataclass, field
from typing import Any

from engines.planar import rows as kinds
from engines.planar.bodies import GROUND, UNIT, Body, Motion, Part, Row, check_bodies, ends, pair
from mbsd3d.errors import InputError
from mbsd3d.extend import number


@dataclass(frozen=True, eq=False)
class Force(Part):
    """Force (2,) [N] at a point of a body (None: centre of mass) and torque [N m], times ``motion`` of time.

    Components along the axes of the world or, with ``frame`` "body", along those of the body.
    """

    body: Body
    force: Any = (0.0, 0.0)
    torque: float = field(default=0.0, kw_only=True)
    at: Any = field(default=None, kw_only=True)
    frame: str = field(default="world", kw_only=True)
    motion: Motion = field(default=UNIT, kw_only=True)

    def check(self, what: str) -> None:
        if not isinstance(self.body, Body):
            raise InputError(f"{what}: {self.body!r} is not a planar body; give a Body")
        if self.frame not in ("world", "body"):
            raise InputError(f"{what}: frame {self.frame!r} is unknown; give 'world' or 'body'")
        self.set(force=pair(self.force, f"{what}: force"), torque=number(self.torque, f"{what}: torque"))
        at = self.body.com if self.at is None else self.body.local_point(pair(self.at, f"{what}: at"))
        self.set(at=at)

    def load(self) -> Row:
        """Return kind, (body of the axes, body of the point) and numbers of the force."""
        axes = self.body if self.frame == "body" else GROUND
        return Row(kinds.FORCE, (axes, self.body), (*self.force, *self.at, self.torque), self.motion)


def constants(spring: Any, what: str) -> dict[str, float]:
    """Return stiffness and damping, both >= 0."""
    return {name: number(getattr(spring, name), f"{what}: {name}", minimum=0.0) for name in ("stiffness", "damping")}


@dataclass(frozen=True, eq=False)
class Spring(Part):
    """Spring and damper between two points: tension ``k (l - l0) + c l_dot``; ``length`` None = as at the reference."""

    a: Any
    b: Any
    at_a: Any = field(kw_only=True)
    at_b: Any = field(kw_only=True)
    stiffness: float = field(kw_only=True)
    damping: float = field(default=0.0, kw_only=True)
    length: float | None = field(default=None, kw_only=True)

    def check(self, what: str) -> None:
        check_bodies(self, what)
        span = ends(self, what, "a spring needs a direction; move one")
        length = span if self.length is None else number(self.length, f"{what}: length", minimum=0.0)
        self.set(length=length, **constants(self, what))

    def load(self) -> Row:
        """Return kind, bodies and numbers of the spring."""
        a, b = self.a.local_point(self.at_a), self.b.local_point(self.at_b)
        return Row(kinds.SPRING, (self.a, self.b), (*a, *b, self.stiffness, self.damping, self.length))


@dataclass(frozen=True, eq=False)
class TorsionSpring(Part):
    """Torque ``-k (angle - angle0) - c rate`` on b, the angle of b relative to a counted from the reference pose."""

    a: Any
    b: Any
    stiffness: float = field(kw_only=True)
    damping: float = field(default=0.0, kw_only=True)
    angle: float = field(default=0.0, kw_only=True)

    def check(self, what: str) -> None:
        check_bodies(self, what)
        self.set(angle=number(self.angle, f"{what}: angle"), **constants(self, what))

    def load(self) -> Row:
        """Return kind, bodies and numbers of the torsion spring."""
        rest = self.angle + self.b.angle - self.a.angle
        return Row(kinds.TORSION, (self.a, self.b), (self.stiffness, self.damping, rest))
