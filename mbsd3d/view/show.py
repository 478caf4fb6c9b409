"""What is asked for is gathered and shown: as a page, or by a server on this machine."""

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ..files import with_suffix
from ..parts import number
from ..progress import Progress
from ..state import State
from ..wording import title_of
from .content import Content
from .drawing import draw_system, poses_of
from .motion import Frames, arrows_of, curves_of, frames_of, traces_of
from .page import View, make_page
from .speed import sensible_speed
from .stage import ALL

LARGEST = 9e6  # characters of a page whose number of frames was not asked for


def show_system(
    system: Any, path: str | Path | None, state: Any, title: str | None, dark: bool | None, live: bool
) -> Any:
    """See `System.show`."""
    check_options("show", path, title, dark, live)
    if not (state is None or isinstance(state, State)):
        raise ValueError(f"show: state = {state!r}; give a State (see System.assemble, Solution.state), or None")
    r, e = poses_of(system, state)
    t = np.array([0.0 if state is None else state.t])
    drawing = draw_system(system)
    content = Content(
        drawing,
        Frames(t, r[None], e[None]),
        [],
        [],
        [],
        1.0,
        title or f"{title_of(system)}: {'reference pose' if state is None else 'a pose'}",
        timed=state is not None,
    )
    return deliver(content, path, dark, live, "system.show")


def animate(
    solution: Any,
    path: str | Path | None,
    curves: Any,
    traces: Any,
    shown: Any,
    frames: int | None,
    speed: float | None,
    title: str | None,
    dark: bool | None,
    live: bool,
) -> Any:
    """See `Solution.animate`."""
    check_options("animate", path, title, dark, live)
    if frames is not None and (isinstance(frames, bool) or not isinstance(frames, int | np.integer) or frames < 2):
        raise ValueError(f"animate: frames = {frames!r}; give a whole number >= 2, or None")
    shown = layers_of(shown)
    if speed is not None:
        speed = number(speed, "animate: speed", positive=True)
    if not solution.t.size:
        raise ValueError("animate: the solution has no samples; run it with output=None or a count")
    with Progress("page", 0.0, 6.0) as progress:
        drawing, count = draw_system(solution.system), frames
        while True:
            moving = frames_of(solution, count)
            content = gather(solution, drawing, moving, curves, traces, speed, title, progress)._replace(shown=shown)
            view = deliver(content, None, dark, live, "solution.animate")
            if live or frames is not None or len(view.html) <= LARGEST or moving.t.size <= 2:
                break
            count = max(2, int(0.9 * moving.t.size * LARGEST / len(view.html)))
    if path is not None and not live:
        view.save(path)
    return view


def gather(
    solution: Any, drawing: Any, frames: Frames, curves: Any, traces: Any, speed: float | None, title: str | None,
    progress: Progress,
) -> Content:  # fmt: skip
    """All that is shown of a run at these frames."""
    progress.update(1.0)
    arrows = arrows_of(solution, frames)
    progress.update(3.0)
    paths = traces_of(solution, frames, traces)
    lines = curves_of(solution, frames, curves) if frames.t.size > 1 else []
    progress.update(4.0)
    seconds = float(frames.t[-1] - frames.t[0])
    return Content(
        drawing, frames, arrows, paths, lines, speed or sensible_speed(seconds), title or title_of(solution.system)
    )


def layers_of(shown: Any) -> tuple[str, ...]:
    """Names of layers, checked."""
    if isinstance(shown, str) or not isinstance(shown, Iterable):
        raise ValueError(f"animate: shown = {shown!r}; give a list of layers, e.g. ['angular velocity']")
    for layer in (shown := tuple(shown)):
        if layer not in ALL:
            raise ValueError(f"animate: shown: layer {layer!r} is unknown; give some of {', '.join(ALL)}")
    return shown


def check_options(user: str, path: Any, title: Any, dark: Any, live: Any) -> None:
    """ValueError for options of another type, and for a folder that is not there: before the work, not after it."""
    if not (path is None or isinstance(path, str | os.PathLike)):
        raise ValueError(f"{user}: path = {path!r}; give the name of a file, or None")
    if path is not None:
        with_suffix(path, ".html")
    if path is not None and not Path(path).parent.is_dir():
        raise ValueError(f"{user}: '{path}' cannot be written: there is no folder '{Path(path).parent}'; make it first")
    if not (title is None or isinstance(title, str)):
        raise ValueError(f"{user}: title = {title!r}; give a text, or None")
    if dark is not None and not isinstance(dark, bool | np.bool_):
        raise ValueError(f"{user}: dark = {dark!r}; give True, False, or None for what the reader's system prefers")
    if not isinstance(live, bool | np.bool_):
        raise ValueError(f"{user}: live = {live!r}; give True for a server on this machine, or False")


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
