"""Bode plots of frequency responses, and Campbell diagrams of whirl frequencies over the speed."""

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.errors import InputError
from ..base.style import label_decades, label_quarter_turns, new_figure, style_axes
from ..linear.campbell import Campbell
from ..linear.state_space import FrequencyResponse

if TYPE_CHECKING:
    from matplotlib.figure import Figure

OUTPUT_STYLES = ("-", "--", ":", "-.")  # of outputs, one after the other as the colours begin anew
BODE_RATIO_MIN = 1e-16  # [1] of the largest magnitude: rounding lies below
LINE_STYLES = {"forward": "-", "backward": "--", "planar": "-.", "mixed": ":"}  # by the sense of the whirl


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
                H, rounds = response.H[:, row, column], row // len(look.lines)
                style: dict[str, Any] = {
                    "color": look.colour(row), "linestyle": OUTPUT_STYLES[rounds % len(OUTPUT_STYLES)],
                }  # fmt: skip
                H = np.where(np.isfinite(H) & (H != 0.0), H, np.nan)
                size.semilogx(response.w, np.abs(H), label=f"{name} [{unit}]", **style)
                phase.semilogx(response.w, unwrapped_degrees(H), **style)
            for axes in (size, phase):
                style_axes(axes, look)
            if response.H[:, :, column].any():
                size.set_yscale("log")
                sizes = np.abs(response.H[:, :, column])
                sizes = sizes[np.isfinite(sizes)]
                seen = sizes[sizes > BODE_RATIO_MIN * sizes.max(initial=0.0)]
                if seen.size:
                    size.set_ylim(bottom=0.5 * seen.min())
                label_decades(size.yaxis)
            label_decades(phase.xaxis)
            label_quarter_turns(phase)
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


def plot_campbell(diagram: Campbell, *, dark: bool = False) -> "Figure":
    """Draw whirl frequencies, the line of excitation by the speed, and the critical speeds."""
    with new_figure(7.5, 5.0, dark) as (figure, look):
        axes, speeds = figure.subplots(), diagram.speeds
        for k, (label, whirl) in enumerate(zip(diagram.labels, diagram.whirl, strict=True)):
            style: dict[str, Any] = {"color": look.colour(k), "linestyle": LINE_STYLES[whirl]}
            axes.plot(speeds, diagram.frequencies[:, k], label=f"{whirl}: {label}", **style)
        top = float(np.nanmax(diagram.frequencies))
        axes.plot(speeds, np.abs(speeds), color=look.muted, linewidth=1.0, label="speed")
        critical = diagram.critical_speeds()
        axes.plot([x.speed for x in critical], [x.frequency for x in critical], color=look.ink, marker="o",
                  markerfacecolor="none", linestyle="none", label="critical" if critical else "_")  # fmt: skip
        style_axes(axes, look)
        axes.set_ylim(0.0, 1.05 * top)
        axes.set_xlim(speeds[0], speeds[-1])
        axes.set_xlabel("speed [rad/s]")
        axes.set_ylabel("whirl frequency [rad/s]")
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize=9, labelcolor=look.ink)
    return figure
