"""Small motions of a bicycle on tyres about a straight run: eigenvalues over the speed, critical speeds, a figure.

Nine degrees of freedom and four deflections have 22 eigenvalues; those of what happens sideways are kept, see
`bicycle.linear.tyre_equations`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mbsd3d import Mode, linearize
from mbsd3d.errors import InputError
from mbsd3d.extend import GRID_WIDTH_POINTS, LINE_WIDTH_POINTS, Result

from ..output import modes_figure, write_modes
from ..parameters import Parameters, machines
from .critical import Range
from .equations import walk
from .tyre_equations import Affine, Build, Limit, SpeedBySpeed, eigenvalues, equations, stable_parts

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["TyreStability", "eigenvalues", "figure", "study"]

ORDINALS = ("", "second ", "third ", "fourth ", "fifth ", "sixth ", "seventh ", "eighth ")
OSCILLATION_NAMES, DECAY_NAMES = (
    ("weave", *(f"{n}wobble" for n in ORDINALS[:4])),
    ("capsize", "castering", *(f"{n}tyre decay" for n in ORDINALS)),
)
"""Enough for ten states that all oscillate, or all decay."""
MODE_ORDER = OSCILLATION_NAMES[0], *DECAY_NAMES[:2], *OSCILLATION_NAMES[1:], *DECAY_NAMES[2:]
CONJUGATE_SUFFIX = " (conjugate)"
FOOT_LENGTH = 0.3048
"""[m]"""


@dataclass(frozen=True, eq=False, repr=False)
class TyreStability(Result):
    """Lateral modes of a bicycle on tyres over the speed, as `study` finds them; a column of ``values`` per mode."""

    build: Build
    parameters: Parameters
    speeds: np.ndarray  # (n,) [m/s]
    values: np.ndarray  # (n, k) complex eigenvalues [1/s]
    limits: tuple[Limit, ...]  # between the speeds
    stable: tuple[Range, ...]  # self-stable, between the first and the last speed
    names: tuple[str, ...]

    @property
    def growth(self) -> np.ndarray:
        """Return the growth of the fastest growing mode [1/s], negative where the bicycle is self-stable, shape
        (n,)."""
        return self.values.real.max(axis=1)

    def mode(self, name: str, speed: float) -> Mode:
        """Return a mode by its name at a speed [m/s]; ``.animate()`` shows it in motion."""
        if name not in self.names:
            raise InputError(f"mode '{name}' is unknown; give one of {', '.join(self.names)}")
        if not self.speeds[0] <= speed <= self.speeds[-1]:
            raise InputError(
                f"mode '{name}' is known from {self.speeds[0]:g} to {self.speeds[-1]:g} m/s; give a speed between"
            )
        _, A = found_equations(self.build, self.parameters, self.speeds[-1])
        wanted = followed(A, np.array([speed, self.speeds[-1]]))[0][0, self.names.index(name)]
        found = linearize(self.build(self.parameters, speed=float(speed))).modes
        return min(found, key=lambda mode: min(abs(mode.eigenvalue - s) for s in (wanted, wanted.conjugate())))

    def figure(self, *, dark: bool = False) -> "Figure":
        """Plot growth and frequency of the modes over the speed, with the self-stable ranges shaded."""
        return figure(self, dark=dark)

    def to_csv(self, path: str | Path) -> Path:
        """Write the eigenvalues by mode [1/s] over the speed [m/s]."""
        return write_modes(path, self.names, self.speeds, self.values)

    def __str__(self) -> str:
        ranges = ", ".join(f"{low:.6g} ... {high:.6g} m/s" for low, high in self.stable) or "nowhere"
        lines = [f"self-stable between {self.speeds[0]:g} and {self.speeds[-1]:g} m/s: {ranges}"]
        for at in self.limits:
            lines.append(f"  {at.speed:.6g} m/s: " + (f"{at.frequency:.5g} rad/s" if at.frequency else "capsize"))
        return "\n".join(lines)


def study(parameters: Parameters, speeds: ArrayLike, build: Build) -> TyreStability:
    """Follow the lateral modes over rising speeds [m/s]; see `bicycle.stability.study`."""
    speeds = np.unique(np.asarray(speeds, float))
    if speeds.size < 2:
        raise InputError("stability on tyres: give at least two different speeds, between which limits are sought")
    direct, (linear, A) = SpeedBySpeed(build, parameters), found_equations(build, parameters, speeds[-1])
    values, names = followed(A, speeds)
    if speeds[0] > 0.0 or isinstance(linear, SpeedBySpeed):
        limits = linear.limits(speeds)
    else:  # the equations of rolling ahead are not those of rolling back
        limits = *direct.limits(np.append(speeds[speeds < 0.0], 0.0)), *linear.limits(np.array([0.0, speeds[-1]]))
    edges = [speeds[0], *(at.speed for at in limits), speeds[-1]]
    stable = tuple(stable_parts(A, edges))
    return TyreStability(build, parameters, speeds, values, limits, stable, names)


def found_equations(
    build: Build, parameters: Parameters, fastest: float
) -> tuple[Affine | SpeedBySpeed, Callable[[float], np.ndarray]]:
    """Return (equations of rolling forwards, A(v) at any speed); rolling backwards has other equations."""
    direct = SpeedBySpeed(build, parameters)
    linear = equations(build, parameters, fastest) if fastest > 0.0 else direct
    return linear, lambda speed: (linear if speed > 0.0 else direct).A(speed)


def followed(A: Callable[[float], np.ndarray], speeds: np.ndarray) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return (values with a column per mode, their names), from the fastest of rising speeds down; modes are named
    there.
    """
    here, modes = np.linalg.eig(A(speeds[-1]))
    names = named(here)
    order = sorted(
        range(len(here)),
        key=lambda k: (
            MODE_ORDER.index(names[k].removesuffix(CONJUGATE_SUFFIX)) + 0.5 * names[k].endswith(CONJUGATE_SUFFIX)
        ),
    )
    at, here, modes, values = speeds[-1], here[order].astype(complex), modes[:, order], []
    for v in speeds[::-1].tolist():
        here, modes = walk(A, at, here, modes, v)
        at = v
        values.append(here)
    return np.array(values[::-1]), tuple(names[k] for k in order)


