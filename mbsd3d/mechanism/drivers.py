"""Drivers: rows with a prescribed motion. Displacements count from the reference pose."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import shown, vector
from ..base.directions import unit
from ..base.errors import InputError
from ..kernels import kinds
from .bodies import GROUND, Body, Ground
from .couplings import Coupling
from .joints import Joint, coordinate_of
from .primitives import ZERO, Primitive, in_plane, ratio
from .signals import Constant, Signal, as_signal, three_signals


class Driver(Joint):
    """A joint that prescribes a motion; `Solution.effort` gives the torque or force it needs.

    Examples
    --------
    >>> from mbsd3d import GROUND, AngleDriver, Body, Driver, Revolute
    >>> arm = Body("arm", mass=1.0, inertia=(0.1, 0.1, 0.1))
    >>> hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 1, 0))
    >>> isinstance(AngleDriver(hinge, 0.3), Driver), isinstance(hinge, Driver)
    (True, False)
    """


@dataclass(frozen=True, eq=False)
class AngleDriver(Coupling, Driver):
    """The angle of a hinge follows ``signal`` [rad] (1 row): theta = f(t), zero at the reference pose.

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
    signal: Signal | float

    def through(self) -> Joint:
        return self.hinge

    def check(self, what: str) -> None:
        coordinate_of(self.hinge, "angle", what)
        self.set(signal=as_signal(self.signal, f"{what}: signal"))

    def rows(self) -> list[Primitive]:
        return [ratio(self.hinge.angle(), 1.0, signal=self.signal)]


@dataclass(frozen=True, eq=False)
class SlideDriver(Coupling, Driver):
    """The slide of a joint follows ``signal`` [m] (1 row).

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Constant, Prismatic, SlideDriver, System
    >>> lift = Body("lift", mass=3.0, inertia=(0.1, 0.1, 0.1))
    >>> rail = Prismatic(GROUND, lift, at=(0, 0, 0), axis=(0, 0, 1), name="rail")
    >>> System([lift], [rail, SlideDriver(rail, Constant(0.0))]).check().mobility
    0
    """

    slider: Joint
    signal: Signal | float

    def through(self) -> Joint:
        return self.slider

    def check(self, what: str) -> None:
        coordinate_of(self.slider, "slide", what)
        self.set(signal=as_signal(self.signal, f"{what}: signal"))

    def rows(self) -> list[Primitive]:
        return [ratio(self.slider.slide(), 1.0, signal=self.signal, in_metres=True)]


@dataclass(frozen=True, eq=False)
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
    at: ArrayLike = field(kw_only=True)
    signal: Sequence[Signal | float | None] = field(kw_only=True)

    @property
    def a(self) -> Body | Ground:
        """The ground."""
        return GROUND

    @property
    def b(self) -> Body | Ground:
        """The driven body."""
        return self.body

    def check(self, what: str) -> None:
        super().check(what)
        signals = three_signals(self.signal, f"{what}: signal", free=True)
        if not any(signals):
            raise InputError(f"{what}: all three directions are free; give at least one signal")
        self.set(at=vector(self.at, f"{what}: at"), signal=signals)

    def point(self) -> np.ndarray:
        return self.at

    def rows(self) -> list[Primitive]:
        axes = zip(np.eye(3), self.signal, strict=True)
        return [in_plane(GROUND, self.body, axis, self.at, self.at, s) for axis, s in axes if s is not None]


@dataclass(frozen=True, eq=False)
class LengthDriver(Driver):
    """The distance of two points follows a signal [m], as of a hydraulic cylinder or a linear actuator (1 row).

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
    at_a: ArrayLike = field(kw_only=True)
    at_b: ArrayLike = field(kw_only=True)
    length: Signal | float = field(kw_only=True)

    def check(self, what: str) -> None:
        super().check(what)
        at_a, at_b = vector(self.at_a, f"{what}: at_a"), vector(self.at_b, f"{what}: at_b")
        if not np.linalg.norm(at_b - at_a) > 1e-12:
            raise InputError(f"{what}: at_a and at_b coincide, so the line has no direction; move one of them")
        length = as_signal(self.length, f"{what}: length")
        if isinstance(length, Constant) and not length.value > 0.0:
            raise InputError(f"{what}: length is {length.value:g} m; give a length above 0")
        self.set(at_a=at_a, at_b=at_b, length=length)

    def point(self) -> np.ndarray:
        return self.at_b

    def rows(self) -> list[Primitive]:
        ends = (self.at_a, self.at_b)
        return [Primitive(kinds.DISTANCE, (self.a, self.b), points=ends, values=(0.0,), signal=self.length)]


@dataclass(frozen=True, eq=False)
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

    a: Body | Ground | Joint | None = None
    b: Body | Ground | Signal | float | None = None
    axis: ArrayLike | None = field(default=None, kw_only=True)
    speed: Signal | float | None = field(default=None, kw_only=True)
    direction: ArrayLike | None = field(default=None, kw_only=True)
    at: ArrayLike | None = field(default=None, kw_only=True)
    joint: Joint | None = field(default=None, kw_only=True)

    def check(self, what: str) -> None:
        if isinstance(self.a, Joint):
            if self.speed is not None and self.b is not None:
                raise InputError(f"{what}: two speeds, {shown(self.b)} and {shown(self.speed)}; give one")
            self.set(joint=self.a, a=None, b=None, speed=self.b if self.speed is None else self.speed)
        if self.joint is not None:
            self.follow_joint(what)
        super().check(what)
        if self.speed is None:
            raise InputError(f"{what}: no speed; give speed= in rad/s about axis=, or in m/s along direction=")
        if (self.axis is None) == (self.direction is None):
            given = "neither axis nor direction" if self.axis is None else "both axis and direction"
            raise InputError(f"{what}: {given}; give axis= for a speed in rad/s, or direction= for one in m/s")
        if self.direction is not None:
            at = self.b.centre if self.at is None else vector(self.at, f"{what}: at")
            self.set(direction=unit(self.direction, f"{what}: direction"), at=at)
        else:
            if self.at is not None:
                raise InputError(f"{what}: at = {self.at} with an axis: a turn has no point; leave at= out")
            self.set(axis=unit(self.axis, f"{what}: axis"))
        self.set(speed=as_signal(self.speed, f"{what}: speed"))

    def follow_joint(self, what: str) -> None:
        """Bodies and axis of the joint that is driven."""
        joint = self.joint
        turn, slide = (joint.angle(), joint.slide()) if isinstance(joint, Joint) else (None, None)
        if (turn is None) == (slide is None):
            name = f"'{joint.name}' ({type(joint).__name__})" if isinstance(joint, Joint) else shown(joint)
            has = "neither angle nor slide" if turn is None else "an angle and a slide"
            raise InputError(
                f"{what}: {name} has {has}; give SpeedDriver(a, b, axis=..., speed=) in rad/s or "
                "SpeedDriver(a, b, at=..., direction=..., speed=) in m/s"
            )
        if slide is not None and slide.kind != "slide":
            raise InputError(f"{what}: '{joint.name}' leads along a curve; give a SlideDriver with Ramp(speed)")
        x = turn or slide
        own = {"a": x.a, "b": x.b, "axis": turn and x.axis, "direction": slide and x.axis_b, "at": slide and x.point_b}
        for name, value in own.items():
            given = getattr(self, name)
            if given is not None and not np.array_equal(given, value):
                raise InputError(f"{what}: {name} = {shown(given)}, but '{joint.name}' says what moves; leave it out")
        self.set(**own)

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
