"""Springs and rods between two moving points: one body of unit length, moved, turned and stretched.

Unit coil and unit rod lie along z from 0 to 1 and have the radius 1.
"""

import numpy as np

from ..rotations import multiply
from ..shapes import Mesh

TURNS, POINTS, SIDES = 10, 12, 6  # of a coil, along each turn, around the wire
SLENDER = 0.045  # radius of a coil in lengths: there its wire is round
WIRE = 0.13  # radius of the wire of a coil, in radii of the coil
Z = np.array([0.0, 0.0, 1.0])
NEAR = 1e-9  # |a + b|^2 / 2 of two opposite unit vectors


def tube(centres: np.ndarray, first: np.ndarray, second: np.ndarray) -> Mesh:
    """An open tube about centres (k, 3) with elliptic sections of half axes ``first`` and ``second`` (k, 3)."""
    turn = np.arange(SIDES) * 2.0 * np.pi / SIDES
    rings = centres[:, None] + np.cos(turn)[:, None] * first[:, None] + np.sin(turn)[:, None] * second[:, None]
    start = (np.arange(len(centres) - 1) * SIDES)[:, None] + np.arange(SIDES)
    beside = (np.arange(len(centres) - 1) * SIDES)[:, None] + (np.arange(SIDES) + 1) % SIDES
    quads = np.stack([start, beside, beside + SIDES, start, beside + SIDES, start + SIDES], axis=-1)
    faces = quads.reshape(-1, 3)
    return Mesh(rings.reshape(-1, 3), faces, np.zeros(len(faces), int))


def unit_coil() -> Mesh:
    """A coil spring of unit radius that closes to its axis at both ends."""
    along = np.linspace(0.0, 1.0, TURNS * POINTS + 1)[:, None]
    radius = np.minimum(np.minimum(along, 1.0 - along) * TURNS, 1.0)
    turn, zero = 2.0 * np.pi * TURNS * along, np.zeros_like(along)
    out = np.hstack([np.cos(turn), np.sin(turn), zero])
    return tube(radius * out + along * Z, WIRE * SLENDER * Z + zero, WIRE * out)


def unit_rod() -> Mesh:
    """A thin straight rod."""
    same = np.ones((2, 1))
    return tube(np.array([0.0 * Z, Z]), same * [1.0, 0.0, 0.0], same * [0.0, 1.0, 0.0])


def directions(spans: np.ndarray, least: float) -> tuple[np.ndarray, np.ndarray]:
    """Lengths >= ``least`` (frames,) and unit quaternions (frames, 4) that turn z along spans (frames, 3).

    The turn from frame to frame is the smallest one, so that nothing spins about its own axis.
    """
    lengths = np.linalg.norm(spans, axis=-1)
    e, last, turned = np.empty((len(spans), 4)), Z, np.array([1.0, 0.0, 0.0, 0.0])
    for k, (span, length) in enumerate(zip(spans, lengths, strict=True)):
        if length > least:  # a spring pressed to a point keeps its direction
            turned = multiply(smallest_turn(last, span / length), turned)
            turned, last = turned / np.linalg.norm(turned), span / length
        e[k] = turned
    return np.maximum(lengths, least), e


def smallest_turn(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Unit quaternion of the smallest rotation that takes unit vector a to b; about any normal if they are opposite."""
    if 1.0 + a @ b < NEAR:
        normal = np.cross(a, np.eye(3)[np.argmin(np.abs(a))])
        return np.array([0.0, *(normal / np.linalg.norm(normal))])
    e = np.array([1.0 + a @ b, *np.cross(a, b)])
    return e / np.linalg.norm(e)
