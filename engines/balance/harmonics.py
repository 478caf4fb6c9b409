"""Harmonics of the load on a block, the common result of all three methods, and their direction of rotation.

A phasor c_n means ``Re(c_n exp(i n q))``. A load in the plane of x and y is the sum of a vector that turns with
the crank and one that turns against it, n times as fast:

    X_n, Y_n phasors of its components:   forward (X + i Y) / 2, backward (X - i Y) / 2
    x + i y = forward exp(i n q) + conj(backward) exp(-i n q)

Its tip draws an ellipse of half axes | |forward| + |backward| | and | |forward| - |backward| |.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Harmonics:
    """Orders 0, 1, 2 ... of crank speed of the load on the block about the origin, world axes."""

    force: np.ndarray  # (orders + 1, 3) complex [N]
    moment: np.ndarray  # (orders + 1, 3) complex [N m]; x and y are the couples, z is the torque reaction
    torque: np.ndarray  # (orders + 1,) complex, of the driver on the crank [N m]

    @property
    def forward(self) -> np.ndarray:
        """Return the forces [N] and couples [N m] that turn with the crank, complex, shape (orders + 1, 2)."""
        return turning(self.force, self.moment, 1)

    @property
    def backward(self) -> np.ndarray:
        """Return the forces [N] and couples [N m] that turn against the crank, complex, shape (orders + 1, 2)."""
        return turning(self.force, self.moment, -1)

    def difference(self, other: "Harmonics", length: float) -> float:
        """Return the largest difference of any component and order [N]; moments are divided by ``length`` [m]."""
        parts = (self.force - other.force, (self.moment - other.moment) / length, (self.torque - other.torque) / length)
        return max(float(np.abs(part).max()) for part in parts)


def turning(force: np.ndarray, moment: np.ndarray, direction: int) -> np.ndarray:
    """Return (X + i Y) / 2 of force [N] and moment [N m], or (X - i Y) / 2 for direction -1."""
    return np.stack([(part[:, 0] + 1j * direction * part[:, 1]) / 2 for part in (force, moment)], axis=-1)


def half_axes(forward: np.ndarray, backward: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the long and the short half axis of the ellipse of a harmonic [N or N m]."""
    a, b = np.abs(forward), np.abs(backward)
    return a + b, np.abs(a - b)
