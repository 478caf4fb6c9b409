"""End stops of hinges and slides: they press back beyond a limit of a counted angle or a displacement."""

from collections.abc import Callable
from dataclasses import KW_ONLY
from operator import attrgetter
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ...base.checks import check_choice
from ...base.errors import InputError
from ...base.fields import Direction, Number, NumberOrNone, Vector, VectorOrDerived, kept, part_class
from ...compiler.decorators import inner_kernel
from ...compiler.records import Parameters
from ...kernels.coordinates import value_and_rate
from ...kernels.force_laws import stop_load
from ..bodies import Body, Ground
from ..force_element import ForceElement, ForceRecord, check_pair, hinge_coordinate
from ..joints import Joint, coordinate_of
from ..lock import Lock
from ..primitives import Coordinate
from ..switching import Mode, Watch

END_STOP = Parameters(
    stiffness="N m/rad or N/m", damping="N m s/rad or N s/m", lower="rad or m", upper="rad or m"
)  # fmt: skip
end_stop_parameters = END_STOP.reader()


@inner_kernel
def range_load(k, c, lower, upper, x, rate):
    """Return (load towards the inside, stored energy, dissipating part of the load) of stops at both ends."""
    up, elastic_up = stop_load(k, c, lower - x, -rate)
    down, elastic_down = stop_load(k, c, x - upper, rate)
    stored = 0.5 * (elastic_up * elastic_up + elastic_down * elastic_down) / k
    return up - down, stored, up - elastic_up + elastic_down - down


@inner_kernel
def see_gap(k, c, gap, rate, seen):
    """Store in ``seen`` the distance to a limit, its rate, and k d + c d_dot, which may be negative."""
    seen[0], seen[1], seen[3] = gap, rate, -(k * gap + c * rate)


@inner_kernel
def range_gap(own, lower, upper, limit, x, rate, seen):
    """Store the distance of x from the lower (0) or the upper limit (1)."""
    gap, away = (x - lower, rate) if limit == 0 else (upper - x, -rate)
    see_gap(own.stiffness, own.damping, gap, away, seen)


@inner_kernel
def end_stop(m, d, p, out, t):
    """Apply the load of two stops along a hinge coordinate, towards the inside."""
    own = end_stop_parameters(m.number, p.number)
    out.load, out.potential, lost = range_load(own.stiffness, own.damping, own.lower, own.upper, out.x, out.rate)
    out.power = lost * out.rate


@inner_kernel
def end_stop_gap(m, d, p, limit, t, seen):
    """Store the distance [rad or m] to the lower (0) or the upper stop (1)."""
    own = end_stop_parameters(m.number, p.number)
    x, rate = value_and_rate(m, d, p.coordinate, t)
    range_gap(own, own.lower, own.upper, limit, x, rate, seen)


LOWER, UPPER = "held at the lower limit", "held at the upper limit"


class Stop(ForceElement):
    """Base class of stops that are monitored between the stages of a step, as contacts are.

    ``gap(m, d, p, limit, t, seen)`` is a kernel that stores how far a limit is away, the rate of that, and the load
    that it would have if it could pull, in numbers 0, 1 and 3 of ``seen``: see `see_gap`.
    """

    gap: ClassVar[Callable | None] = None

    @property
    def gaps(self) -> int:
        """Return the number of limits of the stop."""
        raise NotImplementedError

    def depth_as_built(self) -> float:
        """Return how far the reference pose is beyond a limit [rad or m]; 0 where it is not."""
        raise NotImplementedError


