"""Tables of the studies as CSV files."""

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from mbsd3d.base.paths import with_suffix, write_atomically


def write_table(path: str | Path, head: Sequence[str], rows: Iterable[Sequence[Any]]) -> Path:
    """Write a table; numbers with all their digits.

    Parameters
    ----------
    path : str or Path
        ".csv" is appended if it is missing.
    head : sequence of str
        Names and units.
    rows : iterable of sequences
        Texts and numbers.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ValueError
        If the folder cannot be written.
    """
    sheet = io.StringIO()
    writer = csv.writer(sheet, lineterminator="\n")
    writer.writerow(head)
    writer.writerows([x if isinstance(x, str) else repr(float(x)) for x in row] for row in rows)
    return write_atomically(with_suffix(path, ".csv"), sheet.getvalue().encode())
