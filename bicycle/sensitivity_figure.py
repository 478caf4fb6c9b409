"""Figures of the sensitivity study."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from mbsd3d.base.style import LINE, dress, house, theme

from .parameters import SYMBOL

SHOWN = 14  # parameters of a figure: those that matter most


def draw_derivatives(found: Any, dark: bool) -> Any:
    """Change of the critical speeds by one percent of each parameter, the largest on top.

    Parameters
    ----------
    found : bicycle.sensitivity.Derivatives
    dark : bool
        On dark paper.

    Returns
    -------
    matplotlib.figure.Figure
    """
    look, changes = theme(dark), {name: found.per_percent(name) for name in found.speeds}
    sizes = {key: max(abs(change[key]) for change in changes.values()) for key in next(iter(changes.values()))}
    keys = sorted(sizes, key=lambda key: -sizes[key])[:SHOWN]
    with house(look):
        figure = Figure(figsize=(9.0, 1.5 + 0.28 * len(keys)), layout="constrained")
        panels = figure.subplots(1, len(changes), sharey=True, sharex=True, squeeze=False)[0]
        for k, (axes, (name, change)) in enumerate(zip(panels, changes.items(), strict=True)):
            dress(axes, look)
            axes.barh(range(len(keys)), [change[key] for key in keys], height=0.65, color=look.colour(k))
            axes.axvline(0.0, color=look.ink, linewidth=0.8)
            axes.set_title(f"{name}, {found.speeds[name]:.4f} m/s", loc="left")
            axes.grid(False, axis="y")
            axes.set_xlabel("change by +1 % [m/s]")
            axes.tick_params(axis="y", length=0)
        title = f"{found.parameters.name}: what one percent of a parameter does to the critical speeds"
        figure.suptitle(title, x=0.01, ha="left", color=look.ink, fontsize=11)
        panels[0].set_yticks(range(len(keys)), [SYMBOL[key] for key in keys])
        panels[0].set_ylim(len(keys) - 0.4, -0.6)
    return figure


def draw_uncertainty(found: Any, indices: Any, dark: bool) -> Any:
    """Distribution of weave and capsize speed (left), and which parameters cause it (right).

    Parameters
    ----------
    found : bicycle.uncertainty.MonteCarlo
    indices : bicycle.uncertainty.Sobol
    dark : bool
        On dark paper.

    Returns
    -------
    matplotlib.figure.Figure
    """
    look, names = theme(dark), ("weave speed", "capsize speed")
    total = {name: np.nan_to_num(indices.total[name]) for name in names}
    order = np.argsort(-np.maximum(*total.values()))[:SHOWN]
    with house(look):
        figure = Figure(figsize=(9.0, max(3.4, 1.7 + 0.28 * len(order))), layout="constrained")
        left, right = figure.subplots(1, 2)
        for k, name in enumerate(names):
            draw_samples(left, found.outputs[name], name, look.colour(k))
            place = np.arange(order.size) + 0.36 * (k - 0.5)
            right.barh(place, total[name][order], height=0.34, color=look.colour(k), label=name)
            right.plot(indices.first[name][order], place, "|", color=look.ink, markersize=7)
        for axes in (left, right):
            dress(axes, look)
        left.set_xlabel("speed [m/s]")
        left.set_ylabel("probability density [s/m]")
        title = f"{found.parameters.name}: {len(found.inputs)} samples, and which parameters spread them"
        figure.suptitle(title, x=0.01, ha="left", color=look.ink, fontsize=11)
        handles, labels = right.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper right", frameon=False, labelcolor=look.ink, ncols=2)
        right.grid(False, axis="y")
        right.set_yticks(range(order.size), [SYMBOL[indices.names[k]] for k in order])
        right.set_ylim(order.size - 0.4, -0.6)
        right.set_xlabel("share of the variance [1]: total index; stroke: first order")
    return figure


def draw_samples(axes: Any, values: np.ndarray, name: str, colour: str) -> None:
    """Outline of a histogram; nothing where no sample has this speed."""
    values = values[np.isfinite(values)]
    if values.size and np.ptp(values) > 0.0:
        axes.hist(values, bins=60, density=True, histtype="step", linewidth=LINE, color=colour, label=name)
