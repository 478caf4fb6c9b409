"""Gas in the cylinder of a four-stroke engine: pressure over the cycle by a stated heat release.

One zone of ideal gas with a constant gamma from the closing of the inlet at bottom dead centre to the opening of the
outlet. With psi the crank angle after firing top dead centre, ``d(p V^gamma) = (gamma - 1) V^(gamma - 1) dQ`` gives

    p V^gamma = p_1 V_1^gamma + (gamma - 1) Q int V^(gamma - 1) dx,   x = 1 - exp(-a ((psi - start) / duration)^(m + 1))

the heat release of Wiebe, a = ln 1000, with ``Q = heat rho_1 V_1 / (1 + air_fuel)`` less what the walls take. Pressure
blends (cosine) to the outlet's until bottom dead centre and to the inlet's around gas exchange.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.integrate import cumulative_simpson
from scipy.interpolate import CubicSpline

from engines.balance.gas import CYCLE_ANGLE
from engines.nvh.excitation.presets import Preset
from mbsd3d.errors import InputError
from mbsd3d.extend import number

CYCLE_SAMPLES = 1440  # [1] samples of a cycle, half a degree apart
FUEL_HEAT, AIR_FUEL_RATIO, GAS_CONSTANT, CRANKCASE_PRESSURE = (
    43e6,
    14.7,
    287.0,
    101325.0,
)  # petrol [J/kg], [-]; air [J/(kg K)]; [Pa]
LOAD_MIN = 0.1  # [1] of full load; an idling engine takes about 0.3
EXHAUST_BLEND_ANGLE = np.radians(20.0)  # [rad] half the angle over which pressure goes from outlet to inlet


@dataclass(frozen=True)
class Cycle:
    """Working cycle of a cylinder.

    ``bore, radius, rod_length`` [m]; ``compression`` > 1; ``inlet, outlet``: pressures [Pa]; ``temperature``: at the
    start of compression [K]; ``gamma``; ``start, duration``: of burning, from firing dead centre [degrees]; ``form``:
    Wiebe's m; ``used``: share of the heat that the walls leave; ``opening``: of the outlet [degrees], up to 180.
    ValueError for numbers that no cylinder has.
    """

    bore: float
    radius: float
    rod_length: float
    compression: float
    inlet: float = 0.95e5
    outlet: float = 1.1e5
    temperature: float = 340.0
    gamma: float = 1.3
    start: float = -20.0
    duration: float = 60.0
    form: float = 2.0
    used: float = 0.8
    opening: float = 135.0

    def __post_init__(self) -> None:
        for name in ("bore", "radius", "rod_length", "inlet", "outlet", "temperature", "duration"):
            number(getattr(self, name), f"cycle: {name}", positive=True)
        for name, low in (("compression", 1.0), ("gamma", 1.0), ("rod_length", self.radius)):
            if not number(getattr(self, name), f"cycle: {name}") > low:
                raise InputError(f"cycle: {name} {getattr(self, name):g} is not above {low:g}; give a larger one")
        if not self.start + self.duration < self.opening <= 180.0 or self.start < -180.0:
            raise InputError(
                f"cycle: burning from {self.start:g} to {self.start + self.duration:g} degrees, outlet at "
                f"{self.opening:g}; burning must end before the outlet opens, at 180 or before"
            )

    @property
    def area(self) -> float:
        """Return the area of the piston [m^2]."""
        return np.pi / 4 * self.bore**2

    @property
    def swept(self) -> float:
        """Return the volume that one piston sweeps [m^3]."""
        return 2 * self.radius * self.area

    @property
    def heat(self) -> float:
        """Return the heat Q that the gas keeps of a charge [J]."""
        volume = self.swept * self.compression / (self.compression - 1)
        return self.used * FUEL_HEAT * self.inlet * volume / (GAS_CONSTANT * self.temperature) / (1 + AIR_FUEL_RATIO)

    def volume(self, psi: np.ndarray) -> np.ndarray:
        """Return the volume V at crank angles [rad] [m^3]."""
        R, L = self.radius, self.rod_length
        fall = R + L - R * np.cos(psi) - np.sqrt(L**2 - (R * np.sin(psi)) ** 2)
        return self.swept / (self.compression - 1) + self.area * fall

    def burnt(self, psi: np.ndarray) -> np.ndarray:
        """Return the burnt fraction x, from 0 to 1, at crank angles [rad]."""
        share = np.clip((np.degrees(psi) - self.start) / self.duration, 0.0, None)
        return 1 - np.exp(-np.log(1000.0) * share ** (self.form + 1))

    @cached_property
    def samples(self) -> tuple[np.ndarray, np.ndarray]:
        """Return (psi, p) from -pi to 3 pi, ``CYCLE_SAMPLES`` + 1 each, first and last the same [rad], [Pa]."""
        psi = -np.pi + CYCLE_ANGLE * np.arange(CYCLE_SAMPLES + 1) / CYCLE_SAMPLES
        closed = psi <= np.pi
        V, g = self.volume(psi[closed]), self.gamma
        fine = np.linspace(-np.pi, np.pi, 16 * CYCLE_SAMPLES + 1)  # x has a corner at its start
        rate = np.gradient(self.burnt(fine), fine, edge_order=2)
        added = cumulative_simpson(self.volume(fine) ** (g - 1) * rate, x=fine, initial=0.0)
        stored = self.inlet * V[0] ** g + (g - 1) * self.heat * np.interp(psi[closed], fine, added)
        p = np.full(psi.size, self.outlet)
        p[closed] = stored / V**g
        p[closed] = blend(psi[closed], np.radians(self.opening), np.pi, p[closed], self.outlet)
        p[~closed] = blend(
            psi[~closed], 2 * np.pi - EXHAUST_BLEND_ANGLE, 2 * np.pi + EXHAUST_BLEND_ANGLE, p[~closed], self.inlet
        )
        p[-1] = p[0]
        return psi, p

    @cached_property
    def spline(self) -> CubicSpline:
        """Return the pressure p over psi as a periodic spline."""
        return CubicSpline(*self.samples, bc_type="periodic")

    def force(self, psi: np.ndarray) -> np.ndarray:
        """Return the force on the piston towards the crank, against the pressure of the crankcase [N]; psi [rad], any
        array.
        """
        return self.area * (self.spline(psi) - CRANKCASE_PRESSURE)

    @cached_property
    def work(self) -> float:
        """Return the indicated work of a cycle, the integral of p dV [J]."""
        psi = np.linspace(-np.pi, 3 * np.pi, 8 * CYCLE_SAMPLES + 1)
        V = CubicSpline(psi, self.volume(psi))
        return float(np.trapezoid(self.spline(psi) * V(psi, 1), psi))

    @property
    def mean_pressure(self) -> float:
        """Return the indicated mean effective pressure [Pa]."""
        return self.work / self.swept


def blend(psi: np.ndarray, start: float, end: float, before: np.ndarray, after: float) -> np.ndarray:
    """Return the pressure that goes from one value to another along half a cosine [Pa]."""
    if end <= start:
        return before
    share = 0.5 - 0.5 * np.cos(np.pi * np.clip((psi - start) / (end - start), 0.0, 1.0))
    return before + share * (after - before)


def cycle_of(preset: Preset, load: float = 1.0) -> Cycle:
    """Return the cycle of an engine under a load from `LOAD_MIN` to 1 (full): inlet pressure as share of 0.95 bar.

    ValueError for another load.
    """
    if not LOAD_MIN <= number(load, "gas: load") <= 1.0:
        raise InputError(
            f"gas: load {load:g}; give a share of full load from {LOAD_MIN:g} to 1, or 0: motored, without gas"
        )
    return Cycle(preset.bore, preset.stroke / 2, preset.rod_length, preset.compression, inlet=0.95e5 * load)
