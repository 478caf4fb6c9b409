"""Stresses of a pin that holds a link in a fork or on a cheek, from the reaction of a joint across its axis.

Double shear, cheeks of width a on both sides of a link of width b, gaps g, the pressure of each even over its width:

    tau = F / (2 A)        M = F/2 (a/2 + g + b/4)        sigma = 32 M / (pi d^3)

Single shear, the pin held in one cheek like a cantilever, where the pressure changes linearly over its width a:

    tau = F / A            M = F (e + x/2 - x^2 / (6 a)),  e = g + b/2,  x = a^2 / (3 a + 6 e): where no shear is left

The shear stress is 4/3 of the mean tau at the axis of the pin and vanishes at the fibres that bend most, so that
sqrt(sigma^2 + 3 tau^2) is a bound. A fibre at the angle phi feels ``sigma cos(phi - angle of F)``: a load of constant
size that turns against the pin loads every fibre from one side to the other.
"""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from ..base.checks import check_choice
from ..base.errors import InputError
from ..base.fields import Checked, Number, NumberOrNone, kept, part_class
from ..base.style import Sampled
from .bearings import BearingLoad
from .fatigue import Cycles, Life, miner, rainflow

FIBRES = 36
"""[1] Fibres around a pin: one is within 5 degrees of any load, whose amplitude it then feels to 0.4 %."""
SHEARS = {"double": 2, "single": 1}  # -> shear planes
SHEAR_PEAK = 4.0 / 3.0  # [1] greatest shear stress of a round section over its mean


@part_class(eq=True)
class Pin(Checked):
    """A round pin: ``diameter`` d, width ``cheek`` a of the fork or holder, ``link`` b, ``gap`` g between them [m].

    ``shear``: "double" in a fork, "single" on one cheek. ``lever``: M / F [m], of another support than these.
    """

    _: KW_ONLY
    diameter: Number = kept(positive=True)
    cheek: Number = kept(positive=True)
    link: Number = kept(positive=True)
    gap: Number = kept(default=0.0, minimum=0.0)
    shear: str = "double"
    lever: NumberOrNone = kept(default=None, minimum=0.0)

    def what(self) -> str:
        return "pin_stress"

    def check(self, what: str) -> None:
        check_choice(self.shear, tuple(SHEARS), f"{what}: shear")

    @property
    def arm(self) -> float:
        """Return M / F [m]."""
        if self.lever is not None:
            return self.lever
        a, b, g = self.cheek, self.link, self.gap
        if self.shear == "double":
            return 0.5 * (0.5 * a + g + 0.25 * b)
        e = g + 0.5 * b
        x = a * a / (3.0 * a + 6.0 * e)
        return e + 0.5 * x - x * x / (6.0 * a)

    @property
    def area(self) -> float:
        """Return the area of all shear planes [m^2]."""
        return SHEARS[self.shear] * 0.25 * np.pi * self.diameter**2


@dataclass(frozen=True, eq=False, repr=False)
class PinLife:
    """Damage of the fibres of a pin in one run, and the number of runs that the worst fibre survives."""

    damage: np.ndarray  # (36,) Miner's sums of the fibres in one run
    angles: np.ndarray  # (36,) [rad] of the fibres
    duration: float  # of the run [s]
    name: str

    @property
    def worst(self) -> float:
        """Return the angle [rad] of the fibre of greatest damage."""
        return float(self.angles[int(np.argmax(self.damage))])

    @property
    def runs(self) -> float:
        """Return how often the run can be repeated until the worst fibre fails; infinite without damage."""
        most = float(self.damage.max())
        return 1.0 / most if most > 0.0 else np.inf

    @property
    def hours(self) -> float:
        """Return the life until the worst fibre fails [h]."""
        return self.runs * self.duration / 3600.0

    def __repr__(self) -> str:
        return (
            f"<life of pin '{self.name}': {self.runs:.4g} runs, {self.hours:.4g} h; damage {self.damage.max():.4g} a "
            f"run at {np.degrees(self.worst):.0f} deg>"
        )


