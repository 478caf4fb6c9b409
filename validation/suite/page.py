"""The report as one HTML file that needs no network: verdicts of all cases, and a section for each."""

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import mbsd3d
from mbsd3d.files import package_version
from mbsd3d.report.wording import digits
from mbsd3d.style import DARK, LIGHT

from . import table
from .findings import AGREES, DIFFERS, EXPLAINED, JUDGES, NOT_COMPARED, Finding, Record

MARKS = {AGREES: "✓", EXPLAINED: "≈", DIFFERS: "✗", NOT_COMPARED: "–"}
CLASSES = {AGREES: "pass", EXPLAINED: "pass", DIFFERS: "fail", NOT_COMPARED: "none"}
TEMPLATE = "validation.html"


def page_of(records: Sequence[Record], content: Mapping[str, Any]) -> str:
    """The whole page.

    Parameters
    ----------
    records : sequence of Record
        In the order of the report.
    content : mapping
        Of `document.content_of`: machine, versions, verdict.

    Returns
    -------
    str
        HTML; every text of a case is escaped.
    """
    groups = {name: [r for r in records if r.group == name] for name in dict.fromkeys(r.group for r in records)}
    return template().render(
        content=content,
        groups=groups,
        judges=table.columns_of(records),
        counted=table.counted(records),
        differences=table.differences(records),
        omissions=table.omissions(records),
        meaning=JUDGES,
        light=LIGHT,
        dark=DARK,
        version=package_version(),
    )


@cache
def template() -> Any:
    """Template of the page; every text that is put into it is escaped."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    folders = [Path(__file__).parents[1] / "templates", Path(mbsd3d.__file__).parent / "templates"]
    options = {"autoescape": True, "undefined": StrictUndefined, "trim_blocks": True, "lstrip_blocks": True}
    found = Environment(loader=FileSystemLoader(folders), **options)
    found.filters |= {"number": number, "cell": cell, "key": anchor, "svg": svg}
    found.globals |= {"marks": MARKS, "classes": CLASSES, "many": table.MANY}
    return found.get_template(TEMPLATE)


def number(value: Any) -> str:
    """Two digits, nothing for None."""
    return "" if value is None else digits(float(value), count=2)


def cell(finding: Finding | None) -> dict[str, str]:
    """Text, class and tip of a cell of the overview."""
    if finding is None:
        return {"text": "", "kind": "", "tip": ""}
    shown = "" if finding.verdict == NOT_COMPARED else number(finding.error) if finding.error else ""
    text = f"{MARKS[finding.verdict]} {shown}".strip()
    return {"text": text, "kind": CLASSES[finding.verdict], "tip": finding.note or finding.quantity}


def anchor(name: str) -> str:
    """Id of a case on the page."""
    return "case-" + "".join(c if c.isalnum() else "-" for c in name)


def svg(text: str) -> Any:
    """A chart made by `mbsd3d.report.exhibits.inline_svg`: the only markup that is not escaped."""
    from markupsafe import Markup

    return Markup(text)
