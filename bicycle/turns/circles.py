"""Circles: steady turns without hands, with the stability of each, and turns held by a steer torque."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import Akima1DInterpolator
from scipy.optimize import brentq

from mbsd3d.errors import InputError
from mbsd3d.extend import LINE_WIDTH_POINTS, Progress, Theme, new_figure, number, style_axes, write_table

from ..linear.equations import checked_list
from ..parameters import Parameters
from ..rides.motion import legend_above
from .families import SECTION_STEERS, Family, Search, follow_all, special_points
from .turning import Turn, TurnSolver, course

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEANS = np.radians([1.0, *np.arange(2.5, 41.0, 2.5)])
"""Of the turns with steer torque in the figure of the command line [rad]."""
TORQUE_ROUNDING = 1e-12
"""Sine of a steer angle that is straight ahead or reversed."""
COLUMNS = {
    "lean": "rad", "steer": "rad", "speed": "m/s", "yaw_rate": "rad/s", "radius": "m", "torque": "N m", "load": "N",
    "friction": "-", "growth": "1/s",
}  # fmt: skip
"""Of the table: quantities of a turn with their units."""
MARKS = {"largest lean": "^", "stability changes": "D", "about the rear contact": "s"}
UNITS = {"steer": "steer angle [°]", "lean": "lean [°]", "speed": "speed of the rear contact [m/s]",
         "radius": "radius of the rear track, right > 0 [m]"}  # fmt: skip


def families(
    parameters: Parameters, *, longest: float = 0.1, progress: bool | None = None, keep: list[Family] | None = None
) -> list[Family]:
    """Find all hands-free circles with a steer angle to the right; those to the left are their mirror images.

    Parameters
    ----------
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
        limit); a wheel that lifts; nearly lying. A family that crosses none of the steer angles
        `bicycle.turns.families.SECTION_STEERS` is not found.

    Raises
    ------
    ValueError
        If gravity is zero: then there are no steady turns.
    """
    if parameters.g == 0.0:
        raise InputError(f"bicycle '{parameters.name}': g = 0: without gravity there are no steady turns; give g > 0")
    found = [] if keep is None else keep
    with Progress("circles: families", 0.0, len(SECTION_STEERS), progress) as bar:
        search = Search.of(parameters, longest, bar.update)
        for done, points, ends in follow_all(search):
            turns = []
            for k, x in enumerate(points):
                turns.append(search.turn(x))
                turns[-1].eigenvalues  # noqa: B018 -- the costly part, cached by the turn
                bar.update(done + k / len(points))
            found.append(Family(tuple(turns), ends, tuple(special_points(search, points, turns))))
    return found


def turn(parameters: Parameters, lean: float, steer: float) -> Turn:
    """Compute the steady turn with a lean and a steer angle [rad], to the right > 0: the speed and torque that hold it.

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
    if abs(np.sin(steer)) < TORQUE_ROUNDING:
        raise InputError(f"circles.turn: steer = {steer:g}: a straight wheel makes no turn; give a steer angle")
    return TurnSolver(parameters).turn(lean, steer)


def held(
    parameters: Parameters, speed: float, leans: Sequence[float], *, turner: TurnSolver | None = None
) -> list[Turn]:
    """Compute steady turns at one speed, each with its least steer angle into the turn and the steer torque that it
    needs.

    Parameters
    ----------
    speed : float
        Of the rear contact [m/s] > 0.
    leans : sequence of float
        To the right > 0, not zero [rad].
    turner : TurnSolver or None
        Of the same bicycle, to use again what it found for other speeds.

    Raises
    ------
    ValueError
        If no steer angle below 86 degrees makes such a turn.
    """
    turner, speed = turner or TurnSolver(parameters), number(speed, "circles.held: speed", positive=True)
    found = []
    for lean in checked_list(leans, "circles.held: leans", "finite ones in rad"):
        side = np.sign(lean)
        if side == 0.0:
            raise InputError("circles.held: lean = 0: an upright bicycle goes straight; give a lean")

        def excess(steer: float, lean: float = float(lean), side: float = side) -> float:
            return turner.square(lean, side * steer) - speed**2

        grid = np.geomspace(1e-4, 1.5, 40)  # the gentlest turn needs the highest speed
        last = next((k for k, steer in enumerate(grid) if excess(steer) < 0.0), 0)
        steer = brentq(excess, grid[last - 1], grid[last], xtol=1e-13) if last else np.nan
        if not last or abs(excess(steer)) > 1e-6 * speed**2:  # the square changes its sign at infinity too
            raise InputError(
                f"bicycle '{parameters.name}': no steady turn of {speed:g} m/s at lean {np.degrees(lean):.4g}° with a "
                "steer angle below 86°; give a smaller lean or another speed"
            )
        found.append(turner.turn(lean, side * steer))
    return found


