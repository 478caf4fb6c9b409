"""``python -m validation.benchmark.texts [precision.json]`` renews the times in README.md and docs/performance.md.

All figures stand in docs/measured.json, with date, machine and the kernels they belong to; the texts hold tables made
of it between two marks. With the file of a new measurement, docs/measured.json is renewed first.
"""

import json
import re
import sys
import textwrap
from datetime import date
from pathlib import Path
from typing import Any

from mbsd3d.extend import CACHE, write_atomically
from validation.benchmark.candidates import ENGINES
from validation.benchmark.precision import load
from validation.benchmark.problems import PROBLEMS
from validation.benchmark.tables import MIDDLE, milliseconds

ROOT = Path(__file__).parents[2]
MEASURED = Path("docs/measured.json")
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
FEW = (
    "free body", "top fast", "Cardan", "RSSR", "Bricard", "Stewart platform", "ladder 30", "bicycle M1", "arm 6R",
    "chain 100",
)  # fmt: skip
TEXTS = {"README.md": FEW, "docs/performance.md": tuple(PROBLEMS)}
MARK = re.compile(r"(?<=<!-- times -->\n).*?(?=<!-- end of times -->)", re.DOTALL)


def measured(path: Path) -> dict[str, Any]:
    """What docs/measured.json is to hold of a file of ``validation.benchmark``; ValueError if there is none."""
    rows = load(path)
    ms = {row.name: [milliseconds(row.reached(engine, MIDDLE)) for engine in ENGINES] for row in rows}
    machine = json.loads(path.read_text(encoding="utf-8"))["machine"].split("; load")[0]
    return {"date": date.today().isoformat(), "machine": machine, "kernels": CACHE.name, "note": "", "ms": ms}


def table(data: dict[str, Any], names: tuple[str, ...]) -> str:
    """The lines between the marks of a text: where and when, a table of the problems that were measured, a note."""
    lines = [*textwrap.wrap(f"Measured {data['date']} on {data['machine']}.", 120), ""]
    lines += ["| ms | mbsd3d | MuJoCo | Exudyn |", "|---|---|---|---|"]
    for name in (name for name in names if name in data["ms"]):
        cells = [cell.replace(">", "> ").replace("<", "< ") for cell in data["ms"][name]]
        lines.append(f"| {' | '.join([NAMES.get(name, name), *cells])} |")
    note = ["", *textwrap.wrap(data["note"], 120)] if data["note"] else []
    return "\n".join(["", *lines, *note, "", ""])


def renewed(root: Path, data: dict[str, Any]) -> dict[Path, str]:
    """Texts with their tables as they should be."""
    texts = {root / name: (root / name).read_text(encoding="utf-8") for name in TEXTS}
    return {path: MARK.sub(lambda _, p=path: table(data, TEXTS[p.relative_to(root).as_posix()]), text)
            for path, text in texts.items()}  # fmt: skip


def main(arguments: list[str]) -> None:
    """Renew the data if a file is given, and then the texts."""
    store = ROOT / MEASURED
    if arguments:
        write_atomically(store, (json.dumps(measured(Path(arguments[0])), indent=1) + "\n").encode())
    for path, text in renewed(ROOT, json.loads(store.read_text(encoding="utf-8"))).items():
        write_atomically(path, text.encode())


if __name__ == "__main__":
    main(sys.argv[1:])
