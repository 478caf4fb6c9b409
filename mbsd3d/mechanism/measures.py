"""Measures: scalar functions of the state, named by part. ``measure > value`` is a condition for ``stop_when``.

Measures take numbers as factors and summands, in their unit: ``2.0 * measure - 0.1``, for `Solution.measure`, plots and
conditions.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import check_choice, number, short_repr, vector
from ..base.errors import InputError, checks_arguments
from ..base.rotations import WORLD_AXES, cross, perpendiculars, unit
from ..kernels import kinds
from .bodies import GROUND, Body, Ground, Part, describe_part
from .force_element import ForceElement
from .forces.by_table import ForceCurve
from .forces.contact import Contact
from .forces.springs import SpringDamper
from .joints import Joint, coordinate_of
from .mechanism import Mechanism
from .primitives import ZERO, Coordinate, check_kind
from .switching import is_switching

MEASURES = {
    "coordinate": kinds.COORDINATE,
    "coordinate rate": kinds.COORDINATE_RATE,
    "position": kinds.POSITION,
    "velocity": kinds.VELOCITY,
    "omega": kinds.TURN,
    "lean": kinds.LEAN,
    "lean rate": kinds.LEAN_RATE,
    "distance": kinds.GAP,
    "state": kinds.OWN_STATE,
    "clearance": kinds.CLEARANCE,
    "normal force": kinds.PRESS,
    "reaction force": kinds.REACTION_FORCE,
    "reaction moment": kinds.REACTION_MOMENT,
    "holding load": kinds.HOLDING,
    "sum": kinds.SUM,
    "excess load": kinds.EXCESS,
    "tension": kinds.TENSION,
}
PARALLEL_SINE_MAX = 1e-6  # [1] sine of the angle below which two directions span no plane
CONTACT_MEASURES = ("clearance", "normal force")
HOLDING_MEASURES = ("holding load", "excess load")  # of the row by which a part holds
JOINT_MEASURES = ("coordinate", "coordinate rate")
OF_REACTIONS = ("reaction force", "reaction moment")  # known where the equations have been solved
POSE_MEASURES = ("coordinate", "position", "lean", "distance", "clearance")
UNIT_EXPONENTS = {
    "rad": (0.0, 0.0), "m": (1.0, 0.0), "rad/s": (-1.0, 1.0), "m/s": (0.0, 1.0), "-": (0.0, 0.0), "N": (0.0, 0.0),
    "N m": (0.0, 0.0),
}  # fmt: skip
MEASURE_UNITS = {
    "coordinate": ("rad", "m"), "coordinate rate": ("rad/s", "m/s"), "position": ("m",), "velocity": ("m/s",),
    "omega": ("rad/s",), "lean": ("rad",), "lean rate": ("rad/s",), "distance": ("m",), "state": tuple(UNIT_EXPONENTS),
    "clearance": ("m",), "normal force": ("N",), "reaction force": ("N",), "reaction moment": ("N m",),
    "holding load": ("N", "N m"), "excess load": ("N", "N m"), "sum": ("rad", "m"),
    "tension": ("N",),
}  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class Measure:
    """A scalar function of the state; build one with the functions of this module."""

    kind: str  # a key of MEASURES
    label: str
    unit: str
    a: Body | Ground = GROUND
    b: Body | Ground = GROUND
    point_a: np.ndarray = field(default_factory=lambda: ZERO)
    point_b: np.ndarray = field(default_factory=lambda: ZERO)
    axis: np.ndarray = field(default_factory=lambda: ZERO)
    coordinate: Coordinate | None = None
    part: ForceElement | None = None  # force element it speaks of,
    index: int = 0  # and which of its internal states, or sections
    joint: Joint | None = None  # whose reaction it is, on its body b; the axis is fixed in a
    factor: float = 1.0  # the value is factor times what the kind says, plus the offset
    offset: float = 0.0  # [unit]
    plain_label: str = ""  # without factor and offset; "" = the label

    __array_ufunc__ = None  # 2.0 * measure also for numbers of numpy

    def __post_init__(self) -> None:
        """Check the measure: a file may describe one, and kernels do not check."""
        check_kind(self.kind, MEASURES, "Measure")
        states = 0 if self.part is None else len(self.part.record().states)
        fits = (self.coordinate is not None) == (self.kind in JOINT_MEASURES)
        own = 0 <= self.index < states if self.kind == "state" else self.part is None
        own = isinstance(self.part, Contact) if self.kind in CONTACT_MEASURES else own
        own = 0 <= self.index < strands_of(self.part) if self.kind == "tension" else own
        own = is_switching(self.part) if self.kind in HOLDING_MEASURES else own
        own = self.part is not None and bool(self.part.record().measures) if self.kind == "sum" else own
        own &= (self.joint is not None) == (self.kind in OF_REACTIONS)
        own &= self.joint is None or self.b is self.joint.b
        own &= bool(np.isfinite(self.offset)) and bool(np.isfinite(self.factor)) and self.factor != 0.0
        own &= all(np.shape(x) == (3,) for x in (self.point_a, self.point_b, self.axis))
        if self.unit not in MEASURE_UNITS[self.kind] or not fits or not own:
            raise InputError(
                f"measure '{self.label}': kind '{self.kind}' in {self.unit!r} does not fit its parts; build it with a "
                "function of mbsd3d.measures"
            )

    def __repr__(self) -> str:
        return f"<measure: {self.label} [{self.unit}]>"

    def __gt__(self, value: float) -> "Condition":
        return self._reaches(value, 1.0)

    def __lt__(self, value: float) -> "Condition":
        return self._reaches(value, -1.0)

    def _reaches(self, value: float, direction: float) -> "Condition":
        value = (number(value, f"threshold of {self.label}") - self.offset) / self.factor
        return Condition(self.plain(), value, direction if self.factor > 0.0 else -direction)

    def plain(self) -> "Measure":
        """Return the measure without factor and offset."""
        if self.factor == 1.0 and self.offset == 0.0:
            return self
        return replace(self, factor=1.0, offset=0.0, label=self.plain_label, plain_label="")

    def _scaled(self, factor: float, offset: float) -> "Measure":
        """Return factor times the measure plus an offset."""
        factor, offset, plain = self.factor * factor, self.offset * factor + offset, self.plain_label or self.label
        label = (f"{factor:g} x " if factor != 1.0 else "") + plain + (f" {offset:+g} {self.unit}" if offset else "")
        return replace(self, factor=factor, offset=offset, label=label, plain_label=plain)

    def _operand(self, value: object, sign: str) -> float:
        """Return the factor or summand of a measure as a number."""
        if isinstance(value, Measure):
            raise InputError(
                f"'{self.label}' {sign} '{value.label}': a measure combines with numbers only; combine the arrays of "
                "solution.measure([...])"
            )
        return number(value, f"'{self.label}' {sign}")

    def __mul__(self, factor: float) -> "Measure":
        factor = self._operand(factor, "*")
        if factor == 0.0:
            raise InputError(f"'{self.label}' * 0 is 0 whatever the motion; give another factor")
        return self._scaled(factor, 0.0)

    def __truediv__(self, divisor: float) -> "Measure":
        divisor = self._operand(divisor, "/")
        if divisor == 0.0:
            raise InputError(f"'{self.label}' / 0; give another divisor")
        return self._scaled(1.0 / divisor, 0.0)

    def __add__(self, offset: float) -> "Measure":
        return self._scaled(1.0, self._operand(offset, "+"))

    def __sub__(self, offset: float) -> "Measure":
        return self._scaled(1.0, -self._operand(offset, "-"))

    def __rsub__(self, offset: float) -> "Measure":
        return self._scaled(-1.0, self._operand(offset, "-"))

    def __neg__(self) -> "Measure":
        return self._scaled(-1.0, 0.0)

    __rmul__, __radd__ = __mul__, __add__

    __ge__, __le__ = __gt__, __lt__  # a run ends where the value is reached


@dataclass(frozen=True, eq=False)
class Condition:
    """A measure crosses a value upwards (direction 1) or downwards (-1)."""

    measure: Measure
    value: float
    direction: float

    def __bool__(self) -> bool:
        raise InputError(
            f"condition '{self}' is neither true nor false before a run, so 'and', 'or' and 'a < x < b' would drop a "
            "part of it; give stop_when a single comparison"
        )

    def __and__(self, other: object) -> "Condition":
        raise InputError(
            f"condition '{self}' is joined by & or |; stop_when takes a single comparison: run to the first one, and "
            "go on from the state there, solution.final, with the other"
        )

    __or__ = __rand__ = __ror__ = __and__

    def __str__(self) -> str:
        return f"{self.measure.label} {'>' if self.direction > 0 else '<'} {self.value:g} {self.measure.unit}"


def check_members(system: Mechanism, measure: Measure, what: str) -> None:
    """Check that a measure refers to bodies, joints and forces of this system."""
    members = {id(part) for part in (*system.bodies, *system.joints, *system.forces, GROUND)}
    members |= {id(joint.held()) for joint in system.joints}
    for part in (measure.a, measure.b, measure.part or GROUND, measure.joint or GROUND):
        if id(part) not in members:
            kind = "force" if part is measure.part else "joint" if part is measure.joint else "body"
            raise InputError(
                f"{what}: {measure.label}: {kind} '{part.name}' is not in the system; measure a part of this system"
            )


def unit_powers(measure: Measure) -> tuple[float, float, float]:
    """Return (1, k, j): errors of a measure are scaled by length^k speed^j."""
    return (1.0, *UNIT_EXPONENTS[measure.unit])


def label(part: Body | Ground | Part) -> str:
    """Name of a part for messages."""
    return getattr(part, "name", None) or type(part).__name__


def of_coordinate(x: Coordinate, what: str, rate: bool = False) -> Measure:
    """Return the measure that reads a hinge coordinate, or its rate."""
    turns = x.kind in ("angle", "bearing")
    unit_of = ("rad/s" if rate else "rad") if turns else ("m/s" if rate else "m")
    return Measure("coordinate rate" if rate else "coordinate", what, unit_of, x.a, x.b, coordinate=x)


@checks_arguments
def angle(hinge: Joint) -> Measure:
    """Return the angle of a hinge [rad], unwrapped, zero at the reference pose."""
    return of_coordinate(coordinate_of(hinge, "angle", "measures.angle"), f"angle of {label(hinge)}")


@checks_arguments
def rate(hinge: Joint) -> Measure:
    """Return the rate of the angle of a hinge [rad/s]."""
    return of_coordinate(coordinate_of(hinge, "angle", "measures.rate"), f"rate of {label(hinge)}", rate=True)


@checks_arguments
def slide(slider: Joint) -> Measure:
    """Return the displacement of a sliding joint [m]."""
    return of_coordinate(coordinate_of(slider, "slide", "measures.slide"), f"slide of {label(slider)}")


@checks_arguments
def slide_rate(slider: Joint) -> Measure:
    """Return the speed of a sliding joint [m/s]."""
    x = coordinate_of(slider, "slide", "measures.slide_rate")
    return of_coordinate(x, f"slide rate of {label(slider)}", rate=True)


def body_or_error(body: Any, what: str) -> None:
    """Accept a body or the ground."""
    if not isinstance(body, Body | Ground):
        raise InputError(f"{what}: {short_repr(body)} is not a body; give a Body")


def point_of(body: Body | Ground, at: ArrayLike | None, what: str) -> np.ndarray:
    """Return the world point at the reference pose; None = centre of mass."""
    if at is not None:
        return vector(at, f"{what}: at")
    return body.centre


@checks_arguments
def position(body: Body, *, axis: ArrayLike, at: ArrayLike | None = None) -> Measure:
    """Return the world coordinate of a point of a body along ``axis`` [m]; ``at`` None = centre of mass."""
    body_or_error(body, "measures.position")
    point, axis = point_of(body, at, "measures.position"), unit(axis, "measures.position: axis")
    return Measure("position", f"position of {label(body)}", "m", GROUND, body, ZERO, point, axis)


@checks_arguments
def velocity(body: Body, *, axis: ArrayLike, at: ArrayLike | None = None) -> Measure:
    """Return the velocity of a point of a body along the world direction ``axis`` [m/s]."""
    body_or_error(body, "measures.velocity")
    point, axis = point_of(body, at, "measures.velocity"), unit(axis, "measures.velocity: axis")
    return Measure("velocity", f"velocity of {label(body)}", "m/s", GROUND, body, ZERO, point, axis)


@checks_arguments
def omega(body: Body, *, axis: ArrayLike) -> Measure:
    """Return the angular velocity of a body along the world direction ``axis`` [rad/s]."""
    body_or_error(body, "measures.omega")
    return Measure("omega", f"omega of {label(body)}", "rad/s", GROUND, body, axis=unit(axis, "measures.omega: axis"))


@checks_arguments
def lean(body: Body, *, lateral: ArrayLike = (0.0, 1.0, 0.0)) -> Measure:
    """Return the elevation of a body's lateral axis above the horizontal [rad] (y left, z up: > 0 to the right).

    ``lateral`` is given in world axes at the reference pose.
    """
    body_or_error(body, "measures.lean")
    axis = body.local_axis(unit(lateral, "measures.lean: lateral"))
    return Measure("lean", f"lean of {label(body)}", "rad", GROUND, body, axis=axis)


@checks_arguments
def lean_rate(body: Body, *, lateral: ArrayLike = (0.0, 1.0, 0.0)) -> Measure:
    """Return the rate of `lean` [rad/s]."""
    body_or_error(body, "measures.lean_rate")
    axis = body.local_axis(unit(lateral, "measures.lean_rate: lateral"))
    return Measure("lean rate", f"lean rate of {label(body)}", "rad/s", GROUND, body, axis=axis)


@checks_arguments
def distance(
    a: Body | Ground, b: Body | Ground, *, at_a: ArrayLike | None = None, at_b: ArrayLike | None = None
) -> Measure:
    """Return the distance between a point of a and a point of b [m]; None = centre of mass."""
    for body in (a, b):
        body_or_error(body, "measures.distance")
    point_a, point_b = point_of(a, at_a, "measures.distance"), point_of(b, at_b, "measures.distance")
    return Measure("distance", f"distance {label(a)} to {label(b)}", "m", a, b, point_a, point_b)


@checks_arguments
def state(force: ForceElement, index: int | str = 0) -> Measure:
    """Return the internal state of a force element, by its number from 0 or its name, e.g. of a `CustomForce`.

    ValueError if it has no such state.
    """
    record = force.record() if isinstance(force, ForceElement) else None
    states = record.states if record else ()
    names = force.state_names() if states else ()
    if index in names:
        index = names.index(index)
    if type(index) is not int or not 0 <= index < len(states):
        remedy = f"give one of {', '.join(names)}, or its number" if names else "give a force with internal states"
        raise InputError(f"measures.state: {label(force)} has no internal state {short_repr(index)}; {remedy}")
    what = record.measures[index].unit if record.measures else "-"  # a filter has the unit of what it sees
    return Measure("state", f"state {names[index]} of {label(force)}", what, part=force, index=index)


def strands_of(part: Any) -> int:
    """Return the number of sections of a rope or belt that have a tension each; 0 for all else."""
    return part.strands if isinstance(part, ForceElement) else 0


@checks_arguments
def tension(rope: ForceElement, section: int = 0) -> Measure:
    """Return the tension of a section of a `Rope`, or of a strand of a `Belt` [N], >= 0.

    Parameters
    ----------
    rope : Rope or Belt
    section : int
        Number from 0, in the order of ``solution.force(rope).tension``: rough pulleys part a rope into sections, a belt
        has two strands.

    Raises
    ------
    ValueError
        If it is no rope or belt, or has no such section.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Rope, System, measures, simulate
    >>> bell = Body("bell", mass=2.0, inertia=(0.1, 0.1, 0.1), position=(0, 0, -1.5))
    >>> rope = Rope(((GROUND, (0, 0, 0)), (bell, (0, 0, -1.5))), stiffness=3e3, length=2.0)
    >>> fall = simulate(System([bell], forces=[rope]), 1.0, stop_when=measures.tension(rope) > 150.0)
    >>> round(float(-fall.position(bell)[-1, 2]), 9)  # stretched by 0.05 m
    2.05
    """
    count = strands_of(rope)
    if count == 0:
        raise InputError(f"measures.tension: {short_repr(rope)} has no tension; give a Rope or a Belt")
    if type(section) is not int or not 0 <= section < count:
        raise InputError(f"measures.tension: {label(rope)} has no section {short_repr(section)}; give 0 to {count - 1}")
    which = f" {section}" if count > 1 else ""
    return Measure("tension", f"tension{which} of {label(rope)}", "N", part=rope, index=section)


def of_contact(contact: ForceElement, kind: str, unit_of: str, what: str = "") -> Measure:
    """Return a measure of a `Contact`, or raise a ValueError of the function ``what``."""
    if not isinstance(contact, Contact):
        what = what or kind.replace(" ", "_")
        raise InputError(f"measures.{what}: {short_repr(contact)} is not a contact; give a Contact")
    return Measure(kind, f"{kind} of {label(contact)}", unit_of, contact.a, contact.b, part=contact)


@checks_arguments
def clearance(contact: ForceElement) -> Measure:
    """Return the clearance [m] between the surface of a `Contact` and its plane or other surface; < 0 in contact."""
    return of_contact(contact, "clearance", "m")


@checks_arguments
def normal_force(contact: ForceElement) -> Measure:
    """Force [N] with which a `Contact` presses, >= 0."""
    return of_contact(contact, "normal force", "N")


@checks_arguments
def touches(contact: ForceElement) -> Condition:
    """Return the condition that the surface of a `Contact` reaches its plane or other surface; for ``stop_when``."""
    return of_contact(contact, "clearance", "m", "touches") < 0.0


@checks_arguments
def leaves(contact: ForceElement) -> Condition:
    """Return the condition that a `Contact` lifts off, for ``stop_when``; with damping this is before d = 0."""
    return of_contact(contact, "normal force", "N", "leaves") < 0.0


@checks_arguments
def reaction(joint: Joint, *, axis: ArrayLike | None = None, of: str = "force", axes: str = "world") -> Measure:
    """Return the reaction of a joint on its body b: force [N], or moment about the point of the joint [N m].

    Parameters
    ----------
    axis : (3,) array_like or None
        Direction of the component, world at the reference pose; None = the size of the whole vector.
    of : "force" or "moment"
    axes : "world", "a" or "b"
        Axes in which the direction is fixed: the world, or body a or b of the joint.

    Use it in ``stop_when``, in curves and in `solution.measure`. Each evaluation within a step solves the equations of
    motion once. A reaction that the constraints do not determine is rejected.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, System, measures, simulate
    >>> bob = Body("bob", mass=2.0, inertia=(0.1, 0.1, 0.1), com=(0.5, 0, 0))
    >>> pin = Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, 1, 0))
    >>> swing = simulate(System([bob], [pin]), 1.0, stop_when=measures.reaction(pin) > 30.0)
    >>> round(float(swing.measure(measures.reaction(pin))[-1]), 6)
    30.0
    """
    what = "measures.reaction"
    if not isinstance(joint, Joint):
        raise InputError(f"{what}: {short_repr(joint)} is not a joint; give the part itself")
    check_choice(of, ("force", "moment"), f"{what}: of")
    check_choice(axes, ("world", "a", "b"), f"{what}: axes")
    if of == "moment" and type(joint).reaction_points is not Joint.reaction_points:
        raise InputError(
            f"{what}: the point of {describe_part(joint)} travels, and a moment belongs to a point; give a force"
        )
    fixed_in = GROUND if axes == "world" else getattr(joint, axes)
    along = ZERO if axis is None else fixed_in.local_axis(unit(axis, f"{what}: axis"))
    return Measure(
        f"reaction {of}", f"reaction {of} of {label(joint)}", "N" if of == "force" else "N m", fixed_in, joint.b,
        ZERO, joint.point(), along, joint=joint,
    )  # fmt: skip


def protractor(
    a: Body | Ground, b: Body | Ground, axis: np.ndarray, zero: np.ndarray, direction: np.ndarray, what: str
) -> Coordinate:
    """Return the angle about ``axis`` of a from ``zero``, fixed in a, to ``direction``, fixed in b."""
    for x in (zero, direction):
        if np.linalg.norm(cross(axis, x)) < PARALLEL_SINE_MAX:
            raise InputError(
                f"{what}: {x.tolist()} lies along the axis {axis.tolist()} it is turned about; give another"
            )
    zero = unit(zero - axis * (axis @ zero), f"{what}: zero")
    return Coordinate("angle", a, b, axis, axis, zero_a=zero, zero_b=direction)


@checks_arguments
def heading(body: Body, *, forward: ArrayLike = (1.0, 0.0, 0.0)) -> Measure:
    """Return the angle of a body about z [rad] from the world x axis to its forward axis, > 0 to the left (z up).

    ``forward`` is given in world axes at the reference pose.
    """
    return of_coordinate(_heading(body, forward, "measures.heading"), f"heading of {label(body)}")


@checks_arguments
def heading_rate(body: Body, *, forward: ArrayLike = (1.0, 0.0, 0.0)) -> Measure:
    """Return the rate of `heading` [rad/s]."""
    return of_coordinate(_heading(body, forward, "measures.heading_rate"), f"heading rate of {label(body)}", rate=True)


def _heading(body: Body, forward: ArrayLike, what: str) -> Coordinate:
    body_or_error(body, what)
    return protractor(GROUND, body, WORLD_AXES[2], WORLD_AXES[0], unit(forward, f"{what}: forward"), what)


@checks_arguments
def camber(wheel: Body, *, axle: ArrayLike = (0.0, 1.0, 0.0)) -> Measure:
    """Return the elevation of a wheel's axle above the horizontal [rad], > 0 if the wheel leans right (y left).

    ``axle`` is given in world axes at the reference pose; the spin of the wheel does not matter.
    """
    body_or_error(wheel, "measures.camber")
    return replace(lean(wheel, lateral=unit(axle, "measures.camber: axle")), label=f"camber of {label(wheel)}")


@checks_arguments
def angle_between(
    a: Body | Ground, b: Body | Ground, *, axis_a: ArrayLike, axis_b: ArrayLike, about: ArrayLike | None = None
) -> Measure:
    """Return the angle from an axis of a to an axis of b [rad], about an axis fixed in a.

    Parameters
    ----------
    a, b : Body or GROUND
    axis_a, axis_b : (3,) array_like
        World at the reference pose.
    about : (3,) array_like or None
        World at the reference pose; None = ``axis_a x axis_b``, so that the angle starts between 0 and pi and is that
        between the axes as long as they turn in this plane.

    Raises
    ------
    ValueError
        If the axes are parallel at the reference pose and ``about`` is not given.
    """
    what = "measures.angle_between"
    for body in (a, b):
        body_or_error(body, what)
    first, second = unit(axis_a, f"{what}: axis_a"), unit(axis_b, f"{what}: axis_b")
    if about is None:
        about = cross(first, second)
        if np.linalg.norm(about) < PARALLEL_SINE_MAX:
            raise InputError(f"{what}: the axes are parallel at the reference pose; give the axis as about=")
    x = protractor(a, b, unit(about, f"{what}: about"), first, second, what)
    return of_coordinate(x, f"angle {label(a)} to {label(b)}")


@checks_arguments
def turn(a: Body | Ground, b: Body | Ground, *, about: ArrayLike) -> Measure:
    """Return the angle of b relative to a about an axis fixed in a [rad], zero at the reference pose."""
    return of_coordinate(_turn(a, b, about, "measures.turn"), f"turn of {label(b)} from {label(a)}")


@checks_arguments
def turn_rate(a: Body | Ground, b: Body | Ground, *, about: ArrayLike) -> Measure:
    """Return the rate of `turn` [rad/s]."""
    x = _turn(a, b, about, "measures.turn_rate")
    return of_coordinate(x, f"turn rate of {label(b)} from {label(a)}", rate=True)


def _turn(a: Body | Ground, b: Body | Ground, about: ArrayLike, what: str) -> Coordinate:
    for body in (a, b):
        body_or_error(body, what)
    axis = unit(about, f"{what}: about")
    zero = perpendiculars(axis)[0]
    return protractor(a, b, axis, zero, zero, what)


@checks_arguments
def offset(
    a: Body | Ground,
    b: Body | Ground,
    *,
    along: ArrayLike,
    at_a: ArrayLike | None = None,
    at_b: ArrayLike | None = None,
) -> Measure:
    """Return the distance along an axis fixed in a from a point of a to a point of b [m]; None = centre of mass."""
    return of_coordinate(_offset(a, b, along, at_a, at_b, "measures.offset"), f"offset of {label(b)} from {label(a)}")


@checks_arguments
def offset_rate(
    a: Body | Ground,
    b: Body | Ground,
    *,
    along: ArrayLike,
    at_a: ArrayLike | None = None,
    at_b: ArrayLike | None = None,
) -> Measure:
    """Return the rate of `offset` [m/s]."""
    x = _offset(a, b, along, at_a, at_b, "measures.offset_rate")
    return of_coordinate(x, f"offset rate of {label(b)} from {label(a)}", rate=True)


def _offset(
    a: Body | Ground, b: Body | Ground, along: ArrayLike, at_a: ArrayLike | None, at_b: ArrayLike | None, what: str
) -> Coordinate:
    for body in (a, b):
        body_or_error(body, what)
    axis = unit(along, f"{what}: along")
    return Coordinate("slide", a, b, axis, axis, point_of(a, at_a, what), point_of(b, at_b, what))


@checks_arguments
def between(
    a: Body | Ground, b: Body | Ground, *, at_a: ArrayLike | None = None, at_b: ArrayLike | None = None
) -> dict[str, Measure]:
    """Return the pose of b relative to a: "x", "y", "z" [m] by `offset`; "turn_x", "turn_y", "turn_z" [rad] by `turn`.

    Along and about the axes of a that are world axes at the reference pose.
    """
    names = f"{label(b)} from {label(a)}"
    found = {}
    for name, axis in zip("xyz", WORLD_AXES, strict=True):
        found[name] = replace(offset(a, b, along=axis, at_a=at_a, at_b=at_b), label=f"{name} of {names}")
    for name, axis in zip("xyz", WORLD_AXES, strict=True):
        found[f"turn_{name}"] = replace(turn(a, b, about=axis), label=f"turn about {name} of {names}")
    return found


@checks_arguments
def length(spring: SpringDamper | ForceCurve) -> Measure:
    """Return the length of a spring or damper between two points [m]."""
    if not isinstance(spring, SpringDamper | ForceCurve):
        raise InputError(
            f"measures.length: {short_repr(spring)} is not a SpringDamper or ForceCurve; use measures.distance(a, b)"
        )
    measure = distance(spring.a, spring.b, at_a=spring.at_a, at_b=spring.at_b)
    return replace(measure, label=f"length of {label(spring)}")
