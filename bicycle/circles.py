"""Circles: steady turns without hands, with the stability of each, and turns that a steer torque holds."""

from collections.abc import Sequence

import click
import numpy as np
from scipy.optimize import brentq

from mbsd3d.base.checks import number
from mbsd3d.base.paths import with_suffix, write_atomically
from mbsd3d.base.progress import Progress
from mbsd3d.cli.support import INTERRUPTED, can_view, ready_folder

from .circle_table import summary, table
from .families import SECTIONS, Family, Search, follow_all, special_points
from .options import bicycle_argument, out_option
from .parameters import Parameters
from .turning import Turn, Turner, course

LEANS = np.radians([1.0, *np.arange(2.5, 41.0, 2.5)])
"""Of the turns with steer torque that the command makes [rad]."""


def families(
    parameters: Parameters, *, longest: float = 0.1, progress: bool | None = None, keep: list[Family] | None = None
) -> list[Family]:
    """All hands-free circles with a steer angle to the right; those to the left are their mirror images.

    Parameters
    ----------
    parameters : Parameters
    longest : float
        Longest step in the plane of lean and steer [rad].
    progress : bool or None
        Show a progress bar; None = on a terminal, after two seconds.
    keep : list or None
        Filled with the families as they are found, so that Ctrl-C leaves them there.

    Returns
    -------
    list of Family
        Each from end to end: straight running at the capsize speed, also with the front end reversed; rest (the static
        limit); a wheel that lifts; nearly lying. Looked for on the sections `bicycle.families.SECTIONS` of constant
        steer angle: a family that crosses none of them is not found.

    Raises
    ------
    ValueError
        If gravity is zero: nothing turns then.
    """
    if parameters.g == 0.0:
        raise ValueError(f"bicycle '{parameters.name}': g = 0: without gravity there are no steady turns; give g > 0")
    found = [] if keep is None else keep
    with Progress("circles: families", 0.0, len(SECTIONS), progress) as bar:
        search = Search.of(parameters, longest, bar.update)
        for done, points, ends in follow_all(search):
            turns = []
            for k, x in enumerate(points):
                turns.append(search.turn(x))
                turns[-1].eigenvalues  # noqa: B018 -- the costly part, kept by the turn
                bar.update(done + k / len(points))
            found.append(Family(tuple(turns), ends, tuple(special_points(search, points, turns))))
    return found


def turn(parameters: Parameters, lean: float, steer: float) -> Turn:
    """The steady turn with a lean and a steer angle, and the speed and steer torque that hold it.

    Parameters
    ----------
    parameters : Parameters
    lean, steer : float
        To the right > 0 [rad]; steer is not zero.

    Returns
    -------
    Turn

    Raises
    ------
    ValueError
        If there is no pose on both wheels, or no speed balances this lean.

    Examples
    --------
    >>> from bicycle import Meijaard2007, circles
    >>> leaning = circles.turn(Meijaard2007(), 0.3, 0.2)
    >>> round(leaning.speed, 6), round(leaning.torque, 6)
    (4.037783, -0.330445)
    """
    lean, steer = number(lean, "circles.turn: lean"), number(steer, "circles.turn: steer")
    if np.sin(steer) == 0.0:
        raise ValueError("circles.turn: steer = 0: a straight wheel makes no turn; give a steer angle")
    return Turner(parameters).turn(lean, steer)


def held(parameters: Parameters, speed: float, leans: Sequence[float], *, turner: Turner | None = None) -> list[Turn]:
    """Steady turns at one speed, each with the steer angle and the steer torque that it needs.

    Parameters
    ----------
    parameters : Parameters
    speed : float
        Of the rear contact [m/s] > 0.
    leans : sequence of float
        To the right > 0, not zero [rad].
    turner : Turner or None
        Of the same bicycle: it remembers what other speeds needed too.

    Returns
    -------
    list of Turn
        Those with the least steer angle into the turn.

    Raises
    ------
    ValueError
        If no steer angle below 86 degrees makes such a turn.
    """
    turner, speed = turner or Turner(parameters), number(speed, "circles.held: speed", positive=True)
    found = []
    for lean in leans:
        side = np.sign(number(lean, "circles.held: lean"))
        if side == 0.0:
            raise ValueError("circles.held: lean = 0: an upright bicycle goes straight; give a lean")

        def excess(steer: float, lean: float = float(lean), side: float = side) -> float:
            return turner.square(lean, side * steer) - speed**2

        grid = np.geomspace(1e-4, 1.5, 40)  # the gentlest turn needs the highest speed
        last = next((k for k, steer in enumerate(grid) if excess(steer) < 0.0), 0)
        steer = brentq(excess, grid[last - 1], grid[last], xtol=1e-13) if last else np.nan
        if not last or abs(excess(steer)) > 1e-6 * speed**2:  # the square changes its sign at infinity too
            raise ValueError(
                f"bicycle '{parameters.name}': no steady turn of {speed:g} m/s at lean {np.degrees(lean):.4g}° with a "
                "steer angle below 86°; give a smaller lean or another speed"
            )
        found.append(turner.turn(lean, side * steer))
    return found


