"""Finished work in a SQLite file, so that an interrupted run continues; of a sweep, its cells."""

import hashlib
import json
import sqlite3
from collections.abc import Callable, Mapping
from contextlib import closing, suppress
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from ..base.checks import short_repr
from ..base.errors import InputError
from ..base.paths import as_path, package_version
from .experiment import Experiment, Outcome
from .grids import Grid

FORMAT_VERSION = 1  # rises when an older ledger cannot be read any more
TABLES = (
    "CREATE TABLE IF NOT EXISTS sweep (digest TEXT NOT NULL, identity TEXT NOT NULL)",
    "CREATE TABLE IF NOT EXISTS cells (cell PRIMARY KEY, outcome TEXT NOT NULL)",
)


CONTENT_ERRORS = (ValueError, TypeError, RecursionError, OverflowError)  # of contents written by other programs


class Stored(msgspec.Struct, forbid_unknown_fields=True):
    """Content of a cell: numbers alone, as `Outcome` has them."""

    values: dict[str, float | list[float]]
    settings: str = ""
    error: str = ""


def reason(error: Exception) -> str:
    """Return the fault of the contents in a few words."""
    return "nested too deep" if isinstance(error, RecursionError) else short_repr(str(error)).strip("'\"")


class LedgerError(InputError):
    """Error for a ledger that cannot be opened, read or written."""


def identity(experiment: Experiment, grid: Grid, tag: str) -> dict[str, Any]:
    """Return the identity of a sweep: functions and settings by name, grid by value, version and tag."""
    run = experiment.run
    return {
        "format": FORMAT_VERSION,
        "mbsd3d": package_version(),
        "tag": tag,
        "build": title(experiment.build),
        "measure": title(experiment.measure),
        "run": run_stamp(run),
        "dims": list(grid.dims),
    } | {f"values of '{name}'": stamp(values) for name, (_, values) in grid.columns.items()}


def identity_of_study(experiment: Experiment, names: tuple[str, ...]) -> dict[str, Any]:
    """Return the identity of a study: functions by name, parameters and version; what else matters is in the keys."""
    return {
        "format": FORMAT_VERSION,
        "mbsd3d": package_version(),
        "build": title(experiment.build),
        "measure": title(experiment.measure),
        "parameters": list(names),
    }


def run_stamp(run: Mapping[str, Any] | Callable) -> str | dict[str, str]:
    """Return arguments of `simulate` by name and value, or the name of the function that returns them."""
    return title(run) if callable(run) else {key: stamp(value) for key, value in sorted(run.items())}


def point_key(kind: str, settings: str, x: np.ndarray) -> str:
    """Return the key of what was found at a point with some settings."""
    return f"{kind} {hashlib.sha256(settings.encode() + np.ascontiguousarray(x).tobytes()).hexdigest()}"


def stamp(value: Any) -> str:
    """Return a value as text, by all its fields; arrays, which repr shortens, by a digest of their numbers."""
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape} {hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()}"
    if is_dataclass(value) and not isinstance(value, type):  # a condition, say: its repr does not tell where it looks
        own = (f"{x.name}={stamp(getattr(value, x.name))}" for x in fields(value) if x.init)
        return f"{title(type(value))}({', '.join(own)})"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(stamp, value))}]"
    return title(value) if callable(value) else repr(value)


def title(function: Callable) -> str:
    """Return the name of a function without its module, which is "__main__" or not by the way the script is started."""
    return getattr(function, "__qualname__", type(function).__name__)


