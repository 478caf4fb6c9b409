"""Export of a run as an animated glTF 2.0 file, which Blender, three.js and most viewers of solids open.

One node per body, named as it, carries its shape and the joints' glyphs; its translation and rotation are animated.
glTF is y up: the root node turns the world, z up, by -90 degrees about x; it is shifted to mechanisms that are far from
the origin, since places have single precision. Time starts at zero.
"""

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from ...base.paths import package_version, with_suffix, write_atomically
from ...base.rotations import matrix, rotation
from ...base.style import GREY, SECTOR_BRIGHTNESS
from ...mechanism.mechanism import Mechanism
from ...mechanism.shapes import Mesh
from ...results.motion import Motion
from ..scene.artist import draw_system
from ..scene.drawing import Drawing, Piece, Wire, poses_of, title_of
from ..scene.frames import Frames, frames_of
from ..scene.meshes import COIL_RADIUS_RATIO, ROD_RADIUS_RATIO, rolled, unit_coil, unit_rod
from ..scene.overlays import Points, Trace, moved, nearby, traces_of
from .asset import LINE_STRIP, LINES, TRIANGLES, Asset, Primitive

LAYERS = ("bodies", "joints")  # marks of centres and reference points belong to switches, which glTF does not have
SPRING_LENGTH_MIN = 1e-6  # [sizes of the mechanism] drawn of a spring that is pressed to a point


Z_UP_TO_Y_UP = rotation("x", -90, degrees=True)


def export_run(motion: Motion, path: str | Path, frames: int | None, traces: Points | None) -> Path:
    """Write the file of a solution; see `Solution.export_glb`."""
    shown = frames_of(motion, frames)
    content = glb(motion.system, shown, traces_of(motion, shown, traces))
    return write_atomically(with_suffix(path, ".glb"), content)


def export_pose(system: Mechanism, path: str | Path) -> Path:
    """Write the file of a system at its reference pose; see `System.export_glb`."""
    r, e = poses_of(system)
    content = glb(system, Frames(np.zeros(1), r[None], e[None]), [])
    return write_atomically(with_suffix(path, ".glb"), content)


def glb(system: Mechanism, frames: Frames, traces: list[Trace]) -> bytes:
    """Return the bytes of the file."""
    drawing = draw_system(system)
    origin = drawing.origin
    drawing, frames, _, traces = nearby(drawing, frames, traces=traces)
    names = [body.name for body in system.bodies]
    about: dict[str, str | float] = {
        "title": title_of(system),
        "length": "m",
        "time": "s",
        "start": float(frames.t[0]),
        "duration": float(frames.t[-1] - frames.t[0]),
    }
    asset = Asset(about, f"mbsd3d {package_version()}")
    place = {"rotation": as_gltf(Z_UP_TO_Y_UP)}
    if origin.any():
        place["translation"] = matrix(Z_UP_TO_Y_UP) @ origin
    root = asset.node("world, z up", place)
    bodies = add_bodies(asset, root, [*names, "ground"], drawing, frames)
    add_links(asset, root, drawing, frames)
    for trace in traces:
        if len(trace.points) > 1:
            line = asset.primitive(LINE_STRIP, asset.material(trace.colour), trace.points)
            parent = bodies.get(trace.frame, root)
            asset.node(f"path of {trace.name}", {}, parent, asset.mesh(f"path of {trace.name}", [line]))
    return asset.glb()


def as_gltf(e: np.ndarray) -> np.ndarray:
    """Return quaternions with the scalar last."""
    return np.roll(e, -1, axis=-1)


def add_bodies(asset: Asset, root: int, names: list[str], drawing: Drawing, frames: Frames) -> dict[int, int]:
    """Add a node for every body and the ground, which are returned by their numbers; below it one for its shape and one
    for each of its joints.
    """
    nodes: dict[int, int] = {}
    shown: list[dict[tuple[str, str], list[Piece | Wire]]] = [{} for _ in names]
    everything: tuple[Piece | Wire, ...] = (*drawing.pieces, *drawing.wires)
    for item in everything:
        if item.layer in LAYERS:
            shown[item.body].setdefault((item.layer, item.name), []).append(item)
    clock = frames.t - frames.t[0]
    for i, name in enumerate(names):
        if i == len(names) - 1 and not shown[i]:
            continue  # nothing is fixed to the ground
        places = {"translation": frames.r[:, i], "rotation": as_gltf(frames.e[:, i])}
        node = nodes[i] = asset.moving(name, places, root, clock)
        for (layer, part), items in shown[i].items():
            label = f"{part} shape" if layer == "bodies" else f"{part} on {name}"
            primitives = [primitive for item in items for primitive in primitives_of(asset, item)]
            if primitives:
                asset.node(label, {}, node, asset.mesh(label, primitives))
    return nodes


def primitives_of(asset: Asset, item: Piece | Wire) -> Iterator[Primitive]:
    """Return the triangles of a piece, light and dark ones, or the strokes of a wire."""
    if isinstance(item, Piece):
        yield from solid(asset, item.mesh, item.colour)
        return
    drawn = np.isfinite(item.points).all(axis=1)
    places = np.cumsum(drawn) - 1
    starts = np.flatnonzero(drawn[:-1] & drawn[1:])
    if starts.size:
        corners = places[np.column_stack([starts, starts + 1])]
        yield asset.primitive(LINES, asset.material(item.colour), item.points[drawn], corners=corners)


def solid(asset: Asset, mesh: Mesh, colour: str) -> Iterator[Primitive]:
    """Return one set of triangles for each shade; they share their corners."""
    skin = asset.skin(mesh)
    for shade, brightness in ((0, 1.0), (1, SECTOR_BRIGHTNESS)):
        faces = skin.faces[skin.shade == shade]
        if faces.size:
            paint = asset.material(colour, brightness, double_sided=not skin.closed)
            yield asset.primitive(TRIANGLES, paint, skin.vertices, skin.normals, faces)


def add_links(asset: Asset, root: int, drawing: Drawing, frames: Frames) -> None:
    """Add springs as coils and the links of joints as rods, from one end to the other."""
    clock, least = frames.t - frames.t[0], ROD_RADIUS_RATIO * drawing.size
    for link in drawing.links:
        start, end = link.placed(partial(moved, frames))
        lengths, e = rolled(end - start, SPRING_LENGTH_MIN * drawing.size)
        width = np.full(len(lengths), max(COIL_RADIUS_RATIO * lengths.mean(), least) if link.spring else least)
        mesh = asset.mesh(
            "coil" if link.spring else "rod", list(solid(asset, unit_coil() if link.spring else unit_rod(), GREY))
        )
        places = {"translation": start, "rotation": as_gltf(e), "scale": np.column_stack([width, width, lengths])}
        asset.moving(link.name, places, root, clock, mesh)
