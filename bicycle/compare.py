"""Several bicycles on one page: what they are, at which speeds they stay upright by themselves, how they look and move.

The page (``index.html``) needs no network; a few of the bicycles have a page of their own with the weave mode in motion
(``views/``), about 0.8 MB each. Critical speeds are those of the closed form, confirmed by the general model; round
tyres have the general model alone.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import click

from . import critical, stability
from .models import whipple
from .options import out_option
from .parameters import Meijaard2007, Parameters, entry_of, find, named, names
from .sheet import write_table
from .waiting import collected

AGREES = 1e-6
"""[m/s] Largest difference of critical speeds that counts as the same."""


@dataclass(frozen=True, eq=False)
class Entry:
    """A bicycle of the page.

    Attributes
    ----------
    parameters : Parameters
    critical : bicycle.stability.CriticalSpeeds
        Also the self-stable ranges.
    difference : float
        Largest difference to those of the general model [m/s], NaN for round tyres; infinite if ranges do not match.
    """

    parameters: Parameters
    critical: stability.CriticalSpeeds
    difference: float

    @property
    def mass(self) -> float:
        """Of everything [kg]."""
        return self.parameters.mass

    @property
    def front_load(self) -> float:
        """Share of the weight that the front wheel carries."""
        return self.parameters.front_load

    @property
    def height(self) -> float:
        """Of the centre of mass [m]."""
        p = self.parameters
        return (p.mR * p.rR - p.mB * p.zB - p.mH * p.zH + p.mF * p.rF) / self.mass

    @property
    def source(self) -> str:
        """Where the parameters were published, and whether with a rider."""
        if self.parameters.name not in names():
            return "Meijaard et al. 2007, with rider" if self.parameters.name == "Meijaard2007" else ""
        entry = entry_of(self.parameters.name)
        rider = {True: ", with rider", False: ", without rider"}.get(entry.get("includes_rider"), "")
        return f"{entry['source'].split(':')[0]}{rider}"

    @property
    def file(self) -> str:
        """Name of its own page."""
        return file_of(self.parameters.name)


def check_names(bicycles: Sequence[Parameters]) -> None:
    """Refuse two bicycles of one name, whose pages would be one file."""
    known: set[str] = set()
    for parameters in bicycles:
        if file_of(parameters.name).lower() in known:  # some file systems take "a" for "A"
            raise ValueError(f"compare: two bicycles are called '{parameters.name}'; rename one")
        known.add(file_of(parameters.name).lower())


def file_of(name: str) -> str:
    """Name of the page of a bicycle."""
    return re.sub(r"[^A-Za-z0-9_.+-]+", "-", name).strip(".") + ".html"


def entry(parameters: Parameters) -> Entry:
    """Critical speeds of a bicycle, by closed form and general model."""
    model = stability.critical_speeds(parameters, whipple)
    if parameters.tR or parameters.tF:
        return Entry(parameters, model, float("nan"))
    closed = stability.critical_speeds(parameters)
    return Entry(parameters, closed, critical.difference(closed.stable, model.stable))


def entries(bicycles: Sequence[Parameters], *, progress: bool | None = None) -> list[Entry]:
    """The entries of bicycles; after Ctrl-C those that were finished."""
    return collected(f"{len(bicycles)} bicycles", map(entry, bicycles), len(bicycles), progress)


def table(found: Sequence[Entry]) -> str:
    """Critical speeds as text."""
    wide = max(len(x.parameters.name) for x in found)
    lines = [f"{'':{wide}}  {'weave':>8}  {'capsize':>8}  self-stable [m/s]"]
    for x in found:
        speeds = "  ".join(f"{v:8.4f}" if v > 0.0 else f"{'-':>8}" for v in (x.critical.weave, x.critical.capsize))
        doubt = "  NOT CONFIRMED by the general model" if x.difference > AGREES else ""
        stable = ", ".join(map(str, x.critical.stable)) or "at no speed"
        lines.append(f"{x.parameters.name:{wide}}  {speeds}  {stable}{doubt}")
    return "\n".join(lines)


def to_csv(found: Sequence[Entry], path: str | Path) -> Path:
    """One row per bicycle, critical speeds and parameters; returns the file."""
    keys = list(found[0].parameters.values())
    head = ["bicycle", "weave [m/s]", "capsize [m/s]", "stable from [m/s]", "to [m/s]", "model differs by [m/s]", *keys]
    rows = [
        [x.parameters.name, x.critical.weave, x.critical.capsize, *part, x.difference, *x.parameters.values().values()]
        for x in found
        for part in x.critical.stable or [(float("nan"), float("nan"))]
    ]
    return write_table(path, head, rows)


def chosen(wanted: Sequence[str], unphysical: bool) -> tuple[list[Parameters], list[str]]:
    """Bicycles by name or file, all sets if none is named, and why others were left out."""
    if wanted:
        return [find(text, unphysical=unphysical) for text in wanted], []
    found, left_out = [Meijaard2007()], []
    for name in names():
        try:
            found.append(named(name, unphysical=unphysical))
        except ValueError:
            left_out.append(name)  # all others are what they were published as
    why = "moments of inertia that no body has; --unphysical takes them in"
    return found, [f"{', '.join(left_out)}: {why}"] if left_out else []


@click.command()
@click.argument("bicycles", nargs=-1)
@click.option("--list", "only_list", is_flag=True, help="List the published sets and stop.")
@click.option(
    "--views", type=click.IntRange(0), default=4, show_default=True,
    help="How many, from the first on, get a page that shows their weave in motion (0.8 MB each).",
)  # fmt: skip
@click.option("--unphysical", is_flag=True, help="Accept inertias that no body has; some sets have them.")
@out_option
def command(bicycles: tuple[str, ...], only_list: bool, views: int, unphysical: bool, out: str) -> None:
    """Several bicycles on one page: critical speeds, dimensions, masses, eigenvalues, views.

    BICYCLES are names or parameter files (.txt, .yml); none = all published sets. Writes index.html, views and a table
    (.csv) into the folder compare below --out.
    """
    from mbsd3d.cli.support import INTERRUPTED, Failure, can_view, ready_folder

    if only_list:
        click.echo("\n".join(["Meijaard2007", *names()]))
        return
    can_view(needed=views > 0)
    folder = ready_folder(str(Path(out) / "compare"))
    wanted, left_out = chosen(bicycles, unphysical)
    check_names(wanted)
    for reason in left_out:
        click.echo(f"mbsd3d: left out: {reason}", err=True)
    found = entries(wanted)
    if not found:
        raise Failure("interrupted before a bicycle was finished")
    click.echo(table(found))
    from .compare_page import write_page

    for path in (to_csv(found, folder / "bicycles"), write_page(folder, found, left_out=left_out, views=views)):
        click.echo(str(path))
    if len(found) < len(wanted):
        click.echo(f"mbsd3d: interrupted, {len(wanted) - len(found)} bicycles are missing", err=True)
        raise click.exceptions.Exit(INTERRUPTED)
    if any(x.difference > AGREES for x in found):
        click.echo("mbsd3d: general model and closed form disagree", err=True)
        raise click.exceptions.Exit(1)
