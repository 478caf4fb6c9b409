"""The runs of a calibration, in processes side by side, each written down as it ends."""

import hashlib
import json
import multiprocessing
import os
from collections.abc import Iterator
from dataclasses import asdict, fields
from pathlib import Path

from validation.calibration.judge import Record, examine

ROOT = Path(__file__).parents[2]
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")  # small matrices: one thread a process


def code_digest() -> str:
    """Of the package and of the calibration: what another version has measured does not count."""
    paths = sorted([*(ROOT / "mbsd3d").rglob("*.py"), *(ROOT / "validation" / "calibration").rglob("*.py")])
    return hashlib.sha256(b"".join(path.read_bytes() for path in paths)).hexdigest()[:16]


def stored(path: Path, code: str) -> dict[tuple[str, int], Record]:
    """The records of a file that the same code has made; a last line that is not whole is left out."""
    if not path.is_file():
        return {}
    found = {}
    names = {f.name for f in fields(Record)}
    for line in path.read_text(encoding="utf-8").splitlines():
        try:
            row = json.loads(line)
        except ValueError:
            continue
        if row.pop("code", None) == code and set(row) == names:
            record = Record(**{**row, "failures": tuple(row["failures"])})
            found[record.family, record.seed] = record
    return found


def examine_one(case: tuple[str, int]) -> Record:
    """`examine` of a pair."""
    return examine(*case)


def examined(cases: list[tuple[str, int]], path: Path, jobs: int) -> Iterator[Record]:
    """Records as they come, appended to a file of JSON lines."""
    code = code_digest()
    with path.open("a", encoding="utf-8") as file:
        for record in outcomes(cases, min(jobs, len(cases))):
            file.write(json.dumps({**asdict(record), "code": code}) + "\n")
            file.flush()
            yield record


def outcomes(cases: list[tuple[str, int]], jobs: int) -> Iterator[Record]:
    """Records in any order; here, or in processes of their own."""
    if jobs <= 1:
        yield from map(examine_one, cases)
        return
    os.environ.update(dict.fromkeys(THREADS, "1"))
    with multiprocessing.get_context("spawn").Pool(jobs) as pool:
        yield from pool.imap_unordered(examine_one, cases)
