"""Engines and cars as records: those of the data files under a name, and a user's own, a file (.json) with one."""

import json
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

from mbsd3d.errors import InputError
from mbsd3d.extend import number, vector

DATA = Path(__file__).parent / "data"
Record = dict[str, Any]


@cache
def data(kind: str) -> Record:
    """The data file of "engines" or "cars"."""
    return json.loads((DATA / f"{kind}.json").read_text(encoding="utf-8"))


def is_file(name: str) -> bool:
    """Whether a name means a user's file."""
    return name.endswith(".json")


def record(kind: str, name: str) -> Record:
    """The record of the "engines" or "cars" under a name, or of a file; ValueError for an unknown name, or a file that
    holds no record.
    """
    if not is_file(name):
        known = data(kind)[kind]
        if name not in known:
            raise InputError(f"{kind[:-1]} '{name}' is unknown; there are {', '.join(known)}; or give a file (.json)")
        return known[name]
    try:
        found = json.loads(Path(name).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise InputError(f"{kind[:-1]} '{name}': {getattr(error, 'strerror', None) or error}") from None
    if not isinstance(found, dict):
        raise InputError(f"{kind[:-1]} '{name}': give one record, {{...}}; --export writes an example")
    return found


def fields(found: Any, needed: Iterable[str], what: str, free: Iterable[str] = ()) -> None:
    """ValueError if a record lacks a field or has one that is unknown."""
    if not isinstance(found, dict):
        raise InputError(f"{what}: expected a record, {{...}}")
    needed = list(needed)
    if missing := [name for name in needed if name not in found]:
        raise InputError(f"{what}: {', '.join(missing)} missing; --export writes an example")
    if unknown := [name for name in found if name not in needed and name not in free]:
        raise InputError(f"{what}: {', '.join(unknown)} unknown; it has {', '.join([*needed, *free])}")


def positive(found: Record, names: Iterable[str], what: str) -> None:
    """ValueError for a field that is not a number above 0."""
    for name in names:
        number(found[name], f"{what}: {name}", positive=True)


def triple(value: Any, what: str, **limits: Any) -> tuple[float, ...]:
    """Three numbers within ``limits`` as those of `number`; ValueError for others."""
    return tuple(number(x, f"{what}[{i}]", **limits) for i, x in enumerate(vector(value, what)))