def named(values: np.ndarray) -> list[str]:
    """Return names of modes at the fastest speed: oscillations from weave on by frequency, decays from capsize on by
    rate.
    """
    waves, decays = iter(OSCILLATION_NAMES), iter(DECAY_NAMES)
    names = [""] * len(values)
    for k in np.lexsort((-values.real, np.abs(values.imag))):
        if values[k].imag == 0.0:
            names[k] = next(decays)
        elif values[k].imag > 0.0:
            names[k] = next(waves)
            names[int(np.argmin(np.abs(values - values[k].conj())))] = names[k] + CONJUGATE_SUFFIX
    return names


def published(found: TyreStability, axes: "Sequence[Axes]", ink: str) -> None:
    """Draw printed eigenvalues of a published machine as points."""
    rows = np.array(machines().get(found.parameters.name, {}).get("printed", {"rows": []})["rows"])
    if rows.size:
        v, capsize, weave, weave_w, wobble, wobble_w = rows.T
        style: dict[str, Any] = {"color": ink, "marker": "o", "markersize": 3.5, "linestyle": "none"}
        for k, (growth, rate) in enumerate(((weave, weave_w), (wobble, wobble_w), (capsize, 0.0 * v))):
            axes[0].plot(FOOT_LENGTH * v, growth, label=None if k else "printed", **style)
            axes[1].plot(FOOT_LENGTH * v, rate, **style)


def figure(found: TyreStability, *, dark: bool = False) -> "Figure":
    """Plot growth and frequency of the lateral modes over the speed."""
    title = f"{found.parameters.name} on tyres: small motions about a straight run"
    with modes_figure(title, dark) as (sheet, growth, frequency, look):
        for axes in (growth, frequency):
            for part in found.stable:
                axes.axvspan(*part, color=look.good, linewidth=0.0, zorder=0)
        shown = [k for k, name in enumerate(found.names) if not name.endswith(CONJUGATE_SUFFIX)]
        for number, k in enumerate(shown):
            style: dict[str, Any] = {"color": look.colour(number), "linewidth": LINE_WIDTH_POINTS}
            growth.plot(found.speeds, found.values[:, k].real, label=found.names[k], **style)
            frequency.plot(found.speeds, np.abs(found.values[:, k].imag), **style)
            other = found.names[k] + CONJUGATE_SUFFIX
            if other in found.names:  # where an oscillation has split into two decays
                growth.plot(found.speeds, found.values[:, found.names.index(other)].real, **style)
        published(found, (growth, frequency), look.ink)
        growth.axhline(0.0, color=look.ink, linewidth=GRID_WIDTH_POINTS)
        for at in found.limits:
            growth.axvline(at.speed, color=look.muted, linewidth=GRID_WIDTH_POINTS, linestyle="--")
            growth.annotate(
                f"{at.speed:.4g} m/s", (at.speed, 0.99), xycoords=("data", "axes fraction"), rotation=90.0, ha="right",
                va="top", fontsize=8.5, color=look.muted,
            )  # fmt: skip
        slow = np.sort(found.values[:, shown].real, axis=1)[:, -2:]
        low, high = min(slow.min(), 0.0), max(slow.max(), 0.0)
        growth.set_ylim(low - 0.08 * (high - low), high + 0.08 * (high - low))
    return sheet
