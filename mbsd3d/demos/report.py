"""Demo as text and files: its table as text and as JSON, and its files."""

import json
import textwrap
from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path

from ..api.viewable import AnimateOptions
from ..base.wording import COMPARED_DIGITS, error_text
from ..plotting.plots import save_figure
from .base import Outcome, Row
from .discovery import discover
from .form import Demo

TEXT_WIDTH = 100
TABLE_HEAD = ("quantity", "computed", "theory", "error")


def table(rows: Sequence[Row], heads: Sequence[str] = TABLE_HEAD, beyond: str = "FAIL, limit {:.0e}") -> str:
    """Return the rows of a demo as ``quantity | computed | theory | error``, a word beside those beyond their
    tolerance."""
    cells = [tuple(heads)]
    for row in rows:
        numbers = (row.text(value, compared_text) for value in (row.computed, row.theory))
        cells.append((row.label, *numbers, error_text(row.error)))
    widths = [max(len(line[k]) for line in cells) for k in range(len(heads))]
    lines = [" | ".join([line[0].ljust(widths[0]), *map(str.rjust, line[1:], widths[1:])]) for line in cells]
    rule = "-+-".join("-" * width for width in widths)
    marks = ["" if row.passed else f"  {beyond.format(row.tolerance)}" for row in rows]
    marked = [line + mark for line, mark in zip(lines[1:], marks, strict=True)]
    return "\n".join(f"  {line}" for line in [lines[0], rule, *marked])


def compared_text(value: float) -> str:
    """Format a number for a terminal with the digits by which numbers are compared; the zero has no sign."""
    return f"{value + 0.0:.{COMPARED_DIGITS}g}"


def summary(found: Mapping[str, Sequence[Row]]) -> str:
    """Return the numbers of all demos as one table."""
    rows = [
        Row(f"{name}: {row.quantity}", row.computed, row.theory, row.tolerance, row.unit)
        for name, rows in found.items()
        for row in rows
    ]
    return table(rows)


def run_and_write(name: str, folder: Path, pages: bool) -> tuple[str, tuple[Row, ...]]:
    """Run a demo and write its files: its report, and its rows as plain numbers."""
    demo = discover()[name]
    outcome = demo.run()
    written = listing(write(demo, outcome, folder, pages=pages))
    return f"{report(demo, outcome)}\n{written}\n", outcome.rows


def report(demo: Demo, outcome: Outcome, without: str | None = None) -> str:
    """Return question, why, equation, source, table and notes of a demo."""
    lines = [f"{demo.name}: {demo.title}" + (f" (without {without})" if without else "")]
    for label in ("question", "why", "equation", "source"):
        lines += textwrap.wrap(
            getattr(demo, label), TEXT_WIDTH, initial_indent=f"  {label:10}", subsequent_indent=" " * 12
        )
    lines += ["", table(outcome.rows, beyond="differs, as it should") if without else table(outcome.rows)]
    for note in outcome.notes:
        lines += textwrap.wrap(note, TEXT_WIDTH, initial_indent="  ", subsequent_indent="    ")
    return "\n".join(lines)


def to_json(demo: Demo, outcome: Outcome, without: str | None = None) -> str:
    """Return one JSON object: name, parameters, and of each quantity computed, theory and error; null for numbers that
    are not finite.
    """
    quantities = {
        name: {key: finite(getattr(row, key)) for key in ("computed", "theory", "error")}
        for name, row in outcome.quantities.items()
    }
    found = {"demo": demo.name, "parameters": dict(outcome.parameters), "quantities": quantities}
    return json.dumps({**found, "without": without} if without else found, indent=1)


def finite(value: float) -> float | None:
    """Return a number that JSON can hold."""
    return float(value) if isfinite(value) else None


def write(demo: Demo, outcome: Outcome, folder: Path, *, pages: bool = True, without: str | None = None) -> list[Path]:
    """Write the figure as <demo>.png and <demo>.svg, every run as <run>.npz and <run>.csv, every view as <view>.html.

    The views, written if ``pages``, need the package viser. A demo whose only panel is theory over a parameter has no
    figure without a term.
    """
    written = []
    if outcome.panels:
        if layout := outcome.figure.get_layout_engine():
            layout.execute(outcome.figure)
        outcome.figure.set_layout_engine("none")  # placed once, not again for each format
        stem = f"{demo.name}_without_{without}" if without else demo.name
        written += save_figure(outcome.figure, folder / stem)
    for name, solution in outcome.solutions.items():
        written += [solution.save(folder / name), solution.to_csv(folder / name)]
    for name, (solution, options) in outcome.views.items() if pages else ():
        titled: AnimateOptions = {"title": demo.title, **options}
        written.append(solution.animate(**titled).save(folder / name))
    return written


def listing(paths: list[Path]) -> str:
    """Return the files of a demo as text, the suffixes of one stem together."""
    stems: dict[Path, list[str]] = {}
    for path in paths:
        stems.setdefault(path.with_suffix(""), []).append(path.suffix)
    text = ", ".join(f"{stem}{'|'.join(suffixes)}" for stem, suffixes in stems.items())
    return textwrap.fill(
        text, TEXT_WIDTH, initial_indent="  written ", subsequent_indent=" " * 10, break_on_hyphens=False
    )
