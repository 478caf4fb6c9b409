"""Makes pictures and numbers of the demos for their pages: ``python docs/make_demo_pictures.py [NAME ...]``.

Every demo runs once: ``docs/pictures/demos/NAME.png`` shows its mechanism, and ``docs/demos.json`` keeps its numbers
beside theory.
"""

import json
import sys
from collections.abc import Sequence
from pathlib import Path

from mbsd3d import demos
from mbsd3d.base.paths import write_atomically
from mbsd3d.demos import gallery
from mbsd3d.demos.base import Outcome
from mbsd3d.extend import discover

DOCS = Path(__file__).parent
PICTURES, NUMBERS = DOCS / "pictures" / "demos", DOCS / "demos.json"
DIGITS = 6  # of computed values and theory


def numbers() -> dict[str, list[list[str]]]:
    """Demo -> its rows (quantity with unit, computed, theory), as they were last written."""
    return json.loads(NUMBERS.read_text(encoding="utf-8")) if NUMBERS.exists() else {}


def rows(outcome: Outcome) -> list[list[str]]:
    """The rows of a table: quantity with its unit, computed value, theory."""
    found = []
    for row in outcome.rows:
        values = (0.0 if abs(value) < 0.1 * row.tolerance else value for value in (row.computed, row.theory))
        found.append([gallery.cells(row)[0], *(f"{value:.{DIGITS}g}" for value in values)])
    return found


def make(names: Sequence[str]) -> None:
    """Run some demos, and write their pictures and numbers."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    for name in names:
        outcome = demos.run(name)
        gallery.picture(outcome, PICTURES / f"{name}.png")
        kept = {**numbers(), name: rows(outcome)}
        text = json.dumps({demo: kept[demo] for demo in discover() if demo in kept}, indent=1, ensure_ascii=False)
        write_atomically(NUMBERS, (text + "\n").encode())
        print(name, flush=True)


if __name__ == "__main__":
    make(sys.argv[1:] or list(discover()))
