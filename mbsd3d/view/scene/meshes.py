"""What is computed from triangles: edges, normals at every corner, which faces can be seen.

The meshes of shapes share vertices across smooth edges only, see `mbsd3d.shapes.surfaces`: so a mean over the faces of
a vertex is its normal, here as in any viewer, and no angle is looked at again.
"""

from typing import NamedTuple

import numpy as np

from ...mechanism.shapes import Mesh
from ...mechanism.shapes.surfaces import normals


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


def with_shade(mesh: Mesh, shade: int) -> Mesh:
    """The faces of one shade, with those vertices only that they use."""
    used, faces = np.unique(mesh.faces[mesh.shade == shade], return_inverse=True)
    return Mesh(mesh.vertices[used], faces.reshape(-1, 3), np.full(faces.size // 3, shade))


def welded(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Faces (m, 3) with one number for all vertices at the same place, and those places."""
    grain = 1e-7 * float(np.ptp(vertices, axis=0).max() or 1.0)
    _, first, same = np.unique(np.round(vertices / grain), axis=0, return_index=True, return_inverse=True)
    return same.reshape(-1)[faces], vertices[first]


def flat_normals(triangles: np.ndarray) -> np.ndarray:
    """Unit normals of the planes of triangles (m, 3, 3); zero for one without area."""
    return unit(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]))


def edges_of(faces: np.ndarray, vertices: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(k, 2, 3) edges and (k, 2, 3) the normals of both faces at each; an open edge has its face twice."""
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    face = np.repeat(np.arange(len(faces)), 3)
    order = np.lexsort((face, ends[:, 1], ends[:, 0]))
    ends, face = ends[order], face[order]
    new = np.flatnonzero(np.r_[True, (np.diff(ends, axis=0) != 0).any(axis=1)])
    last = np.r_[new[1:], len(ends)] - 1
    return vertices[ends[new]], normals[np.stack([face[new], face[last]], axis=1)]


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors of length one; zero stays."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300)
