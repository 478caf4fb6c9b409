"""The mechanism drawn in space: outlines of the bodies, joints with their axes, and how they move.

A body without a shape of its own is drawn as the homogeneous solid that has its mass and inertia: a cylinder if two
principal moments are equal, a sphere if all are, else a box. ``Body(shape=...)`` may be "box", "ellipsoid", or a
(k, 3) polyline in body axes from the reference point [m], with rows of NaN between its strokes.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.animation import FuncAnimation
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.proj3d import proj_transform

from .contacts import RollingDisc
from .joints import Joint
from .parts import GROUND, Body, number
from .rotations import matrix
from .state import State

# Okabe and Ito's colours, told apart with any colour vision; black and yellow are left out: axes and paper
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#E69F00", "#56B4E9", "#CC79A7")
GREY = "#707070"
LIFT = np.full((1, 3), np.nan)  # lifts the pen between two strokes
EQUAL = 1e-6  # relative difference of principal moments that counts as none
ROOM, MIDDLE = np.array([0.8, 0.78]), np.array([0.46, 0.52])  # of the figure for the box of the data
AXES_OF_A, AXES_OF_B = ("axis", "axis_a", "normal"), ("axis_b", "lateral")


def colour(i: int) -> str:
    """Colour of body or line ``i``."""
    return COLOURS[i % len(COLOURS)]


def strokes(*lines: Any) -> np.ndarray:
    """(k, 3) one polyline of several, with NaN between them."""
    pieces = [piece for line in lines for piece in (np.reshape(line, (-1, 3)), LIFT)]
    return np.concatenate(pieces) if pieces else np.zeros((0, 3))


def circle(radius: float, normal: int, height: float = 0.0) -> np.ndarray:
    """Circle about coordinate axis ``normal``."""
    turn = np.linspace(0.0, 2.0 * np.pi, 49)
    points = np.full((turn.size, 3), height)
    points[:, (normal + 1) % 3], points[:, (normal + 2) % 3] = radius * np.cos(turn), radius * np.sin(turn)
    return points


def box_lines(edges: np.ndarray) -> np.ndarray:
    """The twelve edges of a box about the origin."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * edges
    pairs = [(i, i | bit) for bit in (1, 2, 4) for i in range(8) if not i & bit]
    return strokes(*(corners[list(pair)] for pair in pairs))


def cylinder_lines(radius: float, length: float, axis: int) -> np.ndarray:
    """Both ends of a cylinder, four lines along it, and on each end a radius that shows its turning."""
    low, high = circle(radius, axis, -0.5 * length), circle(radius, axis, 0.5 * length)
    middle = np.eye(3)[axis] * 0.5 * length
    sides = [np.array([low[k], high[k]]) for k in (0, 12, 24, 36)]
    return strokes(low, high, *sides, [-middle, low[0]], [middle, high[0]])


def ellipsoid_lines(radii: np.ndarray) -> np.ndarray:
    """The three principal sections of an ellipsoid."""
    return strokes(*(circle(1.0, normal) * (np.arange(3) != normal) * radii for normal in range(3)))


def outline(body: Body) -> np.ndarray:
    """Strokes of a body in body axes from its reference point.

    Parameters
    ----------
    body : Body
        With or without a shape of its own.

    Returns
    -------
    (k, 3) ndarray
        [m]; rows of NaN separate strokes; none for a body without inertia.

    Raises
    ------
    ValueError
        If its shape is unknown.
    """
    if body.shape is not None and not isinstance(body.shape, str):
        try:
            return np.array(body.shape, dtype=float).reshape(-1, 3)
        except (TypeError, ValueError):
            pass
    if not (body.shape is None or (isinstance(body.shape, str) and body.shape in ("box", "ellipsoid"))):
        raise ValueError(
            f"body '{body.name}': shape {body.shape!r} is unknown; give 'box', 'ellipsoid', None or a (k, 3) polyline "
            "in body axes [m]"
        )
    if body.mass == 0.0 or not body.inertia.any():
        return np.zeros((0, 3))
    moments, principal = np.linalg.eigh(body.inertia)
    return solid(moments / body.mass, body.shape) @ principal.T + body.com


def solid(moments: np.ndarray, shape: str | None) -> np.ndarray:
    """Outline, in principal axes, of the homogeneous solid with these ascending moments per mass [m^2]."""
    squares = np.maximum(moments.sum() - 2.0 * moments, 0.0)  # of the extents, but for a factor
    low, high = (moments[1] - moments[0], moments[2] - moments[1]) <= EQUAL * moments[2]
    if shape == "ellipsoid" or (shape is None and low and high):
        return ellipsoid_lines(np.sqrt(2.5 * squares))
    if shape is None and (low or high):
        axis = 2 if low else 0
        along, across = moments[axis], moments[1]
        return cylinder_lines(np.sqrt(2.0 * along), np.sqrt(max(12.0 * across - 6.0 * along, 0.0)), axis)
    return box_lines(np.sqrt(6.0 * squares))


