"""Self-stable ranges of several bicycles as bars over the speed."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from mbsd3d.base.style import dress, house, theme

from .critical import Range

ROOM = 1.25  # of the speed axis, over the largest finite end
ROOM_OF_LABEL = 0.09  # of the axis, that a figure takes


def plot_ranges(rows: Sequence[tuple[str, Sequence[Range]]], title: str, *, dark: bool = False) -> Any:
    """Figure with one bar per range; ranges that nothing ends fade out at the edge.

    Parameters
    ----------
    rows : sequence of (str, sequence of Range)
        Name and self-stable ranges, from the top.
    title : str
    dark : bool
        On dark paper.

    Returns
    -------
    matplotlib.figure.Figure
    """
    from matplotlib.figure import Figure

    look = theme(dark)
    ends = [v for _, found in rows for part in found for v in part if np.isfinite(v)]
    top = ROOM * max(ends, default=8.0)
    with house(look):
        figure = Figure(figsize=(8.0, 1.0 + 0.3 * len(rows)), layout="constrained")
        axes = figure.subplots()
        dress(axes, look)
        axes.grid(False, axis="y")
        for k, (_, found) in enumerate(rows):
            for part in found:
                draw_bar(axes, k, part, top, look)
            if not found:
                axes.text(0.01 * top, k, "at no speed", va="center", fontsize=8.5, color=look.muted)
        axes.set_yticks(range(len(rows)), [name for name, _ in rows], fontsize=9)
        axes.set_ylim(len(rows) - 0.4, -0.6)
        axes.set_xlim(0.0, top)
        axes.tick_params(axis="y", length=0)
        axes.set_xlabel("speed [m/s]")
        axes.set_title(title, loc="left")
    return figure


def draw_bar(axes: Any, k: int, part: Range, top: float, look: Any) -> None:
    """A range in row k, its ends in figures beside it; both on the right where there is no room on the left."""
    high, gap = min(part.high, top), 0.008 * top
    width = max(high - part.low, 0.004 * top)  # a bar that is too narrow to be seen gets a stroke
    axes.barh(k, width, left=part.low, height=0.62, color=look.lines[0], linewidth=0.0)
    style = {"va": "center", "fontsize": 8.5}
    low, end = f"{part.low:.3f}", f"{part.high:.3f}" if np.isfinite(part.high) else "no end"
    room, inside = part.low > ROOM_OF_LABEL * top, not np.isfinite(part.high)
    if inside:
        axes.text(top - gap, k, end if room else f"{low} ... {end}", ha="right", color="#ffffff", **style)
    else:
        axes.text(high + gap, k, end if room else f"{low} ... {end}", ha="left", color=look.ink, **style)
    if room:
        axes.text(part.low - gap, k, low, ha="right", color=look.ink, **style)
