"""What is asked for is gathered and shown: as a page, or by a server on this machine."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...base.checks import number
from ...base.paths import ready_path
from ...base.progress import Progress
from ...mechanism.state import State
from ...report.wording import title_of
from ..scene.artist import draw_system
from ..scene.curves import curves_of
from ..scene.drawing import poses_of
from ..scene.frames import Frames, frames_of, sensible_speed
from ..scene.layers import USUAL, layers_of
from ..scene.motion import arrows_of, traces_of
from .content import Content, weight_of
from .html import View, make_page

LARGEST = 7e6  # characters of what moves in a page whose number of frames was not asked for
FEW = 12  # bodies whose names do not hide the scene


def show_system(
    system: Any, path: Any, state: Any, shown: Any, hidden: Any, title: str | None, dark: bool | None, live: bool
) -> Any:
    """See `System.show`."""
    check_options(path, title, dark, live)
    if not (state is None or isinstance(state, State)):
        raise ValueError(f"show: state = {state!r}; give a State (see System.assemble, Solution.state), or None")
    (r, e), t = poses_of(system, state), np.array([0.0 if state is None else state.t])
    title = title or f"{title_of(system)}: {'reference pose' if state is None else 'a pose'}"
    still, layers = Frames(t, r[None], e[None]), page_layers(system, shown, hidden)
    content = Content(draw_system(system), still, [], [], [], 1.0, title, layers, timed=state is not None)
    return deliver(content, path, dark, live, "system.show")


def animate(
    solution: Any, path: Any, *, curves: Any, traces: Any, shown: Any, hidden: Any, frames: int | None,
    speed: float | None, title: str | None, dark: bool | None, live: bool, follow: Any,
) -> Any:  # fmt: skip
    """See `Solution.animate`."""
    check_options(path, title, dark, live)
    followed = followed_body(solution.system, follow, live)
    layers = page_layers(solution.system, shown, hidden)
    speed = None if speed is None else number(speed, "speed", positive=True)
    with Progress("page", 0.0, 6.0) as progress:
        drawing = draw_system(solution.system)

        content = gather(solution, drawing, frames_of(solution, frames), curves, traces, speed, title, layers, progress)
        if frames is None and not live and (weight := weight_of(content)) > LARGEST:
            fewer = frames_of(solution, max(2, int(content.frames.t.size * LARGEST / weight)))
            content = gather(solution, drawing, fewer, curves, traces, speed, title, layers, progress)
        return deliver(content._replace(followed=followed), path, dark, live, "solution.animate")


def followed_body(system: Any, follow: Any, live: bool) -> int:
    """Number of the body that the camera goes along with, or -1."""
    if follow is None:
        return -1
    if live:
        raise ValueError(f"follow = {follow!r}: the camera of a live view does not go along; leave follow out")
    body = system.part(follow)
    return next(i for i, other in enumerate(system.bodies) if other is body)


def gather(
    solution: Any, drawing: Any, frames: Frames, curves: Any, traces: Any, speed: float | None, title: str | None,
    layers: Sequence[str], progress: Progress,
) -> Content:  # fmt: skip
    """All that is shown of a run at these frames."""
    progress.update(1.0)
    arrows = arrows_of(solution, frames)
    progress.update(3.0)
    paths = traces_of(solution, frames, traces)
    lines = curves_of(solution, frames, curves) if frames.t.size > 1 else []
    progress.update(4.0)
    seconds = float(frames.t[-1] - frames.t[0])
    title, speed = title or title_of(solution.system), speed or sensible_speed(seconds)
    return Content(drawing, frames, arrows, paths, lines, speed, title, layers)


def page_layers(system: Any, shown: Any, hidden: Any) -> tuple[str, ...]:
    """The layers that a page shows first; all have switches."""
    return layers_of(shown, hidden, (*USUAL, "body names") if len(system.bodies) <= FEW else USUAL)


def check_options(path: Any, title: Any, dark: Any, live: Any) -> None:
    """ValueError for options of another type, and for a folder that is not there: before the work, not after it."""
    if path is not None:
        ready_path(path, ".html")
    if not (title is None or isinstance(title, str)):
        raise ValueError(f"title = {title!r}; give a text, or None")
    if dark is not None and not isinstance(dark, bool | np.bool_):
        raise ValueError(f"dark = {dark!r}; give True, False, or None for what the reader's system prefers")
    if not isinstance(live, bool | np.bool_):
        raise ValueError(f"live = {live!r}; give True for a server on this machine, or False")


def deliver(content: Content, path: str | Path | None, dark: bool | None, live: bool, user: str) -> Any:
    """The page, written too if a path is given; or the live view."""
    frames = content.frames
    if live:
        from .live import serve

        return serve(content, dark=dark)
    page = make_page(content, None if dark is None else bool(dark), user)
    view = View(page, frames.r.shape[1] - 1, frames.t.size, float(frames.t[-1] - frames.t[0]))
    if path is not None:
        view.save(path)
    return view
