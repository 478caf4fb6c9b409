"""The scene of viser made from a drawing: bodies as frames with their meshes, arrows, links, traces, a ground grid.

Node "/bodies/<i>" is the frame of body ``i``, so that one message pair moves all of it. Lengths in the scene are metres
times ``Stage.scale``, a power of ten that makes every mechanism some units large: light and clipping are made for that.
Arrows, rods and springs of one kind are copies of one mesh in one node, laid along vectors.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ...base.rotations import matrix
from ...base.style import CELLS, GREY, SHADED, channels, linear, paler, rgb
from ...mechanism.shapes import Mesh
from ...mechanism.shapes.surfaces import joined
from ..scene.camera import frame_camera, round_up
from ..scene.drawing import LAYERS, USUAL, Drawing, Link, bounds
from ..scene.frames import Frames
from ..scene.meshes import ROD, SLENDER, Z, arrow, laid, unit_coil, unit_or_z, unit_rod, with_shade
from ..scene.motion import Arrows, Trace
from .recorder import printable

if TYPE_CHECKING:
    from viser import InitialCameraConfig, SceneApi, SceneNodeHandle

FOV = 0.7  # vertical [rad]
SUN = (-0.5, -1.5, 3.0)  # towards it
LONGEST = 0.4  # of the mechanism's size: the longest arrow of each kind
NOTHING = 1e-9  # what is taken for a length of zero: scales of zero have no inverse


class Links:
    """Springs as coils or joints as rods; all of a kind are one node of the scene.

    Each turns from its mean direction over the run by the smallest rotation, so that coils do not spin.
    """

    def __init__(
        self, scene: "SceneApi", name: str, links: Sequence[Link], frames: Frames, size: float, scale: float
    ) -> None:
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


def add_copies(scene: "SceneApi", name: str, mesh: Mesh, colours: np.ndarray, count: int) -> "SceneNodeHandle":
    """A node of ``count`` copies of a mesh, still without a place; colours (3,) or (count, 3), 0 ... 255."""
    still = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)), np.zeros((count, 3))
    scales = np.full((count, 3), NOTHING)
    tints = np.rint(255.0 * linear(colours / 255.0)).astype(np.uint8)  # viser takes those of copies as they are
    return scene.add_batched_meshes_simple(
        name, mesh.vertices, mesh.faces, *still, batched_scales=scales, batched_colors=tints, lod="off", side="double"
    )


def lay(
    node: "SceneNodeHandle",
    points: np.ndarray,
    vectors: np.ndarray,
    scale: float,
    radii: np.ndarray | None = None,
    rest: np.ndarray = Z,
) -> None:
    """Lay the copies along vectors (k, 3) [m] from points: as wide as they are long, or of given radii [m]."""
    length = np.sqrt((vectors**2).sum(axis=1))
    wide = length if radii is None else radii
    node.batched_positions = (points * scale).astype(np.float32)
    node.batched_wxyzs = laid(vectors, rest).astype(np.float32)
    node.batched_scales = (np.column_stack([wide, wide, length]) * scale + NOTHING).astype(np.float32)


@dataclass
class Stage:
    """Handles of what was drawn, to move and to hide it."""

    scale: float  # scene units per metre
    cell: float  # of the ground grid [m]
    bodies: list["SceneNodeHandle"] = field(default_factory=list)
    layers: dict[str, list["SceneNodeHandle"]] = field(default_factory=lambda: {name: [] for name in LAYERS})
    links: list[Links] = field(default_factory=list)
    arrows: list["SceneNodeHandle"] = field(default_factory=list)
    factors: list[float] = field(default_factory=list)  # metres per unit of each kind of arrows
    traces: list["SceneNodeHandle"] = field(default_factory=list)  # the passed part of each
    shown: Sequence[str] = USUAL  # layers that are shown first
    distance: float = 0.0  # of the first view [m]

    def move(self, r: np.ndarray, e: np.ndarray) -> None:
        """Bring bodies (r (n + 1, 3), e (n + 1, 4)) and links to a pose."""
        for body, position, orientation in zip(self.bodies, r, e, strict=True):
            body.position, body.wxyz = position * self.scale, orientation
        for links in self.links:
            links.move(r, e)

    def point(self, kind: int, points: np.ndarray, vectors: np.ndarray) -> None:
        """Let the arrows of one kind show vectors (k, 3) at points (k, 3)."""
        lay(self.arrows[kind], points, vectors * self.factors[kind], self.scale)

    def show(self, layer: str, visible: bool) -> None:
        """Show or hide a layer."""
        for node in self.layers[layer]:
            node.visible = visible


def build_stage(
    scene: "SceneApi",
    camera: "InitialCameraConfig",
    drawing: Drawing,
    frames: Frames,
    arrows: Sequence[Arrows] = (),
    traces: Sequence[Trace] = (),
    shown: Sequence[str] = USUAL,
    *,
    near: bool = False,
) -> Stage:
    """Draw everything at the first frame, in the scene of a server of viser or of a `Recording`.

    ``shown``: the layers that are visible first; ``near``: the camera frames the mechanism at the first frame only.
    """
    low, high = bounds(drawing, frames.r, frames.e)
    box = bounds(drawing, frames.r[:1], frames.e[:1]) if near else (low, high)
    extent = max(float((box[1] - box[0]).max()), 1e-9)
    cell = round_up(extent / 10.0)
    stage = Stage(10.0 ** -np.floor(np.log10(drawing.size / 0.5)), cell, shown=shown)
    for i, (position, orientation) in enumerate(zip(frames.r[0], frames.e[0], strict=True)):
        node = scene.add_frame(f"/bodies/{i}", show_axes=False, position=position * stage.scale, wxyz=orientation)
        stage.bodies.append(node)
    add_pieces(scene, stage, drawing)
    add_wires(scene, stage, drawing)
    add_tags(scene, stage, drawing)
    for name, spring in (("/springs", True), ("/rods", False)):
        if some := [link for link in drawing.links if link.spring == spring]:
            stage.links.append(Links(scene, name, some, frames, drawing.size, stage.scale))
            stage.layers["springs and rods"].append(stage.links[-1].node)
    for i, kind in enumerate(arrows):
        add_arrows(scene, stage, i, kind, drawing.size)
    for i, trace in enumerate(traces):
        add_trace(scene, stage, i, trace)
    add_grid(scene, stage, drawing, low, high)
    for layer in stage.layers:
        if layer not in stage.shown:  # nodes are visible when they are made
            stage.show(layer, False)
    light(scene)
    aim(camera, stage, *box)
    scene.add_frame("/ready", show_axes=False)  # the last one: when it is there, all is
    return stage


def aim(camera: "InitialCameraConfig", stage: Stage, low: np.ndarray, high: np.ndarray) -> None:
    """Let the first view hold the whole box."""
    seen = frame_camera(low, high, FOV)
    stage.distance = seen.distance
    camera.position, camera.look_at = seen.position * stage.scale, seen.look_at * stage.scale
    camera.fov, camera.near = FOV, float(seen.distance * stage.scale) * 1e-3
    camera.far = float(seen.distance * stage.scale) * 1e3


def light(scene: "SceneApi") -> None:
    """Even light with one sun: viser's own, of a photographed place, makes orange yellow."""
    scene.configure_environment_map(None)
    scene.configure_default_lights(False)
    scene.add_light_hemisphere("/sky", sky_color=(255, 255, 255), ground_color=(205, 205, 205), intensity=3.0)
    scene.add_light_directional("/sun", intensity=2.8, cast_shadow=True, position=SUN)


