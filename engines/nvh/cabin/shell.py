"""Body shell of a car as modes: frequencies, dampings, and shapes where forces act or motion is measured.

With the shapes phi_r of unit modal mass the shell moves at rate w under forces f by

    u = H(w) f,   H = sum_r phi_r phi_r' / (w_r^2 - w^2 + 2 i z w_r w)

Modes come from a table (`table.read_modes`), a plate (`plate.plate_shell`) or a beam: `beam_shell` makes those of a
uniform beam with free ends by finite elements: bending up and sideways (cubic), torsion and surge, the six motions as a
rigid body among them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.linalg import eigh

from mbsd3d.errors import InputError
from mbsd3d.extend import number

ELEMENT_COUNT = 40  # [1] beam elements of a shell
ELASTIC_MODES = 4  # [1] elastic modes of each kind; the highest are beyond 150 Hz
Shape = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Modes:
    """``rates`` (r,) w_r >= 0 [rad/s]; ``damping`` (r,) z >= 0 [-]; ``shapes`` (r) of unit modal mass [1/sqrt(kg)].

    ValueError for numbers of modes that differ, or a rate or damping that is negative.
    """

    rates: np.ndarray
    damping: np.ndarray
    shapes: Sequence[Any]

    def __post_init__(self) -> None:
        if not len(self.rates) == len(self.damping) == len(self.shapes):
            counts = len(self.rates), len(self.damping), len(self.shapes)
            raise InputError(f"shell: {counts[0]} rates, {counts[1]} dampings, {counts[2]} shapes; give one per mode")
        for k, (w, z) in enumerate(zip(self.rates, self.damping, strict=True), start=1):
            number(w, f"shell: rate of mode {k}", minimum=0.0)
            number(z, f"shell: damping of mode {k}", minimum=0.0)

    def receptance(self, rates: np.ndarray, felt: np.ndarray, pushed: np.ndarray) -> np.ndarray:
        """Return the receptance H [m/N] at rates (n,) > 0, from shapes at the outputs (r, 3 p) and at the forces (r, 3
        k), shape (n, 3 p, 3 k).
        """
        w = np.asarray(rates, dtype=float)[:, None]
        gain = 1 / (self.rates**2 - w**2 + 2j * self.damping * self.rates * w)
        return np.einsum("rp,nr,rk->npk", felt, gain, pushed)


class ModalShell(Modes):
    """Modes with shapes known everywhere: places (p, 3) -> (p, 3), x ahead, y left, z up from the centre of mass."""

    def at(self, places: np.ndarray) -> np.ndarray:
        """Return the shapes at places (p, 3) [m], shape (r, 3 p)."""
        return np.array([shape(np.atleast_2d(places)).ravel() for shape in self.shapes])


def beam_shell(
    mass: float, roll_inertia: float, length: float, bending: float, lateral: float, torsion: float, damping: float
) -> ModalShell:
    """Return the modes of a uniform beam: ``mass`` [kg], ``roll_inertia`` about x [kg m^2], ``length`` [m], its first
    ``bending``, ``lateral`` and ``torsion`` frequency [Hz], ``damping`` of all elastic modes [-].

    Sections stay plane and square to the axis. ValueError for a number that is not positive, or a negative damping.
    """
    given = dict(mass=mass, roll_inertia=roll_inertia, length=length, bending=bending, lateral=lateral, torsion=torsion)
    for name, value in given.items():
        number(value, f"shell: {name}", positive=True)
    found: list[tuple[float, Shape]] = [(0.0, lambda at: np.tile([1 / np.sqrt(mass), 0, 0], (len(at), 1)))]
    nodes = length * np.linspace(-0.5, 0.5, ELEMENT_COUNT + 1)
    for axis, first in ((2, bending), (1, lateral)):
        for rate, line in bending_modes(nodes, mass, first):
            found.append((rate, partial(bent, line=line, axis=axis)))
    for rate, turns in torsion_modes(roll_inertia, torsion):
        found.append((rate, partial(twisted, nodes=nodes, turns=turns)))
    rates = np.array([rate for rate, _ in found])
    return ModalShell(rates, np.where(rates > 0, damping, 0.0), [shape for _, shape in found])


def bent(at: np.ndarray, line: CubicHermiteSpline, axis: int) -> np.ndarray:
    """Return the displacements of a beam whose line bends along an axis and whose plane sections turn by its slope,
    shape (p, 3).
    """
    u = np.zeros_like(at, dtype=float)
    u[:, axis], u[:, 0] = line(at[:, 0]), -at[:, axis] * line(at[:, 0], 1)
    return u


def twisted(at: np.ndarray, nodes: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Return the displacements of a beam whose sections turn about x by angles given at nodes, shape (p, 3)."""
    turn = np.interp(at[:, 0], nodes, turns)
    return np.stack([0 * turn, -at[:, 2] * turn, at[:, 1] * turn], axis=1)


def bending_modes(nodes: np.ndarray, mass: float, first: float) -> list[tuple[float, CubicHermiteSpline]]:
    """Return (w [rad/s], line) of two rigid and ``ELASTIC_MODES`` elastic modes of unit modal mass; the first at
    ``first`` [Hz]."""
    h = nodes[1] - nodes[0]
    k = np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2],
                  [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h**2, -6 * h, 4 * h**2]]) / h**3  # fmt: skip
    m = np.array([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h**2, 13 * h, -3 * h**2],
                  [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h**2, -22 * h, 4 * h**2]])  # fmt: skip
    m = m * mass / np.ptp(nodes) * h / 420
    return [(w, CubicHermiteSpline(nodes, v[::2], v[1::2])) for w, v in scaled(assembled(k, m, 2), 2, first)]


def torsion_modes(inertia: float, first: float) -> list[tuple[float, np.ndarray]]:
    """Return (w [rad/s], rotations at the nodes) of one rigid and ``ELASTIC_MODES`` elastic modes; the first at
    ``first`` [Hz]."""
    k, m = np.array([[1.0, -1.0], [-1.0, 1.0]]), np.array([[2.0, 1.0], [1.0, 2.0]]) * inertia / ELEMENT_COUNT / 6
    return scaled(assembled(k, m, 1), 1, first)


def assembled(k: np.ndarray, m: np.ndarray, freedoms: int) -> tuple[np.ndarray, np.ndarray]:
    """Return (K, M) of ``ELEMENT_COUNT`` equal elements in a row, with ``freedoms`` degrees of freedom per node."""
    K, M = np.zeros((2, *2 * (freedoms * (ELEMENT_COUNT + 1),)))
    for e in range(ELEMENT_COUNT):
        own = slice(freedoms * e, freedoms * (e + 2))
        K[own, own] += k
        M[own, own] += m
    return K, M


def scaled(pair: tuple[np.ndarray, np.ndarray], rigid: int, first: float) -> list[tuple[float, np.ndarray]]:
    """Return (w, shape) of the lowest modes, rigid ones at exactly 0, stiffness such that the first elastic is
    ``first``.
    """
    squares, shapes = eigh(*pair, subset_by_index=(0, rigid + ELASTIC_MODES - 1))
    w = np.sqrt(np.maximum(squares / squares[rigid], 0.0)) * 2 * np.pi * first
    w[:rigid] = 0.0
    return list(zip(w, shapes.T, strict=True))
