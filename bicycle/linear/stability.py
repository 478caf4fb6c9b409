"""Stability of a straight run: eigenvalues over the speed, from the general model and in closed form, with a figure."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import ArrayLike

from mbsd3d import Mode
from mbsd3d.errors import InputError
from mbsd3d.extend import GRID_WIDTH_POINTS, LINE_WIDTH_POINTS, Result, Theme, checks_arguments, number

from ..model.mechanism import whipple
from ..model.tyres import Tyres
from ..output import modes_figure, write_modes
from ..parameters import Parameters
from . import on_tyres
from .critical import CriticalSpeeds, critical_speeds, speeds_of
from .equations import MODES, NAMES, canonical, checked_speeds, follow
from .general import Build, eigenvalues, linearization, required_equations

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["CriticalSpeeds", "Stability", "canonical", "critical_speeds", "eigenvalues", "figure", "study"]

REFERENCE_SPEED = 5.0  # [m/s] of critical speeds; a linearization at much lower speeds loses digits
DOT_COUNT = 34  # [1] dots of the closed form, so that the lines are seen between them
FIGURE_MODES = (0, 2, 3)  # weave (its conjugate is the mirrored line), capsize, castering


@dataclass(frozen=True, eq=False, repr=False)
class Stability(Result):
    """Modes of a bicycle over the speed, as `study` finds them; a column of ``values`` per mode, see ``names``."""

    build: Build
    parameters: Parameters
    speeds: np.ndarray  # (n,) [m/s]
    values: np.ndarray  # (n, 4) complex eigenvalues [1/s] of the general model
    vectors: np.ndarray  # (n, 4, 4) complex [speed, (lean, steer, rates), mode]
    closed: np.ndarray | None  # (n, 4) eigenvalues of the closed form by real part; None for round tyres
    critical: CriticalSpeeds  # from the general model
    names: tuple[str, ...] = NAMES

    @cached_property
    def difference(self) -> float:
        """Return the largest distance of an eigenvalue in closed form from the next of the general model [1/s]; NaN for
        none.
        """
        if self.closed is None:
            return float("nan")
        return float(np.abs(self.values[:, :, None] - self.closed[:, None, :]).min(axis=1).max())

    def mode(self, name: str, speed: float) -> Mode:
        """Return weave, capsize or castering of the general model at a speed [m/s]; ``.animate()`` shows it in
        motion."""
        check_mode(name)
        speed = number(speed, f"mode '{name}': speed")
        fastest = np.copysign(max(np.abs([*self.speeds, speed, 1.0])), speed)
        linear = required_equations(self.build, self.parameters, fastest)
        value = follow(linear, np.array([fastest, speed]))[0][1, NAMES.index(name)]
        found = linearization(self.build, self.parameters, speed)
        return min(found.modes, key=lambda mode: min(abs(mode.eigenvalue - s) for s in (value, value.conjugate())))

    def figure(self, *, dark: bool = False) -> "Figure":
        """Plot growth and frequency over the speed: lines of the general model, dots of the closed form, ranges
        shaded."""
        return figure(self, dark=dark)

    def to_csv(self, path: str | Path) -> Path:
        """Write the eigenvalues by mode [1/s] over the speed [m/s]."""
        return write_modes(path, self.names, self.speeds, self.values)

    def __str__(self) -> str:
        speeds = f"{self.speeds.size} speeds {self.speeds.min():g} ... {self.speeds.max():g} m/s"
        lines = [f"{self.parameters.name}: modes at {speeds}", str(self.critical)]
        if self.closed is not None:
            lines.append(f"general model and closed form differ by {self.difference:.1e} 1/s")
        return "\n".join(lines)


def check_mode(name: str) -> None:
    """Check the name of a mode; raise ValueError for others."""
    if name not in MODES:
        raise InputError(f"mode '{name}' is unknown; give weave, capsize or castering")


@overload
def study(parameters: Parameters, speeds: ArrayLike | None = ..., build: Build = ...) -> Stability: ...
@overload
def study(
    parameters: Parameters, speeds: ArrayLike | None = ..., build: Build = ..., *, tyres: Tyres, **fittings: float
) -> on_tyres.TyreStability: ...
@checks_arguments
def study(
    parameters: Parameters,
    speeds: ArrayLike | None = None,
    build: Build = whipple,
    *,
    tyres: Tyres | None = None,
    **fittings: float,
) -> Stability | on_tyres.TyreStability:
    """Follow the modes of a bicycle over the speed.

    Parameters
    ----------
    speeds : (n,) array_like or None
        [m/s], also negative; None = 0 ... 10 m/s.
    build : callable
        The model, see `eigenvalues`.
    tyres : mapping, pair of them or None
        As in `bicycle.whipple`; with them the modes follow from a linearisation at every speed, from 0.5 m/s on.
    **fittings : float
        Further arguments of `bicycle.whipple` for a bicycle on tyres, e.g. ``steer_damping``, ``head_stiffness``.

    Examples
    --------
    >>> from bicycle import Meijaard2007, stability
    >>> found = stability.study(Meijaard2007(), [0.0, 5.0])
    >>> found.values[1].round(5).tolist()
    [(-0.77534+4.46487j), (-0.77534-4.46487j), (-0.32287+0j), (-14.07839+0j)]
    """
    if tyres is not None:
        speeds = checked_speeds(np.linspace(0.5, 10.0, 96) if speeds is None else speeds)
        return on_tyres.study(parameters, speeds, partial(build, tyres=tyres, **fittings))
    if fittings:
        raise InputError(f"stability: {', '.join(fittings)} without tyres; give tyres, e.g. bicycle.TYPICAL")
    speeds = checked_speeds(np.linspace(0.0, 10.0, 201) if speeds is None else speeds)
    linear = required_equations(build, parameters, max(float(np.abs(speeds).max()), REFERENCE_SPEED))
    values, vectors = follow(linear, speeds)
    closed = None if parameters.tR or parameters.tF else canonical(parameters).eigenvalues(speeds)
    return Stability(build, parameters, speeds, values, vectors, closed, speeds_of(linear))


def figure(found: Stability, *, dark: bool = False) -> "Figure":
    """Plot growth and frequency of the modes over the speed."""
    title = f"{found.parameters.name}: small motions about a straight run"
    with modes_figure(title, dark) as (sheet, growth, frequency, look):
        for axes in (growth, frequency):
            shade(axes, found, look)
        lines(growth, found, look, np.real)
        lines(frequency, found, look, lambda s: np.abs(np.imag(s)))
        growth.axhline(0.0, color=look.ink, linewidth=GRID_WIDTH_POINTS)
        mark(growth, found, look)
        growth.set_ylim(*window(found))
    return sheet


def window(found: Stability) -> tuple[float, float]:
    """Return limits of the growth that matter for stability [1/s]; a fast castering mode may leave the frame."""
    real = found.values.real
    slow = real[:, :3]
    low, high = min(slow.min(), 0.0), max(slow.max(), 0.0)
    high = max(high, min(real.max(), 2.0 * high))
    margin = 0.08 * (high - low) or 1.0
    return max(real.min(), 2.0 * low) - margin, high + margin


def shade(axes: "Axes", found: Stability, look: Theme) -> None:
    """Tint the self-stable ranges of forward speeds."""
    start, end = found.speeds.min(), found.speeds.max()
    label: str | None = "self-stable"
    for part in found.critical.stable:
        if part.low < end and part.high > start:
            low, high = max(part.low, start), min(part.high, end)
            axes.axvspan(low, high, color=look.good, linewidth=0.0, zorder=0, label=label)
            label = None


def lines(axes: "Axes", found: Stability, look: Theme, part: Callable[[np.ndarray], np.ndarray]) -> None:
    """Draw lines of the general model by mode, and dots of the closed form."""
    split = np.abs(found.values.imag[:, 0]) <= 1e-9 * np.abs(found.values).max()
    split = split | np.r_[split[1:], False] | np.r_[False, split[:-1]]  # up to where they are one
    for side in (found.speeds < 0.0, found.speeds >= 0.0):  # at rest the modes get their names anew
        speeds, values = found.speeds[side], found.values[side]
        for place, k in enumerate(FIGURE_MODES):
            label = found.names[k] if side[np.argmax(found.speeds)] else None
            axes.plot(speeds, part(values[:, k]), label=label, color=look.colour(place), linewidth=LINE_WIDTH_POINTS)
        rest = np.where(split[side], part(values[:, 1]), np.nan)  # the second of two real modes that become the weave
        axes.plot(speeds, rest, color=look.colour(0), linewidth=LINE_WIDTH_POINTS)
    if found.closed is not None:
        every = max(1, found.speeds.size // DOT_COUNT)
        dots = part(found.closed[::every])
        style: dict[str, Any] = {"color": look.ink, "marker": "o", "markersize": 2.4, "linestyle": "none"}
        for k in range(4):
            axes.plot(found.speeds[::every], dots[:, k], label=None if k else "closed form (2007)", **style)


def mark(axes: "Axes", found: Stability, look: Theme) -> None:
    """Mark weave and capsize speed where they are in the frame; the lower has its name on the left, to be legible."""
    speeds = {"weave": found.critical.weave, "capsize": found.critical.capsize}
    for name, speed in speeds.items():
        if found.speeds.min() < speed < found.speeds.max():
            side = -1 if speed == np.nanmin([*speeds.values()]) else 1
            axes.axvline(speed, color=look.muted, linewidth=GRID_WIDTH_POINTS, linestyle="--")
            axes.annotate(
                f"{name} {speed:.4g} m/s", (speed, 0.99), xycoords=("data", "axes fraction"), rotation=90.0,
                ha="right" if side < 0 else "left", va="top", fontsize=8.5, color=look.muted, xytext=(2 * side, 0),
                textcoords="offset points",
            )  # fmt: skip
