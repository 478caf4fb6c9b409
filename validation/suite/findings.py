"""What a judge says of a case, and what is kept of a case that was examined."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any

AGREES, EXPLAINED, DIFFERS, NOT_COMPARED = "agrees", "explained", "differs", "not compared"

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
    """One comparison of one judge.

    Attributes
    ----------
    judge : str
        One of `JUDGES`.
    verdict : str
        "agrees"; "explained": differs, and a cause changed in the same run shows why; "differs"; "not compared".
    quantity : str
        What was compared.
    error, limit : float or None
        Difference and what is allowed, relative to ``max(1, largest value)`` unless ``note`` says otherwise.
    note : str
        Reason why it was not compared, or how a difference is explained.
    """

    judge: str
    verdict: str
    quantity: str = ""
    error: float | None = None
    limit: float | None = None
    note: str = ""


def judged(judge: str, quantity: str, error: float, limit: float, note: str = "") -> Finding:
    """A finding by its numbers: an error beyond the limit differs, and so does NaN."""
    agrees = math.isfinite(error) and error <= limit
    return Finding(judge, AGREES if agrees else DIFFERS, quantity, finite(error), finite(limit), note)


def not_compared(judge: str, reason: str) -> Finding:
    """A finding without numbers; the reason in one line."""
    return Finding(judge, NOT_COMPARED, note=" ".join(reason.split()))


def finite(value: float) -> float | None:
    """JSON has no infinities."""
    return float(value) if math.isfinite(value) else None


@dataclass(frozen=True)
class Record:
    """A case that was examined; plain data, so that it can be kept as JSON.

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
        """The worst of the findings; those of the certificate alone are no comparison."""
        said = {finding.verdict for finding in self.findings}
        outside = {finding.verdict for finding in self.findings if finding.judge != CERTIFICATE}
        if DIFFERS in said:
            return DIFFERS
        return next((verdict for verdict in (EXPLAINED, AGREES) if verdict in outside), NOT_COMPARED)

    def of(self, judge: str) -> tuple[Finding, ...]:
        """Findings of one judge."""
        return tuple(finding for finding in self.findings if finding.judge == judge)

    def worst(self, judge: str) -> Finding | None:
        """The finding that decides for a judge: one that differs, else the one nearest to its limit; None if silent."""
        return max(self.of(judge), key=severity, default=None)

    def in_part(self, judge: str) -> bool:
        """Whether a judge compared some quantities and not others."""
        return len({finding.verdict == NOT_COMPARED for finding in self.of(judge)}) > 1

    @property
    def failures(self) -> tuple[Finding, ...]:
        """What differs."""
        return tuple(finding for finding in self.findings if finding.verdict == DIFFERS)

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self) | {"verdict": self.verdict}


def severity(finding: Finding) -> tuple[int, float]:
    """Differs before explained before agrees before not compared; within one verdict by error over limit."""
    rank = (NOT_COMPARED, AGREES, EXPLAINED, DIFFERS).index(finding.verdict)
    if finding.error is None or finding.limit is None:
        return rank, math.inf if finding.verdict == DIFFERS else 0.0
    return rank, finding.error / finding.limit if finding.limit > 0.0 else (math.inf if finding.error > 0.0 else 0.0)


def record_from(data: Mapping[str, Any]) -> Record:
    """The record of `Record.to_dict`; KeyError or TypeError for anything else."""
    known = {key: data[key] for key in (f.name for f in fields(Record))}
    known["findings"] = tuple(Finding(**finding) for finding in known["findings"])
    return Record(**known | {key: tuple(known[key]) for key in ("attributions", "charts")})


def failed(records: Iterable[Record]) -> list[Record]:
    """Records in which something differs."""
    return [record for record in records if record.verdict == DIFFERS]
