"""Tables as CSV files."""

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from .paths import with_suffix, write_atomically


def write_table(path: str | Path, head: Sequence[str], rows: Iterable[Sequence[Any]]) -> Path:
    """Write names with units, then rows of texts and numbers with all their digits; ".csv" is appended if missing."""
    sheet = io.StringIO()
    writer = csv.writer(sheet, lineterminator="\n")
    writer.writerow(head)
    writer.writerows([x if isinstance(x, str) else repr(float(x)) for x in row] for row in rows)
    return write_atomically(with_suffix(path, ".csv"), sheet.getvalue().encode())
