"""Forces and torques by a table: over the length of a line, over a hinge coordinate, or over the rate of either."""

from dataclasses import KW_ONLY
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import check_choice, check_size, floats
from ...base.errors import InputError
from ...base.fields import NumberOrDerived, Stored, Vector, kept, locked, part_class
from ...compiler.decorators import inner_kernel
from ...compiler.records import Parameters
from ...kernels.force_laws import add_force, line_between
from ...kernels.vectors import scale
from ..bodies import Body, Ground
from ..force_element import ForceElement, ForceRecord, check_pair, hinge_coordinate
from ..joints import Joint, coordinate_of
from ..joints.conditions import ends_coincide, span
from ..primitives import Coordinate

END_ROUNDING = 1e-9  # [1] of the width of a table: what is beyond its ends by less is at its ends
OVER_RATE = 1  # option of a record


@inner_kernel
def from_table(numbers, x):
    """Return (value, integral) at x of a table as `Curve.numbers` has it; NaN beyond its ends if it refuses them."""
    pieces, breaks = int(numbers[0].real), 3
    low, high = 0, pieces - 1
    while low < high:
        middle = (low + high + 1) // 2
        if numbers[breaks + middle].real <= x.real:
            low = middle
        else:
            high = middle - 1
    c = breaks + pieces + 5 * low
    s = x - numbers[breaks + low]
    c3, c2, c1, c0 = numbers[c], numbers[c + 1], numbers[c + 2], numbers[c + 3]
    inside = 1.0 if numbers[1].real <= x.real <= numbers[2].real else np.nan
    integral = (((0.25 * c3 * s + c2 / 3.0) * s + 0.5 * c1) * s + c0) * s + numbers[c + 4]
    return inside * (((c3 * s + c2) * s + c1) * s + c0), inside * integral


def as_points(value: Any, what: str, part: Any) -> np.ndarray:
    """Convert to a new array of (k, 2) points with ascending first numbers."""
    points = floats(value, what, "(k, 2) numbers: pairs of x and y")
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2:
        raise InputError(f"{what} has shape {points.shape}; give two or more pairs of x and y, (k, 2)")
    back = np.flatnonzero(np.diff(points[:, 0]) <= 0.0)
    if back.size:
        k = back[0]
        raise InputError(
            f"{what}: x = {points[k + 1, 0]:.9g} (no. {k + 2}) does not come after {points[k, 0]:.9g}; sort the points "
            "and keep one per x"
        )
    check_size(points, what)
    return locked(points)


class Points(Stored[ArrayLike, np.ndarray]):
    """Pairs of x and y, x ascending."""

    accepts, file_type = "array_like", list[list[float]]
    convert = staticmethod(as_points)


class ByTable(ForceElement):
    """Base class of forces that read y over x from a table."""

    points: Points
    between: str
    beyond: str

    def check(self, what: str) -> None:
        check_choice(self.between, ("linear", "monotone"), f"{what}: between")
        check_choice(self.beyond, ("refuse", "hold", "line"), f"{what}: beyond")

    @cached_property
    def numbers(self) -> np.ndarray:
        """Return what `from_table` reads: number n of pieces, ends, n starts, then c3 to c0 and integral of each.

        The value is ``c3 s^3 + c2 s^2 + c1 s + c0`` at s behind the start; the integral is 0 at x = 0, or at the end
        that is nearer. What goes on beyond the ends are pieces too, the first of which starts a piece's width earlier.
        """
        x, y = self.points.T
        width = np.diff(x)
        slope = np.diff(y) / width
        if self.between == "linear":
            c = np.column_stack([0.0 * slope, 0.0 * slope, slope, y[:-1]])
        else:
            from scipy.interpolate import PchipInterpolator  # a tenth of a second, for such tables alone

            c = PchipInterpolator(x, y).c.T
        starts = x[:-1]
        reach = END_ROUNDING * (x[-1] - x[0])
        ends = [x[0] - reach, x[-1] + reach]
        if self.beyond != "refuse":
            last = ((3.0 * c[-1, 0] * width[-1] + 2.0 * c[-1, 1]) * width[-1]) + c[-1, 2]
            first, last = (c[0, 2], last) if self.beyond == "line" else (0.0, 0.0)
            c = np.vstack([[0.0, 0.0, first, y[0] - first * width[0]], c, [0.0, 0.0, last, y[-1]]])
            starts, ends = np.concatenate([[x[0] - width[0]], x]), [-np.inf, np.inf]
        area = c / (4.0, 3.0, 2.0, 1.0)
        s = np.diff(starts)[:, None]
        rises = (area[:-1] * s ** np.arange(4, 0, -1)).sum(axis=1)
        integral = np.concatenate([[0.0], np.cumsum(rises)])
        zero = np.clip(0.0, x[0], x[-1])
        k = max(int(np.searchsorted(starts, zero, side="right")) - 1, 0)
        integral -= integral[k] + area[k] @ (zero - starts[k]) ** np.arange(4, 0, -1)
        return locked(np.concatenate([[len(c), *ends], starts, np.column_stack([c, integral]).ravel()]))


