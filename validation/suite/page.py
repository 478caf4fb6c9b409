"""Reports of a run: one HTML file that needs no network, and JSON with every finding, in SI units.

format    1; rises when a field changes its meaning
mbsd3d    version            machine   processor, cores, versions of what computed
quick     short list?        verdict   "agrees", or "differs" if any case does
complete  whether all cases of the list are in it
counts    verdict -> number of cases
judges    judge -> what it is
cases     per case: name, group, title, verdict, seconds, facts, and
  findings      judge, verdict, quantity, error, limit, note   (error, limit null where there is no number)
  attributions  differences to other engines explained by a number of the same run

Mechanisms are small pictures, convergence is drawn by hand as SVG, the difference from our motion over the step, both
logarithmic: a hundred figures of matplotlib would take longer than the engines, and ten times the space.
"""

import base64
import io
import json
import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from engines.balance.pages.drawings import stroke, svg, text
from mbsd3d.extend import digits, figure_style, package_version, page_template
from validation.crosscheck import Compared, CrossCheck, Curve
from validation.machine import machine
from validation.suite.findings import (
    AGREES,
    DEFINITIONS,
    DIFFERS,
    EXPLAINED,
    EXUDYN,
    JUDGES,
    MUJOCO,
    NOT_COMPARED,
    Finding,
    Record,
    columns_of,
    counted,
    differences,
    failed,
    omissions,
)
from validation.suite.trials.trial import Run

FORMAT_VERSION = 1
PICTURE_FIELDS = ("picture", "charts")


def content_of(records: Sequence[Record], *, quick: bool, complete: bool) -> dict[str, Any]:
    """Return the content of the JSON file; pictures are left to the page."""
    cases = [{key: value for key, value in record.to_dict().items() if key not in PICTURE_FIELDS} for record in records]
    return {
        "format": FORMAT_VERSION,
        "mbsd3d": package_version(),
        "machine": machine("numpy", "numba", "mujoco-core", "exudyn"),
        "quick": quick,
        "complete": complete,
        "verdict": DIFFERS if failed(records) else AGREES,
        "counts": dict(Counter(record.verdict for record in records)),
        "judges": JUDGES,
        "cases": cases,
    }


def encoded(content: dict[str, Any]) -> bytes:
    """Return UTF-8, indented; NaN and infinity are no JSON and would be an error."""
    return f"{json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)}\n".encode()


TEMPLATES = Path(__file__).parents[1] / "templates"
MARKS = {AGREES: "✓", EXPLAINED: "≈", DIFFERS: "✗", NOT_COMPARED: "–"}
CLASSES = {AGREES: "pass", EXPLAINED: "pass", DIFFERS: "fail", NOT_COMPARED: "none"}
# judges that compare a dozen quantities each: they are shown side by side
SIDE_BY_SIDE_JUDGES = (MUJOCO, EXUDYN, DEFINITIONS)
PARTIAL_MARK = "◐ "  # some quantities were not compared


def page_of(records: Sequence[Record], content: Mapping[str, Any]) -> str:
    """Render the whole page.

    ``records``: in the order of the report; ``content``: of `content_of`: machine, versions, verdict. Returns
    HTML; every text of a case is escaped.
    """
    return page_template("validation.html", TEMPLATES).render(
        content=content,
        groups=grouped(records),
        sections=grouped([record for record in records if detailed(record)]),
        judges=columns_of(records),
        counted=counted(records),
        differences=differences(records),
        omissions=omissions(records),
        meaning=JUDGES, marks=MARKS, classes=CLASSES, number=number, cell=cell, key=anchor, single=single,
        matrix=matrix, reasons=reasons, detailed=detailed,
    )  # fmt: skip


def grouped(records: Sequence[Record]) -> dict[str, list[Record]]:
    """Return group -> its cases."""
    names = dict.fromkeys(record.group for record in records)
    return {name: [record for record in records if record.group == name] for name in names}


def number(value: Any) -> str:
    """Format a number with two digits, nothing for None."""
    return "" if value is None else digits(float(value), count=2)


def cell(record: Record, judge: str) -> dict[str, str]:
    """Return text, class and tip of a cell of the overview."""
    found = entry(record.worst(judge))
    return found | {"text": f"{PARTIAL_MARK * record.in_part(judge)}{found['text']}"}


