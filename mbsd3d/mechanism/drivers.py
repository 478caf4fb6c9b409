"""Drivers: rows with a prescribed motion. Displacements count from the reference pose."""

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY
from itertools import pairwise
from numbers import Real
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import floats, short_repr
from ..base.errors import InputError
from ..base.fields import DirectionOrNone, Stored, Vector, VectorOrNone, derive, kept, locked, or_none, part_class
from ..base.rotations import as_quaternion, by_letter, conjugate, logarithm, multiply, unit
from ..kernels import kinds
from .bodies import GROUND, Body, Ground
from .couplings import Coupling
from .joints import Joint, angle_of, coordinate_of, slide_of
from .joints.conditions import ends_coincide
from .primitives import ZERO, Primitive, in_plane, ratio
from .signals import Constant, Signal, SignalField, ThreeSignalsOrFree, as_signal
from .signals.curves import Table

TURN = 2.0 * np.pi  # [rad]


class Driver(Joint):
    """A joint that prescribes a motion; `Solution.effort` gives the required torque or force.

    Examples
    --------
    >>> from mbsd3d import GROUND, AngleDriver, Body, Driver, Revolute
    >>> arm = Body("arm", mass=1.0, inertia=(0.1, 0.1, 0.1))
    >>> hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 1, 0))
    >>> isinstance(AngleDriver(hinge, 0.3), Driver), isinstance(hinge, Driver)
    (True, False)
    """


@part_class()
class AngleDriver(Coupling, Driver):
    """Prescribes the angle of a hinge: theta = f(t) [rad], zero at the reference pose (1 row).

    `Solution.effort` is the required torque on b about the axis of the hinge; its work enters the energy
    balance.

    Parameters
    ----------
    hinge : Joint
        A joint with an angle.
    signal : float or signal
        Angle f(t) [rad], of b relative to a about the axis of the hinge; several turns count.
    name : str, optional
        For results and messages; "AngleDriver 1" and so on by default.

    Examples
    --------
    >>> from mbsd3d import GROUND, AngleDriver, Body, Kinematic, Ramp, Revolute, System, simulate
    >>> arm = Body("arm", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(0.5, 0, 0))
    >>> hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
    >>> system = System([arm], [hinge, AngleDriver(hinge, Ramp(2.0), name="motor")])
    >>> solution = simulate(system, 1.0, method=Kinematic(), output=5)
    >>> round(float(solution.effort("motor")[0]), 9)  # holds the weight: -m g l about y
    -4.905
    """

    hinge: Joint
    signal: SignalField = kept()

    def through(self) -> Joint:
        return self.hinge

    def check(self, what: str) -> None:
        coordinate_of(self.hinge, "angle", what)

    def rows(self) -> list[Primitive]:
        return [ratio(angle_of(self.hinge), 1.0, signal=self.signal)]


@part_class()
class SlideDriver(Coupling, Driver):
    """Prescribes the displacement of a sliding joint: s = f(t) [m], zero at the reference pose (1 row).

    `Solution.effort` is the required force on b along the axis of the joint.

    Parameters
    ----------
    slider : Joint
        A joint with a slide.
    signal : float or signal
        Displacement f(t) [m] of b relative to a along the axis of the joint.
    name : str, optional
        For results and messages; "SlideDriver 1" and so on by default.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Kinematic, Polynomial, Prismatic, SlideDriver, System, simulate
    >>> lift = Body("lift", mass=3.0, inertia=(0.1, 0.1, 0.1))
    >>> rail = Prismatic(GROUND, lift, at=(0, 0, 0), axis="z", name="rail")
    >>> motor = SlideDriver(rail, Polynomial((0.0, 0.0, 0.6)), name="motor")  # 0.6 t^2
    >>> run = simulate(System([lift], [rail, motor]), 1.0, method=Kinematic(), output=3)
    >>> float(run.slide(rail)[-1].round(9)), float(run.effort(motor)[-1].round(6))  # m (g + 1.2)
    (0.6, 33.03)
    """

    slider: Joint
    signal: SignalField = kept()

    def through(self) -> Joint:
        return self.slider

    def check(self, what: str) -> None:
        coordinate_of(self.slider, "slide", what)

    def rows(self) -> list[Primitive]:
        return [ratio(slide_of(self.slider), 1.0, signal=self.signal, in_metres=True)]