FORCE_CURVE = Parameters(length="m")
force_curve_parameters = FORCE_CURVE.reader()


@inner_kernel
def force_curve(m, d, p, out, t):
    """Pull by a table along the line from a to b: over the stretch l - l0, or over its rate (option)."""
    own = force_curve_parameters(m.number, p.number)
    numbers = m.number[p.number + p.named : p.number + p.numbers]
    length, speed, n, sa, sb = line_between(d, p)  # NaN where the ends meet: the run names the part
    if p.option == OVER_RATE:
        pull, _ = from_table(numbers, speed)
        out.potential = 0.0 * pull
        out.power = -pull * speed
    else:
        pull, stored = from_table(numbers, length - own.length)
        out.potential = stored
        out.power = 0.0 * pull
    add_force(d.body[p.body[0]], scale(pull, n), sa)
    add_force(d.body[p.body[1]], scale(-pull, n), sb)


@part_class()
class ForceCurve(ByTable):
    """Spring or damper by a table, along the line between a point of body ``a`` and a point of body ``b``.

    The force on ``b`` is ``-F n``, with ``n`` from a to b and F read from the table over the stretch ``l - l0`` of the
    distance l, or over its rate: F > 0 pulls the points together. The opposite force acts on ``a``. Over the stretch
    the energy is the integral of F, and none is dissipated; over the rate all of the power ``F l_dot`` is. A spring
    and a damper by tables are two of them.

    Parameters
    ----------
    at_a, at_b : (3,) array_like
        End points, world at the reference pose [m].
    points : (k, 2) array_like
        Pairs of stretch [m] or rate [m/s], ascending, and F [N].
    over : "stretch" or "rate"
    between : "linear" or "monotone"
        Between the points: straight lines, or cubic pieces without corners and without overshoot (Fritsch and Carlson).
    beyond : "refuse", "hold" or "line"
        Beyond the first and last point: an error of the run, their F, or the line that leads through them.
    length : float or None
        l0 >= 0 [m]; None = the distance at the reference pose, 0 for a table over the distance itself.

    Raises
    ------
    ValueError
        If the end points coincide, points do not ascend or are fewer than two, or a choice is unknown.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, ForceCurve, System, accelerations
    >>> cart = Body("cart", mass=2.0, inertia=(0.1, 0.1, 0.1), position=(1.2, 0, 0))
    >>> ends = dict(at_a=(0, 0, 0), at_b=(1.2, 0, 0), length=1.0)
    >>> spring = ForceCurve(GROUND, cart, **ends, points=[(0, 0), (0.1, 100), (0.3, 500)])
    >>> now = accelerations(System([cart], forces=[spring], gravity=(0, 0, 0)))
    >>> round(float(now.acceleration(cart)[0, 0]), 9), round(float(now.energy().potential[0]), 9)  # -300/2; 5 + 20 J
    (-150.0, 25.0)
    """

    law, law_parameters = staticmethod(force_curve), FORCE_CURVE

    a: Body | Ground
    b: Body | Ground
    _: KW_ONLY
    at_a: Vector = kept()
    at_b: Vector = kept()
    points: Points = kept()
    over: str = "stretch"
    between: str = "linear"
    beyond: str = "refuse"
    length: NumberOrDerived = kept(default=None, minimum=0.0, derived=span)

    def check(self, what: str) -> None:
        super().check(what)
        check_choice(self.over, ("stretch", "rate"), f"{what}: over")
        check_pair(self.a, self.b, what)
        if ends_coincide(self):
            raise InputError(f"{what}: at_a and at_b coincide, so the force has no direction; move one of them")

    def record(self) -> ForceRecord:
        return ForceRecord(
            (self.a, self.b), (self.at_a, self.at_b), parameters=self.read_by_law(), series=(self.numbers,),
            option=OVER_RATE if self.over == "rate" else 0,
        )  # fmt: skip


