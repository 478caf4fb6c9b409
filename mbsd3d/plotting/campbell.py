"""Campbell diagrams: whirl frequencies over the speed of a rotor."""

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.style import dress, new_figure
from ..linear.campbell import Campbell

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LINE_STYLES = {"forward": "-", "backward": "--", "planar": "-.", "mixed": ":"}


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
        dress(axes, look)
        axes.set_ylim(0.0, 1.05 * top)
        axes.set_xlim(speeds[0], speeds[-1])
        axes.set_xlabel("speed [rad/s]")
        axes.set_ylabel("whirl frequency [rad/s]")
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize=9, labelcolor=look.ink)
    return figure