@part_class()
class PositionDriver(Driver):
    """A point of a body follows three signals [m], its displacement along the world axes; None leaves one free.

    Parameters
    ----------
    at : (3,) array_like
        The point, world at the reference pose [m].
    signal : sequence of three Signal, float or None
        Displacement from the reference pose along x, y, z [m].

    Examples
    --------
    >>> from mbsd3d import Body, Polynomial, PositionDriver, System, accelerations
    >>> hook = Body("hook", mass=4.0, inertia=(0.2, 0.2, 0.1), position=(0.3, 0, 2))
    >>> lift = PositionDriver(hook, at=(0.3, 0, 2), signal=(0.0, 0.0, Polynomial((0, 0, 0.5))), name="lift")
    >>> accelerations(System([hook], [lift])).effort("lift")[0].round(9) + 0.0  # m (g + 1 m/s^2) upwards
    array([ 0.  ,  0.  , 43.24])
    """

    body: Body
    _: KW_ONLY
    at: Vector = kept()
    signal: ThreeSignalsOrFree = kept()

    @property
    def a(self) -> Body | Ground:
        """Return `GROUND`: the motion is prescribed relative to it."""
        return GROUND

    @property
    def b(self) -> Body | Ground:
        """Return the driven body."""
        return self.body

    def point(self) -> np.ndarray:
        return self.at

    def rows(self) -> list[Primitive]:
        axes = zip(np.eye(3), self.signal, strict=True)
        return [in_plane(GROUND, self.body, axis, self.at, self.at, s) for axis, s in axes if s is not None]


@part_class()
class LengthDriver(Driver):
    """The distance of two points follows a signal [m], as for a hydraulic cylinder or a linear actuator (1 row).

    ``|p_b - p_a| = f(t)``; `Solution.effort` is the force along the line that pushes the points apart [N].

    Parameters
    ----------
    at_a, at_b : (3,) array_like
        The points, world at the reference pose [m].
    length : Signal or float
        The length itself [m], above 0. One that starts at another length than that of the reference pose needs
        ``system.assemble()``.

    Raises
    ------
    ValueError
        If the points coincide, so that the line has no direction, or a constant length is not above 0.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, LengthDriver, Prismatic, Ramp, System, accelerations
    >>> ram = Body("ram", mass=5.0, inertia=(0.1, 0.1, 0.1), position=(0, 0, 0.8))
    >>> guide = Prismatic(GROUND, ram, at=(0, 0, 0), axis=(0, 0, 1))
    >>> cylinder = LengthDriver(GROUND, ram, at_a=(0, 0, 0), at_b=(0, 0, 0.8), length=Ramp(0.1, 0.8), name="lift")
    >>> round(float(accelerations(System([ram], [guide, cylinder])).effort("lift")[0]), 9)  # it carries 5 kg
    49.05
    """

    a: Body | Ground
    b: Body | Ground
    _: KW_ONLY
    at_a: Vector = kept()
    at_b: Vector = kept()
    length: SignalField = kept()

    def check(self, what: str) -> None:
        super().check(what)
        if ends_coincide(self):
            raise InputError(f"{what}: at_a and at_b coincide, so the line has no direction; move one of them")
        if isinstance(self.length, Constant) and not self.length.value > 0.0:
            raise InputError(f"{what}: length is {self.length.value:g} m; give a length above 0")

    def point(self) -> np.ndarray:
        return self.at_b

    def rows(self) -> list[Primitive]:
        ends = (self.at_a, self.at_b)
        return [Primitive(kinds.DISTANCE, (self.a, self.b), points=ends, values=(0.0,), signal=self.length)]


def one_or_three(value: Any, what: str, part: Any) -> tuple[Signal, ...]:
    """Convert one signal, or up to three of them."""
    try:
        given = (value,) if isinstance(value, Signal | Real) else tuple(value)
    except TypeError:
        given = ()
    if not 1 <= len(given) <= 3 or isinstance(value, str):
        raise InputError(f"{what}: {short_repr(value)}; give one signal or three, as numbers, Ramp, Table, ...")
    return tuple(as_signal(x, f"{what}[{k}]") for k, x in enumerate(given))