def pivot(parameters: Parameters, yaw_rate: float) -> Turn:
    """Compute the turn about the rear contact, which stays in place while the front wheel rolls around it; held by a
    torque.

    Of several turns that with the least lean; the centre of mass is nearly above the line between the contacts.

    Parameters
    ----------
    yaw_rate : float
        > 0, to the right [rad/s]; to the left everything is mirrored.
    """
    turner, rate = TurnSolver(parameters), number(yaw_rate, "circles.pivot: yaw_rate", positive=True)
    square = (parameters.w * rate) ** 2

    def steer_of(lean: float) -> float:
        return brentq(lambda x: course(parameters, turner.pose(lean, x))[0], 0.5, np.pi - 0.5, xtol=1e-15)

    def tip(lean: float) -> float:
        """Return the part of the accelerations that a steer torque cannot balance."""
        rest, motion, torque = turner.balance(lean, steer_of(lean))
        left = rest + square * motion
        return float(left[0] * torque[1] - left[1] * torque[0])

    grid = np.radians(np.linspace(-60.0, 60.0, 25))
    change = np.flatnonzero(np.diff(np.signbit([tip(lean) for lean in grid])))
    if not change.size:
        raise InputError(f"circles.pivot: no lean below 60 degrees balances {rate:g} rad/s; give another rate")
    k = change[np.argmin(np.abs(grid[change]))]
    lean = brentq(tip, grid[k], grid[k + 1], xtol=1e-14)
    return turner.turn(lean, steer_of(lean))


def held_if_possible(
    parameters: Parameters, speeds: Sequence[float], found: list[list[Turn]], tell: Callable[[str], object],
    *, progress: bool | None = None,
) -> None:  # fmt: skip
    """Fill ``found`` with turns held by a steer torque, a list per speed; at the first that fails ``tell`` says why."""
    turner = TurnSolver(parameters)
    with Progress("circles: steer torques", 0.0, len(speeds), progress) as bar:
        for done, speed in enumerate(speeds):
            found.append([])
            for k, lean in enumerate(LEANS):
                bar.update(done + k / len(LEANS))
                try:
                    found[-1] += held(parameters, speed, [lean], turner=turner)
                except ValueError as error:
                    tell(str(error))
                    break


def to_csv(found: Sequence[Family], turns: Sequence[Turn], path: str | Path) -> Path:
    """Write one row per turn: its family (0 = held by a steer torque), then `COLUMNS`; return the file."""
    rows = [(k, turn) for k, family in enumerate(found, 1) for turn in family.turns] + [(0, turn) for turn in turns]
    head = ["family", *(f"{name} [{unit}]" for name, unit in COLUMNS.items())]
    return write_table(path, head, ([str(k), *(getattr(turn, name) for name in COLUMNS)] for k, turn in rows))


def summary(found: Sequence[Family]) -> str:
    """Return the families as text, one line per end and special turn."""
    lines = []
    for k, family in enumerate(found, 1):
        lines.append(f"family {k}: from {family.ends[0]} to {family.ends[1]}, {len(family.turns)} circles")
        first, last = family.turns[0], family.turns[-1]
        for name, turn in ((family.ends[0], first), *family.special, (family.ends[1], last)):
            friction = f"{turn.friction:.3f}" if turn.friction < 10.0 else "above 10"
            lines.append(
                f"  {name:28} lean {np.degrees(turn.lean):7.3f}°  steer {np.degrees(turn.steer):7.3f}°  speed "
                f"{turn.speed:8.5f} m/s  radius {turn.radius:9.4f} m  friction {friction}"
            )
    return "\n".join(lines) or "no hands-free circles on the sections that were searched"


