"""Findings of a judge about a case, the stored record of a case, and the table of a run as text."""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from typing import Any

from mbsd3d.extend import aligned, error_text
from validation.crosscheck.result import AGREES, DIFFERS, EXPLAINED
from validation.crosscheck.result import SKIPPED as NOT_COMPARED

# The judges, in the order of the columns of the table.
CERTIFICATE, FREEDOMS, REFERENCE, THEORY = "certificate", "freedoms", "reference", "theory"
PLANE, DEFINITIONS, MUJOCO, EXUDYN = "plane", "definitions", "MuJoCo", "Exudyn"
JUDGES = {
    CERTIFICATE: "the checks that every run of mbsd3d makes with the true equations",
    FREEDOMS: "rows, rank and mobility against counts found elsewhere",
    REFERENCE: "trusted solution in the file of the case",
    THEORY: "closed form or published figure",
    PLANE: "general planar solver, which knows no third dimension",
    DEFINITIONS: "second formulation in plain numpy from the definitions of the joints",
    MUJOCO: "twin in MuJoCo, judged by convergence",
    EXUDYN: "twin in Exudyn, judged by convergence",
}
"""Judge -> what it is; none shares a kernel with mbsd3d but the first."""


@dataclass(frozen=True)
class Finding:
    """One comparison by one judge.

    ``judge``: one of `JUDGES`; ``verdict``: "agrees"; "explained": differs, and a cause changed in the same run
    shows why; "differs"; "not compared"; ``quantity``: what was compared; ``error, limit``: difference and what is
    allowed, relative to ``max(1, largest value)`` unless ``note`` says otherwise; ``note``: reason why it was not
    compared, or how a difference is explained.
    """

    judge: str
    verdict: str
    quantity: str = ""
    error: float | None = None
    limit: float | None = None
    note: str = ""


def judged(judge: str, quantity: str, error: float, limit: float, note: str = "") -> Finding:
    """Return a finding by its numbers: an error beyond the limit differs, and so does NaN."""
    agrees = math.isfinite(error) and error <= limit
    return Finding(judge, AGREES if agrees else DIFFERS, quantity, finite(error), finite(limit), note)


def not_compared(judge: str, reason: str) -> Finding:
    """Return a finding without numbers; the reason in one line."""
    return Finding(judge, NOT_COMPARED, note=" ".join(reason.split()))


def finite(value: float) -> float | None:
    """Return a finite number, else None: JSON has no infinities."""
    return float(value) if math.isfinite(value) else None


@dataclass(frozen=True)
class Record:
    """Examined case as plain data, so that it can be kept as JSON.

    ``name, group, title``: of the case; ``findings``: in the order they were made; ``facts``: numbers of the case:
    bodies, joints, t_end [s], rows, rank, mobility, redundant, steps; ``attributions``: how differences to other
    engines are explained: ``engine``, ``quantity``, ``cause``, ``change``, and the difference ``before`` and ``after``
    the change, relative; ``engines``: engine -> how it was run; ``picture, charts``: PNG as a data address ("" = none);
    convergence plots as SVG; ``seconds``: what examining it took [s].
    """

    name: str
    group: str
    title: str
    findings: tuple[Finding, ...]
    facts: Mapping[str, Any] = field(default_factory=dict)
    attributions: tuple[Mapping[str, Any], ...] = ()
    engines: Mapping[str, str] = field(default_factory=dict)
    picture: str = ""
    charts: tuple[str, ...] = ()
    seconds: float = 0.0

    @property
    def verdict(self) -> str:
        """Return the worst of the findings; those of the certificate alone are no comparison."""
        said = {finding.verdict for finding in self.findings}
        outside = {finding.verdict for finding in self.findings if finding.judge != CERTIFICATE}
        if DIFFERS in said:
            return DIFFERS
        return next((verdict for verdict in (EXPLAINED, AGREES) if verdict in outside), NOT_COMPARED)

    def of(self, judge: str) -> tuple[Finding, ...]:
        """Return the findings of one judge."""
        return tuple(finding for finding in self.findings if finding.judge == judge)

    def worst(self, judge: str) -> Finding | None:
        """Return the finding that decides for a judge: one that differs, else the one nearest to its limit; None
        without findings.
        """
        return max(self.of(judge), key=severity, default=None)

    def in_part(self, judge: str) -> bool:
        """Return whether a judge compared some quantities and not others."""
        return len({finding.verdict == NOT_COMPARED for finding in self.of(judge)}) > 1

    @property
    def failures(self) -> tuple[Finding, ...]:
        """Return the findings that differ."""
        return tuple(finding for finding in self.findings if finding.verdict == DIFFERS)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return asdict(self) | {"verdict": self.verdict}


def severity(finding: Finding) -> tuple[int, float]:
    """Return the sort key: differs before explained before agrees before not compared; within one verdict by error over
    limit.
    """
    rank = (NOT_COMPARED, AGREES, EXPLAINED, DIFFERS).index(finding.verdict)
    if finding.error is None or finding.limit is None:
        return rank, math.inf if finding.verdict == DIFFERS else 0.0
    return rank, finding.error / finding.limit if finding.limit > 0.0 else (math.inf if finding.error > 0.0 else 0.0)


