"""Pictures of a system and of a solution: matplotlib figures, shaded, in perspective."""

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..parts import number
from ..style import house, theme
from .drawing import bounds, draw_system, frame_camera, poses_of
from .lens import lens_of, turned
from .motion import Arrows, Frames, Trace, arrows_of, frames_of, traces_of
from .painter import FINE, Painter, new_sheet
from .pointers import pointers_of, tips_of

LAYERS = ("body", "joint", "centre of mass", "reference point")
KINDS = ("angular velocity", "angular momentum", "reaction force", "reaction moment")
REACH = 0.4  # length of the longest arrow, of the size of what is seen


def chosen(what: str, wanted: Collection[str], known: Sequence[str]) -> tuple[str, ...]:
    """The wanted ones in their order, or a ValueError that names the known ones."""
    wanted = (wanted,) if isinstance(wanted, str) else tuple(wanted)
    for name in wanted:
        if name not in known:
            raise ValueError(f"{what} {name!r} is unknown; give some of {', '.join(map(repr, known))}")
    return wanted


def pair(value: Any, what: str) -> tuple[float, float]:
    """Two numbers."""
    if np.shape(value) != (2,):
        raise ValueError(f"{what}: {value!r} is no pair; give two numbers")
    return number(value[0], what), number(value[1], what)


def painter_of(
    system: Any,
    r: np.ndarray,
    e: np.ndarray,
    inches: tuple[float, float],
    *,
    paths: Sequence[Trace] = (),
    vectors: Sequence[Arrows] = (),
    names: bool | None = None,
    layers: Collection[str] = ("body", "joint"),
    view: Sequence[float] | None = None,
    dark: bool = False,
    ground: bool = True,
    fine: float = FINE,
    **unknown: Any,
) -> tuple[Painter, float]:
    """A painter whose paper holds all poses, paths and arrows, and the length of the longest arrow [m]."""
    if unknown:
        mine = "names, layers, view, dark, ground"
        raise ValueError(f"option '{next(iter(unknown))}' is unknown; there are {mine}, and those of the method itself")
    drawing = draw_system(system)
    low, high = bounds(drawing, r, e)
    camera = frame_camera(low, high)
    if view is not None:
        azimuth, elevation = pair(view, "picture: view")
        if not -89.0 <= elevation <= 89.0:
            raise ValueError(f"picture: view: elevation = {elevation:g}; give -89 ... 89 degrees")
        camera = turned(camera, azimuth, elevation)
    shown, reach = chosen("picture: layer", layers, LAYERS), REACH * float((high - low).max())
    also = [trace.points for trace in paths] + [tips_of(x, reach) for x in vectors]
    return Painter(
        drawing, lens_of(camera), r, e, inches, sheet=theme(dark), layers=shown, names=names, ground=ground, fine=fine,
        also=np.concatenate(also) if also else None,
    ), reach  # fmt: skip


def paper_size(size: Any) -> tuple[float, float]:
    """Width and height [inch], both positive."""
    width, height = pair(size, "picture: size")
    return number(width, "picture: size", positive=True), number(height, "picture: size", positive=True)


def picture_of_system(system: Any, state: Any = None, *, size: Sequence[float] = (6.4, 4.8), **options: Any) -> Figure:
    """A system at rest.

    Parameters
    ----------
    system : System
        What to draw.
    state : State or None
        Pose; None = the reference pose.
    size : (float, float)
        Width and height [inch].
    **options
        ground : bool
            Whether the floor is drawn, with a grid and the shadows of a high sun; it lies under the lowest point.
        names : bool or None
            Whether the names of bodies and joints are written; None = if there are at most 14.
        layers : collection of str
            Some of "body", "joint", "centre of mass", "reference point"; the first two if not given.
        view : (float, float) or None
            Azimuth (from x about z) and elevation of the eye [degrees]; None = the view of `System.show`.
        dark : bool
            On dark paper.

    Returns
    -------
    matplotlib.figure.Figure
        Not shown; `mbsd3d.plots.save_figure` writes it.

    Raises
    ------
    ValueError
        If the state is one of another system, a shape cannot be drawn, or an option is none.
    """
    r, e = poses_of(system, state)
    painter, _ = painter_of(system, r[None], e[None], paper_size(size), **options)
    with house(painter.sheet):
        figure, axes = new_sheet(painter.inches, painter.sheet)
        painter.paint(axes, [(r, e)])
    return figure


def picture_of_solution(
    solution: Any,
    t: float | Sequence[float] | None = None,
    *,
    traces: Any = None,
    arrows: Collection[str] = (),
    size: Sequence[float] = (6.4, 4.8),
    **options: Any,
) -> Figure:
    """A moment of a run, or several in one picture.

    Parameters
    ----------
    solution : Solution
        At least one sample.
    t : float, sequence of float, or None
        Time [s]; several = a multiple exposure; None = the last sample.
    traces : sequence of (body, point), or None
        Points whose paths until then (of several times: from the first to the last) are drawn: a body and a world
        point at the reference pose [m]; () = none, None = the centres of mass.
    arrows : collection of str
        Some of "angular velocity", "angular momentum", "reaction force", "reaction moment". Their lengths are to scale
        within a kind; the legend gives the longest. Shares that the constraints leave open are pale.
    size, **options
        See `picture_of_system`.

    Returns
    -------
    matplotlib.figure.Figure
        With the time in it.

    Raises
    ------
    ValueError
        If a time is outside the run, a part or a kind of arrow is unknown, or an option is none.
    """
    kinds = chosen("picture: arrow", arrows, KINDS)
    inches = paper_size(size)
    run = frames_of(solution)
    try:
        times = np.atleast_1d(np.asarray(run.t[-1] if t is None else t, float))
    except (TypeError, ValueError):
        times = np.empty(0)
    if times.ndim != 1 or not times.size:
        raise ValueError(f"picture: t = {t!r}; give a time or a sequence of times [s]")
    poses = [poses_of(solution.system, solution.at(float(time))) for time in times]
    shown = Frames(times, *(np.array(x) for x in zip(*poses, strict=True)))
    paths = traces_of(solution, run_until(run, shown), traces)
    both = Frames(*(np.concatenate(pair) for pair in zip(run, shown, strict=True)))  # one scale for every moment
    vectors = [x for x in arrows_of(solution, both) if x.kind in kinds] if kinds else []
    painter, reach = painter_of(solution.system, shown.r, shown.e, inches, paths=paths, vectors=vectors, **options)
    with house(painter.sheet):
        figure, axes = new_sheet(inches, painter.sheet)
        pointers = [pointers_of(x, k, reach, painter.lens) for x in vectors for k in range(run.t.size, both.t.size)]
        painter.paint(axes, poses, traces=paths, arrows=pointers)
        moments = [f"{time:.4g}" for time in times]
        painter.write_note(
            axes, f"t = {', '.join(moments) if len(moments) < 6 else ' ... '.join(moments[:: len(moments) - 1])} s"
        )
    return figure


def run_until(run: Frames, shown: Frames) -> Frames:
    """The frames before the last of the shown ones, and that one; of several, not before the first of them."""
    last = int(np.argmax(shown.t))
    since = shown.t.min() if shown.t.size > 1 else -np.inf
    path = (run.t >= since) & (run.t < shown.t[last])
    return Frames(*(np.concatenate([a[path], b[last : last + 1]]) for a, b in zip(run, shown, strict=True)))
