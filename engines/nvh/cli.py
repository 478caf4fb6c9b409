"""Command ``mbsd3d nvh``: an engine in a car, from its gas and inertia to the seat rail; and the car on a rough
road."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mbsd3d.errors import InputError
from mbsd3d.extend import can_view, ready_folder

if TYPE_CHECKING:
    from engines.nvh.study import Study

DIFFERENCE_EXIT_CODE, DEFAULT_CAR = 1, "compact"  # exit code; where an engine is if nothing else is said
KINDS = ("lanchester", "raised", "first")  # of balance_shafts, which is imported when it is needed
FOLLOWERS = ("flat", "roller", "barrel")  # of valve.cam
OPTIONS_BY_TARGET = {
    "LAYOUT": ("car", "rpm", "load", "shafts", "sweep", "cycles", "active", "shell", "sound", "page", "export"),
    "--road": ("car", "speed", "page"),
    "--valve": ("rpm", "follower", "page"),
    "--planes": ("car",),
}
"""What goes with what is studied."""


@click.command(epilog="Example: mbsd3d nvh inline_4 --rpm 3000 --page out")
@click.argument("engine", metavar="[LAYOUT]", required=False)
@click.option("--car", help="Car that holds the engine; see --list, or a file (.json).  [default: compact]")
@click.option("--rpm", type=float, help="Speed [1/min]; default: midway between idle and redline.")
@click.option("--load", type=float, help="Share of full load; 0: motored, without gas.  [default: 1]")
@click.option("--shafts", type=click.Choice(KINDS), help="Balance shafts, geared to the crank.")
@click.option("--sweep", type=int, metavar="N", help="Full motions at N speeds from idle to redline.")
@click.option(
    "--cycles",
    type=int,
    metavar="N",
    help="Length of these motions in engine cycles, after half a second.  [default: 4]",
)
@click.option("--active", is_flag=True, help="Use an active mount: skyhook, and feed-forward on the largest order.")
@click.option("--shell", metavar="KIND", help="The car's shell: beam, plate, or a file of modes.  [default: beam]")
@click.option("--sound", metavar="FILE", help="Write the sound of a run-up at the seat rail to this file (.wav).")
@click.option("--road", help="Drive the car on a road: a class, A (smooth) to H, or a file of x,left,right.")
@click.option("--speed", type=float, help="With --road: speed of the car [m/s].  [default: 20]")
@click.option("--page", metavar="FOLDER", help="Write a page (.html) with animations to this folder.")
@click.option("--export", metavar="FOLDER", help="Write engine, car and shell to this folder, as files to edit.")
@click.option("--valve", metavar="LAW", help="A valve on a cam: cycloidal, harmonic or polynomial; --rpm: of the cam.")
@click.option("--follower", type=click.Choice(FOLLOWERS), help="With --valve: follower on the cam.  [default: flat]")
@click.option("--planes", is_flag=True, help="Compare planar models with space: exact, approximate, impossible.")
@click.option("--list", "only_list", is_flag=True, help="List engines and cars and exit.")
def nvh(engine: str | None, only_list: bool, **options: Any) -> None:
    """Compute the loads of an engine on its bearings, its mounts and its car.

    LAYOUT is an engine with real dimensions, such as inline_4, or a file (.json) with one. Orders of forces and moments
    on the block, loads of the main bearings, modes on the mounts, and forces on the car: by a linear map over the
    speeds, and at one speed by the full motion of the crank train on its mounts. The exit code is 1 if the two differ
    by more than 1 %.

    Instead of LAYOUT, --road: vibration at the seat of a quarter, half and whole car on a rough road, on slides and on
    the links of its axles, and what these make of the travel of a wheel; --valve: from which speed on a valve leaves
    its cam, and how it comes back; --planes: what a plane can say.
    """
    from engines.nvh.excitation import presets
    from engines.nvh.mounts import mounts

    if only_list:
        from engines.nvh.tables import engines

        show("engines; forces and couples on the block at the redline", engines())
        show("cars", [["", "mounts"], *([name, mounts.car(name).title] for name in mounts.names())])
        return
    given = {name: value for name, value in options.items() if value is not None and value is not False}
    subjects = ["LAYOUT"] * (engine is not None) + [f"--{name}" for name in given if f"--{name}" in OPTIONS_BY_TARGET]
    if len(subjects) != 1:
        raise InputError(f"nvh: give one of {', '.join(OPTIONS_BY_TARGET)}; engines are {', '.join(presets.names())}")
    (subject,) = subjects
    wrong = [name for name in given if f"--{name}" != subject and name not in OPTIONS_BY_TARGET[subject]]
    if wrong:
        raise InputError(f"nvh: --{wrong[0]} does not go with {subject}; leave it out")
    if "page" in given:
        can_view(needed=True)
    for option in ("page", "export"):
        if option in given:
            ready_folder(given[option], f"--{option}")
    if "cycles" in given and "sweep" not in given:
        raise InputError("nvh: --cycles belongs to --sweep; give both")
    if "sound" in given:
        ready_folder(str(Path(given["sound"]).parent), "--sound")
        if Path(given["sound"]).suffix.lower() != ".wav" or Path(given["sound"]).is_dir():
            raise InputError(f"nvh: --sound '{given['sound']}'; give a file that ends in .wav")
    car = mounts.car(given.pop("car", DEFAULT_CAR))
    if engine is not None:
        in_car(presets.preset(engine), car, **given)
    elif subject == "--road":
        on_road(car, **given)
    elif subject == "--valve":
        on_cam(**given)
    else:
        from engines.nvh.planar_cross_check import table

        show(f"what a plane says, {car.name}", table(car))


def in_car(
    chosen: Any,
    car: Any,
    rpm: float | None = None,
    load: float = 1.0,
    shafts: str | None = None,
    sweep: int | None = None,
    cycles: int = 4,
    active: bool = False,
    shell: str | None = None,
    sound: str | None = None,
    page: str | None = None,
    export: str | None = None,
) -> None:
    """Study an engine, show it, write its page; exit code 1 if linear map and full run differ."""
    from engines.nvh import tables
    from engines.nvh.cabin.seat import BEAM
    from engines.nvh.study import AGREEMENT_SHARE_MAX, Study

    speed = (chosen.idle + chosen.redline) / 2 if rpm is None else rpm
    study = Study(chosen, car, speed, load, shafts, shell or BEAM)
    check_study(study, shell=shell, sound=sound)
    swept = None if sweep is None else study.sweep(sweep, cycles)
    facts = tables.facts(study)
    width = max(len(name) for name, _ in facts)
    click.echo("\n".join(f"{name:{width}}  {text}" for name, text in facts))
    for title, rows in tables.on_engine(study):
        show(title, rows)
    if swept is not None:
        show("over the speed", tables.sweep(swept))
    of_mount = None
    if active:
        from engines.nvh.control.report import ActiveMount

        of_mount = ActiveMount(study)
        show("active mount", of_mount.rows)
    if study.shell_known:
        show("seat rail", tables.felt(study))
        show(f"paths of {(of_paths := tables.paths(study))[0]}", of_paths[1])
        show(f"modes of the shell, {Path(study.shell).name}", tables.shell(study))
    click.echo(f"\nlinear map and full run differ by {study.difference:.2%}")
    if reason := tables.why(study):
        click.echo(reason)
    if sound is not None:
        from engines.nvh.cabin.sound import write_sound

        click.echo(write_sound(study.map, study.cabin.seat(study.map), sound))
    if page is not None:
        from engines.nvh.page import write_page

        click.echo(write_page(study, page, of_mount, swept, sound))
    if export is not None:
        from engines.nvh.export import export as write_records

        click.echo("\n".join(str(path) for path in write_records(study, export)))
    if study.difference > AGREEMENT_SHARE_MAX:
        click.echo(f"mbsd3d: linear map and full run differ by {study.difference:.2%}", err=True)
        raise click.exceptions.Exit(DIFFERENCE_EXIT_CODE)


def check_study(study: "Study", **of_shell: str | None) -> None:
    """Check the study: the shell is known, mounts leave no motion free, and a table has every place."""
    for option, given in of_shell.items():
        if given is not None and not study.shell_known:
            raise InputError(
                f"nvh: --{option} needs a car whose shell is known, '{study.car.name}' is not; give compact or saloon, "
                "or a file of modes with --shell"
            )
    study.modes  # noqa: B018
    if study.shell_known:
        study.cabin.at_feet, study.cabin.at_seat  # noqa: B018


def on_road(car: Any, road: str, speed: float = 20.0, page: str | None = None) -> None:
    """Show quarter, half and whole car on a road, on slides and on links, and write their page."""
    from engines.nvh.road import report

    rides = report.rides_of(car, road, speed)
    click.echo(f"{car.title.split(',')[0]} on {rides[-1].road.title} at {speed:g} m/s")
    for remark in (report.left_out(rides[-1]), report.lifted(rides[-1])):
        if remark:
            click.echo(remark)
    show("at the seat", report.comfort(rides))
    show("wheels of the whole car on links", report.struts(rides[-1]))
    show("modes of the whole car on links", report.modes(rides[-1]))
    show("guides of the wheels", report.guides(rides[-1].vehicle))
    click.echo(f"\n{report.braking(rides[-1].vehicle)}\n{report.preloads(rides[-1].vehicle)}")
    if page is not None:
        click.echo(report.write_page(car, rides, page))


def on_cam(valve: str, rpm: float | None = None, follower: str = "flat", page: str | None = None) -> None:
    """Show a valve train over the speed, and write its page."""
    from engines.nvh.valvetrain.report import Valve, write_page

    found = Valve(valve, rpm, follower)
    click.echo(f"{found.facts}\n{found.verdict}")
    show("on the cam and off it", found.rows)
    if page is not None:
        click.echo(write_page(found, page))


def show(title: str, rows: list[list[str]]) -> None:
    """Print a table under its title."""
    from mbsd3d.extend import aligned

    click.echo(f"\n{title}\n" + "\n".join(aligned(rows)))
