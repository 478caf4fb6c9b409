"""Figures of rides and of steady turns; nothing is shown, `mbsd3d.plots.save_figure` writes them."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from scipy.interpolate import Akima1DInterpolator

from mbsd3d.extend import LINE, Theme, dress

from ..output import new_figure
from ..parameters import Parameters
from ..rides.motion import NO_ROAD, Ride
from ..turns.families import Family
from ..turns.turning import Turn

SLENDER = 6.0  # length over width from which on the tracks are not drawn to scale
LABELS = {
    "angles": "angle, right > 0 [°]",
    "rates": "yaw rate, right > 0 [°/s]",
    "loads": "load of the wheel [N]",
    "friction": "friction needed [-]",
}
MARKS = {"largest lean": "^", "stability changes": "D", "about the rear contact": "s"}
UNITS = {"steer": "steer angle [°]", "lean": "lean [°]", "speed": "speed of the rear contact [m/s]",
         "radius": "radius of the rear track, right > 0 [m]"}  # fmt: skip


def plot_ride(ride: Ride, title: str | None = None, *, dark: bool = False) -> Figure:
    """Lean, steer, loads of the wheels and friction they need over time, and the tracks of both wheels from above."""
    with new_figure(10.0, 8.2, dark) as (figure, look):
        figure.get_layout_engine().set(w_pad=0.1, h_pad=0.08)
        axes = figure.subplot_mosaic(
            [["angles", "loads"], ["rates", "friction"], ["way", "way"]], height_ratios=(1.0, 1.0, 1.3)
        )
        for one in axes.values():
            dress(one, look)
        lines(axes["angles"], ride.t, {"lean": np.degrees(ride.lean), "steer": np.degrees(ride.steer)}, look)
        lines(axes["rates"], ride.t, {"yaw rate": np.degrees(ride.yaw_rate)}, look)
        lines(axes["loads"], ride.t, {wheel: contact.normal for wheel, contact in ride.contacts.items()}, look)
        friction = {wheel: contact.friction for wheel, contact in ride.contacts.items()}
        lines(axes["friction"], ride.t, friction, look)
        axes["friction"].set_ylim(0.0, min(1.05 * ride.friction, NO_ROAD) or 1.0)
        for name, label in LABELS.items():
            axes[name].set_ylabel(label)
            axes[name].set_xlabel("time [s]")
        way(axes["way"], ride, look)
        figure.suptitle(f"{ride.parameters.name}: {title}" if title else ride.parameters.name, fontweight="bold")
    return figure


def lines(axes: Axes, t: np.ndarray, values: dict[str, np.ndarray], look: Theme) -> None:
    """Curves over time, named beside the axes if there are several."""
    for k, (name, line) in enumerate(values.items()):
        axes.plot(t, line, color=look.colour(k), linewidth=LINE, label=name)
    if len(values) > 1:
        legend_above(axes, look)


def legend_above(axes: Axes, look: Theme) -> None:
    """Names of the lines, above the axes."""
    axes.legend(frameon=False, labelcolor=look.ink, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)


def way(axes: Axes, ride: Ride, look: Theme) -> None:
    """Tracks of both wheels from above, to scale unless the way is slender; the end is marked."""
    points = {wheel: contact.point for wheel, contact in ride.contacts.items()}
    for k, (wheel, point) in enumerate(points.items()):
        axes.plot(point[:, 0], -point[:, 1], color=look.colour(k), linewidth=LINE, label=f"{wheel} wheel")
        axes.plot(point[-1, 0], -point[-1, 1], "o", color=look.colour(k), markersize=5)
    size = np.ptp(np.concatenate([*points.values()]), axis=0)
    axes.set_xlabel("way along the first heading [m]")
    axes.set_ylabel("way to the right [m]")
    axes.invert_yaxis()  # seen from above, what is to the right is below
    if size[0] < SLENDER * size[1]:
        axes.set_aspect("equal", adjustable="datalim")
    if ride.event:
        axes.set_title(f"{ride.event.name} at {ride.event.t:.3g} s", loc="right", color=look.ink)
    legend_above(axes, look)


def plot_circles(
    parameters: Parameters, found: Sequence[Family], held: Sequence[Sequence[Turn]] = (), *, dark: bool = False
) -> Figure:
    """Lean, speed and radius of the families, and steer torque over lean of the turns ``held`` at one speed each."""
    with new_figure(10.0, 8.4, dark) as (figure, look):
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


def shown(values: np.ndarray, name: str) -> np.ndarray:
    """Angles in degrees."""
    return np.degrees(values) if name in ("steer", "lean") else values


def families(axes: Axes, found: Sequence[Family], x: str, y: str, look: Theme) -> None:
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


def torques(axes: Axes, held: Sequence[Sequence[Turn]], look: Theme) -> None:
    """Steer torque over lean, a smooth line per speed through the points of the turns."""
    for k, turns in enumerate(turn for turn in held if turn):
        points = np.array([(np.degrees(turn.lean), turn.torque) for turn in turns])
        axes.plot(*points.T, "o", color=look.colour(k), markersize=3)
        axes.plot(*smooth(points).T, color=look.colour(k), linewidth=LINE, label=f"{turns[0].speed:.3g} m/s")
    axes.set_xlabel("lean [°]")
    axes.set_ylabel("steer torque that holds it, right > 0 [N m]")
    if axes.get_legend_handles_labels()[0]:
        legend_above(axes, look)


def smooth(points: np.ndarray) -> np.ndarray:
    """(k, 2) a curve through points (n, 2) that hardly overshoots; a single point stays as it is."""
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