def pivot(parameters: Parameters, yaw_rate: float) -> Turn:
    """The turn in which the rear contact stays in place and the front wheel rolls around it, held by a steer torque.

    Parameters
    ----------
    parameters : Parameters
    yaw_rate : float
        > 0, to the right [rad/s]; to the left everything is mirrored.

    Returns
    -------
    Turn
        That with the least lean; the centre of mass is nearly above the line between the contacts.

    Raises
    ------
    ValueError
        If no lean below 60 degrees balances it.
    """
    turner, rate = Turner(parameters), number(yaw_rate, "circles.pivot: yaw_rate", positive=True)
    square = (parameters.w * rate) ** 2

    def steer_of(lean: float) -> float:
        return brentq(lambda x: course(parameters, turner.pose(lean, x))[0], 0.5, np.pi - 0.5, xtol=1e-15)

    def tip(lean: float) -> float:
        """What of the accelerations a steer torque cannot balance."""
        rest, motion, torque = turner.balance(lean, steer_of(lean))
        left = rest + square * motion
        return float(left[0] * torque[1] - left[1] * torque[0])

    grid = np.radians(np.linspace(-60.0, 60.0, 25))
    change = np.flatnonzero(np.diff(np.signbit([tip(lean) for lean in grid])))
    if not change.size:
        raise ValueError(f"circles.pivot: no lean below 60 degrees balances {rate:g} rad/s; give another rate")
    k = change[np.argmin(np.abs(grid[change]))]
    lean = brentq(tip, grid[k], grid[k + 1], xtol=1e-14)
    return turner.turn(lean, steer_of(lean))


def held_if_possible(
    parameters: Parameters, speeds: Sequence[float], found: list[list[Turn]], *, progress: bool | None = None
) -> None:
    """Fill ``found`` with turns with steer torque by speed; a lean that no turn of this speed has ends its list."""
    turner = Turner(parameters)
    with Progress("circles: steer torques", 0.0, len(speeds), progress) as bar:
        for done, speed in enumerate(speeds):
            found.append([])
            for k, lean in enumerate(LEANS):
                bar.update(done + k / len(LEANS))
                try:
                    found[-1] += held(parameters, speed, [lean], turner=turner)
                except ValueError as error:
                    click.echo(f"mbsd3d: {error}", err=True)
                    break


@click.command()
@bicycle_argument
@click.option(
    "--speed", "speeds", type=float, multiple=True, default=(3.0, 5.0, 7.0, 9.0), show_default=True,
    help="Of turns that a steer torque holds [m/s]; may be given several times.",
)  # fmt: skip
@click.option("--view", "viewed", is_flag=True, help="Write a page (.html) too: a round of the first family.")
@out_option
def command(parameters: Parameters, speeds: tuple[float, ...], viewed: bool, out: str) -> None:
    """Find the circles a bicycle rides without hands, and the torque that holds it in other turns.

    Hands-free circles come in families that begin and end where the bicycle goes straight, rests, lies or lifts a
    wheel; the stability of each is computed. Writes a figure and a table (.csv) of all turns.
    """
    from mbsd3d.plotting.plots import save_figure

    from .circle_figure import plot

    can_view(needed=viewed)
    target = ready_folder(out) / f"{parameters.name}_circles"
    found: list[Family] = []
    turns: list[list[Turn]] = []
    try:
        families(parameters, keep=found)
        held_if_possible(parameters, speeds, turns)
    except KeyboardInterrupt:
        click.echo("mbsd3d: interrupted; what was found until then is kept", err=True)
        interrupted = True
    else:
        interrupted = False
    click.echo(summary(found))
    held_turns = [turn for group in turns for turn in group]
    files = [write_atomically(with_suffix(target, ".csv"), table(found, held_turns).encode())]
    files += save_figure(plot(parameters, found, turns), target)
    if viewed and found and not interrupted:
        from .ride import view

        shown = max((turn for name, turn in found[0].special or [("", found[0].turns[0])]), key=lambda turn: turn.speed)
        title = f"{parameters.name}: a circle without hands, lean {np.degrees(shown.lean):.1f}°"
        files.append(view(shown.ride(output=400), target, title=title))
    for path in files:
        click.echo(str(path))
    if interrupted:
        raise click.exceptions.Exit(INTERRUPTED)
