"""One HTML file that needs nothing else: the scene of viser, a player, switches, and curves beside it."""

import json
import os
import re
import sys
import tempfile
import webbrowser
from dataclasses import dataclass
from functools import cache
from importlib.resources import files as resources
from pathlib import Path

from markupsafe import Markup

from ...base.errors import InputError
from ...base.paths import as_path
from ...base.templates import HtmlPage, page_template
from .content import Content, scene_and_data
from .recorder import client_head, printable

SCRIPTS = ("unpack.js", "scene.js", "curves.js", "common.js", "player.js")
SOLVING_SCRIPTS = ("solver.js", "explore.js", "ridden.js")  # of pages that solve, before the player


OTHER_FILES = {  # ending -> what writes such a file
    **dict.fromkeys((".mp4", ".mov", ".avi", ".webm"), "export_mp4(path) writes a film"),
    ".gif": "export_gif(path) writes a film",
    **dict.fromkeys((".png", ".svg", ".pdf", ".jpg"), "save_figure of a picture() writes a picture"),
    **dict.fromkeys((".glb", ".gltf"), "export_glb(path) writes a scene"),
}


@dataclass(frozen=True, eq=False, repr=False)
class View(HtmlPage):
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

    def save(self, path: str | Path) -> Path:
        """Write the page; ".html" is appended if missing.

        ValueError if the folder cannot be written, and for the name of a film or a picture.
        """
        ending = as_path(path, "view.html").suffix.lower()
        if ending in OTHER_FILES:
            raise InputError(f"'{path}': a view is a page (.html); {OTHER_FILES[ending]}")
        return super().save(path)

    def open(self) -> Path:
        """Write the page to a temporary file and show it in the browser; ValueError if there is none."""
        path = self.save(Path(tempfile.mkdtemp(prefix="mbsd3d-")) / "view.html")
        if not has_browser() or not webbrowser.open(path.as_uri()):
            raise InputError(f"no browser could be started; open '{path}' in one, or use .save(path)")
        return path


def has_browser() -> bool:
    """Return True if a browser window can be opened here."""
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return False
    try:
        webbrowser.get()
    except webbrowser.Error:
        return False
    return True


@cache
def asset(name: str, package: str = "mbsd3d.view.page") -> str:
    """Return a text of the folder assets of a package."""
    return (resources(package) / "assets" / name).read_text(encoding="utf-8")


def make_page(content: Content, dark: bool | None, user: str) -> str:
    """Return the HTML of the whole page."""
    scene, data = scene_and_data(content, user)
    solver, explore, ride = SOLVING_SCRIPTS
    solving = [explore] * (content.explore is not None) + [ride] * (content.ride is not None)
    scripts = (*SCRIPTS[:-1], *([solver, *solving] if solving else ()), SCRIPTS[-1])
    texts = {
        "style": asset("player.css"),
        "scene": scene,
        "client": client_head(),
        "data": as_script(data),
        "script": "\n".join(map(asset, scripts)),
        "dark": json.dumps(dark),
    }
    return page_template("player.html").render(
        title=printable(content.title),
        moving=content.frames.t.size > 1,
        timed=content.timed,
        curves=bool(content.curves),
        explore=content.explore is not None,
        ride=content.ride is not None,
        captions=any(text for _, text in content.captions),
        **{name: Markup(text) for name, text in texts.items()},
    )


def as_script(data: dict[str, object]) -> str:
    """Return JSON that cannot end the script element around it, whatever names it holds."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return printable(re.sub("[<>&\u2028\u2029]", lambda found: f"\\u{ord(found[0]):04x}", text))
