"""Options and content of a page or a live view."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...base.checks import as_tuple, number
from ...base.checks import short_repr as shown_text
from ...base.errors import InputError
from ...base.paths import ready_path
from ...base.progress import Progress
from ...mechanism.bodies import Body, Ground
from ...mechanism.mechanism import Mechanism
from ...mechanism.state import State
from ...plotting.panels import Wanted
from ...results.motion import Motion
from ...results.result import RunResult
from ..explore.exploration import Exploration, exploration_data
from ..explore.ridden import Ride, ride_data
from ..scene.artist import draw_system
from ..scene.camera import directions, followed_body
from ..scene.drawing import DEFAULT_LAYERS, Layers, poses_of, title_of
from ..scene.frames import Frames, frames_of, sensible_speed
from ..scene.overlays import Points, arrows_of, curves_of, nearby, traces_of
from .content import Content, weight_of
from .html import View, make_page
from .live import LiveView
from .stage import Reach, boxes

MOTION_BYTES_MAX = 7e6  # [characters] of the motion in a page for which no number of frames was asked
# [bodies] whose names do not hide the scene, and [sizes of the mechanism] between two names
NAMED_BODIES_MAX, NAME_DISTANCE_MIN = 12, 0.05


def show_system(
    system: Mechanism,
    path: str | Path | None,
    state: State | None,
    layers: Layers,
    title: str | None,
    dark: bool | None,
    live: bool,
) -> View | LiveView:
    """Show a system; see `System.show`."""
    check_options(path, title, dark, live)
    if not (state is None or isinstance(state, State)):
        raise InputError(f"show: state = {state!r}; give a State (see System.assemble, Solution.state), or None")
    (r, e), t = poses_of(system, state), np.array([0.0 if state is None else state.t])
    title = title or f"{title_of(system)}: {'reference pose' if state is None else 'a pose'}"
    still, visible = Frames(t, r[None], e[None]), page_layers(system, layers)
    content = Content(*nearby(draw_system(system), still), [], 1.0, title, visible, timed=state is not None)
    return deliver(content, path, dark, live, "system.show")


@dataclass(frozen=True)
class MotionOptions:
    """Options of a motion in space; see `Solution.animate`."""

    layers: Layers
    curves: Wanted | None = None
    traces: Points | None = None
    frames: int | None = None
    speed: float | None = None
    title: str | None = None
    follow: Body | Ground | str | None = None
    view: Sequence[float] | None = None
    beside: Motion | None = None
    explore: Exploration | None = None
    ride: Ride | None = None
    captions: Sequence[tuple[float, str]] = ()


def animate(
    motion: Motion, path: str | Path | None, options: MotionOptions, dark: bool | None, live: bool
) -> View | LiveView:
    """Show a motion; see `Solution.animate`."""
    check_options(path, options.title, dark, live)
    with Progress("page", 0.0, 6.0) as progress:
        content = motion_content(motion, options, progress, live)
        return deliver(content, path, dark, live, "solution.animate")


def motion_content(motion: Motion, options: MotionOptions, progress: Progress, live: bool = False) -> Content:
    """Return the content of a page or a live view; the progress is 4 then."""
    frames, beside = options.frames, options.beside
    if not isinstance(beside, Motion | None):
        raise InputError(f"solution.animate: beside {shown_text(beside)} is not a solution; give one, or None")
    followed = followed_body(motion, options.follow, live)
    visible, axes = page_layers(motion.system, options.layers), directions(options.view)
    every = frames_of(motion, frames)
    captions = captions_of(motion, options.captions)
    speed = None if options.speed is None else number(options.speed, "speed", positive=True)
    drawing, name = draw_system(motion.system), options.title or title_of(motion.system)

    def gathered(at: Frames) -> Content:
        progress.update(1.0)
        arrows = arrows_of(motion, at)
        progress.update(3.0)
        paths = traces_of(motion, at, options.traces)
        lines = curves_of(motion, at, options.curves) if at.t.size > 1 else []
        progress.update(4.0)
        least = None if beside is None else reach_of(beside, frames, visible, axes, drawing.origin)
        pace = speed or sensible_speed(float(at.t[-1] - at.t[0]))
        shown = nearby(drawing, at, arrows, paths)
        solves = None
        if options.explore is not None and isinstance(motion, RunResult):
            solves = exploration_data(
                options.explore, motion, drawing.origin, (options.curves, options.traces), (arrows, paths)
            )
        ride = None if options.ride is None else ride_data(options.ride, motion.system, drawing.origin)
        return Content(
            *shown, lines, pace, name, visible, True, followed, options.view, least, solves, ride, captions
        )  # fmt: skip

    content = gathered(every)
    if frames is None and not live and (weight := weight_of(content)) > MOTION_BYTES_MAX:
        return gathered(frames_of(motion, max(2, int(content.frames.t.size * MOTION_BYTES_MAX / weight))))
    return content


def captions_of(motion: Motion, given: Sequence[tuple[float, str]]) -> list[tuple[float, str]]:
    """Return the captions in the order of their times; raise InputError for one outside the run."""
    first, last = float(motion.t[0]), float(motion.t[-1])
    entries = [as_tuple(x, "solution.animate: caption", "a pair (time, text)") for x in given]
    if bad := [x for x in entries if len(x) != 2 or not isinstance(x[1], str)]:
        raise InputError(f"solution.animate: caption {shown_text(bad[0])} is not a pair (time, text); give one")
    found = sorted((number(t, "solution.animate: time of a caption"), text) for t, text in entries)
    for t, text in found:
        if not first <= t <= last:
            raise InputError(
                f"solution.animate: caption '{text}' at {t:g} s is not within the run; give {first:g} ... {last:g} s"
            )
    return found


def reach_of(motion: Motion, frames: int | None, layers: Sequence[str], axes: np.ndarray, origin: np.ndarray) -> Reach:
    """Return the space a motion takes about an origin, also along the directions of a view, and its longest arrows."""
    at = frames_of(motion, frames)
    drawing, near, _, _ = nearby(draw_system(motion.system)._replace(origin=origin), at)
    return Reach(*boxes(drawing, near, layers, axes), {kind.kind: kind.longest for kind in arrows_of(motion, at)})


def page_layers(system: Mechanism, layers: Layers) -> tuple[str, ...]:
    """Return the layers that a page shows first; all have switches."""
    return layers.visible((*DEFAULT_LAYERS, "body names") if names_fit(system) else DEFAULT_LAYERS)


def names_fit(system: Mechanism) -> bool:
    """Return True for few bodies whose names, at the centres of mass of the reference pose, do not overlap."""
    places = np.array([body.centre for body in system.bodies])
    if not 1 < len(places) <= NAMED_BODIES_MAX:
        return len(places) <= NAMED_BODIES_MAX
    gaps = np.linalg.norm(places[:, None] - places, axis=2)[np.triu_indices(len(places), 1)]
    return bool(gaps.min() > NAME_DISTANCE_MIN * gaps.max())


def check_options(path: str | Path | None, title: str | None, dark: bool | None, live: bool) -> None:
    """Raise a ValueError for options of another type, and for a missing folder, before the work is done."""
    if path is not None:
        ready_path(path, ".html")
    if not (title is None or isinstance(title, str)):
        raise InputError(f"title = {shown_text(title)}; give a text, or None")
    if dark is not None and not isinstance(dark, bool | np.bool_):
        raise InputError(f"dark = {shown_text(dark)}; give True, False, or None for what the reader's system prefers")
    if not isinstance(live, bool | np.bool_):
        raise InputError(f"live = {shown_text(live)}; give True for a server on this machine, or False")


def deliver(content: Content, path: str | Path | None, dark: bool | None, live: bool, user: str) -> View | LiveView:
    """Return the page, written to a path if one is given, or the live view."""
    if live:
        return LiveView(content, dark)
    page = page_of(content, dark, user)
    if path is not None:
        page.save(path)
    return page


def page_of(content: Content, dark: bool | None, user: str) -> View:
    """Return the page."""
    frames = content.frames
    page = make_page(content, None if dark is None else bool(dark), user)
    return View(page, frames.r.shape[1] - 1, frames.t.size, float(frames.t[-1] - frames.t[0]))
