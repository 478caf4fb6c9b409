"""HTML pages that need no network: templates of this package on one base, in the house style of the reports."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

import mbsd3d
from mbsd3d.extend import DARK, LIGHT, package_version

FOLDERS = (Path(__file__).parent / "templates", Path(mbsd3d.__file__).parent / "templates")


def environment(filters: Mapping[str, Callable] | None = None, **names: Any) -> Environment:
    """Templates with filters and names of their own; all text that is put into them is escaped."""
    found = Environment(
        loader=FileSystemLoader(FOLDERS), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True,
    )  # fmt: skip
    found.filters |= dict(filters or {})
    found.globals |= {"light": LIGHT, "dark": DARK, "version": package_version(), **names}
    return found
