"""The scene of viser made from a drawing: bodies as frames with their meshes, arrows, traces, a ground grid.

Node "/bodies/<i>" is the frame of body ``i``, so that one message pair moves all of it. Lengths in the scene are metres
times ``Stage.scale``, a power of ten that makes every mechanism some units large: light and clipping are made for that.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .drawing import Drawing, bounds, frame_camera
from .meshes import alone, arrow, creased, tint
from .motion import Arrows, Frames, Trace
from .sticks import Links, add_copies, lay

FEW = 12  # bodies whose names do not hide the picture
FOV = 0.7  # vertical [rad]
SUN = (-0.5, -1.5, 3.0)  # direction it stands in
LONGEST = 0.4  # of the mechanism's size: the longest arrow of each kind
NAMED = {"body": "body names", "joint": "joint names"}
LAYER = {"body": "bodies", "joint": "joints"}  # what a switch is called, where a piece's layer is singular
SHOWN = ("bodies", "joints", "springs and rods", "traces", "ground grid")
ALL = (
    "bodies", "body names", "joints", "joint names", "springs and rods", "traces", "ground grid", "angular velocity",
    "angular momentum", "reaction force", "reaction moment", "centre of mass", "reference point",
)  # fmt: skip


@dataclass
class Stage:
    """Handles of what was drawn, to move and to hide it."""

    scale: float  # scene units per metre
    cell: float  # of the ground grid [m]
    bodies: list[Any] = field(default_factory=list)
    layers: dict[str, list[Any]] = field(default_factory=lambda: {name: [] for name in ALL})
    links: list[Links] = field(default_factory=list)
    arrows: list[Any] = field(default_factory=list)
    factors: list[float] = field(default_factory=list)  # metres per unit of each kind of arrows
    traces: list[Any] = field(default_factory=list)  # the passed part of each
    shown: tuple[str, ...] = SHOWN  # layers that are shown first

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
    scene: Any,
    camera: Any,
    drawing: Drawing,
    frames: Frames,
    arrows: Sequence[Arrows] = (),
    traces: Sequence[Trace] = (),
    shown: Sequence[str] = (),
) -> Stage:
    """Draw everything at the first frame.

    Parameters
    ----------
    scene, camera : viser's ``server.scene`` and ``server.initial_camera``, or those of a `Recording`
    drawing, frames, arrows, traces : what is drawn and how it moves; the camera frames all of it
    shown : layers to show besides the usual ones

    Returns
    -------
    Stage
        Scale and handles.
    """
    low, high = bounds(drawing, frames.r, frames.e)
    extent = max(float((high - low).max()), 1e-9)
    cell = round_length(extent / 10.0)
    stage = Stage(10.0 ** -np.floor(np.log10(drawing.size / 0.5)), cell)
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
    if len(stage.bodies) - 1 <= FEW:
        stage.shown = (*SHOWN, "body names")
    stage.shown = (*stage.shown, *shown)
    for layer in stage.layers:
        stage.show(layer, layer in stage.shown)
    light(scene)
    aim(camera, stage, low, high)
    scene.add_frame("/ready", show_axes=False)  # the last one: when it is there, all is
    return stage


def aim(camera: Any, stage: Stage, low: np.ndarray, high: np.ndarray) -> None:
    """Let the first view hold the whole motion."""
    seen = frame_camera(low, high, FOV)
    camera.position, camera.look_at = seen.position * stage.scale, seen.look_at * stage.scale
    camera.fov, camera.near = FOV, float(seen.distance * stage.scale) * 1e-3
    camera.far = float(seen.distance * stage.scale) * 1e3


def light(scene: Any) -> None:
    """Even light with one sun: viser's own, of a photographed place, makes orange yellow."""
    scene.configure_environment_map(None)
    scene.configure_default_lights(False)
    scene.add_light_hemisphere("/sky", sky_color=(255, 255, 255), ground_color=(205, 205, 205), intensity=3.0)
    scene.add_light_directional("/sun", intensity=2.8, cast_shadow=True, position=SUN)


