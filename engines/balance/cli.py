"""Command line of engine balance: ``python -m engines.balance``."""

from typing import Any

import click
from click.core import ParameterSource

from mbsd3d.errors import InputError
from mbsd3d.extend import Failure

MASSES = {
    "crank": "crank_mass",
    "centre": "crank_centre",
    "rod": "rod_mass",
    "fraction": "rod_fraction",
    "inertia": "rod_inertia",
    "piston": "piston_mass",
}
DISAGREEMENT_EXIT_CODE = 1  # of a process; methods disagree


def masses(context: click.Context, option: click.Parameter, text: str | None) -> dict[str, float]:
    """Read ``crank=2,rod=4`` as fields of `Engine`."""
    found = {}
    for item in (text or "").split(","):
        name, _, number = item.partition("=")
        if not item:
            continue
        if name not in MASSES:
            raise click.BadParameter(f"{name!r} is unknown; give {', '.join(MASSES)}, such as piston=5,rod=4")
        if MASSES[name] in found:
            raise click.BadParameter(f"{name} is given twice; give it once")
        try:
            found[MASSES[name]] = float(number)
        except ValueError:
            raise click.BadParameter(f"{name}={number!r} is not a number; give one [kg, m, -, kg m^2]") from None
    return found


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("layout", required=False)
@click.option("--rpm", type=float, default=10.0, show_default=True, help="Crank speed [1/min].")
@click.option("--R", "radius", type=float, default=1.0, show_default=True, help="Crank radius [m].")
@click.option("--L", "rod_length", type=float, default=2.0, show_default=True, help="Rod length [m].")
@click.option("--spacing", type=float, help="Bore spacing [m]; default: as in the layout.")
@click.option("--masses", callback=masses, help=f"Masses, e.g. piston=5,rod=4; names: {', '.join(MASSES)}.")
@click.option("--gravity", type=(float, float), default=(0.0, 0.0), help="Gravity along x and y [m/s^2].")
@click.option("--driver", type=click.Choice(["block", "dyno"]), default="block", help="Where the torque reacts.")
@click.option(
    "--gas", type=float, metavar="PEAK", help="LAYOUT or --pages: half sines of this peak [N] over the power strokes."
)
@click.option("--shafts", is_flag=True, help="LAYOUT: counterweights and balance shafts for 1x and 2x.")
@click.option("--sweep", is_flag=True, help="LAYOUT: 2x over the rod length.")
@click.option("--ways", is_flag=True, help="Every harmonic by phasor, planar sum and spatial model, and as published.")
@click.option(
    "--truth",
    is_flag=True,
    help="Published figures, all or of LAYOUT, compared with their assumptions and the true values.",
)
@click.option("--pages", type=click.Path(), metavar="FOLDER", help="Write pages there: index.html and the engines.")
def main(
    layout: str | None, masses: dict, gravity: Any, driver: str, gas: float | None, shafts: bool, sweep: bool,
    ways: bool, truth: bool, pages: str | None, **sizes: Any,
) -> None:  # fmt: skip
    """Show the balance of the engine LAYOUT, or of all layouts: forces and moments on the block, order by order.

    A toy engine unless sizes are given: a crank of 1 m at 10 rpm. `mbsd3d nvh --list` has engines with real dimensions.
    Every figure is computed three ways: in closed form, as a sum of planar models, and from the reaction of the whole
    engine in space. The exit code is 1 if they disagree.
    """
    from engines.balance.layouts import Engine, names

    try:
        if truth:
            alone("--truth", set())
            click.echo(published(layout))
            return
        engines = [Engine(name, **sizes, **masses) for name in (names() if layout is None else [layout])]
        if pages is None:
            comparisons = tables(engines, gravity, driver, gas, shafts, sweep, ways)
        else:
            alone("--pages", {"rpm", "radius", "rod_length", "spacing", "masses", "gravity", "driver", "gas"})
            comparisons = written(pages, engines, gravity, driver, gas)
    except ValueError as error:
        raise Failure(" ".join(str(error).split())) from error
    if not all(comparison.agrees for comparison in comparisons):
        wrong = ", ".join(c.engine.layout.name for c in comparisons if not c.agrees)
        click.echo(f"phasor, planar sum and spatial model disagree for {wrong}", err=True)
        raise click.exceptions.Exit(DISAGREEMENT_EXIT_CODE)