class OneToThreeSignals(Stored[Signal | float | Sequence[Signal | float], tuple[Signal, ...]]):
    """One to three signals."""

    accepts, role = "Signal | float | Sequence[Signal | float]", "signal"
    file_type = dict[str, Any] | float | list[dict[str, Any] | float]
    convert = staticmethod(one_or_three)


def as_axes(value: Any, what: str, part: Any) -> np.ndarray:
    """Convert one direction, or up to three of them, to unit vectors (k, 3)."""
    given = [by_letter(x, what) for x in value] if isinstance(value, list | tuple) else by_letter(value, what)
    rows = np.atleast_2d(floats(given, what, "one direction, or one for each signal"))
    if rows.ndim != 2 or rows.shape[1] != 3 or not 1 <= len(rows) <= 3:
        raise InputError(f"{what}: {short_repr(value)}; give one direction, or one for each signal")
    return locked(np.array([unit(row, f"{what}[{k}]") for k, row in enumerate(rows)]))


class AxesOrNone(Stored[str | Sequence[str] | ArrayLike | None, np.ndarray | None]):
    """One to three directions, or None."""

    accepts = "str | Sequence[str] | array_like | None"
    convert = staticmethod(or_none(as_axes))


@part_class()
class OrientationDriver(Driver):
    """The orientation of b relative to a follows signals f(t) [rad] (3 rows).

    Relative to a, b is turned from its reference pose by T(f), with T(0) = 1. Without ``axes`` the three signals are a
    rotation vector, T = exp(f): a turn by its length about its direction, over several turns too. With ``axes`` they
    are angles of turns about these axes one after the other, each axis carried by the turns before it:
    T = T_1(f_1) T_2(f_2) T_3(f_3), as Euler and Cardan angles are. One axis takes one signal.

    Velocities and accelerations follow from the signals in closed form. `Solution.effort` is the moment on b along its
    own axes [N m], ``reaction(driver).moment`` the same in world axes. Measured orientations: `from_table`.

    Parameters
    ----------
    signal : sequence of three Signal or float; or as many as there are axes
        [rad]. Where they are not zero at the start, ``system.assemble()`` turns the bodies there.
    axes : (3,) or (k, 3) array_like, or letters, optional
        Directions in a, world at the reference pose, e.g. ``"z"`` or ``("z", "x", "z")``; None = the rotation vector
        has world components there.

    Raises
    ------
    ValueError
        If signals and axes are not as many, or an axis has no direction.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, OrientationDriver, Ramp, Spherical, System, accelerations
    >>> rotor = Body("rotor", mass=1.0, inertia=(0.1, 0.1, 0.2))
    >>> pivot = Spherical(GROUND, rotor, at=(0, 0, 0))
    >>> angles, axes = (Ramp(2.0), 0.5, Ramp(30.0)), [(0, 0, 1), (1, 0, 0), (0, 0, 1)]
    >>> spin = OrientationDriver(GROUND, rotor, signal=angles, axes=axes)
    >>> system = System([rotor], [pivot, spin])  # it precesses about z, tilted by 0.5 rad, and spins about itself
    >>> accelerations(system, system.assemble()).omega_body(rotor)[0].round(9) + 0.0  # 0, not -0
    array([ 0.        ,  0.95885108, 31.75516512])
    """

    a: Body | Ground
    b: Body | Ground
    _: KW_ONLY
    signal: OneToThreeSignals = kept()
    axes: AxesOrNone = kept(default=None)

    @classmethod
    def from_table(
        cls, a: Body | Ground, b: Body | Ground, times: ArrayLike, orientations: ArrayLike, name: str | None = None
    ) -> Self:
        """Return the driver through measured orientations of b relative to a, by splines of the rotation vector.

        ``orientations``: relative to the reference pose, unit quaternions (n, 4), scalar first, or rotation vectors
        (n, 3) [rad], at n >= 4 increasing ``times`` [s]. Quaternions are unwrapped to the rotation vectors next to each
        other; such a vector turns sharply where b comes near a whole turn about another axis, so give ``axes`` and
        signals then.
        """
        remedy = "unit quaternions (n, 4) or rotation vectors (n, 3)"
        rows = floats(orientations, f"{cls.__name__}: orientations", remedy)
        if rows.ndim != 2 or rows.shape[1] not in (3, 4):
            raise InputError(f"{cls.__name__}: orientations have shape {rows.shape}; give {remedy}")
        vectors = rows if rows.shape[1] == 3 else unwrapped(logarithm(as_quaternions(rows, cls.__name__)))
        return cls(a, b, signal=tuple(Table(times, column) for column in vectors.T), name=name)

    def check(self, what: str) -> None:
        super().check(what)
        wanted = 3 if self.axes is None else len(self.axes)
        if len(self.signal) != wanted:
            of = "a rotation vector has three" if self.axes is None else f"there are {wanted} axes"
            raise InputError(f"{what}: {len(self.signal)} signals, but {of}; give a signal for each, or other axes")

    def rows(self) -> list[Primitive]:
        kind = kinds.ROTATION_VECTOR if self.axes is None else kinds.TURNS
        axes = np.eye(3) if self.axes is None else np.vstack([self.axes, np.eye(3)])[:3]
        signals = (*self.signal, *(Constant(0.0),) * 3)[:3]
        between = multiply(conjugate(self.a.orientation), self.b.orientation)
        numbers = (float(kind), *(x for axis in axes for x in self.a.local_axis(axis)), *between)
        return [
            Primitive(kinds.ORIENT, (self.a, self.b), values=(float(k),), numbers=numbers, signal=x, in_metres=False)
            for k, x in enumerate(signals)
        ]


