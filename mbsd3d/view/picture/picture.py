"""Pictures of a system and of a solution: matplotlib figures, shaded, in perspective."""

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ...base.checks import number
from ...base.style import house, theme
from ..scene.artist import draw_system
from ..scene.camera import frame_camera, lens_of, turned
from ..scene.drawing import bounds, poses_of
from ..scene.frames import Frames, frames_at, frames_of
from ..scene.layers import ARROWS, MARKS, NAMES, USUAL, layers_of
from ..scene.motion import Arrows, Trace, arrows_of, traces_of
from .painter import FINE, Painter, new_sheet
from .pointers import pointers_of, tips_of

LEGIBLE = 14  # names that a picture can hold
REACH = 0.4  # length of the longest arrow, of the size of what is seen


def picture_layers(system: Any, shown: Any, hidden: Any, *, moving: bool) -> tuple[str, ...]:
    """The layers of a picture: with names where there are few; a system at rest has no arrows."""
    few = len(system.bodies) + len(system.joints) <= LEGIBLE
    layers = layers_of(shown, hidden, (*USUAL, *NAMES) if few else USUAL)
    if not moving and set(ARROWS) & set(layers):
        raise ValueError(f"shown: a system at rest has no arrows; give some of {', '.join((*NAMES, *MARKS))}")
    return layers


def pair(value: Any, what: str) -> tuple[float, float]:
    """Two numbers."""
    if np.shape(value) != (2,):
        raise ValueError(f"{what}: {value!r} is no pair; give two numbers")
    return number(value[0], what), number(value[1], what)


def painter_of(
    system: Any,
    r: np.ndarray,
    e: np.ndarray,
    inches: tuple[float, float],
    *,
    paths: Sequence[Trace] = (),
    vectors: Sequence[Arrows] = (),
    layers: Collection[str],
    view: Sequence[float] | None,
    dark: bool,
    fine: float = FINE,
) -> tuple[Painter, float]:
    """A painter whose paper holds all poses, paths and arrows, and the length of the longest arrow [m]."""
    drawing = draw_system(system)
    low, high = bounds(drawing, r, e)
    camera = frame_camera(low, high)
    if view is not None:
        azimuth, elevation = pair(view, "view")
        if not -89.0 <= elevation <= 89.0:
            raise ValueError(f"view: elevation = {elevation:g}; give -89 ... 89 degrees")
        camera = turned(camera, azimuth, elevation)
    reach = REACH * float((high - low).max())
    also = [trace.points for trace in paths] + [tips_of(x, reach) for x in vectors]
    options = {"sheet": theme(dark), "layers": layers, "fine": fine, "also": np.concatenate(also) if also else None}
    return Painter(drawing, lens_of(camera), r, e, inches, **options), reach


def paper_size(size: Any) -> tuple[float, float]:
    """Width and height [inch], both positive."""
    width, height = pair(size, "size")
    return number(width, "size", positive=True), number(height, "size", positive=True)


def picture_of_system(
    system: Any, state: Any, *, shown: Any, hidden: Any, view: Any, size: Sequence[float], dark: bool
) -> Figure:
    """See `System.picture`."""
    layers, inches = picture_layers(system, shown, hidden, moving=False), paper_size(size)
    r, e = poses_of(system, state)
    painter, _ = painter_of(system, r[None], e[None], inches, layers=layers, view=view, dark=dark)
    with house(painter.sheet):
        figure, axes = new_sheet(painter.inches, painter.sheet)
        painter.paint(axes, [(r, e)])
    return figure


def picture_of_solution(
    solution: Any, t: Any, *, traces: Any, shown: Any, hidden: Any, view: Any, size: Sequence[float], dark: bool
) -> Figure:
    """See `Solution.picture`."""
    layers, inches = picture_layers(solution.system, shown, hidden, moving=True), paper_size(size)
    run = frames_of(solution)
    now = moments(solution, run, t)
    paths = traces_of(solution, run_until(run, now), traces) if "traces" in layers else []
    kinds = set(ARROWS) & set(layers)
    both = Frames(*(np.concatenate(pair) for pair in zip(run, now, strict=True)))  # one scale for every moment
    vectors = [x for x in arrows_of(solution, both) if x.kind in kinds] if kinds else []
    painter, reach = painter_of(
        solution.system, now.r, now.e, inches, paths=paths, vectors=vectors, layers=layers, view=view, dark=dark
    )
    with house(painter.sheet):
        figure, axes = new_sheet(inches, painter.sheet)
        pointers = [pointers_of(x, k, reach, painter.lens) for x in vectors for k in range(run.t.size, both.t.size)]
        painter.paint(axes, list(zip(now.r, now.e, strict=True)), traces=paths, arrows=pointers)
        texts = [f"{time:.4g}" for time in now.t]
        several = ", ".join(texts) if len(texts) < 6 else f"{texts[0]} ... {texts[-1]}"
        painter.write_note(axes, f"t = {several} s")
    return figure


def moments(solution: Any, run: Frames, t: Any) -> Frames:
    """The poses at the given times, at the last one for None; of a solution not interpolated but integrated."""
    try:
        times = np.atleast_1d(np.asarray(run.t[-1] if t is None else t, float))
    except (TypeError, ValueError):
        times = np.empty(0)
    if times.ndim != 1 or not times.size:
        raise ValueError(f"picture: t = {t!r}; give a time or a sequence of times [s]")
    if hasattr(solution, "at"):
        poses = [poses_of(solution.system, solution.at(float(time))) for time in times]
        return Frames(times, *(np.array(x) for x in zip(*poses, strict=True)))
    if not (run.t[0] <= times.min() and times.max() <= run.t[-1]):
        raise ValueError(f"picture: t = {t!r} is outside the motion {run.t[0]:g} ... {run.t[-1]:g} s")
    return frames_at(solution, times)


def run_until(run: Frames, shown: Frames) -> Frames:
    """The frames before the last of the shown ones, and that one; of several, not before the first of them."""
    last = int(np.argmax(shown.t))
    since = shown.t.min() if shown.t.size > 1 else -np.inf
    path = (run.t >= since) & (run.t < shown.t[last])
    return Frames(*(np.concatenate([a[path], b[last : last + 1]]) for a, b in zip(run, shown, strict=True)))
