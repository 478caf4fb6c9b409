"""Study of an engine in a car at a speed; each part is computed on request."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from engines.nvh.cabin.seat import BEAM, Cabin, known
from engines.nvh.excitation import balance_shafts
from engines.nvh.excitation.loads import Source
from engines.nvh.excitation.main_bearings import Bearing, main_bearings
from engines.nvh.excitation.presets import Preset
from engines.nvh.mounts import mounts as cars
from engines.nvh.mounts.mounts import Car, Mount
from engines.nvh.mounts.powertrain import Equivalent, equivalent
from engines.nvh.mounts.response import Map, OnMounts, run_orders, whole_run
from engines.nvh.mounts.rigid_modes import RigidMode, rigid_modes, sag
from engines.nvh.mounts.roll_axis import Decoupled, decouple, roll_share
from mbsd3d import Solution
from mbsd3d.errors import InputError
from mbsd3d.extend import closing, number

MAP_SPEEDS = 60  # [1] speeds of the map, from idle to redline
AGREEMENT_SHARE_MAX = 0.01  # [1] difference of linear map and full run, over the largest order
IDLE_LOAD = 0.3  # [1] share of the inlet pressure at idle, which turns the engine and its accessories
SPEED_RATIO_MIN = 0.1  # [1] of the idle speed; a starter turns faster
SWEEP_TURN_SAMPLES = 48  # [1] samples of a turn in a sweep; orders from 40 on alias
SWEEP_COUNT_MAX = 1000  # [1] speeds of a sweep, and cycles at each
SWEEP_THREADS = 2  # [1] threads of a sweep; the compiled time loop leaves the others running
SETTLE_SECONDS = 0.5  # [s] the run starts from the state of the linear answer


@dataclass(frozen=True)
class Sweep:
    """Sweep over the speed: linear ``map`` and ``full`` (s, n, mounts, 3) motion at the same speeds, phasors of the
    forces on the car [N], from so many ``cycles``.
    """

    map: Map
    full: np.ndarray
    cycles: int

    @property
    def off(self) -> np.ndarray:
        """Return the largest difference of any mount and order, over the largest force at that speed, shape (s,)."""
        size = np.abs(self.map.force[:, 1:]).max(axis=(1, 2, 3))
        return np.abs(self.full - self.map.force)[:, 1:].max(axis=(1, 2, 3)) / size


@dataclass(frozen=True)
class Study:
    """Study of ``preset`` in ``car`` at ``rpm`` [1/min] under ``load``, a share of full load; 0 is motored, without
    gas; ``shafts``: balance shafts, one of `balance_shafts.KINDS`, or None; ``shell``: model of the car's shell, see
    `Cabin`.

    ValueError for a speed that is not positive, below a tenth of the idle speed or beyond the redline, or a load
    outside 0 ... 1.
    """

    preset: Preset
    car: Car
    rpm: float
    load: float = 1.0
    shafts: str | None = None
    shell: str = BEAM

    def __post_init__(self) -> None:
        rpm, least = number(self.rpm, "nvh: rpm", positive=True), SPEED_RATIO_MIN * self.preset.idle
        if rpm > self.preset.redline:
            most = f"redline of '{self.preset.name}'; give {self.preset.redline:g} or less"
            raise InputError(f"nvh: rpm {rpm:g} is beyond the {most}")
        if rpm < least:
            raise InputError(f"nvh: rpm {rpm:g}: '{self.preset.name}' idles at {self.preset.idle:g}; give {least:g} up")
        self.source.cycle  # noqa: B018  # refuses a load

    @cached_property
    def source(self) -> Source:
        """Return the engine as a source of vibration."""
        fitted = () if self.shafts is None else balance_shafts.fitted(self.preset, self.shafts)
        return Source(self.preset, self.load, tuple(fitted))

    @cached_property
    def body(self) -> Equivalent:
        """Return rigid body and rotor of the powertrain."""
        return equivalent(self.preset, self.source.fitted)

    @cached_property
    def placed(self) -> list[Mount]:
        """Return the mounts of the car for this powertrain."""
        return cars.mounts(self.car, self.preset, self.body.mass)

    @cached_property
    def modes(self) -> list[RigidMode]:
        """Return the modes of the powertrain at rest."""
        return rigid_modes(self.body.rigid, self.placed)

    @cached_property
    def sag(self) -> tuple[np.ndarray, np.ndarray]:
        """Return displacement [m] and rotation [rad] of the powertrain under its weight."""
        return sag(self.body.rigid, self.placed)

    @cached_property
    def decoupled(self) -> Decoupled:
        """Return the mounts moved until the powertrain rolls about its torque-roll axis."""
        return decouple(self.body.rigid, self.placed)

    @cached_property
    def roll_shares(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return (share of energy, frequency [Hz]) of the roll, as built and decoupled."""
        return roll_share(self.body.rigid, self.placed), roll_share(self.body.rigid, self.decoupled.mounts)

    @cached_property
    def on_mounts(self) -> OnMounts:
        """Return the powertrain on its mounts about the position under the mean torque."""
        return OnMounts(self.body, self.placed, self.source.mean_torque)

    @cached_property
    def map(self) -> Map:
        """Return the linear map from idle to redline."""
        return self.over(MAP_SPEEDS)

    def over(self, count: int) -> Map:
        """Return the linear map at ``count`` speeds from idle to redline."""
        return self.on_mounts.answer(self.source, np.linspace(self.preset.idle, self.preset.redline, count))

    @cached_property
    def spin(self) -> float:
        """Return the largest change of a mount's force without the spin of the crank, over the largest force [-]."""
        still = replace(self.on_mounts, gyroscopic=False).answer(self.source, self.map.rpm)
        return float(np.abs(still.force - self.map.force).max() / np.abs(self.map.force).max())

    @cached_property
    def here(self) -> Map:
        """Return the linear map at the speed of the study."""
        return self.on_mounts.answer(self.source, [self.rpm])

    @cached_property
    def run(self) -> Solution:
        """Simulate the full motion at this speed, settled, over four cycles."""
        return whole_run(self.source, self.on_mounts, self.rpm, settle=SETTLE_SECONDS)

    @cached_property
    def run_force(self) -> np.ndarray:
        """Return the phasors on the car in the full run, turned to the crank angle of the map [N], shape (n, mounts,
        3).
        """
        return run_orders(self.run, self.placed, self.preset.engine(self.rpm).rate, self.here.orders)

    @cached_property
    def differences(self) -> tuple[np.ndarray, np.ndarray]:
        """Return by order (n,) the largest force of a mount in the linear map [N] and its difference to the full
        run."""
        linear, full = self.here.force[0, 1:], self.run_force[1:]
        return np.abs(linear).max(axis=(1, 2)), np.abs(full - linear).max(axis=(1, 2))

    @property
    def difference(self) -> float:
        """Return the largest difference of full run and map in any order, over the largest order."""
        size, off = self.differences
        return float(off.max() / size.max())

    @property
    def nearest(self) -> tuple[float, float, float]:
        """Return (order of the largest difference of full run and map, frequency of the mode nearest to it [Hz], share
        of the amplitude of this mode at resonance, ``|2 z / (1 - r^2 + 2 i z r)|``).
        """
        rate, (_, off) = self.preset.engine(self.rpm).rate, self.differences
        order = float(self.here.orders[1:][off.argmax()])
        values = self.on_mounts.model(rate).poles
        values = values[values.imag > 0.0]
        w, z = np.abs(values), -values.real / np.abs(values)
        r = order * rate / w
        share = np.abs(2 * z / (1 - r**2 + 2j * z * r))
        return order, float(w[share.argmax()] / (2 * np.pi)), float(share.max())

    def sweep(self, count: int, cycles: int = 4) -> Sweep:
        """Simulate full motions at ``count`` speeds from idle to redline, each over ``cycles``, on two threads.

        ValueError for a count below 2, no cycle, or more than `SWEEP_COUNT_MAX` of either.
        """
        if not (2 <= count <= SWEEP_COUNT_MAX and 1 <= cycles <= SWEEP_COUNT_MAX):
            raise InputError(
                f"nvh: a sweep of {count} speeds, {cycles} cycles each; "
                f"give 2 ... {SWEEP_COUNT_MAX}, 1 ... {SWEEP_COUNT_MAX}"
            )
        found = self.over(count)

        def full(rpm: float) -> np.ndarray:
            run = whole_run(
                self.source, self.on_mounts, rpm, settle=SETTLE_SECONDS, kept=cycles, count=SWEEP_TURN_SAMPLES
            )
            return run_orders(run, self.placed, self.preset.engine(rpm).rate, found.orders)

        with closing(ThreadPoolExecutor(SWEEP_THREADS)) as pool:  # Ctrl-C waits for none of them
            return Sweep(found, np.array(list(pool.map(full, found.rpm))), cycles)

    @property
    def shell_known(self) -> bool:
        """Return whether the shell of the car is known."""
        return known(self.car, self.shell)

    @cached_property
    def cabin(self) -> Cabin:
        """Return the car around the powertrain; raise ValueError if its shell is not known."""
        return Cabin(self.car, self.on_mounts, self.shell)

    @property
    def idling(self) -> "Study":
        """Return the study of the same engine at idle."""
        return replace(self, rpm=self.preset.idle, load=IDLE_LOAD)

    @cached_property
    def bearings(self) -> list[Bearing]:
        """Return the main bearings at this speed and load."""
        return main_bearings(self.source, self.rpm)
