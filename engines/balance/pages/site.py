"""Pages of the engines: one for each layout, and an index with all layouts and the truth table.

``write_pages(folder)`` writes ``index.html``, ``I4.html`` ... and the animated engines ``views/I4.html`` ...
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from engines.balance import gas, report, spatial
from engines.balance.balance import Comparison, compare
from engines.balance.layouts import Engine, names
from engines.balance.pages import drawings, portrait
from engines.balance.pages.sheets import QUANTITIES, GasTorque, Sheet
from engines.balance.published.claims import Row
from engines.balance.published.truth import AGREES, rows
from mbsd3d.errors import InputError
from mbsd3d.extend import Progress, digits, page_template, readable, write_atomically

HARMONIC_ORDERS, TURN_SAMPLES = 6, 72  # harmonics; samples of a turn
PLAY_SCRIPT = (
    '<script type="module">if (!matchMedia("(prefers-reduced-motion: reduce)").matches) mbsd3d.play(true);</script>'
)
TEMPLATES = Path(__file__).parents[2] / "templates"
SOURCES = {"published_checks": "Articles and e-book, toy engine", "toy_set_2": "Animations, second toy engine"}


@dataclass(frozen=True)
class Pages:
    """Path of the index of pages that were written, and the comparisons on them."""

    index: Path
    comparisons: list[Comparison]  # Of the engines, in their order


def write_pages(
    folder: str | Path, engines: Sequence[Engine] | None = None, *, gravity: Any = (0.0, 0.0), driver: str = "block",
    peak: float = 10e3, progress: bool | None = None,
) -> Pages:  # fmt: skip
    """Write the pages of engines, by default of all layouts of the data file with the toy engine's masses.

    ``folder``: made if it is missing; older pages in it are replaced; ``engines``: of different names, identical and
    centred cylinders, not standing still; ``gravity`` (2,): in the plane of the cylinders [m/s^2]; ``driver``: where
    the driving torque reacts, "block" or "dyno"; ``peak``: of the gas force on a piston, half sines over the power
    strokes [N]; ``progress``: show a bar; None = on a terminal, after two seconds. ValueError for no engines, two of
    one name, an engine without the closed form, or a folder that cannot be written.
    """
    engines = [Engine(name) for name in names()] if engines is None else list(engines)
    if not engines:
        raise InputError("pages: no engines; give at least one, or None for all layouts of the data file")
    folder, files = Path(folder), file_names(engines)
    try:
        (folder / "views").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"pages: folder '{folder}' cannot be made ({error.strerror}); give another one") from error
    truth, sheets = rows(), []
    with Progress(f"pages of {len(engines)} engines", 0, 2 * len(engines), progress) as bar:
        for engine in engines:
            sheets.append(make_sheet(engine, gravity=gravity, driver=driver, peak=peak))
            bar.update(len(sheets))
        for k, (sheet, file) in enumerate(zip(sheets, files, strict=True)):
            view = portrait.shown(sheet.engine).animate(curves=(), traces=(), title=sheet.engine.layout.name)
            write_atomically(folder / "views" / file, playing(view.html).encode())
            page = render("engine.html", sheet=sheet, near=neighbours(sheets, files, k), file=file, truth=truth)
            write_atomically(folder / file, page.encode())
            bar.update(len(sheets) + k + 1)
    index = render("index.html", sheets=list(zip(sheets, files, strict=True)), truth=truth, shades=shades(sheets))
    return Pages(write_atomically(folder / "index.html", index.encode()), [sheet.comparison for sheet in sheets])


def playing(view: str) -> str:
    """Return a view that plays from the start, unless the reader asked for less motion."""
    body, end = view.rsplit("</body>", 1)
    return f"{body}{PLAY_SCRIPT}</body>{end}"


def file_names(engines: Sequence[Engine]) -> list[str]:
    """Return the file names of the pages: names of layouts with "-" in place of characters that file names cannot have.

    ValueError if two would be the same.
    """
    files = [re.sub(r"[^A-Za-z0-9_.+-]+", "-", engine.layout.name).strip(".") + ".html" for engine in engines]
    for engine, file in zip(engines, files, strict=True):
        if [other.lower() for other in (*files, "index.html")].count(file.lower()) > 1:
            raise InputError(f"pages: engine '{engine.layout.name}' would share '{file}' with another page; rename it")
    return files


def make_sheet(engine: Engine, *, gravity: Any = (0.0, 0.0), driver: str = "block", peak: float = 10e3) -> Sheet:
    """Compute harmonics by three methods, driving torque and gas torque of an engine."""
    comparison = compare(engine, HARMONIC_ORDERS, gravity=gravity, driver=driver)
    system = spatial.build(engine, driver=driver, gravity=(*gravity, 0.0))
    driving = spatial.turn(system, engine, count=TURN_SAMPLES).effort("motor")
    samples = 360.0 * np.arange(TURN_SAMPLES + 1) / TURN_SAMPLES, driving
    try:
        fired = gas.with_gas(system, engine, gas.half_sine(peak), TURN_SAMPLES)
    except gas.FiringOrderError:
        return Sheet(comparison, samples)
    both = spatial.turn(fired, engine, turns=2, count=TURN_SAMPLES).effort("motor")
    pushed = (np.concatenate([driving, driving[1:]]) - both)[::2]
    return Sheet(
        comparison, samples, GasTorque(engine, peak, (720.0 * np.arange(TURN_SAMPLES + 1) / TURN_SAMPLES, pushed))
    )


def neighbours(sheets: list[Sheet], files: list[str], k: int) -> list[tuple[str, str]]:
    """Return (file, name) of the pages before and after page k in a cycle, nothing for a single page."""
    if len(files) == 1:
        return []
    return [(files[i % len(files)], sheets[i % len(files)].engine.layout.name) for i in (k - 1, k + 1)]


def shades(sheets: list[Sheet]) -> dict[str, Any]:
    """Return the columns of the index, (kind, order) of any engine, and the largest relative value of each kind."""
    columns: list[tuple[str, int]] = []
    largest: dict[str, float] = {}
    for kind, _ in QUANTITIES:
        for order in sheets[0].orders:
            values = [relative(sheet, kind, order) for sheet in sheets]
            if max(values) > report.AMPLITUDE_ROUNDING:
                columns.append((kind, order))
                largest[kind] = max(largest.get(kind, 0.0), *values)
    return {"columns": columns, "largest": largest}


def relative(sheet: Sheet, kind: str, order: int) -> float:
    """Return the amplitude over F_single, F_single times spacing, or F_single times R [-]."""
    engine = sheet.engine
    size = {"force": 1.0, "couple": engine.spacing, "torque": engine.radius}[kind] * engine.single
    value = sheet.torque(order) if kind == "torque" else sheet.harmonics(kind)[order - 1].axes[0]
    return value / size if value > sheet.noise else 0.0


def shade(value: float, largest: float) -> int:
    """Return the strength of a cell's colour [%], in proportion to the root so that small values are visible."""
    return 0 if value == 0.0 else int(round(8 + 47 * (value / largest) ** 0.5))


