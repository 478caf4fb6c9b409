"""Runs of a calibration in parallel processes, each stored as it ends."""

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from mbsd3d import SweepError
from mbsd3d.extend import on_one_thread, outcomes
from validation.calibration.judge import Record, examine

ROOT = Path(__file__).parents[2]
Case = tuple[str, int]
"""Family and seed."""
PROCESS_CASES_MIN = 8  # [1] cases from which on processes are worth their start


def code_digest() -> str:
    """Return the digest of package and calibration: measurements of another version do not count."""
    paths = sorted([*(ROOT / "mbsd3d").rglob("*.py"), *(ROOT / "validation" / "calibration").rglob("*.py")])
    return hashlib.sha256(b"".join(path.read_bytes() for path in paths)).hexdigest()[:16]


def stored(path: Path, code: str) -> dict[Case, Record]:
    """Return the records of a file that this code has made; incomplete lines are left out."""
    found: dict[Case, Record] = {}
    names = {f.name for f in fields(Record)}
    for line in path.read_text(encoding="utf-8").splitlines() if path.is_file() else []:
        try:
            row = json.loads(line)
        except ValueError:  # the process was killed while it wrote
            continue
        if row.pop("code", None) == code and set(row) == names:
            record = Record(**{**row, "failures": tuple(row["failures"])})
            found[record.family, record.seed] = record
    return found


@on_one_thread  # many small decompositions
def examine_cell(cell: Mapping[str, Any]) -> Record:
    """Run a case in another process: names travel, mechanisms are built there."""
    return examine(cell["family"], cell["seed"])


def examined(cases: list[Case], path: Path) -> Iterator[Record]:
    """Yield records as they come, appended to a file of JSON lines; raise SweepError for a case that fails."""
    code, cells = code_digest(), [{"family": family, "seed": seed} for family, seed in cases]
    with path.open("a", encoding="utf-8") as file:
        for k, record in arriving(cells):
            if not isinstance(record, Record):
                family, seed = cases[k]
                raise SweepError(f"{family} of seed {seed}: {record.error}")
            file.write(json.dumps({**asdict(record), "code": code}) + "\n")
            file.flush()
            yield record


def arriving(cells: list[dict[str, Any]]) -> Iterator[tuple[int, Any]]:
    """Yield (number of the cell, record): few of them here, many in processes of their own."""
    if len(cells) < PROCESS_CASES_MIN:
        yield from ((k, examine_cell(cell)) for k, cell in enumerate(cells))
    else:
        yield from outcomes(examine_cell, cells, list(range(len(cells))), "processes")
