"""Frames of a film as images: a painted scene, the time, and curves below it with a moving cursor."""

import textwrap
from collections.abc import Iterator, Sequence
from typing import TypedDict

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb

from ...base.checks import number, whole
from ...base.errors import InputError
from ...base.figure import Figure
from ...base.style import Theme, figure_style, style_axes, theme
from ...mechanism.bodies import Body, Ground
from ...plotting.panels import Wanted
from ...results.motion import Motion
from ..picture.painter import new_sheet
from ..picture.picture import painter_of, picture_layers
from ..picture.shading import pointers_of
from ..scene.camera import followed_body
from ..scene.drawing import ARROWS, USUAL_LAYERS, Layers
from ..scene.frames import FILM_SECONDS, REAL_TIME_SECONDS_MAX, frames_of, sensible_speed
from ..scene.overlays import Curve, Points, arrows_of, curves_of, traces_of

PAPER_WIDTH_MAX = 7.2  # [inch] of a frame; a film of more than 720 pixels has finer lines, not smaller letters
PLOT_HEIGHT_SHARE = 0.27  # [1] of the width: height of a plot below the scene
PLOT_WIDTH_MIN = 320  # [pixel] of a plot
FRAMES_MAX, PIXELS_MAX = 5000, 4096  # [frames] of a film, [pixel] of a side
TRIANGLE_PIXELS_MAX = 31.0  # [pixel] of the longest triangle or stroke, about
PATH_POINTS_MIN = 400  # [points] of a path
EXTENT_POSES_COUNT = 60  # [poses] from which the extent of the motion is found


class FilmOptions(TypedDict, total=False):
    """Options of a film besides its frames per second; see `Solution.export_gif`."""

    speed: float | None
    width: int
    height: int | None
    curves: Wanted | None
    traces: Points | None
    layers: Layers
    view: Sequence[float] | None
    dark: bool
    follow: Body | Ground | str | None


def paced(t: np.ndarray, fps: float, speed: float | None, usual: tuple[float, float]) -> tuple[float, float, int]:
    """Check and return (frames per second, model time per real time, number of frames)."""
    if t.size < 2 or t[-1] <= t[0]:
        raise InputError("a film needs motion, this has one moment only; run it longer, or use solution.picture")
    fps, span = number(fps, "fps", positive=True), float(t[-1] - t[0])
    speed = sensible_speed(span, *usual) if speed is None else number(speed, "speed", positive=True)
    count = round(span * fps / speed) + 1
    if not 2 <= count <= FRAMES_MAX:
        raise InputError(
            f"speed: {span:g} s at speed {speed:g} and {fps:g} frames per second make {count} frames, "
            f"not 2 ... {FRAMES_MAX}; give another speed"
        )
    return fps, speed, count


