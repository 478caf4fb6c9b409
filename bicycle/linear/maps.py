"""Self-stable ranges of a bicycle over one or two of its parameters, in closed form or from the general model."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mbsd3d.errors import InputError
from mbsd3d.extend import GRID_WIDTH_POINTS, LINE_WIDTH_POINTS, Result, Theme, new_figure, style_axes, write_table

from ..output import collected
from ..parameters import MEANING, SYMBOL, TYRES, UNIT, Parameters, check_set
from . import critical
from .equations import checked_list
from .general import Build
from .uncertainty import variants

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FRAME_SHARE = 0.95  # [1] quantile of the critical speeds in a figure: those that go to infinity leave the frame
FRAME_MARGIN = 1.2  # [1] of that speed: the frame ends above it


@dataclass(frozen=True, eq=False, repr=False)
class StableMap(Result):
    """Self-stable range at the lowest speeds, by cell."""

    parameters: Parameters
    names: tuple[str, str]  # symbols of the two that vary
    values: tuple[np.ndarray, np.ndarray]  # theirs, (n,) and (m,)
    low: np.ndarray  # (n, m) [m/s], NaN where no speed is self-stable
    high: np.ndarray  # infinite where nothing ends the range
    missing: int = 0  # cells that Ctrl-C left out, NaN

    def to_csv(self, path: str | Path) -> Path:
        """Write one row per cell; return the file."""
        head = [*(f"{key} [{UNIT[key]}]" for key in self.names), "low [m/s]", "high [m/s]"]
        x, y = (axis.ravel() for axis in np.meshgrid(*self.values, indexing="ij"))
        return write_table(path, head, zip(x, y, self.low.ravel(), self.high.ravel(), strict=True))

    def __str__(self) -> str:
        axes = [
            f"{key} = {x.min():g} ... {x.max():g} {UNIT[key]} ({x.size})"
            for key, x in zip(self.names, self.values, strict=True)
        ]
        found = ~np.isnan(self.low)
        lines = [f"{self.parameters.name}: {', '.join(axes)}"]
        if found.any():
            i, j = np.unravel_index(np.nanargmin(self.low), self.low.shape)
            place = f"{self.names[0]} = {self.values[0][i]:g}, {self.names[1]} = {self.values[1][j]:g}"
            lines.append(f"  lowest stable speed {self.low[i, j]:.6g} m/s at {place}")
        missing = f"; {self.missing} left out by Ctrl-C" if self.missing else ""
        lines.append(f"  self-stable at some speed in {found.sum()} of {found.size} cells{missing}")
        return "\n".join(lines)


def stable_map(
    parameters: Parameters, axes: Mapping[str, ArrayLike], build: Build | None = None, *,
    progress: bool | None = None,
) -> StableMap:  # fmt: skip
    """Solve for the self-stable range of every combination of two parameters; Ctrl-C keeps finished cells.

    Parameters
    ----------
    axes : mapping of str to (n,) array_like
        Two symbols with their values, SI units.
    build : callable, optional
        None = closed form; `bicycle.whipple` or another ``build(parameters, speed=v)`` = general model.
    progress : bool, optional
        Show a bar; None = on a terminal, after two seconds.

    Raises
    ------
    ValueError
        For anything but two parameters with finite and possible values, or crown radii without a model.
    """
    (first, x), (second, y) = checked_axes(parameters, axes, build).items()
    points = np.array([np.repeat(x, y.size), np.tile(y, x.size)])
    q, missing = polynomials(parameters, (first, second), points, build, progress)
    low, high = (np.reshape(edge, (x.size, y.size)) for edge in critical.first_range(q))
    return StableMap(parameters, (first, second), (x, y), low, high, missing)


def polynomials(
    parameters: Parameters, names: tuple[str, ...], points: np.ndarray, build: Build | None, show: bool | None
) -> tuple[critical.Quartic, int]:
    """Return (polynomials of the bicycles at the points (k, n), how many Ctrl-C left out); those are NaN."""
    if build is None:
        return critical.polynomial(variants(parameters, names, points)), 0
    n = points.shape[1]
    cells = (replace(parameters, **dict(zip(names, point, strict=True))) for point in points.T.tolist())
    solved = (critical.model_polynomial(cell, build, check=k == 0) for k, cell in enumerate(cells))
    found = collected(f"{n} bicycles", solved, n, show)
    q = critical.Quartic(*(np.full((n, *shape), np.nan) for shape in ((), (), (2,), (2,), (2,))))
    for k, one in enumerate(found):
        for whole, part in zip(q, one, strict=True):
            whole[k] = part
    return q, n - len(found)


@dataclass(frozen=True, eq=False, repr=False)
class StableSpeeds(Result):
    """Critical speeds and self-stable ranges of a bicycle over one of its parameters, as `stable_speeds` finds them."""

    parameters: Parameters
    name: str  # symbol of the parameter that varies
    values: np.ndarray  # (n,) [SI unit], rising
    weave: np.ndarray  # (n,) [m/s], NaN where it has none
    capsize: np.ndarray  # (n,) [m/s], NaN where it has none
    edges: np.ndarray  # (n, 5) speeds from 0 to infinity at which stability can change [m/s], NaN beyond
    stable: np.ndarray  # (n, 4) whether it is self-stable from one edge to the next
    missing: int = 0  # values that Ctrl-C left out, NaN

    def ranges(self, k: int) -> list[critical.Range]:
        """Return all self-stable ranges [m/s] at value k."""
        return critical.ranges_between(self.edges[k], self.stable[k])

    @property
    def low(self) -> np.ndarray:
        """Return the lowest self-stable speed [m/s], NaN where no speed is self-stable, shape (n,)."""
        return critical.first_between(self.edges, self.stable)[0]

    @property
    def high(self) -> np.ndarray:
        """Return the end of the range that begins at `low` [m/s], infinite where nothing ends it, shape (n,)."""
        return critical.first_between(self.edges, self.stable)[1]

    def figure(self, *, dark: bool = False) -> "Figure":
        """Plot weave and capsize speed over the parameter, self-stable ranges shaded."""
        return plot_speeds(self, dark=dark)

    def to_csv(self, path: str | Path) -> Path:
        """Write one row per value: weave, capsize, lowest stable speed and the end of its range; return the file."""
        head = [f"{self.name} [{UNIT[self.name]}]", *(f"{x} [m/s]" for x in ("weave", "capsize", "low", "high"))]
        table = np.column_stack([self.values, self.weave, self.capsize, self.low, self.high])
        return write_table(path, head, table)

    def __str__(self) -> str:
        first, last, unit = self.values[0], self.values[-1], UNIT[self.name]
        found = ~np.isnan(self.low)
        lines = [f"{self.parameters.name}: {self.name} = {first:g} ... {last:g} {unit}, {self.values.size} values"]
        for k in (0, self.values.size - 1):
            lines.append(f"  {self.name} = {self.values[k]:g} {unit}: stable {critical.listed(self.ranges(k))}")
        if found.any():
            k = int(np.nanargmin(self.low))
            lines.append(f"  lowest stable speed {self.low[k]:.6g} m/s at {self.name} = {self.values[k]:g} {unit}")
        stable = f"  self-stable at some speed for {found.sum()} values"
        lines.append(stable + (f"; {self.missing} left out by Ctrl-C" if self.missing else ""))
        return "\n".join(lines)


def stable_speeds(
    parameters: Parameters, name: str, values: ArrayLike, build: Build | None = None, *, progress: bool | None = None
) -> StableSpeeds:
    """Solve for the critical speeds and all self-stable ranges over one parameter; Ctrl-C keeps finished values.

    Parameters
    ----------
    name : str
        Symbol of the parameter, e.g. "c".
    values : (n,) array_like
        Its values, SI units, at least two; they are sorted.
    build : callable, optional
        None = closed form; `bicycle.whipple` or another ``build(parameters, speed=v)`` = general model.
    progress : bool, optional
        Show a bar; None = on a terminal, after two seconds.

    Returns
    -------
    StableSpeeds
        Ranges are roots of polynomials: none is lost between speeds.

    Raises
    ------
    ValueError
        For an unknown symbol, values that are not possible, or crown radii without a model.

    Examples
    --------
    >>> from bicycle import Meijaard2007, sensitivity
    >>> found = sensitivity.stable_speeds(Meijaard2007(), "c", [0.05, 0.08, 0.11])
    >>> print(found.low.round(4), found.high.round(4))
    [3.9054 4.2924 4.6046] [5.1043 6.0243 6.8527]
    """
    what = "stable_speeds"
    ((name, x),) = checked_axes(parameters, {name: values}, build, what, 1).items()
    x = np.unique(x)
    if x.size < 2:
        raise InputError(f"{what} of '{parameters.name}': one value of {name}; give two or more")
    q, missing = polynomials(parameters, (name,), x[None], build, progress)
    edges, stable = critical.intervals(q)
    return StableSpeeds(parameters, name, x, critical.weave(q), critical.capsize(q), edges, stable, missing)


def checked_axes(
    parameters: Parameters, axes: Mapping[str, ArrayLike], build: Build | None, what: str = "stable_map", count: int = 2
) -> dict[str, np.ndarray]:
    """Return ``count`` parameters with their values, every combination of which is possible."""
    check_set(parameters, what)
    what = f"{what} of '{parameters.name}'"
    if len(axes) != count:
        raise InputError(f"{what}: {len(axes)} parameters; give two, e.g. {{'c': [0.05, 0.1], 'lam': [0.2, 0.4]}}")
    found = {}
    for key, values in axes.items():
        if key not in MEANING:
            raise InputError(f"{what}: there is no parameter '{key}'; there are {', '.join(MEANING)}")
        found[key] = checked_list(values, f"{what}: values of {key}", "a list of finite numbers")
    for corner in product(*({x.min(), x.max()} for x in found.values())):  # suffice: what is possible is convex
        replace(parameters, **dict(zip(found, corner, strict=True)))
    if build is None and set(found) & set(TYRES):
        known = f"the closed form has no crown radius ({', '.join(TYRES)})"
        raise InputError(f"{what}: {known}; give build=bicycle.whipple (--model)")
    return found


def plot_map(found: StableMap, *, dark: bool = False) -> "Figure":
    """Plot the lowest self-stable speed and the width of the range over two or more values each, blank where
    unstable."""
    with new_figure(9.0, 4.2, dark) as (figure, look):
        width = np.where(np.isnan(found.low), np.nan, found.high - found.low)
        panels = figure.subplots(1, 2, sharey=True)
        for axes, values, title in zip(
            panels, (found.low, width), ("lowest self-stable speed", "width of the self-stable range"), strict=True
        ):
            style_axes(axes, look)
            axes.set_title(title)
            draw(figure, axes, found, values, look)
        panels[0].set_ylabel(label(found.names[1]))
        figure.suptitle(f"{found.parameters.name}: blank where it is self-stable at no speed", x=0.01, ha="left")
    return figure


def plot_speeds(found: StableSpeeds, *, dark: bool = False) -> "Figure":
    """Plot weave and capsize speed over one parameter; ranges that nothing ends leave the frame."""
    with new_figure(7.0, 4.4, dark) as (figure, look):
        axes = figure.subplots()
        style_axes(axes, look)
        speeds = found.edges[:, :-1]
        finite = speeds[np.isfinite(speeds) & (speeds > 0.0)]
        top = FRAME_MARGIN * float(np.quantile(finite, FRAME_SHARE)) if finite.size else 1.0
        for k, stable in enumerate(found.stable.T):
            low, high = (np.minimum(found.edges[:, k + i], 2.0 * top) for i in (0, 1))
            axes.fill_between(found.values, low, high, where=stable, color=look.good, linewidth=0.0)
        for k, name in enumerate(("weave", "capsize")):
            speed = getattr(found, name)
            axes.plot(found.values, speed, color=look.colour(k), linewidth=LINE_WIDTH_POINTS, label=name)
        here = getattr(found.parameters, found.name)
        if found.values[0] <= here <= found.values[-1]:
            axes.axvline(here, color=look.muted, linewidth=GRID_WIDTH_POINTS, linestyle="--", label="as built")
        axes.set_xlim(found.values[0], found.values[-1])
        axes.set_ylim(0.0, top)
        axes.set_xlabel(label(found.name))
        axes.set_ylabel("speed [m/s]")
        axes.set_title(f"{found.parameters.name}: self-stable speeds, shaded")
        axes.legend(frameon=False, labelcolor=look.ink)
    return figure


def label(key: str) -> str:
    """Return meaning, symbol and unit of a parameter."""
    return f"{MEANING[key]} {SYMBOL[key]} [{UNIT[key]}]"


def draw(figure: "Figure", axes: "Axes", found: StableMap, values: np.ndarray, look: Theme) -> None:
    """Draw one panel: colours up to the 95th percentile, so that a few long or endless ranges do not hide the
    others."""
    finite = values[np.isfinite(values)]
    top = (float(np.quantile(finite, 0.95)) if finite.size else 0.0) or 1.0
    shown = np.where(np.isposinf(values), 2.0 * top, values).T  # infinite ones would be left blank
    mesh = axes.pcolormesh(*found.values, shown, cmap="viridis", vmin=0.0, vmax=top, shading="nearest")
    bar = figure.colorbar(mesh, ax=axes, extend="max")
    bar.set_label("[m/s]", color=look.ink)
    bar.ax.tick_params(colors=look.ink)
    bar.outline.set_edgecolor(look.ink)
    axes.grid(False)
    first, second = found.names
    here = getattr(found.parameters, first), getattr(found.parameters, second)
    if all(x.min() <= value <= x.max() for x, value in zip(found.values, here, strict=True)):
        axes.plot(*here, "o", markersize=7, color=look.lines[1], markeredgecolor="#ffffff")
        axes.annotate(found.parameters.name, here, (6, 6), textcoords="offset points", color="#ffffff", fontsize=8)
    axes.set_xlabel(label(found.names[0]))
