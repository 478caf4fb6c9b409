"""HTML pages and their templates, which other packages may extend."""

import html
from functools import cache
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template

from .paths import package_version, with_suffix, write_atomically
from .style import DARK, LIGHT
from .wording import digits, readable, relative

TEMPLATE_FOLDER = Path(__file__).parent.parent / "templates"


class HtmlPage:
    """One HTML text that works from a file, without a network."""

    html: str

    def _repr_html_(self) -> str:
        """Return the page for a notebook, in a frame of its own, so that its style does not leak."""
        style = "width:100%;height:560px;border:1px solid #ccc"
        return f'<iframe srcdoc="{html.escape(self.html)}" style="{style}" title="mbsd3d"></iframe>'

    def save(self, path: str | Path) -> Path:
        """Write the page; ".html" is appended if missing. ValueError if the folder cannot be written."""
        return write_atomically(with_suffix(path, ".html"), self.html.encode("utf-8", "replace"))


@cache
def page_template(name: str, *folders: Path) -> Template:
    """Return a template from the folders, or of this package; every text that is put into it is escaped.

    It knows the themes ``light`` and ``dark``, the ``version`` of this package, and how numbers are written: the
    functions ``digits`` and ``relative``, and the filter ``readable`` for texts that terminals print too.
    """
    loader = FileSystemLoader([*folders, TEMPLATE_FOLDER])
    found = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    found.globals |= {
        "light": LIGHT,
        "dark": DARK,
        "version": package_version(),
        "digits": digits,
        "relative": relative,
    }
    found.filters["readable"] = readable
    return found.get_template(name)