def add_pieces(scene: "SceneApi", stage: Stage, drawing: Drawing) -> None:
    """One mesh for all pieces of a body that share layer, colour and shade."""
    groups: dict[tuple, list[Mesh]] = {}
    for piece in drawing.pieces:
        for shade in (0, 1):
            if (piece.mesh.shade == shade).any():
                key = piece.body, piece.layer, piece.colour, shade
                groups.setdefault(key, []).append(with_shade(piece.mesh, shade))
    for k, ((body, layer, colour, shade), parts) in enumerate(groups.items()):
        mesh, tint = joined(*parts), rgb(colour, SHADED if shade else 1.0)
        place = f"/bodies/{body}/mesh{k}"
        node = scene.add_mesh_simple(place, mesh.vertices * stage.scale, mesh.faces, color=tint, side="double")
        stage.layers[layer].append(node)


def add_wires(scene: "SceneApi", stage: Stage, drawing: Drawing) -> None:
    """One set of segments for all wires of a body that share layer and colour."""
    groups: dict[tuple, list[np.ndarray]] = {}
    for wire in drawing.wires:
        segments = np.stack([wire.points[:-1], wire.points[1:]], axis=1)
        segments = segments[np.isfinite(segments).all(axis=(1, 2))] * stage.scale
        if len(segments):
            groups.setdefault((wire.body, wire.layer, wire.colour), []).append(segments)
    for k, ((body, layer, colour), parts) in enumerate(groups.items()):
        name = f"/bodies/{body}/wire{k}"
        node = scene.add_line_segments(
            name, np.concatenate(parts), rgb(colour), thickness=2.0, thickness_units="screen"
        )
        stage.layers[layer].append(node)


