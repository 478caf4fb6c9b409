"""Table of the calibration in docs/theory/certificate.md, from the figures in docs/calibration.json."""

import json
import re
from collections.abc import Sequence
from datetime import date
from pathlib import Path
from typing import Any

from mbsd3d.extend import write_atomically
from validation.calibration import table
from validation.calibration.judge import Record

ROOT = Path(__file__).parents[2]
FIGURES_FILE, PAGE_FILE = Path("docs/calibration.json"), Path("docs/theory/certificate.md")
TABLE_PATTERN = re.compile(r"(?<=<!-- calibration -->\n).*?(?=<!-- end of calibration -->)", re.DOTALL)


def figures(records: Sequence[Record]) -> dict[str, Any]:
    """Return the content of docs/calibration.json for a calibration."""
    return {
        "date": date.today().isoformat(),
        "runs": len(records),
        "families": len({r.family for r in records}),
        "rows": table.rows(records),
    }


def renewed(page: str, found: dict[str, Any]) -> str:
    """Return the page with its table renewed."""
    head = f"{found['runs']} runs of {found['families']} families, {found['date']}:"
    return TABLE_PATTERN.sub(lambda _: f"\n{head}\n\n{table.markdown(found['rows'])}\n\n", page)


def renew(records: Sequence[Record], root: Path = ROOT) -> None:
    """Store the figures, and write the table of them into the page."""
    found = figures(records)
    write_atomically(root / FIGURES_FILE, (json.dumps(found, indent=1) + "\n").encode())
    page = (root / PAGE_FILE).read_text(encoding="utf-8")
    write_atomically(root / PAGE_FILE, renewed(page, found).encode())
