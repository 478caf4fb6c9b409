"""Nodes of a page: meshes and lines of a drawing, gathered by what they have in common, and their names."""

from typing import NamedTuple

import numpy as np

from ...mechanism.shapes import Mesh
from ...mechanism.shapes.triangles import joined
from .drawing import Drawing
from .meshes import with_shade


class MeshNode(NamedTuple):
    """All pieces of a body that share layer, colour and shade."""

    name: str
    body: int
    layer: str
    colour: str
    shade: int
    mesh: Mesh


class WireNode(NamedTuple):
    """All wires of a body that share layer and colour, as segments (k, 2, 3)."""

    name: str
    body: int
    layer: str
    colour: str
    segments: np.ndarray


def mesh_nodes(drawing: Drawing) -> list[MeshNode]:
    """Return the meshes of the bodies."""
    groups: dict[tuple[int, str, str, int], list[Mesh]] = {}
    for piece in drawing.pieces:
        for shade in (0, 1):
            if (piece.mesh.shade == shade).any():
                key = piece.body, piece.layer, piece.colour, shade
                groups.setdefault(key, []).append(with_shade(piece.mesh, shade))
    return [
        MeshNode(f"/bodies/{key[0]}/mesh{k}", *key, joined(*parts)) for k, (key, parts) in enumerate(groups.items())
    ]


def wire_nodes(drawing: Drawing) -> list[WireNode]:
    """Return the lines of the bodies."""
    groups: dict[tuple[int, str, str], list[np.ndarray]] = {}
    for wire in drawing.wires:
        segments = np.stack([wire.points[:-1], wire.points[1:]], axis=1)
        segments = segments[np.isfinite(segments).all(axis=(1, 2))]
        if len(segments):
            groups.setdefault((wire.body, wire.layer, wire.colour), []).append(segments)
    found = enumerate(groups.items())
    return [WireNode(f"/bodies/{key[0]}/wire{k}", *key, np.concatenate(parts)) for k, (key, parts) in found]


def ghost_nodes(drawing: Drawing) -> list[tuple[int, Mesh]]:
    """Return (body, all its shapes as one mesh) of the bodies that have some."""
    parts: dict[int, list[Mesh]] = {}
    for piece in drawing.pieces:
        if piece.layer == "bodies":
            parts.setdefault(piece.body, []).append(piece.mesh)
    return [(body, joined(*meshes)) for body, meshes in parts.items()]
