"""Pictures of a system and of a motion: matplotlib figures, shaded, in perspective."""

from collections.abc import Collection, Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from ...base.checks import number, short_repr
from ...base.errors import InputError
from ...base.style import figure_style, theme
from ...mechanism.bodies import Body, Ground
from ...mechanism.mechanism import Mechanism
from ...mechanism.state import State
from ...results.motion import Motion
from ..scene.artist import draw_system
from ..scene.camera import (
    directions,
    followed_body,
    frame_camera,
    lens_of,
    pair,
    seen_from,
    stood_back,
    turning_box,
)
from ..scene.drawing import ARROWS, DEFAULT_LAYERS, MARKS, NAMES, USUAL_LAYERS, Layers, bounds, poses_of
from ..scene.frames import Frames, frames_at, frames_of
from ..scene.overlays import Arrows, Points, Trace, arrows_of, traces_of
from .painter import NONE, TRIANGLE_SIZE_MAX, Painter, new_sheet
from .shading import pointers_of, tips_of

LEGIBLE = 14  # names that a picture can hold
LARGEST = 100  # inch
REACH = 0.4  # length of the longest arrow, of the size of what is seen


@runtime_checkable
class Continuous(Protocol):
    """Run, which has a state at any time; a mode has samples only."""

    def at(self, t: float) -> State:
        """Return the state at a time [s]."""


def picture_layers(system: Mechanism, layers: Layers, *, moving: bool) -> tuple[str, ...]:
    """Return the layers of a picture: with names where there are few; a system at rest has no arrows."""
    few = len(system.bodies) + len(system.joints) <= LEGIBLE
    visible = layers.visible((*DEFAULT_LAYERS, *NAMES) if few else DEFAULT_LAYERS)
    if not moving and set(ARROWS) & set(visible):
        raise InputError(f"shown: a system at rest has no arrows; give some of {', '.join((*NAMES, *MARKS))}")
    return visible


def painter_of(
    system: Mechanism,
    r: np.ndarray,
    e: np.ndarray,
    inches: tuple[float, float],
    *,
    paths: Sequence[Trace] = (),
    vectors: Sequence[Arrows] = (),
    layers: Collection[str],
    view: Sequence[float] | None,
    dark: bool,
    fine: float = TRIANGLE_SIZE_MAX,
    drawn: slice = slice(None),
    near: bool = False,
) -> tuple[Painter, float]:
    """Return a painter whose paper holds all poses, paths and arrows, and the length of the longest arrow [m].

    ``drawn``: the frames of the arrows that are shown; their scale is that of all. ``near``: the paper holds the first
    pose with room to turn; paths and arrows may leave it.
    """
    drawing, floor = draw_system(system), None
    if near:
        floor = float(bounds(drawing, r, e, layers)[0][2])
        r, e = r[:1], e[:1]
        axes = directions(view)
        also = turning_box(*bounds(drawing, r, e, layers, axes), axes)
    low, high = bounds(drawing, r, e, layers)
    reach = REACH * float((high - low).max())
    if not near:
        also = np.concatenate(
            [NONE, *(x.at(r[-1], e[-1]) for x in paths), *(tips_of(x, reach, drawn) for x in vectors)]
        )
    camera = stood_back(seen_from(frame_camera(low, high), view), also)
    lens, sheet = lens_of(camera), theme(dark)
    return Painter(drawing, lens, r, e, inches, sheet=sheet, layers=layers, fine=fine, also=also, floor=floor), reach


def paper_size(size: Sequence[float]) -> tuple[float, float]:
    """Return width and height [inch], positive, and no larger than memory holds."""
    width, height = (number(side, "size", positive=True) for side in pair(size, "size"))
    if max(width, height) > LARGEST:
        raise InputError(f"size = {width:g} x {height:g} inch; give at most {LARGEST} each way")
    return width, height


