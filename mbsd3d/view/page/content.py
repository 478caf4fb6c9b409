"""Content of a page: the drawing and its motion, as numbers for the player.

Arrays become short texts: whole steps, second differences, deflate, base64. Motions are smooth, so that second
differences of their steps are small numbers, whose bytes deflate well when all first bytes come first, then all second
ones. Sums of 32-bit integers wrap around and are exact: no error grows.
"""

import base64
import zlib
from collections.abc import Sequence
from typing import NamedTuple, TypedDict

import numpy as np

from ...base.style import DARK, GROUND_GRID_GREYS, LIGHT
from ...base.wording import with_superscripts
from ..scene.camera import length_text
from ..scene.drawing import DEFAULT_LAYERS, MARKS, Drawing
from ..scene.frames import Frames
from ..scene.overlays import Arrows, Curve, Trace
from .recorder import Recording
from .stage import Links, Reach, Stage

POSITION_RESOLUTION = 1e-5  # [sizes of the mechanism] of positions
QUATERNION_RESOLUTION = 1e-5  # [1] of the components of quaternions
ARROW_RESOLUTION = 2e-4  # [lengths of the longest arrow] of arrows
NOT_FINITE_CODE = -(2**31)  # stands for a value that is not finite
CURVE_RESOLUTION = 1e-6  # [ranges of the curve] of curves
TRACE_BYTES_PER_NUMBER = 10  # [characters] of a number of a trace; the scene holds its points four times


class Content(NamedTuple):
    """Content of a page or a live view."""

    drawing: Drawing
    frames: Frames
    arrows: list[Arrows]
    traces: list[Trace]
    curves: list[Curve]
    speed: float  # model time per real time
    title: str
    shown: tuple[str, ...] = DEFAULT_LAYERS  # layers
    timed: bool = True  # whether the time is one of a run
    followed: int = -1  # body that the camera goes along with
    view: Sequence[float] | None = None  # azimuth and elevation of the camera at first [degrees]
    least: Reach | None = None  # what the first view holds and the arrows are scaled by, of another motion
    explore: dict[str, object] | None = None  # by which the page solves: see `explore.exploration`
    ride: dict[str, object] | None = None  # what the reader moves himself: see `explore.ridden`
    captions: Sequence[tuple[float, str]] = ()  # times [s] and sentences


class Packed(TypedDict):
    """Array as the player reads it."""

    shape: list[int]
    step: float  # of the whole numbers
    data: str  # base64


def weight_of(content: Content) -> int:
    """Return the characters that the motion takes in a page, without the curves."""
    frames, size = content.frames, content.drawing.size
    arrays = [(frames.r, POSITION_RESOLUTION * size), (frames.e, QUATERNION_RESOLUTION)]
    for kind in content.arrows:
        arrays += [(kind.points, ARROW_RESOLUTION * size), (kind.vectors, ARROW_RESOLUTION * kind.longest)]
    traces = sum(trace.points.size for trace in content.traces)
    return sum(len(pack(values, step)["data"]) for values, step in arrays) + TRACE_BYTES_PER_NUMBER * traces


def scene_and_data(content: Content, user: str) -> tuple[str, dict[str, object]]:
    """Return the recorded scene (base64) and the data by which the player moves it."""
    recording = Recording(user)
    stage = Stage(
        recording.scene, recording.camera, *content[:4], content.shown, near=content.followed >= 0, view=content.view,
        least=content.least, ghost=bool(content.explore and content.explore["ghost"]),
    )  # fmt: skip
    return recording.data(), player_data(content, stage)


