"""Figures of a solution over time. Nothing is shown automatically: every function returns a Figure.

Lines differ in colour, and in their dashes too once the colours are used up; see `mbsd3d.base.style`.
"""

import io
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib.figure
import numpy as np
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter

from ..base.checks import check_choice, short_repr
from ..base.errors import InputError, checks_arguments
from ..base.figure import Figure
from ..base.paths import as_path, write_atomically
from ..base.style import LINE_WIDTH_POINTS, Theme, figure_style, style_axes, theme
from ..results.result import RunResult
from .default_curves import default_curves, seen_panels
from .panels import Panel, Part, PlotQuantity, Wanted, panels_of

LINE_STYLES = ("-", "--", ":", "-.")
MARKED_SAMPLES_MAX = 40  # [1] samples that are marked one by one: straight lines between few of them could mislead
LEGEND_LINES_MAX = 14  # [1] lines up to which all are named
NAMED_LINES_COUNT = 10  # [1] of more lines, the strongest, which keep their colours; the others are thin and grey
OTHER_WIDTH_RATIO, OTHER_ORDER = 0.4, 1.5  # [1] of their width; place among what is drawn: behind lines, which have 2
RESIDUAL_FLOOR_EXPONENT = -18  # [1] exponent of the smallest residual shown; smaller ones are rounding


def plot_quantity(
    solution: RunResult,
    quantity: str | Wanted | None = None,
    *parts: Part,
    against: PlotQuantity | None = None,
    degrees: bool = False,
    dark: bool = False,
    axes: Axes | Sequence[Axes] | None = None,
) -> Figure:
    """Plot a quantity over time or another quantity; arguments as in `Solution.plot`."""
    check_choice(degrees, (True, False), "plot: degrees")
    if quantity is None and parts:
        raise InputError("plot: parts without a quantity; give one, e.g. plot('reaction', hinge)")
    panels = (
        seen_panels(solution, default_curves(solution)) if quantity is None else panels_of(solution, quantity, parts)
    )
    if degrees:
        panels = [panel.in_degrees() for panel in panels]
    across = None if against is None else panel_across(solution, against, quantity, parts, degrees)
    look = theme(dark)
    with figure_style(look):
        targets = new_axes(len(panels)) if axes is None else np.ravel(np.asarray(axes, dtype=object))
        if len(targets) != len(panels):
            raise InputError(
                f"plot: {quantity} of these parts needs {len(panels)} axes, not {len(targets)}; give as many"
            )
        if not all(isinstance(target, Axes) for target in targets):
            raise InputError(f"plot: axes = {short_repr(axes)}; give matplotlib axes, one per panel, or None")
        before: tuple[list[str], str] | None = None
        for target, panel in zip(targets, panels, strict=True):
            legend = ([name for name, _ in panel.lines], panel.note)
            draw_panel(target, solution.t, panel, across, look, legend=legend != before)
            size = max(largest(panels, panel.unit), panel.size)
            if panel.unit == "[N m]":  # a moment is rounding beside what the forces make on the model's length
                size = max(size, largest(panels, "[N]") * float(solution.compiled.model.length))
            set_range(target, panel, size)
            before = legend
        for target in targets[-1:] if axes is None else targets:  # in a figure of its own the lowest axes are enough
            target.set_xlabel("time [s]" if across is None else f"{across.label} {across.unit}", parse_math=False)
        if axes is None:
            targets[0].figure.align_ylabels()
    return targets[0].figure


def new_axes(count: int) -> np.ndarray:
    """Return axes one below the other in a new figure."""
    figure = Figure(figsize=(7.5, 1.0 + 2.3 * count), layout="constrained")
    engine: Any = figure.get_layout_engine()
    engine.set(w_pad=0.1, h_pad=0.06)
    return figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]


def panel_across(
    solution: RunResult, against: PlotQuantity, quantity: str | Wanted | None, parts: tuple[Part, ...], degrees: bool
) -> Panel:
    """Return the panel of the horizontal axis."""
    if isinstance(against, str) and isinstance(quantity, str):
        found = panels_of(solution, against, parts)
    else:
        found = panels_of(solution, [against])
    if len(found) != 1:
        example = "against=('angle', 'hinge')"
        raise InputError(f"plot: against {short_repr(against)} is not a single axis; give a scalar, e.g. {example}")
    return found[0].in_degrees() if degrees else found[0]


def lines_across(panel: Panel, across: Panel) -> list[np.ndarray]:
    """Return the horizontal values of every line of a panel: one for all, or each its own."""
    if len(across.lines) == 1:
        return [across.lines[0][1]] * len(panel.lines)
    values = dict(across.lines)
    missing = [name for name, _ in panel.lines if name not in values]
    if missing:
        raise InputError(
            f"plot: against {across.label} has the lines {', '.join(values)}, none of '{missing[0]}'; "
            "give one scalar, e.g. against=('angle', 'hinge')"
        )
    return [values[name] for name, _ in panel.lines]