def picture_of_system(
    system: Mechanism,
    state: State | None,
    *,
    layers: Layers = USUAL_LAYERS,
    view: Sequence[float] | None = None,
    size: Sequence[float],
    dark: bool = False,
) -> Figure:
    """Draw a system; see `System.picture`."""
    visible, inches = picture_layers(system, layers, moving=False), paper_size(size)
    r, e = poses_of(system, state)
    painter, _ = painter_of(system, r[None], e[None], inches, layers=visible, view=view, dark=dark)
    with figure_style(painter.sheet):
        figure, axes = new_sheet(painter.inches, painter.sheet)
        painter.paint(axes, [(r, e)])
    return figure


def picture_of_solution(
    motion: Motion,
    t: ArrayLike | None,
    *,
    traces: Points | None = None,
    layers: Layers = USUAL_LAYERS,
    view: Sequence[float] | None = None,
    size: Sequence[float],
    dark: bool = False,
    follow: Body | Ground | str | None = None,
) -> Figure:
    """Draw a motion; see `Solution.picture`."""
    visible, inches = picture_layers(motion.system, layers, moving=True), paper_size(size)
    run = frames_of(motion)
    now = moments(motion, run, t)
    paths = traces_of(motion, run_until(run, now), traces) if "traces" in visible else []
    kinds = set(ARROWS) & set(visible)
    both = Frames(*(np.concatenate(pair) for pair in zip(run, now, strict=True)))  # one scale for every moment
    vectors = [x for x in arrows_of(motion, both) if x.kind in kinds] if kinds else []
    followed = followed_body(motion, follow) if now.t.size == 1 or follow is not None else -1
    way = now.r[-1, followed] - run.r[0, followed]  # of the camera; -1 is the ground
    held = now if followed < 0 else Frames(*(np.concatenate([a[:1], b]) for a, b in zip(run, now, strict=True)))
    painter, reach = painter_of(
        motion.system, held.r, held.e, inches, paths=paths, vectors=vectors, layers=visible, view=view, dark=dark,
        drawn=slice(run.t.size, None), near=followed >= 0,
    )  # fmt: skip
    painter = painter.gone(way)
    with figure_style(painter.sheet):
        figure, axes = new_sheet(inches, painter.sheet)
        pointers = [pointers_of(x, k, reach, painter.lens) for x in vectors for k in range(run.t.size, both.t.size)]
        painter.paint(axes, list(zip(now.r, now.e, strict=True)), traces=paths, arrows=pointers)
        texts = [f"{time:.6g}" for time in now.t]
        several = ", ".join(texts) if len(texts) < 6 else f"{texts[0]} ... {texts[-1]}"
        painter.write_note(axes, f"t = {several} s")
    return figure


def moments(motion: Motion, run: Frames, t: ArrayLike | None) -> Frames:
    """Return the poses at the given times, at the last one for None.

    Poses of a run are integrated, not interpolated.
    """
    try:
        times = np.atleast_1d(np.asarray(run.t[-1] if t is None else t, float))
    except (TypeError, ValueError, OverflowError):
        times = np.empty(0)
    if times.ndim != 1 or not times.size:
        raise InputError(f"picture: t = {short_repr(t)}; give a time or a sequence of times [s]")
    if isinstance(motion, Continuous):
        poses = [poses_of(motion.system, motion.at(float(time))) for time in times]
        return Frames(times, *(np.array(x) for x in zip(*poses, strict=True)))
    if not (run.t[0] <= times.min() and times.max() <= run.t[-1]):
        raise InputError(f"picture: t = {short_repr(t)} is outside the motion {run.t[0]:g} ... {run.t[-1]:g} s")
    return frames_at(motion, times)


def run_until(run: Frames, shown: Frames) -> Frames:
    """Return the frames before the last of the shown ones, and that one; of several, not before the first of them."""
    last = int(np.argmax(shown.t))
    since = shown.t.min() if shown.t.size > 1 else -np.inf
    path = (run.t >= since) & (run.t < shown.t[last])
    return Frames(*(np.concatenate([a[path], b[last : last + 1]]) for a, b in zip(run, shown, strict=True)))