@inner_kernel
def torque_curve(m, d, p, out, t):
    """Load by a table over a hinge coordinate, or over its rate (option)."""
    numbers = m.number[p.number : p.number + p.numbers]
    if p.option == OVER_RATE:
        out.load, _ = from_table(numbers, out.rate)
        out.potential = 0.0 * out.load
        out.power = out.load * out.rate
    else:
        out.load, integral = from_table(numbers, out.x)
        out.potential = -integral
        out.power = 0.0 * out.load


@part_class()
class TorqueCurve(ByTable):
    """Torque by a table between the sides of a hinge: a motor over its speed, a damper, a spring over its angle.

    T, read over the rate or over the counted angle, acts on body b about the axis, the opposite torque on a: T > 0
    drives the angle up. In a slide it is a force. Over the angle or slide the energy is minus the integral of T; over
    the rate the power ``T x_dot`` counts as work.

    Parameters
    ----------
    joint : Joint
        A joint with an angle or a slide.
    points : (k, 2) array_like
        Pairs of rate [rad/s or m/s], angle [rad] or slide [m], ascending, and T [N m or N].
    over : "rate", "angle" or "slide"
        "rate" is that of the angle, else of the slide.
    between : "linear" or "monotone"
        Between the points: straight lines, or cubic pieces without corners and without overshoot (Fritsch and Carlson).
    beyond : "refuse", "hold" or "line"
        Beyond the first and last point: an error of the run, their T, or the line that leads through them.

    Raises
    ------
    ValueError
        For a joint without the coordinate, points that do not ascend or are fewer than two, or an unknown choice.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, System, TorqueCurve, accelerations
    >>> rotor = Body("rotor", mass=2.0, inertia=(0.3, 0.3, 0.4), omega=(0, 0, 75.0))
    >>> hinge = Revolute(GROUND, rotor, at=(0, 0, 0), axis=(0, 0, 1))
    >>> motor = TorqueCurve(hinge, points=[(0, 30), (50, 28), (100, 35), (157, 0)])
    >>> round(float(accelerations(System([rotor], [hinge], [motor])).alpha(rotor)[0, 2]), 9)  # 31.5 / 0.4
    78.75
    """

    law = staticmethod(torque_curve)

    joint: Joint
    _: KW_ONLY
    points: Points = kept()
    over: str = "rate"
    between: str = "linear"
    beyond: str = "refuse"

    def check(self, what: str) -> None:
        super().check(what)
        check_choice(self.over, ("rate", "angle", "slide"), f"{what}: over")
        self.coordinate(what)

    def coordinate(self, what: str) -> Coordinate:
        """Return the coordinate along which the load acts."""
        return hinge_coordinate(self.joint, what) if self.over == "rate" else coordinate_of(self.joint, self.over, what)

    def record(self) -> ForceRecord:
        x = self.coordinate("")
        return ForceRecord(
            (x.a, x.b), coordinate=x, series=(self.numbers,), option=OVER_RATE if self.over == "rate" else 0
        )

    def partners(self) -> tuple:
        return (self.joint,)
