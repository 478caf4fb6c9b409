"""Rough roads by ISO 8608, as sums of waves with seeded phases.

The displacement spectrum of a class is ``G(n) = G_0 (n / n_0)^-2`` over the spatial frequency n, n_0 = 0.1 1/m, with
G_0 = 16e-6 m^3 for class A and four times more from class to class. A track of length L is

    z(x) = sum_k sqrt(2 G(n_k) / L) cos(2 pi n_k x + phase_k),     n_k = k / L

and repeats itself. Left and right track have equal spectra; their waves share the part ``exp(-n / coherent)`` (assumed)
of their amplitude, so that long waves lift both sides and short ones each side alone.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mbsd3d.errors import InputError
from mbsd3d.extend import number

CLASSES = "ABCDEFGH"
N0, G0 = 0.1, 16e-6  # 1/m, m^3
SPATIAL_FREQUENCY_MAX, SPATIAL_FREQUENCY_MIN = 2.83, 0.011  # 1/m: range of the standard
COHERENCE_FREQUENCY = 0.3  # [1/m] up to which left and right track are coherent


@dataclass(frozen=True)
class Road:
    """Rough road: ``kind``: "A" (smooth) to "H"; ``length``: after which it repeats itself [m]; ``seed``.

    ValueError for an unknown class, or a length that holds no wave of the standard.

    >>> road = Road("C")
    >>> bool(abs(road.height(12.3, 0) - road.height(12.3 + road.length, 0)) < 1e-12)
    True
    """

    kind: str = "C"
    length: float = 200.0
    seed: int = 0

    def __post_init__(self) -> None:
        if self.kind not in CLASSES or len(self.kind) != 1:
            raise InputError(f"road of class {self.kind!r}; give one of {', '.join(CLASSES)}")
        if number(self.length, "road: length", positive=True) < 2.0 / SPATIAL_FREQUENCY_MIN:
            raise InputError(
                f"road: length {self.length:g} m is too short for its waves; "
                f"give {2 / SPATIAL_FREQUENCY_MIN:.0f} m or more"
            )

    @property
    def title(self) -> str:
        """Return the road in words."""
        return f"a road of class {self.kind}"

    @cached_property
    def waves(self) -> np.ndarray:
        """Return the spatial frequencies n_k within the range of the standard [1/m], shape (k,)."""
        n = np.arange(1, int(SPATIAL_FREQUENCY_MAX * self.length) + 1) / self.length
        return n[n >= SPATIAL_FREQUENCY_MIN]

    def spectrum(self, n: np.ndarray) -> np.ndarray:
        """Return the spectral density G at spatial frequencies [m^3]."""
        return G0 * 4.0 ** CLASSES.index(self.kind) * (np.asarray(n) / N0) ** -2

    @cached_property
    def amplitudes(self) -> np.ndarray:
        """Return the complex amplitudes of z = Re sum c_k exp(2 pi i n_k x) of left and right track [m], shape (2,
        k)."""
        phases = np.exp(2j * np.pi * np.random.default_rng(self.seed).random((2, self.waves.size)))
        size, shared = np.sqrt(2 * self.spectrum(self.waves) / self.length), np.exp(-self.waves / COHERENCE_FREQUENCY)
        left, other = phases
        # of two waves with unit size and any phases the sum is brought back to unit size
        right = shared * left + np.sqrt(1 - shared**2) * other
        return size * np.stack([left, right / np.abs(right)])

    def height(self, x: np.ndarray, side: int) -> np.ndarray:
        """Return z of the left (0) or right (1) track at places along the road [m]."""
        return summed(self.waves, self.amplitudes[side], x)


def summed(waves: np.ndarray, amplitudes: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return Re sum c_k exp(2 pi i n_k x)."""
    return (np.exp(2j * np.pi * np.multiply.outer(np.asarray(x, dtype=float), waves)) @ amplitudes).real