def alone(switch: str, allowed: set[str]) -> None:
    """Raise a usage error for options that `switch`, which takes LAYOUT, does not use."""
    context = click.get_current_context()
    given = [
        option.opts[0]
        for option in context.command.params
        if context.get_parameter_source(option.name) is ParameterSource.COMMANDLINE
        and option.name not in allowed | {"layout", switch.removeprefix("--")}
    ]
    if given:
        raise InputError(f"{switch} does not use {', '.join(given)}; leave one of them out")


def published(name: str | None) -> str:
    """Return the truth table of the toy engines, or its rows about one layout."""
    from engines.balance import report
    from engines.balance.layouts import layout
    from engines.balance.published import truth

    found = truth.rows()
    if name is not None:
        found = [row for row in found if layout(name).name in row.layouts]
        if not found:
            return f"no published figure is about {name}"
    return (
        f"{report.truth(found)}\n\n{report.single_cylinder()}" if name in (None, "single") else str(report.truth(found))
    )


def written(folder: str, engines: list, gravity: Any, driver: str, gas: float | None) -> list:
    """Write the pages, print their paths and return the comparisons they show."""
    from engines.balance.pages.site import write_pages

    if not folder:
        raise InputError("--pages '' names no folder; give one, or . for this one")
    options: dict[str, Any] = {} if gas is None else {"peak": gas}
    done = write_pages(folder, engines, gravity=gravity, driver=driver, **options)
    click.echo(done.index)
    return done.comparisons


def tables(engines: list, gravity: Any, driver: str, gas: float | None, shafts: bool, sweep: bool, ways: bool) -> list:
    """Print harmonics of one engine or of all, and the requested studies; return the comparisons shown."""
    from engines.balance import report
    from engines.balance.balance import compare

    if len(engines) > 1 and (gas is not None or shafts or sweep):
        raise InputError("--gas, --shafts and --sweep study one engine; give a LAYOUT")
    comparisons = [compare(engine, gravity=gravity, driver=driver) for engine in engines]
    extra = [] if gas is None else [report.gas_harmonics(engines[0], gas)]
    extra += [report.balance_shafts(engines[0])] if shafts else []
    extra += [report.rod_ratios(engines[0])] if sweep else []
    if ways:
        parts = [report.ways(comparison) for comparison in comparisons]
        click.echo(report.Table(parts[0].header, [row for part in parts for row in part.rows]))
    elif len(comparisons) == 1:
        show(comparisons[0])
    else:
        click.echo(report.overview(comparisons))
        click.echo("F [N] and M [N m]: force and couple on the block; fwd, bwd turn with and against the crank;")
        click.echo("T [N m]: largest order of the driving torque; spread: of the three ways, over F_single and weight.")
    for table in extra:
        click.echo(f"\n{table}")
    return comparisons


def show(comparison: Any) -> None:
    """Print one engine: components by three methods, rotating vectors, and how well the methods agree."""
    from engines.balance import report
    from engines.balance.gas import firing_order

    plan = comparison.engine.layout
    click.echo(f"{plan.title}; {len(plan.pins)} cylinders, fires {firing_order(plan)}")
    click.echo(f"F_single 1x = {comparison.engine.single:.6g} N\n")
    click.echo(f"{report.components(comparison)}\n")
    click.echo(f"{report.turning(comparison)}\n")
    click.echo(f"largest difference {comparison.disagreement:.1e} of F_single and the weight of a cylinder")