def add_tags(scene: "SceneApi", stage: Stage, drawing: Drawing) -> None:
    """Names, fixed in their bodies."""
    for k, tag in enumerate(drawing.tags):
        place, name = tag.point * stage.scale, f"/bodies/{tag.body}/name{k}"
        node = scene.add_label(name, printable(tag.text), position=place, anchor="bottom-center")
        stage.layers[tag.layer].append(node)


def add_arrows(scene: "SceneApi", stage: Stage, i: int, kind: Arrows, size: float) -> None:
    """Arrows of one kind."""
    stage.factors.append(LONGEST * size / kind.longest if kind.longest > 0.0 else 0.0)
    tints = np.array([channels(tint) for tint in kind.tints])
    node = add_copies(scene, f"/arrows/{i}", arrow(kind.heads), tints, len(kind.names))
    stage.arrows.append(node)
    stage.layers[kind.kind].append(node)
    stage.point(i, kind.points[0], kind.vectors[0])


def add_trace(scene: "SceneApi", stage: Stage, i: int, trace: Trace) -> None:
    """The whole path, pale, and the part that was passed, strong."""
    segments = np.stack([trace.points[:-1], trace.points[1:]], axis=1) * stage.scale
    if not len(segments):
        return
    for name, colour, width in (("path", rgb(paler(trace.colour)), 1.5), ("passed", rgb(trace.colour), 3.0)):
        node = scene.add_line_segments(
            f"/traces/{i}/{name}", segments, colour, thickness=width, thickness_units="screen"
        )
        stage.layers["traces"].append(node)
    stage.traces.append(node)


def add_grid(scene: "SceneApi", stage: Stage, drawing: Drawing, low: np.ndarray, high: np.ndarray) -> None:
    """A ground grid whose lines are at round coordinates."""
    thin, thick = CELLS["light"]
    cell, span = stage.cell, float((high - low)[:2].max())
    count = 2.0 * np.ceil(0.75 * span / cell + 1.0)
    middle = np.round(0.5 * (low + high)[:2] / cell) * cell
    node = scene.add_grid(
        "/grid", count * cell * stage.scale, count * cell * stage.scale, cell_size=cell * stage.scale,
        section_size=5.0 * cell * stage.scale, position=np.array([*middle, min(drawing.floor, low[2])]) * stage.scale,
        cell_color=(thin,) * 3, section_color=(thick,) * 3, shadow_opacity=0.25,
        fade_distance=max(100.0, 4.0 * frame_camera(low, high, FOV).distance * stage.scale),  # 100: viser's own
    )  # fmt: skip
    stage.layers["ground grid"].append(node)
