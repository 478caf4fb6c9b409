"""Solids for the painter: small triangles and outlines of all pieces of a drawing, placed at a pose and shaded.

The painter sorts what it draws by depth, so no triangle and no stroke may be long: both are split beforehand.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.colors import to_rgb

from .drawing import Piece
from .lens import Lens

CREASE = np.cos(np.radians(35.0))  # edges with a sharper bend are drawn, and shading does not run across them
DARK, LIT, GLOSS = 0.48, 1.15, 0.14  # brightness of a face turned away from the light and towards it; highlight
SECOND = 0.72  # brightness of the second tint, by which one sees a round body turn
PALE = 0.12  # share of white in all colours
OUTLINE = 0.38  # brightness of the outline
LIGHT = np.array([-0.45, 0.75, -0.55])  # towards the light, from right, up and forward of the eye


class Items(NamedTuple):
    """What is painted far to near: triangles, and strokes from the first corner to the second."""

    corners: np.ndarray  # (k, 3, 3) world [m]
    fill: np.ndarray  # (k, 3) colours
    width: np.ndarray  # (k,) of the pen, points; 0 for triangles
    lift: np.ndarray  # (k,) [m] towards the eye, for the order only


def join(parts: Sequence[Items]) -> Items:
    """All items of several."""
    return Items(*(np.concatenate(field) for field in zip(*parts, strict=True)))


def split_triangles(triangles: np.ndarray, longest: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Halve triangles at their longest edge until none is above its limit; what belongs to the corners is halved too.

    Parameters
    ----------
    triangles : (m, 3, k) ndarray
        For each corner its position, then anything that is linear in between.
    longest : (m,) ndarray
        Limits of their edges.

    Returns
    -------
    (m', 3, k) ndarray, (m',) ndarray
        The parts, and the places of the triangles they come from.
    """
    parent = np.arange(len(triangles))
    while True:
        edges = np.linalg.norm((np.roll(triangles, -1, axis=1) - triangles)[..., :3], axis=2)
        long = np.flatnonzero(edges.max(axis=1, initial=0.0) > longest[parent])
        if not long.size:
            return triangles, parent
        turn = (edges[long].argmax(axis=1)[:, None] + np.arange(3)) % 3
        a, b, c = np.take_along_axis(triangles[long], turn[:, :, None], axis=1).transpose(1, 0, 2)
        middle = 0.5 * (a + b)
        triangles = np.concatenate([triangles, np.stack([middle, b, c], axis=1)])
        triangles[long] = np.stack([a, middle, c], axis=1)
        parent = np.concatenate([parent, parent[long]])


def split_strokes(strokes: np.ndarray, longest: float) -> tuple[np.ndarray, np.ndarray]:
    """Cut strokes (m, 2, 3) into equal parts not above ``longest``; also the place of the parent."""
    lengths = np.linalg.norm(strokes[:, 1] - strokes[:, 0], axis=1)
    counts = np.maximum(np.ceil(lengths / longest - 1e-9), 1).astype(int)
    parent = np.repeat(np.arange(len(strokes)), counts)
    place = np.arange(parent.size) - np.repeat(np.cumsum(counts) - counts, counts)
    share = np.stack([place, place + 1], axis=1) / counts[parent][:, None]
    start, along = strokes[parent, :1], (strokes[:, 1] - strokes[:, 0])[parent, None]
    return start + share[:, :, None] * along, parent


def normals_of(triangles: np.ndarray) -> np.ndarray:
    """Unit normals; zero for a triangle without area."""
    return unit(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]))


