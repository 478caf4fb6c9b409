"""The figure of a ride: angles, loads and friction over time, and the way seen from above."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from mbsd3d.base.style import LINE, Theme, dress, house, theme

from .motion import NO_ROAD, Ride

SLENDER = 6.0  # length over width from which on the way is not drawn to scale
LABELS = {
    "angles": "angle, right > 0 [°]",
    "rates": "yaw rate, right > 0 [°/s]",
    "loads": "load of the wheel [N]",
    "friction": "friction needed [-]",
}


def plot(ride: Ride, title: str | None = None, *, dark: bool = False) -> Figure:
    """Lean, steer, loads of the wheels, friction they need, and the tracks of both wheels.

    Parameters
    ----------
    ride : Ride
    title : str or None
        None = the name of the bicycle.
    dark : bool
        On dark paper.

    Returns
    -------
    matplotlib.figure.Figure
        Not shown; `mbsd3d.save_figure` writes it.
    """
    look = theme(dark)
    with house(look):
        figure = Figure(figsize=(10.0, 8.2), layout="constrained")
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


def lines(axes: Any, t: np.ndarray, values: dict[str, np.ndarray], look: Theme) -> None:
    """Curves over time, named beside the axes if there are several."""
    for k, (name, line) in enumerate(values.items()):
        axes.plot(t, line, color=look.colour(k), linewidth=LINE, label=name)
    if len(values) > 1:
        axes.legend(frameon=False, labelcolor=look.ink, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)


def way(axes: Any, ride: Ride, look: Theme) -> None:
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
    axes.legend(frameon=False, labelcolor=look.ink, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)
