"""Engines and cars as records: those of the data files by name, and a user's own from a file (.json)."""

import csv
import json
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from mbsd3d.errors import InputError
from mbsd3d.extend import number, read_text, similar, vector

RECORD_BYTES_MAX, TABLE_BYTES_MAX = 1_000_000, 10_000_000  # bytes of a file with a record, and of a table
DATA = Path(__file__).parent / "data"
Record = dict[str, Any]


@cache
def data(kind: str) -> Record:
    """Return the data file of "engines" or "cars"."""
    return json.loads((DATA / f"{kind}.json").read_text(encoding="utf-8"))


def is_file(name: str) -> bool:
    """Return whether a name means a user's file."""
    return name.endswith(".json")


def record(kind: str, name: str) -> Record:
    """Return the record of the "engines" or "cars" under a name, or of a file; raise ValueError for an unknown name or
    a file without a record.
    """
    if not is_file(name):
        known = data(kind)[kind]
        if name not in known:
            near = similar(name, known)
            hint = f", did you mean '{near[0]}'? There" if near else "; there"
            raise InputError(f"{kind[:-1]} '{name}' is unknown{hint} are {', '.join(known)}; or give a file (.json)")
        return known[name]
    text = read_text(Path(name), RECORD_BYTES_MAX, kind[:-1])
    try:
        found = json.loads(text)
    except (ValueError, RecursionError) as error:  # not JSON, a number of too many digits, nested too deep
        raise InputError(f"{kind[:-1]} '{name}' is not JSON: {error}; --export writes an example") from None
    if not isinstance(found, dict):
        raise InputError(f"{kind[:-1]} '{name}': give one record, {{...}}; --export writes an example")
    return found


def table(path: Path, headers: Sequence[Sequence[str]], kind: str) -> tuple[list[str], list[tuple[str, list[str]]]]:
    """Read header and (where, cells) of every line of a file of comma-separated values, without empty lines.

    ValueError for a file that cannot be read, another header, or a line with more or fewer cells.
    """
    text = read_text(path, TABLE_BYTES_MAX, kind)
    try:
        rows = csv.reader(text.splitlines())
        lines = [(k, [cell.strip() for cell in row]) for k, row in enumerate(rows, start=1) if any(row)]
    except csv.Error as error:
        raise InputError(f"{kind} '{path}': {error}; give a file of comma-separated values") from None
    if not lines or lines[0][1] not in headers:
        heads = " or ".join(f"'{','.join(header)}'" for header in headers)
        raise InputError(f"{kind} '{path.name}': line 1 must be {heads}")
    header = lines[0][1]
    for k, row in lines[1:]:
        if len(row) != len(header):
            raise InputError(f"{kind} '{path.name}': line {k} has {len(row)} values; give {len(header)}")
    return header, [(f"{kind} '{path.name}': line {k}", row) for k, row in lines[1:]]


def cell(text: str, what: str) -> float:
    """Return a cell as a finite number."""
    try:
        return number(float(text), what)
    except ValueError:
        raise InputError(f"{what} is '{text}'; give a number") from None


def fields(found: Any, needed: Iterable[str], what: str, free: Iterable[str] = ()) -> None:
    """Raise ValueError if a record lacks a field or has an unknown one."""
    if not isinstance(found, dict):
        raise InputError(f"{what}: expected a record, {{...}}")
    needed = list(needed)
    if missing := [name for name in needed if name not in found]:
        raise InputError(f"{what}: {', '.join(missing)} missing; --export writes an example")
    if unknown := [name for name in found if name not in needed and name not in free]:
        raise InputError(f"{what}: {', '.join(unknown)} unknown; it has {', '.join([*needed, *free])}")


def positive(found: Record, names: Iterable[str], what: str) -> None:
    """Raise ValueError for a field that is not a number above 0."""
    for name in names:
        number(found[name], f"{what}: {name}", positive=True)


def titled(title: Any, what: str) -> None:
    """Raise ValueError for a title that is not a text, or an empty one."""
    if not isinstance(title, str) or not title.strip():
        raise InputError(f"{what}: title {title!r:.80}; give a few words")


def triple(value: Any, what: str, **limits: Any) -> tuple[float, float, float]:
    """Return three numbers within ``limits`` as those of `number`; raise ValueError for others."""
    x, y, z = (number(x, f"{what}[{i}]", **limits) for i, x in enumerate(vector(value, what)))
    return x, y, z
