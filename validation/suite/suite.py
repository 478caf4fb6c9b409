"""Runs trials one after the other, keeps every record as it comes, and writes the reports."""

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from mbsd3d.extend import Progress, on_one_thread, outcomes, write_atomically

from .charts import chart
from .document import content_of, encoded
from .findings import CERTIFICATE, DIFFERS, Finding, Record, failed
from .ledger import Ledger
from .listing import chosen, trials
from .page import page_of
from .peers import PEERS, attributions, compared, settings
from .pictures import picture
from .trial import Trial, examine, stopped

NAME = "validation"
SEVERAL = 4  # cases that are worth the seconds in which processes start


@dataclass(frozen=True)
class Suite:
    """What is run, where its results are kept, and how many seconds an engine gets for a case."""

    trials: Sequence[Trial]
    ledger: Ledger
    quick: bool = False
    budget: float = 1.0
    show: bool | None = None

    @property
    def records(self) -> list[Record]:
        """Of the cases that are finished, in the order of the trials."""
        return [self.ledger.records[trial.name] for trial in self.trials if trial.name in self.ledger.records]

    @property
    def left(self) -> list[Trial]:
        """Cases that are still to be examined."""
        return [trial for trial in self.trials if trial.name not in self.ledger.records]

    @property
    def failed(self) -> list[Record]:
        """Cases in which something differs."""
        return failed(self.records)

    def run(self) -> None:
        """Examine what is left; Ctrl-C leaves everything that is finished in the ledger."""
        done = len(self.records)
        with Progress("validation", 0, len(self.trials), self.show) as bar:
            for count, record in enumerate(self.examine_left(), start=done + 1):
                self.ledger.put(record)
                bar.update(count)

    def examine_left(self) -> Iterator[Record]:
        """Records as they come; many cases go to processes of their own, which an engine may take down with it."""
        left = self.left
        if len(left) < SEVERAL:
            yield from (examined(trial, self.budget) for trial in left)
            return
        cells = [{"name": trial.name, "quick": self.quick, "budget": self.budget} for trial in left]
        for k, found in outcomes(examined_by_name, cells, list(range(len(cells))), "processes"):
            yield found if isinstance(found, Record) else lost(left[k], found.error)

    def write(self, folder: Path) -> list[Path]:
        """Page and JSON of what is finished."""
        content = content_of(self.records, quick=self.quick, complete=not self.left)
        html = page_of(self.records, content)
        return [
            write_atomically(folder / f"{NAME}.html", html.encode()),
            write_atomically(folder / f"{NAME}.json", encoded(content)),
        ]


def examined_by_name(cell: Mapping[str, Any]) -> Record:
    """A trial in another process: names travel, mechanisms are built there."""
    (trial,) = chosen(trials(cell["quick"]), (cell["name"],))
    return examined(trial, cell["budget"])


def lost(trial: Trial, error: str) -> Record:
    """Record of a case whose process died."""
    return Record(trial.name, trial.group, trial.title, (Finding(CERTIFICATE, DIFFERS, "run", note=error),))


@on_one_thread  # many small decompositions, for which threads cost more than they save
def examined(trial: Trial, budget: float) -> Record:
    """Record of a trial: its own judges, the engines, a picture, and the curves of convergence."""
    began = time.perf_counter()
    record, made = examine(trial)
    if made is None:
        return record
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
