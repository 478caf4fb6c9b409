"""Drivers: rows with a prescribed motion. Displacements count from the reference pose."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import vector
from ..base.directions import unit
from ..kernels import kinds
from .bodies import GROUND, Body, Ground
from .couplings import Coupling
from .joints import Joint, coordinate_of
from .primitives import ZERO, Primitive, in_plane, ratio
from .signals import Signal, as_signal, three_signals


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
            raise ValueError(f"{what}: all three directions are free; give at least one signal")
        self.set(at=vector(self.at, f"{what}: at"), signal=signals)

    def point(self) -> np.ndarray:
        return self.at

    def rows(self) -> list[Primitive]:
        axes = zip(np.eye(3), self.signal, strict=True)
        return [in_plane(GROUND, self.body, axis, self.at, self.at, s) for axis, s in axes if s is not None]


@dataclass(frozen=True, eq=False)
class SpeedDriver(Driver):
    """b turns relative to a about an axis fixed in a at a prescribed speed [rad/s] (1 row without residual).

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, SpeedDriver, System
    >>> rotor = Body("rotor", mass=1.0, inertia=(0.1, 0.1, 0.2))
    >>> hinge = Revolute(GROUND, rotor, at=(0, 0, 0), axis=(0, 0, 1))
    >>> system = System([rotor], [hinge, SpeedDriver(GROUND, rotor, axis=(0, 0, 1), speed=3.0)])
    >>> system.state().v[3:].round(12).tolist()
    [0.0, 0.0, 3.0]
    """

    a: Body | Ground
    b: Body | Ground
    axis: ArrayLike = field(kw_only=True)
    speed: Signal | float = field(kw_only=True)

    def check(self, what: str) -> None:
        super().check(what)
        self.set(axis=unit(self.axis, f"{what}: axis"), speed=as_signal(self.speed, f"{what}: speed"))

    def rows(self) -> list[Primitive]:
        return [
            Primitive(kinds.TURN_RATE, (self.a, self.b), axes=(self.axis, ZERO), signal=self.speed, in_metres=False)
        ]
