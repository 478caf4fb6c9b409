"""``mbsd3d nvh``: an engine in a car, from its gas and inertia to what the car gets; and the car on a rough road."""

from typing import Any

import click

from mbsd3d.errors import InputError
from mbsd3d.extend import can_view, ready_folder

DIFFER = 1  # exit code
KINDS = ("lanchester", "raised", "first")  # of balance_shafts, which is imported when it is needed
OF_ENGINE = ("rpm", "load", "shafts")


@click.command()
@click.argument("engine", metavar="LAYOUT", required=False)
@click.option("--car", "car_name", default="compact", show_default=True, help="Where it is mounted; see --list.")
@click.option("--rpm", type=float, help="Speed [1/min]; default: half way between idle and redline.")
@click.option("--load", type=float, help="Share of full load; 0: motored, without gas.  [default: 1]")
@click.option("--shafts", type=click.Choice(KINDS), help="Balance shafts, geared to the crank.")
@click.option("--road", help="Without LAYOUT: the car on a road of this class, A (smooth) to H.")
@click.option("--speed", type=float, help="With --road: of the car [m/s].  [default: 20]")
@click.option("--page", "folder", metavar="FOLDER", help="Write a page (.html) there, with everything in motion.")
@click.option("--list", "only_list", is_flag=True, help="List engines and cars and end.")
def nvh(engine: str | None, car_name: str, folder: str | None, only_list: bool, **given: Any) -> None:
    """What an engine does to its bearings, its mounts and the car it is in.

    LAYOUT is an engine with real dimensions, such as inline_4. Orders of forces and moments on the block, loads of the
    main bearings, modes on the mounts, and what the mounts hand on: by a linear map over the speeds, and at one speed
    by the full motion of the crank train on its mounts. The exit code is 1 if the two differ by more than 1 %.

    With --road instead of LAYOUT: vibration at the seat of a quarter, linked, half and whole car on a
    rough road, and what the links of its axles make of the travel of a wheel.
    """
    from validation.nvh.engine import presets
    from validation.nvh.held import mounts

    if only_list:
        listed = [(name, presets.preset(name).title) for name in presets.names()]
        listed += [(name, mounts.car(name).title) for name in mounts.names()]
        click.echo("\n".join(f"{name:12} {title}" for name, title in listed))
        return
    given = {name: value for name, value in given.items() if value is not None}
    if (engine is None) == ("road" not in given):
        raise InputError(f"nvh: give one of LAYOUT and --road; engines are {', '.join(presets.names())}")
    wrong = [name for name in given if (name in OF_ENGINE) != (engine is not None)]
    if wrong:
        raise InputError(f"nvh: --{wrong[0]} is for {'--road' if engine else 'an engine'}; leave it out")
    if folder is not None:
        can_view(needed=True)
        ready_folder(folder, "--page")
    if engine is None:
        on_road(mounts.car(car_name), folder, **given)
    else:
        in_car(presets.preset(engine), mounts.car(car_name), folder, **given)


def in_car(
    chosen: Any, car: Any, folder: str | None, rpm: float | None = None, load: float = 1.0, shafts: str | None = None
) -> None:
    """Study an engine, show it, write its page; exit code 1 if linear map and full run differ."""
    from validation.nvh import tables
    from validation.nvh.study import AGREES, Study

    speed = (chosen.idle + chosen.redline) / 2 if rpm is None else rpm
    study = Study(chosen, car, speed, load, shafts)
    facts = tables.facts(study)
    width = max(len(name) for name, _ in facts)
    click.echo("\n".join(f"{name:{width}}  {text}" for name, text in facts))
    show("load on the block", tables.loads(study))
    if study.source.fitted:
        show("balance shafts fitted late", tables.timing(study))
    show("main bearings", tables.bearings(study))
    show("modes on the mounts", tables.modes(study))
    show("mounts", tables.mounts(study))
    show("handed on to the car", tables.handed_on(study))
    click.echo(f"\nlinear map and full run differ by {study.difference:.2%}")
    if folder is not None:
        from validation.nvh.page import write_page

        click.echo(write_page(study, folder))
    if study.difference > AGREES:
        click.echo(f"mbsd3d: linear map and full run differ by {study.difference:.2%}", err=True)
        raise click.exceptions.Exit(DIFFER)


def on_road(car: Any, folder: str | None, road: str, speed: float = 20.0) -> None:
    """Quarter, linked, half and whole car on a road; show them, write their page."""
    from validation.nvh.road import report
    from validation.nvh.road.vehicle import KINDS

    rides = [report.ride_of(car, kind, road, speed) for kind in KINDS]
    click.echo(f"{car.title.split(',')[0]} on a road of class {road} at {speed:g} m/s")
    show("at the seat", report.comfort(rides))
    show("wheels", report.struts(rides[-1]))
    show("modes", report.modes(rides[-1]))
    show("guides of the wheels", report.guides(rides[-1].vehicle))
    click.echo(f"\n{report.braking(rides[-1].vehicle)}")
    if folder is not None:
        click.echo(report.write_page(car, rides[-1], folder))


def show(title: str, rows: list[list[str]]) -> None:
    """A table under its title."""
    from validation.suite.findings import aligned

    click.echo(f"\n{title}\n" + "\n".join(aligned(rows)))
