"""Command ``python -m validation.benchmark.texts [FOLDER]``, which renews the times in README.md and
docs/performance.md.

All figures stand in docs/measured.json, with date, machine and the kernels they belong to; the texts hold tables made
of it between two marks, and say so if the kernels have changed since. With the folder of a new measurement,
docs/measured.json is renewed first.
"""

import hashlib
import json
import re
import sys
import textwrap
from datetime import date
from pathlib import Path
from typing import Any

from mbsd3d.errors import InputError
from mbsd3d.extend import compiled_sources, write_atomically
from validation.benchmark.candidates import ENGINES
from validation.benchmark.cli import DATA, SPEED
from validation.benchmark.precision import load
from validation.benchmark.problems import PROBLEMS
from validation.benchmark.speed import exponent
from validation.benchmark.tables import MIDDLE_ERROR, milliseconds

ROOT = Path(__file__).parents[2]
MEASURED_FILE = Path("docs/measured.json")
NAMES = {
    "free body": "free tumbling body",
    "top fast": "fast heavy top",
    "top slow": "slow heavy top",
    "Cardan": "Cardan shafts, coasting",
    "Andrews": "Andrews' mechanism",
    "four-bar 2": "four-bar with 2 windows, 10 s, singular poses",
    "four-bar 40": "four-bar with 40 windows, 10 s, singular poses",
    "ladder 10": "ladder of 10 redundant four-bars",
    "ladder 30": "ladder of 30 redundant four-bars",
    "bicycle M1": "bicycle, IFToMM M1",
    "bicycle M3": "bicycle, IFToMM M3",
    "arm 6R": "6R arm",
    "ball chain 10": "chain of 10 ball joints",
    **{f"chain {n}": f"chain of {n} hinges" for n in (10, 30, 100, 150, 300, 1000)},
}
README_PROBLEMS = (
    "free body", "top fast", "Cardan", "RSSR", "Bricard", "Stewart platform", "ladder 30", "bicycle M1", "arm 6R",
    "chain 100",
)  # fmt: skip
PROBLEMS_BY_PAGE = {"README.md": README_PROBLEMS, "docs/performance.md": tuple(PROBLEMS)}
TABLE_PATTERN = re.compile(r"(?<=<!-- (times|speed) -->\n).*?(?=<!-- end of \1 -->)", re.DOTALL)


def measured(folder: Path) -> dict[str, Any]:
    """Return the content of docs/measured.json from a folder of ``validation.benchmark``; raise ValueError if a file is
    missing.
    """
    rows, speed = load(folder / DATA), folder / SPEED
    if not speed.is_file():
        raise InputError(f"{speed}: not found; measure first, python -m validation.benchmark --part speed")
    found = json.loads(speed.read_text(encoding="utf-8"))
    growing = found.pop("growing")
    found |= {"long": growing["chain"], "growth": {name: exponent(costs) for name, costs in growing.items()}}
    ms = {row.name: [milliseconds(row.reached(engine, MIDDLE_ERROR)) for engine in ENGINES] for row in rows}
    machine = json.loads((folder / DATA).read_text(encoding="utf-8"))["machine"].split("; load")[0]
    when = {"date": date.today().isoformat(), "machine": machine, "kernels": kernels(), "note": ""}
    return {**when, "ms": ms, "speed": found}


def kernels() -> str:
    """Return the digest of the code that is timed."""
    return hashlib.sha256(b"".join(path.read_bytes() for path in compiled_sources())).hexdigest()[:16]


def where(data: dict[str, Any]) -> list[str]:
    """Return lines on date and machine of the measurement, and whether the code is older than that."""
    since = "" if data["kernels"] == kernels() else " The kernels have changed since."
    return textwrap.wrap(f"Measured {data['date']} on {data['machine']}.{since}", 120)


def note(data: dict[str, Any]) -> list[str]:
    """Return lines with the note on the figures, if there is one."""
    return ["", *textwrap.wrap(data["note"], 120)] if data["note"] else []


def times(data: dict[str, Any], names: tuple[str, ...]) -> str:
    """Tabulate milliseconds to an error of the measured problems."""
    lines = ["| ms | mbsd3d | MuJoCo | Exudyn |", "|---|---|---|---|"]
    for name in (name for name in names if name in data["ms"]):
        cells = [cell.replace(">", "> ").replace("<", "< ") for cell in data["ms"][name]]
        lines.append(f"| {' | '.join([NAMES.get(name, name), *cells])} |")
    return "\n".join(["", *where(data), "", *lines, *note(data), "", ""])


def speed(data: dict[str, Any]) -> str:
    """Tabulate the cost of an evaluation, and the times of one-time work."""
    found = data["speed"]
    ours = {n: f"{cost:.2f}" for n, cost, *_ in (*found["long"], *found["chain"])}
    theirs = {n: f"{cost:.2f}" for n, _, cost in found["chain"]}
    growth, check, start = found["growth"], found["check"], found["start"]
    sizes = sorted(ours)
    lines = [
        f"| µs per body and evaluation of a chain of hinges | {' | '.join(map(str, sizes))} |",
        "|---" * (1 + len(sizes)) + "|",
        f"| RK4, with projection after every step | {' | '.join(ours[n] for n in sizes)} |",
        f"| MuJoCo, RK4 | {' | '.join(theirs.get(n, '') for n in sizes)} |",
        "",
        f"The cost grows as n^{growth['chain']:.2f} from {found['long'][0][0]} to {found['long'][-1][0]} links, and as "
        f"n^{growth['ladder']:.2f} for ladders of four-bars with three",
        "redundant rows each.",
        "",
        "| one-time work | s |",
        "|---|---|",
        f"| `check()` of a chain of 1000 bodies, of a ladder of 100 four-bars | {check[0]:.1f}, {check[1]:.1f} |",
        f"| start of a process to its first result; with all kernels to compile | {start[0]:.1f}; {start[1]:.0f} |",
    ]
    return "\n".join(["", *where(data), "", *lines, *note(data), "", ""])


def renewed(root: Path, data: dict[str, Any]) -> dict[Path, str]:
    """Return the texts with their tables renewed."""
    found = {}
    for name, problems in PROBLEMS_BY_PAGE.items():
        tables = {"times": times(data, problems), "speed": speed(data)}
        found[root / name] = filled((root / name).read_text(encoding="utf-8"), tables)
    return found


def filled(text: str, tables: dict[str, str]) -> str:
    """Return a text with its tables replaced."""
    return TABLE_PATTERN.sub(lambda mark: tables[mark[1]], text)


def main(arguments: list[str]) -> None:
    """Renew the data if a folder is given, and then the texts."""
    store = ROOT / MEASURED_FILE
    if arguments:
        write_atomically(store, (json.dumps(measured(Path(arguments[0])), indent=1) + "\n").encode())
    for path, text in renewed(ROOT, json.loads(store.read_text(encoding="utf-8"))).items():
        write_atomically(path, text.encode())


if __name__ == "__main__":
    main(sys.argv[1:])