def entry(finding: Finding | None) -> dict[str, str]:
    """Return text, class and tip of a finding."""
    if finding is None:
        return {"text": "", "kind": "", "tip": ""}
    shown = number(finding.error) if finding.error and finding.verdict != NOT_COMPARED else ""
    tip = finding.note if finding.limit is None else f"limit {finding.limit:.0e}; {finding.note}"
    text = f"{MARKS[finding.verdict]} {shown}".strip()
    return {"text": text, "kind": CLASSES[finding.verdict], "tip": f"{finding.quantity}: {tip}"}


def detailed(record: Record) -> bool:
    """Return whether a case has its own section; random ones only with something to report."""
    return bool(record.picture or record.charts) or record.verdict != AGREES


def single(record: Record) -> list[Finding]:
    """Return the findings of the judges that have few."""
    return [finding for finding in record.findings if finding.judge not in SIDE_BY_SIDE_JUDGES]


def matrix(record: Record) -> tuple[list[str], list[tuple[str, list[dict[str, str]]]]]:
    """Return (judges, rows of (quantity, cells)) of the judges that compare many quantities."""
    compared = [x for x in record.findings if x.judge in SIDE_BY_SIDE_JUDGES and x.verdict != NOT_COMPARED]
    judges = [judge for judge in SIDE_BY_SIDE_JUDGES if any(x.judge == judge for x in compared)]
    found = {(x.quantity, x.judge): x for x in compared}
    quantities = dict.fromkeys(x.quantity for x in sorted(compared, key=lambda x: SIDE_BY_SIDE_JUDGES.index(x.judge)))
    return judges, [(name, [entry(found.get((name, judge))) for judge in judges]) for name in quantities]


def reasons(record: Record) -> list[str]:
    """Return why those judges did not compare something: one line per reason."""
    found: dict[tuple[str, str], list[str]] = {}
    for x in record.findings:
        if x.judge in SIDE_BY_SIDE_JUDGES and x.verdict == NOT_COMPARED:
            found.setdefault((x.judge, x.note), []).append(x.quantity)
    return [
        f"{judge}, not compared{': ' if any(names) else ''}{', '.join(filter(None, names))}: {note}"
        for (judge, note), names in found.items()
    ]


def anchor(name: str) -> str:
    """Return the id of a case on the page."""
    return "case-" + "".join(c if c.isalnum() else "-" for c in name)


QUANTITIES = ("position", "rotation", "velocity", "energy", "reaction force")
"""The curves that are drawn; the others follow from them."""
CHART_WIDTH, CHART_HEIGHT, LEFT_MARGIN, BOTTOM_MARGIN, TOP_MARGIN = 300.0, 190.0, 46.0, 34.0, 22.0
DIFFERENCE_MIN = 1e-17  # [1] smaller differences are drawn here: equal bits have no logarithm
Place = Callable[[float, float], complex]  # of a step and a difference
KEY_HEIGHT = 18.0  # [units of the drawing] height of the key
PICTURE_SIZE, DOTS_PER_INCH = (3.6, 2.7), 110  # inch, per inch
PICTURE_BODIES_MAX = 40  # [1] bodies that can be distinguished at this size


def picture(made: Run) -> str:
    """Return the mechanism at the end of its run, else as built, as data address; "" for too many bodies to
    distinguish.
    """
    if len(made.system.bodies) > PICTURE_BODIES_MAX:
        return ""
    pose = None if made.solution is None else made.solution.state(made.solution.t.size - 1)
    figure, buffer = made.system.picture(pose, size=PICTURE_SIZE), io.BytesIO()
    with figure_style():
        figure.savefig(buffer, format="webp", dpi=DOTS_PER_INCH, pil_kwargs={"quality": 70})
    return f"data:image/webp;base64,{base64.b64encode(buffer.getvalue()).decode()}"