def add_pieces(scene: Any, stage: Stage, drawing: Drawing) -> None:
    """One mesh for all pieces of a body that share layer, colour and shade."""
    if not drawing.pieces:
        return
    sizes = [len(piece.mesh.vertices) for piece in drawing.pieces]
    starts = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    vertices = np.concatenate([piece.mesh.vertices for piece in drawing.pieces]) * stage.scale
    faces = np.concatenate([piece.mesh.faces + k for piece, k in zip(drawing.pieces, starts, strict=True)])
    vertices, faces = creased(vertices, faces)
    groups: dict[tuple, list[np.ndarray]] = {}
    first = 0
    for piece in drawing.pieces:
        own, first = faces[first : first + len(piece.mesh.faces)], first + len(piece.mesh.faces)
        for shade in (0, 1):
            some = own[piece.mesh.shade == shade]
            if len(some):
                groups.setdefault((piece.body, piece.layer, piece.colour, shade), []).append(some)
    for k, ((body, layer, colour, shade), parts) in enumerate(groups.items()):
        name, rgb = f"/bodies/{body}/mesh{k}", tint(colour, shade)
        node = scene.add_mesh_simple(name, *alone(vertices, np.concatenate(parts)), color=rgb, side="double")
        stage.layers[LAYER.get(layer, layer)].append(node)


def add_wires(scene: Any, stage: Stage, drawing: Drawing) -> None:
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
            name, np.concatenate(parts), tint(colour), thickness=2.0, thickness_units="screen"
        )
        stage.layers[LAYER.get(layer, layer)].append(node)


def add_tags(scene: Any, stage: Stage, drawing: Drawing) -> None:
    """Names, fixed in their bodies."""
    for k, tag in enumerate(drawing.tags):
        text = tag.text.encode("utf-8", "replace").decode("utf-8")
        node = scene.add_label(
            f"/bodies/{tag.body}/name{k}", text, position=tag.point * stage.scale, anchor="bottom-center"
        )
        stage.layers[NAMED[tag.layer]].append(node)


def heads_of(kind: Arrows) -> int:
    """Two for axial vectors (rotations, moments), one for forces."""
    return 1 if kind.kind == "reaction force" else 2


def add_arrows(scene: Any, stage: Stage, i: int, kind: Arrows, size: float) -> None:
    """Arrows of one kind; those of axial vectors have two heads, as on paper, and uncertain ones are pale."""
    longest = float(np.sqrt((kind.vectors**2).sum(axis=-1)).max())
    stage.factors.append(LONGEST * size / longest if longest > 0.0 else 0.0)
    colours = np.array([tint(kind.colour, pale=uncertain) for uncertain in kind.uncertain])
    node = add_copies(scene, f"/arrows/{i}", *arrow(heads_of(kind)), len(kind.names), colours)
    stage.arrows.append(node)
    stage.layers[kind.kind].append(node)
    stage.point(i, kind.points[0], kind.vectors[0])


def add_trace(scene: Any, stage: Stage, i: int, trace: Trace) -> None:
    """The whole path, pale, and the part that was passed, strong."""
    segments = np.stack([trace.points[:-1], trace.points[1:]], axis=1) * stage.scale
    if not len(segments):
        return
    for name, colour, width in (("path", tint(trace.colour, pale=True), 1.5), ("passed", tint(trace.colour), 3.0)):
        node = scene.add_line_segments(
            f"/traces/{i}/{name}", segments, colour, thickness=width, thickness_units="screen"
        )
        stage.layers["traces"].append(node)
    stage.traces.append(node)


def add_grid(scene: Any, stage: Stage, drawing: Drawing, low: np.ndarray, high: np.ndarray) -> None:
    """A ground grid whose lines are at round coordinates."""
    cell, span = stage.cell, float((high - low)[:2].max())
    count = 2.0 * np.ceil(0.75 * span / cell + 1.0)
    middle = np.round(0.5 * (low + high)[:2] / cell) * cell
    node = scene.add_grid(
        "/grid", count * cell * stage.scale, count * cell * stage.scale, cell_size=cell * stage.scale,
        section_size=5.0 * cell * stage.scale, position=np.array([*middle, min(drawing.floor, low[2])]) * stage.scale,
        cell_color=(190, 190, 190), section_color=(150, 150, 150), shadow_opacity=0.25,
        fade_distance=max(100.0, 4.0 * frame_camera(low, high, FOV).distance * stage.scale),  # 100: viser's own
    )  # fmt: skip
    stage.layers["ground grid"].append(node)


def round_length(length: float) -> float:
    """1, 2 or 5 times a power of ten, not below ``length``."""
    decade = 10.0 ** np.floor(np.log10(length))
    return float(f"{next(factor * decade for factor in (1.0, 2.0, 5.0, 10.0) if factor * decade >= length):.1g}")