def welded(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Faces (m, 3) with one number for all vertices at the same place, and those places."""
    grain = 1e-7 * float(np.ptp(vertices, axis=0).max() or 1.0)
    _, first, same = np.unique(np.round(vertices / grain), axis=0, return_index=True, return_inverse=True)
    return same.reshape(-1)[faces], vertices[first]


def corner_normals(faces: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """(m, 3, 3) normals at the corners: means over the faces around a corner that are not beyond a crease."""
    corners = faces.ravel()
    order = np.argsort(corners, kind="stable")
    counts = np.bincount(corners)
    starts = np.cumsum(counts) - counts
    many = counts[corners]
    mine = np.repeat(np.arange(corners.size), many)
    step = np.arange(mine.size) - np.repeat(np.cumsum(many) - many, many)
    other = order[starts[corners[mine]] + step] // 3
    smooth = np.einsum("ki,ki->k", normals[mine // 3], normals[other]) >= CREASE
    total = np.zeros((corners.size, 3))
    np.add.at(total, mine[smooth], normals[other[smooth]])
    return (total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-300)).reshape(-1, 3, 3)


def edges_of(faces: np.ndarray, vertices: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(k, 2, 3) edges and (k, 2, 3) the normals of both faces at each; an open edge has its face twice."""
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    face = np.repeat(np.arange(len(faces)), 3)
    order = np.lexsort((face, ends[:, 1], ends[:, 0]))
    ends, face = ends[order], face[order]
    new = np.flatnonzero(np.r_[True, (np.diff(ends, axis=0) != 0).any(axis=1)])
    last = np.r_[new[1:], len(ends)] - 1
    return vertices[ends[new]], normals[np.stack([face[new], face[last]], axis=1)]


class Prepared(NamedTuple):
    """What does not change with the pose, body axes from O."""

    whole: np.ndarray  # (w, 3, 3) triangles as given, for shadows
    whole_body: np.ndarray  # (w,)
    triangles: np.ndarray  # (t, 3, 3) split
    flat: np.ndarray  # (t, 3) normals of their planes, which say what is a front face
    round: np.ndarray  # (t, 3) normals that they are shaded with
    tints: np.ndarray  # (t, 3)
    body: np.ndarray  # (t,)
    edges: np.ndarray  # (s, 2, 3) split
    sides: np.ndarray  # (s, 2, 3) normals of the faces at both sides
    inks: np.ndarray  # (s, 3)
    owner: np.ndarray  # (s,) bodies


def prepare(piece: Piece, longest: float) -> Prepared:
    """Split the triangles and edges of a piece: the thinner it is, the finer, down to ``longest`` / 2.5."""
    faces, vertices = welded(piece.mesh.vertices, piece.mesh.faces)
    longest = min(longest, max(float(np.ptp(vertices, axis=0).min()), 0.4 * longest))
    whole = vertices[faces]
    normals = normals_of(whole)
    corners = corner_normals(faces, normals)
    bent = np.einsum("mci,mi->mc", corners, normals).min(axis=1) < 1.0 - 1e-4
    split, parent = split_triangles(np.concatenate([whole, corners], axis=2), np.where(bent, 0.4, 1.0) * longest)
    tints = np.where(piece.mesh.shade[:, None] == 1, SECOND, 1.0) * (
        PALE + (1.0 - PALE) * np.array(to_rgb(piece.colour))
    )
    edges, sides = edges_of(faces, vertices, normals)
    short, of = split_strokes(edges, longest)
    fields = {
        "whole": whole,
        "whole_body": np.full(len(whole), piece.body),
        "triangles": split[..., :3],
        "flat": normals[parent],
        "round": unit(split[..., 3:].mean(axis=1)),
        "tints": tints[parent],
        "body": np.full(len(split), piece.body),
        "edges": short,
        "sides": sides[of],
        "inks": np.full((len(short), 3), OUTLINE) * to_rgb(piece.colour),
        "owner": np.full(len(short), piece.body),
    }
    return Prepared(**fields)


class Solids:
    """Pieces that are ready to be placed."""

    def __init__(self, pieces: Sequence[Piece], longest: float) -> None:
        self.longest = longest
        parts = [prepare(piece, longest) for piece in pieces]
        self.parts = Prepared(*(np.concatenate(field) for field in zip(*parts, strict=True))) if parts else None

    def placed(self, r: np.ndarray, R: np.ndarray, lens: Lens, pen: float) -> Items:
        """Shaded front faces, creases and outlines at a pose (n + 1, 3), (n + 1, 3, 3); ``pen`` in points."""
        if self.parts is None:
            return strokes_as_items(np.zeros((0, 2, 3)), (0.0, 0.0, 0.0), pen, 0.0)
        whole, whole_body, triangles, flat, smooth, tints, body, edges, sides, inks, owner = self.parts
        corners = triangles @ R[body].transpose(0, 2, 1) + r[body, None]
        normals = np.einsum("kij,kj->ki", R[body], flat)
        front = np.einsum("ki,ki->k", normals, lens.eye - corners[:, 0]) > 0.0
        corners, body = corners[front], body[front]
        fill = shaded(tints[front], np.einsum("kij,kj->ki", R[body], smooth[front]), lens)
        faces = Items(corners, fill, np.zeros(len(corners)), np.zeros(len(corners)))
        edges = edges @ R[owner].transpose(0, 2, 1) + r[owner, None]
        creased = np.einsum("ki,ki->k", sides[:, 0], sides[:, 1]) < CREASE
        sides = sides @ R[owner].transpose(0, 2, 1)
        visible = np.einsum("kfi,ki->kf", sides, lens.eye - edges.mean(axis=1)) > 0.0
        drawn = (visible[:, 0] != visible[:, 1]) | (creased & visible.all(axis=1))
        return join([faces, strokes_as_items(edges[drawn], inks[drawn], pen, 0.6 * self.longest)])

    def shadow(self, r: np.ndarray, R: np.ndarray, floor: float) -> np.ndarray:
        """(k, 3, 3) triangles on the floor under the faces that look up."""
        if self.parts is None:
            return np.zeros((0, 3, 3))
        body = self.parts.whole_body
        corners = self.parts.whole @ R[body].transpose(0, 2, 1) + r[body, None]
        corners = corners[normals_of(corners)[:, 2] > 0.0]
        corners[:, :, 2] = floor
        return corners


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors of length one; zero stays."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300)


def strokes_as_items(strokes: np.ndarray, ink: Any, pen: float, lift: float) -> Items:
    """Strokes (k, 2, 3) as items."""
    k = len(strokes)
    corners = strokes[:, [0, 1, 1]]
    return Items(corners, np.broadcast_to(ink, (k, 3)), np.full(k, pen), np.full(k, lift))


def shaded(tints: np.ndarray, normals: np.ndarray, lens: Lens) -> np.ndarray:
    """Colours of faces: the cosine law wrapped around the body (no face is black), and a soft highlight."""
    light = LIGHT @ lens.axes / np.linalg.norm(LIGHT)
    halfway = light - lens.axes[2]
    cosine = normals @ light
    bright = DARK + (LIT - DARK) * (0.5 + 0.5 * cosine) ** 1.2
    gloss = GLOSS * np.clip(normals @ (halfway / np.linalg.norm(halfway)), 0.0, 1.0) ** 24
    white = np.clip(bright - 0.92, 0.0, None)[:, None] * 1.2 + gloss[:, None]
    return np.clip(tints * bright[:, None] * (1.0 - white) + white, 0.0, 1.0)
