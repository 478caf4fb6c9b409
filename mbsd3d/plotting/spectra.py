"""Figures of spectra, densities and waterfalls."""

from typing import TYPE_CHECKING

import numpy as np

from ..base.errors import InputError
from ..base.style import Theme, label_decades, new_figure, style_axes
from ..base.wording import with_superscripts
from ..results.spectrum import Density, Spectrum, Waterfall

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STEMS_MAX = 150  # [bins] up to which a spectrum is drawn by stems
SHOWN_RATIO_MIN = 1e-3  # [1] of the largest amplitude: 60 dB; smaller ones are not shown
DENSITY_RATIO_MIN = 1e-10  # [1] of the largest density: 100 dB; rounding lies below
SPACE_RATIO = 1.1  # [1] of the last bin that is shown: where the axis ends
GRID_COUNT = 800  # [1] frequencies of the map of a waterfall
MEAN_BINS = 2  # [bins] that the window makes of the mean
MARKED_ORDERS_MAX = 6  # [1] orders of a waterfall that are named
MARKED_RATIO_MIN = 0.02  # [1] of the largest amplitude of an order that is named
NEIGHBOUR_ORDERS = 0.5  # [1] around an order that is named: its flanks are not
STEM_SHIFT = 0.12  # [1] of a bin between the stems of components


def plot_spectrum(spectrum: Spectrum, *, dark: bool = False) -> "Figure":
    """Draw peak amplitudes over frequency or orders up to the last that counts, a colour per component."""
    size = np.abs(spectrum.amplitudes).reshape(spectrum.orders.size, -1)
    last = np.flatnonzero(size.max(axis=1) >= SHOWN_RATIO_MIN * size.max())[-1]
    shown = slice(max(int(SPACE_RATIO * last), 2) + 1)
    orders, size = spectrum.orders[shown], size[shown]
    over_time = np.allclose(spectrum.frequency, 2.0 * np.pi * spectrum.orders, rtol=1e-12)
    with new_figure(7.5, 4.0, dark) as (figure, look):
        axes, bin_width = figure.subplots(), orders[1] - orders[0]
        for k, (name, column) in enumerate(zip(components(spectrum, size), size.T, strict=True)):
            if orders.size > STEMS_MAX:
                axes.plot(orders, column, color=look.colour(k), label=name)
                continue
            at = orders + STEM_SHIFT * bin_width * (k - 0.5 * (size.shape[1] - 1))
            axes.vlines(at, 0.0, column, color=look.colour(k), linewidth=2.0, label=name)
        axes.set_ylim(0.0, 1.05 * size.max() or 1.0)
        axes.set_xlabel("frequency [Hz]" if over_time else "order")
        labelled(axes, look, f"amplitude of {spectrum.name}" if spectrum.name else "amplitude", spectrum.unit)
    return figure


def plot_density(density: Density, *, dark: bool = False) -> "Figure":
    """Draw a density over frequency on a logarithmic axis, a colour per component."""
    values = density.density.reshape(density.hertz.size, -1)
    with new_figure(7.5, 4.0, dark) as (figure, look):
        axes = figure.subplots()
        for k, (name, column) in enumerate(zip(components(density, values), values.T, strict=True)):
            axes.plot(density.hertz, np.where(column > 0.0, column, np.nan), color=look.colour(k), label=name)
        if values.max() > 0.0:
            axes.set_yscale("log")
            axes.set_ylim(bottom=max(values.max() * DENSITY_RATIO_MIN, axes.get_ylim()[0]))
            label_decades(axes.yaxis)
        else:
            axes.set_ylim(0.0, 1.0)
        axes.set_xlim(density.hertz[0], density.hertz[-1])
        axes.set_xlabel("frequency [Hz]")
        labelled(axes, look, f"density of {density.name}", density.unit)
    return figure


