"""Figure of a demo from its declaration: computed lines, theory as dots, the ablation dashed."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import ArrayLike

from ..base.style import COLOURS, GREY, LIGHT
from ..base.wording import relative, with_superscripts
from .panel_drawing import (
    GLOBE_VIEW,
    every,
    legend_below,
    new_figure,
    plain_decades,
    seen_side,
    space,
    spectrum_bars,
    theory_dots,
)

TIME_AXIS = "time [s]"  # label of what is drawn over the time of the run
PANELS_PER_ROW_MAX = 3  # [1] panels side by side
ABLATION_RANGE_RATIO = 6  # [1] of the computed range, beyond which an ablation leaves the picture
FLAT_RANGE_RATIO = 1e-6  # [1] of its size; a smaller range is rounding, and the line looks level


class Line(NamedTuple):
    """Further line of a panel, with theory as dots."""

    name: str
    y: ArrayLike
    x: ArrayLike | None = None  # None: that of the curve
    theory: tuple[ArrayLike, ArrayLike] | None = None


class Drawn(ABC):
    """Content of a panel: how it is drawn, and all values in it."""

    @abstractmethod
    def draw(self, axes: Axes, other: Self | None, ablated: str) -> None:
        """Draw it, and beside it the same of the ablation."""

    @property
    @abstractmethod
    def values(self) -> list[ArrayLike]:
        """Return all values that are drawn."""


@dataclass(frozen=True, eq=False)
class Curve(Drawn):
    """A computed line with theory as dots; labels have units in brackets, e.g. "time [s]"."""

    label: str
    x: ArrayLike
    y: ArrayLike
    theory: tuple[ArrayLike, ArrayLike] | None = None
    along: str = TIME_AXIS
    title: str = ""
    scale: float = 0.0  # the axis reaches as far as this to both sides of zero
    name: str = "computed"
    more: Sequence[Line] = ()
    logarithmic: bool = False
    equal: bool = False  # both axes to the same scale: a path seen from above
    colours: Sequence[int] = ()  # places in the palette of the lines, as those of the bodies they tell of; () = in turn

    @property
    def lines(self) -> list[tuple[ArrayLike, Line]]:
        """Return all lines with their x."""
        others = [(self.x if line.x is None else line.x, line) for line in self.more]
        return [(self.x, Line(self.name, self.y, theory=self.theory)), *others]

    @property
    def values(self) -> list[ArrayLike]:
        """Return x and y of all lines."""
        return [values for x, line in self.lines for values in (x, line.y)]

    def draw(self, axes: Axes, other: Self | None, ablated: str) -> None:
        """Draw the lines, those of the ablation that differ, and theory."""
        others = other.lines if other else []
        label: str | None = "theory"
        dashed: list[Line2D] = []
        for k, (x, line) in enumerate(self.lines):
            own = COLOURS[self.colours[k] if self.colours else k]
            axes.plot(x, line.y, color=own, label=line.name)
            if k < len(others):
                other_x, beside = others[k]
                if not (alike(x, other_x) and alike(line.y, beside.y)):
                    locked = still(other_x, x) and still(beside.y, line.y)  # a single point
                    style, tint = "x" if locked else "--", own if self.more else COLOURS[1]
                    dashed += axes.plot(other_x, beside.y, style, color=tint, label=None if self.more else ablated)
            if line.theory is not None:
                where, known = (np.atleast_1d(np.asarray(values, float)) for values in line.theory)
                dots = every(where.size, 25)
                theory_dots(axes, where[dots], known[dots], label)
                label = None
        if self.more and other is not None:
            axes.plot([], [], "--", color=GREY, label=ablated)
        if self.logarithmic:
            axes.set_yscale("log")
            plain_decades(axes)
        limit(axes, self, other)
        for drawn in dashed:
            end(drawn, *axes.get_ylim())
        if self.equal:
            axes.set_aspect("equal", adjustable="datalim")
        axes.set(xlabel=self.along, ylabel=self.label)
        legend_below(axes, 2 if self.more else 3)


@dataclass(frozen=True, eq=False)
class Bars(Drawn):
    """Amplitudes ``y`` at multiples ``x`` of a frequency, with theory on them, on a logarithmic axis."""

    label: str
    x: Sequence[int] | np.ndarray
    y: ArrayLike
    theory: ArrayLike
    along: str = "multiple of the shaft speed [-]"
    title: str = ""

    @property
    def values(self) -> list[ArrayLike]:
        """Return the amplitudes."""
        return [self.y]

    def draw(self, axes: Axes, other: Self | None, ablated: str) -> None:
        """Draw the bars, and those of the ablation beside them where they stand on the axis."""
        low, high = 0.3 * np.min(self.y), 3 * np.max(self.y)
        beside = [(ablated, other.y)] if other and np.min(other.y) > low else []
        spectrum_bars(axes, self.x, [("computed", self.y), *beside], self.theory)
        axes.set(xlabel=self.along, ylabel=self.label, ylim=(low, high))
        legend_below(axes, 3)


@dataclass(frozen=True, eq=False)
class Path(Drawn):
    """Paths of points (n, 3) in space: the first one ``y``, ``more`` of them, and a ``net`` behind them in grey."""

    labels: Sequence[str]  # of the three axes, with their unit
    y: ArrayLike
    title: str = ""
    name: str = "computed"
    more: Sequence[Line] = ()
    net: Sequence[np.ndarray] = ()
    box: Sequence[float] = (1.0, 1.0, 1.0)
    heights: tuple[float, float] = (-1.0, 1.0)  # least and greatest third coordinate
    globe: bool = False  # on the unit sphere, whose far side is not seen
    colours: Sequence[int] = ()  # as of a `Curve`

    @property
    def values(self) -> list[ArrayLike]:
        """Return the points of all paths."""
        return [self.y, *(line.y for line in self.more)]

    def draw(self, axes: Axes3D, other: Self | None, ablated: str) -> None:
        """Draw the paths with a dot at the start of each."""
        axes.view_init(*GLOBE_VIEW if self.globe else (25, -60))

        def shown(path: ArrayLike) -> np.ndarray:
            return seen_side(axes, path) if self.globe else np.asarray(path)

        for grey in self.net:
            axes.plot(*shown(grey).T, color=LIGHT.grid, linewidth=0.8)
        for k, line in enumerate([Line(self.name, self.y), *self.more]):
            own = COLOURS[self.colours[k] if self.colours else k]
            axes.plot(*shown(line.y).T, color=own, linewidth=1.8, label=line.name)
            axes.plot(*np.asarray(line.y)[:1].T, "o", color=own)
        if other is not None:
            axes.plot(*shown(other.y).T, "--", color=COLOURS[len(self.more) + 1], label=ablated)
        space(axes, self.labels, self.box)
        axes.set(zlim=self.heights, zticks=self.heights)
        legend_below(axes, 2)


@dataclass(frozen=True, eq=False)
class Table(Drawn):
    """Numbers ``y`` of rows by columns; those not ``good`` stand out."""

    label: str
    rows: Sequence[str]
    columns: Sequence[str]
    y: ArrayLike
    good: ArrayLike
    title: str = ""

    @property
    def values(self) -> list[ArrayLike]:
        """Return the numbers."""
        return [self.y]

    def draw(self, axes: Axes, other: Self | None, ablated: str) -> None:
        """Draw one tinted cell a number."""
        good = np.asarray(self.good)
        for (i, j), value in np.ndenumerate(np.asarray(self.y)):
            tint, weight = (LIGHT.good, "normal") if good[i, j] else (LIGHT.bad, "bold")
            axes.fill([j, j + 1, j + 1, j], [i, i, i + 1, i + 1], color=tint, edgecolor=LIGHT.paper, linewidth=2)
            axes.text(
                j + 0.5, i + 0.5, relative(value), ha="center", va="center", fontsize=8, weight=weight, color=LIGHT.ink
            )
        axes.set(xlim=(0, len(self.columns)), ylim=(len(self.rows), 0), xlabel=self.label)
        axes.set_xticks(np.arange(len(self.columns)) + 0.5, self.columns, rotation=35, ha="right", fontsize=9)
        axes.set_yticks(np.arange(len(self.rows)) + 0.5, self.rows, fontsize=9)
        axes.tick_params(length=0)
        axes.grid(False)
        axes.spines[:].set_visible(False)


class Points(NamedTuple):
    """Theory as a line over a parameter, with computed points and the one of this run."""

    curve: Curve
    computed: tuple[ArrayLike, ArrayLike]
    here: tuple[float, float]

    def draw(self, axes: Axes, *_: object) -> None:
        """Draw theory as a line here, as every point costs a run."""
        axes.plot(self.curve.x, self.curve.y, color=COLOURS[0], label="theory")
        theory_dots(axes, *self.computed, label="computed")
        axes.plot(*self.here, "o", color=COLOURS[1], label="computed here")
        axes.set(xlabel=self.curve.along, ylabel=self.curve.label)
        widen(axes, joined([self.curve.y, self.computed[1]]))
        legend_below(axes, 3)


class Panel(NamedTuple):
    """Content of a panel, the same under the ablation, and the label of the ablation."""

    drawn: Drawn | Points
    other: Drawn | None = None
    ablated: str = ""


def figure_of(title: str, panels: Sequence[Panel]) -> Figure:
    """Return the panels side by side as a figure."""
    titles = [getattr(panel.drawn, "title", "") for panel in panels]
    solid = [isinstance(panel.drawn, Path) for panel in panels]
    widths = [1.5 if isinstance(panel.drawn, Table) else 1.0 for panel in panels]
    figure, axes = new_figure(
        title, [("3d:" * three) + text for text, three in zip(titles, solid, strict=True)], widths
    )
    for place, panel in zip(axes, panels, strict=True):
        panel.drawn.draw(place, panel.other, panel.ablated)
        place.set(xlabel=with_superscripts(place.get_xlabel()), ylabel=with_superscripts(place.get_ylabel()))
    return figure


def limit(axes: Axes, curve: Curve, other: Curve | None) -> None:
    """Set the limits of the axis from computed curves: a distant ablation, or rounding, does not set its scale."""
    if curve.logarithmic:
        return
    y = joined([curve.y, *(line.y for line in curve.more)])
    y = np.concatenate([y, [-curve.scale, curve.scale] if curve.scale else []])
    span, size = np.ptp(y), np.abs(y).max()
    beside = joined([other.y]) if other is not None else np.zeros(1)
    if span <= max(FLAT_RANGE_RATIO * size, FLAT_RANGE_RATIO**2 * np.abs(beside).max()):
        widen(axes, y)
    elif curve.scale or np.ptp(beside) > ABLATION_RANGE_RATIO * span:
        axes.set_ylim(y.min() - 0.3 * span, y.max() + 0.3 * span)


def widen(axes: Axes, y: np.ndarray) -> None:
    """Give an axis that shows nothing but rounding a range by the size of its values."""
    size = np.abs(y).max(initial=0.0)
    if np.ptp(axes.get_ylim()) < FLAT_RANGE_RATIO * size:
        axes.set_ylim(y.mean() - 0.1 * size, y.mean() + 0.1 * size)


def end(line: Line2D, low: float, high: float) -> None:
    """Cut a line where it leaves the picture far, so that it does not come back into it."""
    y, far = np.array(line.get_ydata(), float), ABLATION_RANGE_RATIO * (high - low)
    gone = np.flatnonzero((y < low - far) | (y > high + far))
    if gone.size:
        y[gone[0] + 1 :] = np.nan
        line.set_ydata(y)


def still(one: ArrayLike, other: ArrayLike) -> bool:
    """Return whether a line looks constant compared with another one."""
    return bool(np.ptp(joined([one])) <= FLAT_RANGE_RATIO * np.ptp(joined([other])))


def joined(lines: Sequence[ArrayLike]) -> np.ndarray:
    """Return all finite numbers of some lines."""
    y = np.concatenate([np.ravel(np.asarray(line, float)) for line in lines])
    return y[np.isfinite(y)]


def alike(one: ArrayLike, other: ArrayLike) -> bool:
    """Return whether two lines look the same."""
    y, z = np.asarray(one, float), np.asarray(other, float)
    return y.shape == z.shape and bool(np.allclose(y, z, rtol=1e-4, atol=1e-4 * np.abs(y).max(initial=0.0)))


def same(one: Drawn, other: Drawn) -> bool:
    """Return whether two panels look the same."""
    pairs = [panel.values for panel in (one, other)]
    return len(pairs[0]) == len(pairs[1]) and all(map(alike, *pairs))
