"""Shaded picture of a mechanism in perspective, drawn with matplotlib on plain axes; vector output stays vector.

Everything is split into small triangles and strokes, which are painted from far to near.
"""

import copy
from collections.abc import Collection, Sequence
from typing import Self

import numpy as np
from matplotlib.artist import Artist, allow_rasterization
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.patheffects import withStroke
from matplotlib.transforms import IdentityTransform

from ...base.figure import Figure
from ...base.rotations import matrix
from ...base.style import LIGHT, Theme, channels
from ..scene.camera import Lens, length_text, round_down, window
from ..scene.drawing import DEFAULT_LAYERS, Drawing, Tag
from ..scene.overlays import Trace
from .shading import SEAM_WIDTH, Items, Pointers, Solids, join, outlines, split_strokes, strokes_as_items

POINTS_PER_INCH = 72.0  # [points/inch]
TRIANGLE_SIZE_MAX = 0.045  # [sizes of what is seen] of the longest triangle or stroke

ARROW_LIFT = 1e3  # [sizes of what is seen] by which arrows are painted as if nearer: most start within solids
PEN, LINK, AXIS, PATH = 0.7, 1.6, 1.0, 1.3  # line widths [points]
SIZE, GAP = 9.0, 7.0  # of the letters of names, and from a name to its point [points]
NONE = np.empty((0, 3))  # no points
VECTOR_STROKES_MAX = 3000  # [1] more triangles and strokes than this are painted as an image, also in a vector file


def tone(colour: str) -> np.ndarray:
    """Return the colour "#rrggbb" (3,) as matplotlib counts, 0 ... 1."""
    return channels(colour) / 255.0


def shadow_on(sheet: Theme) -> np.ndarray:
    """Return the colour of shadows on a paper."""
    paper = tone(sheet.paper)
    return paper * (0.93 if paper.mean() > 0.5 else 0.6)


class Mosaic(Artist):
    """Many plain triangles and bars (k, 4, 2), one after the other; an image, four times as fast as paths.

    Agg widens each by half a pixel, so no seam shows.
    """

    zorder = 3

    def __init__(self, polygons: np.ndarray, fill: np.ndarray, bars: np.ndarray) -> None:
        super().__init__()
        halves = np.stack([polygons[:, :3], polygons[:, [0, 2, 3]]], axis=1)
        kept = np.stack([np.ones_like(bars), bars], axis=1)  # the second half of a triangle is empty
        self.triangles = halves[kept]
        self.colours = np.ones((len(self.triangles), 3, 4))
        self.colours[..., :3] = np.repeat(fill, 1 + bars, axis=0)[:, None]
        self.set_rasterized(True)

    @allow_rasterization  # type: ignore[untyped-decorator]  # of matplotlib
    def draw(self, renderer: RendererBase) -> None:
        """Draw all polygons and bars by one call."""
        gc = renderer.new_gc()
        corners = self.get_transform().transform(self.triangles.reshape(-1, 2)).reshape(-1, 3, 2)
        renderer.draw_gouraud_triangles(gc, corners, self.colours, IdentityTransform())
        gc.restore()


