"""Base class of force elements: the record their laws read, and checks of input."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from ..base.checks import check_choice, shown
from ..base.errors import InputError
from ..base.fields import part_class
from .bodies import Body, Ground, Part
from .joints import Joint
from .primitives import Coordinate


@dataclass(frozen=True, eq=False)
class ForceRecord:
    """What the law of a force reads: bodies, world points, element axes, scalars, signals, coordinate, own states."""

    bodies: tuple
    points: tuple = ()  # one per body; none: it acts at no point (torques, loads along a coordinate)
    frame: np.ndarray = field(default_factory=lambda: np.eye(3))
    frame_b: np.ndarray | None = None  # other axes in b; None: the same
    values: tuple = ()
    signals: tuple = (None, None, None)
    coordinate: Coordinate | None = None
    measures: tuple = ()  # it reads
    numbers: tuple = ()  # gains, references, parameters
    states: tuple = ()  # initial values of its own states
    scales: tuple = ()  # of their errors: (unit, k, j) is unit length^k speed^j


@part_class()
class ForceElement(Part):
    """Base class of force elements.

    ``law(m, d, p, out, t)`` is the kernel of a class, as a static method (see `kernels.force_laws`); ``record()`` is
    what it reads of one element. A class in a file of `mechanism.forces` needs no more: `dynamics.loads` finds its law.
    """

    role = "force"
    law: ClassVar[Callable | None] = None
    shows: ClassVar[tuple[str, ...]] = ()  # what its law shows besides, after the point at which it acts

    def record(self) -> ForceRecord:
        """What the law reads of this element."""
        raise NotImplementedError

    def bodies(self) -> tuple[Any, ...]:
        """The bodies it acts on."""
        return self.record().bodies

    def partners(self) -> tuple[Any, ...]:
        """Joints and forces it refers to."""
        return ()

    def acts_at(self, body: Body | Ground) -> tuple[Body | Ground, np.ndarray]:
        """(body that carries it, world point at the reference pose) of the point at which its load on a body is given.

        A torque acts at no point: its is given at the centre of mass.
        """
        record = self.record()
        where = [other is body for other in record.bodies].index(True)
        return body, record.points[where] if record.points else body.centre

    def state_names(self) -> tuple[str, ...]:
        """Names of its own states, in their order."""
        return tuple(str(k) for k in range(len(self.record().states)))


def check_body(body: Any, what: str) -> None:
    """A Body, or a ValueError."""
    if not isinstance(body, Body):
        raise InputError(f"{what}: {shown(body)} is not a body; give a Body")


def check_pair(a: Any, b: Any, what: str) -> None:
    """Two different bodies, one of which may be the ground."""
    for body in (a, b):
        if not isinstance(body, Body | Ground):
            raise InputError(f"{what}: {shown(body)} is not a body; give a Body or GROUND")
    if a is b:
        raise InputError(f"{what}: acts between '{a.name}' and itself; give two different bodies")


def in_body_frame(frame: str, what: str) -> float:
    """1 for "body", 0 for "world"."""
    check_choice(frame, ("world", "body"), f"{what}: frame")
    return float(frame == "body")


def hinge_coordinate(hinge: Any, what: str) -> Coordinate:
    """The angle of a joint, else its slide."""
    found = (hinge.angle() or hinge.slide()) if isinstance(hinge, Joint) else None
    if found is None:
        raise InputError(f"{what}: {shown(hinge)} has no angle and no slide; give a Revolute, Cylindrical or Prismatic")
    return found
