"""Commands on small motions about a straight run: sensitivity, why, frequency, compare."""

from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from mbsd3d.errors import InputError
from mbsd3d.extend import INTERRUPT_EXIT_CODE, Failure, can_view, ready_folder

from . import (
    bicycle_argument,
    dark_option,
    fitted,
    out_option,
    report,
    saved,
    tyre_flags,
    tyre_options,
    unphysical_option,
)  # fmt: skip

if TYPE_CHECKING:
    from ..linear.general import Build
    from ..parameters import Parameters


@click.command(epilog="Example: mbsd3d bicycle sensitivity Browserins --deviation c=0.005")
@bicycle_argument
@click.option(
    "--deviation", "given", multiple=True, metavar="SYMBOL=VALUE",
    help="Standard deviation in SI units, e.g. c=0.005; repeatable. Default: those of the set or file.",
)  # fmt: skip
@click.option(
    "--samples",
    type=click.IntRange(2, 100_000),
    default=10_000,
    show_default=True,
    help="Number of samples of the distribution.",
)
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True, help="Seed of the random numbers.")
@click.option(
    "--map", "axes", multiple=True, metavar="SYMBOL=FROM:TO:COUNT",
    help="Map of the self-stable range over two parameters, e.g. --map c=0:0.2:81 --map lam=0:0.7:81",
)  # fmt: skip
@click.option(
    "--model", "general", is_flag=True, help="Compute the map by the general model instead of the closed form (slower)."
)
@dark_option
@out_option
def sensitivity(
    parameters: "Parameters", given: tuple[str, ...], samples: int, seed: int, axes: tuple[str, ...], general: bool,
    dark: bool, out: str,
) -> None:  # fmt: skip
    """Compute how weave, capsize and double-root speed depend on every parameter.

    Writes the derivatives; with standard deviations (those of a measured set, or --deviation) also the distribution of
    the speeds and the Sobol indices of the parameters. Tables (.csv) and figures. Next: mbsd3d bicycle why
    """
    from ..linear.maps import checked_axes
    from ..linear.sensitivity import NoSpeedsError
    from ..model.mechanism import whipple

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
        click.echo(f"mbsd3d: {error}: only the map is written", err=True)
    if wanted:
        write_map(parameters, wanted, build, dark, target.with_name(f"map_{parameters.name}"))


def write_speeds(
    parameters: "Parameters", spread: dict[str, float], samples: int, seed: int, dark: bool, target: Path
) -> None:
    """Write derivatives of the critical speeds and, with standard deviations, their distribution."""
    from ..linear.sensitivity import derivatives, monte_carlo, plot_derivatives, plot_uncertainty, sobol
    from ..model.mechanism import whipple

    tyres = bool(parameters.tR or parameters.tF)
    found = derivatives(parameters, whipple if tyres else None)
    click.echo(str(found))
    report(*saved(plot_derivatives(found, dark=dark), target), found.to_csv(target))
    if tyres:
        click.echo("no distribution: samples are solved in closed form, which has no round tyres")
    elif spread:
        sampled, indices = monte_carlo(parameters, spread, n=samples, seed=seed), sobol(parameters, spread, seed=seed)
        click.echo(str(sampled))
        name = target.with_name(f"uncertainty_{parameters.name}")
        figure = plot_uncertainty(sampled, indices, dark=dark)
        tables = sampled.to_csv(name), indices.to_csv(name.with_name(f"sobol_{parameters.name}"))
        report(*saved(figure, name), *tables)
    else:
        click.echo(f"no standard deviations of {parameters.name} are known; give some: --deviation c=0.005")


def write_map(
    parameters: "Parameters", wanted: dict[str, np.ndarray], build: "Build | None", dark: bool, target: Path
) -> None:
    """Write a map with figure and table, also after Ctrl-C."""
    from ..linear.maps import plot_map, stable_map

    found = stable_map(parameters, wanted, build)
    report(*saved(plot_map(found, dark=dark), target), found.to_csv(target))
    end(f"{found.missing} cells of {found.low.size}" if found.missing else "")


