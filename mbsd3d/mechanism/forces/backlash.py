"""Backlash between gear teeth: both shafts turn freely within it, and the flanks are in contact at its ends."""

from dataclasses import KW_ONLY
from typing import Any

from ...base.checks import short_repr
from ...base.errors import InputError
from ...base.fields import Number, NumberOrNone, kept, part_class
from ...compiler.decorators import inner_kernel
from ...kernels.coordinates import sum_and_rate
from ..couplings import Gear
from ..force_element import ForceRecord
from ..joints import Joint, angle_of
from ..measures import Measure, label, of_coordinate
from ..primitives import Primitive, ratio
from ..signals import Constant
from .end_stop import END_STOP, YieldingOrRigidStop, end_stop_parameters, range_gap, range_load
from .sum_spring import load_sum


@inner_kernel
def backlash(m, d, p, out, t):
    """Apply the load of two flanks along the angle of gear b less that of gear a times the ratio."""
    own = end_stop_parameters(m.number, p.number)
    x, rate = sum_and_rate(m, d, p, t)
    load, out.potential, lost = range_load(own.stiffness, own.damping, own.lower, own.upper, x, rate)
    out.power = lost * rate
    load_sum(m, d, p, load, t)


@inner_kernel
def backlash_gap(m, d, p, limit, t, seen):
    """Store the clearance [rad] of the flanks of one side (0) or the other (1)."""
    own = end_stop_parameters(m.number, p.number)
    x, rate = sum_and_rate(m, d, p, t)
    range_gap(own, own.lower, own.upper, limit, x, rate, seen)


@part_class()
class Backlash(YieldingOrRigidStop):
    """Play between the teeth of a gear: x = angle_b - ratio angle_a is free within -angle/2 ... angle/2.

    Beyond the play by d the flanks press with the torque ``max(0, k d + c d_dot)`` along x, which never pulls: it acts
    on gear b, -ratio times it on gear a, and the opposite of both on what carries the hinges, as with `Gear`. Angles
    are counted over all turns. Energy ``k d^2 / 2``; the rest of the power is dissipated.

    With ``restitution=e`` instead of a stiffness the flanks are rigid: they strike at an event and part with e times
    the rate of x, until hops too low to be seen end in touch; see `EndStop`.

    Parameters
    ----------
    gear : Gear
        Hinges and ratio. It is not itself in the system, where its row would leave no play.
    angle : float
        The whole play > 0 [rad], by which gear b turns while gear a is held: play at the pitch circle over the pitch
        radius of b.
    stiffness, damping : float
        k > 0 [N m/rad], c >= 0 [N m s/rad] at gear b, of flanks that yield.
    restitution : float
        e of 0 ... 1, of rigid flanks.

    Raises
    ------
    ValueError
        For anything but a `Gear`, both stiffness and restitution, or a gear that is in the system too. A rigid one
        refuses a run that starts beyond the play.

    Examples
    --------
    >>> from mbsd3d import GROUND, Backlash, Body, Gear, Revolute, System, measures, simulate
    >>> one = Body("one", 1.0, (0.1, 0.1, 0.2), omega=(0, 0, 2.0))
    >>> two = Body("two", 1.0, (0.1, 0.1, 0.2), position=(0.3, 0, 0), omega=(0, 0, 0))
    >>> a = Revolute(GROUND, one, at=(0, 0, 0), axis=(0, 0, 1), name="a")
    >>> b = Revolute(GROUND, two, at=(0.3, 0, 0), axis=(0, 0, 1), name="b")
    >>> teeth = Backlash(Gear(a, b, ratio=-1), angle=0.1, restitution=0.0, name="teeth")
    >>> run = simulate(System([one, two], [a, b], [teeth], gravity=(0, 0, 0)), 1.0)
    >>> run.events[0].what, round(run.events[0].t, 9), round(float(run.rate(b)[-1]), 9)
    ("'teeth' is struck at its upper limit", 0.025, -1.0)
    """

    law, law_parameters = staticmethod(backlash), END_STOP
    gap = staticmethod(backlash_gap)
    leaves = "is free"

    gear: Gear
    _: KW_ONLY
    angle: Number = kept(positive=True)
    stiffness: NumberOrNone = kept(default=None, positive=True)
    damping: Number = kept(default=0.0, minimum=0.0)
    restitution: NumberOrNone = kept(default=None, minimum=0.0)

    def check(self, what: str) -> None:
        if not isinstance(self.gear, Gear):
            remedy = "give a Gear; of a GearMesh one with its hinges and ratio"
            raise InputError(f"{what}: {short_repr(self.gear)} is not a Gear; {remedy}")
        self.check_law(what)

    @property
    def limits(self) -> tuple[float, float]:
        return (-0.5 * self.angle, 0.5 * self.angle)

    @property
    def play(self) -> Measure:
        """Return the measure of x = angle_b - ratio angle_a [rad], for ``stop_when`` and `solution.measure`."""
        return Measure("sum", f"play of {label(self)}", "rad", part=self)

    def value_measure(self) -> Measure:
        return self.play

    in_metres = False

    def row_at(self, value: float) -> Primitive:
        a, b = self.gear.hinge_a, self.gear.hinge_b
        return ratio(angle_of(a), -self.gear.ratio, angle_of(b), 1.0, signal=Constant(value))

    def through(self) -> Joint:
        return self.gear.hinge_b

    def partners(self) -> tuple[Joint, ...]:
        return (self.gear.hinge_b, self.gear.hinge_a)

    def replaces(self) -> tuple[Any, ...]:
        return (self.gear,)

    def record(self) -> ForceRecord:
        both = angle_of(self.gear.hinge_a), angle_of(self.gear.hinge_b)
        bodies = {id(body): body for x in both for body in (x.a, x.b)}
        last = self.gear.b
        return ForceRecord(
            (*(body for body in bodies.values() if body is not last), last),
            parameters=self.read_by_law(**self.numbers_of_law()),
            measures=tuple(of_coordinate(x, "angle of a gear") for x in both),
            series=((-self.gear.ratio, 1.0),),
        )
