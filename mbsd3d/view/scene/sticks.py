"""Sticks: coils, rods and arrows along z from 0 to 1, and the turns that lay them along vectors."""

from typing import Any

import numpy as np

from ...base.quaternions import multiply
from ...mechanism.shapes import Mesh
from ...mechanism.shapes.surfaces import joined, revolved

TURNS, POINTS, SIDES = 10, 12, 6  # of a coil, along each turn, around the wire
ROD = 0.005  # radius of a rod and least one of a spring, in sizes of the mechanism
SLENDER = 0.045  # radius of a coil in lengths: there its wire is round
WIRE = 0.13  # radius of the wire of a coil, in radii of the coil
Z = np.array([0.0, 0.0, 1.0])
SHAFT, HEAD = 0.018, 0.17  # radius of an arrow's shaft and length of its head, of its length
WIDE = 3.0  # radius of a head, in radii of the shaft
SECTIONS = 12  # of an arrow about its axis


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


def arrow(heads: int, length: float = 1.0, shaft: float = SHAFT, head: float = HEAD) -> Mesh:
    """An arrow from the origin along z with one head or two, one behind the other; all lengths in one unit."""
    wide, corners = WIDE * shaft, [(0.0, 0.0), (shaft, 0.0), (shaft, length - heads * head)]
    for k in range(heads, 0, -1):
        corners += [(wide, length - k * head), (shaft if k > 1 else 0.0, length - (k - 1) * head)]
    sides = [revolved(np.array(side), SECTIONS) for side in zip(corners, corners[1:], strict=False)]
    mesh = joined(*sides)  # sides share no vertices: their rims are sharp
    return mesh._replace(shade=np.zeros_like(mesh.shade))


def rolled(spans: np.ndarray, least: float) -> tuple[np.ndarray, np.ndarray]:
    """Lengths >= ``least`` (frames,) and unit quaternions (frames, 4) that turn z along spans (frames, 3).

    The turn from frame to frame is the smallest one, so that nothing spins about its own axis.
    """
    lengths = np.linalg.norm(spans, axis=-1)
    known = np.maximum.accumulate(np.where(lengths > least, np.arange(len(spans)), -1))
    along = unit_or_z(np.where(known[:, None] < 0, Z, spans[known]))  # pressed to a point it keeps its direction
    steps = smallest(np.vstack([Z, along[:-1]]), along)
    e = np.empty_like(steps)
    for k, step in enumerate(steps):
        e[k] = multiply(step, e[k - 1]) if k else step
    return np.maximum(lengths, least), e / np.linalg.norm(e, axis=1, keepdims=True)


def laid(vectors: np.ndarray, rest: Any = Z) -> np.ndarray:
    """(k, 4) quaternions that turn z into the directions of vectors by way of the unit vectors ``rest``."""
    rest = np.broadcast_to(rest, vectors.shape)
    return multiply(smallest(rest, unit_or_z(vectors)), smallest(np.broadcast_to(Z, rest.shape), rest))


def smallest(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(k, 4) unit quaternions of the smallest rotations of unit vectors a to b; half a turn about x if b = -a."""
    e = np.column_stack([1.0 + (a * b).sum(axis=1), np.cross(a, b)])
    norm = np.sqrt((e**2).sum(axis=1, keepdims=True))
    half = np.where(np.abs(a[:, :1]) < 0.9, np.cross(a, [1.0, 0.0, 0.0]), np.cross(a, [0.0, 1.0, 0.0]))
    half = np.column_stack([np.zeros(len(a)), unit_or_z(half)])
    return np.where(norm > 1e-7, e / np.maximum(norm, 1e-7), half)


def unit_or_z(vectors: np.ndarray) -> np.ndarray:
    """Unit vectors; z for those of no length."""
    length = np.sqrt((vectors**2).sum(axis=-1, keepdims=True))
    return np.divide(vectors, length, out=np.broadcast_to(Z, vectors.shape).copy(), where=length > 0.0)
