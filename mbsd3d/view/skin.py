"""What glTF wants of a mesh: faces that have an area, a unit normal at every corner, and which faces can be seen."""

from typing import NamedTuple

import numpy as np

from ..shapes import Mesh
from ..surfaces import normals


class Skin(NamedTuple):
    """A mesh without faces that have no area."""

    vertices: np.ndarray  # (k, 3) [m]
    normals: np.ndarray  # (k, 3) unit vectors
    faces: np.ndarray  # (m, 3)
    shade: np.ndarray  # (m,)
    closed: bool  # nobody can look at the faces from behind


def skin(mesh: Mesh) -> Skin:
    """The mesh with its normals; a face with a corner whose faces cancel out has its own normal."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    spans = np.cross(b - a, c - a)
    areas = np.linalg.norm(spans, axis=1)
    seen = areas > 0.0
    faces, flat, shade = mesh.faces[seen], spans[seen] / areas[seen, None], mesh.shade[seen]
    found = normals(mesh._replace(faces=faces))
    lost = ~found.any(axis=1)[faces].all(axis=1)
    vertices = np.concatenate([mesh.vertices, mesh.vertices[faces[lost]].reshape(-1, 3)])
    found = np.concatenate([found, np.repeat(flat[lost], 3, axis=0)])
    faces = np.array(faces)
    faces[lost] = len(mesh.vertices) + np.arange(3 * lost.sum()).reshape(-1, 3)
    used, faces = np.unique(faces, return_inverse=True)
    faces = faces.reshape(-1, 3)
    return Skin(vertices[used], found[used], faces, shade, is_closed(vertices[used], faces))


def is_closed(vertices: np.ndarray, faces: np.ndarray) -> bool:
    """Whether every edge is passed in both directions, as the edges between faces of a solid are."""
    _, places = np.unique(vertices.astype(np.float32), axis=0, return_inverse=True)  # sharp edges have vertices twice
    edges = places.reshape(-1)[faces[:, [0, 1, 1, 2, 2, 0]]].reshape(-1, 2)
    return np.array_equal(np.unique(edges, axis=0), np.unique(edges[:, ::-1], axis=0))