def plot_circles(
    parameters: Parameters, found: Sequence[Family], held: Sequence[Sequence[Turn]] = (), *, dark: bool = False
) -> "Figure":
    """Plot lean, speed and radius of the families, and steer torque over lean of the turns ``held`` at one speed
    each."""
    with new_figure(10.0, 8.4, dark) as (figure, look):
        figure.set_layout_engine("constrained", w_pad=0.1, h_pad=0.1)
        axes = figure.subplots(2, 2)
        for one in axes.flat:
            style_axes(one, look)
        draw_families(axes[0, 0], found, "steer", "lean", look)
        draw_families(axes[0, 1], found, "lean", "speed", look)
        draw_families(axes[1, 0], found, "speed", "radius", look)
        axes[1, 0].set_yscale("symlog", linthresh=1.0)
        axes[1, 0].set_ylim(-100.0, 100.0)
        axes[1, 0].yaxis.set_major_formatter("{x:g}")
        draw_torques(axes[1, 1], held, look)
        figure.suptitle(f"{parameters.name}: steady circles, steered to the right", fontweight="bold")
        legend(figure, len(found), look)
    return figure


def shown(values: np.ndarray, name: str) -> np.ndarray:
    """Return angles in degrees, other values unchanged."""
    return np.degrees(values) if name in ("steer", "lean") else values


def draw_families(axes: "Axes", found: Sequence[Family], x: str, y: str, look: Theme) -> None:
    """Draw one quantity over another; thick where stable, with marks at special turns."""
    for k, family in enumerate(found):
        across, up = (shown(family.values(name), name) for name in (x, y))
        stable = np.where(family.values("stable"), up, np.nan)
        axes.plot(across, up, color=look.colour(k), linewidth=LINE_WIDTH_POINTS)
        axes.plot(across, stable, color=look.colour(k), linewidth=3.5 * LINE_WIDTH_POINTS, solid_capstyle="butt")
        for name, turn in family.special:
            place = [shown(np.array([getattr(turn, q)]), q) for q in (x, y)]
            axes.plot(*place, MARKS[name], color=look.colour(k), markersize=5, markeredgecolor=look.ink)
    axes.set_xlabel(UNITS[x])
    axes.set_ylabel(UNITS[y])


def draw_torques(axes: "Axes", held: Sequence[Sequence[Turn]], look: Theme) -> None:
    """Draw steer torque over lean, a smooth line per speed through the points of the turns."""
    for k, turns in enumerate(turn for turn in held if turn):
        points = np.array([(np.degrees(turn.lean), turn.torque) for turn in turns])
        axes.plot(*points.T, "o", color=look.colour(k), markersize=3)
        axes.plot(
            *smooth(points).T, color=look.colour(k), linewidth=LINE_WIDTH_POINTS, label=f"{turns[0].speed:.3g} m/s"
        )
    axes.set_xlabel("lean [°]")
    axes.set_ylabel("steer torque that holds it, right > 0 [N m]")
    if axes.get_legend_handles_labels()[0]:
        legend_above(axes, look)


def smooth(points: np.ndarray) -> np.ndarray:
    """Return a curve (k, 2) through points (n, 2) with little overshoot; a single point stays as it is."""
    count = len(points)
    if count < 2:
        return points
    return Akima1DInterpolator(np.arange(count), points, method="makima")(np.linspace(0, count - 1, 10 * count - 9))


def legend(figure: "Figure", count: int, look: Theme) -> None:
    """Draw families, marks and line widths below all panels."""
    from matplotlib.lines import Line2D  # only who draws waits for it

    entries = [
        Line2D([], [], color=look.colour(k), linewidth=LINE_WIDTH_POINTS, label=f"family {k + 1}") for k in range(count)
    ]
    entries.append(Line2D([], [], color=look.muted, linewidth=3.5 * LINE_WIDTH_POINTS, label="stable"))
    for name, mark in MARKS.items():
        entries.append(Line2D([], [], color=look.muted, marker=mark, linestyle="none", markersize=5, label=name))
    figure.legend(handles=entries, frameon=False, labelcolor=look.ink, loc="outside lower center", ncols=4)
