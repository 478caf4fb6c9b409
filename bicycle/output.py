"""Shared output of the studies: results as text, tables as CSV files, work with a progress bar, figures in the common
style.
"""

import csv
import html
import io
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from mbsd3d.extend import Progress, Theme, new_figure, style_axes, with_suffix, write_atomically

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

T = TypeVar("T")
REPR_LINES_MAX = 12  # [1] lines of a result in a console
BOX_HEIGHT = "24em"  # of a result in a notebook: half a screen, the rest is scrolled


class Result(ABC):
    """Base of results: `str` says what was found, a console shows its first lines, a notebook a box to scroll."""

    @abstractmethod
    def __str__(self) -> str:
        """Return what was found, line by line."""

    def __repr__(self) -> str:
        lines = str(self).splitlines()
        if len(lines) > REPR_LINES_MAX:
            kept = REPR_LINES_MAX - 1
            lines[kept:] = [f"  ... {len(lines) - kept} more lines: print() shows all"]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        """Return the text for a notebook."""
        return f'<pre style="max-height:{BOX_HEIGHT};overflow:auto">{html.escape(str(self))}</pre>'


def write_table(path: str | Path, head: Sequence[str], rows: Iterable[Sequence[Any]]) -> Path:
    """Write names with units, then rows of texts and numbers with all their digits; ".csv" is appended if missing."""
    sheet = io.StringIO()
    writer = csv.writer(sheet, lineterminator="\n")
    writer.writerow(head)
    writer.writerows([x if isinstance(x, str) else repr(float(x)) for x in row] for row in rows)
    return write_atomically(with_suffix(path, ".csv"), sheet.getvalue().encode())


def write_modes(path: str | Path, names: Sequence[str], speeds: np.ndarray, values: np.ndarray) -> Path:
    """Write eigenvalues (n, k) by the names of their modes [1/s] over the speed [m/s], as `write_table` does."""
    head = ["speed [m/s]"] + [f"{part} {name} [1/s]" for name in names for part in ("Re", "Im")]
    return write_table(path, head, np.column_stack([speeds, values.view(float)]))


def collected(title: str, results: Iterable[T], count: int, progress: bool | None = None) -> list[T]:
    """Return the ``count`` results of an iterator with a progress bar; after Ctrl-C those that were finished."""
    found: list[T] = []
    with Progress(title, 0, count, progress) as bar:
        try:
            for result in results:
                found.append(result)
                bar.update(len(found))
        except KeyboardInterrupt:
            pass
    return found


@contextmanager
def modes_figure(title: str, dark: bool = False) -> Iterator[tuple["Figure", "Axes", "Axes", Theme]]:
    """Yield (figure, growth, frequency, colours): modes over the speed, to be drawn within the block."""
    with new_figure(9.2, 6.2, dark) as (sheet, look):
        growth, frequency = sheet.subplots(2, 1, sharex=True, height_ratios=(1.7, 1.0))
        for axes in (growth, frequency):
            style_axes(axes, look)
            axes.margins(x=0.0)
        yield sheet, growth, frequency, look
        growth.set_ylabel("growth, Re(s) [1/s]")
        frequency.set_ylabel("frequency, |Im(s)| [rad/s]")
        frequency.set_xlabel("speed [m/s]")
        growth.set_title(title)
        growth.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize=9, labelcolor=look.ink)
