"""Self-stable range of a bicycle over two of its parameters, in closed form or from the general model."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mbsd3d.errors import InputError
from mbsd3d.extend import Theme, new_figure, style_axes

from ..output import collected, write_table
from ..parameters import MEANING, SYMBOL, TYRES, UNIT, Parameters, check_set
from . import critical
from .equations import checked_list
from .general import Build
from .uncertainty import variants

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class StableMap:
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
    if build is None:
        found, missing = critical.first_range(critical.polynomial(variants(parameters, (first, second), points))), 0
    else:
        found, missing = by_model(parameters, (first, second), points, build, progress)
    low, high = (np.reshape(edge, (x.size, y.size)) for edge in found)
    return StableMap(parameters, (first, second), (x, y), low, high, missing)


def by_model(
    parameters: Parameters, names: tuple[str, str], points: np.ndarray, build: Build, show: bool | None
) -> tuple[tuple[np.ndarray, np.ndarray], int]:
    """Return ((low, high) (n,) each, cells that Ctrl-C left out) from the general model at the points (2, n)."""
    n = points.shape[1]
    cells = (replace(parameters, **dict(zip(names, point, strict=True))) for point in points.T.tolist())
    solved = (critical.model_polynomial(cell, build, check=k == 0) for k, cell in enumerate(cells))
    found = collected(f"{n} bicycles", solved, n, show)
    edges = np.full_like(points, np.nan)
    if found:
        edges[:, : len(found)] = critical.first_range(critical.Quartic(*map(np.array, zip(*found, strict=True))))
    return (edges[0], edges[1]), n - len(found)


def checked_axes(parameters: Parameters, axes: Mapping[str, ArrayLike], build: Build | None) -> dict[str, np.ndarray]:
    """Return two parameters with their values, every pair of which is possible."""
    check_set(parameters, "stable_map")
    what = f"stable_map of '{parameters.name}'"
    if len(axes) != 2:
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
