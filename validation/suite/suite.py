"""Run of test cases one after the other, with stored records and written reports.

MuJoCo, Exudyn and the definitions of the joints are judges too: `cross_check` speaks in the words of the suite.
"""

import hashlib
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import mbsd3d
from mbsd3d.extend import Progress, Store, on_one_thread, outcomes, write_atomically
from validation.crosscheck import CrossCheck, cross_check
from validation.crosscheck import Finding as PeerFinding
from validation.machine import installed
from validation.suite.findings import (
    CERTIFICATE,
    DIFFERS,
    EXUDYN,
    MUJOCO,
    Finding,
    Record,
    failed,
    not_compared,
    record_from,
)
from validation.suite.page import chart, content_of, encoded, page_of, picture
from validation.suite.trials import chosen, trials
from validation.suite.trials.trial import Run, Trial, examine, stopped

STORE_NAME = "validation"
PROCESS_CASES_MIN = 4  # [1] cases that are worth the seconds in which processes start
PEERS = (MUJOCO, EXUDYN)
SECOND_BUDGET_RATIO = 5.0  # [1] of the budget, for a second look at a difference
PACKAGES = ("numpy", "scipy", "numba", "mujoco-core", "mujoco", "exudyn")
SOURCE_PATTERNS = ("*.py", "references/*.json", "parameters/*.json")


def store(folder: Path, fresh: bool = False, **settings: Any) -> Store:
    """Return the finished cases in a folder: of these sources, versions of all that computes, and settings; others are
    discarded.

    An edited kernel, reference or closed form gives another identity, so no result outlives what it was made of.
    """
    text, here = hashlib.sha256(), Path(__file__).parents[1]
    for root in (Path(mbsd3d.__file__).parent, here, here.with_name("bicycle")):
        for path in sorted(path for pattern in SOURCE_PATTERNS for path in root.rglob(pattern)):
            text.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    made_of = {"sources": text.hexdigest(), "versions": [installed(name) for name in PACKAGES], **settings}
    found = Store(folder / f"{STORE_NAME}.db", made_of, "validation", replace=True)
    if fresh:
        found.clear()
    return found


def compared(made: Run, trial: Trial, budget: float) -> tuple[list[Finding], CrossCheck | None]:
    """Return all findings of the engines and the definitions about a mechanism.

    ``made``: mechanism and start; ``trial``: how long it is compared, and why not; ``budget``: seconds that an engine's
    runs may take. Returns findings; check: attributions and curves; None if nothing was compared.
    """
    if trial.alone:
        return [not_compared(judge, trial.alone) for judge in PEERS], None
    check = asked(made, budget)
    if check.failures:  # finer steps, and time to change what may be to blame
        check = asked(made, SECOND_BUDGET_RATIO * budget)
    if check.interrupted:
        raise KeyboardInterrupt
    return [translated(finding) for finding in check.findings], check


def asked(made: Run, budget: float) -> CrossCheck:
    """Return the findings of `cross_check`; of a case without a motion at its start."""
    return cross_check(made.system, made.t_end or None, state=made.state, budget=budget, progress=False)


def translated(finding: PeerFinding) -> Finding:
    """Return a finding of `cross_check`: limits may differ by the tolerance, or by their uncertainty."""
    limit = None if finding.difference is None else finding.bound
    order = "" if finding.order is None else f"order {finding.order:.2f} of {finding.expected:g}"
    until = "" if finding.until is None else f"until {finding.until:.4g} s"
    causes = "; ".join(map(str, finding.attributions))
    note = "; ".join(text for text in (finding.reason, causes, order, until, finding.part) if text)
    return Finding(finding.engine, finding.status, finding.quantity, finding.difference, limit, note)


def attributions(check: CrossCheck) -> tuple[dict[str, Any], ...]:
    """Return every cause that was changed, with the difference before and after."""
    return tuple(
        {"engine": finding.engine, "quantity": finding.quantity, **attribution._asdict()}
        for finding in check.findings
        for attribution in finding.attributions
    )


