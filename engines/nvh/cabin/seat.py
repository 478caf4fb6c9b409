"""Vibration of the engine at the driver's seat: acceleration of the seat rail by order and speed, path by path.

A shell that moves under the mounts changes their forces. With f_b those on a shell that stands still, D what the
mounted powertrain puts against motions of the mounts' feet (`OnMounts.feet`) and H the receptance of the shell,

    f = (1 + D H)^-1 f_b,    a = -W^2 H_s f

Every component of every mount's force is a path, and the sum of the paths is what is felt.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from engines.nvh.cabin.plate import plate_shell
from engines.nvh.cabin.shell import ModalShell, beam_shell
from engines.nvh.cabin.table import SEAT_NAME, ModalTable, read_modes
from engines.nvh.mounts.mounts import Car
from engines.nvh.mounts.response import Map, OnMounts
from mbsd3d import rotation
from mbsd3d.errors import InputError
from mbsd3d.extend import matrix, reporting_linalg_errors

KINDS = BEAM, PLATE = "beam", "plate"
BEAM_FIELDS = ("mass", "roll_inertia", "length", "bending", "lateral", "torsion", "damping")


@dataclass(frozen=True)
class Cabin:
    """A car around a powertrain on mounts: ``car``, known by its shell; ``held``; ``made_of``: "beam", "plate", or a
    file with a table of modes. ValueError for a car or a shell that is not known.
    """

    car: Car
    held: OnMounts
    made_of: str = BEAM

    def __post_init__(self) -> None:
        if self.made_of not in KINDS and "." not in self.made_of:
            raise InputError(f"shell '{self.made_of}' is unknown; give {', '.join(KINDS)} or a file of modes (.csv)")
        if self.made_of in KINDS:
            self.record  # noqa: B018  # refuses a car without one

    @property
    def record(self) -> dict[str, Any]:
        """Return the shell of the car as in the data file; raise ValueError for a car without one."""
        if self.car.shell is None:
            raise InputError(
                f"car '{self.car.name}': its shell is not known; give compact or saloon, or a file of modes"
            )
        return self.car.shell

    @cached_property
    def shell(self) -> ModalShell | ModalTable:
        """Return the modes of the shell."""
        if self.made_of not in KINDS:
            return read_modes(self.made_of)
        record = self.record
        if self.made_of == BEAM:
            return beam_shell(**{name: record[name] for name in BEAM_FIELDS})
        return plate_shell(record["mass"], record["length"], record["width"], record["bending"], record["damping"])

    @cached_property
    def axes(self) -> np.ndarray:
        """Return the rotation from the axes of the engine to those of the car, for transverse engines too, shape (3,
        3).
        """
        turned = 0.0 if self.car.shell is None else self.car.shell["turned"]
        return matrix(rotation("z", turned, degrees=True))

    @cached_property
    def feet(self) -> np.ndarray:
        """Return the feet of the mounts from the centre of mass of the shell, axes of the car [m], shape (mounts,
        3)."""
        return np.array(self.record["engine"]) + np.array([m.at for m in self.held.placed]) @ self.axes.T

    @cached_property
    def at_feet(self) -> np.ndarray:
        """Return the shapes of the shell's modes at the feet of the mounts [1/sqrt(kg)], shape (r, 3 mounts)."""
        shell = self.shell
        return shell.at([m.name for m in self.held.placed]) if isinstance(shell, ModalTable) else shell.at(self.feet)

    @cached_property
    def at_seat(self) -> np.ndarray:
        """Return the shapes of the shell's modes at the seat rail [1/sqrt(kg)], shape (r, 3)."""
        shell = self.shell
        return shell.at([SEAT_NAME]) if isinstance(shell, ModalTable) else shell.at(np.array(self.record["seat"]))

    def paths(self, found: Map) -> np.ndarray:
        """Return the phasors of the seat's acceleration (last axis, car axes) by component of each mount's force (last
        but one, car axes), shape (s, n, mounts, 3, 3) [m/s^2]; order 0 gives none.
        """
        felt, count = np.zeros((*found.force.shape, 3), dtype=complex), len(self.held.placed)
        for s, rpm in enumerate(found.rpm):
            rate = 2 * np.pi * rpm / 60
            W = found.orders[1:] * rate
            turn = np.kron(np.eye(count), self.axes)
            D = turn @ self.held.feet(rate, W) @ turn.T
            blocked = (found.force[s, 1:] @ self.axes.T).reshape(W.size, -1)
            moved = np.eye(3 * count) + D @ self.shell.receptance(W, self.at_feet, self.at_feet)
            with reporting_linalg_errors("nvh: the shell on its mounts"):
                force = np.linalg.solve(moved, blocked[..., None])[..., 0]
            to_seat = -(W[:, None, None] ** 2) * self.shell.receptance(W, self.at_seat, self.at_feet)
            felt[s, 1:] = np.swapaxes(to_seat * force[:, None, :], 1, 2).reshape(W.size, count, 3, 3)
        if not np.isfinite(felt).all():
            raise InputError("nvh: the seat feels more than a computer can hold; check the units of car and engine")
        return felt

    def seat(self, found: Map) -> np.ndarray:
        """Return the phasors of the acceleration of the seat rail, axes of the car [m/s^2], shape (s, n, 3)."""
        return self.paths(found).sum(axis=(2, 3))


def known(car: Car, made_of: str) -> bool:
    """Return whether the shell of a car is known."""
    return car.shell is not None or made_of not in KINDS


def rms(felt: np.ndarray) -> np.ndarray:
    """Return the root mean square over all orders and directions of (s, n, 3) phasors, shape (s,)."""
    return np.sqrt((np.abs(felt) ** 2).sum(axis=(1, 2)) / 2)
