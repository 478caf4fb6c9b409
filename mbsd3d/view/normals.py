"""Normals of a surface: smooth over its round parts, broken at its edges."""

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..shapes import Mesh

CREASE = np.cos(np.radians(40.0))  # faces that meet under a larger angle have an edge; prisms of ten sides are round
CANCELLED = 1e-3  # relative length below which the sum of the normals about a corner has no direction


class Surface(NamedTuple):
    """A mesh whose vertices are doubled where the normal jumps."""

    vertices: np.ndarray  # (k, 3) [m]
    normals: np.ndarray  # (k, 3) unit vectors
    faces: np.ndarray  # (m, 3); those of a mesh without area are left out
    shade: np.ndarray  # (m,)
    closed: bool  # every edge has a face on either side: nobody can look inside


def surface(mesh: Mesh) -> Surface:
    """The mesh with normals.

    Parameters
    ----------
    mesh : Mesh
        Any triangles.

    Returns
    -------
    Surface
        Corners of neighbouring faces share a normal, the mean weighted by the angles of the faces there.
    """
    corners = mesh.vertices[mesh.faces]
    spans = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(spans, axis=1)
    seen = areas > 0.0
    faces, flat = mesh.faces[seen], spans[seen] / areas[seen, None]
    weights = angles(corners[seen])[..., None] * flat[:, None]
    for groups in (smooth_groups(faces, flat), np.arange(len(faces))):  # every face for itself where that fails
        keys = np.column_stack([faces.ravel(), np.repeat(groups, 3)])
        keys, places = np.unique(keys, axis=0, return_inverse=True)
        normals, total = np.zeros((len(keys), 3)), np.zeros(len(keys))
        np.add.at(normals, places, weights.reshape(-1, 3))
        np.add.at(total, places, np.linalg.norm(weights, axis=2).ravel())
        lengths = np.linalg.norm(normals, axis=1)
        if (lengths > CANCELLED * total).all():
            break
    vertices = mesh.vertices[keys[:, 0]]
    return Surface(vertices, normals / lengths[:, None], places.reshape(-1, 3), mesh.shade[seen], is_closed(faces))


def angles(corners: np.ndarray) -> np.ndarray:
    """(m, 3) angles of triangles (m, 3, 3) at their corners [rad]."""
    ahead, back = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    return np.arctan2(np.linalg.norm(np.cross(ahead, back), axis=2), (ahead * back).sum(axis=2))


def edges(faces: np.ndarray) -> np.ndarray:
    """(3 m, 2) directed edges, three of every face in turn."""
    return faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)


def smooth_groups(faces: np.ndarray, flat: np.ndarray) -> np.ndarray:
    """(m,) number of the round part every face belongs to; no edge of the solid lies within a part."""
    ends, owner = np.sort(edges(faces), axis=1), np.repeat(np.arange(len(faces)), 3)
    order = np.lexsort(ends.T)
    shared = (ends[order][1:] == ends[order][:-1]).all(axis=1)
    left, right = owner[order][:-1][shared], owner[order][1:][shared]
    smooth = (flat[left] * flat[right]).sum(axis=1) > CREASE
    links = coo_array((np.ones(smooth.sum()), (left[smooth], right[smooth])), shape=(len(faces), len(faces)))
    return connected_components(links, directed=False)[1]


def is_closed(faces: np.ndarray) -> bool:
    """Whether every edge is passed in both directions."""
    there, back = edges(faces), edges(faces)[:, ::-1]
    return np.array_equal(np.unique(there, axis=0), np.unique(back, axis=0))
