"""One HTML file that needs nothing else: the scene of viser, a player, switches, and curves beside it."""

import html
import json
import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from importlib.resources import files as resources
from pathlib import Path
from typing import Any

import numpy as np

from ..files import with_suffix, write_atomically
from ..parts import number
from ..progress import Progress
from .content import Content, scene_and_data, sensible_speed
from .drawing import draw_system, poses_of
from .motion import Frames, arrows_of, curves_of, frames_of, traces_of
from .recorder import client_head
from .stage import ALL

LARGEST = 9e6  # characters of a page whose number of frames was not asked for
SCRIPTS = ("unpack.js", "scene.js", "curves.js", "player.js")


@dataclass(frozen=True, eq=False, repr=False)
class View:
    """A page that shows a mechanism; one HTML text that works from a file, without a network.

    Examples
    --------
    >>> from mbsd3d import Body, System
    >>> view = System([Body("stone", mass=1.5, inertia=(1, 2, 2))]).show()
    >>> path = view.save("stone.html")  # doctest: +SKIP
    """

    html: str
    bodies: int
    frames: int
    seconds: float  # of model time

    def __repr__(self) -> str:
        bodies = f"{self.bodies} {'body' if self.bodies == 1 else 'bodies'}"
        motion = f"{self.frames} frames of {self.seconds:g} s, " if self.frames > 1 else ""
        return f"<view: {bodies}, {motion}{len(self.html.encode()) / 1e6:.2f} MB; .save(path) or .open()>"

    def _repr_html_(self) -> str:
        """A frame in a notebook."""
        style = "width:100%;height:560px;border:1px solid #ccc"
        return f'<iframe srcdoc="{html.escape(self.html)}" style="{style}" title="mechanism"></iframe>'

    def save(self, path: str | Path) -> Path:
        """Write the page whole or not at all; ".html" is appended if it is missing, an older file is replaced.

        Raises
        ------
        ValueError
            If the folder does not exist or cannot be written.
        """
        return write_atomically(with_suffix(path, ".html"), self.html.encode("utf-8"))

    def open(self) -> Path:
        """Write the page to a folder for temporary files and show it in the browser; returns the file.

        Raises
        ------
        ValueError
            If no browser can be started.
        """
        import tempfile
        import webbrowser

        from .live import has_browser

        path = self.save(Path(tempfile.mkdtemp(prefix="mbsd3d-")) / "view.html")
        if not has_browser() or not webbrowser.open(path.as_uri()):
            raise ValueError(f"no browser could be started; open '{path}' in one, or use .save(path)")
        return path


@cache
def asset(name: str) -> str:
    """A text of the folder assets."""
    return (resources("mbsd3d.view") / "assets" / name).read_text(encoding="utf-8")


def make_page(content: Content, dark: bool | None, user: str) -> str:
    """The whole page."""
    from jinja2 import Environment

    scene, data = scene_and_data(content, user)
    texts = {
        "style": asset("player.css"),
        "scene": scene,
        "client": client_head(),
        "data": as_script(data),
        "script": "\n".join(asset(name) for name in SCRIPTS),
        "dark": json.dumps(dark),
    }
    template = Environment(autoescape=True, keep_trailing_newline=True).from_string(asset("page.html"))
    from markupsafe import Markup

    return template.render(
        title=printable(content.title),
        moving=content.frames.t.size > 1,
        curves=bool(content.curves),
        **{name: Markup(text) for name, text in texts.items()},
    )


def as_script(data: dict[str, Any]) -> str:
    """JSON that cannot end the script element it stands in, whatever names are in it."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return printable(re.sub("[<>&\u2028\u2029]", lambda found: f"\\u{ord(found[0]):04x}", text))


def printable(text: str) -> str:
    """The text with "?" for what no file can hold (halves of surrogate pairs)."""
    return text.encode("utf-8", "replace").decode("utf-8")


def show_system(
    system: Any, path: str | Path | None, state: Any, title: str | None, dark: bool | None, live: bool
) -> Any:
    """See `System.show`."""
    check_options(title, dark)
    r, e = poses_of(system, state)
    t = np.array([0.0 if state is None else state.t])
    drawing = draw_system(system)
    content = Content(drawing, Frames(t, r[None], e[None]), [], [], [], 1.0, title or "reference pose")
    return deliver(system, content, path, dark, live, "system.show")


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
    check_options(title, dark)
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
            view = deliver(solution.system, content, None, dark, live, "solution.animate")
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
    lines = curves_of(solution, frames, curves)
    progress.update(4.0)
    seconds = float(frames.t[-1] - frames.t[0])
    return Content(drawing, frames, arrows, paths, lines, speed or sensible_speed(seconds), title or "motion")


def layers_of(shown: Any) -> tuple[str, ...]:
    """Names of layers, checked."""
    if isinstance(shown, str) or not isinstance(shown, Iterable):
        raise ValueError(f"animate: shown = {shown!r}; give a list of layers, e.g. ['angular velocity']")
    for layer in (shown := tuple(shown)):
        if layer not in ALL:
            raise ValueError(f"animate: shown: layer {layer!r} is unknown; give some of {', '.join(ALL)}")
    return shown


def check_options(title: Any, dark: Any) -> None:
    """ValueError for options of another type."""
    if not (title is None or isinstance(title, str)):
        raise ValueError(f"title = {title!r}; give a text, or None")
    if dark is not None and not isinstance(dark, bool | np.bool_):
        raise ValueError(f"dark = {dark!r}; give True, False, or None for what the reader's system prefers")


def deliver(system: Any, content: Content, path: str | Path | None, dark: bool | None, live: bool, user: str) -> Any:
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
