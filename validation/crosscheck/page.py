"""The result as one HTML page that needs no network and prints on A4."""

from pathlib import Path
from typing import Any

from .display import number, summary, verdict
from .verdict import CrossCheck, Finding

FOLDER = Path(__file__).parent.parent / "templates"


def page(check: CrossCheck, title: str, pictures: tuple[dict[str, str], ...] = ()) -> str:
    """The page; ``pictures`` of the mechanism as {"kind": "on-light" or "on-dark", "data": a data: address}."""
    from jinja2 import ChoiceLoader, Environment, FileSystemLoader, PackageLoader
    from markupsafe import Markup

    from mbsd3d.extend import DARK, LIGHT, inline_svg

    loader = ChoiceLoader([FileSystemLoader(FOLDER), PackageLoader("mbsd3d")])
    template = Environment(loader=loader, autoescape=True, trim_blocks=True).get_template("cross_check.html")
    return template.render(
        title=title, check=check, summary=summary(check), numbers=numbers, verdict=verdict, light=LIGHT, dark=DARK,
        pictures=pictures, figure=Markup(inline_svg(check.figure(), "c-")),
    )  # fmt: skip


def numbers(finding: Finding) -> list[Any]:
    """Cells of a row of the table."""
    forms = ((finding.difference, ".1e"), (finding.uncertainty, ".0e"), (finding.order, ".2f"), (finding.until, ".4g"))
    return [number(value, form).strip() for value, form in forms]