class FilmFrames:
    """Frames of a film, (height, width, 3) uint8, and its size; options as `Solution.export_mp4`.

    ``usual``: if the speed is not given, the longest run shown in real time, and the length of any other film [s].
    """

    def __init__(
        self,
        motion: Motion,
        *,
        fps: float = 25,
        speed: float | None = None,
        width: int = 480,
        height: int | None = None,
        curves: Wanted | None = (),
        traces: Points | None = None,
        layers: Layers = USUAL_LAYERS,
        view: Sequence[float] | None = None,
        dark: bool = False,
        follow: Body | Ground | str | None = None,
        usual: tuple[float, float] = (REAL_TIME_SECONDS_MAX, FILM_SECONDS),
    ) -> None:
        self.fps, self.speed, count = paced(motion.t, fps, speed, usual)
        self.width = whole(width, "width", 64, PIXELS_MAX)
        rows = round(0.75 * self.width / 2) * 2 if height is None else whole(height, "height", 64, PIXELS_MAX)
        self.dpi = max(100.0, self.width / PAPER_WIDTH_MAX)
        self.sheet = theme(dark)
        visible = picture_layers(motion.system, layers, moving=True)
        kinds = set(ARROWS) & set(visible)
        self.frames = frames_of(motion, count)
        self.finer = -(-PATH_POINTS_MIN // (count - 1))  # points of a path per frame, so that few frames leave it round
        fine = frames_of(motion, self.finer * (count - 1) + 1)
        self.traces = traces_of(motion, fine, traces) if "traces" in visible else []
        self.vectors = [x for x in arrows_of(motion, self.frames) if x.kind in kinds] if kinds else []
        some = np.unique(np.linspace(0, count - 1, EXTENT_POSES_COUNT).astype(int))
        r, e = self.frames.r[some], self.frames.e[some]
        followed = followed_body(motion, follow)
        self.way = self.frames.r[:, followed] - self.frames.r[0, followed]  # of the camera; -1 is the ground
        inches = (self.width / self.dpi, rows / self.dpi)
        self.painter, self.reach = painter_of(
            motion.system, r, e, inches, paths=self.traces, vectors=self.vectors, layers=visible, view=view, dark=dark,
            fine=max(0.03, TRIANGLE_PIXELS_MAX / self.width), near=followed >= 0,
        )  # fmt: skip
        found = curves_of(motion, self.frames, curves)
        if found and self.width < PLOT_WIDTH_MIN:
            raise InputError(f"width = {self.width} is too small for curves; give at least {PLOT_WIDTH_MIN}")
        self.strip = Strip(found, self.frames.t, self.width, self.dpi, self.sheet) if found else None
        self.height = rows + (self.strip.height if self.strip else 0)

    def __len__(self) -> int:
        return self.frames.t.size

    def __iter__(self) -> Iterator[np.ndarray]:
        return (self.frame(k) for k in range(len(self)))

    def frame(self, k: int) -> np.ndarray:
        """Return frame k as an image (height, width, 3)."""
        with figure_style(self.sheet):
            figure, axes = new_sheet(self.painter.inches, self.sheet)
            figure.set_dpi(self.dpi)
            painter = self.painter.gone(self.way[k])
            painter.paint(
                axes,
                [(self.frames.r[k], self.frames.e[k])],
                traces=[trace._replace(points=trace.points[: self.finer * k + 1]) for trace in self.traces],
                arrows=[pointers_of(x, k, self.reach, painter.lens) for x in self.vectors],
            )
            painter.write_note(axes, self.clock(k))
            scene = pixels(figure)
        return scene if self.strip is None else np.concatenate([scene, self.strip.at(k)])

    def clock(self, k: int) -> str:
        """Return the time with as many digits as the steps need, and the speed if it is not 1."""
        t = self.frames.t
        digits = max(0, int(np.ceil(-np.log10(t[1] - t[0]))))
        rate = "" if self.speed == 1.0 else f"   ({self.speed:g}× speed)"
        return f"t = {t[k]:.{digits}f} s{rate}"


class Strip:
    """Curves over time as one image, on which the cursor moves."""

    def __init__(self, curves: Sequence[Curve], t: np.ndarray, width: int, dpi: float, sheet: Theme) -> None:
        self.height = round(PLOT_HEIGHT_SHARE * width * len(curves) / 2) * 2
        self.sheet, self.pen = sheet, max(1, round(dpi / 100))
        with figure_style(sheet):
            figure = Figure(figsize=(width / dpi, self.height / dpi), dpi=dpi, layout="constrained")
            figure.set_facecolor(sheet.paper)
            panels = figure.subplots(len(curves), 1, sharex=True, squeeze=False)[:, 0]
            for axes, curve in zip(panels, curves, strict=True):
                style_axes(axes, sheet)
                for i, (name, values) in enumerate(curve.lines):
                    axes.plot(t, values, color=sheet.colour(i), linewidth=1.2, label=name)
                axes.set_ylabel("\n".join([*textwrap.wrap(curve.label, 18), f"[{curve.unit}]"]), fontsize=7)
                axes.tick_params(labelsize=7)
                axes.locator_params(axis="y", nbins=4)
                axes.margins(x=0.01)
                low, high = (f([f(values) for _, values in curve.lines]) for f in (np.nanmin, np.nanmax))
                if high - low < 1e-9 * curve.size:  # rounding is not magnified
                    axes.set_ylim(low - 0.05 * curve.size, high + 0.05 * curve.size)
                if len(curve.lines) > 1:
                    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=7)
            panels[-1].set_xlabel("time [s]", fontsize=7)
            self.image = pixels(figure)
        self.boxes = [axes.bbox.extents for axes in panels]
        self.columns = np.rint(panels[0].transData.transform(np.column_stack([t, 0.0 * t]))[:, 0]).astype(int)
        self.dots = [
            (to_rgb(sheet.colour(i)), self.height - axes.transData.transform(np.column_stack([t, values]))[:, 1])
            for axes, curve in zip(panels, curves, strict=True)
            for i, (_, values) in enumerate(curve.lines)
        ]

    def at(self, k: int) -> np.ndarray:
        """Return the image with the cursor at a frame: a line, and a dot on every curve."""
        image, x, half = self.image.copy(), self.columns[k], 3 * self.pen
        for _, low, _, high in self.boxes:
            rows = slice(round(self.height - high), round(self.height - low))
            image[rows, x : x + self.pen] = np.round(255 * np.array(to_rgb(self.sheet.muted)))
        for tint, heights in self.dots:
            y = round(heights[k])
            across, down = np.meshgrid(np.arange(x - half, x + half + 1), np.arange(y - half, y + half + 1))
            inside = np.hypot(across - x, down - y) <= half
            inside &= (down >= 0) & (down < image.shape[0]) & (across >= 0) & (across < image.shape[1])
            image[down[inside], across[inside]] = np.round(255 * np.array(tint))
        return image


def pixels(figure: Figure) -> np.ndarray:
    """Return the pixels (height, width, 3) uint8 of a figure at its own resolution."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()  # type: ignore[no-untyped-call]  # of matplotlib
    return np.array(canvas.buffer_rgba())[..., :3]  # type: ignore[no-untyped-call]
