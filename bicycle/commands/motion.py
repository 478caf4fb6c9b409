"""Commands on nonlinear motions: ride, circles."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from mbsd3d import IntegrationError
from mbsd3d.errors import InputError
from mbsd3d.extend import INTERRUPT_EXIT_CODE, can_view, keep, number, ready_folder

from ..model.tyres import TYPICAL, both
from ..parameters import fittings as own_fittings
from ..rides.manoeuvres import FALLEN, MANOEUVRES, Manoeuvre
from . import bicycle_argument, out_option, report, saved, tyre_options

if TYPE_CHECKING:
    from ..model.tyres import Tyres
    from ..parameters import Parameters

OUTPUT_RATE, SAMPLES_MIN, SAMPLES_MAX = 100, 400, 20_000
"""Samples of a ride per second, and at least and at most: a tyre that bounces does so within some hundredths."""


@click.command(epilog="Example: mbsd3d bicycle ride --speed 5 --view")
@bicycle_argument
@click.option(
    "--manoeuvre",
    type=click.Choice([*MANOEUVRES]),
    default="push",
    show_default=True,
    help="Manoeuvre to ride; see --list.",
)
@click.option("--list", "only_list", is_flag=True, help="List the manoeuvres.")
@click.option("--speed", type=float, help="Speed at the start [m/s]; default: as in the manoeuvre.")
@click.option("--t-end", type=float, help="End of the ride [s]; default: as in the manoeuvre.")
@click.option(
    "--fallen", type=float, default=f"{np.degrees(FALLEN):g}", show_default=True, help="Tilt that ends the ride [°]."
)
@click.option("--held-down", is_flag=True, help="Continue where a wheel would lift off, as if the ground could pull.")
@click.option("--view", "viewed", is_flag=True, help="Also write a page (.html) that shows the ride.")
@tyre_options
@out_option
def ride(
    parameters: "Parameters", manoeuvre: str, only_list: bool, speed: float | None, t_end: float | None, fallen: float,
    held_down: bool, viewed: bool, fittings: dict[str, Any], out: str,
) -> None:  # fmt: skip
    """Simulate a bicycle without hands: nonlinear motion, forces of the ground, friction they need, and falls.

    Writes a figure, a table (.csv) and the whole run (.npz, read by mbsd3d.load; not with --unphysical), named after
    bicycle, manoeuvre and the settings that were changed. Ctrl-C keeps what was computed. The exit code is 1 if the
    certificate of the run fails.
    """
    from ..rides.motion import plot_ride
    from ..rides.ride import run, view

    if only_list:
        width = max(map(len, MANOEUVRES))
        click.echo("\n".join(f"{name:{width}}  {chosen.title}" for name, chosen in MANOEUVRES.items()))
        return
    can_view(needed=viewed)
    chosen = MANOEUVRES[manoeuvre]
    given = {"speed": speed, "t_end": t_end}
    arguments = chosen.arguments | {key: value for key, value in given.items() if value is not None}
    if arguments["speed"] == 0.0:
        raise InputError("ride: --speed 0: a manoeuvre needs a bicycle that rolls; give a speed in m/s")
    fitted = chosen.fittings(fittings)
    own = ["tyres"] if fitted and not fittings else refitted(parameters, fittings)
    name = "_".join([parameters.name, manoeuvre, *changes(chosen, arguments, fallen, held_down), *own])
    arguments |= fitted
    target = ready_folder(out) / name
    samples = (
        int(np.clip(OUTPUT_RATE * number(arguments["t_end"], "ride: --t-end", positive=True), SAMPLES_MIN, SAMPLES_MAX))
        + 1
    )
    try:
        found = run(parameters, fallen=np.radians(fallen), held_down=held_down, output=samples, **arguments)
    except IntegrationError as error:
        if not parameters.unphysical:
            keep(error.solution, target)
        raise
    click.echo(f"{chosen.title}\n{found}")
    if parameters.unphysical:
        click.echo("no .npz file: it would hold bodies that cannot exist, and not be read back")
    else:
        report(found.solution.save(target))
    report(found.to_csv(target), *saved(plot_ride(found, chosen.title), target))
    if viewed:
        report(view(found, target, title=f"{parameters.name}: {chosen.title}"))
    if found.interrupted:
        raise click.exceptions.Exit(INTERRUPT_EXIT_CODE)
    if not found.solution.certificate.passed:
        raise click.exceptions.Exit(1)


def changes(chosen: Manoeuvre, arguments: Mapping[str, Any], fallen: float, held_down: bool) -> list[str]:
    """Return the settings that differ from the manoeuvre, for names of files: no ride replaces a different one."""
    numbers = {"speed": (arguments["speed"], chosen.speed), "t-end": (arguments["t_end"], chosen.t_end)}
    numbers["fallen"] = fallen, np.degrees(FALLEN)
    texts = {key: [f"{value:.12g}" for value in pair] for key, pair in numbers.items()}
    return [f"{key}{given}" for key, (given, usual) in texts.items() if given != usual] + ["held-down"] * held_down


def refitted(parameters: "Parameters", fittings: Mapping[str, Any]) -> list[str]:
    """Return the unusual settings of tyres and head for names of files, after "tyres"."""
    if not fittings:
        return []
    own = own_fittings(parameters)
    usual, rear = (both(one.get("tyres", TYPICAL))[0] for one in (own, fittings))
    other = {key: x for key, x in rear.items() if usual.get(key) != x}
    other |= {key: x for key, x in fittings.items() if key.startswith("head")}
    return ["tyres", *(f"{key}{x:.12g}" if isinstance(x, float) else f"{key}{x}" for key, x in other.items())]


@click.command(epilog="Example: mbsd3d bicycle circles --speed 4")
@bicycle_argument
@click.option(
    "--speed", "speeds", type=float, multiple=True, default=(3.0, 5.0, 7.0, 9.0), show_default=True,
    help="Speed of the turns held by a steer torque [m/s]; repeatable.",
)  # fmt: skip
@click.option("--view", "viewed", is_flag=True, help="Also write a page (.html): one round of the first family.")
@tyre_options
@out_option
def circles(
    parameters: "Parameters", speeds: tuple[float, ...], viewed: bool, fittings: dict[str, Any], out: str
) -> None:
    """Find the circles that a bicycle rides without hands, and the torque that holds it in other turns.

    Hands-free circles come in families that begin and end where the bicycle goes straight, rests, lies or lifts a
    wheel; the stability of each is computed. Writes a figure and a table (.csv) of all turns. On tyres only the held
    turns are sought, up to the limit of grip, beside those of ideal wheels.
    """
    from ..rides.ride import view
    from ..turns import circles as study

    for speed in speeds:
        number(speed, "circles: --speed", positive=True)
    if "head_stiffness" in fittings:
        raise InputError("circles: turns are sought with a rigid head tube; leave out --head")
    if fittings:
        circles_on_tyres(parameters, speeds, fittings["tyres"], out)
        return
    can_view(needed=viewed)
    target = ready_folder(out) / f"{parameters.name}_circles"
    families: list[Any] = []
    held: list[Any] = []
    interrupted = False
    try:
        study.families(parameters, keep=families)
        study.held_if_possible(parameters, speeds, held, lambda text: click.echo(f"mbsd3d: {text}", err=True))
    except KeyboardInterrupt:
        click.echo("mbsd3d: interrupted; what was found until then is kept", err=True)
        interrupted = True
    click.echo(study.summary(families))
    report(study.to_csv(families, [turn for group in held for turn in group], target))
    if interrupted:  # tables keep what was found; a figure takes longer than who presses Ctrl-C waits
        raise click.exceptions.Exit(INTERRUPT_EXIT_CODE)
    report(*saved(study.plot_circles(parameters, families, held), target))
    if viewed and families:
        first = families[0]
        shown = max((turn for _, turn in first.special or [("", first.turns[0])]), key=lambda turn: turn.speed)
        title = f"{parameters.name}: a circle without hands, lean {np.degrees(shown.lean):.1f}°"
        report(view(shown.ride(output=400), target, title=title))


def circles_on_tyres(parameters: "Parameters", speeds: tuple[float, ...], tyres: "Tyres", out: str) -> None:
    """Compute held turns at every speed up to the limit of grip."""
    from ..turns import circles as study
    from ..turns.on_tyres import figure, to_csv, turns

    target = ready_folder(out) / f"{parameters.name}_circles_tyres"
    leans = np.arange(0.025, 1.3, 0.025)
    found: list[Any] = []
    ideal: list[Any] = []
    interrupted = False
    try:
        for speed in speeds:
            try:
                found.append(turns(parameters, tyres, speed, leans))
            except InputError as error:
                if not found and speed == speeds[-1]:
                    raise
                click.echo(f"mbsd3d: {error}", err=True)
                continue
            last = found[-1][-1]
            used = f"{100.0 * last.saturation:.0f} % of the grip" if last.saturation else "no limit of grip"
            click.echo(
                f"{speed:g} m/s: up to a lean of {np.degrees(last.lean):.1f}°, radius {last.radius:.4g} m, with {used} "
                f"and {last.steer_torque:.3g} N m of steer torque"
            )
        study.held_if_possible(parameters, [group[0].speed for group in found], ideal, lambda text: None)
    except KeyboardInterrupt:
        click.echo("mbsd3d: interrupted; what was found until then is kept", err=True)
        interrupted = True
    if found:
        report(to_csv([turn for group in found for turn in group], target))
    if interrupted:
        raise click.exceptions.Exit(INTERRUPT_EXIT_CODE)
    report(*saved(figure(found, ideal, f"{parameters.name}: steady turns on tyres"), target))
