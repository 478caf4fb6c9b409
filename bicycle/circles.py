"""Circles: steady turns without hands, with the stability of each, and turns that a steer torque holds."""

from collections.abc import Sequence
from pathlib import Path

import click
import numpy as np
from scipy.optimize import brentq

from mbsd3d.commands import ready_folder
from mbsd3d.files import write_atomically
from mbsd3d.parts import number
from mbsd3d.progress import Progress

from .families import Family, follow_all, special_points
from .options import bicycle_argument, out_option
from .parameters import Parameters
from .turning import Turn, Turner, course

LEANS = np.radians([1.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0])
"""Of the turns with steer torque that the command makes [rad]."""
COLUMNS = {"lean": "rad", "steer": "rad", "speed": "m/s", "yaw_rate": "rad/s", "radius": "m", "torque": "N m",
           "load": "N", "friction": "-", "growth": "1/s"}  # fmt: skip


def families(parameters: Parameters, *, longest: float = 0.1, progress: bool | None = None) -> list[Family]:
    """All hands-free circles with a steer angle to the right; those to the left are their mirror images.

    Parameters
    ----------
    parameters : Parameters
    longest : float
        Longest step in the plane of lean and steer [rad].
    progress : bool or None
        Show a progress bar; None = on a terminal, after two seconds.

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
    search, curves, ends = follow_all(parameters, longest, progress)
    found, total = [], sum(map(len, curves))
    with Progress("circles: stability", 0.0, total, progress) as bar:
        for points, names in zip(curves, ends, strict=True):
            turns = [search.turn(x) for x in points]
            for turn in turns:
                turn.growth  # noqa: B018 -- the costly part, kept by the turn
                bar.update(bar.start + 1)
            found.append(Family(tuple(turns), names, tuple(special_points(search, points, turns))))
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
    (4.037785, -0.330445)
    """
    lean, steer = number(lean, "circles.turn: lean"), number(steer, "circles.turn: steer")
    if np.sin(steer) == 0.0:
        raise ValueError("circles.turn: steer = 0: a straight wheel makes no turn; give a steer angle")
    return Turner(parameters).turn(lean, steer)


def held(parameters: Parameters, speed: float, leans: Sequence[float]) -> list[Turn]:
    """Steady turns at one speed, each with the steer angle and the steer torque that it needs.

    Parameters
    ----------
    parameters : Parameters
    speed : float
        Of the rear contact [m/s] > 0.
    leans : sequence of float
        To the right > 0, not zero [rad].

    Returns
    -------
    list of Turn
        Those with the least steer angle into the turn.

    Raises
    ------
    ValueError
        If no steer angle below 90 degrees makes such a turn.
    """
    turner, speed = Turner(parameters), number(speed, "circles.held: speed", positive=True)
    found = []
    for lean in leans:
        side = np.sign(number(lean, "circles.held: lean"))
        if side == 0.0:
            raise ValueError("circles.held: lean = 0: an upright bicycle goes straight; give a lean")

        def excess(steer: float, lean: float = float(lean), side: float = side) -> float:
            at = course(parameters, turner.pose(lean, side * steer))[0]
            return turner.balance(lean, side * steer).held[0] * at**2 - speed**2

        grid = np.geomspace(1e-4, 1.5, 40)  # the gentlest turn needs the highest speed
        last = next((k for k, steer in enumerate(grid) if excess(steer) < 0.0), 0)
        if not last:
            raise ValueError(
                f"circles.held: no steady turn of {speed:g} m/s at lean {lean:.6g} rad; give a smaller lean"
            )
        found.append(turner.turn(lean, side * brentq(excess, grid[last - 1], grid[last], xtol=1e-13)))
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

    grid = np.radians(np.linspace(-60.0, 60.0, 81))
    change = np.flatnonzero(np.diff(np.signbit([tip(lean) for lean in grid])))
    if not change.size:
        raise ValueError(f"circles.pivot: no lean below 60 degrees balances {rate:g} rad/s; give another rate")
    k = change[np.argmin(np.abs(grid[change]))]
    lean = brentq(tip, grid[k], grid[k + 1], xtol=1e-14)
    return turner.turn(lean, steer_of(lean))
