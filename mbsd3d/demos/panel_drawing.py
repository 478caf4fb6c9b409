"""Common style of the demos' figures."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import NullFormatter
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import ArrayLike

from ..base.figure import Figure
from ..base.style import COLOURS, LIGHT, figure_style, style_axes
from ..base.wording import relative

GLOBE_VIEW = (25.0, 55.0)  # [deg] elevation and azimuth from which a sphere is seen


def new_figure(title: str, panels: Sequence[str], widths: Sequence[float] | None = None) -> tuple[Figure, list[Axes]]:
    """Return a figure with titled panels side by side, of relative widths; one whose title starts with "3d:" is in
    space.
    """
    count = len(panels)
    with figure_style():
        figure = Figure(figsize=(4.6 * count + 0.4, 4.4), layout="constrained")
        figure.set_layout_engine("constrained", w_pad=0.1, h_pad=0.08, wspace=0.03)
        grid = figure.add_gridspec(1, count, width_ratios=widths or [1.0] * count)
        axes = []
        for k, text in enumerate(panels):
            in_space = text.startswith("3d:")
            axes.append(figure.add_subplot(grid[0, k], projection="3d" if in_space else None))
            axes[-1].set_title(text.removeprefix("3d:").strip(), fontsize=10.5)
            (dress_space if in_space else style_axes)(axes[-1])
        if title:
            figure.suptitle(title, fontsize=13, fontweight="bold")
    return figure, axes


def dress_space(axes: Axes3D) -> None:
    """Set the colours of axes in space."""
    axes.tick_params(colors=LIGHT.ink)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.label.set_color(LIGHT.ink)
        axis.line.set_color(LIGHT.ink)


def theory_dots(axes: Axes, x: ArrayLike, y: ArrayLike, label: str | None = "theory", **options: Any) -> None:
    """Draw theory as open circles, so that the computed line stays visible through them."""
    style: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 5.5, "markerfacecolor": LIGHT.paper}
    axes.plot(x, y, **{**style, "markeredgecolor": LIGHT.ink, "markeredgewidth": 1.0, "label": label, **options})


def legend_below(axes: Axes, columns: int) -> None:
    """Draw the legend under the panel, never on the data."""
    axes.legend(
        ncols=columns, labelcolor=LIGHT.ink, loc="upper center", bbox_to_anchor=(0.5, -0.15), frameon=False, fontsize=9
    )


def sphere_net() -> list[np.ndarray]:
    """Return parallels and meridians of the unit sphere, (points, 3) each."""
    turn, lines = np.linspace(0, 2 * np.pi, 73), []
    for z in np.sin(np.radians([-60, -30, 0, 30, 60])):
        radius = np.sqrt(1 - z * z)
        lines.append(np.stack([radius * np.cos(turn), radius * np.sin(turn), 0 * turn + z], axis=1))
    rise = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 73)
    for phi in np.arange(0, 2 * np.pi, np.pi / 6):
        lines.append(np.stack([np.cos(rise) * np.cos(phi), np.cos(rise) * np.sin(phi), np.sin(rise)], axis=1))
    return lines


def space(axes: Axes3D, labels: Sequence[str], box: Sequence[float] = (1, 1, 1)) -> None:
    """Set few ticks and labels with units for a panel in space."""
    axes.set_box_aspect(box, zoom=1.15)
    for axis, label in zip((axes.xaxis, axes.yaxis, axes.zaxis), labels, strict=True):
        axis.set_ticks([-1, 1])
        axis.set_label_text(label)
        axis.labelpad = -4
        axis.pane.set_visible(False)
    axes.grid(False)


def seen_side(axes: Axes3D, path: ArrayLike) -> np.ndarray:
    """Return a path (n, 3) on the unit sphere with the far side left out."""
    up, turn = np.radians(axes.elev), np.radians(axes.azim)
    view = np.array([np.cos(up) * np.cos(turn), np.cos(up) * np.sin(turn), np.sin(up)])  # towards the eye
    return np.where((np.asarray(path) @ view > -1e-9)[:, None], path, np.nan)


def rim() -> np.ndarray:
    """Return the outline of the unit sphere as seen in panels in space, shape (73, 3)."""
    up, around, turn = *np.radians(GLOBE_VIEW), np.linspace(0, 2 * np.pi, 73)
    side, top = (
        (-np.sin(around), np.cos(around), 0.0),
        (-np.sin(up) * np.cos(around), -np.sin(up) * np.sin(around), np.cos(up)),
    )
    return np.outer(np.cos(turn), side) + np.outer(np.sin(turn), top)


def every(count: int, wanted: int) -> np.ndarray:
    """Return about ``wanted`` evenly spaced sample numbers out of ``count``."""
    return np.unique(np.linspace(0, count - 1, min(count, wanted)).round().astype(int))


def spectrum_bars(
    axes: Axes, orders: Sequence[int] | np.ndarray, groups: Sequence[tuple[str, ArrayLike]], theory: ArrayLike
) -> None:
    """Draw amplitudes per harmonic as bars on a logarithmic axis, with theory on the bars of the first group."""
    width = 0.85 / max(len(groups), 2)
    place = np.arange(len(orders))
    for k, (label, values) in enumerate(groups):
        shift = (k - 0.5 * (len(groups) - 1)) * width
        bars = axes.bar(place + shift, values, width=0.92 * width, color=COLOURS[k], label=label)
        numbers, size = [f"{value:#.3g}" for value in np.ravel(values)], 6 if len(groups) > 1 else 8
        axes.bar_label(bars, numbers, padding=6, fontsize=size, color=LIGHT.ink)
        if k == 0:
            theory_dots(axes, place + shift, theory, label="theory", zorder=5)
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_xticks(place, [f"{order}x" for order in orders])


def plain_decades(axes: Axes) -> None:
    """Set plain text like 10⁻² on a logarithmic axis, whole decades only: mathematics takes long to typeset."""
    axes.yaxis.set_major_formatter(lambda x, _: relative(x))
    axes.yaxis.set_minor_formatter(NullFormatter())
