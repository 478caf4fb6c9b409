"""One HTML file that needs nothing else: the scene of viser, a player, switches, and curves beside it."""

import html
import json
import re
from dataclasses import dataclass
from functools import cache
from importlib.resources import files as resources
from pathlib import Path
from typing import Any

from ...base.paths import with_suffix, write_atomically
from .browser import has_browser, printable
from .content import Content, scene_and_data
from .recorder import client_head

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

        path = self.save(Path(tempfile.mkdtemp(prefix="mbsd3d-")) / "view.html")
        if not has_browser() or not webbrowser.open(path.as_uri()):
            raise ValueError(f"no browser could be started; open '{path}' in one, or use .save(path)")
        return path


@cache
def asset(name: str) -> str:
    """A text of the folder assets."""
    return (resources("mbsd3d.view.page") / "assets" / name).read_text(encoding="utf-8")


def make_page(content: Content, dark: bool | None, user: str) -> str:
    """The whole page."""
    from jinja2 import Environment
    from markupsafe import Markup

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
    return template.render(
        title=printable(content.title),
        moving=content.frames.t.size > 1,
        timed=content.timed,
        curves=bool(content.curves),
        **{name: Markup(text) for name, text in texts.items()},
    )


def as_script(data: dict[str, Any]) -> str:
    """JSON that cannot end the script element it stands in, whatever names are in it."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return printable(re.sub("[<>&\u2028\u2029]", lambda found: f"\\u{ord(found[0]):04x}", text))
