"""Springs, dampers and stops on weighted sums of angles and slides, as fixed tendons have them."""

from collections.abc import Sequence
from dataclasses import KW_ONLY
from typing import Any

import numpy as np

from ...base.checks import number, short_repr
from ...base.errors import InputError
from ...base.fields import Number, NumberOrNone, Stored, as_numbers, kept, part_class
from ...compiler.decorators import inner_kernel
from ...compiler.records import Parameters
from ...kernels.coordinates import coordinate, sum_and_rate
from ...kernels.force_laws import series
from ...kernels.vectors import add6, scale
from ..force_element import ForceElement, ForceRecord
from ..measures import of_coordinate
from ..sums import Joints, KindsOrNone, NumbersOrOnes, places_of, weighted
from .end_stop import Stop, range_gap, range_load

SUM_SPRING = Parameters(stiffness="N m/rad or N/m", damping="N m s/rad or N s/m", lower="rad or m", upper="rad or m")
sum_spring_parameters = SUM_SPRING.reader()


@inner_kernel
def load_sum(m, d, p, load, t):
    """Apply a load along the weighted sum of the coordinates that a force reads: w_i times it along each."""
    weights = series(m, p, 0, p.measures)
    for i in range(p.measures):
        k, share = m.measure[p.measure + i].coordinate, weights[i] * load
        a, b = d.body[m.coordinate[k].body[0]], d.body[m.coordinate[k].body[1]]
        _, _, la, ta, lb, tb = coordinate(m, d, k, t)
        add6(a.Q, scale(share, la), scale(share, ta))
        add6(b.Q, scale(share, lb), scale(share, tb))


@inner_kernel
def sum_spring(m, d, p, out, t):
    """Load -(k (x - x0) + c x_dot) along x = sum w_i x_i; x0 is the nearest rest value."""
    own = sum_spring_parameters(m.number, p.number)
    x, rate = sum_and_rate(m, d, p, t)
    stretch = x - own.upper if x.real > own.upper.real else x - own.lower if x.real < own.lower.real else 0.0 * x
    load_sum(m, d, p, -own.stiffness * stretch - own.damping * rate, t)
    out.potential = 0.5 * own.stiffness * stretch * stretch
    out.power = -own.damping * rate * rate


@inner_kernel
def sum_stop(m, d, p, out, t):
    """Load of two stops along x = sum w_i x_i, towards the inside."""
    own = sum_spring_parameters(m.number, p.number)
    x, rate = sum_and_rate(m, d, p, t)
    load, out.potential, lost = range_load(own.stiffness, own.damping, own.lower, own.upper, x, rate)
    load_sum(m, d, p, load, t)
    out.power = lost * rate


@inner_kernel
def sum_stop_gap(m, d, p, limit, t, seen):
    """See how far the lower (0) or the upper stop (1) is away."""
    own = sum_spring_parameters(m.number, p.number)
    x, rate = sum_and_rate(m, d, p, t)
    range_gap(own, own.lower, own.upper, limit, x, rate, seen)


def as_rest(value: Any, what: str, part: Any) -> tuple[float, float]:
    """Convert a number, or a lower and an upper one, to two finite numbers in order."""
    if isinstance(value, int | float | np.number):
        return (number(value, what),) * 2
    lower, upper = pair if len(pair := as_numbers(value, what, part)) == 2 else (1.0, 0.0)
    if lower > upper:
        raise InputError(f"{what} = {short_repr(value)}; give a number, or (lower, upper) in order")
    return lower, upper


class Rest(Stored[float | Sequence[float], tuple[float, float]]):
    """A rest value, or the range in which the spring is slack."""

    accepts, file_type = "float | tuple[float, float]", float | list[float]
    convert = staticmethod(as_rest)


@part_class()
class SumSpring(ForceElement):
    """Spring and damper on a weighted sum x = sum w_i x_i of angles and slides: load -(k (x - x0) + c x_dot) along x.

    So w_i times it acts along each coordinate, on body b of its joint, and the opposite on a. Energy
    ``k (x - x0)^2 / 2``; dissipated power ``c x_dot^2``. x0 is the nearest value of the rest range.

    Parameters
    ----------
    joints : Joint, or sequence of Joint
        With an angle or a slide; any number of them.
    weights : sequence of float or None
        w_i, one per joint; None = ones.
    of : "angle", "slide", a sequence of them, or None
        Coordinate of joints that have both; None = the angle where there is one, else the slide.
    stiffness, damping : float
        k >= 0 [N/m by (unit of x / m)^2], c >= 0 likewise with seconds.
    rest : float or (lower, upper)
        Value, or range of values, of x where the spring is slack, counted from the reference pose.

    Raises
    ------
    ValueError
        For a joint without the coordinate, weights that are 0 or not one per joint, or a rest range out of order.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, SumSpring, System, accelerations
    >>> one, two = (Body(name, mass=1.0, inertia=(0.3, 0.3, 0.5)) for name in ("one", "two"))
    >>> first, second = (Revolute(GROUND, body, at=(0, 0, 0), axis=(0, 0, 1)) for body in (one, two))
    >>> tendon = SumSpring((first, second), weights=(0.02, -0.01), stiffness=500.0, rest=0.3)
    >>> seen = accelerations(System([one, two], [first, second], [tendon]))
    >>> round(float(seen.alpha(one)[0, 2]), 12), round(float(seen.alpha(two)[0, 2]), 12)  # 150 N by each lever
    (6.0, -3.0)
    """

    law, law_parameters = staticmethod(sum_spring), SUM_SPRING

    joints: Joints = kept()
    _: KW_ONLY
    weights: NumbersOrOnes = kept(default=None)
    of: KindsOrNone = kept(default=None)
    stiffness: Number = kept(minimum=0.0)
    damping: Number = kept(default=0.0, minimum=0.0)
    rest: Rest = kept(default=0.0)

    def check(self, what: str) -> None:
        check_sum(self, what)

    def record(self) -> ForceRecord:
        return record_of_sum(self, *self.rest)

    def partners(self) -> tuple:
        return tuple(dict.fromkeys(self.joints))


