"""Springs and dampers on weighted sums of angles and slides, as fixed tendons have them."""

from collections.abc import Sequence
from dataclasses import KW_ONLY
from typing import Any

import numpy as np

from ...base.checks import number, short_repr
from ...base.errors import InputError
from ...base.fields import Number, Stored, as_numbers, kept, part_class
from ...compiler.decorators import inner_kernel
from ...compiler.records import Parameters
from ...kernels.coordinates import coordinate
from ...kernels.force_laws import series
from ...kernels.vectors import add6, dot, scale, vec
from ..force_element import ForceElement, ForceRecord
from ..measures import of_coordinate
from ..sums import Joints, KindsOrNone, NumbersOrOnes, places_of, weighted

SUM_SPRING = Parameters(stiffness="N m/rad or N/m", damping="N m s/rad or N s/m", lower="rad or m", upper="rad or m")
sum_spring_parameters = SUM_SPRING.reader()


@inner_kernel
def sum_spring(m, d, p, out, t):
    """Load -(k (x - x0) + c x_dot) along x = sum w_i x_i, so w_i times it along each; x0 is the nearest rest value."""
    own, weights = sum_spring_parameters(m.number, p.number), series(m, p, 0, p.measures)
    x, rate = 0.0, 0.0
    for apply in range(2):
        stretch = x - own.upper if x.real > own.upper else x - own.lower if x.real < own.lower else 0.0 * x
        load = -own.stiffness * stretch - own.damping * rate
        for i in range(p.measures):
            k = m.measure[p.measure + i].coordinate
            a, b = d.body[m.coordinate[k].body[0]], d.body[m.coordinate[k].body[1]]
            value, _, la, ta, lb, tb = coordinate(m, d, k, t)
            if apply == 0:
                x += weights[i] * value
                rate += weights[i] * (
                    dot(la, vec(a.velocity)) + dot(ta, vec(a.w)) + dot(lb, vec(b.velocity)) + dot(tb, vec(b.w))
                )
            else:
                share = weights[i] * load
                add6(a.Q, scale(share, la), scale(share, ta))
                add6(b.Q, scale(share, lb), scale(share, tb))
        if apply == 1:
            out.potential = 0.5 * own.stiffness * stretch * stretch
            out.power = -own.damping * rate * rate


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
        w_i, one a joint; None = ones.
    of : "angle", "slide", a sequence of them, or None
        Coordinate of joints that have both; None = the angle where there is one, else the slide.
    stiffness, damping : float
        k >= 0 [N/m by (unit of x / m)^2], c >= 0 likewise with seconds.
    rest : float or (lower, upper)
        Value, or range of values, of x where the spring is slack, counted from the reference pose.

    Raises
    ------
    ValueError
        For a joint without the coordinate, weights that are 0 or not one a joint, or a rest range out of order.

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
        if not self.joints:
            raise InputError(f"{what}: no joints; give at least one")
        places_of(self.joints, self.weights, self.of, "joints", what)

    def record(self) -> ForceRecord:
        coordinates, weights = zip(*weighted(self.joints, self.weights, self.of), strict=True)
        bodies = {id(body): body for x in coordinates for body in (x.a, x.b)}
        lower, upper = self.rest
        return ForceRecord(
            tuple(bodies.values()),
            parameters=self.read_by_law(lower=lower, upper=upper),
            measures=tuple(of_coordinate(x, "term of a sum") for x in coordinates),
            series=(weights,),
        )

    def partners(self) -> tuple:
        return tuple(dict.fromkeys(self.joints))
