"""The ledger of a sweep: a SQLite file that holds every finished cell, so that an interrupted sweep goes on."""

import hashlib
import json
import sqlite3
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from ..base.checks import shown
from ..base.paths import package_version
from .experiment import Experiment, Outcome
from .grids import Grid

FORMAT = 1  # rises when an older ledger cannot be read any more
TABLES = (
    "CREATE TABLE IF NOT EXISTS sweep (digest TEXT NOT NULL, identity TEXT NOT NULL)",
    "CREATE TABLE IF NOT EXISTS cells (cell INTEGER PRIMARY KEY, outcome TEXT NOT NULL)",
)


UNREADABLE = (ValueError, TypeError, RecursionError, OverflowError)  # of contents that nobody of us has written


class Stored(msgspec.Struct, forbid_unknown_fields=True):
    """What a cell holds: numbers alone, as `Outcome` has them."""

    values: dict[str, float | list[float]]
    settings: str = ""
    error: str = ""


def reason(error: Exception) -> str:
    """What is wrong with the contents, in a few words."""
    return "nested too deep" if isinstance(error, RecursionError) else shown(str(error)).strip("'\"")


class LedgerError(ValueError):
    """A ledger that cannot be opened, read or written."""


def identity(experiment: Experiment, grid: Grid, tag: str) -> dict[str, Any]:
    """What makes two sweeps the same: functions and settings by name, grid by value, version and tag."""
    run = experiment.run
    return {
        "format": FORMAT,
        "mbsd3d": package_version(),
        "tag": tag,
        "build": title(experiment.build),
        "measure": title(experiment.measure),
        "run": title(run) if callable(run) else {key: stamp(value) for key, value in sorted(run.items())},
        "dims": list(grid.dims),
    } | {f"values of '{name}'": stamp(values) for name, (_, values) in grid.columns.items()}


def stamp(value: Any) -> str:
    """A value as text; arrays, which repr shortens, by a digest of their numbers."""
    if not isinstance(value, np.ndarray):
        return repr(value)
    return f"{value.dtype} {value.shape} {hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()}"


def title(function: Callable) -> str:
    """Name of a function; not its module, which is "__main__" or not by the way the script is started."""
    return getattr(function, "__qualname__", type(function).__name__)


class Ledger:
    """Finished cells in a file; failed ones are not kept, they are tried again.

    Every cell is committed as it comes: what a killed process had finished is there. Floats are stored as JSON, which
    reads back bit for bit.
    """

    def __init__(self, path: str | Path, own: dict[str, Any], cells: int) -> None:
        self.path, self.cells = Path(path), cells
        try:
            self.file = sqlite3.connect(self.path, isolation_level=None)
            self.file.execute("PRAGMA journal_mode=WAL")
            self.file.execute("PRAGMA synchronous=NORMAL")
            for table in TABLES:
                self.file.execute(table)
            self.check(own)
        except sqlite3.Error as error:
            raise LedgerError(
                f"sweep: ledger '{self.path}' cannot be used: {error}; give a file in a folder that exists and is "
                "yours, and that is new or the ledger of this sweep"
            ) from error

    def check(self, own: dict[str, Any]) -> None:
        """Refuse the ledger of another sweep, and say what differs; a new one gets the identity of this sweep."""
        text = json.dumps(own, sort_keys=True)
        digest = hashlib.sha256(text.encode()).hexdigest()
        found = self.file.execute("SELECT digest, identity FROM sweep").fetchone()
        if found is None:
            self.file.execute("INSERT INTO sweep VALUES (?, ?)", (digest, text))
        elif found[0] != digest:
            try:
                other = msgspec.convert(json.loads(found[1]), dict[str, Any])
            except UNREADABLE as error:
                raise LedgerError(f"sweep: ledger '{self.path}' cannot be read: {reason(error)}; delete it") from error
            names = sorted(name for name in own.keys() | other.keys() if own.get(name) != other.get(name))
            names = names or ["its digest"]
            raise LedgerError(
                f"sweep: ledger '{self.path}' belongs to another sweep, it differs in {', '.join(names)}; "
                "give another file, or delete this one"
            )

    def finished(self) -> dict[int, Outcome]:
        """The cells that need not run again."""
        try:
            rows = self.file.execute("SELECT cell, outcome FROM cells").fetchall()
            stored = {cell: msgspec.convert(json.loads(text), Stored) for cell, text in rows}
        except (sqlite3.Error, *UNREADABLE) as error:
            raise LedgerError(f"sweep: ledger '{self.path}' cannot be read: {reason(error)}; delete it") from error
        if any(not isinstance(cell, int) or not 0 <= cell < self.cells for cell in stored):
            raise LedgerError(f"sweep: ledger '{self.path}' holds cells that the grid does not have; delete it")
        kept = {cell: Outcome(x.values, "", x.settings) for cell, x in stored.items() if not x.error}
        shapes = {tuple((name, np.shape(value)) for name, value in sorted(x.values.items())) for x in kept.values()}
        if len(shapes) > 1:
            raise LedgerError(f"sweep: ledger '{self.path}' holds cells with different values; delete it")
        return kept

    def put(self, cell: int, outcome: Outcome) -> None:
        """Store a finished cell; LedgerError if that fails."""
        if outcome.error:
            return
        text = json.dumps({"values": outcome.values, "settings": outcome.settings})
        try:
            self.file.execute("INSERT OR REPLACE INTO cells VALUES (?, ?)", (cell, text))
        except sqlite3.Error as error:
            raise LedgerError(f"ledger '{self.path}' cannot be written: {error}") from error

    def close(self) -> None:
        """Give the file back."""
        with suppress(sqlite3.Error):  # what could not be written has been reported by `put`
            self.file.close()