class Store:
    """Finished work by its key in a SQLite file, with the identity of what made it.

    Every piece is committed at once, so the finished work of a killed process is kept. Values are stored as JSON, which
    reads floats back bit for bit.

    ``identity`` is what makes two runs the same, as JSON: settings, versions; ``what`` names the work in messages, e.g.
    "sweep". If the file holds other work or is damaged, ``replace`` starts afresh: for files that a command keeps for
    itself. Otherwise a `LedgerError` states what differs; it is also raised for a file that cannot be used, read or
    written.
    """

    def __init__(self, path: str | Path, identity: Mapping[str, Any], what: str, *, replace: bool = False) -> None:
        self.path, self.what, self.replace = as_path(path, f"{what}.db"), what, replace
        try:
            try:
                self.open()
            except sqlite3.OperationalError:  # it is in use, say, or may not be written
                raise
            except sqlite3.DatabaseError:
                if not replace:
                    raise
                self.forget()
                self.open()
            self.check(dict(identity), replace)
        except sqlite3.Error as error:
            raise LedgerError(
                f"{what}: ledger '{self.path}' cannot be used: {error}; give a file that is new or of this {what}, in "
                "a folder that exists, is yours and has space"
            ) from error

    def open(self) -> None:
        """Open the file, and create its tables if it is new; raise sqlite3.DatabaseError if it is damaged."""
        self.file = sqlite3.connect(self.path, isolation_level=None)
        self.file.execute("PRAGMA journal_mode=WAL")
        self.file.execute("PRAGMA synchronous=NORMAL")
        for table in TABLES:
            self.file.execute(table)
        if self.replace and self.file.execute("PRAGMA quick_check").fetchone() != ("ok",):
            raise sqlite3.DatabaseError("damaged")

    def forget(self) -> None:
        """Remove a damaged file with the other files of SQLite."""
        self.close()
        for end in ("", "-wal", "-shm"):
            Path(f"{self.path}{end}").unlink(missing_ok=True)

    def check(self, own: dict[str, Any], replace: bool) -> None:
        """Check that the file holds this work: refuse or delete other work, and say what differs; a new file gets this
        identity.
        """
        text = json.dumps(own, sort_keys=True)
        found = self.file.execute("SELECT identity FROM sweep").fetchone()
        if found == (text,):
            return
        if found is not None and not replace:
            try:
                other = msgspec.convert(json.loads(found[0]), dict[str, Any])
            except CONTENT_ERRORS as error:
                raise self.unreadable(error) from error
            names = sorted(name for name in own.keys() | other.keys() if own.get(name) != other.get(name))
            names = names or ["its digest"]
            raise LedgerError(
                f"{self.what}: ledger '{self.path}' belongs to another {self.what}, it differs in {', '.join(names)}; "
                "give another file, or delete this one"
            )
        self.clear()
        self.file.execute("DELETE FROM sweep")
        digest = hashlib.sha256(text.encode()).hexdigest()
        self.file.execute("INSERT INTO sweep VALUES (?, ?)", (digest, text))

    def clear(self) -> None:
        """Delete all finished work."""
        self.file.execute("DELETE FROM cells")

    def all(self) -> dict[int | str, Any]:
        """Return all finished cells by their key."""
        try:
            rows = self.file.execute("SELECT cell, outcome FROM cells").fetchall()
            return {key: json.loads(text) for key, text in rows}
        except (sqlite3.Error, *CONTENT_ERRORS) as error:
            raise self.unreadable(error) from error

    def unreadable(self, error: Exception) -> LedgerError:
        """Return the error for contents that cannot be read."""
        return LedgerError(f"{self.what}: ledger '{self.path}' cannot be read: {reason(error)}; delete it")

    def put(self, key: int | str, value: Any) -> None:
        """Store a finished piece; it is in the file when this returns."""
        try:
            self.file.execute("INSERT OR REPLACE INTO cells VALUES (?, ?)", (key, json.dumps(value)))
        except sqlite3.Error as error:
            raise LedgerError(
                f"ledger '{self.path}' cannot be written: {error}; make room, and run the {self.what} again with this "
                "ledger: it goes on"
            ) from error

    def close(self) -> None:
        """Close the file."""
        with suppress(sqlite3.Error):  # what could not be written has been reported by `put`
            self.file.close()


class Ledger(Store):
    """Finished cells of a sweep; failed ones are not kept, they are tried again."""

    def __init__(self, path: str | Path, own: Mapping[str, Any], cells: int) -> None:
        super().__init__(path, own, "sweep")
        self.cells = cells

    def finished(self) -> dict[int, Outcome]:
        """Return the cells that need not run again."""
        found = self.all()
        try:
            stored = {cell: msgspec.convert(kept, Stored) for cell, kept in found.items()}
        except CONTENT_ERRORS as error:
            raise self.unreadable(error) from error
        if any(not isinstance(cell, int) or not 0 <= cell < self.cells for cell in stored):
            raise LedgerError(f"sweep: ledger '{self.path}' holds cells that the grid does not have; delete it")
        kept = {int(cell): Outcome(x.values, "", x.settings) for cell, x in stored.items() if not x.error}
        shapes = {tuple((name, np.shape(value)) for name, value in sorted(x.values.items())) for x in kept.values()}
        if len(shapes) > 1:
            raise LedgerError(f"sweep: ledger '{self.path}' holds cells with different values; delete it")
        return kept

    def keep(self, cell: int, outcome: Outcome) -> None:
        """Store a finished cell."""
        if not outcome.error:
            self.put(cell, {"values": outcome.values, "settings": outcome.settings})


class StoredPoint(msgspec.Struct, forbid_unknown_fields=True):
    """What a study found at a point."""

    values: dict[str, float | list[float]]
    jac: list[list[float]] | None = None


class PointLedger:
    """Values and derivatives that a study found, by point.

    The file is opened for each piece, so that it may serve several studies that differ in their sample times only.
    """

    def __init__(self, path: str | Path, own: Mapping[str, Any]) -> None:
        self.path, self.own = path, own
        with closing(self.open()) as file:
            found = file.all()
            try:
                self.known = {str(key): msgspec.convert(one, StoredPoint) for key, one in found.items()}
            except CONTENT_ERRORS as error:
                raise file.unreadable(error) from error

    def open(self) -> Store:
        """Open the file."""
        return Store(self.path, self.own, "study")

    def keep(self, key: str, values: Mapping[str, float | list[float]], jac: list[list[float]] | None = None) -> None:
        """Store what was found at a point."""
        with closing(self.open()) as file:
            self.put(file, key, values, jac)

    def put(self, file: Store, key: str, values: Mapping[str, Any], jac: list[list[float]] | None = None) -> None:
        """Store what was found at a point in the open file."""
        file.put(key, {"values": dict(values), "jac": jac})
        self.known[key] = StoredPoint(dict(values), jac)


class PointCells:
    """The points of a study as the cells of a sweep, for which the file stays open."""

    def __init__(self, ledger: PointLedger, keys: list[str]) -> None:
        self.ledger, self.keys, self.file = ledger, keys, ledger.open()

    def finished(self) -> dict[int, Outcome]:
        """Return the points that need not run again."""
        known = self.ledger.known
        return {cell: Outcome(known[key].values) for cell, key in enumerate(self.keys) if key in known}

    def keep(self, cell: int, outcome: Outcome) -> None:
        """Store a finished point."""
        if not outcome.error:
            self.ledger.put(self.file, self.keys[cell], outcome.values)

    def close(self) -> None:
        """Close the file."""
        self.file.close()
