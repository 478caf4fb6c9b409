"""Copies of a body of length 1 along z that are laid along vectors: arrows, rods and springs of a scene."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..rotations import matrix, multiply
from .drawing import Link
from .links import SLENDER, unit_coil, unit_rod
from .meshes import linear, tint
from .motion import Frames

ROD = 0.005  # radius of a rod and least one of a spring, in units of the mechanism's size
GREY = "#8c8c8c"
NOTHING = 1e-9  # what stands for a length of zero: scales of zero have no inverse
Z = np.array([0.0, 0.0, 1.0])


class Links:
    """Springs as coils or joints as rods; all of a kind are one node of the scene.

    Each turns from its mean direction over the run by the smallest rotation, so that coils do not spin.
    """

    def __init__(self, scene: Any, name: str, links: Sequence[Link], frames: Frames, size: float, scale: float) -> None:
        self.ends, self.scale = [link.ends for link in links], scale
        spans = np.stack([np.subtract(*reversed(span)) for span in (paths(link, frames) for link in links)], axis=1)
        lengths = np.sqrt((spans**2).sum(axis=-1)).mean(axis=0)
        spring = links[0].spring
        self.radii = np.maximum(SLENDER * lengths if spring else 0.0, ROD * size) + 0.0 * lengths
        self.rest = directions(spans.sum(axis=0))
        mesh = unit_coil() if spring else unit_rod()
        self.node = add_copies(scene, name, mesh.vertices, mesh.faces, len(links), np.array(tint(GREY)))
        self.move(frames.r[0], frames.e[0])

    def move(self, r: np.ndarray, e: np.ndarray) -> None:
        """Lay them between their ends at a pose."""
        ends = np.array([[r[k] + matrix(e[k]) @ p for k, p in pair] for pair in self.ends])
        lay(self.node, ends[:, 0], ends[:, 1] - ends[:, 0], self.scale, self.radii, self.rest)


def paths(link: Link, frames: Frames) -> list[np.ndarray]:
    """Both ends (frames, 3) of a link, world [m]."""
    return [frames.r[:, k] + matrix(frames.e[:, k]) @ p for k, p in link.ends]


def add_copies(scene: Any, name: str, vertices: np.ndarray, faces: np.ndarray, count: int, colours: np.ndarray) -> Any:
    """A node of ``count`` copies of a mesh, still without a place; colours (3,) or (count, 3)."""
    still = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)), np.zeros((count, 3))
    scales = np.full((count, 3), NOTHING)
    return scene.add_batched_meshes_simple(
        name, vertices, faces, *still, batched_scales=scales, batched_colors=linear(colours), lod="off", side="double"
    )


def lay(
    node: Any, points: np.ndarray, vectors: np.ndarray, scale: float, radii: np.ndarray | None = None, rest: Any = Z
) -> None:
    """Lay the copies along vectors (k, 3) [m] from points: as wide as they are long, or of given radii [m]."""
    length = np.sqrt((vectors**2).sum(axis=1))
    wide = length if radii is None else radii
    node.batched_positions = (points * scale).astype(np.float32)
    node.batched_wxyzs = laid(vectors, rest).astype(np.float32)
    node.batched_scales = (np.column_stack([wide, wide, length]) * scale + NOTHING).astype(np.float32)


def laid(vectors: np.ndarray, rest: Any = Z) -> np.ndarray:
    """(k, 4) quaternions that turn z into the directions of vectors by way of the unit vectors ``rest``."""
    rest = np.broadcast_to(rest, vectors.shape)
    return multiply(smallest(rest, directions(vectors)), smallest(np.broadcast_to(Z, rest.shape), rest))


def smallest(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(k, 4) unit quaternions of the smallest rotations of unit vectors a to b; half a turn about x if b = -a."""
    e = np.column_stack([1.0 + (a * b).sum(axis=1), np.cross(a, b)])
    norm = np.sqrt((e**2).sum(axis=1, keepdims=True))
    half = np.where(np.abs(a[:, :1]) < 0.9, np.cross(a, [1.0, 0.0, 0.0]), np.cross(a, [0.0, 1.0, 0.0]))
    half = np.column_stack([np.zeros(len(a)), directions(half)])
    return np.where(norm > 1e-7, e / np.maximum(norm, 1e-7), half)


def directions(vectors: np.ndarray) -> np.ndarray:
    """Unit vectors; z for those of no length."""
    length = np.sqrt((vectors**2).sum(axis=-1, keepdims=True))
    return np.divide(vectors, length, out=np.broadcast_to(Z, vectors.shape).copy(), where=length > 0.0)