def record_from(data: Mapping[str, Any]) -> Record:
    """Return the record of `Record.to_dict`; raise KeyError or TypeError for anything else."""
    known = {key: data[key] for key in (f.name for f in fields(Record))}
    known["findings"] = tuple(Finding(**finding) for finding in known["findings"])
    return Record(**known | {key: tuple(known[key]) for key in ("attributions", "charts")})


def failed(records: Iterable[Record]) -> list[Record]:
    """Return the records in which something differs."""
    return [record for record in records if record.verdict == DIFFERS]


LISTED_CASES_MAX = 30  # [1] cases of one group; of more only those that differ have their own line
SILENT_MARK, ABSENT_MARK, PARTIAL_MARK = "-", "", "~"
LEGEND = (
    "Errors are relative; exact: counts equal; *: explained, with a number; !: differs; ~: in part; -: not compared."
)
REASONS_MAX = 3  # [1] most frequent ones shown per judge


def cell(finding: Finding | None) -> str:
    """Return the error of the deciding finding; "!" marks one that differs, "-" one that was not compared."""
    if finding is None:
        return ABSENT_MARK
    if finding.verdict == NOT_COMPARED:
        return SILENT_MARK
    mark = {DIFFERS: "!", EXPLAINED: "*"}.get(finding.verdict, "")
    if finding.error is None:
        return f"stopped{mark}"
    if not finding.error:
        return f"{'exact' if finding.verdict == AGREES else 0}{mark}"
    return f"{finding.error:.0e}{mark}"


def columns_of(records: Iterable[Record]) -> list[str]:
    """Return the judges with findings, in their order."""
    said = {finding.judge for record in records for finding in record.findings}
    return [judge for judge in JUDGES if judge in said]


def line(record: Record, judges: Sequence[str]) -> list[str]:
    """Return the cells of one case."""
    cells = [f"{cell(record.worst(judge))}{PARTIAL_MARK * record.in_part(judge)}" for judge in judges]
    return [record.name, record.verdict, *cells]


def summary(group: str, records: Sequence[Record], judges: Sequence[str]) -> list[str]:
    """Return the cells of many cases: of each judge the finding nearest to its limit, and how many cases it judged."""
    cells = []
    for judge in judges:
        found = [x for record in records if (x := record.worst(judge)) is not None and x.verdict != NOT_COMPARED]
        cells.append(f"{cell(max(found, key=severity))} ({len(found)})" if found else SILENT_MARK)
    counts = Counter(record.verdict for record in records)
    verdict = ", ".join(f"{counts[word]} {word}" for word in (AGREES, EXPLAINED, DIFFERS, NOT_COMPARED) if counts[word])
    return [f"{group}: {len(records)} cases", verdict, *cells]


def lines_of(records: Sequence[Record], judges: Sequence[str]) -> list[list[str]]:
    """Return header and rows, group by group."""
    rows = [["case", "verdict", *judges]]
    for group in dict.fromkeys(record.group for record in records):
        own = [record for record in records if record.group == group]
        if len(own) > LISTED_CASES_MAX:
            rows.append(summary(group, own, judges))
            own = failed(own)
        rows += [line(record, judges) for record in own]
    return rows


def differences(records: Iterable[Record]) -> list[str]:
    """Return one line per finding that differs, with its numbers."""
    return [f"{record.name}: {sentence(finding)}" for record in records for finding in record.failures]


def sentence(finding: Finding) -> str:
    """Return a finding in words."""
    numbers = "" if finding.error is None else f" {error_text(finding.error, 3)}"
    limit = "" if finding.limit is None else f" (limit {finding.limit:.0e})"
    return f"{finding.judge}: {finding.quantity}{numbers}{limit}{': ' if finding.note else ''}{finding.note}"


def omissions(records: Sequence[Record]) -> list[str]:
    """Return per judge how many cases it did not compare, and the most frequent reasons."""
    found = []
    for judge in columns_of(records):
        notes = [f.note for record in records for f in record.of(judge) if f.verdict == NOT_COMPARED]
        if notes:
            reasons = Counter(notes).most_common()
            shown = "; ".join(f"{note} ({count})" for note, count in reasons[:REASONS_MAX])
            rest = f"; {len(reasons) - REASONS_MAX} more reasons in the report" if len(reasons) > REASONS_MAX else ""
            found.append(f"{judge}, not compared {len(notes)} times: {shown}{rest}")
    return found


def counted(records: Sequence[Record]) -> str:
    """Return how many cases agree, differ and were not compared."""
    counts = Counter(record.verdict for record in records)
    words = f"{counts[AGREES]} agree, {counts[EXPLAINED]} explained, {counts[DIFFERS]} differ"
    words += f", {counts[NOT_COMPARED]} not compared"
    alone = "" if not counts[NOT_COMPARED] else f" (no judge but the {CERTIFICATE})"
    return f"{len(records)} cases: {words}{alone}"


def table(records: Sequence[Record]) -> str:
    """Return all cases as a table, with the differences and omissions."""
    parts = [*aligned(lines_of(records, columns_of(records))), "", LEGEND, ""]
    parts += [*differences(records), *omissions(records), counted(records)]
    return "\n".join(parts)