def as_quaternions(rows: np.ndarray, what: str) -> np.ndarray:
    """Return unit quaternions (n, 4); InputError for other rows."""
    return np.array([as_quaternion(row, f"{what}: orientations[{k}]") for k, row in enumerate(rows)])


def unwrapped(vectors: np.ndarray) -> np.ndarray:
    """Return rotation vectors (n, 3) [rad] of the same rotations, each next to the one before it by whole turns."""
    found = vectors.copy()
    for before, x in pairwise(found):
        along = x if x.any() else before  # a whole turn has no direction of its own
        if along.any():
            along = along / math.sqrt(along @ along)
            x += TURN * np.round((before - x) @ along / TURN) * along
    return found


def as_given(value: Any, what: str, part: Any) -> Any:
    """Return the value unchanged."""
    return value


class BodyOrJoint(Stored[Body | Ground | Joint | None, Body | Ground]):
    """A body, or the joint that moves it."""

    accepts, role, file_type = "Body | Ground | Joint | None", "body", str
    convert = staticmethod(as_given)


class BodyOrSpeed(Stored[Body | Ground | Signal | float | None, Body | Ground]):
    """A body, or the speed of a joint."""

    accepts, role, file_type = "Body | Ground | Signal | float | None", "body", str
    convert = staticmethod(as_given)


def as_speed(value: Any, what: str, part: Any) -> Signal:
    """Accept a signal if no other one is given."""
    if isinstance(part.a, Joint) and part.b is not None:
        raise InputError(f"{part.what()}: two speeds, {short_repr(part.b)} and {short_repr(value)}; give one")
    return as_signal(value, what)


class SpeedOrDerived(Stored[Signal | float | None, Signal]):
    """A signal or a number; None = what was given in place of a body."""

    accepts, role, file_type = "Signal | float | None", "signal", dict | float | None
    convert = staticmethod(or_none(as_speed))


