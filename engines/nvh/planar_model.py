"""Planar model of an engine in its car: sway, bounce and roll in the plane across the crank, and a front view.

The planar powertrain has mass, inertia about x, mounts and loads of the real one, all pushed into the plane x = 0; its
shell moves in the same plane. With heads T_j = [1 0 -z; 0 1 y] of the mounts

    (K + i W C - W^2 M) q = F,   f_j = (k_j + i W c_j) T_j q,   D = Z - Z Y Z,   f = (1 + D H)^-1 f_b

as in space (`OnMounts`, `Cabin`), with three degrees of freedom instead of six. None of it uses the solver in space.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag, eigh, expm
from scipy.optimize import root

from engines.nvh.cabin.seat import Cabin
from engines.nvh.cabin.table import ModalTable
from engines.nvh.control.cancel import Cancel, Path
from engines.nvh.mounts.response import OnMounts
from engines.nvh.road.guide import Guide
from mbsd3d.errors import InputError

ACROSS_COORDINATES = (1, 2, 3)  # y, z, about x: the plane across the crank
IN_PLANE = slice(1, 3)  # y, z


@dataclass(frozen=True)
class Flat:
    """Powertrain of ``held`` in the plane across its crank, about the middle of the crank."""

    held: OnMounts

    @property
    def mass(self) -> np.ndarray:
        """Return the mass matrix M; the rotor at constant speed has no share; shape (3, 3)."""
        return self.held.mass[np.ix_(ACROSS_COORDINATES, ACROSS_COORDINATES)]

    @property
    def heads(self) -> np.ndarray:
        """Return the matrix T from the planar motion to the motion of the mounts, shape (2 mounts, 3)."""
        return np.vstack([[[1.0, 0.0, -mount.at[2]], [0.0, 1.0, mount.at[1]]] for mount in self.held.placed])

    @property
    def rates(self) -> tuple[np.ndarray, np.ndarray]:
        """Return stiffness and damping of the mounts alone, (2 mounts, 2 mounts) each."""
        parts = ("stiffness", "dampers")
        return tuple(
            block_diag(*[getattr(mount, part)[IN_PLANE, IN_PLANE] for mount in self.held.placed]) for part in parts
        )

    def modes(self) -> np.ndarray:
        """Return the frequencies with the rotor locked and without dampers [Hz], shape (3,)."""
        T, M = self.heads, self.mass + np.diag([0.0, 0.0, self.held.body.rotor])
        return np.sqrt(eigh(T.T @ self.rates[0] @ T, M, eigvals_only=True)) / (2 * np.pi)

    def seat(self, cabin: Cabin, rpm: np.ndarray, orders: np.ndarray, load: np.ndarray) -> np.ndarray:
        """Return the phasors of the acceleration of the seat rail in the plane, for loads (s, n, 6) [m/s^2], shape (s,
        n, 2).
        """
        (k, c), T, M = self.rates, self.heads, self.mass
        (feet, seat), found = flat_shapes(cabin), np.zeros((rpm.size, orders.size, 2), dtype=complex)
        W = 2 * np.pi * rpm[:, None] / 60 * orders[1:]
        for s, w in enumerate(W):
            w3 = w[:, None, None]
            Z = k + 1j * w3 * c
            stiff = T.T @ Z @ T - w3**2 * M
            q = np.linalg.solve(stiff, load[s, 1:, ACROSS_COORDINATES].T[..., None])
            D = Z - Z @ T @ np.linalg.solve(stiff, T.T @ Z)
            moved = np.eye(k.shape[0]) + D @ cabin.shell.receptance(w, feet, feet)
            force = np.linalg.solve(moved, Z @ T @ q)
            found[s, 1:] = (-(w3**2) * cabin.shell.receptance(w, seat, feet) @ force)[..., 0]
        return found

    def path(self, cancel: Cancel) -> Path:
        """Return the path from the actuator of ``cancel`` to the force on the car, held over a sample."""
        (k, c), T, M = self.rates, self.heads, self.mass
        head = T[2 * cancel.which + 1]
        both = np.zeros((7, 7))
        both[:3, 3:6] = np.eye(3)
        both[3:6, :3], both[3:6, 3:6] = (-np.linalg.solve(M, T.T @ part @ T) for part in (k, c))
        both[3:6, 6] = np.linalg.solve(M, head)
        sampled = expm(both / cancel.rate)
        mount = cancel.mount
        C = np.concatenate([mount.rates[2] * head, mount.damping[2] * head])
        return Path(sampled[:6, :6], sampled[:6, 6], C, -1.0, 1 / cancel.rate)


def flat_shapes(cabin: Cabin) -> tuple[np.ndarray, np.ndarray]:
    """Return the mode shapes of the shell at feet (r, 2 mounts) and seat (r, 2), in the plane across the crank through
    its centre of mass.
    """
    if isinstance(cabin.shell, ModalTable):
        raise InputError("plane: a table of modes knows its places only; give a shell of a beam or a plate")
    axes, places = cabin.axes, np.vstack([cabin.feet, cabin.record["seat"]])
    normal = axes[:, 0]
    shapes = cabin.shell.at(places - np.outer(places @ normal, normal)).reshape(-1, len(places), 3) @ axes[:, IN_PLANE]
    return shapes[:, :-1].reshape(len(shapes), -1), shapes[:, -1]


def front_view(guide: Guide, heights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (camber [rad], motion ratio) of a double wishbone in the front view, over heights of the wheel [m].

    Each arm turns about the point where its axis meets the plane of the wheel's centre; the strut is projected.
    """
    links, centre = guide.links, np.asarray(guide.centre)
    arms = []
    for name in ("lower", "upper"):
        (front, outer), (rear, _) = (np.array(links[f"{name} arm, {end}"]) for end in ("front", "rear"))
        share = (centre[0] - front[0]) / (rear[0] - front[0])
        arms.append(((front + share * (rear - front))[1:], outer[1:]))
    inner, strut = np.array(guide.strut)[:, 1:]
    lengths = [np.hypot(*(b - a)) for a, b in arms]

    def moved(x: np.ndarray, point: np.ndarray) -> np.ndarray:
        """Return the position of a point of the upright [m]: x = (across, up, turn about x) of the wheel's centre."""
        turn = np.array([[np.cos(x[2]), -np.sin(x[2])], [np.sin(x[2]), np.cos(x[2])]])
        return centre[1:] + x[:2] + turn @ (point - centre[1:])

    def errors(ahead: np.ndarray, z: float) -> list[float]:
        x = ahead - 1.0  # away from 0, where relative steps vanish
        return [*(np.hypot(*(moved(x, b) - a)) - n for (a, b), n in zip(arms, lengths, strict=True)), x[1] - z]

    x, found = np.zeros(3), []
    for z in heights:
        x = root(errors, x + 1.0, args=(z,), tol=1e-12).x - 1.0
        found.append((-x[2], np.hypot(*(moved(x, strut) - inner))))
    camber, length = np.array(found).T
    return camber, np.gradient(length, heights, edge_order=2)
