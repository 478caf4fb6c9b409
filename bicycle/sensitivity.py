"""How the critical speeds of a bicycle depend on its parameters: exact derivatives, Monte Carlo, maps."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import click
import numpy as np

from .models import whipple
from .options import bicycle_argument, out_option
from .parameter_files import is_file, read_values
from .parameters import Parameters
from .slopes import Derivatives, NoSpeedsError, derivatives
from .stable_maps import StableMap, checked_axes, plot_map, stable_map
from .uncertainty import MonteCarlo, Sobol, checked_deviations, monte_carlo, published_deviations, sobol

__all__ = [
    "Derivatives", "MonteCarlo", "Sobol", "StableMap", "derivatives", "monte_carlo", "plot_derivatives", "plot_map",
    "plot_uncertainty", "sobol", "stable_map",
]  # fmt: skip


def plot_derivatives(found: Derivatives, *, dark: bool = False) -> Any:
    """Matplotlib figure: change of the critical speeds by one percent of the parameters that matter most."""
    from .sensitivity_figure import draw_derivatives

    return draw_derivatives(found, dark)


def plot_uncertainty(found: MonteCarlo, indices: Sobol, *, dark: bool = False) -> Any:
    """Matplotlib figure: distributions of weave and capsize speed, and the Sobol indices of the parameters."""
    from .sensitivity_figure import draw_uncertainty

    return draw_uncertainty(found, indices, dark)


@click.command()
@bicycle_argument
@click.option(
    "--deviation", "given", multiple=True, metavar="SYMBOL=VALUE",
    help="Standard deviation in SI units, e.g. c=0.005; several times. Default: those of the set or file.",
)  # fmt: skip
@click.option(
    "--samples", type=click.IntRange(2, 100_000), default=10_000, show_default=True, help="Of the distribution."
)
@click.option("--seed", type=int, default=1, show_default=True, help="Of the random numbers.")
@click.option(
    "--map", "axes", multiple=True, metavar="SYMBOL=FROM:TO:COUNT",
    help="Map of the self-stable range over two parameters, e.g. --map c=0:0.2:81 --map lam=0:0.7:81",
)  # fmt: skip
@click.option("--model", "general", is_flag=True, help="Map from the general model, not the closed form (slower).")
@click.option("--dark", is_flag=True, help="Figures on dark paper.")
@out_option
def command(
    parameters: Parameters, given: tuple[str, ...], samples: int, seed: int, axes: tuple[str, ...], general: bool,
    dark: bool, out: str,
) -> None:  # fmt: skip
    """How weave, capsize and double-root speed depend on every parameter.

    Writes the derivatives; with standard deviations (those of a measured set, or --deviation) also the distribution of
    the speeds and the Sobol indices of the parameters. Tables (.csv) and figures. Next: mbsd3d bicycle why
    """
    from mbsd3d.cli.support import Failure, ready_folder

    if len(axes) not in (0, 2) or (general and not axes):
        raise Failure(f"--map is given {len(axes)} times; give two, e.g. --map c=0:0.2:81 --map lam=0:0.7:81")
    wanted, spread = once(map(grid_of, axes), "--map"), deviations_of(parameters, given)
    build = whipple if general else None
    if wanted:
        checked_axes(parameters, wanted, build)
    target = ready_folder(out) / f"sensitivity_{parameters.name}"
    try:
        write_speeds(parameters, spread, samples, seed, dark, target)
    except NoSpeedsError as error:
        if not wanted:
            raise
        click.echo(f"mbsd3d: {error}: the map alone is made", err=True)
    if wanted:
        write_map(parameters, wanted, build, dark, target.with_name(f"map_{parameters.name}"))


def write_speeds(
    parameters: Parameters, spread: dict[str, float], samples: int, seed: int, dark: bool, target: Path
) -> None:
    """Derivatives of the critical speeds and, with standard deviations, their distribution."""
    from mbsd3d.plotting.plots import save_figure

    tyres = bool(parameters.tR or parameters.tF)
    found = derivatives(parameters, whipple if tyres else None)
    click.echo(str(found))
    report(*save_figure(plot_derivatives(found, dark=dark), target), found.to_csv(target))
    if tyres:
        click.echo("no distribution: samples are solved in closed form, which knows no round tyres")
    elif spread:
        sampled, indices = monte_carlo(parameters, spread, n=samples, seed=seed), sobol(parameters, spread, seed=seed)
        click.echo(str(sampled))
        name = target.with_name(f"uncertainty_{parameters.name}")
        figure = plot_uncertainty(sampled, indices, dark=dark)
        report(
            *save_figure(figure, name), sampled.to_csv(name), indices.to_csv(name.with_name(f"sobol_{parameters.name}"))
        )
    else:
        click.echo(f"no standard deviations of {parameters.name} are known; give some: --deviation c=0.005")


def write_map(parameters: Parameters, wanted: dict[str, np.ndarray], build: Any, dark: bool, target: Path) -> None:
    """Map with figure and table; what Ctrl-C left is written too."""
    from mbsd3d.cli.support import INTERRUPTED
    from mbsd3d.plotting.plots import save_figure

    found = stable_map(parameters, wanted, build)
    report(*save_figure(plot_map(found, dark=dark), target), found.to_csv(target))
    if found.missing:
        click.echo(f"mbsd3d: interrupted, {found.missing} cells of {found.low.size} are missing", err=True)
        raise click.exceptions.Exit(INTERRUPTED)


def report(*paths: Path) -> None:
    """Say what was written."""
    for path in paths:
        click.echo(str(path))


def number_of(text: str, what: str) -> float:
    """A number of the command line."""
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{what}: '{text}' is no number; write e.g. 0.08 (SI units)") from None


def once(pairs: Iterable[tuple[str, Any]], what: str) -> dict[str, Any]:
    """A mapping, with every symbol given once."""
    found = {}
    for key, value in pairs:
        if key in found:
            raise ValueError(f"{what} {key} is given twice; give it once")
        found[key] = value
    return found


def grid_of(text: str) -> tuple[str, np.ndarray]:
    """``c=0:0.2:81`` as a symbol and its values."""
    key, _, right = text.partition("=")
    parts = right.split(":")
    if len(parts) != 3 or not parts[2].isdigit() or int(parts[2]) < 2:
        raise ValueError(f"--map '{text}': write SYMBOL=FROM:TO:COUNT with at least 2 values, e.g. c=0:0.2:81")
    return key, np.linspace(number_of(parts[0], f"--map {key}"), number_of(parts[1], f"--map {key}"), int(parts[2]))


def deviations_of(parameters: Parameters, given: tuple[str, ...]) -> dict[str, float]:
    """As on the command line, else those of the file or of the published set."""
    if given:
        pairs = [text.partition("=") for text in given]
        found = [(key, number_of(right, f"--deviation {key}")) for key, _, right in pairs]
        return checked_deviations(parameters, once(found, "--deviation"))
    asked = click.get_current_context().params["bicycle"]
    if is_file(asked):
        return {key: std for key, std in read_values(asked)[1].items() if std}
    return published_deviations(parameters)