@part_class()
class SpeedDriver(Driver):
    """A joint, or b relative to a, turns [rad/s] or moves [m/s] at a prescribed speed (1 row without residual).

    ``SpeedDriver(hinge, 3.0)`` turns a hinge, ``SpeedDriver(slider, 0.2)`` moves a slider, and without a joint
    ``SpeedDriver(a, b, axis=..., speed=...)`` turns b about an axis fixed in a, ``SpeedDriver(a, b, at=...,
    direction=..., speed=...)`` moves the point of b along a direction fixed in b. What has an angle and a slide is
    driven in the second way only, so that rad/s and m/s cannot be mixed up.

    Parameters
    ----------
    a, b : Body or GROUND; or a joint and its speed
    axis : (3,) array_like
        About which b turns, world at the reference pose.
    direction, at : (3,) array_like
        Along which a point of b moves, and that point, world at the reference pose [m]; ``at`` None = centre of mass.
    speed : Signal or float
        [rad/s], with ``direction`` or a slider [m/s].

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Prismatic, Revolute, SpeedDriver, System
    >>> rotor = Body("rotor", mass=1.0, inertia=(0.1, 0.1, 0.2))
    >>> hinge = Revolute(GROUND, rotor, at=(0, 0, 0), axis=(0, 0, 1))
    >>> (System([rotor], [hinge, SpeedDriver(hinge, 3.0)]).state().v[3:].round(12) + 0.0).tolist()
    [0.0, 0.0, 3.0]
    >>> rail = Prismatic(GROUND, rotor, at=(0, 0, 0), axis=(1, 0, 0))
    >>> (System([rotor], [rail, SpeedDriver(rail, 0.2)]).state().v[:3].round(12) + 0.0).tolist()
    [0.2, 0.0, 0.0]
    """

    a: BodyOrJoint = kept(default=None)
    b: BodyOrSpeed = kept(default=None)
    _: KW_ONLY
    axis: DirectionOrNone = kept(default=None)
    speed: SpeedOrDerived = kept(default=None)
    direction: DirectionOrNone = kept(default=None)
    at: VectorOrNone = kept(default=None)
    joint: Joint | None = None

    def check(self, what: str) -> None:
        a: Any = self.a
        b: Any = self.b
        if isinstance(a, Joint):
            speed = self.speed if b is None else as_signal(b, f"{what}: speed")
            derive(self, joint=a, a=None, b=None, speed=speed)
        if self.joint is not None:
            self.follow_joint(what, self.joint)
        super().check(what)
        if self.speed is None:
            raise InputError(f"{what}: no speed; give speed= in rad/s about axis=, or in m/s along direction=")
        if (self.axis is None) == (self.direction is None):
            given = "neither axis nor direction" if self.axis is None else "both axis and direction"
            raise InputError(f"{what}: {given}; give axis= for a speed in rad/s, or direction= for one in m/s")
        if self.direction is None and self.at is not None:
            raise InputError(f"{what}: at = {self.at} with an axis: a rotation needs no point; leave at= out")
        if self.direction is not None and self.at is None:
            derive(self, at=self.b.centre)

    def follow_joint(self, what: str, joint: Joint) -> None:
        """Return the bodies and axis of the joint that is driven."""
        turn, slide = (joint.angle(), joint.slide()) if isinstance(joint, Joint) else (None, None)
        if (turn is None) == (slide is None):
            name = f"'{joint.name}' ({type(joint).__name__})" if isinstance(joint, Joint) else short_repr(joint)
            has = "neither angle nor slide" if turn is None else "an angle and a slide"
            raise InputError(
                f"{what}: {name} has {has}; give SpeedDriver(a, b, axis=..., speed=) in rad/s or "
                "SpeedDriver(a, b, at=..., direction=..., speed=) in m/s"
            )
        if slide is not None and slide.kind != "slide":
            raise InputError(f"{what}: '{joint.name}' leads along a curve; give a SlideDriver with Ramp(speed)")
        x: Any = turn or slide
        own: dict[str, Any] = {
            "a": x.a,
            "b": x.b,
            "axis": turn and x.axis,
            "direction": slide and x.axis_b,
            "at": slide and x.point_b,
        }
        for name, value in own.items():
            given = getattr(self, name)
            if given is not None and not np.array_equal(given, value):
                raise InputError(
                    f"{what}: {name} = {short_repr(given)}, but '{joint.name}' says what moves; leave it out"
                )
        derive(self, **own)

    def point(self) -> np.ndarray:
        return self.b.position if self.at is None else self.at

    def partners(self) -> list[Joint]:
        return [] if self.joint is None else [self.joint]

    def rows(self) -> list[Primitive]:
        on = (self.a, self.b)
        if self.direction is None:
            return [Primitive(kinds.TURN_RATE, on, axes=(self.axis, ZERO), signal=self.speed, in_metres=False)]
        slip = kinds.NO_SIDESLIP  # n . (v_b - v_a) at the point of b, here not zero but the speed
        return [Primitive(slip, on, points=(self.at, self.at), axes=(ZERO, self.direction), signal=self.speed)]