def settings(check: CrossCheck) -> dict[str, str]:
    """Return engine -> formulation, integrator, steps and seconds of its runs."""
    found = {}
    for engine in check.engines:
        steps = f"; {engine.steps[0]} ... {engine.steps[-1]} steps, {sum(engine.seconds):.2g} s" if engine.steps else ""
        found[engine.engine] = f"{engine.settings}{steps}{'; ' if engine.stopped else ''}{engine.stopped}"
    return {name: text for name, text in found.items() if text}


@dataclass(frozen=True)
class Suite:
    """Test cases, the folder of their results, and the seconds of an engine per case."""

    trials: Sequence[Trial]
    store: Store
    quick: bool = False
    budget: float = 1.0
    show: bool | None = None

    @cached_property
    def found(self) -> dict[str, Record]:
        """Return the finished cases by name."""
        return {str(name): record_from(data) for name, data in self.store.all().items()}

    @property
    def records(self) -> list[Record]:
        """Return the records of the finished cases, in the order of the test cases."""
        return [self.found[trial.name] for trial in self.trials if trial.name in self.found]

    @property
    def left(self) -> list[Trial]:
        """Return the cases that are still to be examined."""
        return [trial for trial in self.trials if trial.name not in self.found]

    @property
    def failed(self) -> list[Record]:
        """Return the cases in which something differs."""
        return failed(self.records)

    def run(self) -> None:
        """Examine the remaining cases; Ctrl-C keeps everything finished in the store."""
        done = len(self.records)
        with Progress("validation", 0, len(self.trials), self.show) as bar:
            for count, record in enumerate(self.examine_left(), start=done + 1):
                self.found[record.name] = record
                self.store.put(record.name, record.to_dict())
                bar.update(count)

    def examine_left(self) -> Iterator[Record]:
        """Yield records as they come; many cases run in processes of their own, which a crash of an engine may end."""
        left = self.left
        if len(left) < PROCESS_CASES_MIN:
            yield from (examined(trial, self.budget) for trial in left)
            return
        cells = [{"name": trial.name, "quick": self.quick, "budget": self.budget} for trial in left]
        for k, found in outcomes(examined_by_name, cells, list(range(len(cells))), "processes"):
            yield found if isinstance(found, Record) else lost(left[k], found.error)

    def write(self, folder: Path) -> list[Path]:
        """Write page and JSON of the finished cases."""
        content = content_of(self.records, quick=self.quick, complete=not self.left)
        html = page_of(self.records, content)
        return [
            write_atomically(folder / f"{STORE_NAME}.html", html.encode()),
            write_atomically(folder / f"{STORE_NAME}.json", encoded(content)),
        ]


def examined_by_name(cell: Mapping[str, Any]) -> Record:
    """Run a test case in another process: names travel, mechanisms are built there."""
    (trial,) = chosen(trials(cell["quick"]), (cell["name"],))
    return examined(trial, cell["budget"])


def lost(trial: Trial, error: str) -> Record:
    """Return the record of a case whose process died."""
    return Record(trial.name, trial.group, trial.title, (Finding(CERTIFICATE, DIFFERS, "run", note=error),))


@on_one_thread  # many small decompositions, for which threads cost more than they save
def examined(trial: Trial, budget: float) -> Record:
    """Return the record of a test case: its own judges, the engines, a picture, and the curves of convergence."""
    began = time.perf_counter()
    record, made = examine(trial)
    if made is None:
        return replace(record, seconds=time.perf_counter() - began)
    if trial.drawn:
        record = replace(record, picture=picture(made))
    try:
        findings, check = compared(made, trial, budget)
    except Exception as error:  # an engine that breaks must not take the other cases with it
        findings, check = [stopped(judge, "comparison", error) for judge in PEERS], None
    record = replace(record, findings=(*record.findings, *findings))
    if check is not None:
        charts = (chart(check),) if trial.drawn else ()
        record = replace(record, attributions=attributions(check), engines=settings(check), charts=charts)
    return replace(record, seconds=time.perf_counter() - began)
