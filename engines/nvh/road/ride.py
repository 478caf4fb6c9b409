"""Car on a rough road: vibration at the seat, wave by wave and in the full motion.

A wave n of the road reaches a wheel x ahead of the centre of mass as ``c exp(2 pi i n (v t + x))`` and pushes it by
``(k + i w c_t)`` of its height, w = 2 pi n v. By the small motions H of the car (`mbsd3d.state_space`) the acceleration
at the seat is

    a = -w^2 s' H(w) f,     a_w^2 = sum |W_k a|^2 / 2

for the very road that the full motion runs over, so that both can be compared wave by wave. W_k weighs vertical
vibration of seated people by ISO 2631-1:

    W_k(s) = high pass (0.4 Hz) * low pass (100 Hz) * (1 + s / w3) / (1 + s / (Q4 w4) + s^2 / w4^2)
             * (w5 / w6)^2 (1 + s / (Q5 w5) + s^2 / w5^2) / (1 + s / (Q6 w6) + s^2 / w6^2)
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.signal import TransferFunction

from engines.nvh.road.measured import Measured
from engines.nvh.road.profile import SPATIAL_FREQUENCY_MAX, Road
from engines.nvh.road.vehicle import Corner, Vehicle
from mbsd3d import Solution, System, Table, simulate
from mbsd3d.errors import InputError
from mbsd3d.extend import number

SAMPLES_PER_WAVE = 16  # [1] samples of the shortest wave of the road
SETTLE_SECONDS = 6.0  # [s] heave of 1.2 Hz with a fifth of critical damping has decayed to 1e-4
SPEED_RANGE = 0.5, 150.0  # [m/s] speeds of a car
RTOL = 1e-8
LEVEL_HEIGHT_MAX = 1e-9  # [m] a road with smaller heights is level
F3, F4, Q4 = 12.5, 12.5, 0.63
F5, Q5, F6, Q6 = 2.37, 0.91, 3.35, 0.91
LOW_CORNER, HIGH_CORNER = 0.4, 100.0
REACTIONS = ((0.315, "not uncomfortable"), (0.63, "a little uncomfortable"), (1.0, "fairly uncomfortable"),
         (1.6, "uncomfortable"), (2.5, "very uncomfortable"), (np.inf, "extremely uncomfortable"))  # fmt: skip


@dataclass(frozen=True)
class Ride:
    """Ride of ``vehicle`` on ``road`` at ``speed`` [m/s]; ValueError for a speed outside the range of cars, or a level
    road.
    """

    vehicle: Vehicle
    road: Road | Measured
    speed: float

    def __post_init__(self) -> None:
        speed = number(self.speed, "ride: speed", positive=True)
        if not SPEED_RANGE[0] <= speed <= SPEED_RANGE[1]:
            raise InputError(
                f"ride: speed {speed:g} m/s; give {SPEED_RANGE[0]:g} ... {SPEED_RANGE[1]:g} m/s, as cars go"
            )
        if not np.abs(self.road.amplitudes).max(initial=0.0) > LEVEL_HEIGHT_MAX:
            raise InputError(
                f"road '{self.road.title}' is level: "
                f"no wave of {1 / SPATIAL_FREQUENCY_MAX:.2g} m or more; give uneven heights"
            )

    @cached_property
    def rates(self) -> np.ndarray:
        """Return the rates w of the waves [rad/s], shape (k,)."""
        return 2 * np.pi * self.road.waves * self.speed

    def under(self, corner: Corner) -> np.ndarray:
        """Return the phasors of the road under a wheel [m]; a half car has the mean of both tracks; shape (k,)."""
        c = self.road.amplitudes
        track = c.mean(axis=0) if self.vehicle.kind == "half" else c[corner.side]
        return track * np.exp(2j * np.pi * self.road.waves * corner.x)

    def pushed(self, corner: Corner) -> np.ndarray:
        """Return the phasors of the force of the road on a wheel through its tyre [N], shape (k,)."""
        return (corner.tyre + 1j * self.rates * corner.tyre_damping) * self.under(corner)

    @cached_property
    def heights(self) -> np.ndarray:
        """Return the phasors of the heights of the vehicle's points [m], shape (k, outputs)."""
        push = np.transpose([self.pushed(corner) for corner in self.vehicle.corners])
        return (self.vehicle.small_motions.frequency_response(self.rates).H @ push[..., None])[..., 0]

    @cached_property
    def seat(self) -> np.ndarray:
        """Return the phasors of the acceleration at the seat [m/s^2], shape (k,)."""
        return -(self.rates**2) * (self.heights @ self.vehicle.at_seat)

    @property
    def weighted(self) -> float:
        """Return the root mean square of the weighted acceleration at the seat [m/s^2]."""
        return rms(weight(self.rates / (2 * np.pi)) * self.seat)

    @property
    def verdict(self) -> str:
        """Return the likely reaction of people in public transport."""
        return verdict(self.weighted)

    @property
    def count(self) -> int:
        """Return the number of samples over one length of the road."""
        return int(np.ceil(SAMPLES_PER_WAVE * self.road.waves[-1] * self.road.length))

    @cached_property
    def times(self) -> np.ndarray:
        """Return the sample times of the full motion [s], which settles before it goes over one length of the road."""
        period = self.road.length / self.speed
        before = int(np.ceil(SETTLE_SECONDS / period * self.count))
        return period / self.count * np.arange(before + self.count + 1)

    @cached_property
    def system(self) -> System:
        """Return the car with the forces of the road on its wheels."""
        turns = np.arange(self.times.size) % self.count  # the road repeats itself
        loads = [
            (corner.name, (0, 0, Table(self.times, self.over(self.pushed(corner), self.count)[turns])), None)
            for corner in self.vehicle.corners
        ]
        return self.vehicle.system(loads)

    @cached_property
    def run(self) -> Solution:
        """Simulate the full motion over one length of the road, settled."""
        return simulate(self.system, float(self.times[-1]), output=self.times[-self.count - 1 :], rtol=RTOL)

    def over(self, phasors: np.ndarray, count: int) -> np.ndarray:
        """Return the values over a length of the road of the sum of its waves, shape (count,)."""
        lines = np.zeros(count // 2 + 1, dtype=complex)
        lines[self.numbers] = phasors * count / 2
        return np.fft.irfft(lines, count)

    def sampled(self, phasors: np.ndarray) -> np.ndarray:
        """Return the values of a sum of the road's waves at the times of the full motion, shape (samples,)."""
        turned = phasors * np.exp(1j * self.rates * self.run.t[0])
        return np.resize(self.over(turned, self.run.t.size - 1), self.run.t.size)

    def tyre_load(self, corner: Corner) -> np.ndarray:
        """Return the force of the road on a wheel in the full motion [N], below 0 where a tyre would have to pull,
        shape (samples,).
        """
        tyre = self.run.force(f"tyre of {corner.name}")
        return tyre.force[:, 2] + self.sampled(self.pushed(corner)) + corner.borne

    @property
    def numbers(self) -> np.ndarray:
        """Return the number of each wave on the length of the road, shape (k,)."""
        return np.round(self.road.waves * self.road.length).astype(int)

    @cached_property
    def run_seat(self) -> np.ndarray:
        """Return the phasors of the acceleration at the seat in the full motion [m/s^2], shape (k,)."""
        run, (x, y) = self.run, self.vehicle.seat
        up = run.acceleration("body")[:, 2] + run.alpha("body") @ (y, -x, 0.0)
        count = up.size - 1
        lines = np.fft.rfft(up[:-1]) * 2 / count
        return lines[self.numbers] * np.exp(-1j * self.rates * run.t[0])

    @property
    def difference(self) -> float:
        """Return the root mean square of the difference of full motion and small motions, over that of the acceleration
        [-].
        """
        return rms(self.run_seat - self.seat) / rms(self.seat)


def rms(phasors: np.ndarray) -> float:
    """Return the root mean square of a sum of waves of different frequencies."""
    return float(np.sqrt(np.sum(np.abs(phasors) ** 2) / 2))


def quadratic(frequency: float, Q: float) -> np.ndarray:
    """Return the coefficients of ``1 + s / (Q w) + s^2 / w^2``, highest power first."""
    w = 2 * np.pi * frequency
    return np.array([1 / w**2, 1 / (Q * w), 1.0])


def weighting() -> TransferFunction:
    """Return W_k as a transfer function of s."""
    above = np.array([1 / (2 * np.pi * LOW_CORNER) ** 2, 0.0, 0.0])
    numerator = np.polymul(above, [1 / (2 * np.pi * F3), 1.0])
    numerator = (F5 / F6) ** 2 * np.polymul(numerator, quadratic(F5, Q5))
    denominator = np.array([1.0])
    for part in (
        quadratic(LOW_CORNER, np.sqrt(0.5)),
        quadratic(HIGH_CORNER, np.sqrt(0.5)),
        quadratic(F4, Q4),
        quadratic(F6, Q6),
    ):
        denominator = np.polymul(denominator, part)
    return TransferFunction(numerator, denominator)


def weight(frequency: np.ndarray) -> np.ndarray:
    """Return W_k at frequencies [Hz], complex."""
    H, s = weighting(), 2j * np.pi * np.asarray(frequency)
    return np.polyval(H.num, s) / np.polyval(H.den, s)


def verdict(acceleration: float) -> str:
    """Return the likely reaction of people in public transport to a weighted acceleration [m/s^2] (annex C).

    The ranges of the standard overlap; the milder word is taken up to the end of its range.
    """
    return next(word for limit, word in REACTIONS if acceleration <= limit)
