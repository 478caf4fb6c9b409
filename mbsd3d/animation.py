"""The mechanism drawn in space, and how it moves; what is drawn says `mbsd3d.scene`."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.animation import FuncAnimation
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.proj3d import proj_transform

from .parts import number
from .scene import Scene, strokes

# Okabe and Ito's colours, told apart with any colour vision; black and yellow are left out: axes and paper
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#E69F00", "#56B4E9", "#CC79A7")
GREY = "#707070"
ROOM, MIDDLE = np.array([0.8, 0.78]), np.array([0.46, 0.52])  # of the figure for the box of the data


def colour(i: int) -> str:
    """Colour of body or line ``i``."""
    return COLOURS[i % len(COLOURS)]


def bounds(frames: list[list[np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner of all lines [m]."""
    points = np.concatenate([line for lines in frames for line in lines])
    points = points[np.isfinite(points).all(axis=1)]
    low, high = points.min(axis=0), points.max(axis=0)
    margin = max(0.05 * float((high - low).max()), 1e-9)
    return low - margin, high + margin


def prepare(axes: Any, low: np.ndarray, high: np.ndarray) -> None:
    """Equal scales, units, and a ground grid at the height of the lowest point."""
    size = float((high - low).max())
    middle, half = 0.5 * (low + high), np.maximum(0.5 * (high - low), 0.2 * size)
    half[2] = 0.5 * (high - low)[2] if (high - low)[2] > 0.4 * size else half[2]
    low, high = np.array([*(middle - half)[:2], low[2]]), np.array([*(middle + half)[:2], low[2] + 2.0 * half[2]])
    step = 10.0 ** np.floor(np.log10(size / 3.0))
    step *= next(factor for factor in (5.0, 2.0, 1.0) if size / (step * factor) >= 3.0)
    grid = []
    for i, j in ((0, 1), (1, 0)):
        for x in np.arange(np.ceil(low[i] / step), np.floor(high[i] / step) + 1) * step:
            line = np.full((2, 3), low[2])
            line[:, i], line[:, j] = x, (low[j], high[j])
            grid.append(line)
    axes.plot(*strokes(*grid).T, color="#c8c8c8", linewidth=0.6, zorder=0)
    for axis, name, k in ((axes.xaxis, "x", 0), (axes.yaxis, "y", 1), (axes.zaxis, "z", 2)):
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
        ticks = np.arange(np.ceil(low[k] / step - 1e-9), np.floor(high[k] / step + 1e-9) + 1) * step
        axis.set_ticks(np.round(ticks, 12) + 0.0)
        getattr(axes, f"set_{name}label")(f"{name} [m]", labelpad=8.0)
        getattr(axes, f"set_{name}lim")(low[k], high[k], auto=False)
    axes.grid(False)
    axes.view_init(elev=22.0, azim=-58.0)
    fit(axes, low, high)


def fit(axes: Any, low: np.ndarray, high: np.ndarray) -> None:
    """Scale and shift the picture such that the box of the data, with room for numbers, fills the figure."""
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    figure, zoom = axes.figure, 1.0
    for _ in range(3):  # perspective makes it slightly nonlinear
        axes.set_box_aspect(high - low, zoom=zoom)
        axes.apply_aspect()
        x, y, _ = proj_transform(*corners.T, axes.get_proj())
        spots = figure.transFigure.inverted().transform(axes.transData.transform(np.column_stack([x, y])))
        zoom *= float(np.min(ROOM / np.ptp(spots, axis=0)))
    shift = MIDDLE - 0.5 * (spots.min(axis=0) + spots.max(axis=0))
    place = axes.get_position(original=True)
    axes.set_position((place.x0 + shift[0], place.y0 + shift[1], place.width, place.height))


