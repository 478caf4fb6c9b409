"""Effects that ideal wheels leave out, in one figure: growth over the speed, steering response, and turns up to the
limit.
"""

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from mbsd3d.errors import InputError
from mbsd3d.extend import GRID_WIDTH_POINTS, LINE_WIDTH_POINTS, Theme, label_decades, new_figure, number, style_axes

from ..linear import frequency
from ..linear.general import eigenvalues
from ..linear.tyre_equations import Affine, SpeedBySpeed, equations
from ..model.mechanism import whipple
from ..parameters import Parameters
from ..turns import on_tyres
from ..turns.circles import held_if_possible
from ..turns.turning import Turn

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SPEEDS = np.linspace(0.1, 12.0, 120)  # [m/s]
FREQUENCIES = np.geomspace(0.3, 300.0, 400)  # [rad/s]
LEANS = np.arange(0.025, 1.2, 0.025)  # [rad]
GROWTH_RANGE = (-8.0, 6.0)  # [1/s] of the growth


def figure(parameters: Parameters, fittings: Mapping[str, Any], *, speed: float = 5.0, dark: bool = False) -> "Figure":
    """Plot a bicycle on tyres in colour, on ideal wheels in grey.

    Growth of the sideways modes over the speed: ideal wheels know no wobble. Steer by a steer torque over the
    frequency, at one speed: tyres give way to fast steering. Torque that holds a turn at this speed, and the grip that
    the turn takes, over the lean: an ideal wheel rides turns for which there is no grip.

    Parameters
    ----------
    fittings : mapping
        ``tyres`` and more, as `bicycle.whipple` takes them.
    speed : float
        Of turns and steering [m/s].

    Raises
    ------
    ValueError
        If there are no tyres, or no such turn.
    """
    if fittings.get("tyres") is None:
        raise InputError(f"bicycle '{parameters.name}': no tyres to compare; give tyres=, e.g. bicycle.TYPICAL")
    speed = number(speed, "ideal or tyres: speed", positive=True)
    linear = equations(partial(whipple, **fittings), parameters)
    with new_figure(10.0, 7.6, dark) as (sheet, look):
        (growth, shaken), (torque, grip) = sheet.subplots(2, 2)
        for axes in (growth, shaken, torque, grip):
            style_axes(axes, look)
        draw_growth(growth, parameters, linear, look)
        draw_steering(shaken, parameters, fittings, speed, look)
        draw_turns((torque, grip), parameters, fittings, speed, look)
        handles, names = growth.get_legend_handles_labels()
        sheet.legend(handles, names, loc="outside lower center", ncols=2, frameon=False, labelcolor=look.ink)
        sheet.suptitle(f"{parameters.name}: what ideal wheels leave out", fontweight="bold")
    return sheet


def draw_growth(axes: "Axes", parameters: Parameters, linear: Affine | SpeedBySpeed, look: Theme) -> None:
    """Draw the largest growths over the speed as dots, which need no names."""
    ideal = eigenvalues(whipple, parameters, SPEEDS).real
    found = [np.linalg.eigvals(linear.A(v)).real for v in SPEEDS.tolist()]
    style: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 3.0}
    for values, colour, label in ((ideal, look.muted, "on ideal wheels"), (np.array(found), look.lines[0], "on tyres")):
        axes.plot(SPEEDS, values, color=colour, **style)
        axes.plot([], [], color=colour, linewidth=LINE_WIDTH_POINTS, label=label)
    axes.axhline(0.0, color=look.ink, linewidth=GRID_WIDTH_POINTS)
    axes.set_xlim(0.0, SPEEDS[-1])
    axes.set_ylim(*GROWTH_RANGE)
    axes.set_xlabel("speed [m/s]")
    axes.set_ylabel("growth of the modes [1/s]")


def draw_steering(axes: "Axes", parameters: Parameters, fittings: Mapping[str, Any], speed: float, look: Theme) -> None:
    """Draw steer by steer torque over the frequency."""
    ideal = partial(whipple, steer_damping=fittings.get("steer_damping", 0.0))
    for colour, H in (
        (look.muted, frequency.response(parameters, speed, FREQUENCIES, ideal).H),
        (look.lines[0], frequency.response(parameters, speed, FREQUENCIES, **fittings).H),
    ):
        axes.loglog(FREQUENCIES, np.abs(H[0, :, 1, 1]), color=colour, linewidth=LINE_WIDTH_POINTS)
    for axis in (axes.xaxis, axes.yaxis):
        label_decades(axis)
    axes.set_xlabel("frequency ω [rad/s]")
    axes.set_ylabel(f"steer by torque at {speed:g} m/s [rad/(N m)]")


def draw_turns(
    panels: tuple["Axes", "Axes"], parameters: Parameters, fittings: Mapping[str, Any], speed: float, look: Theme
) -> None:  # fmt: skip
    """Draw steer torque and friction over the lean, with a rigid head; a dot marks the limit of grip."""
    found: list[list[Turn]] = []
    held_if_possible(parameters, [speed], found, lambda text: None, progress=False)
    on_grip = on_tyres.turns(parameters, fittings["tyres"], speed, LEANS)
    lines = [
        (look.muted, [(x.lean, x.torque, x.friction) for x in found[0]]),
        (look.lines[0], [(x.lean, x.steer_torque, x.friction) for x in on_grip]),
    ]
    for colour, turns in lines:
        lean, *values = np.transpose(turns) if turns else np.zeros((3, 0))
        for axes, value in zip(panels, values, strict=True):
            axes.plot(np.degrees(lean), value, color=colour, linewidth=LINE_WIDTH_POINTS)
    for axes, value in zip(panels, values, strict=True):
        axes.plot(np.degrees(lean[-1:]), value[-1:], "o", color=look.lines[0], markersize=5)
        axes.set_xlabel("lean in a steady turn [°]")
    panels[0].set_ylabel(f"steer torque at {speed:g} m/s [N m]")
    panels[1].set_ylabel("friction the turn takes [-]")
