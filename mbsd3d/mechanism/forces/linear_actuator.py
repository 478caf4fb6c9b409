"""A linear actuator between two points: its thrust falls off with its rate, and it ends at its stops."""

from dataclasses import KW_ONLY

import numpy as np

from ...base.errors import InputError
from ...base.fields import Number, NumberOrNone, Numbers, Vector, kept, part_class
from ...compiler.decorators import inner_kernel
from ...compiler.records import Parameters
from ...kernels.force_laws import add_force, line_between
from ...kernels.signals import signal
from ...kernels.vectors import scale
from ..bodies import Body, Ground
from ..force_element import ForceRecord, check_pair
from ..joints.conditions import ends_coincide, span
from ..signals import SignalField
from .end_stop import Stop, range_gap, range_load

LINEAR_ACTUATOR = Parameters(shortest="m", longest="m", rate="m/s", stiffness="N/m", damping="N s/m")
actuator_parameters = LINEAR_ACTUATOR.reader()


@inner_kernel
def thrust_at(thrust, rate, most):
    """Return T clip(1 - l_dot / v0, -1, 1), with v0 the rate without load in the direction of T."""
    way = -1.0 if thrust.real < 0.0 else 1.0
    share = 1.0 - way * rate / most
    if share.real > 1.0:
        share = 1.0 + 0.0 * share
    elif share.real < -1.0:
        share = -1.0 + 0.0 * share
    return thrust * share


@inner_kernel
def linear_actuator(m, d, p, out, t):
    """Push along the line from a to b: thrust at the rate, and the stops at both ends of the stroke."""
    own = actuator_parameters(m.number, p.number)
    length, rate, n, sa, sb = line_between(d, p)
    thrust = thrust_at(signal(m, p.signal[0], t)[0] + 0.0 * rate, rate, own.rate)
    load, out.potential, lost = range_load(own.stiffness, own.damping, own.shortest, own.longest, length, rate)
    push = thrust + load
    out.power = (thrust + lost) * rate
    add_force(d.body[p.body[0]], scale(-push, n), sa)
    add_force(d.body[p.body[1]], scale(push, n), sb)


@inner_kernel
def actuator_gap(m, d, p, limit, t, seen):
    """See how far the length is from its least (0) or its greatest (1)."""
    own = actuator_parameters(m.number, p.number)
    length, rate, _, _, _ = line_between(d, p)
    range_gap(own, own.shortest, own.longest, limit, length, rate, seen)


@part_class()
class LinearActuator(Stop):
    """A linear actuator, electric or hydraulic, between a point of body ``a`` and a point of body ``b``.

    It pushes the points apart with ``T clip(1 - l_dot / v0, -1, 1)``, T the thrust that a signal commands (below 0 it
    pulls) and v0 the rate without load, towards which it moves; against a load that drives it back it holds T. At both
    ends of its stroke a stop presses back with ``max(0, k d + c d_dot)``, as an `EndStop`. The opposite force acts on
    ``a``. Energy ``k d^2 / 2`` of the stops; all else counts as work. For a length that is prescribed see
    `LengthDriver`.

    Parameters
    ----------
    at_a, at_b : (3,) array_like
        End points, world at the reference pose [m].
    thrust : Signal or float
        T [N], > 0 to extend.
    rate : float or None
        v0 > 0 [m/s]; None: the thrust is the same at all rates.
    stroke : (shortest, longest)
        Lengths between the end points at the stops [m].
    stiffness, damping : float
        k > 0 [N/m], c >= 0 [N s/m] of the stops.

    Raises
    ------
    ValueError
        If the end points coincide or the stroke is none. A run that starts from the reference pose, and that beyond a
        stop, is refused at its start.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, LinearActuator, Prismatic, System, simulate
    >>> gate = Body("gate", mass=50.0, inertia=(1.0, 1.0, 1.0), position=(0, 0, 1.0))
    >>> guide = Prismatic(GROUND, gate, at=(0, 0, 0), axis=(0, 0, 1), name="guide")
    >>> ends = dict(at_a=(0, 0, 0), at_b=(0, 0, 1.0), stroke=(0.9, 1.5), stiffness=1e5, damping=2e3)
    >>> lift = LinearActuator(GROUND, gate, thrust=800.0, rate=0.4, **ends)
    >>> up = simulate(System([gate], [guide], [lift]), 8.0)
    >>> bool(0.5 < up.slide(guide)[-1] < 0.504)  # 310 N more than the weight press it into the upper stop
    True
    """

    law, law_parameters = staticmethod(linear_actuator), LINEAR_ACTUATOR
    gap, gaps = staticmethod(actuator_gap), 2

    a: Body | Ground
    b: Body | Ground
    _: KW_ONLY
    at_a: Vector = kept()
    at_b: Vector = kept()
    thrust: SignalField = kept()
    rate: NumberOrNone = kept(default=None, positive=True)
    stroke: Numbers = kept()
    stiffness: Number = kept(positive=True)
    damping: Number = kept(default=0.0, minimum=0.0)

    def check(self, what: str) -> None:
        check_pair(self.a, self.b, what)
        if ends_coincide(self):
            raise InputError(f"{what}: at_a and at_b coincide, so the thrust has no direction; move one of them")
        if len(self.stroke) != 2 or not 0.0 < self.stroke[0] < self.stroke[1]:
            raise InputError(f"{what}: stroke = {self.stroke}; give the shortest and the longest length, both above 0")

    def depth_as_built(self) -> float:
        shortest, longest = self.stroke
        return max(shortest - span(self), span(self) - longest, 0.0)

    def signal_unit(self) -> str:
        return "N"

    def record(self) -> ForceRecord:
        rate = np.inf if self.rate is None else self.rate
        shortest, longest = self.stroke
        return ForceRecord(
            (self.a, self.b), (self.at_a, self.at_b), signals=(self.thrust, None, None),
            parameters=self.read_by_law(shortest=shortest, longest=longest, rate=rate),
        )  # fmt: skip
