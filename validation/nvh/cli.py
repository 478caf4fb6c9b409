"""``mbsd3d nvh``: an engine in a car, from its gas and inertia to what the car gets."""

import click

from mbsd3d.extend import can_view, ready_folder

DIFFER = 1  # exit code
KINDS = ("lanchester", "raised", "first")  # of balance_shafts, which is imported when it is needed


@click.command()
@click.argument("engine", metavar="LAYOUT", required=False)
@click.option("--car", "car_name", default="compact", show_default=True, help="Where it is mounted; see --list.")
@click.option("--rpm", type=float, help="Speed [1/min]; default: half way between idle and redline.")
@click.option("--load", type=float, default=1.0, show_default=True, help="Share of full load; 0: motored, without gas.")
@click.option("--shafts", type=click.Choice(KINDS), help="Balance shafts, geared to the crank.")
@click.option("--page", "folder", metavar="FOLDER", help="Write a page (.html) there, with the engine in motion.")
@click.option("--list", "only_list", is_flag=True, help="List engines and cars and end.")
def nvh(
    engine: str | None, car_name: str, rpm: float | None, load: float, shafts: str | None, folder: str | None,
    only_list: bool,
) -> None:  # fmt: skip
    """What an engine does to its bearings, its mounts and the car it is in.

    LAYOUT is an engine with real dimensions, such as inline_4. Orders of forces and moments on the block, loads of the
    main bearings, modes on the mounts, and what the mounts hand on: by a linear map over the speeds, and at one speed
    by the full motion of the crank train on its mounts. The exit code is 1 if the two differ by more than 1 %.
    """
    from validation.nvh.engine import presets
    from validation.nvh.held import mounts
    from validation.nvh.study import AGREES, Study

    if only_list:
        listed = [(name, presets.preset(name).title) for name in presets.names()]
        listed += [(name, mounts.car(name).title) for name in mounts.names()]
        click.echo("\n".join(f"{name:12} {title}" for name, title in listed))
        return
    if engine is None:
        raise ValueError(f"nvh: no LAYOUT; give one of {', '.join(presets.names())}")
    chosen = presets.preset(engine)
    speed = (chosen.idle + chosen.redline) / 2 if rpm is None else rpm
    study = Study(chosen, mounts.car(car_name), speed, load, shafts)
    if folder is not None:
        can_view(needed=True)
        ready_folder(folder, "--page")
    show(study)
    if folder is not None:
        from validation.nvh.page import write_page

        click.echo(write_page(study, folder))
    if study.difference > AGREES:
        click.echo(f"mbsd3d: linear map and full run differ by {study.difference:.2%}", err=True)
        raise click.exceptions.Exit(DIFFER)


def show(study: object) -> None:
    """The tables of a study."""
    from validation.nvh import tables
    from validation.suite.findings import aligned

    width = max(len(name) for name, _ in tables.facts(study))
    click.echo("\n".join(f"{name:{width}}  {text}" for name, text in tables.facts(study)))
    timing = [("balance shafts fitted late", tables.timing)] if study.source.fitted else []
    for title, table in (
        ("load on the block", tables.loads), *timing,
        ("main bearings", tables.bearings), ("modes on the mounts", tables.modes),
        ("mounts", tables.mounts), ("handed on to the car", tables.handed_on),
    ):  # fmt: skip
        click.echo(f"\n{title}\n" + "\n".join(aligned(table(study))))
    click.echo(f"\nlinear map and full run differ by {study.difference:.2%}")
