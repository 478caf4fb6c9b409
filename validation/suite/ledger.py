"""The ledger of a run: one line of JSON per finished case, so that a killed run goes on where it stopped."""

import hashlib
import json
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import mbsd3d
from validation.suite.findings import Record, record_from

FILE = "validation.jsonl"
PACKAGES = ("numpy", "scipy", "numba", "mujoco-core", "mujoco", "exudyn")
SOURCES = ("*.py", "references/*.json", "data/*.json")


def identity(**settings: Any) -> dict[str, Any]:
    """What makes the results of two runs exchangeable: sources, versions of all that computes, settings.

    An edited kernel, reference or closed form gives another identity, so no result outlives what it was made of.
    """
    text, here = hashlib.sha256(), Path(__file__).parents[1]
    for folder in (Path(mbsd3d.__file__).parent, here, here.with_name("bicycle")):
        for path in sorted(path for pattern in SOURCES for path in folder.rglob(pattern)):
            text.update(path.relative_to(folder).as_posix().encode() + path.read_bytes())
    return {"sources": text.hexdigest(), "versions": {name: installed(name) for name in PACKAGES}, **settings}


def installed(package: str) -> str | None:
    """Version of a distribution, None if it is absent."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


class Ledger:
    """Records of finished cases in a file of a folder.

    The first line is the identity. A file of another identity is begun anew: its results were made by other code or
    settings. A line cut off by a kill is left out.
    """

    def __init__(self, folder: Path, own: Mapping[str, Any], fresh: bool = False) -> None:
        self.path, self.own = folder / FILE, dict(own)
        self.records: dict[str, Record] = {} if fresh else self.read()
        lines = [self.own, *(record.to_dict() for record in self.records.values())]
        self.path.write_text("".join(f"{json.dumps(line)}\n" for line in lines), encoding="utf-8")

    def read(self) -> dict[str, Record]:
        """Finished cases by name; none of another identity."""
        if not self.path.is_file():
            return {}
        head, *lines = self.path.read_text(encoding="utf-8").splitlines() or [""]
        if parsed(head) != self.own:
            return {}
        found = [made for made in map(restored, lines) if made is not None]
        return {record.name: record for record in found}

    def put(self, record: Record) -> None:
        """Add a finished case; it is in the file when this returns."""
        self.records[record.name] = record
        with self.path.open("a", encoding="utf-8") as file:
            file.write(f"{json.dumps(record.to_dict())}\n")


def parsed(line: str) -> Any:
    """JSON of a line, None if it was cut off."""
    try:
        return json.loads(line)
    except ValueError:
        return None


def restored(line: str) -> Record | None:
    """Record of a line, None if it was cut off or is none."""
    data = parsed(line)
    try:
        return record_from(data)
    except (KeyError, TypeError):
        return None
