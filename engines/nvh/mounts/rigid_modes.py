"""Rigid-body modes of a powertrain on its mounts: six frequencies, shapes, and shares of kinetic energy.

With phi the shape of a mode about the centre of mass (three displacements, three rotations, real: dampers left out) its
energy is shared among the directions as ``phi_i (M phi)_i / phi'M phi``; the shares add up to 1, and one near 1 says
that the mode is decoupled.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from engines.nvh.mounts.mounts import Mount, bushings
from engines.nvh.mounts.powertrain import Equivalent
from mbsd3d import Body, System, linearize
from mbsd3d.errors import InputError

DIRECTIONS = ("x", "y", "z", "about x", "about y", "about z")


@dataclass(frozen=True)
class RigidMode:
    """Rigid-body mode: ``frequency`` [Hz], ``shape`` (6,) about the centre of mass [m], [rad]; ``shares`` (6,) of
    kinetic energy.
    """

    frequency: float
    shape: np.ndarray
    shares: np.ndarray

    @property
    def main(self) -> str:
        """Return the direction with most of the energy."""
        return DIRECTIONS[int(np.argmax(self.shares))]


def mass_matrix(body: Body | Equivalent) -> np.ndarray:
    """Return the mass matrix about the centre of mass, car axes, shape (6, 6)."""
    M = np.zeros((6, 6))
    M[:3, :3], M[3:, 3:] = body.mass * np.eye(3), body.inertia
    return M


def rigid_modes(body: Body, placed: Sequence[Mount]) -> list[RigidMode]:
    """Compute six modes of a body at rest in its reference pose, without dampers, sorted by frequency.

    ValueError if mounts leave a motion free.
    """
    bare = [replace(mount, damping=(0.0, 0.0, 0.0)) for mount in placed]
    small = linearize(System([body], forces=bushings(bare, body), gravity=(0, 0, 0)))
    M, found = mass_matrix(body), []
    free = int((small.eigenvalues == 0.0).sum()) // 2
    if free:
        raise InputError(f"powertrain: {len(placed)} mounts leave {free} motions free; give three that are not in line")
    for mode in small.modes:
        shape = np.concatenate([mode.translation[0], mode.rotation[0]])
        shape = (shape * np.exp(-1j * np.angle(shape[np.argmax(np.abs(shape))]))).real
        energy = shape * (M @ shape)
        found.append(RigidMode(float(mode.frequency), shape, energy / energy.sum()))
    return found


def sag(body: Body, placed: Sequence[Mount]) -> tuple[np.ndarray, np.ndarray]:
    """Return (displacement of the centre of mass [m], rotation vector [rad]) of the powertrain under its weight."""
    system = System([body], forces=bushings(placed, body))
    q = system.equilibrium().state.q
    moved = np.array(q[:3]) - body.position
    sign = 1.0 if q[3] >= 0 else -1.0
    angle = 2.0 * np.arctan2(np.linalg.norm(q[4:7]), abs(q[3]))
    turn = sign * np.array(q[4:7]) * (angle / max(np.linalg.norm(q[4:7]), 1e-300))
    return moved + np.cross(turn, body.com), turn