def player_data(content: Content, stage: Stage) -> dict[str, object]:
    """Return numbers and names for player.js; lengths in metres."""
    drawing, frames = content.drawing, content.frames
    t, size = frames.t, drawing.size
    moving = [
        i for i in range(frames.r.shape[1]) if np.ptp(frames.r[:, i], axis=0).any() or np.ptp(frames.e[:, i], 0).any()
    ]
    return {
        "times": {"first": float(t[0]), "step": float((t[-1] - t[0]) / max(t.size - 1, 1)), "count": int(t.size)},
        "speed": content.speed,
        "scale": stage.scale,
        "sight": [stage.sight.depth, stage.sight.across, stage.sight.up],
        "followed": content.followed,
        "moving": moving,
        "bodies": [[tag.body, tag.text] for tag in drawing.tags if tag.layer == "body names" and tag.body in moving],
        "poses": {"r": pack(frames.r, POSITION_RESOLUTION * size), "e": pack(frames.e, QUATERNION_RESOLUTION)},
        "links": [links_data(links) for links in stage.links],
        "solids": [node.name for node in stage.layers["bodies"] if "/mesh" in node.name],
        "traces": [node.name for node in stage.traces],
        "arrows": [arrows_data(kind, i, stage, size) for i, kind in enumerate(content.arrows)],
        "layers": layers_data(content, stage),
        "curves": [curve_data(curve) for curve in content.curves],
        "captions": [list(caption) for caption in content.captions],
        "grid": length_text(stage.cell),
        "darkCells": [[grey] * 3 for grey in GROUND_GRID_GREYS["dark"]],
        "colours": {"light": LIGHT.lines, "dark": DARK.lines},
        **({} if content.explore is None else {"explore": content.explore}),
        **({} if content.ride is None else {"ride": content.ride | {"ground": stage.ground, "cell": 5.0 * stage.cell}}),
    }


def links_data(links: Links) -> dict[str, object]:
    """Return the ends of springs or rods in body axes, the circles they are tangents of, their radii, and the
    directions from which they turn.
    """
    ends = [[[int(body), [float(x) for x in point]] for body, point in link.ends] for link in links.links]
    rounds = [x and [x.body, x.axis.tolist(), *map(float, x.arms)] for x in (link.rounds for link in links.links)]
    widths = {"radii": links.radii.tolist(), "rest": links.rest.tolist()}
    return {"node": links.node.name, "ends": ends, "rounds": rounds, **widths}


def arrows_data(kind: Arrows, i: int, stage: Stage, size: float) -> dict[str, object]:
    """Return the points, sizes and legend of the arrows of one kind."""
    return {
        "kind": kind.kind,
        "unit": with_superscripts(kind.unit),
        "heads": kind.heads,
        "colour": kind.colour,
        "uncertain": any(kind.uncertain),
        "node": stage.arrows[i].name,
        "longest": kind.longest,
        "factor": stage.factors[i],
        "points": pack(kind.points, ARROW_RESOLUTION * size),
        "vectors": pack(kind.vectors, ARROW_RESOLUTION * kind.longest),
    }


def layers_data(content: Content, stage: Stage) -> list[dict[str, object]]:
    """Return the switches: name, nodes, whether they are shown first, and the mark of arrows."""
    marks = {kind.kind: {"colour": kind.colour, "heads": kind.heads} for kind in content.arrows}
    inner = (*marks, *MARKS)
    return [
        {
            "name": name,
            "inner": name in inner,
            "nodes": [node.name for node in nodes],
            "shown": name in stage.shown,
            **marks.get(name, {}),
        }
        for name, nodes in stage.layers.items()
        if nodes
    ]


def curve_data(curve: Curve) -> dict[str, object]:
    """Encode the curves of one plot for the page."""
    lines = []
    for name, values in curve.lines:
        values = np.asarray(values, float)
        finite = values[np.isfinite(values)]
        span, largest = (float(np.ptp(finite)), float(np.abs(finite).max())) if finite.size else (0.0, 0.0)
        lines.append({"name": name, "values": pack(values, max(CURVE_RESOLUTION * span, 1e-9 * largest))})
    return {"label": curve.label, "unit": with_superscripts(curve.unit), "lines": lines, "size": curve.size}


def pack(values: np.ndarray, step: float) -> Packed:
    """Return values (frames, ...) as multiples of ``step``, of a wider one where they would not fit into 30 bits."""
    values = np.asarray(values, float)
    finite = np.isfinite(values)
    largest = float(np.abs(values[finite]).max()) if finite.any() else 0.0
    step = max(float(step), largest / 2**30) or 1.0
    whole = np.where(finite, np.rint(np.where(finite, values, 0.0) / step), NOT_FINITE_CODE).astype(np.int32)
    rows = np.ascontiguousarray(whole.reshape(len(whole), -1).T)
    for _ in range(2):
        rows = np.diff(rows, axis=1, prepend=np.int32(0))
    zigzag = ((rows << 1) ^ (rows >> 31)).astype("<u4")  # small negative numbers become small positive ones
    planes = zigzag.reshape(-1, 1).view(np.uint8).T
    data = base64.b64encode(zlib.compress(planes.tobytes(), 9)).decode("ascii")
    return {"shape": list(values.shape), "step": step, "data": data}
