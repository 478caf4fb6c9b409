"""Base class of force elements: the record their laws read, and checks of input."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from ..base.checks import check_choice, short_repr
from ..base.errors import InputError
from ..base.fields import part_class
from ..compiler.records import Parameters
from .bodies import Body, Ground, Part
from .joints import Joint
from .primitives import Coordinate


@dataclass(frozen=True, eq=False)
class ForceRecord:
    """Input of a force law: bodies, points, axes, parameters, signals, coordinate and internal states."""

    bodies: tuple
    points: tuple = ()  # one per body; none: it acts at no point (torques, loads along a coordinate)
    frame: np.ndarray = field(default_factory=lambda: np.eye(3))
    frame_b: np.ndarray | None = None  # other axes in b; None: the same
    parameters: Mapping[str, Any] = field(default_factory=dict)  # by the names that its law declares
    option: int = 0  # a choice that its law knows
    signals: tuple = (None, None, None)
    coordinate: Coordinate | None = None
    measures: tuple = ()  # it reads
    series: tuple = ()  # sequences of numbers, as many as its law asks for: gains and references
    states: tuple = ()  # initial values of its internal states
    scales: tuple = ()  # of their errors: (unit, k, j) is unit length^k speed^j
    joint: Joint | None = None  # whose reaction its law reads


@part_class()
class ForceElement(Part):
    """Base class of force elements.

    ``law(m, d, p, out, t)`` is the kernel of a class, as a static method (see `kernels.force_laws`); ``record()`` is
    what it reads of one element. A class in a file of `mechanism.forces` needs no more: `dynamics.applied_forces` finds
    its law.
    """

    role = "force"
    law: ClassVar[Callable | None] = None
    law_parameters: ClassVar[Parameters] = Parameters()  # that the law reads by name
    shows: ClassVar[tuple[str, ...]] = ()  # what its law shows besides, after the point at which it acts

    def record(self) -> ForceRecord:
        """Return the record of this element that its compiled law reads."""
        raise NotImplementedError

    @cached_property
    def own_record(self) -> ForceRecord:
        """Return `record`, made once."""
        return self.record()

    def read_by_law(self, **own: Any) -> dict[str, Any]:
        """Return the parameters of the law by name: ``own`` ones, else the attributes of that name."""
        return {name: own[name] if name in own else getattr(self, name) for name in self.law_parameters.units}

    def signal_unit(self) -> str:
        """Return the unit of its signals; "-" without one, or with different ones."""
        return "-"

    def bodies(self) -> tuple[Any, ...]:
        """Return the bodies the element acts on."""
        return self.own_record.bodies

    @property
    def strands(self) -> int:
        """Return the number of sections that have a tension each, as those of a rope; 0 for all else."""
        return 0

    def partners(self) -> tuple[Any, ...]:
        """Return the joints and forces the element refers to."""
        return ()

    def acts_at(self, body: Body | Ground) -> tuple[Body | Ground, np.ndarray]:
        """Return (body that carries it, world point at the reference pose) of the point at which the load is given.

        A torque acts at no point; the centre of mass is returned for it.
        """
        record = self.record()
        where = [other is body for other in record.bodies].index(True)
        return body, record.points[where] if record.points else body.centre

    def state_names(self) -> tuple[str, ...]:
        """Return the names of the element's internal states, in their order."""
        return tuple(str(k) for k in range(len(self.record().states)))


def check_body(body: Any, what: str) -> None:
    """Accept a Body."""
    if not isinstance(body, Body):
        raise InputError(f"{what}: {short_repr(body)} is not a body; give a Body")


def check_pair(a: Any, b: Any, what: str) -> None:
    """Check that two bodies differ; one of them may be the ground."""
    for body in (a, b):
        if not isinstance(body, Body | Ground):
            raise InputError(f"{what}: {short_repr(body)} is not a body; give a Body or GROUND")
    if a is b:
        raise InputError(f"{what}: acts between '{a.name}' and itself; give two different bodies")


def in_body_frame(frame: str, what: str) -> int:
    """Return 1 for "body", 0 for "world"."""
    check_choice(frame, ("world", "body"), f"{what}: frame")
    return int(frame == "body")


def hinge_coordinate(hinge: Any, what: str) -> Coordinate:
    """Return the angle of a joint, else its slide."""
    found = (hinge.angle() or hinge.slide()) if isinstance(hinge, Joint) else None
    if found is None:
        raise InputError(
            f"{what}: {short_repr(hinge)} has no angle and no slide; give a Revolute, Cylindrical or Prismatic"
        )
    return found
