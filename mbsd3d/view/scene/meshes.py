"""Triangles: normals, edges and shades of meshes, and the coils, rods and arrows that are laid along vectors.

The meshes of shapes share vertices across smooth edges only, see `mbsd3d.mechanism.shapes.triangles`: so a mean over
the faces of a vertex is its normal, here as in any viewer.
"""

from typing import NamedTuple

import numpy as np

from ...base.rotations import multiply
from ...mechanism.shapes import Mesh
from ...mechanism.shapes.triangles import joined, normals, revolved

COIL_TURNS_COUNT, COIL_POINTS_COUNT, WIRE_SIDES_COUNT = 10, 12, 6  # of a coil, along each turn, around the wire
ROD_RADIUS_RATIO = 0.005  # [sizes of the mechanism] radius of a rod, and the least one of a spring
COIL_RADIUS_RATIO = 0.045  # [lengths of the spring] radius of a coil at which its wire is round
WIRE_RADIUS_RATIO = 0.13  # [radii of the coil] radius of its wire
Z_AXIS = np.array([0.0, 0.0, 1.0])
ARROW_RADIUS_RATIO, ARROW_HEAD_RATIO = 0.018, 0.17  # [lengths of the arrow] radius of its shaft, length of its head
ARROW_HEAD_WIDTH_RATIO = 3.0  # [radii of the shaft] radius of the head
ARROW_SECTIONS_COUNT = 12  # sections of an arrow about its axis


class Skin(NamedTuple):
    """Mesh without faces of zero area."""

    vertices: np.ndarray  # (k, 3) [m]
    normals: np.ndarray  # (k, 3) unit vectors
    faces: np.ndarray  # (m, 3)
    shade: np.ndarray  # (m,)
    closed: bool  # the faces are never seen from behind


def skin(mesh: Mesh) -> Skin:
    """Return the mesh with its normals; a face with a corner whose faces cancel out has its own normal."""
    flat = flat_normals(mesh.vertices[mesh.faces])
    seen = flat.any(axis=1)
    faces, flat, shade = mesh.faces[seen], flat[seen], mesh.shade[seen]
    found = normals(mesh._replace(faces=faces))
    lost = ~found[faces].any(axis=2).all(axis=1)
    vertices = np.concatenate([mesh.vertices, mesh.vertices[faces[lost]].reshape(-1, 3)])
    found = np.concatenate([found, np.repeat(flat[lost], 3, axis=0)])
    faces[lost] = len(mesh.vertices) + np.arange(3 * lost.sum()).reshape(-1, 3)
    used, faces = np.unique(faces, return_inverse=True)
    faces = faces.reshape(-1, 3)
    return Skin(vertices[used], found[used], faces, shade, is_closed(vertices[used], faces))


def is_closed(vertices: np.ndarray, faces: np.ndarray) -> bool:
    """Return whether every edge is passed in both directions, as the edges between faces of a solid are."""
    _, places = np.unique(vertices.astype(np.float32), axis=0, return_inverse=True)  # sharp edges have vertices twice
    edges = places.reshape(-1)[faces[:, [0, 1, 1, 2, 2, 0]]].reshape(-1, 2)
    return np.array_equal(np.unique(edges, axis=0), np.unique(edges[:, ::-1], axis=0))


