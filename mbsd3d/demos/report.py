"""A demo on paper: its table as text, and its files."""

import textwrap
from pathlib import Path

from ..plotting.plots import save_figure
from .base import Demo, Outcome, Row

WIDTH = 100
HEAD = ("quantity", "computed", "theory", "error")


def table(rows: tuple[Row, ...]) -> str:
    """The rows of a demo as ``quantity | computed | theory | error``, FAIL beside those beyond their tolerance."""
    cells = [HEAD]
    for row in rows:
        quantity = f"{row.quantity} [{row.unit}]" if row.unit else row.quantity
        cells.append((quantity, f"{row.computed:.12g}", f"{row.theory:.12g}", f"{row.error:.1e}"))
    widths = [max(len(line[k]) for line in cells) for k in range(len(HEAD))]
    lines = [" | ".join([line[0].ljust(widths[0]), *map(str.rjust, line[1:], widths[1:])]) for line in cells]
    rule = "-+-".join("-" * width for width in widths)
    marks = ["" if row.passed else f"  FAIL, limit {row.tolerance:.0e}" for row in rows]
    marked = [line + mark for line, mark in zip(lines[1:], marks, strict=True)]
    return "\n".join(f"  {line}" for line in [lines[0], rule, *marked])


def report(demo: Demo, outcome: Outcome) -> str:
    """Title, why, source, table and notes of a demo."""
    lines = [f"{demo.name}: {demo.title}"]
    for label, text in (("why", demo.why), ("source", demo.source)):
        lines += textwrap.wrap(text, WIDTH, initial_indent=f"  {label:8}", subsequent_indent=" " * 10)
    lines += ["", table(outcome.rows)]
    for note in outcome.notes:
        lines += textwrap.wrap(note, WIDTH, initial_indent="  ", subsequent_indent="    ")
    return "\n".join(lines)


def write(demo: Demo, outcome: Outcome, folder: Path, *, pages: bool = True) -> list[Path]:
    """Write the figure as <demo>.png and <demo>.svg, every run as <run>.npz and <run>.csv, every view as <view>.html.

    The views, written if ``pages``, need the package viser.
    """
    outcome.figure.get_layout_engine().execute(outcome.figure)
    outcome.figure.set_layout_engine("none")  # placed once, not again for each format
    written = save_figure(outcome.figure, folder / demo.name)
    for name, solution in outcome.solutions.items():
        written += [solution.save(folder / name), solution.to_csv(folder / name)]
    for name, (solution, options) in outcome.views.items() if pages else ():
        written.append(solution.animate(**{"title": demo.title, **options}).save(folder / name))
    return written


def listing(paths: list[Path]) -> str:
    """The files of a demo, the suffixes of one stem together."""
    stems: dict[Path, list[str]] = {}
    for path in paths:
        stems.setdefault(path.with_suffix(""), []).append(path.suffix)
    text = ", ".join(f"{stem}{'|'.join(suffixes)}" for stem, suffixes in stems.items())
    return textwrap.fill(text, WIDTH, initial_indent="  written ", subsequent_indent=" " * 10, break_on_hyphens=False)
