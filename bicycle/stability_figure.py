"""The figure of the stability study."""

from typing import Any

import numpy as np

from mbsd3d.base.style import LINE, THIN, Theme, dress, house, theme

DOTS = 34  # of the closed form, so that the lines are seen between them
SHOWN = (0, 2, 3)  # weave (its conjugate is the mirrored line), capsize, castering


def draw(found: Any, dark: bool) -> Any:
    """Growth and frequency of the modes over the speed.

    Parameters
    ----------
    found : bicycle.stability.Stability
    dark : bool
        On dark paper.

    Returns
    -------
    matplotlib.figure.Figure
    """
    from matplotlib.figure import Figure

    look = theme(dark)
    with house(look):
        figure = Figure(figsize=(9.2, 6.2), layout="constrained")
        growth, frequency = figure.subplots(2, 1, sharex=True, height_ratios=(1.7, 1.0))
        for axes in (growth, frequency):
            shade(axes, found, look)
            dress(axes, look)
            axes.margins(x=0.0)
        lines(growth, found, look, np.real)
        lines(frequency, found, look, lambda s: np.abs(np.imag(s)))
        growth.axhline(0.0, color=look.ink, linewidth=THIN)
        mark(growth, found, look)
        growth.set_ylim(*window(found))
        growth.set_ylabel("growth, Re(s) [1/s]")
        frequency.set_ylabel("frequency, |Im(s)| [rad/s]")
        frequency.set_xlabel("speed [m/s]")
        growth.set_title(f"{found.parameters.name}: small motions about a straight run")
        growth.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize=9, labelcolor=look.ink)
    return figure


def window(found: Any) -> tuple[float, float]:
    """Limits of the growth: all that matters for stability; a fast castering mode may leave the frame."""
    real = found.values.real
    slow = real[:, :3]
    low, high = min(slow.min(), 0.0), max(slow.max(), 0.0)
    high = max(high, min(real.max(), 2.0 * high))
    margin = 0.08 * (high - low) or 1.0
    return max(real.min(), 2.0 * low) - margin, high + margin


def shade(axes: Any, found: Any, look: Theme) -> None:
    """Tint the self-stable ranges of forward speeds."""
    start, end, label = found.speeds.min(), found.speeds.max(), "self-stable"
    for part in found.critical.stable:
        if part.low < end and part.high > start:
            low, high = max(part.low, start), min(part.high, end)
            axes.axvspan(low, high, color=look.good, linewidth=0.0, zorder=0, label=label)
            label = None


def lines(axes: Any, found: Any, look: Theme, part: Any) -> None:
    """Lines of the general model by mode, dots of the closed form."""
    split = np.abs(found.values.imag[:, 0]) <= 1e-9 * np.abs(found.values).max()
    split = split | np.r_[split[1:], False] | np.r_[False, split[:-1]]  # up to where they are one
    for side in (found.speeds < 0.0, found.speeds >= 0.0):  # at rest the modes get their names anew
        speeds, values = found.speeds[side], found.values[side]
        for number, k in enumerate(SHOWN):
            label = found.names[k] if side[np.argmax(found.speeds)] else None
            axes.plot(speeds, part(values[:, k]), label=label, color=look.colour(number), linewidth=LINE)
        rest = np.where(split[side], part(values[:, 1]), np.nan)  # the second of two real modes that become the weave
        axes.plot(speeds, rest, color=look.colour(0), linewidth=LINE)
    if found.closed is not None:
        every = max(1, found.speeds.size // DOTS)
        dots = part(found.closed[::every])
        style = {"color": look.ink, "marker": "o", "markersize": 2.4, "linestyle": "none"}
        for k in range(4):
            axes.plot(found.speeds[::every], dots[:, k], label=None if k else "closed form (2007)", **style)


def mark(axes: Any, found: Any, look: Theme) -> None:
    """Weave and capsize speed, where they are in the frame; the lower has its name on the left, to be read beside."""
    speeds = {"weave": found.critical.weave, "capsize": found.critical.capsize}
    for name, speed in speeds.items():
        if found.speeds.min() < speed < found.speeds.max():
            side = -1 if speed == np.nanmin([*speeds.values()]) else 1
            axes.axvline(speed, color=look.muted, linewidth=THIN, linestyle="--")
            axes.annotate(
                f"{name} {speed:.4g} m/s", (speed, 0.99), xycoords=("data", "axes fraction"), rotation=90.0,
                ha="right" if side < 0 else "left", va="top", fontsize=8.5, color=look.muted, xytext=(2 * side, 0),
                textcoords="offset points",
            )  # fmt: skip
