"""Scene of viser from a drawing: bodies as frames with their meshes, arrows, links, traces, a ground grid.

Node "/bodies/<i>" is the frame of body ``i``, so that one message pair moves all of it. Lengths in the scene are metres
times ``Stage.scale``, a power of ten that makes every mechanism some units large: light and clipping are made for that.
Arrows, rods and springs of one kind are copies of one mesh in one node, laid along vectors.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...base.rotations import matrix
from ...base.style import GREY, GROUND_GRID_GREYS, SECTOR_BRIGHTNESS, channels, linear, muted_colour, rgb
from ...mechanism.shapes import Mesh
from ..scene.camera import directions, frame_camera, round_up, sight
from ..scene.drawing import DEFAULT_LAYERS, LAYERS, WORLD_AXES, Drawing, Link, bounds
from ..scene.frames import Frames
from ..scene.meshes import (
    COIL_RADIUS_RATIO,
    ROD_RADIUS_RATIO,
    Z_AXIS,
    arrow,
    laid,
    unit_coil,
    unit_or_z,
    unit_rod,
)
from ..scene.nodes import ghost_nodes, mesh_nodes, wire_nodes
from ..scene.overlays import Arrows, Trace, moved
from .recorder import printable

if TYPE_CHECKING:
    from viser import BatchedMeshHandle, InitialCameraConfig, LineSegmentsHandle, SceneApi, SceneNodeHandle

FIELD_OF_VIEW = 0.7  # [rad] vertical
GROUND_FADE_DISTANCE = 12.0  # [camera distances] at which an endless ground has faded
GHOST_COLOUR, GHOST_OPACITY = (120, 130, 145), 0.3  # of the bodies of another motion
SUN_DIRECTION = (-0.5, -1.5, 3.0)  # [1] towards the sun
ARROW_LENGTH_SHARE = 0.4  # [sizes of the mechanism] of the longest arrow of each kind
# [cells] of the ground grid along what is seen, and of a ground without an edge
GRID_CELLS_COUNT, ENDLESS_GRID_CELLS_COUNT = 10.0, 2.5
BOX_HALF_SIDE_RATIO = 0.75  # [1] half the side of a box over the radius of a ball that fills the same view
SCALE_MIN = 1e-9  # [1] scale that stands for zero, which has no inverse

Box = tuple[np.ndarray, np.ndarray]  # lowest and highest corner (3,) [m]


class Reach(NamedTuple):
    """Space that a view must hold, and lengths that scale its arrows."""

    world: Box
    seen: Box  # along the directions of the view
    longest: Mapping[str, float]  # arrow of each kind


class Links:
    """Springs as coils or joints as rods; all of a kind are one node of the scene.

    Each turns from its mean direction over the run by the smallest rotation, so that coils do not spin.
    """

    def __init__(
        self, scene: "SceneApi", name: str, links: Sequence[Link], frames: Frames, size: float, scale: float
    ) -> None:
        self.links, self.scale = links, scale
        ends = [link.placed(partial(moved, frames)) for link in links]
        spans = np.stack([end - start for start, end in ends], axis=1)
        lengths = np.sqrt((spans**2).sum(axis=-1)).mean(axis=0)
        spring = links[0].spring
        self.radii = np.maximum(COIL_RADIUS_RATIO * lengths if spring else 0.0, ROD_RADIUS_RATIO * size) + 0.0 * lengths
        self.rest = unit_or_z(spans.sum(axis=0))
        mesh = unit_coil() if spring else unit_rod()
        self.node = add_copies(scene, name, mesh, channels(GREY), len(links))
        self.move(frames.r[0], frames.e[0])

    def move(self, r: np.ndarray, e: np.ndarray) -> None:
        """Place the links between their ends at a pose."""
        ends = np.array([link.placed(lambda k, p: r[k] + matrix(e[k]) @ p) for link in self.links])
        lay(self.node, ends[:, 0], ends[:, 1] - ends[:, 0], self.scale, self.radii, self.rest)


def add_copies(scene: "SceneApi", name: str, mesh: Mesh, colours: np.ndarray, count: int) -> "BatchedMeshHandle":
    """Add a node of ``count`` copies of a mesh, still without a place; colours (3,) or (count, 3), 0 ... 255."""
    still = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)), np.zeros((count, 3))
    scales = np.full((count, 3), SCALE_MIN)
    tints = np.rint(255.0 * linear(colours / 255.0)).astype(np.uint8)  # viser takes those of copies as they are
    return scene.add_batched_meshes_simple(
        name, mesh.vertices, mesh.faces, *still, batched_scales=scales, batched_colors=tints, lod="off", side="double"
    )


def lay(
    node: "BatchedMeshHandle",
    points: np.ndarray,
    vectors: np.ndarray,
    scale: float,
    radii: np.ndarray | None = None,
    rest: np.ndarray = Z_AXIS,
) -> None:
    """Place the copies along vectors (k, 3) [m] from points: as wide as they are long, or of given radii [m]."""
    length = np.sqrt((vectors**2).sum(axis=1))
    wide = length if radii is None else radii
    node.batched_positions = (points * scale).astype(np.float32)
    node.batched_wxyzs = laid(vectors, rest).astype(np.float32)
    node.batched_scales = (np.column_stack([wide, wide, length]) * scale + SCALE_MIN).astype(np.float32)


class Stage:
    """All that is shown, drawn at the first frame into the scene of a server of viser or of a `Recording`.

    ``shown``: the layers that are visible first; ``near``: the camera frames the mechanism at the first frame only;
    ``endless``: the ground has no edge; ``view``: azimuth and elevation of the first view [degrees], None = the usual;
    ``least``: what a view that is not near holds at least; ``pivot`` (3,): the point about which all may swing, world;
    ``ghost``: there are pale copies of the bodies, hidden at first.
    """

    def __init__(
        self,
        scene: "SceneApi",
        camera: "InitialCameraConfig",
        drawing: Drawing,
        frames: Frames,
        arrows: Sequence[Arrows] = (),
        traces: Sequence[Trace] = (),
        shown: Sequence[str] = DEFAULT_LAYERS,
        *,
        near: bool = False,
        endless: bool = False,
        view: Sequence[float] | None = None,
        least: Reach | None = None,
        pivot: np.ndarray | None = None,
        ghost: bool = False,
    ) -> None:
        axes = directions(view)
        box, seen = boxes(drawing, frames.first if near else frames, shown, axes)  # of what the first view holds
        if pivot is not None:
            least = swing(pivot, *box, axes)
        if least and not near:
            box, seen = around(box, least.world), around(seen, least.seen)
        ground = bounds(drawing, frames.r, frames.e, shown) if near else box
        self.scene, self.shown = scene, shown
        self.scale = float(10.0 ** -np.floor(np.log10(drawing.size / 0.5)))  # scene units per metre
        cells = ENDLESS_GRID_CELLS_COUNT if endless else GRID_CELLS_COUNT
        self.cell = round_up(max(float((box[1] - box[0]).max()), 1e-9) / cells)  # of the ground grid [m]
        self.layers: dict[str, list[SceneNodeHandle]] = {name: [] for name in LAYERS}
        self.bodies = [
            scene.add_frame(f"/bodies/{i}", show_axes=False, position=position * self.scale, wxyz=orientation)
            for i, (position, orientation) in enumerate(zip(frames.r[0], frames.e[0], strict=True))
        ]
        self.add_pieces(drawing)
        if ghost:
            self.add_ghosts(drawing)
        self.add_wires(drawing)
        self.add_tags(drawing)
        self.links: list[Links] = []
        for name, spring in (("/springs", True), ("/rods", False)):
            if some := [link for link in drawing.links if link.spring == spring]:
                self.links.append(Links(scene, name, some, frames, drawing.size, self.scale))
                self.layers["springs and rods"].append(self.links[-1].node)
        longest = [max(x.longest, least.longest.get(x.kind, 0.0) if least else 0.0) for x in arrows]
        self.factors = [ARROW_LENGTH_SHARE * drawing.size / x if x > 0.0 else 0.0 for x in longest]  # m per unit
        self.arrows = [self.add_arrows(i, kind) for i, kind in enumerate(arrows)]
        self.traces: list[LineSegmentsHandle] = []  # the passed part of each
        for i, trace in enumerate(traces):
            self.add_trace(i, trace)
        self.add_grid(*ground, drawing.floor, endless)
        for layer in self.layers:
            if layer not in shown:  # nodes are visible when they are made
                self.show(layer, False)
        self.light()
        self.sight = sight(*seen, axes, FIELD_OF_VIEW, turns=near)  # of the first view
        self.aim(camera)
        scene.add_frame("/ready", show_axes=False)  # the last one: once it exists, so does everything else

    def move(self, r: np.ndarray, e: np.ndarray) -> None:
        """Move bodies (r (n + 1, 3), e (n + 1, 4)) and links to a pose."""
        for body, position, orientation in zip(self.bodies, r, e, strict=True):
            body.position, body.wxyz = position * self.scale, orientation
        for links in self.links:
            links.move(r, e)

    def point(self, kind: int, points: np.ndarray, vectors: np.ndarray) -> None:
        """Set the arrows of one kind to vectors (k, 3) at points (k, 3)."""
        lay(self.arrows[kind], points, vectors * self.factors[kind], self.scale)

    def show(self, layer: str, visible: bool) -> None:
        """Show or hide a layer."""
        for node in self.layers[layer]:
            node.visible = visible

    def add_pieces(self, drawing: Drawing) -> None:
        """Add one mesh for all pieces of a body that share layer, colour and shade."""
        for name, _, layer, colour, shade, mesh in mesh_nodes(drawing):
            tint = rgb(colour, SECTOR_BRIGHTNESS if shade else 1.0)
            node = self.scene.add_mesh_simple(name, mesh.vertices * self.scale, mesh.faces, color=tint, side="double")
            self.layers[layer].append(node)

    def add_ghosts(self, drawing: Drawing) -> None:
        """Add pale copies of the bodies, hidden, for another motion of the same mechanism."""
        for i, body in enumerate(self.bodies[:-1]):
            self.scene.add_frame(f"/ghosts/{i}", show_axes=False, visible=False, position=body.position, wxyz=body.wxyz)
        for i, mesh in ghost_nodes(drawing):
            if i < len(self.bodies) - 1:
                self.scene.add_mesh_simple(
                    f"/ghosts/{i}/mesh", mesh.vertices * self.scale, mesh.faces, color=GHOST_COLOUR,
                    opacity=GHOST_OPACITY, side="double", cast_shadow=False,
                )  # fmt: skip

    def add_wires(self, drawing: Drawing) -> None:
        """Add one set of segments for all wires of a body that share layer and colour."""
        for name, _, layer, colour, segments in wire_nodes(drawing):
            self.add_segments(name, layer, segments, colour, 2.0)

    def add_segments(
        self, name: str, layer: str, segments: np.ndarray, colour: str, width: float
    ) -> "LineSegmentsHandle":
        """Add lines (k, 2, 3) [m], equally wide on the screen wherever they are."""
        node = self.scene.add_line_segments(
            name, segments * self.scale, rgb(colour), thickness=width, thickness_units="screen"
        )
        self.layers[layer].append(node)
        return node

    def add_tags(self, drawing: Drawing) -> None:
        """Add names, fixed in their bodies."""
        for k, tag in enumerate(drawing.tags):
            place, name = tag.point * self.scale, f"/bodies/{tag.body}/name{k}"
            node = self.scene.add_label(name, printable(tag.text), position=place, anchor="bottom-center")
            self.layers[tag.layer].append(node)

    def add_arrows(self, i: int, kind: Arrows) -> "BatchedMeshHandle":
        """Add arrows of one kind, at the first frame."""
        tints = np.array([channels(tint) for tint in kind.tints])
        node = add_copies(self.scene, f"/arrows/{i}", arrow(kind.heads), tints, len(kind.names))
        self.layers[kind.kind].append(node)
        lay(node, kind.points[0], kind.vectors[0] * self.factors[i], self.scale)
        return node

    def add_trace(self, i: int, trace: Trace) -> None:
        """Add the whole path, pale, and the part that was passed, strong."""
        segments = np.stack([trace.points[:-1], trace.points[1:]], axis=1)
        if len(segments):
            place = f"/bodies/{trace.frame}/trace{i}"
            self.add_segments(f"{place}/path", "traces", segments, muted_colour(trace.colour), 1.5)
            self.traces.append(self.add_segments(f"{place}/passed", "traces", segments, trace.colour, 3.0))

    def add_grid(self, low: np.ndarray, high: np.ndarray, floor: float, endless: bool) -> None:
        """Add a ground grid whose lines are at round coordinates."""
        thin, thick = GROUND_GRID_GREYS["light"]
        distance = frame_camera(low, high, FIELD_OF_VIEW).distance * self.scale
        cell, span = self.cell, float((high - low)[:2].max())
        side = 2.0 * np.ceil(0.75 * span / cell + 1.0) * cell * self.scale
        middle = np.round(0.5 * (low + high)[:2] / cell) * cell
        self.ground = [*map(float, middle), float(min(floor, low[2]))]
        node = self.scene.add_grid(
            "/grid", side, side, cell_size=cell * self.scale, section_size=5.0 * cell * self.scale,
            position=np.array(self.ground) * self.scale,
            cell_color=(thin,) * 3, section_color=(thick,) * 3, shadow_opacity=0.25, infinite_grid=endless,
            # 100 is the default of viser
            fade_distance=GROUND_FADE_DISTANCE * distance if endless else max(100.0, 4.0 * distance),
        )  # fmt: skip
        self.layers["ground grid"].append(node)

    def light(self) -> None:
        """Set even light with one sun; viser's default, of a photographed place, makes orange yellow."""
        self.scene.configure_environment_map(None)
        self.scene.configure_default_lights(False)
        self.scene.add_light_hemisphere("/sky", sky_color=(255, 255, 255), ground_color=(205, 205, 205), intensity=3.0)
        self.scene.add_light_directional("/sun", intensity=2.8, cast_shadow=True, position=SUN_DIRECTION)

    def aim(self, camera: "InitialCameraConfig") -> None:
        """Set the first view so that a square window holds a whole box."""
        seen = self.sight.camera()
        distance = float(seen.distance * self.scale)
        camera.position, camera.look_at = seen.position * self.scale, seen.look_at * self.scale
        camera.fov, camera.near, camera.far = FIELD_OF_VIEW, 1e-3 * distance, 1e3 * distance


def boxes(drawing: Drawing, frames: Frames, layers: Sequence[str], axes: np.ndarray) -> tuple[Box, Box]:
    """Return the boxes of some layers in all frames, along the axes of the world and those of a view."""
    r, e = frames.r, frames.e
    return bounds(drawing, r, e, layers, WORLD_AXES), bounds(drawing, r, e, layers, axes)


def around(one: Box, other: Box) -> Box:
    """Return the smallest axis-aligned box that encloses two boxes."""
    return np.minimum(one[0], other[0]), np.maximum(one[1], other[1])


def swing(pivot: np.ndarray, low: np.ndarray, high: np.ndarray, axes: np.ndarray) -> Reach:
    """Return the space round a point on which all that is in a box at first hangs or stands."""
    half = BOX_HALF_SIDE_RATIO * np.linalg.norm(np.maximum(np.abs(low - pivot), np.abs(high - pivot)))
    return Reach((pivot - half, pivot + half), (axes @ pivot - half, axes @ pivot + half), {})
