"""What the driver feels of the engine: acceleration of the seat rail by order and speed, path by path.

A shell that moves under the mounts changes their forces. With f_b those on a shell that stands still, D what the
mounted powertrain puts against motions of the mounts' feet (`OnMounts.feet`) and H the receptance of the shell,

    f = (1 + D H)^-1 f_b,    a = -W^2 H_s f

Every component of every mount's force is a path, and the sum of the paths is what is felt.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mbsd3d import rotation
from mbsd3d.errors import InputError
from mbsd3d.extend import matrix
from validation.nvh.cabin.shell import ModalShell, beam_shell
from validation.nvh.held.mounts import Car
from validation.nvh.held.response import Map, OnMounts


@dataclass(frozen=True)
class Cabin:
    """A car around a powertrain on mounts: ``car``, known by its shell; ``held``. ValueError if it is not known."""

    car: Car
    held: OnMounts

    def __post_init__(self) -> None:
        if self.car.shell is None:
            raise InputError(f"car '{self.car.name}': its shell is not known; give compact or saloon")

    @cached_property
    def shell(self) -> ModalShell:
        """Modes of the shell."""
        record = {key: value for key, value in self.car.shell.items() if key not in ("engine", "turned", "seat")}
        return beam_shell(**record)

    @cached_property
    def axes(self) -> np.ndarray:
        """(3, 3) from the axes of the engine to those of the car: an engine may stand across."""
        return matrix(rotation("z", self.car.shell["turned"], degrees=True))

    @cached_property
    def feet(self) -> np.ndarray:
        """(mounts, 3) from the centre of mass of the shell, axes of the car [m]."""
        return np.array(self.car.shell["engine"]) + np.array([m.at for m in self.held.placed]) @ self.axes.T

    def paths(self, found: Map) -> np.ndarray:
        """(s, n, mounts, 3, 3) phasors of the seat's acceleration (last, axes of the car) by the component of each
        mount's force (last but one, axes of the car) [m/s^2]; order 0 is none.
        """
        felt, count = np.zeros((*found.force.shape, 3), dtype=complex), len(self.held.placed)
        seat = np.array([self.car.shell["seat"]])
        for s, rpm in enumerate(found.rpm):
            rate = 2 * np.pi * rpm / 60
            W = found.orders[1:] * rate
            turn = np.kron(np.eye(count), self.axes)
            D = turn @ self.held.feet(rate, W) @ turn.T
            blocked = (found.force[s, 1:] @ self.axes.T).reshape(W.size, -1)
            moved = np.eye(3 * count) + D @ self.shell.receptance(W, self.feet, self.feet)
            force = np.linalg.solve(moved, blocked[..., None])[..., 0]
            to_seat = -(W[:, None, None] ** 2) * self.shell.receptance(W, seat, self.feet)
            felt[s, 1:] = np.swapaxes(to_seat * force[:, None, :], 1, 2).reshape(W.size, count, 3, 3)
        return felt

    def seat(self, found: Map) -> np.ndarray:
        """(s, n, 3) phasors of the acceleration of the seat rail, axes of the car [m/s^2]."""
        return self.paths(found).sum(axis=(2, 3))


def rms(felt: np.ndarray) -> np.ndarray:
    """(s,) of all orders and directions of (s, n, 3) phasors."""
    return np.sqrt((np.abs(felt) ** 2).sum(axis=(1, 2)) / 2)
