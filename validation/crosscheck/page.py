"""Result of a cross-check as one HTML page that needs no network and prints on A4."""

from pathlib import Path
from typing import Any

from markupsafe import Markup

from mbsd3d.extend import inline_svg, page_template
from validation.crosscheck.result import CrossCheck, Finding, number, summary, verdict

TEMPLATES = Path(__file__).parents[1] / "templates"


def page(check: CrossCheck, title: str) -> str:
    """Render the whole page."""
    return page_template("cross_check.html", TEMPLATES).render(
        title=title, check=check, summary=summary(check), numbers=numbers, verdict=verdict,
        figure=Markup(inline_svg(check.figure(), "c-")),
    )  # fmt: skip


def numbers(finding: Finding) -> list[Any]:
    """Return the cells of a row of the table."""
    forms = ((finding.difference, ".1e"), (finding.uncertainty, ".0e"), (finding.order, ".2f"), (finding.until, ".4g"))
    return [number(value, form).strip() for value, form in forms]