def components(seen: Spectrum | Density, columns: np.ndarray) -> list[str]:
    """Return the labels of the components, "_" (none) of a single one."""
    count = columns.shape[1]
    return ["_"] if count == 1 else [*seen.names] or [str(k + 1) for k in range(count)]


def labelled(axes: "Axes", look: Theme, what: str, unit: str) -> None:
    """Style axes and name what is drawn upwards; a legend where there are components."""
    style_axes(axes, look)
    axes.set_ylabel(with_superscripts(f"{what} [{unit}]" if unit else what))
    if axes.get_legend_handles_labels()[1]:
        axes.legend(frameon=False, labelcolor=look.ink)


def plot_waterfall(waterfall: Waterfall, *, dark: bool = False) -> "Figure":
    """Draw amplitudes over frequency and speed as colours, of several components their root sum of squares."""
    order = np.argsort(waterfall.speeds)
    speeds = waterfall.speeds[order]
    if not speeds[-1] - speeds[0] > 1e-6 * speeds[-1]:
        raise InputError(
            f"waterfall: the speed is {speeds[0]:g} rad/s all the time, so there is nothing over it; plot orders"
        )
    size = np.abs(waterfall.amplitudes).reshape(*waterfall.amplitudes.shape[:2], -1)
    size, orders = np.sqrt((size**2).sum(axis=2))[order, MEAN_BINS:], waterfall.orders[MEAN_BINS:]
    top = size.max(initial=0.0) or 1.0
    seen = np.multiply.outer(speeds, orders)[size > SHOWN_RATIO_MIN * top] / (2.0 * np.pi)
    hertz = np.linspace(0.0, float(seen.max(initial=speeds[-1] / (2.0 * np.pi))), GRID_COUNT)
    turns, rpm = speeds / (2.0 * np.pi), speeds * 30.0 / np.pi
    decades = np.log(np.maximum(size, SHOWN_RATIO_MIN * top))
    shown = [
        np.exp(np.interp(hertz / rate, orders, row, left=decades.min()))
        for rate, row in zip(turns, decades, strict=True)
    ]
    with new_figure(8.0, 5.5, dark) as (figure, look):
        from matplotlib.colors import LogNorm  # only who draws waits for it

        axes = figure.subplots()
        style_axes(axes, look)
        axes.grid(False)
        norm = LogNorm(SHOWN_RATIO_MIN * top, top)
        mesh = axes.pcolormesh(hertz, rpm, shown, cmap="viridis", norm=norm, shading="gouraud", rasterized=True)
        mark_orders(axes, look, orders, size.max(axis=0), turns[-1], rpm[-1])
        axes.set_xlabel("frequency [Hz]")
        axes.set_ylabel("speed [rev/min]")
        bar = figure.colorbar(mesh, ax=axes)
        bar.ax.tick_params(which="both", colors=look.ink)
        label_decades(bar.ax.yaxis)
        bar.set_label(with_superscripts(f"amplitude of {waterfall.name} [{waterfall.unit}]"), color=look.ink)
    return figure


def mark_orders(axes: "Axes", look: Theme, orders: np.ndarray, largest: np.ndarray, turns: float, rpm: float) -> None:
    """Write the largest orders (bins,) where they leave the map at the highest speed [1/s, rev/min]: above or right."""
    marked: list[float] = []
    right = axes.get_xlim()[1]
    for k in np.argsort(-largest).tolist():
        if len(marked) == MARKED_ORDERS_MAX or largest[k] < MARKED_RATIO_MIN * largest.max():
            break
        if any(abs(orders[k] - other) <= NEIGHBOUR_ORDERS for other in marked):
            continue
        marked.append(orders[k])
        above = orders[k] * turns <= right
        at = (orders[k] * turns, rpm) if above else (right, rpm * right / (orders[k] * turns))
        axes.annotate(f"{orders[k]:g}×", at, xytext=(0, 3) if above else (3, 0), textcoords="offset points",
                      ha="center" if above else "left", va="bottom" if above else "center", fontsize=9,
                      color=look.ink)  # fmt: skip