class Mark(NamedTuple):
    """A joint: its point and axes fixed in bodies, which are given by their places; the ground comes last."""

    joint: Joint
    body: int
    point: np.ndarray
    axes: list[tuple[int, np.ndarray]]

    def shown_at(self, place: np.ndarray, R: np.ndarray, R_a: np.ndarray) -> np.ndarray:
        """World position of the marker: the point itself, or where a disc with its centre there touches its plane."""
        disc = self.joint
        if not isinstance(disc, RollingDisc):
            return place
        normal, axis = R_a @ disc.a.local_axis(disc.plane[1]), R @ disc.b.local_axis(disc.axis)
        down = (normal @ axis) * axis - normal
        return place + (disc.radius - disc.crown) * down / max(np.linalg.norm(down), 1e-12) - disc.crown * normal


class Scene:
    """What is drawn of a system, in body axes; poses (r, R) are (n + 1, 3) and (n + 1, 3, 3), the ground last."""

    def __init__(self, system: Any) -> None:
        self.system, self.bodies = system, [*system.bodies, GROUND]
        self.index = {id(body): i for i, body in enumerate(self.bodies)}
        self.outlines = [outline(body) for body in system.bodies]
        self.joints = [self.mark(joint) for joint in system.joints]
        self.arms = [self.arm(body) for body in system.bodies]
        links = [part for part in (*system.joints, *system.forces) if hasattr(part, "at_a") and hasattr(part, "at_b")]
        self.links = [[self.fixed(link.a, link.at_a), self.fixed(link.b, link.at_b)] for link in links]

    def fixed(self, body: Any, point: np.ndarray) -> tuple[int, np.ndarray]:
        """Place of a body, and in its axes a world point of the reference pose."""
        return self.index[id(body)], body.local_point(point)

    def mark(self, joint: Joint) -> Mark:
        """A joint's point on body b and its axes."""
        disc = isinstance(joint, RollingDisc)
        own = {name: joint.b if disc else joint.a for name in AXES_OF_A} | {name: joint.b for name in AXES_OF_B}
        axes = {name: getattr(joint, name) for name in own if getattr(joint, name, None) is not None}
        if "axis_b" in axes and np.array_equal(axes["axis_b"], axes.get("axis")):
            del axes["axis_b"]
        directions = [(self.index[id(own[name])], own[name].local_axis(axis)) for name, axis in axes.items()]
        return Mark(joint, *self.fixed(joint.b, joint.centre if disc else joint.point()), directions)

    def arm(self, body: Body) -> np.ndarray:
        """Lines from the centre of mass of a body to its joints, body axes."""
        points = []
        for joint in self.system.joints:
            if joint.b is body and (hasattr(joint, "at_b") or hasattr(joint, "centre")):
                points.append(getattr(joint, "at_b", getattr(joint, "centre", None)))
            elif joint.a is body and hasattr(joint, "at_b"):
                points.append(joint.at_a if hasattr(joint, "at_a") else joint.at)
        return strokes(*([body.com, body.local_point(point)] for point in points))

    def poses(self, r: np.ndarray, e: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(r, R) with the ground, from positions (n, 3) and quaternions (n, 4)."""
        return np.vstack([r, np.zeros(3)]), np.concatenate([matrix(e), np.eye(3)[None]])

    def pose(self, state: State | None) -> tuple[np.ndarray, np.ndarray]:
        """(r, R) at a state, or at the reference pose."""
        if state is None:
            bodies = self.system.bodies
            return self.poses(np.array([b.position for b in bodies]), np.array([b.orientation for b in bodies]))
        q = state.q.reshape(-1, 7)
        if len(q) != len(self.outlines):
            raise ValueError(f"state has {len(q)} bodies, the system {len(self.outlines)}; give a state of this system")
        return self.poses(q[:, :3], q[:, 3:])

    def lines(self, pose: tuple[np.ndarray, np.ndarray], size: float) -> list[np.ndarray]:
        """Outlines, arms, centres of mass, reference points of every body; then links, joints, joint axes."""
        r, R = pose
        drawn = []
        for i, body in enumerate(self.system.bodies):
            drawn += [x @ R[i].T + r[i] for x in (self.outlines[i], self.arms[i], body.com[None], np.zeros((1, 3)))]
        at = [mark.point @ R[mark.body].T + r[mark.body] for mark in self.joints]
        tips = [(p, R[k] @ axis) for p, mark in zip(at, self.joints, strict=True) for k, axis in mark.axes]
        shown = [
            mark.shown_at(p, R[mark.body], R[self.index[id(mark.joint.a)]])
            for p, mark in zip(at, self.joints, strict=True)
        ]
        links = [[p @ R[k].T + r[k] for k, p in ends] for ends in self.links]
        spokes = [[p - 0.5 * size * axis, p + 0.5 * size * axis] for p, axis in tips]
        return [*drawn, strokes(*links), np.reshape(shown, (-1, 3)), strokes(*spokes)]


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
