"""Shared output of the studies: modes as CSV files, work with a progress bar, figures in the common style."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from mbsd3d.extend import Progress, Theme, new_figure, style_axes, write_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

T = TypeVar("T")


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
