"""The table of a run as text: one line per case, then what differs, and what was not compared and why."""

from collections import Counter
from collections.abc import Iterable, Sequence

from validation.suite.findings import (
    AGREES,
    CERTIFICATE,
    DIFFERS,
    EXPLAINED,
    JUDGES,
    NOT_COMPARED,
    Finding,
    Record,
    failed,
    severity,
)

MANY = 30
"""Of one group: more cases than that share a line, and only those that differ have their own."""
SILENT, ABSENT, PART = "-", "", "~"
LEGEND = (
    "Errors are relative; exact: counts equal; *: explained, with a number; !: differs; ~: in part; -: not compared."
)
REASONS = 3  # most frequent ones shown per judge


def cell(finding: Finding | None) -> str:
    """Error of the deciding finding; "!" marks one that differs, "-" what was not compared."""
    if finding is None:
        return ABSENT
    if finding.verdict == NOT_COMPARED:
        return SILENT
    mark = {DIFFERS: "!", EXPLAINED: "*"}.get(finding.verdict, "")
    if finding.error is None:
        return f"stopped{mark}"
    if not finding.error:
        return f"{'exact' if finding.verdict == AGREES else 0}{mark}"
    return f"{finding.error:.0e}{mark}"


def columns_of(records: Iterable[Record]) -> list[str]:
    """The judges who said anything, in their order."""
    said = {finding.judge for record in records for finding in record.findings}
    return [judge for judge in JUDGES if judge in said]


def line(record: Record, judges: Sequence[str]) -> list[str]:
    """Cells of one case."""
    cells = [f"{cell(record.worst(judge))}{PART * record.in_part(judge)}" for judge in judges]
    return [record.name, record.verdict, *cells]


def summary(group: str, records: Sequence[Record], judges: Sequence[str]) -> list[str]:
    """Cells of many cases: of each judge the finding nearest to its limit, and how many cases it judged."""
    cells = []
    for judge in judges:
        found = [record.worst(judge) for record in records]
        found = [finding for finding in found if finding is not None and finding.verdict != NOT_COMPARED]
        cells.append(f"{cell(max(found, key=severity))} ({len(found)})" if found else SILENT)
    counts = Counter(record.verdict for record in records)
    verdict = ", ".join(f"{counts[word]} {word}" for word in (AGREES, EXPLAINED, DIFFERS, NOT_COMPARED) if counts[word])
    return [f"{group}: {len(records)} cases", verdict, *cells]


def lines_of(records: Sequence[Record], judges: Sequence[str]) -> list[list[str]]:
    """Header and rows, group by group."""
    rows = [["case", "verdict", *judges]]
    for group in dict.fromkeys(record.group for record in records):
        own = [record for record in records if record.group == group]
        if len(own) > MANY:
            rows.append(summary(group, own, judges))
            own = failed(own)
        rows += [line(record, judges) for record in own]
    return rows


def aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Columns side by side: two of words, then numbers."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    sides = [str.ljust, str.ljust, *[str.rjust] * (len(widths) - 2)]
    return ["  ".join(side(x, n) for side, x, n in zip(sides, row, widths, strict=True)).rstrip() for row in rows]


def differences(records: Iterable[Record]) -> list[str]:
    """One line per finding that differs, with its numbers."""
    return [f"{record.name}: {sentence(finding)}" for record in records for finding in record.failures]


def sentence(finding: Finding) -> str:
    """A finding in words."""
    numbers = "" if finding.error is None else f" {finding.error:.2e}"
    limit = "" if finding.limit is None else f" (limit {finding.limit:.0e})"
    return f"{finding.judge}: {finding.quantity}{numbers}{limit}{': ' if finding.note else ''}{finding.note}"


def omissions(records: Sequence[Record]) -> list[str]:
    """Per judge how many cases it did not compare, and the most frequent reasons."""
    found = []
    for judge in columns_of(records):
        notes = [f.note for record in records for f in record.of(judge) if f.verdict == NOT_COMPARED]
        if notes:
            reasons = Counter(notes).most_common()
            shown = "; ".join(f"{note} ({count})" for note, count in reasons[:REASONS])
            rest = f"; {len(reasons) - REASONS} more reasons in the report" if len(reasons) > REASONS else ""
            found.append(f"{judge}, not compared {len(notes)} times: {shown}{rest}")
    return found


def counted(records: Sequence[Record]) -> str:
    """How many cases agree, differ and were not compared."""
    counts = Counter(record.verdict for record in records)
    words = f"{counts[AGREES]} agree, {counts[EXPLAINED]} explained, {counts[DIFFERS]} differ"
    words += f", {counts[NOT_COMPARED]} not compared"
    alone = "" if not counts[NOT_COMPARED] else f" (no judge but the {CERTIFICATE})"
    return f"{len(records)} cases: {words}{alone}"


def text(records: Sequence[Record]) -> str:
    """Everything."""
    parts = [*aligned(lines_of(records, columns_of(records))), "", LEGEND, ""]
    parts += [*differences(records), *omissions(records), counted(records)]
    return "\n".join(parts)
