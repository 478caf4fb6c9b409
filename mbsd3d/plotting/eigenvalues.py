"""Eigenvalues in the complex plane."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..base.style import LIGHT, dress, house
from ..linear.modes import ModalAnalysis

MARKERS = "osD^v<>pP*X"


def plot_eigenvalues(linearization: ModalAnalysis) -> Figure:
    """Plot eigenvalues in the complex plane, one mark per mode and one for all zeros; the growing half is tinted."""
    look = LIGHT
    with house(look):
        figure = Figure(figsize=(7.5, 4.6), layout="constrained")
        axes, values = figure.subplots(), linearization.eigenvalues
        marks = [(mode.label, mode.eigenvalue) for mode in linearization.modes if mode.eigenvalue]
        zeros = int((values == 0.0).sum())
        for k, (label, s) in enumerate([*marks, *([(f"{zeros} zero" + "s" * (zeros > 1), 0j)] if zeros else [])]):
            points = np.array([s, s.conjugate()] if s.imag else [s])
            style: dict[str, Any] = {
                "color": look.colour(k) if s else look.ink,
                "marker": MARKERS[k % len(MARKERS)] if s else "x",
            }
            axes.plot(points.real, points.imag, linestyle="none", markerfacecolor="none", label=label, **style)
        axes.axhline(0.0, color=look.muted, linewidth=0.8)
        axes.axvline(0.0, color=look.muted, linewidth=0.8)
        size = float(np.abs(values).max(initial=0.0)) or 1.0
        low, high = min(values.real.min(), 0.0) - 0.1 * size, max(values.real.max(), 0.0) + 0.1 * size
        axes.set_xlim(low, high)
        axes.axvspan(0.0, high, color=look.lines[1], alpha=0.06, linewidth=0.0)
        axes.set_ylim(*np.array([-1.1, 1.1]) * max(np.abs(values.imag).max(), 0.1 * size))
        dress(axes, look)
        axes.set_xlabel("real part (growth) [1/s]")
        axes.set_ylabel("imaginary part [rad/s]")
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize=9, labelcolor=look.ink)
    return figure
