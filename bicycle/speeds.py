"""The speeds at which the modes of a bicycle change character: weave, capsize, double roots, self-stable ranges."""

from dataclasses import dataclass

from . import critical
from .critical import Range
from .double_roots import DoubleRoot, double_roots
from .equations import Canonical, canonical
from .general import Build, linear_equations
from .parameters import Parameters


@dataclass(frozen=True)
class CriticalSpeeds:
    """Of one bicycle; speeds [m/s], NaN where there is none.

    Attributes
    ----------
    weave : float
        Above it weave no longer grows.
    capsize : float
        At it one eigenvalue is zero.
    weave_rate : float
        omega of the weave at that speed [rad/s].
    double_roots : list of DoubleRoot
        Speeds at which two real modes meet, with their eigenvalue.
    stable : list of Range
        All ranges of speed in which every motion decays.
    """

    weave: float
    capsize: float
    weave_rate: float
    double_roots: list[DoubleRoot]
    stable: list[Range]

    def __str__(self) -> str:
        weave = f"{self.weave:.12g} m/s, omega {self.weave_rate:.12g} rad/s"
        lines = [
            f"weave     {weave if self.weave > 0.0 else '-'}",
            f"capsize   {f'{self.capsize:.12g} m/s' if self.capsize > 0.0 else '-'}",
            *(f"two modes meet at {x.speed:.12g} m/s, {x.eigenvalue:.12g} 1/s" for x in self.double_roots),
            f"stable    {', '.join(map(str, self.stable)) or 'at no speed'}",
        ]
        return "\n".join(lines)


def critical_speeds(parameters: Parameters, build: Build | None = None, *, speed: float = 5.0) -> CriticalSpeeds:
    """Weave, capsize and double-root speeds and all self-stable ranges, from the characteristic polynomial.

    Parameters
    ----------
    parameters : Parameters
    build : callable or None
        A model, e.g. `bicycle.whipple`: its linearisation; None = the closed form.
    speed : float
        At which the model is linearised [m/s].

    Raises
    ------
    ValueError
        If the equations of a model do not have the form of `bicycle.general`.

    Examples
    --------
    >>> from bicycle import Meijaard2007
    >>> round(critical_speeds(Meijaard2007()).weave, 9)
    4.292382536
    """
    linear = canonical(parameters) if build is None else linear_equations(build, parameters, speed)
    if linear is None:
        raise ValueError(
            f"bicycle '{parameters.name}': a force depends on speed otherwise than through the motion, so critical "
            "speeds do not follow from a polynomial; see the eigenvalues"
        )
    return speeds_of(linear)


def speeds_of(linear: Canonical) -> CriticalSpeeds:
    """Critical speeds of linear equations."""
    q = critical.quartic(linear.M, linear.C1, linear.g * linear.K0, linear.K2)
    weave = critical.weave(q)
    rate = critical.weave_rate(q, weave)
    return CriticalSpeeds(float(weave), float(critical.capsize(q)), float(rate), double_roots(q), critical.ranges(q))
