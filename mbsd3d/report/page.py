"""Page of a report.

Its figures are vector graphics whose colours follow the reader's light or dark paper; it prints on A4. The time the run
took is left out, so the same run gives the same bytes.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..base.concurrency import on_one_thread
from ..base.errors import InputError
from ..base.style import theme
from ..base.templates import HtmlPage, page_template
from ..base.wording import digits, relative
from ..constraints.redundancy import diagnose
from ..plotting.panels import Wanted
from ..results.certificate import certificate_of
from ..results.checks.check import Check
from ..results.result import RunResult
from ..view.scene.drawing import title_of
from . import facts
from .exhibits import figure_of, picture_of, wanted_curves

FIT_TOLERANCE_DEFAULT = 1e-5  # [m] play of real parts, as `System.check` takes it
BAR_DECADES = 16.0  # [1] decades of the certificate's bars, from 1e-16 to 1
MEANING = {
    "joint gaps": "the joints stay closed",
    "joint velocities": "the joints are not torn apart",
    "orientations": "bodies turn by their angular velocities",
    "turns of hinges": "no turn is miscounted",
    "signals": "steps follow the sines",
    "contacts": "steps see bodies touch",
    "overlap": "contacts let no body through",
    "held loads": "locks and friction bear no more than they can",
    "energy balance": "energy changes by the work done",
    "momentum balance": "momentum changes by the impulse",
    "angular momentum": "it changes by the angular impulse",
    "Newton-Euler": "every body obeys its equations",
    "acceleration rows": "accelerations keep them closed",
    "accelerations": "rounding does not move the bodies",
    "reactions": "rounding does not load the joints",
}


@dataclass(frozen=True, repr=False)
class Report(HtmlPage):
    """Offline HTML page about a run; ``passed`` is the verdict of its certificate."""

    html: str
    title: str
    passed: bool

    def __repr__(self) -> str:
        verdict, size = "passed" if self.passed else "FAILED", len(self.html.encode()) / 1000
        return f"<report '{self.title}': {verdict}, {size:.0f} kB; .save(path) writes it, a browser shows it>"


@on_one_thread  # many small decompositions, for which threads cost more than they save
def make_report(
    solution: RunResult, path: str | Path | None, *, title: str | None, curves: Wanted | None, dark: bool | None
) -> Report:
    """Build the report page of a solution: certificate, curves and tables."""
    if not solution.t.size:
        raise InputError("report: the solution has no samples; run it to a later time")
    if title is not None and not isinstance(title, str):
        raise InputError(f"report: title {title!r} is not a text; give one, or None")
    if dark is not None:
        theme(dark)
    record, certificate = solution.record, certificate_of(solution)
    diagnosis = diagnose(solution.system, record.tolerance * solution.compiled.model.length or FIT_TOLERANCE_DEFAULT)
    title = title if title is not None else title_of(solution.system)
    few, thin = facts.thinned(solution)
    figures = [figure_of(k, *wanted) for k, wanted in enumerate(wanted_curves(solution, few, curves))]
    page = page_template("report.html").render(
        title=title,
        solution=solution,
        certificate=certificate,
        checks=[check_row(check) for check in certificate.checks],
        warnings=[*facts.warnings(solution), *([f"Reactions and efforts: {thin}"] if thin else [])],
        picture=picture_of(solution, dark),
        run=facts.run_facts(solution),
        drift=facts.drift_facts(solution),
        freedoms=facts.freedom_facts(diagnosis),
        figures=figures,
        tables=facts.tables(solution, few, diagnosis),
        digits=digits,
        paper={None: "auto", True: "dark", False: "light"}[None if dark is None else bool(dark)],
    )
    report = Report(page, title, certificate.passed)
    if path is not None:
        report.save(path)
    return report


def check_row(check: Check) -> dict[str, str | bool | float]:
    """Return A check with the places of error and limit on a logarithmic bar [%]."""

    def place(value: float) -> float:
        return round(100.0 * min(max(np.log10(max(value, 1e-300)) / BAR_DECADES + 1.0, 0.0), 1.0), 2)

    finite = np.isfinite(check.error)
    return {
        "name": check.name,
        "meaning": MEANING.get(check.name, check.meaning) if check.passed else check.meaning,
        "error": relative(check.error, count=2) if finite else "not a number",
        "limit": relative(check.limit),
        "passed": check.passed,
        "bar": place(check.error) if finite else 100.0,
        "mark": place(check.limit),
    }