class Painter:
    """Painter of poses of one drawing through one lens on sheets of one size."""

    def __init__(
        self,
        drawing: Drawing,
        lens: Lens,
        r: np.ndarray,  # (frames, n + 1, 3), with e all poses that must fit on the paper
        e: np.ndarray,  # (frames, n + 1, 4)
        inches: tuple[float, float],  # width and height of the paper
        *,
        sheet: Theme = LIGHT,
        layers: Collection[str] = DEFAULT_LAYERS,  # "ground grid" is the floor with its grid and the shadows
        also: np.ndarray = NONE,  # (k, 3) more points that must fit, world [m]: paths, tips of arrows
        fine: float = TRIANGLE_SIZE_MAX,  # longest triangle or stroke, of the size of all that is seen
        floor: float | None = None,  # height of the ground [m]; None = that of the lowest point
    ) -> None:
        self.lens, self.sheet, self.inches, self.ground = lens, sheet, inches, "ground grid" in layers
        hues = dict(zip(LIGHT.lines, sheet.lines, strict=True))
        pieces = [p._replace(colour=hues.get(p.colour, p.colour)) for p in drawing.pieces if p.layer in layers]
        self.wires = [w._replace(colour=hues.get(w.colour, w.colour)) for w in drawing.wires if w.layer in layers]
        self.tags = [tag for tag in drawing.tags if tag.layer in layers]
        self.links = drawing.links if "springs and rods" in layers else []
        points = [also]
        R = matrix(e)
        for body, local in [(p.body, p.mesh.vertices) for p in pieces] + [(w.body, w.points) for w in self.wires]:
            points.append((local @ R[:, body].transpose(0, 2, 1) + r[:, None, body]).reshape(-1, 3))
        for link in self.links:
            points += link.placed(lambda body, point: R[:, body] @ point + r[:, body])
        cloud = np.concatenate([*points, r.reshape(-1, 3)[:1]])
        cloud = cloud[np.isfinite(cloud).all(axis=1)]
        self.low, self.high = cloud.min(axis=0), cloud.max(axis=0)
        self.floor = self.low[2] if floor is None else floor
        self.size = float((self.high - self.low).max()) or drawing.size or 1.0
        if self.ground:  # the shadows belong to the picture
            cloud = np.concatenate([cloud, cloud * (1.0, 1.0, 0.0) + (0.0, 0.0, self.floor)])
        self.longest = fine * self.size
        self.solids = Solids(pieces, self.longest)
        self.corner, opposite = window(lens.project(cloud)[0], inches)
        self.scale = (
            POINTS_PER_INCH * inches[0] / (opposite - self.corner)[0]
        )  # points of the paper per unit of the projection
        self.cell = round_down(0.22 * self.size)

    def gone(self, way: np.ndarray) -> Self:
        """Return the painter whose eye has gone a way (3,) [m]; the ground stays where it is."""
        other = copy.copy(self)
        other.lens = self.lens._replace(eye=self.lens.eye + way)
        other.low, other.high = self.low + way, self.high + way
        return other

    def on_paper(self, points: np.ndarray) -> np.ndarray:
        """Return world points (..., 3) as points of the paper (..., 2), 1/72 inch from the lower left corner."""
        return (self.lens.project(points)[0] - self.corner) * self.scale

    def items(self, r: np.ndarray, e: np.ndarray) -> Items:
        """Return solids, wires and links at a pose (n + 1, 3), (n + 1, 4)."""
        R = matrix(e)
        found = [self.solids.placed(r, R, self.lens, PEN)]
        for wire in self.wires:
            points = wire.points @ R[wire.body].T + r[wire.body]
            segments = np.stack([points[:-1], points[1:]], axis=1)
            strokes = self.strokes(segments[np.isfinite(segments).all(axis=(1, 2))], wire.colour, AXIS)
            found.append(strokes._replace(lift=strokes.lift - self.longest))  # what lies within a solid stays hidden
        for link in self.links:
            ends = np.array(link.placed(lambda body, point: R[body] @ point + r[body]))
            found.append(self.strokes(ends[None], self.sheet.muted, LINK))
        return join(found)

    def strokes(self, strokes: np.ndarray, colour: str, pen: float) -> Items:
        """Return straight lines (k, 2, 3) as items."""
        return strokes_as_items(split_strokes(strokes, self.longest)[0], tone(colour), pen, 0.0)

    def paint(
        self,
        axes: Axes,
        poses: Sequence[tuple[np.ndarray, np.ndarray]],
        *,
        traces: Sequence[Trace] = (),
        arrows: Sequence[Pointers] = (),
    ) -> None:
        """Paint poses (r, e) on top of each other, paths as far as their points go, and arrows with their legend.

        Paths seen from a body are drawn where its last pose has it. The axes get the paper's units of 1/72 inch; names
        belong to the last pose.
        """
        width, height = POINTS_PER_INCH * self.inches[0], POINTS_PER_INCH * self.inches[1]
        axes.set(xlim=(0, width), ylim=(0, height))
        axes.set_axis_off()
        found = [self.items(r, e) for r, e in poses]
        for items in (arrow.items(self.longest) for arrow in arrows):
            found.append(items._replace(lift=items.lift + ARROW_LIFT * self.size))
        if self.ground:
            shadows = [self.solids.shadow(r, matrix(e), self.floor) for r, e in poses]
            self.paint_ground(axes, np.concatenate(shadows))
        for trace in traces:
            points = trace.at(*poses[-1])
            strokes = np.stack([points[:-1], points[1:]], axis=1)
            found.append(self.strokes(strokes, trace.colour, PATH))
        self.paint_items(axes, join(found))
        self.paint_directions(axes)
        self.write_names(axes, *poses[-1])
        for k, (legend, colour) in enumerate(dict.fromkeys((arrow.legend, arrow.colour) for arrow in arrows)):
            tint = self.readable(colour)
            axes.text(width - 8, height - 8 - 11 * k, legend, ha="right", va="top", fontsize=8, color=tint)

    def paint_items(self, axes: Axes, items: Items) -> None:
        """Paint the items before the eye, from far to near."""
        seen = self.lens.before(items.corners)
        items = Items(*(field[seen] for field in items))
        depth = self.lens.project(items.corners)[1].mean(axis=1) - items.lift
        order = np.argsort(-depth, kind="stable")
        pen = items.width[order] > 0.0
        polygons = outlines(self.on_paper(items.corners[order]), items.width[order])
        fill = items.fill[order]
        if len(order) > VECTOR_STROKES_MAX:
            axes.add_artist(Mosaic(polygons, fill, pen))
            return
        drawn = PolyCollection(
            polygons,  # type: ignore[arg-type]  # matplotlib takes arrays too
            facecolors=fill, edgecolors=fill, linewidths=SEAM_WIDTH, joinstyle="round", zorder=3,
        )  # fmt: skip
        drawn.set_antialiased(pen.tolist())  # the paper must not shine through between triangles
        axes.add_collection(drawn, autolim=False)

    def paint_ground(self, axes: Axes, shadows: np.ndarray) -> None:
        """Paint a grid that fades into the paper, the size of its cells, and shadows under a high sun."""
        floor, paper, grid = self.floor, tone(self.sheet.paper), tone(self.sheet.grid)
        shade = shadow_on(self.sheet)
        axes.add_collection(
            PolyCollection(
                self.on_paper(shadows[self.lens.before(shadows)]),  # type: ignore[arg-type]  # as above
                facecolors=[shade], edgecolors=[shade], linewidths=0.4, zorder=1,
            ),
            autolim=False,
        )  # fmt: skip
        middle, reach = 0.5 * (self.low + self.high)[:2], 0.75 * self.size + self.cell
        first, last = np.floor((middle - reach) / self.cell), np.ceil((middle + reach) / self.cell)
        strokes = []
        for i, j in ((0, 1), (1, 0)):
            for x in np.arange(first[i], last[i] + 1):
                line = np.full((2, 3), floor)
                line[:, i], line[:, j] = x * self.cell, (first[j] * self.cell, last[j] * self.cell)
                strokes.append(line)
        short, _ = split_strokes(np.array(strokes), 0.25 * self.cell)
        far = np.linalg.norm(short.mean(axis=1)[:, :2] - middle, axis=1) / reach
        seen = (far < 1.0) & self.lens.before(short)
        short, far = short[seen], far[seen]
        tints = grid + (paper - grid) * np.clip(1.6 * far - 0.6, 0.0, 1.0)[:, None]
        axes.add_collection(
            LineCollection(
                self.on_paper(short),  # type: ignore[arg-type]  # as above
                colors=tints, linewidths=0.6, zorder=2, capstyle="butt",
            ),
            autolim=False,
        )  # fmt: skip
        edge, text = POINTS_PER_INCH * self.inches[0] - 8, f"grid {length_text(self.cell)}"
        axes.text(edge, 7, text, ha="right", va="bottom", fontsize=8, color=self.sheet.muted)

    def paint_directions(self, axes: Axes) -> None:
        """Paint the axes of the world in the corner, as they lie in the middle of the picture."""
        for k, name in enumerate("xyz"):
            tip = 20.0 * self.lens.axes[:2, k]
            axes.plot(*np.array([(26.0, 24.0), tip + (26.0, 24.0)]).T, color=self.sheet.muted, linewidth=1.0, zorder=4)
            x, y = 1.32 * tip + (26.0, 24.0)
            axes.text(x, y, name, ha="center", va="center", fontsize=7.5, color=self.sheet.muted, zorder=5)

    def write_names(self, axes: Axes, r: np.ndarray, e: np.ndarray) -> None:
        """Write names of bodies above their points and of joints below them; those at one point share a line.

        Points that are not on the paper have none: the camera follows another body.
        """
        R = matrix(e)
        paper = POINTS_PER_INCH * np.array(self.inches)
        lines: list[tuple[Tag, np.ndarray, list[str]]] = []
        for tag in self.tags:
            place = R[tag.body] @ tag.point + r[tag.body]
            point = self.on_paper(place)
            if not (self.lens.before(place[None]) and (point > 0.0).all() and (point < paper).all()):
                continue
            same = [texts for first, at, texts in lines if first.layer == tag.layer and np.abs(at - point).max() < SIZE]
            if same:
                same[0].append(tag.text)
            else:
                lines.append((tag, point, [tag.text]))
        halo = [withStroke(linewidth=2.4, foreground=self.sheet.paper)]
        for tag, (x, y), texts in lines:
            text = ", ".join(texts)
            half = min(
                0.3 * SIZE * len(text), 0.5 * POINTS_PER_INCH * self.inches[0]
            )  # about that: it stays on the paper
            x = np.clip(x, half, POINTS_PER_INCH * self.inches[0] - half)
            side, va = (1.0, "bottom") if tag.layer == "body names" else (-1.0, "top")
            tint = self.readable(tag.colour)
            axes.text(
                x, y + side * GAP, text, color=tint, fontsize=SIZE, ha="center", va=va, path_effects=halo, zorder=5
            )

    def write_note(self, axes: Axes, text: str) -> None:
        """Write a line in the upper left corner."""
        axes.text(8, POINTS_PER_INCH * self.inches[1] - 8, text, ha="left", va="top", fontsize=9, color=self.sheet.ink)

    def readable(self, colour: str) -> np.ndarray:
        """Return a colour moved towards the ink, for letters."""
        return 0.6 * tone(colour) + 0.4 * tone(self.sheet.ink)


def new_sheet(inches: tuple[float, float], sheet: Theme) -> tuple[Figure, Axes]:
    """Return an empty figure and axes that fill it."""
    figure = Figure(figsize=inches, facecolor=sheet.paper)
    return figure, figure.add_axes((0.0, 0.0, 1.0, 1.0))