def draw(axes: Any, scene: Scene, lines: list[np.ndarray]) -> list[Any]:
    """Line artists for the lines of a scene, in their order."""
    styles: list[dict[str, Any]] = []
    for i, body in enumerate(scene.system.bodies):
        tint = {"color": colour(i)}
        styles += [
            {**tint, "linewidth": 1.1, "label": body.name},
            {**tint, "linewidth": 2.2, "alpha": 0.55, "solid_capstyle": "round"},
            {**tint, "linestyle": "none", "marker": "o", "markersize": 5},
            {**tint, "linestyle": "none", "marker": "+", "markersize": 13, "markeredgewidth": 1.3},
        ]
    styles += [
        {"color": GREY, "linewidth": 1.2, "linestyle": "--"},
        {"color": "black", "linestyle": "none", "marker": "D", "markersize": 8, "markerfacecolor": "none"},
        {"color": "black", "linewidth": 1.2},
    ]
    return [axes.plot(*line.T, **style)[0] for line, style in zip(lines, styles, strict=True)]


def nearest(t: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Places of the samples nearest to the times."""
    after = np.clip(np.searchsorted(t, times), 1, max(t.size - 1, 1))
    return np.where(times - t[after - 1] <= t[np.minimum(after, t.size - 1)] - times, after - 1, after) % t.size


def animate(solution: Any, fps: float = 25, speed: float = 1.0, size: Sequence[float] = (6, 6)) -> FuncAnimation:
    """The motion of a solution as an animation with the traces of the centres of mass.

    Nothing is interpolated: every frame shows the sample nearest to its time, and the time of that sample. Ask
    `simulate` for ``output`` as dense as the frames are.

    Parameters
    ----------
    solution : Solution
        At least one sample.
    fps : float
        Frames per second of the film > 0.
    speed : float
        Seconds of the run per second of the film > 0; 0.1 is slow motion.
    size : (float, float)
        Width and height [inch], at 100 pixels per inch.

    Returns
    -------
    matplotlib.animation.FuncAnimation
        Nothing is shown; write it with ``.save("motion.gif", writer="pillow")`` or ``.to_jshtml()``.

    Raises
    ------
    ValueError
        If ``fps`` or ``speed`` is not positive, the size is no pair, or there is no sample.
    """
    fps, speed = number(fps, "animate: fps", positive=True), number(speed, "animate: speed", positive=True)
    if len(tuple(size)) != 2:
        raise ValueError(f"animate: size is {size!r}; give width and height [inch]")
    if not solution.t.size:
        raise ValueError("animate: the solution has no samples; run it to a later time")
    width, height = (number(length, "animate: size", positive=True) for length in size)
    t, scene, q = solution.t, Scene(solution.system), solution.arrays["q"]
    count = int((t[-1] - t[0]) * fps / speed + 1e-9) + 1
    shown = nearest(t, t[0] + np.arange(count) * speed / fps)
    few = np.unique(np.linspace(0, t.size - 1, 60).astype(int))  # enough to see how far the motion reaches
    low, high = bounds([scene.lines(scene.poses(q[k, :, :3], q[k, :, 3:]), 0.0) for k in few])
    axis_length = 0.12 * float((high - low).max())
    figure = Figure(figsize=(width, height))
    axes = figure.add_axes((0.02, 0.02, 0.9, 0.9), projection="3d")
    prepare(axes, low, high)
    artists = draw(axes, scene, scene.lines(scene.poses(q[0, :, :3], q[0, :, 3:]), axis_length))
    paths = [solution.com(body) for body in scene.system.bodies]
    traces = [axes.plot(*path[:1].T, color=colour(i), linewidth=0.8, alpha=0.7)[0] for i, path in enumerate(paths)]
    clock = figure.text(0.03, 0.95, "")
    figure.legend(handles=artists[0 : 4 * len(paths) : 4], loc="upper right", frameon=False, ncols=2, fontsize=9)

    def update(frame: int) -> list[Any]:
        k = shown[frame]
        for artist, line in zip(artists, scene.lines(scene.poses(q[k, :, :3], q[k, :, 3:]), axis_length), strict=True):
            artist.set_data_3d(*line.T)
        for trace, path in zip(traces, paths, strict=True):
            trace.set_data_3d(*path[: k + 1].T)
        clock.set_text(f"t = {t[k]:.3f} s")
        return [*artists, *traces, clock]

    return FuncAnimation(figure, update, frames=count, interval=1000.0 / fps, blit=False, cache_frame_data=False)
