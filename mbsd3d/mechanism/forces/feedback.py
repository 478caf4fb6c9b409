"""Feedback of measures: loads of a controller, a rider or a governor."""

from collections.abc import Sequence
from dataclasses import KW_ONLY
from typing import Any

from ...base.errors import InputError
from ...base.fields import NumberOrNone, Numbers, NumbersOrDerived, Stored, kept, part_class
from ...base.wording import counted
from ...compiler.decorators import inner_kernel
from ...compiler.records import Parameters
from ...kernels.force_laws import series
from ...kernels.measures import measure
from ..force_element import ForceElement, ForceRecord, hinge_coordinate
from ..joints import Joint
from ..measures import Measure, unit_powers

FEEDBACK = Parameters(time_constant="s")
feedback_parameters = FEEDBACK.reader()


@inner_kernel
def feedback(m, d, p, out, t):
    """Load -sum g_i (x_i - r_i); x_i is measure i or its filtered value z_i with z_dot_i = (y_i - z_i) / tau."""
    own, load = feedback_parameters(m.number, p.number), 0.0
    gains, references = series(m, p, 0, p.measures), series(m, p, 1, p.measures)
    for i in range(p.measures):
        x = measure(m, d, p.measure + i, t)
        if p.states > 0:
            z = d.z[p.state + i]
            d.state_rate[p.state + i] = (x - z) / own.time_constant
            x = z
        load -= gains[i] * (x - references[i])
    out.load = load
    out.power = load * out.rate


def as_measures(value: Any, what: str, part: Any) -> tuple[Measure, ...]:
    """Convert to measures, at least one."""
    what = what.removesuffix(": measures")
    seen = tuple(value) if isinstance(value, Sequence) else (value,)
    if not seen:
        raise InputError(f"{what}: no measures; give at least one of mbsd3d.measures")
    for x in seen:
        if not isinstance(x, Measure):
            raise InputError(f"{what}: {x!r} is not a measure; build one with mbsd3d.measures")
        if x.joint is not None or x.kind == "holding load":
            raise InputError(
                f"{what}: the load would change {x.label}, which it reads at the same time; give measures of motion"
            )
    return seen


class Measures(Stored[Measure | Sequence[Measure], tuple[Measure, ...]]):
    """Measures; a single one needs no sequence."""

    accepts, file_type = "Measure | Sequence[Measure]", list[dict]
    convert = staticmethod(as_measures)


@part_class()
class StateFeedback(ForceElement):
    """Load ``-sum_i g_i (x_i - r_i)`` on body b of a hinge, the opposite one on a; its work enters the energy balance.

    ``x_i`` is measure i, or with a time constant its first-order filter: internal states ``z_i`` with
    ``z_dot_i = (y_i - z_i) / tau``. The filters start at the references, so that the load starts from zero, unless
    the start state says otherwise (``State.z``).

    Parameters
    ----------
    measures : sequence of Measure
        Measured quantities, from `mbsd3d.measures`.
    gains : sequence of float
        g_i [N m or N per unit of measure i]; one per measure.
    on : Joint
        Hinge or slider along whose coordinate the load acts.
    reference : sequence of float or None
        r_i, in the units of the measures; None = zeros.
    time_constant : float or None
        tau > 0 [s]; None = no filter.

    Raises
    ------
    ValueError
        For sequences of different lengths, numbers that are not finite, no measure, or a joint without a coordinate.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, StateFeedback, System, accelerations, measures
    >>> arm = Body("arm", mass=2.0, inertia=(0.1, 0.5, 0.5), com=(0.5, 0, 0))
    >>> hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 0, 1))
    >>> seen = [measures.angle(hinge), measures.rate(hinge)]
    >>> servo = StateFeedback(measures=seen, gains=(30.0, 4.0), on=hinge, reference=(0.2, 0.0))
    >>> system = System([arm], [hinge], [servo])
    >>> round(float(accelerations(system).alpha(arm)[0, 2]), 12)  # 30 * 0.2 / (0.5 + 2 * 0.5^2)
    6.0
    """

    law, law_parameters = staticmethod(feedback), FEEDBACK

    _: KW_ONLY
    measures: Measures = kept()
    gains: Numbers = kept()
    on: Joint
    reference: NumbersOrDerived = kept(default=None, derived=lambda feedback: (0.0,) * len(feedback.measures))
    time_constant: NumberOrNone = kept(default=None, positive=True)

    def check(self, what: str) -> None:
        hinge_coordinate(self.on, f"{what}: on")
        for name, values in (("gains", self.gains), ("reference", self.reference)):
            if len(values) != len(self.measures):
                raise InputError(
                    f"{what}: {name}: {counted(len(values), 'value')} for {counted(len(self.measures), 'measure')}; "
                    "give one per measure"
                )

    def record(self) -> ForceRecord:
        x, filtered = hinge_coordinate(self.on, ""), self.time_constant is not None
        return ForceRecord(
            (x.a, x.b),
            parameters=self.read_by_law(time_constant=self.time_constant or 0.0),
            coordinate=x,
            measures=self.measures,
            series=(self.gains, self.reference),
            states=self.reference if filtered else (),
            scales=tuple(unit_powers(x) for x in self.measures) if filtered else (),
        )

    def bodies(self) -> tuple:
        return (*self.record().bodies, *(body for x in self.measures for body in (x.a, x.b)))

    def partners(self) -> tuple:
        return (self.on, *(x.part for x in self.measures if x.part is not None))

    def state_names(self) -> tuple[str, ...]:
        if self.time_constant is None:
            return ()
        labels = tuple(measure.label for measure in self.measures)
        return labels if len(set(labels)) == len(labels) else tuple(f"{x} ({k})" for k, x in enumerate(labels))