def figure(x: Any) -> str:
    """Format a figure of the truth table: six digits, 0 for rounding, an en dash between two values, nothing for
    None."""
    if isinstance(x, tuple):
        return " \u2026 ".join(figure(part) for part in x)
    return readable(report.value(x))


def mark(row: Row) -> str:
    """Return "pass" or "fail" for a published figure, or nothing if it or the true figure is missing.

    It is if the verdict says so, or if it is the true one rounded to its own two or more decimals.
    """
    if row.published is None or row.actual is None or isinstance(row.actual, tuple):
        return ""
    decimals = len(str(row.published).partition(".")[2])
    rounded = decimals >= 2 and abs(row.published - row.actual) <= 0.5 * 10.0**-decimals
    return "pass" if rounded or AGREES in row.verdict else "fail"


def render(name: str, truth: list[Row], **values: Any) -> str:
    """Render a page from a template."""
    return page_template(name, TEMPLATES).render(
        truth=truth, marks=[mark(row) for row in truth], mark=mark, figure=figure, digits=digits, drawings=drawings,
        sketch=portrait.sketch, relative=relative, shade=shade, quantities=QUANTITIES, sources=SOURCES,
        orders=HARMONIC_ORDERS,
        ways=report.ways, **values,
    )  # fmt: skip
