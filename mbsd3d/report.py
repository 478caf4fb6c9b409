"""The report of a run: one page, for a reader who must be convinced, that needs neither a network nor this package.

Its figures are vector graphics whose colours follow the reader's light or dark paper; it prints on A4. What it says in
numbers stands in `mbsd3d.facts`. The time the run took is left out, so the same run gives the same bytes.
"""

import html
import io
import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from .facts import (
    body_table,
    digits,
    drift_facts,
    driver_table,
    force_table,
    freedom_facts,
    joint_table,
    loaded_joints,
    run_facts,
    thinned,
    warnings,
)  # fmt: skip
from .files import package_version, with_suffix, write_atomically
from .style import DARK, LIGHT, house

LINES = 6  # of a figure that is chosen here
DECADES = 16.0  # of the certificate's bars, from 1e-16 to 1
MEANING = {
    "joint gaps": "the joints stay closed",
    "joint velocities": "the joints are not torn apart",
    "energy balance": "energy changes by the work done, and by nothing else",
    "momentum balance": "momentum changes by the impulse of the forces, and by nothing else",
    "angular momentum": "so does angular momentum",
    "Newton-Euler": "force = mass × acceleration for each body",
    "acceleration rows": "the accelerations keep the joints closed",
}


@dataclass(frozen=True, repr=False)
class Report:
    """One offline HTML page about a run.

    Attributes
    ----------
    html : str
        The whole page.
    title : str
    passed : bool
        Verdict of the certificate.
    """

    html: str
    title: str
    passed: bool

    def __repr__(self) -> str:
        verdict, size = "passed" if self.passed else "FAILED", len(self.html.encode()) / 1000
        return f"<report '{self.title}': {verdict}, {size:.0f} kB; .save(path) writes it, a browser shows it>"

    def _repr_html_(self) -> str:
        """In a notebook: a frame of its own, so that its style stays its own."""
        return f'<iframe srcdoc="{html.escape(self.html)}" style="width:100%;height:60em;border:0"></iframe>'

    def save(self, path: str | Path) -> Path:
        """Write the page; ".html" is appended if it is missing, an older file is replaced in one go.

        Raises
        ------
        ValueError
            If the folder cannot be written.
        """
        return write_atomically(with_suffix(path, ".html"), self.html.encode())


def make_report(
    solution: Any,
    path: str | Path | None = None,
    *,
    title: str | None = None,
    curves: Any = None,
    dark: bool | None = None,
) -> Report:
    """A page about a run: verdict, certificate, curves, freedoms, and tables of all parts.

    Parameters
    ----------
    solution : Solution
        At least one sample.
    path : str or Path, optional
        Where to write it as well.
    title : str, optional
        None = the names of the bodies.
    curves : sequence of str and (str, part, ...), optional
        One figure each, as `Solution.plot` takes them; None = the ones that tell most.
    dark : bool, optional
        Dark or light paper; None = as the reader's screen is set. It prints on light paper anyway.

    Returns
    -------
    Report

    Raises
    ------
    ValueError
        For a solution without samples, an unknown quantity or part, or a folder that cannot be written.
    """
    if not solution.t.size:
        raise ValueError("report: the solution has no samples; run it to a later time")
    if title is not None and not isinstance(title, str):
        raise ValueError(f"report: title {title!r} is no text; give one, or None")
    record, certificate = solution.record, solution.certificate
    as_built = {"as_built": record.tolerance * solution.compiled.model.length} if record.tolerance else {}
    diagnosis = solution.system.check(**as_built)
    title = title if title is not None else title_of(solution.system)
    tables = [body_table(solution), joint_table(solution, diagnosis), driver_table(solution), force_table(solution)]
    page = template().render(
        title=title,
        version=package_version(),
        certificate=certificate,
        checks=[check_row(check) for check in certificate.checks],
        warnings=warnings(solution),
        picture=picture_of(solution, dark),
        run=run_facts(solution),
        drift=drift_facts(solution),
        freedoms=freedom_facts(diagnosis),
        figures=[figure_of(solution, k, *wanted) for k, wanted in enumerate(wanted_curves(solution, curves))],
        tables=[table for table in tables if table.rows],
        digits=digits,
        light=LIGHT,
        dark=DARK,
        paper={None: "auto", True: "dark", False: "light"}[None if dark is None else bool(dark)],
    )
    report = Report(page, title, certificate.passed)
    if path is not None:
        report.save(path)
    return report