@part_class()
class SumStop(Stop):
    """Stops of a weighted sum x = sum w_i x_i of angles and slides: a load ``max(0, k d + c d_dot)`` beyond a limit.

    d is how far x is beyond ``lower`` or ``upper``; w_i times the load acts along each coordinate, on body b of its
    joint, and the opposite on a. It never pulls: a string that goes slack, or a chain of rings that runs out. Energy
    ``k d^2 / 2``; the rest of the power is dissipated, ``c d_dot^2`` in touch.

    Parameters
    ----------
    joints, weights, of
        As of `SumSpring`.
    lower, upper : float or None
        Limits of x, counted from the reference pose; None: no stop there.
    stiffness, damping : float
        k > 0 [N/m by (unit of x / m)^2], c >= 0 likewise with seconds.

    Raises
    ------
    ValueError
        As `SumSpring`; for no limit at all, or a lower one that is not below the upper one. A run that starts from the
        reference pose, and that beyond a limit, is refused at its start.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Prismatic, SumStop, System, simulate
    >>> one, two = (Body(name, mass=2.0, inertia=(0.1, 0.1, 0.1)) for name in ("one", "two"))
    >>> rails = [Prismatic(GROUND, body, at=(0, 0, 0), axis=(0, 0, 1)) for body in (one, two)]
    >>> rope = SumStop(rails, weights=(-1, -2), upper=0.5, stiffness=5e4, damping=300.0)
    >>> run = simulate(System([one, two], rails, [rope], gravity=(0, 0, -1)), 0.3)  # both fall together
    >>> bool(-0.5 - 1e-3 < run.slide(rails[0])[-1] + 2 * run.slide(rails[1])[-1])
    True
    """

    law, law_parameters = staticmethod(sum_stop), SUM_SPRING
    gap, gaps = staticmethod(sum_stop_gap), 2

    joints: Joints = kept()
    _: KW_ONLY
    weights: NumbersOrOnes = kept(default=None)
    of: KindsOrNone = kept(default=None)
    lower: NumberOrNone = kept(default=None)
    upper: NumberOrNone = kept(default=None)
    stiffness: Number = kept(positive=True)
    damping: Number = kept(default=0.0, minimum=0.0)

    def check(self, what: str) -> None:
        check_sum(self, what)
        if self.lower is None and self.upper is None:
            raise InputError(f"{what}: neither lower nor upper; give at least one limit")
        lower, upper = self.limits
        if not lower < upper:
            raise InputError(
                f"{what}: lower = {lower:g} is not below upper = {upper:g}; exchange them or set them apart"
            )

    @property
    def limits(self) -> tuple[float, float]:
        """Return both limits [rad or m], infinite where there is none."""
        return (-np.inf if self.lower is None else self.lower, np.inf if self.upper is None else self.upper)

    def depth_as_built(self) -> float:
        lower, upper = self.limits
        return max(lower, -upper, 0.0)

    def record(self) -> ForceRecord:
        return record_of_sum(self, *self.limits)

    def partners(self) -> tuple:
        return tuple(dict.fromkeys(self.joints))


def check_sum(part: SumSpring | SumStop, what: str) -> None:
    """Check the joints of a sum, and their weights."""
    if not part.joints:
        raise InputError(f"{what}: no joints; give at least one")
    places_of(part.joints, part.weights, part.of, "joints", what)


def record_of_sum(part: SumSpring | SumStop, lower: float, upper: float) -> ForceRecord:
    """Return what the laws of sums read: coordinates, weights, and the range in which there is no load."""
    coordinates, weights = zip(*weighted(part.joints, part.weights, part.of), strict=True)
    bodies = {id(body): body for x in coordinates for body in (x.a, x.b)}
    return ForceRecord(
        tuple(bodies.values()),
        parameters=part.read_by_law(lower=lower, upper=upper),
        measures=tuple(of_coordinate(x, "term of a sum") for x in coordinates),
        series=(weights,),
    )
