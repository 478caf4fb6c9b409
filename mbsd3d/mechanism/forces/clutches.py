"""Slipping clutches, freewheels and ratchets: parts that hold a hinge or slide one way, or up to a load."""

from dataclasses import KW_ONLY
from typing import ClassVar

import numpy as np

from ...base.errors import InputError
from ...base.fields import Number, Truth, kept, part_class
from ...compiler.decorators import inner_kernel
from ...compiler.records import Parameters
from ..force_element import ForceRecord, hinge_coordinate
from ..joints import Joint, coordinate_of
from ..lock import Lock
from ..measures import Condition
from ..primitives import Coordinate
from ..switched import as_condition
from ..switching import OPEN, Mode, Watch

CLOSED = Mode("closed")  # of a clutch, before it is known whether it slips or holds
PASSES, RELEASED = "passes a tooth", "is released"
SLIPPING_LOAD = Parameters(load="N m or N")
slipping_load_parameters = SLIPPING_LOAD.reader()


@inner_kernel
def slipping_load(m, d, p, out, t):
    """Apply a constant load along a hinge coordinate, that of a clutch while it slips one way."""
    own = slipping_load_parameters(m.number, p.number)
    out.load = own.load + 0.0 * out.rate
    out.power = out.load * out.rate


@part_class()
class HingeLock(Lock):
    """Base class of locks of the angle, or else the slide, of a joint."""

    law, law_parameters = staticmethod(slipping_load), SLIPPING_LOAD

    hinge: Joint

    def check(self, what: str) -> None:
        hinge_coordinate(self.hinge, what)

    def through(self) -> Joint:
        return self.hinge

    def coordinate(self) -> Coordinate:
        return hinge_coordinate(self.hinge, "")

    def record(self) -> ForceRecord:
        return self.record_in(OPEN)

    def record_in(self, mode: Mode) -> ForceRecord:
        x = self.coordinate()
        return ForceRecord((x.a, x.b), parameters={"load": self.slip_load(mode)}, coordinate=x)

    def slip_load(self, mode: Mode) -> float:
        """Return the load along the coordinate in a mode in which it is free."""
        return 0.0


@part_class()
class Freewheel(HingeLock):
    """A hinge or slide that moves ahead and not back: b overruns a freely, and a takes b along where it falls behind.

    The rate of the coordinate is never below 0. Where it would be, the coordinate is held by a row, until the load of
    the row changes sign. Two parts on one axis need a joint between them for it: ``Revolute(lever, shaft)``.

    Parameters
    ----------
    hinge : Joint
        A joint with an angle, or else a slide; its rate [rad/s or m/s] is that of b relative to a.
    name : str, optional
        For results and messages; "Freewheel 1" and so on by default.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Freewheel, Revolute, System, TorsionSpring, simulate
    >>> wheel = Body("wheel", mass=1.0, inertia=(0.1, 0.1, 0.2), omega=(0, 0, 3.0))
    >>> hinge = Revolute(GROUND, wheel, at=(0, 0, 0), axis=(0, 0, 1))
    >>> wound = System([wheel], [hinge], [TorsionSpring(hinge, stiffness=0.8), Freewheel(hinge, name="pawl")])
    >>> run = simulate(wound, 5.0)  # a spring is wound up and stays so: 3 sqrt(0.2 / 0.8)
    >>> round(float(run.angle(hinge)[-1]), 6), run.events[0].what
    (1.5, "'pawl' locks")
    """

    leaves: ClassVar[str] = "runs free"

    def touching(self, mode: Mode, x: float, rate: float, slack: float, slow: float) -> Mode | None:
        return mode if self.holds(mode) else Mode("held", (x,))  # an impact elsewhere may turn it back, at any rate

    def watched(self, mode: Mode) -> list[Watch]:
        return self.watch_load(mode) if self.holds(mode) else [Watch(self.rate_measure() < 0.0, "locks")]


@part_class()
class Ratchet(HingeLock):
    """A hinge with a toothed wheel and a pawl: it turns ahead, and back only to the last tooth that has passed.

    Teeth stand at equal angles from the reference pose on. The pawl catches without rebound, holds by a row, and lets
    go where the load of the row changes sign. Each tooth that passes is an event.

    Parameters
    ----------
    hinge : Joint
        A joint with an angle.
    teeth : int
        Number of teeth per revolution.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Ratchet, Revolute, System, TorsionSpring, simulate
    >>> wheel = Body("wheel", mass=1.0, inertia=(0.1, 0.1, 0.2), omega=(0, 0, 3.0))
    >>> hinge = Revolute(GROUND, wheel, at=(0, 0, 0), axis=(0, 0, 1))
    >>> wound = System([wheel], [hinge], [TorsionSpring(hinge, stiffness=0.8), Ratchet(hinge, teeth=12, name="pawl")])
    >>> run = simulate(wound, 5.0)  # it turns to 1.5 rad and back to the second tooth
    >>> round(float(run.angle(hinge)[-1] / (2 * 3.141592653589793 / 12)), 6), run.events[-1].what
    (2.0, "'pawl' catches")
    """

    leaves: ClassVar[str] = "lets go"

    _: KW_ONLY
    teeth: Number = kept(positive=True)

    def check(self, what: str) -> None:
        coordinate_of(self.hinge, "angle", what)
        if self.teeth % 1.0:
            raise InputError(f"{what}: teeth = {self.teeth:g} is not a whole number; give the teeth per revolution")

    @property
    def pitch(self) -> float:
        """Return the angle between teeth [rad]."""
        return 2.0 * np.pi / self.teeth

    def first_mode(self) -> Mode:
        return Mode("open", (-np.pi / self.teeth,))

    def placed(self, mode: Mode, x: float, slack: float) -> Mode:
        return mode if self.holds(mode) else Mode("open", (float(np.floor((x + slack) / self.pitch)) * self.pitch,))

    def opened(self, mode: Mode) -> Mode:
        return Mode("open", mode.numbers)

    def after(self, mode: Mode, watch: Watch) -> Mode:
        if watch.action == PASSES:
            return Mode("open", (mode.numbers[0] + self.pitch,))
        return Lock.after(self, mode, watch)

    def touching(self, mode: Mode, x: float, rate: float, slack: float, slow: float) -> Mode | None:
        return Mode("held", mode.numbers) if self.holds(mode) or x <= mode.numbers[0] + slack else None

    def watched(self, mode: Mode) -> list[Watch]:
        if self.holds(mode):
            return self.watch_load(mode)
        tooth, x = mode.numbers[0], self.value_measure()
        return [Watch(x < tooth, "catches"), Watch(x > tooth + self.pitch, PASSES)]