def chart(check: CrossCheck) -> str:
    """Draw one panel per engine that ran, on common axes; "" where none ran."""
    ran = [engine for engine in check.engines if any(curve.quantity in QUANTITIES for curve in engine.curves)]
    if not ran:
        return ""
    box = bounds([curve for engine in ran for curve in engine.curves if curve.quantity in QUANTITIES])
    panels = [
        f'<g transform="translate({k * (CHART_WIDTH + 24):g} 0)">{panel(engine, *box)}</g>'
        for k, engine in enumerate(ran)
    ]
    width, label = 2 * (CHART_WIDTH + 24), f"convergence of {' and '.join(engine.engine for engine in ran)}"
    return str(svg(width, CHART_HEIGHT + KEY_HEIGHT, "".join(panels) + key(), label))


def bounds(curves: Sequence[Curve]) -> tuple[int, int, int, int]:
    """Return the decades that hold all steps and differences."""
    steps = [math.log10(step) for curve in curves for step in curve.steps]
    sizes = [math.log10(max(size, DIFFERENCE_MIN)) for curve in curves for size in curve.differences]
    low, high = math.floor(min(sizes)), math.ceil(max(sizes))
    return math.floor(min(steps)), math.ceil(max(steps)), low, max(high, low + 1)


def panel(engine: Compared, first: int, last: int, low: int, high: int) -> str:
    """Draw axes, curves and the expected slope of one engine."""

    def place(step: float, size: float) -> complex:
        x = LEFT_MARGIN + (CHART_WIDTH - LEFT_MARGIN) * (math.log10(step) - first) / (last - first)
        y = (
            CHART_HEIGHT
            - BOTTOM_MARGIN
            - (CHART_HEIGHT - BOTTOM_MARGIN - TOP_MARGIN) * (math.log10(max(size, DIFFERENCE_MIN)) - low) / (high - low)
        )
        return complex(x, -y)

    every = max(1, (high - low) // 5)
    drawn = []
    for decade in range(low, high + 1, every):
        drawn.append(stroke("grid", place(10.0**first, 10.0**decade), place(10.0**last, 10.0**decade)))
        drawn.append(text(LEFT_MARGIN - 5, -place(10.0**first, 10.0**decade).imag + 3.5, f"1e{decade}", "end"))
    for decade in range(first, last + 1):
        drawn.append(stroke("grid", place(10.0**decade, 10.0**low), place(10.0**decade, 10.0**high)))
        drawn.append(text(place(10.0**decade, 1.0).real, CHART_HEIGHT - BOTTOM_MARGIN + 14, f"1e{decade}"))
    curves = [curve for curve in engine.curves if curve.quantity in QUANTITIES]
    drawn += [line(place, curve) for curve in curves]
    drawn.append(slope(place, engine, curves))
    drawn.append(text(LEFT_MARGIN, 12, f"{engine.engine}: relative difference [-] over step [s]", "start", "value"))
    return "".join(drawn)


def line(place: Place, curve: Curve) -> str:
    """Draw a curve with a mark at every run."""
    tint = f"t{QUANTITIES.index(curve.quantity)}"
    points = [place(step, size) for step, size in zip(curve.steps, curve.differences, strict=True)]
    marks = "".join(f'<circle class="fill {tint}" cx="{z.real:.2f}" cy="{-z.imag:.2f}" r="2.4"/>' for z in points)
    return stroke(f"line {tint}", *points) + marks


def slope(place: Place, engine: Compared, curves: Sequence[Curve]) -> str:
    """Draw the expected order, from the largest difference of the coarsest run on."""
    first = max(curve.differences[0] for curve in curves)
    if not engine.order or first <= 0.0:
        return ""
    least = min(max(size, DIFFERENCE_MIN) for curve in curves for size in curve.differences)
    coarse = curves[0].steps[0]
    fine = max(curves[0].steps[-1], coarse * (least / first) ** (1.0 / engine.order))  # not below the panel
    return stroke("ring muted", place(coarse, first), place(fine, first * (fine / coarse) ** engine.order))


def key() -> str:
    """Draw the key: colours of the quantities, and the meaning of the dashes."""
    parts, x = [], LEFT_MARGIN
    for k, quantity in enumerate((*QUANTITIES, "expected order")):
        kind = f"line t{k}" if k < len(QUANTITIES) else "ring muted"
        parts.append(stroke(kind, complex(x, -CHART_HEIGHT - 8), complex(x + 16, -CHART_HEIGHT - 8)))
        parts.append(text(x + 20, CHART_HEIGHT + 11.5, quantity, "start"))
        x += 30 + 5.6 * len(quantity)
    return "".join(parts)
