"""Variants of a bicycle: their changes, their self-stable ranges, table and bars."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mbsd3d import AngleDriver, Constant, System
from mbsd3d.errors import InputError
from mbsd3d.extend import Result, Theme, new_figure, style_axes, write_table

from ..parameters import Parameters
from . import critical
from .critical import Range

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TRAIL_SHIFT = 0.1  # [m] by which a mass or the trail is moved
Fields = dict[str, Any]  # of `Parameters` that change
NO_SPIN_R, NO_SPIN_F, NO_TRAIL = {"IRyy": 0.0}, {"IFyy": 0.0}, {"c": 0.0}
AXIS_RATIO = 1.25  # [1] length of the speed axis over the largest finite end
END_RATIO_MAX = 4.0  # [1] of the median end; a larger end is cut off, so that the others are visible
LABEL_SHARE = 0.09  # [1] of the axis: width of a number
NO_RANGE = Range(float("nan"), float("nan"))

CHANGES: dict[str, Callable[[Parameters], Fields]] = {
    "as built": lambda p: {},
    "rear wheel without spin momentum": lambda p: NO_SPIN_R,
    "front wheel without spin momentum": lambda p: NO_SPIN_F,
    "no spin momentum": lambda p: NO_SPIN_R | NO_SPIN_F,
    "no trail": lambda p: NO_TRAIL,
    "no trail, no spin momentum": lambda p: NO_TRAIL | NO_SPIN_R | NO_SPIN_F,
    "steer axis vertical, same trail": lambda p: {"lam": 0.0},
    "front mass on the steer axis": lambda p: {"xH": on_axis(p)},
    "frame and rider 0.1 m forward": lambda p: {"xB": p.xB + TRAIL_SHIFT},
    "frame and rider 0.1 m back": lambda p: {"xB": p.xB - TRAIL_SHIFT},
    "frame and rider 0.1 m up": lambda p: {"zB": p.zB - TRAIL_SHIFT},
    "frame and rider 0.1 m down": lambda p: {"zB": p.zB + TRAIL_SHIFT},
    "fork 0.1 m forward": lambda p: {"xH": p.xH + TRAIL_SHIFT},
    "fork 0.1 m back": lambda p: {"xH": p.xH - TRAIL_SHIFT},
}
"""Name -> parameters that change [SI units]. In small motions I_yy of a wheel is nothing but spin momentum."""


def on_axis(p: Parameters) -> float:
    """Return x_H [m] such that the common centre of mass of fork and front wheel lies on the steer axis."""
    if p.mH == 0.0:
        raise InputError(f"bicycle '{p.name}': the fork has no mass (mH = 0) that could be moved; give it one")
    mass = p.mH + p.mF
    height = (p.mF * p.rF - p.mH * p.zH) / mass
    return float((mass * (p.w + p.c - height * np.tan(p.lam)) - p.mF * p.w) / p.mH)


def lock(bicycle: System) -> System:
    """Return the bicycle with its steering locked."""
    driver = AngleDriver(bicycle.part("steer", "joints"), Constant(0.0), name="lock")
    return replace(bicycle, joints=[*bicycle.joints, driver])


@dataclass(frozen=True, repr=False)
class Ablation(Result):
    """Changed bicycle, and the speeds at which it is self-stable."""

    name: str  # of the change
    parameters: Parameters  # with the change
    ranges: list[Range]  # self-stable [m/s] in closed form; of the general model for round tyres
    growth: float  # fastest [1/s] at the speed of `Ablations`, negative where all motions decay
    model: list[Range] | None = None  # ranges of the general model; None if it was not asked
    confirmed: bool | None = None  # whether its spectrum agrees, see `in_spectrum`
    problem: str = ""  # why this variant is not possible; then there are no ranges and no growth
    ideal: list[Range] | None = None  # on ideal wheels, without damper and soft head, if ``ranges`` are those on tyres

    @property
    def difference(self) -> float:
        """Return the largest difference between the ends of both [m/s]; infinite if not equally many, NaN without a
        model.
        """
        return float("nan") if self.model is None else critical.difference(self.ranges, self.model)

    def __str__(self) -> str:
        return f"{self.name}: {self.problem or critical.listed(self.ranges)}"


@dataclass(frozen=True, repr=False)
class Ablations(Result):
    """Result of `ablations`; growths are those at ``speed`` [m/s]; ``missing`` counts the rows lost to Ctrl-C."""

    parameters: Parameters
    speed: float
    rows: list[Ablation]
    missing: int = 0

    def __str__(self) -> str:
        wide = max([len(self.parameters.name), *(len(row.name) for row in self.rows)])
        lines = [f"{self.parameters.name:{wide}}  {'self-stable':26}  growth [1/s] at {self.speed:.6g} m/s"]
        for row in self.rows:
            doubt = "  NOT CONFIRMED by the general model" if row.confirmed is False else ""
            ideal = "" if row.ideal is None else f"  ideal wheels: {critical.listed(row.ideal)}"
            found = f"{critical.listed(row.ranges):26}  {row.growth:12.6f}{doubt}{ideal}"
            lines.append(f"{row.name:{wide}}  {f'not possible: {row.problem}' if row.problem else found}")
        return "\n".join(lines)


def to_csv(found: Ablations, path: str | Path) -> Path:
    """Write one row per variant and range; return the file."""
    growth = f"growth at {found.speed!r} m/s [1/s]"
    head = ["variant", "low [m/s]", "high [m/s]", growth, "difference of the model [m/s]", "not possible"]
    head += ["ideal wheels low [m/s]", "ideal wheels high [m/s]"]
    rows = [
        [row.name, *part, row.growth, row.difference, row.problem, *ideal]
        for row in found.rows
        for part, ideal in zip_longest(row.ranges or [NO_RANGE], row.ideal or [NO_RANGE], fillvalue=NO_RANGE)
    ]
    return write_table(path, head, rows)


def plot_ablations(found: Ablations, *, dark: bool = False) -> "Figure":
    """Plot the self-stable ranges, one bar per variant."""
    title = f"{found.parameters.name}: at which speeds does it stay upright by itself?"
    shown = [row for row in found.rows if not row.problem]
    beside = [row.ideal for row in shown] if any(row.ideal is not None for row in shown) else []
    return plot_ranges([(row.name, row.ranges) for row in shown], title, beside=beside, dark=dark)


def plot_ranges(
    rows: Sequence[tuple[str, Sequence[Range] | None]], title: str, *, beside: Sequence[Sequence[Range] | None] = (),
    dark: bool = False,
) -> "Figure":  # fmt: skip
    """Plot self-stable ranges of several bicycles by name, a bar per range; a range that ends far out reaches the edge.

    ``beside`` has ranges of ideal wheels for the same rows, drawn as thin bars below; None = not possible.
    """
    both = [found or () for found in (*(found for _, found in rows), *beside)]
    ends = [v for found in both for part in found for v in part if np.isfinite(v)]
    near = [v for v in ends if v <= END_RATIO_MAX * np.median(ends)]
    top, room = AXIS_RATIO * max(near, default=8.0), 0.42 if beside else 0.3
    with new_figure(8.0, 1.0 + room * len(rows), dark) as (figure, look):
        axes = figure.subplots()
        style_axes(axes, look)
        axes.grid(False, axis="y")
        for k, (_, found) in enumerate(rows):
            draw_row(axes, k, found, top, look, height=0.44 if beside else 0.62)
        for k, found in enumerate(beside):
            for part in [part for part in found or () if part.low < top]:
                width = max(min(part.high, top) - part.low, 0.004 * top)
                axes.barh(k + 0.33, width, left=part.low, height=0.16, color=look.muted, linewidth=0.0)
        if beside:
            figure.suptitle("blue: on tyres, grey: on ideal wheels", x=0.99, ha="right", fontsize=9, color=look.muted)
        axes.set_yticks(range(len(rows)), [name for name, _ in rows], fontsize=9)
        axes.set_ylim(len(rows) - 0.4, -0.6)
        axes.set_xlim(0.0, top)
        axes.tick_params(axis="y", length=0)
        axes.set_xlabel("speed [m/s]")
        axes.set_title(title, loc="left")
    return figure


def draw_row(axes: "Axes", k: int, found: Sequence[Range] | None, top: float, look: Theme, *, height: float) -> None:
    """Draw the ranges of one bicycle in row k."""
    for part in found or ():
        draw_bar(axes, k, part, top, look, height)
    if not found:
        text = "not possible" if found is None else "at no speed"
        axes.text(0.01 * top, k, text, va="center", fontsize=8.5, color=look.muted)


def draw_bar(axes: "Axes", k: int, part: Range, top: float, look: Theme, height: float) -> None:
    """Draw a range in row k with its ends as numbers; both on the right where there is no room on the left."""
    high, gap = min(part.high, top), 0.008 * top
    style: dict[str, Any] = {"va": "center", "fontsize": 8.5}
    if part.low > (1.0 - LABEL_SHARE) * top:
        axes.text(top - gap, k, f"{part} →", ha="right", color=look.ink, **style)
        return
    width = max(high - part.low, 0.004 * top)  # a narrow bar is widened so that it is seen
    axes.barh(k, width, left=part.low, height=height, color=look.lines[0], linewidth=0.0)
    low, end = f"{part.low:.3f}", f"{part.high:.3f}" if np.isfinite(part.high) else "no end"
    room, inside = part.low > LABEL_SHARE * top, part.high > top
    if inside:
        axes.text(top - gap, k, end if room else f"{low} ... {end}", ha="right", color="#ffffff", **style)
    else:
        axes.text(high + gap, k, end if room else f"{low} ... {end}", ha="left", color=look.ink, **style)
    if room:
        axes.text(part.low - gap, k, low, ha="right", color=look.ink, **style)