@cache
def template() -> Any:
    """The page; every text that is put into it is escaped."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    folder = Path(__file__).parent / "templates"
    options = {"autoescape": True, "undefined": StrictUndefined, "trim_blocks": True, "lstrip_blocks": True}
    return Environment(loader=FileSystemLoader(folder), **options).get_template("report.html")


def title_of(system: Any) -> str:
    """The names of the bodies, the first ones of many."""
    names = [body.name for body in system.bodies]
    if len(names) == 1:
        return names[0]
    if len(names) <= 4:
        return f"{', '.join(names[:-1])} and {names[-1]}"
    return f"{', '.join(names[:3])} and {len(names) - 3} more bodies"


def check_row(check: Any) -> dict[str, Any]:
    """A check with the places of error and limit on a logarithmic bar [%]."""

    def place(value: float) -> float:
        return round(100.0 * min(max(np.log10(max(value, 1e-300)) / DECADES + 1.0, 0.0), 1.0), 2)

    finite = np.isfinite(check.error)
    return {
        "name": check.name,
        "meaning": MEANING.get(check.name, check.meaning) if check.passed else check.meaning,
        "error": digits(check.error, count=2) if finite else "not a number",
        "limit": digits(check.limit, count=2),
        "passed": check.passed,
        "bar": place(check.error) if finite else 100.0,
        "mark": place(check.limit),
    }


def wanted_curves(solution: Any, curves: Any) -> list[tuple[Any, str]]:
    """(entry for `plot`, caption) of every figure."""
    if curves is not None:
        if isinstance(curves, str):
            raise ValueError(f"report: curves {curves!r} is a single text; give a list, e.g. ['energy']")
        return [(entry, "") for entry in curves]
    if solution.t.size == 1:
        return []
    system, found = solution.system, [("energy", "Energies, and the work of drivers and of forces that store none.")]
    for kind, name in (("angle", "Angles"), ("slide", "Displacements")):
        joints = [joint for joint in system.joints if getattr(joint, kind)() is not None]
        moved = {id(joint): float(np.ptp(getattr(solution, kind)(joint))) for joint in joints}
        chosen = most(joints, moved)
        if chosen:
            cut = f" that change most, {len(chosen)} of {len(joints)}" if len(joints) > len(chosen) else ""
            found.append(((kind, *chosen), f"{name} of the joints{cut}."))
    few, _ = thinned(solution, len(system.joints))
    joints = loaded_joints(solution)[0]
    loads = {id(joint): float(np.linalg.norm(few.reaction(joint).force, axis=1).max()) for joint in joints}
    chosen = most(joints, loads)
    if chosen:
        cut = f" with the largest forces, {len(chosen)} of {len(joints)}" if len(joints) > len(chosen) else ""
        found.append((("reaction", *chosen), f"Reactions of the joints{cut}."))
    if solution.compiled.drives:
        found.append(("effort", "Efforts of the drivers."))
    if not joints:
        shown = system.bodies[:LINES]
        found.append((("omega_body", *shown), "Angular velocity in body axes."))
        found.append((("com", *shown), "Centre of mass."))
    return found


def most(parts: list, sizes: dict[int, float]) -> list:
    """The parts with the largest sizes, in the order of the model."""
    kept = sorted(parts, key=lambda part: -sizes[id(part)])[:LINES]
    return [part for part in parts if part in kept]


def figure_of(solution: Any, number: int, entry: Any, caption: str) -> dict[str, Any]:
    """A figure as inline SVG, with a caption and a text for those who do not see it."""
    from markupsafe import Markup

    from .plots import plot_quantity

    figure = plot_quantity(solution, [entry])
    figure.set_size_inches(7.5, 0.85 + 1.75 * len(figure.axes))  # three of one panel go on an A4 page
    labels = ", ".join(axes.get_ylabel().replace("\n", " ") for axes in figure.axes)
    return {"svg": Markup(inline_svg(figure, f"f{number}-")), "caption": caption, "label": f"{labels} over time"}


def inline_svg(figure: Any, prefix: str) -> str:
    """A figure as an SVG element for a page: ids of its own, colours as variables of the page (see report.html)."""
    buffer = io.StringIO()
    with house():
        figure.savefig(buffer, format="svg", metadata=dict.fromkeys(("Creator", "Date", "Format", "Type")))
    text = buffer.getvalue()
    text = re.sub(r"<!--.*?-->|<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.S)
    text = re.sub(r' (width|height)="[\d.]+pt"', "", text, count=2)
    text = re.sub(r'\b(id="|href="#|url\(#)', rf"\g<1>{prefix}", text)
    # a hundredth of a point is enough for the eye
    text = re.sub(r'\bd="[^"]*"', lambda d: re.sub(r"(\.\d\d)\d+", r"\1", d.group()), text)
    names = {LIGHT.paper: "paper", LIGHT.ink: "ink", LIGHT.muted: "muted", LIGHT.grid: "grid"}
    names |= {tint: f"line{k}" for k, tint in enumerate(LIGHT.lines)}
    for tint, name in names.items():
        text = re.sub(tint, f"var(--{name})", text, flags=re.I)
    return re.sub(r"\n\s*", "\n", text)


def picture_of(solution: Any, dark: bool | None) -> Any:
    """The mechanism as an image, or None as long as there is no painter."""
    return None