@part_class()
class YieldingOrRigidStop(Lock, Stop):
    """Base class of stops at both ends of a range: with stiffness and damping, or rigid, with restitution.

    Its fields ``stiffness``, ``damping`` and ``restitution`` are those of `EndStop`.
    """

    gaps = 2

    if TYPE_CHECKING:

        @property
        def stiffness(self) -> float | None:
            """Return k, None of a rigid stop."""

        @property
        def damping(self) -> float:
            """Return c."""

        @property
        def restitution(self) -> float | None:
            """Return e, None of a stop that yields."""

    @property
    def limits(self) -> tuple[float, float]:
        """Return both limits [rad or m], infinite where there is none."""
        raise NotImplementedError

    def check_law(self, what: str) -> None:
        """Refuse anything but either stiffness and damping or a restitution of 0 ... 1."""
        if (self.stiffness is None) == (self.restitution is None):
            raise InputError(f"{what}: give either stiffness= of a stop that yields, or restitution= of a rigid one")
        if self.restitution is not None and (self.restitution > 1.0 or self.damping):
            raise InputError(
                f"{what}: restitution = {self.restitution:g} with damping = {self.damping:g}; give 0 ... 1, and no "
                "damping"
            )

    @property
    def switches(self) -> bool:
        """Return whether the stop is rigid."""
        return self.restitution is not None

    @property
    def bounce(self) -> float:
        return self.restitution or 0.0

    def sense(self, mode: Mode) -> float:
        return -1.0 if mode.name == UPPER else 1.0

    def depth(self, x: float) -> float:
        lower, upper = self.limits
        return max(lower - x, x - upper)

    def depth_as_built(self) -> float:
        x = self.record().coordinate
        built = float(x.axis @ (x.point_b - x.point_a)) if x is not None and x.kind == "slide" else 0.0
        return max(self.depth(built), 0.0)

    def touching(self, mode: Mode, x: float, rate: float, slack: float, slow: float) -> Mode | None:
        lower, upper = self.limits
        if x <= lower + slack:
            return Mode(LOWER, (lower,))
        if x >= upper - slack:
            return Mode(UPPER, (upper,))
        return None

    def watched(self, mode: Mode) -> list[Watch]:
        if self.holds(mode):
            return self.watch_load(mode)
        (lower, upper), x = self.limits, self.value_measure()
        found = [Watch(x < lower, "is struck at its lower limit")] if np.isfinite(lower) else []
        return [*found, Watch(x > upper, "is struck at its upper limit")] if np.isfinite(upper) else found

    def numbers_of_law(self) -> dict[str, float]:
        """Return stiffness and limits as the law reads them; a rigid stop has no load of its own."""
        if self.stiffness is None:
            return {"lower": -np.inf, "upper": np.inf, "stiffness": 1.0}
        lower, upper = self.limits
        return {"lower": lower, "upper": upper, "stiffness": self.stiffness}


def check_range(lower: float | None, upper: float | None, what: str) -> None:
    """Reject missing limits, and limits in the wrong order."""
    if lower is None and upper is None:
        raise InputError(f"{what}: neither lower nor upper; give at least one limit")
    if lower is not None and upper is not None and not lower < upper:
        raise InputError(f"{what}: lower = {lower:g} is not below upper = {upper:g}; exchange them or set them apart")


def both_ends(lower: float | None, upper: float | None) -> tuple[float, float]:
    """Return both limits, infinite where none is given."""
    return (-np.inf if lower is None else lower, np.inf if upper is None else upper)


@part_class()
class EndStop(YieldingOrRigidStop):
    """End stops of a hinge or slide: beyond a limit of the coordinate x a load ``max(0, k d + c d_dot)`` presses back.

    With ``restitution=`` instead of a stiffness the stop is rigid: see below.

    d is how far x is beyond ``lower`` or ``upper``. Angles count turns from the reference pose, so that a stop may
    stand at any number of them. It never pulls: what leaves faster than the spring can follow leaves without load.
    Energy ``k d^2 / 2``; the rest of the power is dissipated, ``c d_dot^2`` in touch.

    A mass m that meets a stop at speed v sinks in by about ``v sqrt(m / k)`` and is in touch for about
    ``pi sqrt(m / k)``. It comes back with ``e v``: e = 0.5 takes ``c = 0.511 sqrt(k m)``, 0.8 takes
    ``0.149 sqrt(k m)``. On a hinge m is the moment of inertia.

    A rigid stop, ``restitution=e``, is struck at an event: with the rates v before and v' after it, counted away from
    the stop, and the impulses P of all stops that are closed, ``0 <= P``, ``v' + e v >= 0``, one of both zero. Bounces
    that grow too low to be seen end in rest: the stop holds by a row until its load changes sign. Impacts and the
    energy they take stand in ``solution.events``.

    Parameters
    ----------
    joint : Joint
        A joint with an angle or a slide.
    lower, upper : float or None
        Limits [rad or m], counted from the reference pose; None: no stop there.
    stiffness, damping : float
        k > 0 [N m/rad or N/m], c >= 0 [N m s/rad or N s/m], of a stop that yields.
    restitution : float
        e of 0 ... 1, of a rigid stop, which has no stiffness.
    of : "angle", "slide" or None
        Coordinate to limit if the joint has both; None: the angle, else the slide.

    Raises
    ------
    ValueError
        For a joint without the coordinate, no limit at all, a lower limit that is not below the upper one, or both
        stiffness and restitution. A run that starts from the reference pose, and that beyond a limit, is refused at
        its start, of rigid stops one that starts beyond a limit anywhere.

    Examples
    --------
    >>> from math import pi
    >>> from mbsd3d import GROUND, Body, EndStop, Revolute, System, simulate
    >>> drum = Body("drum", mass=2.0, inertia=(0.3, 0.3, 0.5), omega=(0, 0, 5.0))
    >>> hinge = Revolute(GROUND, drum, at=(0, 0, 0), axis=(0, 0, 1))
    >>> stop = EndStop(hinge, upper=6 * pi, stiffness=2000.0)
    >>> turned = simulate(System([drum], [hinge], [stop]), 8.0)
    >>> float(turned.angle(hinge).max() > 6 * pi), round(float(turned.rate(hinge)[-1]), 6)  # three turns, and back
    (1.0, -5.0)
    """

    law, law_parameters = staticmethod(end_stop), END_STOP
    leaves = "is left"
    gap = staticmethod(end_stop_gap)

    joint: Joint
    _: KW_ONLY
    lower: NumberOrNone = kept(default=None)
    upper: NumberOrNone = kept(default=None)
    stiffness: NumberOrNone = kept(default=None, positive=True)
    damping: Number = kept(default=0.0, minimum=0.0)
    restitution: NumberOrNone = kept(default=None, minimum=0.0)
    of: str | None = None

    def check(self, what: str) -> None:
        check_choice(self.of, (None, "angle", "slide"), f"{what}: of")
        self.coordinate(what)
        self.check_law(what)
        check_range(self.lower, self.upper, what)

    def through(self) -> Joint:
        return self.joint

    def coordinate(self, what: str = "") -> Coordinate:
        """Return the coordinate that is limited."""
        return hinge_coordinate(self.joint, what) if self.of is None else coordinate_of(self.joint, self.of, what)

    @property
    def limits(self) -> tuple[float, float]:
        return both_ends(self.lower, self.upper)

    def record(self) -> ForceRecord:
        x = self.coordinate()
        return ForceRecord((x.a, x.b), parameters=self.read_by_law(**self.numbers_of_law()), coordinate=x)


