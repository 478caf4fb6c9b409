"""Convergence of engines to the motion of mbsd3d as a figure."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from mbsd3d.extend import GRID_WIDTH_POINTS, LINE_WIDTH_POINTS, Figure, Theme, figure_style, relative, style_axes, theme

Curves = Sequence[tuple[str, Sequence[float], Sequence[float]]]
"""Quantity, steps and differences of each."""
FIGURE_QUANTITIES = ("position", "rotation", "velocity", "energy", "reaction force")
"""Quantities that are drawn: the others follow from them."""


def convergence_figure(engines: Sequence[tuple[str, float | None, Curves]], dark: bool = False) -> Figure:
    """Plot the difference from the motion of mbsd3d over the step, one panel per (name, order, curves), and the slope
    of that order.
    """
    look = theme(dark)
    with figure_style(look):
        figure = Figure(figsize=(7.5, 3.6), layout="constrained", facecolor=look.paper)
        panels = figure.subplots(1, max(len(engines), 1), squeeze=False, sharey=True)[0]
        for axes, engine in zip(panels, engines, strict=False):
            draw(axes, *engine, look)
        panels[0].set_ylabel("difference from mbsd3d, relative [-]")
        if not engines:
            panels[0].set_title("no engine ran")
            style_axes(panels[0], look)
    return figure


def draw(axes: Axes, name: str, order: float | None, curves: Curves, look: Theme) -> None:
    """Draw the curves of an engine."""
    style_axes(axes, look)
    shown = [curve for curve in curves if curve[0] in FIGURE_QUANTITIES]
    for i, (quantity, steps, differences) in enumerate(shown):
        kept = [(h, e) for h, e in zip(steps, differences, strict=True) if e > 0.0]
        if kept:
            axes.loglog(*zip(*kept, strict=True), "o-", color=look.colour(i), linewidth=LINE_WIDTH_POINTS, markersize=4,
                        label=quantity)  # fmt: skip
    if shown and order:
        _, steps, _ = shown[0]
        first = max(differences[0] for *_, differences in shown)
        least = min((e for *_, differences in shown for e in differences if e > 0.0), default=0.0)
        slope = [(h, 2.0 * first * (h / steps[0]) ** order) for h in steps]
        slope = slope[:2] + [(h, e) for h, e in slope[2:] if e >= 0.1 * least]  # below, all is rounding
        axes.loglog(
            *zip(*slope, strict=True), "--", color=look.muted, linewidth=2 * GRID_WIDTH_POINTS, label=f"order {order:g}"
        )
    for axis in (axes.xaxis, axes.yaxis):  # mathtext is off in this style: names may have dollars in them
        axis.set_major_locator(LogLocator(numticks=6))
        axis.set_major_formatter(FuncFormatter(lambda value, _: relative(value)))
        axis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("step [s]")
    axes.set_title(name)
    axes.legend(fontsize=8, frameon=False, labelcolor=look.ink)
