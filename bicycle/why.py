"""Why a bicycle stays upright: take something away, or move it, and see at which speeds it still does.

Ranges are roots of polynomials, see `bicycle.critical`: none is too narrow to be found. The general model confirms
them: its linear equations give the same ranges, and its fastest growth changes sign within 1e-6 m/s of every end.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import click
import numpy as np

from mbsd3d import AngleDriver, Constant, System, linearize, measures
from mbsd3d.progress import Progress

from . import characteristic, critical
from .critical import Range
from .equations import canonical
from .general import Build, linearization
from .models import whipple
from .options import bicycle_argument, out_option
from .parameters import Parameters
from .sheet import write_table
from .variants import CHANGES, two_mass_skate

STEP = 1e-6
"""[m/s] on both sides of an end, where the fastest growth must have opposite signs."""


@dataclass(frozen=True)
class Ablation:
    """A bicycle with something changed.

    Attributes
    ----------
    name : str
        What is changed.
    parameters : Parameters
        With the change.
    ranges : list of Range
        Self-stable speeds [m/s] in closed form; of the general model for round tyres.
    growth : float
        Fastest growth [1/s] at the speed of `Ablations`, negative where all motions decay.
    model : list of Range or None
        The ranges of the general model; None if it was not asked.
    confirmed : bool or None
        Whether its growth changes sign at every end, and, with locked steering, is the same.
    """

    name: str
    parameters: Parameters
    ranges: list[Range]
    growth: float
    model: list[Range] | None = None
    confirmed: bool | None = None

    @property
    def difference(self) -> float:
        """Largest difference between the ends of both [m/s]; infinite where they do not match, NaN without a model."""
        return float("nan") if self.model is None else critical.difference(self.ranges, self.model)


@dataclass(frozen=True)
class Ablations:
    """What `ablations` found; growths are those at ``speed`` [m/s]; ``missing`` rows Ctrl-C left out."""

    parameters: Parameters
    speed: float
    rows: list[Ablation]
    missing: int = 0

    def __str__(self) -> str:
        wide = max([len(self.parameters.name), *(len(row.name) for row in self.rows)])
        lines = [f"{self.parameters.name:{wide}}  {'self-stable':26}  growth [1/s] at {self.speed:.6g} m/s"]
        for row in self.rows:
            doubt = "  NOT CONFIRMED by the general model" if row.confirmed is False else ""
            stable = ", ".join(map(str, row.ranges)) or "at no speed"
            lines.append(f"{row.name:{wide}}  {stable:26}  {row.growth:12.6f}{doubt}")
        return "\n".join(lines)


def ablations(parameters: Parameters, build: Build | None = whipple, *, progress: bool | None = None) -> Ablations:
    """Self-stable ranges of a bicycle, of its variants (`bicycle.variants`), with locked steering, of a two-mass skate.

    Parameters
    ----------
    parameters : Parameters
    build : callable or None
        The general model that is to confirm them; None = closed form alone.
    progress : bool, optional
        Show a bar; None = on a terminal, after two seconds.

    Returns
    -------
    Ablations
        After Ctrl-C with the rows that were finished.

    Raises
    ------
    ValueError
        For a variant that is no bicycle, or round tyres without a model.

    Examples
    --------
    >>> from bicycle import Meijaard2007
    >>> found = ablations(Meijaard2007(), None)
    >>> print(*{row.name: row.ranges for row in found.rows}["no trail"])
    2.933073 ... 3.128986 m/s
    """
    todo = [
        (name, replace(parameters, **change(parameters), name=f"{parameters.name}, {name}"))
        for name, change in CHANGES.items()
    ]
    rows: list[Ablation] = []
    speed = critical.typical_speed(critical.ranges(quartic_of(parameters, build)))
    with Progress(f"variants of {parameters.name}", 0, len(todo) + 2, progress) as bar:
        try:
            for name, variant in todo:
                rows.append(ablated(name, variant, build, speed))
                bar.update(len(rows))
            rows.append(locked(parameters, build, speed))
            rows.append(ablated("two-mass skate: no trail, no spin", two_mass_skate(), build, speed))
        except KeyboardInterrupt:
            return Ablations(parameters, speed, rows, len(todo) + 2 - len(rows))
    return Ablations(parameters, speed, rows)


def round_tyres(parameters: Parameters) -> bool:
    """Which the closed form does not know."""
    return bool(parameters.tR or parameters.tF)


def quartic_of(parameters: Parameters, build: Build | None) -> critical.Quartic:
    """In closed form; of the general model for round tyres."""
    if build is not None and round_tyres(parameters):
        return characteristic.of_model(parameters, build)
    return characteristic.of(parameters)


def ablated(name: str, parameters: Parameters, build: Build | None, speed: float) -> Ablation:
    """Ranges of a bicycle, confirmed by a model."""
    q = quartic_of(parameters, build)
    found = Ablation(name, parameters, critical.ranges(q), fastest(q, speed))
    if build is None:
        return found
    ends = [v for part in found.ranges for v in part if 0.0 < v < np.inf]
    sides = [growth(build, parameters, v - STEP) * growth(build, parameters, v + STEP) < 0.0 for v in ends]
    model = critical.ranges(characteristic.of_model(parameters, build))
    return replace(found, model=model, confirmed=all(sides) and len(model) == len(found.ranges))


def fastest(q: critical.Quartic, v: float) -> float:
    """Largest real part [1/s] of the roots at a speed."""
    c, d, e = (critical.value(x, v * v) for x in (q.c, q.d, q.e))
    return float(np.roots([q.a, q.b * v, c, d * v, e]).real.max())


def growth(build: Build, parameters: Parameters, speed: float) -> float:
    """Largest real part [1/s] of the spectrum of the general model."""
    return float(linearization(build, parameters, speed).eigenvalues.real.max())


def locked(parameters: Parameters, build: Build | None, speed: float) -> Ablation:
    """Only lean is left: a pendulum upside down, which falls at any speed with +-sqrt(-g K0_11 / M_11)."""
    name, falls = "steering locked", []
    if build is None or not round_tyres(parameters):
        linear = canonical(parameters)
        falls.append(float(np.sqrt(-linear.g * linear.K0[0, 0] / linear.M[0, 0])))
    if build is not None:
        falls.append(falling(build(parameters, speed=speed)))
    if len(falls) == 1:
        return Ablation(name, parameters, [], falls[0], model=None if build is None else [])
    return Ablation(name, parameters, [], falls[0], [], abs(falls[1] - falls[0]) < STEP * falls[0])


def falling(bicycle: System) -> float:
    """Growth [1/s] of the lean of a bicycle whose steering is held."""
    frame, steer = bicycle.part("frame"), bicycle.part("steer", "joints")
    held = replace(bicycle, joints=[*bicycle.joints, AngleDriver(steer, Constant(0.0), name="lock")])
    return float(linearize(held, outputs=[measures.lean(frame), measures.lean_rate(frame)]).eigenvalues.real.max())


def plot_ablations(found: Ablations, *, dark: bool = False) -> Any:
    """Figure of the self-stable ranges, one bar per variant.

    Parameters
    ----------
    found : Ablations
    dark : bool
        On dark paper.

    Returns
    -------
    matplotlib.figure.Figure
    """
    from .range_figure import plot_ranges

    title = f"{found.parameters.name}: at which speeds does it stay upright by itself?"
    return plot_ranges([(row.name, row.ranges) for row in found.rows], title, dark=dark)


@click.command()
@bicycle_argument
@click.option("--closed-form", is_flag=True, help="Do not confirm the ranges by the general model (faster).")
@click.option("--dark", is_flag=True, help="Figure on dark paper.")
@out_option
def command(parameters: Parameters, closed_form: bool, dark: bool, out: str) -> None:
    """Why it stays upright: spin, trail, masses taken away or moved, steering locked.

    Prints the self-stable ranges [m/s] of each variant and how fast it falls at one speed; writes a figure and a table
    (.csv). The exit code is 1 if the general model does not confirm a range. Next: mbsd3d bicycle sensitivity
    """
    from mbsd3d.commands import INTERRUPTED, Failure, ready_folder
    from mbsd3d.plots import save_figure

    folder = ready_folder(out)
    found = ablations(parameters, None if closed_form else whipple)
    if not found.rows:
        raise Failure("interrupted before a variant was finished")
    click.echo(str(found))
    target = folder / f"why_{parameters.name}"
    for path in (*save_figure(plot_ablations(found, dark=dark), target), to_csv(found, target)):
        click.echo(str(path))
    if found.missing:
        click.echo(f"mbsd3d: interrupted, {found.missing} variants are missing", err=True)
        raise click.exceptions.Exit(INTERRUPTED)
    if any(row.confirmed is False for row in found.rows):
        click.echo("mbsd3d: general model and closed form disagree", err=True)
        raise click.exceptions.Exit(1)


def to_csv(found: Ablations, path: str | Path) -> Path:
    """One row per variant and range; returns the file."""
    head = [
        "variant",
        "low [m/s]",
        "high [m/s]",
        f"growth at {found.speed!r} m/s [1/s]",
        "difference of the model [m/s]",
    ]
    rows = [
        [row.name, low, high, row.growth, row.difference]
        for row in found.rows
        for low, high in row.ranges or [(float("nan"), float("nan"))]
    ]
    return write_table(path, head, rows)
