"""Why a bicycle stays upright: take something away, or move it, and see at which speeds it still does.

Ranges are roots of polynomials, see `bicycle.critical`: none is too narrow to be found. The general model confirms
them: its linear equations give the same ranges, and its fastest growth changes sign within 1e-6 m/s of every end.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial import Polynomial

from mbsd3d import AngleDriver, Constant, System, linearize, measures
from mbsd3d.errors import InputError
from mbsd3d.extend import Theme, dress

from ..model.mechanism import whipple
from ..output import collected, new_figure, write_table
from ..parameters import Parameters, named
from . import critical
from .critical import Quartic, Range
from .equations import canonical
from .general import Build, linearization

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHIFT = 0.1  # [m]
NO_SPIN_R, NO_SPIN_F, NO_TRAIL = {"IRyy": 0.0}, {"IFyy": 0.0}, {"c": 0.0}
STEP = 1e-6
"""[m/s] on both sides of an end, where the fastest growth must have opposite signs; and [1/s] between equal growths."""
ROOM = 1.25  # of the speed axis, over the largest finite end
ROOM_OF_LABEL = 0.09  # of the axis, that a number takes

CHANGES: dict[str, Callable[[Parameters], dict[str, float]]] = {
    "as built": lambda p: {},
    "rear wheel without spin momentum": lambda p: NO_SPIN_R,
    "front wheel without spin momentum": lambda p: NO_SPIN_F,
    "no spin momentum": lambda p: NO_SPIN_R | NO_SPIN_F,
    "no trail": lambda p: NO_TRAIL,
    "no trail, no spin momentum": lambda p: NO_TRAIL | NO_SPIN_R | NO_SPIN_F,
    "steer axis vertical, same trail": lambda p: {"lam": 0.0},
    "front mass on the steer axis": lambda p: {"xH": on_axis(p)},
    "frame and rider 0.1 m forward": lambda p: {"xB": p.xB + SHIFT},
    "frame and rider 0.1 m back": lambda p: {"xB": p.xB - SHIFT},
    "frame and rider 0.1 m up": lambda p: {"zB": p.zB - SHIFT},
    "frame and rider 0.1 m down": lambda p: {"zB": p.zB + SHIFT},
    "fork 0.1 m forward": lambda p: {"xH": p.xH + SHIFT},
    "fork 0.1 m back": lambda p: {"xH": p.xH - SHIFT},
}
"""Name -> parameters that change [SI units]. In small motions I_yy of a wheel is nothing but spin momentum."""


def on_axis(p: Parameters) -> float:
    """x_H [m] such that the common centre of mass of fork and front wheel lies on the steer axis."""
    if p.mH == 0.0:
        raise InputError(f"bicycle '{p.name}': the fork has no mass (mH = 0) that could be moved; give it one")
    mass = p.mH + p.mF
    height = (p.mF * p.rF - p.mH * p.zH) / mass
    return float((mass * (p.w + p.c - height * np.tan(p.lam)) - p.mF * p.w) / p.mH)


def two_mass_skate() -> Parameters:
    """Two point masses on skates, with neither trail nor spin momentum; the tilt of 5 degrees to all digits."""
    return replace(named("Tms"), lam=np.pi / 36.0, name="two-mass skate")


@dataclass(frozen=True)
class Ablation:
    """A bicycle with something changed, and at which speeds it is self-stable."""

    name: str  # of the change
    parameters: Parameters  # with the change
    ranges: list[Range]  # self-stable [m/s] in closed form; of the general model for round tyres
    growth: float  # fastest [1/s] at the speed of `Ablations`, negative where all motions decay
    model: list[Range] | None = None  # ranges of the general model; None if it was not asked
    confirmed: bool | None = None  # whether its spectrum agrees, see `in_spectrum`
    problem: str = ""  # why this variant is not possible; then there are no ranges and no growth

    @property
    def difference(self) -> float:
        """Largest difference between the ends of both [m/s]; infinite if not equally many, NaN without a model."""
        return float("nan") if self.model is None else critical.difference(self.ranges, self.model)


def quartic_of(parameters: Parameters, build: Build | None) -> Quartic:
    """In closed form; of the general model for round tyres, which the closed form does not know."""
    if build is not None and (parameters.tR or parameters.tF):
        return critical.model_polynomial(parameters, build)
    return critical.polynomial(parameters)


def ablated(name: str, parameters: Parameters, build: Build | None, speed: float) -> Ablation:
    """Ranges of a bicycle, confirmed by a model."""
    q = quartic_of(parameters, build)
    found = Ablation(name, parameters, critical.ranges(q), fastest(q, speed))
    if build is None:
        return found
    model = critical.ranges(critical.model_polynomial(parameters, build))
    return replace(found, model=model, confirmed=len(model) == len(found.ranges) and in_spectrum(found, build, speed))


def in_spectrum(found: Ablation, build: Build, speed: float) -> bool:
    """Whether the spectrum of the model has the same fastest growth, which changes sign at every end of a range."""

    def growth(v: float) -> float:
        A = linearization(build, found.parameters, v).A  # its own spectrum rounds small values to zero
        return float(np.linalg.eigvals(A).real.max())

    ends = [v for part in found.ranges for v in part if 0.0 < v < np.inf]
    alike = abs(growth(speed) - found.growth) < STEP * max(1.0, abs(found.growth))
    return alike and all(growth(v - STEP) * growth(v + STEP) < 0.0 for v in ends)


def fastest(q: Quartic, v: float) -> float:
    """Largest real part [1/s] of the roots at a speed."""
    return float(Polynomial(q.at(v)).roots().real.max())


def locked(parameters: Parameters, build: Build | None, speed: float) -> Ablation:
    """Only lean is left: an inverted pendulum, which falls at any speed with +-sqrt(-g K0_11 / M_11)."""
    name, falls = "steering locked", []
    if build is None or not (parameters.tR or parameters.tF):
        linear = canonical(parameters)
        falls.append(float(np.sqrt(-linear.g * linear.K0[0, 0] / linear.M[0, 0])))
    if build is not None:
        falls.append(falling(build(parameters, speed=speed)))
    confirmed = abs(falls[1] - falls[0]) < STEP * falls[0] if len(falls) == 2 else None
    return Ablation(name, parameters, [], falls[0], None if build is None else [], confirmed)


def falling(bicycle: System) -> float:
    """Growth [1/s] of the lean of a bicycle whose steering is held."""
    frame, steer = bicycle.part("frame"), bicycle.part("steer", "joints")
    held = replace(bicycle, joints=[*bicycle.joints, AngleDriver(steer, Constant(0.0), name="lock")])
    return float(linearize(held, outputs=[measures.lean(frame), measures.lean_rate(frame)]).eigenvalues.real.max())


@dataclass(frozen=True)
class Ablations:
    """What `ablations` found; growths are those at ``speed`` [m/s]; ``missing`` counts the rows lost to Ctrl-C."""

    parameters: Parameters
    speed: float
    rows: list[Ablation]
    missing: int = 0

    def __str__(self) -> str:
        wide = max([len(self.parameters.name), *(len(row.name) for row in self.rows)])
        lines = [f"{self.parameters.name:{wide}}  {'self-stable':26}  growth [1/s] at {self.speed:.6g} m/s"]
        for row in self.rows:
            doubt = "  NOT CONFIRMED by the general model" if row.confirmed is False else ""
            found = f"{critical.listed(row.ranges):26}  {row.growth:12.6f}{doubt}"
            lines.append(f"{row.name:{wide}}  {f'not possible: {row.problem}' if row.problem else found}")
        return "\n".join(lines)


def ablations(parameters: Parameters, build: Build | None = whipple, *, progress: bool | None = None) -> Ablations:
    """Self-stable ranges of a bicycle, of its variants (`CHANGES`), with locked steering, and of a two-mass skate.

    Parameters
    ----------
    build : callable or None
        The general model that must confirm them; None = closed form alone.
    progress : bool, optional
        Show a bar; None = on a terminal, after two seconds.

    Examples
    --------
    >>> from bicycle import Meijaard2007
    >>> found = ablations(Meijaard2007(), None)
    >>> print(*{row.name: row.ranges for row in found.rows}["no trail"])
    2.933073 ... 3.128986 m/s
    """
    speed, count = critical.typical_speed(critical.ranges(quartic_of(parameters, build))), len(CHANGES) + 2
    rows = collected(f"variants of {parameters.name}", one_by_one(parameters, build, speed), count, progress)
    return Ablations(parameters, speed, rows, count - len(rows))


def one_by_one(parameters: Parameters, build: Build | None, speed: float) -> Iterator[Ablation]:
    """The variants, the bicycle with locked steering, and a two-mass skate."""
    for name in CHANGES:
        yield changed(parameters, name, build, speed)
    yield locked(parameters, build, speed)
    yield ablated("two-mass skate: no trail, no spin", two_mass_skate(), build, speed)


def changed(parameters: Parameters, name: str, build: Build | None, speed: float) -> Ablation:
    """A variant, or why it is not possible for this bicycle."""
    try:
        variant = replace(parameters, **CHANGES[name](parameters), name=f"{parameters.name}, {name}")
        return ablated(name, variant, build, speed)
    except ValueError as error:
        return Ablation(name, parameters, [], float("nan"), problem=str(error))


def to_csv(found: Ablations, path: str | Path) -> Path:
    """One row per variant and range; returns the file."""
    growth = f"growth at {found.speed!r} m/s [1/s]"
    head = ["variant", "low [m/s]", "high [m/s]", growth, "difference of the model [m/s]", "not possible"]
    rows = [
        [row.name, low, high, row.growth, row.difference, row.problem]
        for row in found.rows
        for low, high in row.ranges or [(float("nan"), float("nan"))]
    ]
    return write_table(path, head, rows)


def plot_ablations(found: Ablations, *, dark: bool = False) -> "Figure":
    """Figure of the self-stable ranges, one bar per variant."""
    title = f"{found.parameters.name}: at which speeds does it stay upright by itself?"
    return plot_ranges([(row.name, row.ranges) for row in found.rows if not row.problem], title, dark=dark)


def plot_ranges(rows: Sequence[tuple[str, Sequence[Range]]], title: str, *, dark: bool = False) -> "Figure":
    """Self-stable ranges of several bicycles by name, a bar per range; one that nothing ends reaches the edge."""
    ends = [v for _, found in rows for part in found for v in part if np.isfinite(v)]
    top = ROOM * max(ends, default=8.0)
    with new_figure(8.0, 1.0 + 0.3 * len(rows), dark) as (figure, look):
        axes = figure.subplots()
        dress(axes, look)
        axes.grid(False, axis="y")
        for k, (_, found) in enumerate(rows):
            for part in found:
                draw_bar(axes, k, part, top, look)
            if not found:
                axes.text(0.01 * top, k, "at no speed", va="center", fontsize=8.5, color=look.muted)
        axes.set_yticks(range(len(rows)), [name for name, _ in rows], fontsize=9)
        axes.set_ylim(len(rows) - 0.4, -0.6)
        axes.set_xlim(0.0, top)
        axes.tick_params(axis="y", length=0)
        axes.set_xlabel("speed [m/s]")
        axes.set_title(title, loc="left")
    return figure


def draw_bar(axes: "Axes", k: int, part: Range, top: float, look: Theme) -> None:
    """A range in row k with its ends as numbers; both on the right where there is no room on the left."""
    high, gap = min(part.high, top), 0.008 * top
    width = max(high - part.low, 0.004 * top)  # a narrow bar is widened so that it is seen
    axes.barh(k, width, left=part.low, height=0.62, color=look.lines[0], linewidth=0.0)
    style = {"va": "center", "fontsize": 8.5}
    low, end = f"{part.low:.3f}", f"{part.high:.3f}" if np.isfinite(part.high) else "no end"
    room, inside = part.low > ROOM_OF_LABEL * top, not np.isfinite(part.high)
    if inside:
        axes.text(top - gap, k, end if room else f"{low} ... {end}", ha="right", color="#ffffff", **style)
    else:
        axes.text(high + gap, k, end if room else f"{low} ... {end}", ha="left", color=look.ink, **style)
    if room:
        axes.text(part.low - gap, k, low, ha="right", color=look.ink, **style)
