"""Figures of a study, in the house style."""

from typing import TYPE_CHECKING

import numpy as np

from bicycle.output import new_figure
from mbsd3d.extend import LINE, THIN, dress
from validation.engine_balance import gas, phasor
from validation.nvh.study import Study

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN = 5  # orders of a figure
TALL = 0.35  # of the height of a waterfall that its highest peak takes


def largest_orders(study: Study) -> tuple[np.ndarray, np.ndarray]:
    """(numbers of the largest orders in the map, (s, n) size of their forces on the car [N])."""
    size = np.linalg.norm(np.abs(study.map.force), axis=-1).max(axis=2)
    ranked = np.argsort(-size.max(axis=0))[:SHOWN]
    return np.sort(ranked[size.max(axis=0)[ranked] > 1e-4 * size.max()]), size


def waterfall(study: Study) -> "Figure":
    """Largest force of a mount over frequency and speed: orders are lines from the left corner."""
    chosen, size = largest_orders(study)
    rpm, orders = study.map.rpm, study.map.orders
    unit = TALL * np.ptp(rpm) / size.max()
    with new_figure(7.5, 4.4) as (made, look):
        axes = made.add_subplot()
        dress(axes, look)
        for i, speed in enumerate(rpm[::2]):
            at = orders * speed / 60
            axes.vlines(at, speed, speed + unit * size[2 * i], color=look.muted, linewidth=THIN)
        for line, k in enumerate(chosen):
            axes.plot(orders[k] * rpm / 60, rpm + unit * size[:, k], color=look.colour(line), linewidth=LINE)
            axes.annotate(f"{orders[k]:g}x", (orders[k] * rpm[-1] / 60, rpm[-1]), color=look.colour(line), fontsize=9)
        axes.set(xlabel="frequency [Hz]", ylabel="speed [1/min], and force of the hardest mount upwards")
        axes.set_title(f"tallest line: {size.max():.3g} N", loc="left")
    return made


def order_lines(study: Study) -> "Figure":
    """Force of the hardest mount over speed, order by order; dots are the full run."""
    chosen, size = largest_orders(study)
    with new_figure(7.5, 3.4) as (made, look):
        axes = made.add_subplot()
        dress(axes, look)
        full = np.linalg.norm(np.abs(study.run_force), axis=-1).max(axis=1)
        for line, k in enumerate(chosen):
            colour = look.colour(line)
            axes.semilogy(study.map.rpm, size[:, k], color=colour, linewidth=LINE, label=f"{study.map.orders[k]:g}x")
            axes.semilogy([study.rpm], [full[k]], "o", color=colour, markersize=6)
        axes.set(xlabel="speed [1/min]", ylabel="force [N]", ylim=(1e-4 * size.max(), 2 * size.max()))
        axes.yaxis.set_major_formatter(lambda x, _: f"{x:g}")
        axes.legend(frameon=False, labelcolor=look.ink, ncols=SHOWN, loc="lower right")
    return made


def working_cycle(study: Study) -> "Figure":
    """Pressure over volume and over the crank angle; torque of gas and inertia over the crank angle."""
    angle, cycle = np.linspace(0.0, 4 * np.pi, 1441), study.source.cycle
    engine = study.preset.engine(study.rpm)
    inertia = phasor.block_load(engine, 24, dyno=True).torque
    turning = -np.real(np.exp(1j * np.outer(angle, np.arange(inertia.size))) @ inertia)
    with new_figure(7.5, 5.0 if cycle else 2.6) as (made, look):
        axes = made.subplot_mosaic([["volume", "pressure"], ["torque", "torque"]] if cycle else [["torque"]])
        for part in axes.values():
            dress(part, look)
        if cycle:
            psi, p = cycle.samples
            axes["volume"].plot(1e3 * cycle.volume(psi), p / 1e5, color=look.colour(0), linewidth=LINE)
            axes["volume"].set(xlabel="volume of a cylinder [l]", ylabel="pressure [bar]")
            axes["pressure"].plot(np.degrees(psi), p / 1e5, color=look.colour(0), linewidth=LINE)
            axes["pressure"].set(xlabel="crank angle from firing [degrees]", xticks=range(-180, 541, 180))
            gases = gas.torque(engine, cycle.force, angle)
            axes["torque"].plot(np.degrees(angle), gases, color=look.colour(1), linewidth=LINE, label="gas")
            axes["torque"].plot(np.degrees(angle), gases + turning, color=look.ink, linewidth=LINE, label="both")
        axes["torque"].plot(np.degrees(angle), turning, color=look.colour(0), linewidth=LINE, label="inertia")
        axes["torque"].set(xlabel="crank angle [degrees]", ylabel="torque on the crank [N m]", xticks=range(0, 721, 90))
        made.legend(frameon=False, labelcolor=look.ink, ncols=3, loc="outside lower right")
    return made


def bearing_loads(study: Study) -> "Figure":
    """Radial loads of the main bearings over a cycle, and the paths of their vectors."""
    with new_figure(7.5, 3.2) as (made, look):
        over, path = made.subplots(1, 2, width_ratios=(4.0, 1.0))
        dress(over, look)
        dress(path, look)
        for k, bearing in enumerate(study.bearings):
            colour = look.colour(k)
            over.plot(bearing.angle, bearing.radial / 1e3, color=colour, linewidth=LINE, label=bearing.name)
            path.plot(-bearing.force[:, 1] / 1e3, -bearing.force[:, 0] / 1e3, color=colour, linewidth=THIN)
        over.set(xlabel="crank angle [degrees]", ylabel="radial load [kN]", xticks=range(0, 721, 180))
        made.legend(frameon=False, labelcolor=look.ink, fontsize=8, ncols=len(study.bearings), loc="outside upper left")
        path.set(xlabel="across [kN]", ylabel="along x, towards the head of an inline engine [kN]", aspect="equal")
        path.yaxis.label.set_size(8)
        path.locator_params(axis="x", nbins=2)
    return made