def draw_panel(axes: Axes, t: np.ndarray, panel: Panel, across: Panel | None, look: Theme, legend: bool) -> None:
    """Draw lines, grid, label and legend of a panel."""
    style_axes(axes, look)
    axes.set_prop_cycle(cycler(linestyle=LINE_STYLES) * cycler(color=look.lines))
    marks: dict[str, Any] = {"marker": "o", "markersize": 3} if t.size <= MARKED_SAMPLES_MAX else {}
    if across is not None and not marks:
        marks = {"marker": "o", "markersize": 5, "markevery": [0]}
    horizontal = [t] * len(panel.lines) if across is None else lines_across(panel, across)
    drawn, named = [], strongest(panel)
    for k, (x, (name, values)) in enumerate(zip(horizontal, panel.lines, strict=True)):
        shown = np.where(values > 0.0, values, np.nan) if panel.log else values
        pen: dict[str, Any] = {"linewidth": LINE_WIDTH_POINTS, **marks}
        if k not in named:
            pen = {"linewidth": OTHER_WIDTH_RATIO * LINE_WIDTH_POINTS, "zorder": OTHER_ORDER}
            pen |= {"color": look.muted, "linestyle": "-"}  # both, so that it takes none of the others' colours
        drawn += axes.plot(x, shown, label=name, **pen)
    if t.size > 1 and across is None:
        margin = 0.01 * (t[-1] - t[0])
        axes.set_xlim(t[0] - margin, t[-1] + margin)
    axes.set_ylabel("\n".join(textwrap.wrap(f"{panel.label} {panel.unit}", 30)), parse_math=False)
    if legend and (len(panel.lines) > 1 or panel.note):
        write_legend(axes, [drawn[k] for k in named], len(drawn) - len(named), panel.note, look)


def strongest(panel: Panel) -> list[int]:
    """Return the places of the lines to name: all, in their order, or of many those of largest size, largest first."""
    if len(panel.lines) <= LEGEND_LINES_MAX:
        return list(range(len(panel.lines)))
    sizes = [float(np.nanmax(np.abs(values), initial=0.0)) for _, values in panel.lines]
    return sorted(range(len(sizes)), key=lambda k: -sizes[k])[:NAMED_LINES_COUNT]


def write_legend(axes: Axes, named: list[Line2D], others: int, note: str, look: Theme) -> None:
    """Draw the legend beside the data, never on it; names are written as they are, whatever signs they hold."""
    shown, names = named, [str(line.get_label()) for line in named]
    if others:
        names.append(f"and {others} smaller ones")
        shown = [*shown, Line2D([], [], linewidth=OTHER_WIDTH_RATIO * LINE_WIDTH_POINTS, color=look.muted)]
    places = [str(k) for k in range(len(names))]  # matplotlib drops names that start with "_"
    beside: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0), "frameon": False}
    legend = axes.legend(shown, places, title=note or None, labelcolor=look.ink, **beside)
    legend.get_title().set_color(look.ink)
    for text, name in zip(legend.get_texts(), names, strict=True):
        text.set_parse_math(False)
        text.set_text(name)
    legend.get_title().set_parse_math(False)


def largest(panels: list[Panel], unit: str) -> float:
    """Return the largest value of a unit."""
    alike = [values for panel in panels if panel.unit == unit for _, values in panel.lines]
    return max((float(np.nanmax(np.abs(x), initial=0.0)) for x in alike), default=0.0)


def set_range(axes: Axes, panel: Panel, size: float) -> None:
    """Set whole decades on a logarithmic axis; rounding is not magnified: ``size`` is the largest value of this
    unit."""
    values = np.concatenate([np.array(panel.shows), *(values for _, values in panel.lines)])
    values = values[np.isfinite(values) & (values > 0.0 if panel.log else True)]
    if not values.size:
        return
    low, high = float(values.min()), float(values.max())
    if panel.log:
        last = np.ceil(np.log10(high))
        axes.set_yscale("log")
        axes.set_ylim(10.0 ** min(max(np.floor(np.log10(low)), RESIDUAL_FLOOR_EXPONENT), last - 1.0), 10.0**last)
        axes.yaxis.set_minor_formatter(NullFormatter())
    elif panel.shows:
        axes.set_ylim(low - 0.05 * (high - low), high + 0.05 * (high - low))
    elif high - low < 1e-9 * size:
        axes.set_ylim(low - 0.05 * size, high + 0.05 * size)


@checks_arguments
def save_figure(figure: matplotlib.figure.Figure, path: str | Path, *, pdf: bool = False) -> list[Path]:
    """Write a figure as PNG (150 dpi), SVG and, if ``pdf``, PDF; the same figure gives the same bytes.

    ``path`` is the name of all of them, without suffix or with one of theirs; ".pdf" asks for PDF too. Returns the
    files. ValueError if the folder cannot be written.
    """
    if not isinstance(figure, matplotlib.figure.Figure):
        raise InputError(
            f"save_figure: {short_repr(figure)} is not a figure; give one of matplotlib, e.g. of solution.plot()"
        )
    path, written = as_path(path, "figure"), []
    if (given := path.suffix.lower()) in (".png", ".svg", ".pdf"):
        path, pdf = path.with_suffix(""), pdf or given == ".pdf"
    options: dict[str, dict[str, Any]] = {
        ".png": {"dpi": 150, "metadata": {"Software": None}},
        ".svg": {"dpi": 300, "metadata": {"Date": None}},
    }
    if pdf:
        options[".pdf"] = {"dpi": 300, "metadata": {"CreationDate": None}}
    with figure_style():
        for suffix, settings in options.items():
            buffer = io.BytesIO()
            figure.savefig(buffer, format=suffix[1:], facecolor=figure.get_facecolor(), **settings)
            written.append(write_atomically(path.with_name(path.name + suffix), buffer.getvalue()))
    return written
