"""The figure of a demo from what it declares: computed lines, theory as dots, the ablation dashed."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..base.style import COLOURS
from .drawing import every, legend_below, new_figure, theory_dots

if TYPE_CHECKING:
    from .form import Curve

MOST = 3  # panels side by side
FAR = 6  # times the computed range, beyond which an ablation leaves the picture


class Panel(NamedTuple):
    """A curve, the same one under the ablation, and computed points where the curve is theory."""

    curve: "Curve"
    other: "Curve | None"
    label: str  # of the other curve
    computed: Sequence = ()


def figure_of(title: str, panels: Sequence[Panel]) -> Figure:
    """Panels side by side."""
    panels = panels[:MOST]
    figure, axes = new_figure(title, [panel.curve.title for panel in panels])
    for place, panel in zip(axes, panels, strict=True):
        draw(place, panel)
    return figure


def limit(axes: Axes, panel: Panel) -> None:
    """What is computed fills the axis: an ablation that leaves it far behind, or rounding, does not set its scale."""
    curve, other = panel.curve, panel.other
    y = np.asarray(curve.y, float)
    y = np.concatenate([y[np.isfinite(y)], [-curve.scale, curve.scale] if curve.scale else []])
    span = np.ptp(y)
    if curve.scale or (other is not None and np.ptp(np.asarray(other.y, float)) > FAR * span > 0.0):
        axes.set_ylim(y.min() - 0.3 * span, y.max() + 0.3 * span)


def draw(axes: Axes, panel: Panel) -> None:
    """One panel."""
    curve = panel.curve
    if panel.computed:
        axes.plot(curve.x, curve.y, color=COLOURS[0], label="theory")
        (some, values), (here, value) = panel.computed
        theory_dots(axes, some, values, label="computed")
        axes.plot(here, value, "o", color=COLOURS[1], label="computed here")
    else:
        axes.plot(curve.x, curve.y, color=COLOURS[0], label="computed")
        if panel.other is not None:
            axes.plot(panel.other.x, panel.other.y, "--", color=COLOURS[1], label=panel.label)
        if curve.theory is not None:
            x, y = (np.atleast_1d(np.asarray(values, float)) for values in curve.theory)
            dots = every(x.size, 25)
            theory_dots(axes, x[dots], y[dots])
        limit(axes, panel)
    axes.set(xlabel=curve.along, ylabel=curve.label)
    legend_below(axes, 3)