def once(pairs: Iterable[tuple[str, Any]], what: str) -> dict[str, Any]:
    """Return the pairs as a mapping; raise an error for a symbol given twice."""
    found: dict[str, Any] = {}
    for key, value in pairs:
        if key in found:
            raise InputError(f"{what} {key} is given twice; give it once")
        found[key] = value
    return found


def grid_of(text: str) -> tuple[str, np.ndarray]:
    """Read ``c=0:0.2:81`` as a symbol and its values."""
    key, _, right = text.partition("=")
    parts = right.split(":")
    if len(parts) != 3 or not parts[2].isdigit() or int(parts[2]) < 2:
        raise InputError(f"--map '{text}': write SYMBOL=FROM:TO:COUNT with at least 2 values, e.g. c=0:0.2:81")
    return key, np.linspace(number_of(parts[0], f"--map {key}"), number_of(parts[1], f"--map {key}"), int(parts[2]))


def number_of(text: str, what: str) -> float:
    """Read a number of the command line."""
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{what}: '{text}' is not a number; write e.g. 0.08 (SI units)") from None


def deviations_of(parameters: "Parameters", given: tuple[str, ...]) -> dict[str, float]:
    """Return the standard deviations of the command line, else those of the file or of the published set."""
    from ..linear.uncertainty import known_deviations

    if given:
        pairs = [text.partition("=") for text in given]
        found = [(key, number_of(right, f"--deviation {key}")) for key, _, right in pairs]
        return known_deviations(parameters, once(found, "--deviation"))
    return dict(parameters.deviations)


@click.command(epilog="Example: mbsd3d bicycle why")
@bicycle_argument
@click.option("--closed-form", is_flag=True, help="Do not confirm the ranges by the general model (faster).")
@tyre_options
@dark_option
@out_option
def why(parameters: "Parameters", closed_form: bool, fittings: dict[str, Any], dark: bool, out: str) -> None:
    """Show why a bicycle stays upright: without spin or trail, with masses moved, with steering locked.

    Prints the self-stable ranges [m/s] of each variant and how fast it falls at one speed; writes a figure and a table
    (.csv). On tyres also the effects of their camber, trail, relaxation and stiffness, compared with ideal wheels. The
    exit code is 1 if the general model does not confirm a range. Next: mbsd3d bicycle sensitivity
    """
    from ..linear.why import ablations, plot_ablations, to_csv
    from ..model.mechanism import whipple

    folder = ready_folder(out)
    if closed_form and fittings:
        raise Failure("--closed-form: the closed form has ideal wheels; leave out --tyres, --tyre and --head")
    found = ablations(parameters, None if closed_form else whipple, **fittings)
    if not found.rows:
        raise Failure("interrupted before a variant was finished")
    click.echo(str(found))
    target = folder / f"why_{parameters.name}{'_tyres' * bool(fittings)}"
    report(to_csv(found, target))
    if not found.missing:
        report(*saved(plot_ablations(found, dark=dark), target))
    end(f"{found.missing} variants" if found.missing else "", any(row.confirmed is False for row in found.rows))


