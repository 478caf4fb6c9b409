"""Solids and arrows for the painter: small triangles and outlines, placed at a pose and shaded.

The painter sorts by depth, so no triangle and no stroke may be long: both are split beforehand.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...base.rotations import matrix
from ...base.style import SECTOR_BRIGHTNESS, channels
from ...base.wording import with_superscripts
from ...mechanism.shapes import Mesh
from ...mechanism.shapes.triangles import moved
from ...mechanism.shapes.triangles import normals as vertex_normals
from ..scene.camera import Lens
from ..scene.drawing import Piece
from ..scene.meshes import arrow, edges_of, flat_normals, laid, unit, welded
from ..scene.overlays import Arrows

CREASE = np.cos(np.radians(35.0))  # edges with a sharper bend are drawn
# [1] brightness of a face turned away from the light and towards it, and of highlights
SHADOW_BRIGHTNESS, LIT_BRIGHTNESS, HIGHLIGHT_BRIGHTNESS = 0.48, 1.15, 0.14
THIN_TRIANGLE_FACTOR = 0.4  # [1] size of the triangles of thin, and of large and round solids, over the others
SEAM_WIDTH = 0.35  # [points] of the line around each polygon; without it gaps show
WHITE_SHARE = 0.12  # [1] of white in all colours
OUTLINE_BRIGHTNESS = 0.38  # [1] of outlines
LIGHT_DIRECTION = np.array([-0.45, 0.75, -0.55])  # [1] towards the light: right, up and forward of the eye
# [lengths of the longest arrow] radius of the shaft, length of the head, length of the shortest arrow that is drawn
ARROW_RADIUS_RATIO, ARROW_HEAD_RATIO = 0.018, 0.14
ARROW_LENGTH_MIN = 0.04


class Items(NamedTuple):
    """Triangles, and strokes from the first corner to the second, painted from far to near."""

    corners: np.ndarray  # (k, 3, 3) world [m]
    fill: np.ndarray  # (k, 3) colours
    width: np.ndarray  # (k,) of the pen, points; 0 for triangles
    lift: np.ndarray  # (k,) [m] towards the eye, for the order only


def join(parts: Sequence[Items]) -> Items:
    """Return all items of several."""
    return Items(*(np.concatenate(field) for field in zip(*parts, strict=True)))


def split_triangles(triangles: np.ndarray, longest: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Halve triangles (m, 3, k) at their longest edge until none is above its limit (m,).

    A corner is its position, then anything that is linear in between and is halved too. Also returns the place of the
    triangle that each part comes from.
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


class Prepared(NamedTuple):
    """Triangles and edges that do not change with the pose, body axes from O."""

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
    lifts: np.ndarray  # (s,) [m] by which they are painted as if nearer: small ones must not show through others


def prepare(piece: Piece, longest: float) -> Prepared:
    """Split triangles and edges of a piece.

    Down to THIN_TRIANGLE_FACTOR times ``longest`` if thin, or large and round.
    """
    faces, vertices = welded(piece.mesh.vertices, piece.mesh.faces)
    thickness, finest = float(np.ptp(vertices, axis=0).min()), THIN_TRIANGLE_FACTOR * longest
    limit = min(longest, max(thickness, finest))
    whole = vertices[faces]
    normals, corners = flat_normals(whole), vertex_normals(piece.mesh)[piece.mesh.faces]
    bent = np.einsum("mci,mi->mc", corners, normals).min(axis=1) < 1.0 - 1e-4
    split, parent = split_triangles(
        np.concatenate([whole, corners], axis=2), np.where(bent & (thickness > longest), finest, limit)
    )
    tint = channels(piece.colour) / 255.0
    brightness = np.where(piece.mesh.shade[:, None] == 1, SECTOR_BRIGHTNESS, 1.0)
    edges, sides = edges_of(faces, vertices, normals)
    short, of = split_strokes(edges, limit)
    lift = min(0.6 * limit, 0.15 * float(np.ptp(vertices, axis=0).max()))
    return Prepared(
        whole=whole,
        whole_body=np.full(len(whole), piece.body),
        triangles=split[..., :3],
        flat=normals[parent],
        round=unit(split[..., 3:].mean(axis=1)),
        tints=(brightness * (WHITE_SHARE + (1.0 - WHITE_SHARE) * tint))[parent],
        body=np.full(len(split), piece.body),
        edges=short,
        sides=sides[of],
        inks=np.full((len(short), 3), OUTLINE_BRIGHTNESS) * tint,
        owner=np.full(len(short), piece.body),
        lifts=np.full(len(short), lift),
    )


class Solids:
    """Pieces that are ready to be placed."""

    def __init__(self, pieces: Sequence[Piece], longest: float) -> None:
        parts = [prepare(piece, longest) for piece in pieces]
        self.parts = Prepared(*(np.concatenate(field) for field in zip(*parts, strict=True))) if parts else None

    def placed(self, r: np.ndarray, R: np.ndarray, lens: Lens, pen: float) -> Items:
        """Return shaded front faces, creases and outlines at a pose (n + 1, 3), (n + 1, 3, 3); ``pen`` in points."""
        if self.parts is None:
            return strokes_as_items(np.zeros((0, 2, 3)), (0.0, 0.0, 0.0), pen, 0.0)
        whole, whole_body, triangles, flat, smooth, tints, body, edges, sides, inks, owner, lifts = self.parts
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
        return join([faces, strokes_as_items(edges[drawn], inks[drawn], pen, lifts[drawn])])

    def shadow(self, r: np.ndarray, R: np.ndarray, floor: float) -> np.ndarray:
        """Return triangles (k, 3, 3) on the floor under the faces that look up."""
        if self.parts is None:
            return np.zeros((0, 3, 3))
        body = self.parts.whole_body
        corners = self.parts.whole @ R[body].transpose(0, 2, 1) + r[body, None]
        corners = corners[flat_normals(corners)[:, 2] > 0.0]
        corners[:, :, 2] = floor
        return corners


def strokes_as_items(strokes: np.ndarray, ink: ArrayLike, pen: float, lift: np.ndarray | float) -> Items:
    """Return strokes (k, 2, 3) as items."""
    k = len(strokes)
    corners = strokes[:, [0, 1, 1]]
    return Items(corners, np.broadcast_to(ink, (k, 3)), np.full(k, pen), np.broadcast_to(lift, k))


def shaded(tints: np.ndarray, normals: np.ndarray, lens: Lens) -> np.ndarray:
    """Return the colours of faces: the cosine law wrapped around the body (no face is black), and a soft highlight."""
    light = LIGHT_DIRECTION @ lens.axes / np.linalg.norm(LIGHT_DIRECTION)
    halfway = light - lens.axes[2]
    cosine = normals @ light
    bright = SHADOW_BRIGHTNESS + (LIT_BRIGHTNESS - SHADOW_BRIGHTNESS) * (0.5 + 0.5 * cosine) ** 1.2
    gloss = HIGHLIGHT_BRIGHTNESS * np.clip(normals @ (halfway / np.linalg.norm(halfway)), 0.0, 1.0) ** 24
    white = np.clip(bright - 0.92, 0.0, None)[:, None] * 1.2 + gloss[:, None]
    return np.clip(tints * bright[:, None] * (1.0 - white) + white, 0.0, 1.0)


def outlines(corners: np.ndarray, widths: np.ndarray) -> np.ndarray:
    """Return polygons (k, 4, 2) of triangles (k, 3, 2), their last corner twice; items with a width are bars."""
    polygons = corners[:, [0, 1, 2, 2]]
    pen = widths > 0.0
    start, end = corners[pen, 0], corners[pen, 1]
    along = unit(end - start) * 0.5 * (widths[pen, None] - SEAM_WIDTH)
    aside = along[:, ::-1] * (-1.0, 1.0)
    start, end = start - 0.5 * along, end + 0.5 * along  # where two of them meet at an angle, no notch is left
    polygons[pen] = np.stack([start + aside, end + aside, end - aside, start - aside], axis=1)
    return polygons


class Pointers(NamedTuple):
    """Arrows of one kind at one time, ready to be painted."""

    pieces: list[Piece]
    legend: str
    colour: str
    lens: Lens

    def items(self, longest: float) -> Items:
        """Return shaded triangles and outlines."""
        here, R = np.zeros((1, 3)), np.eye(3)[None]
        return Solids(self.pieces, longest).placed(here, R, self.lens, 0.5)


def arrow_along(start: np.ndarray, vector: np.ndarray, reach: float, heads: int) -> Mesh:
    """Return an arrow among arrows of up to ``reach`` [m]: thinner when it is too short for its head."""
    length = float(np.linalg.norm(vector))
    head, thin = (
        min(ARROW_HEAD_RATIO * reach, 0.8 * length / heads),
        ARROW_RADIUS_RATIO * reach * min(1.0, length / (2.0 * ARROW_HEAD_RATIO * reach)),
    )
    return moved(arrow(heads, length, thin, head), matrix(laid(vector[None])[0]), start)


def tips_of(arrows: Arrows, reach: float, drawn: slice) -> np.ndarray:
    """Return (k, 3) the ends of the arrows of the drawn frames if the longest of all has the length ``reach`` [m]."""
    return (arrows.points + reach / arrows.longest * arrows.vectors)[drawn].reshape(-1, 3)


def pointers_of(arrows: Arrows, frame: int, reach: float, lens: Lens) -> Pointers:
    """Return arrows of one kind at a frame, the longest of all frames as long as ``reach`` [m].

    Uncertain ones paler.
    """
    longest, pieces = arrows.longest, []
    for k, name in enumerate(arrows.names):
        vector = reach / longest * arrows.vectors[frame, k]
        if np.linalg.norm(vector) > ARROW_LENGTH_MIN * reach:
            mesh = arrow_along(arrows.points[frame, k], vector, reach, arrows.heads)
            pieces.append(Piece(name, arrows.kind, 0, mesh, arrows.tints[k]))
    unsure = ", pale: not unique" if any(arrows.uncertain) else ""
    size = f", longest {longest:.3g} {with_superscripts(arrows.unit)}" if arrows.unit else ""
    return Pointers(pieces, f"{arrows.kind}{size}{unsure}", arrows.colour, lens)
