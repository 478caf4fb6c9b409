"""Error against wall time, a panel per problem, in the house style."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from mbsd3d.extend import LINE, THIN, dress, house, theme

from .candidates import PEERS
from .goals import MIDDLE
from .ladders import Point
from .precision import Row

SHOWN = (
    "free body", "top fast", "bicycle M1", "Bricard", "Andrews", "four-bar 2", "four-bar 40", "Stewart platform",
    "arm 6R", "chain 10", "chain 100", "chain 300",
)  # fmt: skip
COLUMNS = 4
ERRORS = (1e-10, 1e-1)  # of the axes
MARKS = {"mbsd3d": "o", "MuJoCo": "s", "Exudyn": "^"}


def front(row: Row, engine: str) -> list[Point]:
    """Points of all candidates of an engine that no other one of it beats in both time and error."""
    points = sorted((p for climbed in row.of(engine) for p in climbed.points), key=lambda p: (p.seconds, p.error))
    found: list[Point] = []
    for point in points:
        if not found or point.error < found[-1].error:
            found.append(point)
    return found


def work_precision(rows: Sequence[Row], dark: bool = False) -> Any:
    """A matplotlib figure: the best of each engine, down and left is better.

    Raises
    ------
    ValueError
        If none of the problems it shows was measured.
    """
    from matplotlib.figure import Figure

    shown = sorted((row for row in rows if row.name in SHOWN), key=lambda row: SHOWN.index(row.name))
    if not shown:
        raise ValueError(f"none of {', '.join(SHOWN)} was measured; measure one with --mechanism")
    look = theme(dark)
    count = -(-len(shown) // COLUMNS)
    columns = min(COLUMNS, len(shown))
    with house(look):
        figure = Figure(figsize=(2.9 * columns + 0.4, 2.6 * count + 0.5), layout="constrained", facecolor=look.paper)
        grid = np.atleast_1d(figure.subplots(count, columns, sharey=True, squeeze=False)).ravel()
        for axes, row in zip(grid, shown, strict=False):
            panel(axes, row, look)
        for axes in grid[len(shown) :]:
            axes.set_visible(False)
        for k, axes in enumerate(grid[: len(shown)]):
            if k % columns == 0:
                axes.set_ylabel("error at the end [-]")
            if k + columns >= len(shown):
                axes.set_xlabel("wall time")
        handles, names = grid[0].get_legend_handles_labels()
        for axes in grid[1 : len(shown)]:
            more = zip(*axes.get_legend_handles_labels(), strict=True)
            new = [(handle, name) for handle, name in more if name not in names]
            handles, names = handles + [h for h, _ in new], names + [n for _, n in new]
        legend = figure.legend(handles, names, loc="outside upper center", ncols=len(names), frameon=False)
        for text in legend.get_texts():
            text.set_color(look.ink)
    return figure


def seconds_text(x: float, place: Any = None) -> str:
    """ "10 ms"."""
    return f"{1e3 * x:g} ms" if x < 1.0 else f"{x:g} s"


def panel(axes: Any, row: Row, look: Any) -> None:
    """One problem."""
    for k, engine in enumerate(("mbsd3d", *PEERS)):
        points = [point for point in front(row, engine) if point.error <= ERRORS[1]]
        if points:
            seconds, errors = [p.seconds for p in points], [max(p.error, ERRORS[0]) for p in points]
            axes.plot(
                seconds, errors, color=look.colour(k), linewidth=LINE, marker=MARKS[engine], markersize=3.5,
                label=engine,
            )  # fmt: skip
    axes.axhline(MIDDLE, color=look.muted, linewidth=THIN, linestyle="--")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylim(*ERRORS)
    low, high = axes.get_xlim()
    axes.set_xlim(10 ** np.floor(np.log10(low)), 10 ** np.ceil(np.log10(high)))  # whole decades, each labelled
    axes.xaxis.set_major_formatter(seconds_text)
    axes.yaxis.set_major_formatter("{x:.0e}")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_formatter("")
    axes.tick_params(labelsize="small")
    axes.set_title(row.name)
    dress(axes, look)
