"""Copies of a stick in a scene of viser that are laid along vectors: arrows, rods and springs; one node for many."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...base.rotations import matrix
from ...base.style import GREY, channels, linear
from ...mechanism.shapes import Mesh
from ..scene.drawing import Link
from ..scene.frames import Frames
from ..scene.sticks import ROD, SLENDER, Z, laid, unit_coil, unit_or_z, unit_rod

NOTHING = 1e-9  # what stands for a length of zero: scales of zero have no inverse


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
        self.rest = unit_or_z(spans.sum(axis=0))
        mesh = unit_coil() if spring else unit_rod()
        self.node = add_copies(scene, name, mesh, channels(GREY), len(links))
        self.move(frames.r[0], frames.e[0])

    def move(self, r: np.ndarray, e: np.ndarray) -> None:
        """Lay them between their ends at a pose."""
        ends = np.array([[r[k] + matrix(e[k]) @ p for k, p in pair] for pair in self.ends])
        lay(self.node, ends[:, 0], ends[:, 1] - ends[:, 0], self.scale, self.radii, self.rest)


def paths(link: Link, frames: Frames) -> list[np.ndarray]:
    """Both ends (frames, 3) of a link, world [m]."""
    return [frames.r[:, k] + matrix(frames.e[:, k]) @ p for k, p in link.ends]


def add_copies(scene: Any, name: str, mesh: Mesh, colours: np.ndarray, count: int) -> Any:
    """A node of ``count`` copies of a mesh, still without a place; colours (3,) or (count, 3), 0 ... 255."""
    still = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)), np.zeros((count, 3))
    scales = np.full((count, 3), NOTHING)
    tints = np.rint(255.0 * linear(colours / 255.0)).astype(np.uint8)  # viser takes those of copies as they are
    return scene.add_batched_meshes_simple(
        name, mesh.vertices, mesh.faces, *still, batched_scales=scales, batched_colors=tints, lod="off", side="double"
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
