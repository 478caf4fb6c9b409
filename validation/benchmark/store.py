"""Measured rows on disk: written after every problem, so that an interrupted run goes on where it was."""

import json
from collections.abc import Sequence
from pathlib import Path

from mbsd3d.extend import write_atomically

from ..machine import installed
from .ladders import TARGETS
from .precision import Row, from_dict

PACKAGES = ("mbsd3d", "mujoco-core", "exudyn", "numpy", "numba")


def versions() -> list[str]:
    """What rows of one file have in common."""
    return [installed(package) for package in PACKAGES]


def save(path: Path, rows: Sequence[Row], machine: str, complete: bool) -> None:
    """Write all rows; ValueError if the folder cannot be written."""
    data = {
        "machine": machine,
        "versions": versions(),
        "targets": list(TARGETS),
        "complete": complete,
        "rows": [row.to_dict() for row in rows],
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, json.dumps(data, indent=1).encode())


def load(path: Path, *, unfinished: bool = False) -> list[Row]:
    """The rows of a file; with ``unfinished`` only those of an interrupted run of these versions.

    Raises
    ------
    ValueError
        If the file is missing or not one of these.
    """
    if not path.is_file():
        if unfinished:
            return []
        raise ValueError(f"{path}: not found; measure first, python -m validation.benchmark --out {path.parent}")
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        rows = [from_dict(row) for row in data["rows"]]
        other = data["complete"] or data["versions"] != versions() or data["targets"] != list(TARGETS)
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{path}: no rows of a benchmark ({error}); move it away, or give another --out") from None
    return [] if unfinished and other else rows
