"""Joints that engage and release during a run: by conditions, or at a load."""

from collections.abc import Sequence
from dataclasses import KW_ONLY
from typing import Any, ClassVar

import numpy as np

from ..base.checks import short_repr
from ..base.errors import InputError
from ..base.fields import Number, Truth, kept, part_class
from .bodies import Body, Ground
from .couplings import Coupling
from .drivers import Driver
from .engaged import Engaged, JointOfAnother
from .joints import Joint
from .joints.pairs import Screw
from .measures import Condition, reaction
from .primitives import Coordinate, Primitive
from .switching import OPEN, Mode, Switching, Watch

AS_BUILT = Mode("as built")


def as_condition(value: Any, what: str, part: Any) -> Condition | None:
    """Accept a condition, or None."""
    if value is None or isinstance(value, Condition):
        return value
    raise InputError(f"{what} = {short_repr(value)} is not a condition; write e.g. measures.angle(hinge) > 1.2")


@part_class()
class SwitchedJoint(Switching, JointOfAnother):
    """Base class of joints that are active only part of the time."""

    without_events: ClassVar[str] = "use system.engage and release"

    def check(self, what: str) -> None:
        if not isinstance(self.joint, Joint) or isinstance(self.joint, Driver | Screw | SwitchedJoint | Engaged):
            remedy = "give a joint that holds two bodies, or a coupling"
            if isinstance(self.joint, Screw):
                remedy = "end the run and use system.engage"
            raise InputError(f"{what}: {short_repr(self.joint)} cannot be switched; {remedy}")
        if self.joint.reflected():
            raise InputError(
                f"{what}: {short_repr(self.joint)} has a reflected inertia, which would come and go with the joint; "
                "give it to a hinge or slide that stays"
            )

    def bodies(self) -> tuple[Body | Ground, ...]:
        return self.joint.bodies()

    def rows(self) -> list[Primitive]:
        return list(self.rows_in(self.first_mode()))

    def rows_in(self, mode: Mode) -> Sequence[Primitive]:
        if mode.name == OPEN.name:
            return []
        return self.joint.rows() if mode.name == AS_BUILT.name else self.engaged_in(mode).rows()

    def engaged_in(self, mode: Mode) -> Engaged:
        """Return the joint as it engaged."""
        x = mode.numbers
        if mode.name != "engaged" or len(x) != 9:
            raise InputError(f"{self.what()}: mode {short_repr(tuple(mode))} is unknown; give a state of a run")
        return Engaged(self.joint, shift=x[:3], turn=x[3:7], length=x[7] or None, offset=x[8])

    @property
    def couples(self) -> bool:
        """Return whether the joint couples hinge coordinates of other joints."""
        return isinstance(self.joint, Coupling)

    def angle(self) -> Coordinate | None:
        return self.joint.angle()

    def slide(self) -> Coordinate | None:
        return self.joint.slide()

    def point(self) -> np.ndarray:
        return self.joint.point()

    def held(self) -> Joint:
        return self.joint


def engaged_mode(joint: Engaged) -> Mode:
    """Return the mode of a joint that has engaged at a pose."""
    return Mode("engaged", (*map(float, joint.shift), *map(float, joint.turn), joint.length or 0.0, joint.offset))


@part_class()
class Switched(SwitchedJoint):
    """A joint that engages and releases in a run, each time a condition becomes true.

    Where it engages it takes the pose of the moment, as `System.engage` does: points and axes rest in body a, body b is
    held as it stands, a `Distance` takes the length and a coupling the offset. The impact is plastic: momentum is kept,
    and the energy lost stands in ``solution.events``. Its angle and slide count from the reference pose at all times.

    Parameters
    ----------
    joint : Joint
        Not itself in the system. A `Screw` and drivers are refused.
    engage, release : Condition or None
        ``measure > value`` or ``measure < value``. Each acts when it comes true, not while it is true; None = never.
    engaged : bool
        Whether it holds at the start, then as built: at the reference pose.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, PointOnLine, Revolute, Switched, System, measures, simulate
    >>> door = Body("door", mass=20.0, inertia=(3.0, 3.4, 1.35), com=(0.45, 0, 0))
    >>> hinge = Revolute(GROUND, door, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")
    >>> bolt = PointOnLine(GROUND, door, at=(0.85, 0, 0), axis=(1, 0, 0))
    >>> latch = Switched(bolt, engage=measures.angle(hinge) > 0.0, name="latch")
    >>> house = System([door], [hinge, latch])
    >>> run = simulate(house, 1.0, state=house.assemble(angles={hinge: -0.9}, rates={hinge: 1.8}))
    >>> run.events[0], float(run.rate(hinge)[-1].round(9))
    (<0.5 s: 'latch' engages, 8.748 J lost>, 0.0)
    """

    _: KW_ONLY
    engage: Condition | None = kept(default=None, by=as_condition)
    release: Condition | None = kept(default=None, by=as_condition)
    engaged: Truth = kept(default=False)

    def check(self, what: str) -> None:
        SwitchedJoint.check(self, what)
        if self.engage is None and (self.release is None or not self.engaged):
            raise InputError(f"{what}: never engages; give engage=, or engaged=True and release=")

    def first_mode(self) -> Mode:
        return AS_BUILT if self.engaged else OPEN

    def watched(self, mode: Mode) -> list[Watch]:
        condition, action = (self.engage, "engages") if mode.name == OPEN.name else (self.release, "is released")
        return [] if condition is None else [Watch(condition, action)]


@part_class()
class Breaks(SwitchedJoint):
    """A joint that breaks for good when the size of its force reaches a limit.

    Parameters
    ----------
    joint : Joint
        Not itself in the system: `Breaks` stands for it, has its angle, slide and reaction, and carries springs.
    force : float
        Size of the reaction force at which it breaks [N].

    Raises
    ------
    ValueError
        From a run, if the constraints do not determine the reaction of the joint.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Breaks, Revolute, System, simulate
    >>> bob = Body("bob", mass=2.0, inertia=(0.1, 0.1, 0.1), com=(0.5, 0, 0))
    >>> pin = Breaks(Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, 1, 0)), force=30.0, name="pin")
    >>> run = simulate(System([bob], [pin]), 1.0)
    >>> run.events[0].what, round(float(run.reaction(pin).force[-1] @ (0, 0, 1)), 9)
    ("'pin' breaks", 0.0)
    """

    _: KW_ONLY
    force: Number = kept(positive=True)

    def first_mode(self) -> Mode:
        return AS_BUILT

    def watched(self, mode: Mode) -> list[Watch]:
        return [] if mode.name == OPEN.name else [Watch(reaction(self) > self.force, "breaks")]
