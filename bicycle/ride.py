"""Rides: nonlinear runs of the Whipple bicycle, with what the rider and the wind do to it, until it falls."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np

from mbsd3d import IntegrationError, Signal, accelerations, simulate
from mbsd3d.base.checks import number
from mbsd3d.cli.support import INTERRUPTED, can_view, keep, ready_folder

from .events import check_start, elevation, unloading
from .loads import ridden
from .manoeuvres import MANOEUVRES, Manoeuvre
from .motion import WHEELS, Event, Ride
from .options import bicycle_argument, out_option
from .parameters import Parameters

FALLEN = np.radians(60.0)
"""Tilt of the frame at which a ride ends unless another one is given [rad]."""
RATE, MOST = 100, 20_000
"""Samples of a manoeuvre per second, and at most."""


def run(
    parameters: Parameters,
    t_end: float = 10.0,
    *,
    speed: float,
    lean: float = 0.0,
    steer: float = 0.0,
    lean_rate: float = 0.0,
    steer_rate: float = 0.0,
    torque: Signal | float = 0.0,
    push: Signal | float = 0.0,
    fallen: float = FALLEN,
    held_down: bool = False,
    rtol: float = 1e-8,
    output: int | Sequence[float] | None = None,
    progress: bool | None = None,
) -> Ride:
    """Let a bicycle go and see what it does.

    Parameters
    ----------
    parameters : Parameters
    t_end : float
        End of the ride [s].
    speed, lean, steer, lean_rate, steer_rate : float
        The start, as in `whipple` [m/s, rad, rad/s].
    torque : Signal or float
        Of the rider on the handlebar [N m], to the right > 0.
    push : Signal or float
        Horizontal force on the centre of mass of frame and rider [N], to the right of the first heading > 0.
    fallen : float
        Tilt of the frame that ends the ride [rad], 0 < fallen < pi/2.
    held_down : bool
        Go on where the ground would have to pull at a wheel, as if it ran on a rail: the two-mass skate has its weight
        in front of both wheels.
    rtol, output, progress
        As in `mbsd3d.simulate`.

    Returns
    -------
    Ride
        Up to ``event`` if it fell ("fallen") or a wheel left the ground ("rear wheel unloaded", "front wheel
        unloaded"): ideal wheels would be held down from there on. Unloading is looked for at the samples, and then
        located to 1e-9 s. Ctrl-C keeps what was computed.

    Raises
    ------
    ValueError
        If the bicycle lies fallen at the start, a wheel is not pressed to the ground there, or a number is none.
    IntegrationError
        If the run cannot go on; its ``solution`` holds the samples.

    Examples
    --------
    >>> from bicycle import Meijaard2007, ride
    >>> print(ride.run(Meijaard2007(), speed=2.0, lean_rate=0.05).event.name)
    front wheel unloaded
    """
    limit = number(fallen, "ride: fallen", positive=True)
    if limit >= 0.5 * np.pi:
        raise ValueError(f"ride: fallen = {limit:.6g} rad; give a tilt below pi/2")
    system = ridden(
        parameters, torque, push, speed=speed, lean=lean, steer=steer, lean_rate=lean_rate, steer_rate=steer_rate
    )
    start, upward = system.state(), elevation(system)
    check_start(parameters, Ride(parameters, accelerations(system, start)), limit, held_down)
    settings = {"state": start, "rtol": rtol, "output": output, "progress": progress}
    try:
        found = simulate(system, t_end, stop_when=upward < 0.5 * np.pi - limit, **settings)
    except IntegrationError as error:
        found = error.solution  # an ideal wheel that is held down may lead anywhere
        if held_down or unloading(found) is None:
            raise
    event = None if held_down else unloading(found)
    if event is None:
        stopped = (found.record.stopped_by or "").startswith(upward.label)
        return Ride(parameters, found, Event("fallen", float(found.final.t)) if stopped else None)
    if output is not None:
        settings["output"] = [*found.t[found.t < event.t], event.t]
    return Ride(parameters, simulate(system, event.t, **settings), event)


@click.command()
@bicycle_argument
@click.option(
    "--manoeuvre", type=click.Choice([*MANOEUVRES]), default="push", show_default=True, help="What happens; see --list."
)
@click.option("--list", "only_list", is_flag=True, help="List the manoeuvres.")
@click.option("--speed", type=float, help="At the start [m/s]; default: that of the manoeuvre.")
@click.option("--t-end", type=float, help="End of the ride [s]; default: that of the manoeuvre.")
@click.option(
    "--fallen", type=float, default=f"{np.degrees(FALLEN):g}", show_default=True, help="Tilt that ends it [°]."
)
@click.option("--held-down", is_flag=True, help="Go on where a wheel would lift, as if the ground could pull.")
@click.option("--view", "viewed", is_flag=True, help="Write a page (.html) too that shows the ride.")
@out_option
def command(
    parameters: Parameters, manoeuvre: str, only_list: bool, speed: float | None, t_end: float | None, fallen: float,
    held_down: bool, viewed: bool, out: str,
) -> None:  # fmt: skip
    """Let a bicycle go without hands: nonlinear motion, forces of the ground, friction they need, and falls.

    Writes a figure, a table (.csv) and the whole run (.npz, read by mbsd3d.load), named after bicycle, manoeuvre and
    what was changed of it. Ctrl-C keeps what was computed. The exit code is 1 if the certificate of the run fails.
    """
    if only_list:
        width = max(map(len, MANOEUVRES))
        click.echo("\n".join(f"{name:{width}}  {chosen.title}" for name, chosen in MANOEUVRES.items()))
        return
    can_view(needed=viewed)
    chosen = MANOEUVRES[manoeuvre]
    given = {"speed": speed, "t_end": t_end}
    arguments = chosen.arguments | {key: value for key, value in given.items() if value is not None}
    if arguments["speed"] == 0.0:
        raise ValueError("ride: --speed 0: a manoeuvre needs a bicycle that rolls; give a speed in m/s")
    name = "_".join([parameters.name, manoeuvre, *changes(chosen, arguments, fallen, held_down)])
    target = ready_folder(out) / name
    try:
        samples = int(np.clip(RATE * arguments["t_end"], 2, MOST)) + 1
        found = run(parameters, fallen=np.radians(fallen), held_down=held_down, output=samples, **arguments)
    except IntegrationError as error:
        keep(error.solution, target)
        raise
    click.echo(f"{chosen.title}\n{found}")
    write(found, target, chosen.title, viewed)
    if found.interrupted:
        raise click.exceptions.Exit(INTERRUPTED)
    if not found.solution.certificate.passed:
        raise click.exceptions.Exit(1)


def changes(chosen: Manoeuvre, arguments: Mapping[str, Any], fallen: float, held_down: bool) -> list[str]:
    """What differs from the manoeuvre, for the names of files: rides that differ do not replace each other."""
    numbers = {"speed": (arguments["speed"], chosen.speed), "t-end": (arguments["t_end"], chosen.t_end)}
    numbers["fallen"] = fallen, np.degrees(FALLEN)
    texts = {key: [f"{value:.12g}" for value in pair] for key, pair in numbers.items()}
    return [f"{key}{given}" for key, (given, usual) in texts.items() if given != usual] + ["held-down"] * held_down


def write(found: Ride, target: Path, title: str, viewed: bool) -> None:
    """Everything a person wants to keep of a ride; the names of the files are printed."""
    from mbsd3d.plotting.plots import save_figure

    from .ride_figure import plot

    files = [
        found.solution.save(target),
        found.to_csv(target),
        *save_figure(plot(found, title), target),
    ]
    if viewed:
        files.append(view(found, target, title=f"{found.parameters.name}: {title}"))
    for path in files:
        click.echo(str(path))


def view(found: Ride, path: str | Path | None = None, title: str | None = None) -> Any:
    """A page that goes along with the frame: traces of both hubs, and steer, loads and energies as curves.

    Frame and rear wheel have one point of reference: names would stand on each other.
    """
    system = found.solution.system
    traces = [(body, body.position) for body in (system.part(f"{wheel} wheel") for wheel in WHEELS)]
    curves = [("angle", "steer"), *(("reaction", f"{wheel} contact") for wheel in WHEELS), "energy"]
    shown = found.solution.animate(
        title=title, traces=traces, curves=curves, shown="reaction force", hidden="body names", follow="frame"
    )
    return shown if path is None else shown.save(path)