@click.command(epilog="Example: mbsd3d bicycle frequency Browserins")
@bicycle_argument
@click.option("--speed", "speeds", type=float, multiple=True, help="Speed [m/s]; repeatable. Default: 3, 5 and 8.")
@click.option("--from", "low", type=float, default=0.1, show_default=True, help="Lowest frequency [rad/s].")
@click.option("--to", "high", type=float, default=100.0, show_default=True, help="Highest frequency [rad/s].")
@click.option("--count", type=click.IntRange(2, 100_000), default=301, show_default=True, help="Number of frequencies.")
@tyre_options
@dark_option
@out_option
def frequency(
    parameters: "Parameters", speeds: tuple[float, ...], low: float, high: float, count: int, fittings: dict[str, Any],
    dark: bool, out: str,
) -> None:  # fmt: skip
    """Draw a Bode plot: lean and steer in response to lean and steer torque.

    From the general model at each speed. Writes a figure and a table (.csv). Dashed: the bicycle falls at this speed
    if nobody steers. On tyres, thin lines are those of ideal wheels. Next: mbsd3d bicycle ride
    """
    from ..linear.frequency import plot_response, response
    from ..model.mechanism import whipple

    if not 0.0 < low < high < np.inf:
        raise Failure(f"--from {low:g} --to {high:g}: give frequencies in rad/s with 0 < from < to")
    folder = ready_folder(out)
    omega, speeds = np.geomspace(low, high, count), speeds or (3.0, 5.0, 8.0)
    found = response(parameters, speeds, omega, **fittings)
    ideal = partial(whipple, steer_damping=fittings.get("steer_damping", 0.0))
    beside = response(parameters, speeds, omega, ideal) if fittings else None
    for v, growth in zip(found.speeds, found.growth, strict=True):
        click.echo(f"{v:g} m/s: {'falls' if growth > 0.0 else 'self-stable'}, growth {growth:.6g} 1/s")
    target = folder / f"frequency_{parameters.name}{'_tyres' * bool(fittings)}"
    report(*saved(plot_response(found, beside=beside, dark=dark), target), found.to_csv(target))


@click.command(epilog="Example: mbsd3d bicycle compare Browserins Fisher")
@click.argument("bicycles", nargs=-1)
@click.option("--list", "only_list", is_flag=True, help="List the published sets and stop.")
@click.option(
    "--views", type=click.IntRange(0), default=4, show_default=True,
    help="Number of bicycles, from the first on, that get a page with their weave in motion (0.8 MB each).",
)  # fmt: skip
@unphysical_option
@tyre_flags
@out_option
def compare(
    bicycles: tuple[str, ...], only_list: bool, views: int, unphysical: bool, on_tyres: bool, changed: tuple[str, ...],
    head: tuple[float, ...] | None, out: str,
) -> None:  # fmt: skip
    """Compare several bicycles on one page: critical speeds, dimensions, masses, eigenvalues, views.

    BICYCLES are names or parameter files (.txt, .yml); none = all published sets. Writes index.html, views and a table
    (.csv) into the folder compare below --out. With --tyres also what ideal wheels leave out, as a figure.
    """
    from ..pages.compare import SPEED_TOLERANCE, check_names, chosen, entries, table, to_csv, write_page
    from ..parameters import names

    if only_list:
        click.echo("\n".join(["Meijaard2007", *names()]))
        return
    can_view(needed=views > 0)
    folder = ready_folder(str(Path(out) / "compare"))
    wanted, left_out = chosen(bicycles, unphysical)
    check_names(wanted)
    for reason in left_out:
        click.echo(f"mbsd3d: left out: {reason}", err=True)
    grips = [fitted(p, on_tyres, changed, head) for p in wanted] if on_tyres or changed or head else None
    found = entries(wanted, grips)
    if not found:
        raise Failure("interrupted before a bicycle was finished")
    click.echo(table(found))
    report(to_csv(found, folder / "bicycles"))
    missing = len(wanted) - len(found)
    if not missing:
        report(write_page(folder, found, left_out=left_out, views=views))
        for x in [x for x in found[: max(views, 1)] if x.fittings]:
            report(*saved(x.left_out, folder / f"ideal_or_tyres_{x.parameters.name}"))
    end(f"{missing} bicycles" if missing else "", any(x.difference > SPEED_TOLERANCE for x in found))


def end(missing: str, disagree: bool = False) -> None:
    """End with the exit code of a study that Ctrl-C cut short, or whose two models disagree."""
    if missing:
        click.echo(f"mbsd3d: interrupted, {missing} are missing", err=True)
        raise click.exceptions.Exit(INTERRUPT_EXIT_CODE)
    if disagree:
        click.echo("mbsd3d: general model and closed form disagree", err=True)
        raise click.exceptions.Exit(1)
