"""The figure of the circles: families of hands-free ones, their speeds, and the torque that holds other turns."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from scipy.interpolate import Akima1DInterpolator

from mbsd3d.base.style import LINE, Theme, dress, house, theme

from .families import Family
from .parameters import Parameters
from .turning import Turn

MARKS = {"largest lean": "^", "stability changes": "D", "about the rear contact": "s"}


def plot(
    parameters: Parameters, found: Sequence[Family], held: Sequence[Sequence[Turn]] = (), *, dark: bool = False
) -> Figure:
    """Lean, speed and radius of the families, and steer torque over lean at constant speeds.

    Parameters
    ----------
    parameters : Parameters
    found : sequence of Family
        Thick where stable.
    held : sequence of sequences of Turn
        Turns with steer torque, one sequence per speed.
    dark : bool
        On dark paper.

    Returns
    -------
    matplotlib.figure.Figure
        Not shown; `mbsd3d.save_figure` writes it.
    """
    look = theme(dark)
    with house(look):
        figure = Figure(figsize=(10.0, 8.4), layout="constrained")
        figure.get_layout_engine().set(w_pad=0.1, h_pad=0.1)
        axes = figure.subplots(2, 2)
        for one in axes.flat:
            dress(one, look)
        families(axes[0, 0], found, "steer", "lean", look)
        families(axes[0, 1], found, "lean", "speed", look)
        families(axes[1, 0], found, "speed", "radius", look)
        axes[1, 0].set_yscale("symlog", linthresh=1.0)
        axes[1, 0].set_ylim(-100.0, 100.0)
        axes[1, 0].yaxis.set_major_formatter("{x:g}")
        torques(axes[1, 1], held, look)
        figure.suptitle(f"{parameters.name}: steady circles, steered to the right", fontweight="bold")
        legend(figure, len(found), look)
    return figure


UNITS = {"steer": "steer angle [°]", "lean": "lean [°]", "speed": "speed of the rear contact [m/s]",
         "radius": "radius of the rear track, right > 0 [m]"}  # fmt: skip


def shown(values: np.ndarray, name: str) -> np.ndarray:
    """Angles in degrees."""
    return np.degrees(values) if name in ("steer", "lean") else values


def families(axes: Any, found: Sequence[Family], x: str, y: str, look: Theme) -> None:
    """One quantity over another; thick where stable, with marks at special turns."""
    for k, family in enumerate(found):
        across, up = (shown(family.values(name), name) for name in (x, y))
        stable = np.where(family.values("stable"), up, np.nan)
        axes.plot(across, up, color=look.colour(k), linewidth=LINE)
        axes.plot(across, stable, color=look.colour(k), linewidth=3.5 * LINE, solid_capstyle="butt")
        for name, turn in family.special:
            place = [shown(np.array([getattr(turn, q)]), q) for q in (x, y)]
            axes.plot(*place, MARKS[name], color=look.colour(k), markersize=5, markeredgecolor=look.ink)
    axes.set_xlabel(UNITS[x])
    axes.set_ylabel(UNITS[y])


def torques(axes: Any, held: Sequence[Sequence[Turn]], look: Theme) -> None:
    """Steer torque over lean, a smooth line per speed through the points of the turns."""
    for k, turns in enumerate(turn for turn in held if turn):
        points = np.array([(np.degrees(turn.lean), turn.torque) for turn in turns])
        axes.plot(*points.T, "o", color=look.colour(k), markersize=3)
        axes.plot(*smooth(points).T, color=look.colour(k), linewidth=LINE, label=f"{turns[0].speed:.3g} m/s")
    axes.set_xlabel("lean [°]")
    axes.set_ylabel("steer torque that holds it, right > 0 [N m]")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(frameon=False, labelcolor=look.ink, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)


def smooth(points: np.ndarray) -> np.ndarray:
    """(k, 2) a curve through points (n, 2), which it does not overshoot much; a single point stays alone."""
    count = len(points)
    if count < 2:
        return points
    return Akima1DInterpolator(np.arange(count), points, method="makima")(np.linspace(0, count - 1, 10 * count - 9))


def legend(figure: Figure, count: int, look: Theme) -> None:
    """Families, marks and line widths, below all panels."""
    entries = [Line2D([], [], color=look.colour(k), linewidth=LINE, label=f"family {k + 1}") for k in range(count)]
    entries.append(Line2D([], [], color=look.muted, linewidth=3.5 * LINE, label="stable"))
    for name, mark in MARKS.items():
        entries.append(Line2D([], [], color=look.muted, marker=mark, linestyle="none", markersize=5, label=name))
    figure.legend(handles=entries, frameon=False, labelcolor=look.ink, loc="outside lower center", ncols=4)
