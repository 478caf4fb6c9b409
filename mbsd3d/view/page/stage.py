"""The scene of viser made from a drawing: bodies as frames with their meshes, arrows, traces, a ground grid.

Node "/bodies/<i>" is the frame of body ``i``, so that one message pair moves all of it. Lengths in the scene are metres
times ``Stage.scale``, a power of ten that makes every mechanism some units large: light and clipping are made for that.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...base.style import CELLS, SHADED, channels, paler, rgb
from ...mechanism.shapes import Mesh
from ...mechanism.shapes.surfaces import joined
from ..scene.camera import frame_camera
from ..scene.drawing import Drawing, bounds
from ..scene.frames import Frames
from ..scene.grid import round_up
from ..scene.layers import LAYERS, USUAL
from ..scene.meshes import with_shade
from ..scene.motion import Arrows, Trace
from ..scene.sticks import arrow
from .copies import Links, add_copies, lay

FOV = 0.7  # vertical [rad]
SUN = (-0.5, -1.5, 3.0)  # direction it stands in
LONGEST = 0.4  # of the mechanism's size: the longest arrow of each kind


@dataclass
class Stage:
    """Handles of what was drawn, to move and to hide it."""

    scale: float  # scene units per metre
    cell: float  # of the ground grid [m]
    bodies: list[Any] = field(default_factory=list)
    layers: dict[str, list[Any]] = field(default_factory=lambda: {name: [] for name in LAYERS})
    links: list[Links] = field(default_factory=list)
    arrows: list[Any] = field(default_factory=list)
    factors: list[float] = field(default_factory=list)  # metres per unit of each kind of arrows
    traces: list[Any] = field(default_factory=list)  # the passed part of each
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
    scene: Any,
    camera: Any,
    drawing: Drawing,
    frames: Frames,
    arrows: Sequence[Arrows] = (),
    traces: Sequence[Trace] = (),
    shown: Sequence[str] = USUAL,
    *,
    near: bool = False,
) -> Stage:
    """Draw everything at the first frame.

    Parameters
    ----------
    scene, camera : viser's ``server.scene`` and ``server.initial_camera``, or those of a `Recording`
    drawing, frames, arrows, traces : what is drawn and how it moves
    shown : layers that are shown first
    near : whether the camera frames the mechanism at the first frame only, not all of its motion

    Returns
    -------
    Stage
        Scale and handles.
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


def aim(camera: Any, stage: Stage, low: np.ndarray, high: np.ndarray) -> None:
    """Let the first view hold the whole box."""
    seen = frame_camera(low, high, FOV)
    stage.distance = seen.distance
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
            name, np.concatenate(parts), rgb(colour), thickness=2.0, thickness_units="screen"
        )
        stage.layers[layer].append(node)


def add_tags(scene: Any, stage: Stage, drawing: Drawing) -> None:
    """Names, fixed in their bodies."""
    for k, tag in enumerate(drawing.tags):
        text = tag.text.encode("utf-8", "replace").decode("utf-8")
        node = scene.add_label(
            f"/bodies/{tag.body}/name{k}", text, position=tag.point * stage.scale, anchor="bottom-center"
        )
        stage.layers[tag.layer].append(node)


def add_arrows(scene: Any, stage: Stage, i: int, kind: Arrows, size: float) -> None:
    """Arrows of one kind."""
    stage.factors.append(LONGEST * size / kind.longest if kind.longest > 0.0 else 0.0)
    tints = np.array([channels(tint) for tint in kind.tints])
    node = add_copies(scene, f"/arrows/{i}", arrow(kind.heads), tints, len(kind.names))
    stage.arrows.append(node)
    stage.layers[kind.kind].append(node)
    stage.point(i, kind.points[0], kind.vectors[0])


def add_trace(scene: Any, stage: Stage, i: int, trace: Trace) -> None:
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


def add_grid(scene: Any, stage: Stage, drawing: Drawing, low: np.ndarray, high: np.ndarray) -> None:
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