@part_class()
class PointStop(YieldingOrRigidStop):
    """Stops of a point of b along an axis fixed in a: corners of a slider in its guide, a foot over the ground.

    With x, how far the point of b is from ``at`` along the axis, it presses like an `EndStop` beyond ``lower`` or
    ``upper``: by ``max(0, k d + c d_dot)`` along the axis at the point, or with ``restitution=`` at events. It is
    smooth: nothing acts across the axis.

    Parameters
    ----------
    a, b : Body or GROUND
    at : (3,) array_like
        Origin of x, world at the reference pose [m]; ``at_b``: the point of b, if it is a different one.
    axis : (3,) array_like
        Fixed in a; world at the reference pose.
    lower, upper : float or None
        Limits [m]; None: no stop there.
    stiffness, damping : float
        k > 0 [N/m], c >= 0 [N s/m], of a stop that yields.
    restitution : float
        e of 0 ... 1, of a rigid one.

    Raises
    ------
    ValueError
        As for an `EndStop`.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, PointStop, System, simulate
    >>> bar = Body("bar", mass=2.0, inertia=(0.1, 0.1, 0.1), position=(0, 0, 1.0))
    >>> feet = [PointStop(GROUND, bar, at=(x, 0, 1), axis=(0, 0, 1), lower=-0.2, restitution=0) for x in (-0.3, 0.3)]
    >>> run = simulate(System([bar], forces=feet), 0.5)
    >>> round(float(run.position(bar)[-1, 2]), 9), len(run.events)  # both feet at once
    (0.8, 1)
    """

    law, law_parameters = staticmethod(end_stop), END_STOP
    leaves = "is left"
    gap = staticmethod(end_stop_gap)

    a: Body | Ground
    b: Body | Ground
    _: KW_ONLY
    at: Vector = kept()
    at_b: VectorOrDerived = kept(default=None, derived=attrgetter("at"))
    axis: Direction = kept()
    lower: NumberOrNone = kept(default=None)
    upper: NumberOrNone = kept(default=None)
    stiffness: NumberOrNone = kept(default=None, positive=True)
    damping: Number = kept(default=0.0, minimum=0.0)
    restitution: NumberOrNone = kept(default=None, minimum=0.0)

    def check(self, what: str) -> None:
        check_pair(self.a, self.b, what)
        self.check_law(what)
        check_range(self.lower, self.upper, what)

    @property
    def limits(self) -> tuple[float, float]:
        return both_ends(self.lower, self.upper)

    def coordinate(self) -> Coordinate:
        return Coordinate("slide", self.a, self.b, self.axis, self.axis, self.at, self.at_b)

    def point(self) -> np.ndarray:
        """Return the point of b (world, reference pose)."""
        return self.at_b

    def partners(self) -> tuple[Joint, ...]:
        return ()

    def record(self) -> ForceRecord:
        own = self.read_by_law(**self.numbers_of_law())
        return ForceRecord((self.a, self.b), (self.at, self.at_b), parameters=own, coordinate=self.coordinate())
