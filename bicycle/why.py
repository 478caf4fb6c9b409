"""Why a bicycle stays upright: take something away, or move it, and see at which speeds it still does.

Ranges are roots of polynomials, see `bicycle.critical`: none is too narrow to be found. The general model confirms
them: its linear equations give the same ranges, and its fastest growth changes sign within 1e-6 m/s of every end.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import click

from . import critical
from .ablation import Ablation, ablated, locked, quartic_of
from .general import Build
from .models import whipple
from .options import bicycle_argument, out_option
from .parameters import Parameters
from .sheet import write_table
from .variants import CHANGES, two_mass_skate
from .waiting import collected


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
            found = f"{stable:26}  {row.growth:12.6f}{doubt}"
            lines.append(f"{row.name:{wide}}  {f'not possible: {row.problem}' if row.problem else found}")
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
        For a bicycle without two freedoms, or round tyres without a model.

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
    """A variant, or why this bicycle has none."""
    try:
        variant = replace(parameters, **CHANGES[name](parameters), name=f"{parameters.name}, {name}")
        return ablated(name, variant, build, speed)
    except ValueError as error:
        return Ablation(name, parameters, [], float("nan"), problem=str(error))


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
    return plot_ranges([(row.name, row.ranges) for row in found.rows if not row.problem], title, dark=dark)


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
    from mbsd3d.cli.support import INTERRUPTED, Failure, ready_folder
    from mbsd3d.plotting.plots import save_figure

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
        "not possible",
    ]
    rows = [
        [row.name, low, high, row.growth, row.difference, row.problem]
        for row in found.rows
        for low, high in row.ranges or [(float("nan"), float("nan"))]
    ]
    return write_table(path, head, rows)
