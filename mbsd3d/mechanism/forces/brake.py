"""A brake or a clutch: dry friction in a hinge or slide that slips at a given torque and holds at rest."""

from dataclasses import KW_ONLY

from ...base.errors import InputError
from ...base.fields import Number, kept, part_class
from ...compiler.decorators import inner_kernel
from ...compiler.records import Parameters
from ...kernels.signals import signal
from ..force_element import ForceElement, ForceRecord, hinge_coordinate
from ..joints import Joint
from ..signals import Constant, SignalField

BRAKE_ELASTIC_SLIP = 1e-3
"""rad or m: about what a brake yields before it slips."""


BRAKE = Parameters(stiffness="N m/rad or N/m", damping="N m s/rad or N s/m")
brake_parameters = BRAKE.reader()


@inner_kernel
def brake(m, d, p, out, t):
    """Load -clip(k z + c x_dot, T) along a hinge coordinate; signal T."""
    own = brake_parameters(m.number, p.number)
    k, c, z = own.stiffness, own.damping, d.z[p.state]
    most = signal(m, p.signal[0], t)[0]
    f = k * z + c * out.rate
    if most.real <= 0.0:
        f = 0.0 * f
    elif f.real > most.real:
        f = most + 0.0 * f
    elif f.real < -most.real:
        f = -most + 0.0 * f
    z_dot = (f - k * z) / c
    d.state_rate[p.state] = z_dot
    out.load = -f
    out.potential = 0.5 * k * z * z
    out.power = k * z * z_dot - f * out.rate


@part_class()
class Brake(ForceElement):
    """Dry friction in a hinge or slide with a torque (or force) T that may change: load -clip(k z + c x_dot, T) on b.

    The yielding z is an internal state, ``z_dot = (f - k z) / c`` with the f that acts. While f stays within T it is
    ``z_dot = x_dot``: the brake holds like a spring and a damper and does not creep. Beyond, it slips with T exactly.
    It never turns anything back by more than T/k, and it always dissipates. Energy ``k z^2 / 2``.

    Parameters
    ----------
    torque : Signal or float
        T [N m or N]; a signal below 0 counts as 0, which releases the brake.
    stiffness, damping : float
        k > 0 [N m/rad or N/m], c > 0 [N m s/rad or N s/m]. It yields by T/k before it slips; what it holds, a mass m on
        a wheel of radius r say, comes to rest without much ringing for c near ``sqrt(k m r^2)``.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Brake, Revolute, System, simulate
    >>> disc = Body("disc", mass=2.0, inertia=(0.3, 0.3, 0.5), omega=(0, 0, 5.0))
    >>> hinge = Revolute(GROUND, disc, at=(0, 0, 0), axis=(0, 0, 1))
    >>> stopped = simulate(System([disc], [hinge], [Brake(hinge, torque=2.0, stiffness=2e3, damping=20.0)]), 3.0)
    >>> round(float(stopped.angle(hinge)[-1]), 4)  # 0.5 * 5^2 / (2 * 2.0) to the stop, then back by 2.0 / 2e3
    3.124
    """

    law, law_parameters = staticmethod(brake), BRAKE

    hinge: Joint
    _: KW_ONLY
    torque: SignalField = kept()
    stiffness: Number = kept(positive=True)
    damping: Number = kept(positive=True)

    def check(self, what: str) -> None:
        hinge_coordinate(self.hinge, what)
        if isinstance(self.torque, Constant) and self.torque.value < 0.0:
            raise InputError(f"{what}: torque = {self.torque.value:g}; a brake has none below 0")

    def signal_unit(self) -> str:
        return "N m" if hinge_coordinate(self.hinge, "").kind == "angle" else "N"

    def record(self) -> ForceRecord:
        x = hinge_coordinate(self.hinge, "")
        return ForceRecord(
            (x.a, x.b), parameters=self.read_by_law(), signals=(self.torque, None, None), coordinate=x,
            states=(0.0,), scales=((BRAKE_ELASTIC_SLIP, 0.0, 0.0),),
        )  # fmt: skip

    def partners(self) -> tuple:
        return (self.hinge,)

    def state_names(self) -> tuple[str, ...]:
        return ("yielding",)