@part_class()
class Clutch(HingeLock):
    """Dry friction between two parts that slips at a torque, and locks when they turn alike: no creep, no stiffness.

    While it slips its load on b is the torque against the rate of the hinge; at rate 0 a row holds the angle as long as
    the load of the row stays within the torque. A torque is finite, so a clutch takes no part in impacts.

    Parameters
    ----------
    hinge : Joint
        A joint with an angle, or else a slide.
    torque : float
        T > 0 [N m or N].
    engage, release : Condition or None
        Conditions that close or open the clutch each time they become true.
    engaged : bool
        Whether it is closed at the start; needed where there is no ``engage``.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Clutch, Revolute, System, simulate
    >>> disc = Body("disc", mass=2.0, inertia=(0.3, 0.3, 0.5), omega=(0, 0, 5.0))
    >>> hinge = Revolute(GROUND, disc, at=(0, 0, 0), axis=(0, 0, 1))
    >>> run = simulate(System([disc], [hinge], [Clutch(hinge, torque=2.0, engaged=True, name="brake")]), 3.0)
    >>> run.events[0], round(float(run.angle(hinge)[-1]), 9)  # 0.5 * 5 / 2.0; 0.5 * 5^2 / (2 * 2.0)
    (<1.25 s: 'brake' locks>, 3.125)
    """

    one_sided: ClassVar[bool] = False
    leaves: ClassVar[str] = "slips"

    _: KW_ONLY
    torque: Number = kept(positive=True)
    engage: Condition | None = kept(default=None, by=as_condition)
    release: Condition | None = kept(default=None, by=as_condition)
    engaged: Truth = kept(default=False)

    def check(self, what: str) -> None:
        HingeLock.check(self, what)
        if self.engage is None and not self.engaged:
            raise InputError(f"{what}: never closes; give engage=, or engaged=True")

    def first_mode(self) -> Mode:
        return CLOSED if self.engaged else OPEN

    def slip_load(self, mode: Mode) -> float:
        return -self.torque * mode.numbers[0] if mode.name == "slipping" else 0.0

    def opened(self, mode: Mode) -> Mode:
        return mode if mode.name == "slipping" else Mode("slipping", (1.0,))

    def moving(self, mode: Mode, rate: float, slow: float) -> Mode:
        return mode if mode.name == OPEN.name or abs(rate) <= slow else Mode("slipping", (float(np.sign(rate)),))

    def yielding(self, mode: Mode, load: float) -> Mode:
        return Mode("slipping", (-float(np.sign(load)),))

    def after(self, mode: Mode, watch: Watch) -> Mode:
        if watch.action == RELEASED:
            return OPEN
        return self.yielding(mode, watch.condition.direction) if self.holds(mode) else CLOSED

    def excess(self, load: float, mode: Mode, capacity: float) -> float:
        return abs(load) - self.torque

    def returns(self, a: float, held: Mode, free: Mode) -> float:
        return -free.numbers[0] * a

    def helps(self, free: Mode, rate: float) -> bool:
        return free.name == "slipping" and free.numbers[0] * rate < 0.0

    def touching(self, mode: Mode, x: float, rate: float, slack: float, slow: float) -> Mode | None:
        if self.holds(mode):
            return mode
        return None if mode.name == OPEN.name or abs(rate) > slow else Mode("held", (x,))

    def watched(self, mode: Mode) -> list[Watch]:
        if mode.name == OPEN.name:
            return [] if self.engage is None else [Watch(self.engage, "engages")]
        found = [] if self.release is None else [Watch(self.release, RELEASED)]
        if self.holds(mode):
            load = self.load_measure()
            return [*found, Watch(load > self.torque, "slips"), Watch(load < -self.torque, "slips")]
        return [*found, *(Watch(bound, "locks") for bound in self.bounds(mode))]

    def bounds(self, mode: Mode) -> list[Condition]:
        return [Condition(self.rate_measure(), 0.0, -mode.numbers[0])] if mode.name == "slipping" else []
