"""The figure of the frequency study: a Bode plot."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MultipleLocator, NullFormatter

from mbsd3d.base.style import LINE, dress, house, theme
from mbsd3d.report.wording import RAISED


def draw(found: Any, dark: bool) -> Any:
    """Magnitude and phase of lean and steer (rows) to lean and steer torque (columns), a line per speed.

    Parameters
    ----------
    found : bicycle.frequency.Response
    dark : bool
        On dark paper.

    Returns
    -------
    matplotlib.figure.Figure
    """
    look = theme(dark)
    with house(look):
        figure = Figure(figsize=(9.0, 9.0), layout="constrained")
        panels = figure.subplots(4, 2, sharex=True, height_ratios=(1.5, 1.0, 1.5, 1.0))
        for out, given in np.ndindex(2, 2):
            size, phase = panels[2 * out : 2 * out + 2, given]
            for axes in (size, phase):
                dress(axes, look)
            draw_lines(size, phase, found, found.H[:, :, out, given], look)
            size.set_title(f"{found.outputs[out]} / {found.inputs[given]}")
        for out in (0, 1):
            panels[2 * out, 0].set_ylabel("magnitude [rad/(N m)]")
            panels[2 * out + 1, 0].set_ylabel("phase [°]")
        for axes in panels[-1]:
            axes.set_xlabel("frequency ω [rad/s]")
        handles, names = panels[0, 0].get_legend_handles_labels()
        legend = {"loc": "outside lower center", "ncols": min(len(names), 4), "frameon": False, "labelcolor": look.ink}
        figure.legend(handles, names, **legend)
        figure.suptitle(f"{found.parameters.name}: response of lean and steer to torques")
        figure.align_ylabels(panels[:, 0])
    return figure


def draw_lines(size: Any, phase: Any, found: Any, H: np.ndarray, look: Any) -> None:
    """Magnitude and phase of one output to one input, (speeds, frequencies)."""
    for k, (v, growth) in enumerate(zip(found.speeds, found.growth, strict=True)):
        falls = growth > 0.0
        style = {"color": look.colour(k), "linestyle": "--" if falls else "-", "linewidth": LINE}
        size.loglog(found.frequencies, np.abs(H[k]), label=f"{v:g} m/s{', falls' if falls else ''}", **style)
        degrees = np.degrees(np.unwrap(np.angle(H[k])))
        turns = np.round((degrees[0] - 10.0) / 360.0)  # begins in -170 ... 190: against the torque is 180 on both sides
        phase.semilogx(found.frequencies, degrees - 360.0 * turns, **style)
    decades(size.yaxis)
    decades(size.xaxis)
    phase.yaxis.set_major_locator(MultipleLocator(90.0))


def decades(axis: Any) -> None:
    """Labels like 10⁻² at every decade: the house style writes texts as they are, without mathematics."""
    axis.set_major_locator(LogLocator(numticks=20))
    axis.set_major_formatter(FuncFormatter(lambda x, _: f"10{str(round(np.log10(x))).translate(RAISED)}"))
    axis.set_minor_formatter(NullFormatter())
