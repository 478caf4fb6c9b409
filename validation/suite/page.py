"""The reports of a run: one HTML file that needs no network, and JSON with every finding, in SI units.

format    1; rises when a field changes its meaning
mbsd3d    version            machine   processor, cores, versions of what computed
quick     short list?        verdict   "agrees", or "differs" if any case does
complete  whether all cases of the list are in it
counts    verdict -> number of cases
judges    judge -> what it is
cases     per case: name, group, title, verdict, seconds, facts, and
  findings      judge, verdict, quantity, error, limit, note   (error, limit null where there is no number)
  attributions  differences to other engines explained by a number of the same run
"""

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mbsd3d.extend import digits, package_version, page_template
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

FORMAT = 1
PICTURES = ("picture", "charts")


def content_of(records: Sequence[Record], *, quick: bool, complete: bool) -> dict[str, Any]:
    """The content of the JSON file; pictures are left to the page."""
    cases = [{key: value for key, value in record.to_dict().items() if key not in PICTURES} for record in records]
    return {
        "format": FORMAT,
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
    """UTF-8, indented; NaN and infinity are no JSON and would be an error."""
    return f"{json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)}\n".encode()


TEMPLATES = Path(__file__).parents[1] / "templates"
MARKS = {AGREES: "✓", EXPLAINED: "≈", DIFFERS: "✗", NOT_COMPARED: "–"}
CLASSES = {AGREES: "pass", EXPLAINED: "pass", DIFFERS: "fail", NOT_COMPARED: "none"}
SEVERAL = (MUJOCO, EXUDYN, DEFINITIONS)  # Judges that compare a dozen quantities each: they stand side by side
PART = "◐ "  # some quantities were not compared


def page_of(records: Sequence[Record], content: Mapping[str, Any]) -> str:
    """The whole page.

    ``records``: in the order of the report; ``content``: of `document.content_of`: machine, versions, verdict. Returns
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
    """Group -> its cases."""
    names = dict.fromkeys(record.group for record in records)
    return {name: [record for record in records if record.group == name] for name in names}


def number(value: Any) -> str:
    """Two digits, nothing for None."""
    return "" if value is None else digits(float(value), count=2)


def cell(record: Record, judge: str) -> dict[str, str]:
    """Text, class and tip of a cell of the overview."""
    found = entry(record.worst(judge))
    return found | {"text": f"{PART * record.in_part(judge)}{found['text']}"}


def entry(finding: Finding | None) -> dict[str, str]:
    """Text, class and tip of a finding."""
    if finding is None:
        return {"text": "", "kind": "", "tip": ""}
    shown = number(finding.error) if finding.error and finding.verdict != NOT_COMPARED else ""
    tip = finding.note if finding.limit is None else f"limit {finding.limit:.0e}; {finding.note}"
    text = f"{MARKS[finding.verdict]} {shown}".strip()
    return {"text": text, "kind": CLASSES[finding.verdict], "tip": f"{finding.quantity}: {tip}"}


def detailed(record: Record) -> bool:
    """Whether a case has a section of its own; of random ones only where there is something to say."""
    return bool(record.picture or record.charts) or record.verdict != AGREES


def single(record: Record) -> list[Finding]:
    """Findings of the judges that have few."""
    return [finding for finding in record.findings if finding.judge not in SEVERAL]


def matrix(record: Record) -> tuple[list[str], list[tuple[str, list[dict[str, str]]]]]:
    """(judges, rows of (quantity, cells)) of the judges that compare many quantities."""
    compared = [x for x in record.findings if x.judge in SEVERAL and x.verdict != NOT_COMPARED]
    judges = [judge for judge in SEVERAL if any(x.judge == judge for x in compared)]
    found = {(x.quantity, x.judge): x for x in compared}
    quantities = dict.fromkeys(x.quantity for x in sorted(compared, key=lambda x: SEVERAL.index(x.judge)))
    return judges, [(name, [entry(found.get((name, judge))) for judge in judges]) for name in quantities]


def reasons(record: Record) -> list[str]:
    """Why those judges did not compare something: one line per reason."""
    found: dict[tuple[str, str], list[str]] = {}
    for x in record.findings:
        if x.judge in SEVERAL and x.verdict == NOT_COMPARED:
            found.setdefault((x.judge, x.note), []).append(x.quantity)
    return [
        f"{judge}, not compared{': ' if any(names) else ''}{', '.join(filter(None, names))}: {note}"
        for (judge, note), names in found.items()
    ]


def anchor(name: str) -> str:
    """Id of a case on the page."""
    return "case-" + "".join(c if c.isalnum() else "-" for c in name)