@dataclass(frozen=True, eq=False, repr=False)
class PinStress(Sampled):
    """Stresses of a pin at the samples, in the axes of the part that holds it.

    They follow from the force across the axis alone: a tilting moment, whose greatest value `tilting` gives, is assumed
    to be carried by faces or a second eye.
    """

    t: np.ndarray  # (samples,) [s]
    force: np.ndarray  # (samples, 2) across the axis, on the pin by the part that does not hold it [N]
    pin: Pin
    rtol: float  # of the run: ranges below it are rounding
    tilting: float  # greatest tilting moment of the joint [N m], not in these stresses; NaN where it is not determined
    name: str

    @property
    def angles(self) -> np.ndarray:
        """Return the angles of the fibres (36,) [rad], counted about the axis of the pin."""
        return 2.0 * np.pi / FIBRES * np.arange(FIBRES)

    @property
    def load(self) -> np.ndarray:
        """Return the size of the force (samples,) [N]."""
        return np.hypot(self.force[:, 0], self.force[:, 1])

    @property
    def fibres(self) -> np.ndarray:
        """Return the bending stress of each fibre (samples, 36) [Pa]; tension where the force of a link points to."""
        towards = np.stack([np.cos(self.angles), np.sin(self.angles)])
        return self.force @ towards * self.bending_per_force

    @property
    def bending_per_force(self) -> float:
        """Return the bending stress over the force, 32 M / (pi d^3 F) [1/m^2]."""
        return 32.0 * self.pin.arm / (np.pi * self.pin.diameter**3)

    @property
    def moment(self) -> np.ndarray:
        """Return the greatest bending moment along the pin (samples,) [N m]."""
        return self.load * self.pin.arm

    @property
    def bending(self) -> np.ndarray:
        """Return the bending stress (samples,) [Pa] of the fibre that the load points to."""
        return self.load * self.bending_per_force

    @property
    def shear(self) -> np.ndarray:
        """Return the mean shear stress tau (samples,) [Pa] of a shear plane."""
        return self.load / self.pin.area

    @property
    def shear_peak(self) -> np.ndarray:
        """Return the shear stress at the axis (samples,) [Pa], 4/3 of the mean."""
        return SHEAR_PEAK * self.shear

    @property
    def von_mises(self) -> np.ndarray:
        """Return the greater of the equivalent stresses at the fibre and at the axis (samples,) [Pa]."""
        return np.maximum(self.bending, np.sqrt(3.0) * self.shear_peak)

    @property
    def bound(self) -> np.ndarray:
        """Return sqrt(sigma^2 + 3 tau^2) (samples,) [Pa], which no point of the pin exceeds."""
        return np.sqrt(self.bending**2 + 3.0 * self.shear**2)

    @property
    def pressures(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the mean pressures F / (d b) of the link and F / (d a) of a cheek, half of it in a fork [Pa]."""
        d = self.pin.diameter
        return self.load / (d * self.pin.link), self.load / (SHEARS[self.pin.shear] * d * self.pin.cheek)

    def cycles(self, fibre: int) -> Cycles:
        """Return the cycles of a fibre, 0 ... 35, without ranges below the error of the run."""
        whole_number = isinstance(fibre, int | np.integer) and not isinstance(fibre, bool)
        if not (whole_number and 0 <= fibre < FIBRES):
            raise InputError(f"pin_stress: '{self.name}' has no fibre {fibre!r}; give 0 ... {FIBRES - 1}")
        return self._cycles_of(self.fibres[:, [fibre]])[0]

    def _cycles_of(self, stresses: np.ndarray) -> list[Cycles]:
        """Return the cycles of each column of stresses (samples, k), without ranges below the error of the run."""
        least = self.rtol * 2.0 * float(self.bending.max())
        return [rainflow(column).at_least(least) for column in stresses.T]

    def life(self, life: Life, *, strength: float | None = None) -> PinLife:
        """Return the damage of all fibres by `miner`, with its arguments: ``life`` and ``strength`` as there."""
        damage = np.array([miner(cycles, life, strength=strength) for cycles in self._cycles_of(self.fibres)])
        return PinLife(damage, self.angles, float(self.t[-1] - self.t[0]), self.name)

    def __repr__(self) -> str:
        most = int(np.argmax(self.load))
        left = "not determined" if np.isnan(self.tilting) else f"{self.tilting:.4g} N m"
        return (
            f"<pin '{self.name}': {self.load[most]:.4g} N at most; bending {self.bending[most] / 1e6:.4g} MPa, "
            f"shear {self.shear[most] / 1e6:.4g} MPa, bound {self.bound[most] / 1e6:.4g} MPa; "
            f"tilting moment {left}, not in it>"
        )


def stress_of(pin: Pin, load: BearingLoad, holder: str, rtol: float) -> PinStress:
    """Return the stresses of a pin under the load of a joint in the frame of its holder."""
    sign = -1.0 if holder == "a" else 1.0  # the load is on b
    known = bool(load.unique_moment[:2].all())
    tilting = float(load.tilting.max(initial=0.0)) if known else np.nan
    return PinStress(load.t, sign * load.force[:, :2], pin, rtol, tilting, load.name)