def with_shade(mesh: Mesh, shade: int) -> Mesh:
    """Return the faces of one shade, with those vertices only that they use."""
    used, faces = np.unique(mesh.faces[mesh.shade == shade], return_inverse=True)
    return Mesh(mesh.vertices[used], faces.reshape(-1, 3), np.full(faces.size // 3, shade))


def welded(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return faces (m, 3) with one number for all vertices at the same place, and those places."""
    grain = 1e-7 * float(np.ptp(vertices, axis=0).max() or 1.0)
    _, first, same = np.unique(np.round(vertices / grain), axis=0, return_index=True, return_inverse=True)
    return same.reshape(-1)[faces], vertices[first]


def flat_normals(triangles: np.ndarray) -> np.ndarray:
    """Return unit normals of the planes of triangles (m, 3, 3); zero for one without area."""
    return unit(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]))


def edges_of(faces: np.ndarray, vertices: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return edges (k, 2, 3) and the normals of both faces at each (k, 2, 3); an open edge has its face twice."""
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    edges, first, same = np.unique(ends, axis=0, return_index=True, return_inverse=True)
    last = np.zeros_like(first)
    np.maximum.at(last, same.reshape(-1), np.arange(len(ends)))
    return vertices[edges], normals[np.column_stack([first, last]) // 3]


def unit(vectors: np.ndarray) -> np.ndarray:
    """Return vectors of length one; zero stays."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300)


def unit_coil() -> Mesh:
    """Return a coil spring of unit radius along z from 0 to 1 that closes to its axis at both ends."""
    along = np.linspace(0.0, 1.0, COIL_TURNS_COUNT * COIL_POINTS_COUNT + 1)[:, None]
    radius = np.minimum(np.minimum(along, 1.0 - along) * COIL_TURNS_COUNT, 1.0)
    turn, zero = 2.0 * np.pi * COIL_TURNS_COUNT * along, np.zeros_like(along)
    out = np.hstack([np.cos(turn), np.sin(turn), zero])
    return tube(
        radius * out + along * Z_AXIS, WIRE_RADIUS_RATIO * COIL_RADIUS_RATIO * Z_AXIS + zero, WIRE_RADIUS_RATIO * out
    )


def unit_rod() -> Mesh:
    """Return a rod of unit radius along z from 0 to 1."""
    same = np.ones((2, 1))
    return tube(np.array([0.0 * Z_AXIS, Z_AXIS]), same * [1.0, 0.0, 0.0], same * [0.0, 1.0, 0.0])


def tube(centres: np.ndarray, first: np.ndarray, second: np.ndarray) -> Mesh:
    """Return an open tube about centres (k, 3) with elliptic sections of half axes ``first`` and ``second`` (k, 3)."""
    turn = np.arange(WIRE_SIDES_COUNT) * 2.0 * np.pi / WIRE_SIDES_COUNT
    rings = centres[:, None] + np.cos(turn)[:, None] * first[:, None] + np.sin(turn)[:, None] * second[:, None]
    start = (np.arange(len(centres) - 1) * WIRE_SIDES_COUNT)[:, None] + np.arange(WIRE_SIDES_COUNT)
    beside = (np.arange(len(centres) - 1) * WIRE_SIDES_COUNT)[:, None] + (
        np.arange(WIRE_SIDES_COUNT) + 1
    ) % WIRE_SIDES_COUNT
    quads = np.stack(
        [start, beside, beside + WIRE_SIDES_COUNT, start, beside + WIRE_SIDES_COUNT, start + WIRE_SIDES_COUNT], axis=-1
    )
    faces = quads.reshape(-1, 3)
    return Mesh(rings.reshape(-1, 3), faces, np.zeros(len(faces), int))


def arrow(heads: int, length: float = 1.0, shaft: float = ARROW_RADIUS_RATIO, head: float = ARROW_HEAD_RATIO) -> Mesh:
    """Return an arrow from the origin along z with one head or two, one behind the other; all lengths in one unit."""
    wide, corners = ARROW_HEAD_WIDTH_RATIO * shaft, [(0.0, 0.0), (shaft, 0.0), (shaft, length - heads * head)]
    for k in range(heads, 0, -1):
        corners += [(wide, length - k * head), (shaft if k > 1 else 0.0, length - (k - 1) * head)]
    sides = [revolved(np.array(side), ARROW_SECTIONS_COUNT) for side in zip(corners, corners[1:], strict=False)]
    mesh = joined(*sides)  # sides share no vertices: their rims are sharp
    return mesh._replace(shade=np.zeros_like(mesh.shade))


def rolled(spans: np.ndarray, least: float) -> tuple[np.ndarray, np.ndarray]:
    """Return lengths >= ``least`` (frames,) and unit quaternions (frames, 4) that turn z along spans (frames, 3).

    The turn from frame to frame is the smallest one, so that nothing spins about its own axis.
    """
    lengths = np.linalg.norm(spans, axis=-1)
    known = np.maximum.accumulate(np.where(lengths > least, np.arange(len(spans)), -1))
    along = unit_or_z(np.where(known[:, None] < 0, Z_AXIS, spans[known]))  # pressed to a point it keeps its direction
    steps = smallest(np.vstack([Z_AXIS, along[:-1]]), along)
    e = np.empty_like(steps)
    for k, step in enumerate(steps):
        e[k] = multiply(step, e[k - 1]) if k else step
    return np.maximum(lengths, least), e / np.linalg.norm(e, axis=1, keepdims=True)


def laid(vectors: np.ndarray, rest: np.ndarray = Z_AXIS) -> np.ndarray:
    """Return quaternions (k, 4) that turn z into the directions of vectors by way of the unit vectors ``rest``."""
    rest = np.broadcast_to(rest, vectors.shape)
    return multiply(smallest(rest, unit_or_z(vectors)), smallest(np.broadcast_to(Z_AXIS, rest.shape), rest))


def smallest(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return unit quaternions (k, 4) of the smallest rotations of unit vectors a to b.

    Half a turn about x if b = -a.
    """
    e = np.column_stack([1.0 + (a * b).sum(axis=1), np.cross(a, b)])
    norm = np.sqrt((e**2).sum(axis=1, keepdims=True))
    half = np.where(np.abs(a[:, :1]) < 0.9, np.cross(a, [1.0, 0.0, 0.0]), np.cross(a, [0.0, 1.0, 0.0]))
    half = np.column_stack([np.zeros(len(a)), unit_or_z(half)])
    return np.where(norm > 1e-7, e / np.maximum(norm, 1e-7), half)


def unit_or_z(vectors: np.ndarray) -> np.ndarray:
    """Return unit vectors; z for vectors of length zero."""
    length = np.sqrt((vectors**2).sum(axis=-1, keepdims=True))
    return np.divide(vectors, length, out=np.broadcast_to(Z_AXIS, vectors.shape).copy(), where=length > 0.0)
