"""Load of an engine on its block over half orders of crank speed: inertia in closed form, gas by the stated cycle.

    F_k, M_k: phasors of order k/2, k = 0 ... 2 orders:   load = sum_k Re((F_k, M_k) exp(i k q / 2))

in car axes: x along the crank, z up the middle of the bores, about the middle of the crank. Inertia grows with w^2, gas
does not depend on w. The torque reacts outside of the block, at a flywheel that turns evenly: then piston and rod push
the block around the crank by the torque of inertia and gas, turned round.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from engines.balance import gas as engine_gas
from engines.balance import phasor, shafts
from engines.balance.pages.portrait import upright
from engines.balance.shafts import Shaft
from engines.nvh.excitation.combustion import CYCLE_SAMPLES, Cycle, cycle_of
from engines.nvh.excitation.presets import Preset
from mbsd3d import Signal, spectrum

ORDER_MAX = 8  # [1] highest order of crank speed
REFERENCE_RPM = 1000.0  # [1/min] speed of the computed inertia loads, which grow as its square


@dataclass(frozen=True)
class Load:
    """Phasors over half orders, car axes.

    ``orders`` (n,): 0, 1/2 ...; ``force, moment`` (n, 3) complex [N], [N m]; ``torque`` (n,): of the flywheel on the
    crank, against gas and inertia [N m].
    """

    orders: np.ndarray
    force: np.ndarray
    moment: np.ndarray
    torque: np.ndarray

    @property
    def six(self) -> np.ndarray:
        """Return forces and moments, shape (n, 6)."""
        return np.hstack([self.force, self.moment])


@dataclass(frozen=True)
class Source:
    """Engine as a source of vibration: ``preset``; ``load``: share of full load, 0 for a motored engine without gas;
    ``fitted``: balance shafts.
    """

    preset: Preset
    load: float = 1.0
    fitted: tuple[Shaft, ...] = ()

    @cached_property
    def cycle(self) -> Cycle | None:
        """Return the working cycle of the gas, None without gas."""
        return None if self.load == 0.0 else cycle_of(self.preset, self.load)

    @cached_property
    def inertia(self) -> Load:
        """Return the inertia loads at 1000 rpm."""
        engine = self.preset.engine(REFERENCE_RPM)
        h = phasor.block_load(engine, ORDER_MAX, dyno=True)
        R = upright(engine.layout)
        force, moment = np.zeros((2, 2 * ORDER_MAX + 1, 3), dtype=complex)
        force[::2], moment[::2] = h.force @ R.T, h.moment @ R.T
        for shaft in self.fitted:
            X, Y, *about = shafts.load(shaft, engine.rate)
            force[2 * shaft.order] += R @ np.array([X, Y, 0.0])
            moment[2 * shaft.order] += R @ np.array(about)
        torque = np.zeros(2 * ORDER_MAX + 1, dtype=complex)
        torque[::2] = h.torque
        return Load(np.arange(2 * ORDER_MAX + 1) / 2, force, moment, torque)

    @cached_property
    def gas_torque(self) -> np.ndarray:
        """Return the phasors of the torque of the gas on the crank [N m], shape (2 ORDER_MAX + 1,)."""
        if self.cycle is None:
            return np.zeros(2 * ORDER_MAX + 1, dtype=complex)
        engine = self.preset.engine(REFERENCE_RPM)
        angle = 4 * np.pi * np.arange(CYCLE_SAMPLES + 1) / CYCLE_SAMPLES
        seen = spectrum(angle, engine_gas.torque(engine, self.cycle.force, angle), rate=1.0)
        return np.array([seen.at(k / 2) for k in range(2 * ORDER_MAX + 1)])

    def at(self, rpm: float) -> Load:
        """Return the load at a speed [1/min]; the sign does not matter, and 0 has no inertia load."""
        share, moment = (rpm / REFERENCE_RPM) ** 2, self.inertia.moment * (rpm / REFERENCE_RPM) ** 2
        moment[:, 0] -= self.gas_torque
        return Load(
            self.inertia.orders, self.inertia.force * share, moment, self.inertia.torque * share - self.gas_torque
        )

    def over_the_cycle(self, rpm: float, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return (torque of the gas, of the inertia) on a crank at constant speed, at its angles [rad], all orders [N
        m].
        """
        engine = self.preset.engine(rpm)
        waves = phasor.block_load(engine, 3 * ORDER_MAX, dyno=True).torque
        inertia = -np.real(np.exp(1j * np.outer(angle, np.arange(waves.size))) @ waves)
        if self.cycle is None:
            return np.zeros_like(angle), inertia
        return engine_gas.torque(engine, self.cycle.force, angle), inertia

    @property
    def mean_torque(self) -> float:
        """Return the indicated mean torque at the crank [N m]."""
        return float(self.gas_torque[0].real)


def along(direction: np.ndarray, push: Signal) -> tuple[Signal | float, ...]:
    """Return the components of a force along a unit vector, as a number where there is none so that it costs no
    table."""
    return tuple(float(x) * push if x else 0.0 for x in direction)
