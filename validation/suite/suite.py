"""Runs trials one after the other, keeps every record as it comes, and writes the reports."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from mbsd3d.files import write_atomically
from mbsd3d.progress import Progress
from mbsd3d.threads import on_one_thread

from .document import content_of, encoded
from .findings import Record, failed
from .ledger import Ledger
from .page import page_of
from .peers import PEERS, attributions, compared, settings
from .pictures import chart, picture
from .trial import Trial, examine, stopped

NAME = "validation"


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

    @on_one_thread  # many small decompositions, for which threads cost more than they save
    def run(self) -> None:
        """Examine what is left; Ctrl-C leaves everything that is finished in the ledger."""
        done = len(self.records)
        with Progress("validation", 0, len(self.trials), self.show) as bar:
            for count, trial in enumerate(self.left, start=done):
                bar.update(count)
                self.ledger.put(examined(trial, self.budget))

    def write(self, folder: Path) -> list[Path]:
        """Page and JSON of what is finished."""
        content = content_of(self.records, quick=self.quick, complete=not self.left)
        html = page_of(self.records, content)
        return [
            write_atomically(folder / f"{NAME}.html", html.encode()),
            write_atomically(folder / f"{NAME}.json", encoded(content)),
        ]


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
        charts = (chart(check, trial.name),) if trial.drawn else ()
        record = replace(record, attributions=attributions(check), engines=settings(check), charts=charts)
    return replace(record, seconds=time.perf_counter() - began)
