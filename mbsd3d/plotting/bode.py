"""Bode plots of frequency responses."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import LogLocator

from ..base.errors import InputError
from ..base.style import RAISED, dress, new_figure
from ..linear.state_space import FrequencyResponse

if TYPE_CHECKING:
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

DECADES_MAX = 20  # [1] that are labelled each


def plot_bode(response: FrequencyResponse, *, dark: bool = False) -> "Figure":
    """Draw magnitude and phase over the frequency: a column per input, a line per output."""
    if not response.w.min() > 0.0:
        raise InputError(
            f"bode: frequency {response.w.min():g} rad/s has no place on a logarithmic axis; give w above 0"
        )
    inputs = len(response.inputs)
    with new_figure(max(6.5, 4.0 * inputs), 6.0, dark) as (figure, look):
        panels = figure.subplots(2, inputs, sharex=True, squeeze=False, height_ratios=(1.5, 1.0))
        for column, (size, phase) in enumerate(panels.T):
            for row, (name, unit) in enumerate(zip(response.outputs, response.output_units, strict=True)):
                H, style = response.H[:, row, column], {"color": look.colour(row)}
                H = np.where(np.isfinite(H) & (H != 0.0), H, np.nan)
                size.semilogx(response.w, np.abs(H), label=f"{name} [{unit}]", **style)
                phase.semilogx(response.w, unwrapped_degrees(H), **style)
            for axes in (size, phase):
                dress(axes, look)
            if response.H[:, :, column].any():
                size.set_yscale("log")
                decades(size.yaxis)
            decades(phase.xaxis)
            low, high = np.array(phase.get_ylim()) / 90.0
            phase.set_yticks(90.0 * np.arange(np.ceil(low), np.floor(high) + 1.0))
            size.set_title(f"to {response.inputs[column]} [{response.input_units[column]}]")
            phase.set_xlabel("frequency ω [rad/s]")
        panels[0, 0].set_ylabel("magnitude")
        panels[1, 0].set_ylabel("phase [°]")
        handles, names = panels[0, 0].get_legend_handles_labels()
        figure.legend(handles, names, loc="outside lower center", ncols=min(len(names), 3), frameon=False,
                      labelcolor=look.ink)  # fmt: skip
        figure.align_ylabels(panels[:, 0])
    return figure


def unwrapped_degrees(H: np.ndarray) -> np.ndarray:
    """Return the phase (n,) [degrees] without jumps, beginning within -190 ... 170; NaN where H is."""
    found = np.full(H.size, np.nan)
    there = np.isfinite(H)
    if there.any():
        degrees = np.degrees(np.unwrap(np.angle(H[there])))
        found[there] = degrees - 360.0 * np.round((degrees[0] + 10.0) / 360.0)
    return found


def decades(axis: "Axis") -> None:
    """Label decades like 10⁻²: the figure style writes texts as they are, without mathematics."""
    axis.set_major_locator(LogLocator(numticks=DECADES_MAX))
    axis.set_major_formatter(lambda x, _: f"10{str(round(np.log10(x))).translate(RAISED)}")
    axis.set_minor_formatter("")
