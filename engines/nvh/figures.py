"""Figures of a study."""

from typing import TYPE_CHECKING

import numpy as np

from engines.balance.pages.portrait import upright
from engines.nvh.mounts.response import Map
from engines.nvh.study import Study, Sweep
from mbsd3d.extend import GRID_WIDTH_POINTS, LINE_WIDTH_POINTS, new_figure, style_axes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE_ORDERS = 5  # [1] orders of a figure
LINE_SPACING, PEAK_DECADES = 2, 3  # speeds of the map from line to line of a waterfall; what its peaks show
SEAT_SPEEDS = 201  # [1] speeds of the seat figure; modes of a shell with 3 % of damping are 6 % wide
FORCE_SHARE_MIN = 1e-3  # [1] of the 1x force of a cylinder; an engine with less has no force
HIGHEST_PEAK_SPACINGS = 5.0  # [1] speeds of the map that its highest peak takes


def largest(size: np.ndarray) -> np.ndarray:
    """Return the numbers of the orders of (s, n) with the largest values, in order."""
    ranked = np.argsort(-size.max(axis=0))[:FIGURE_ORDERS]
    return np.sort(ranked[size.max(axis=0)[ranked] > 1e-4 * size.max()])


def handed(force: np.ndarray) -> np.ndarray:
    """Return the force of the mount with the largest force, from (s, n, mounts, 3) phasors [N], shape (s, n)."""
    return np.linalg.norm(np.abs(force), axis=-1).max(axis=2)


def waterfall(study: Study, size: np.ndarray, unit: str) -> "Figure":
    """Plot the orders over the speed, (s, n): one line per speed, with a peak at the frequency of every order, in
    decades.
    """
    chosen, (rpm, orders) = largest(size), (study.map.rpm, study.map.orders)
    stacked = np.arange(0, rpm.size, LINE_SPACING)
    tall, most = HIGHEST_PEAK_SPACINGS * np.ptp(rpm) / (rpm.size - 1), size[:, chosen].max()
    height = tall * np.clip(1 + np.log10(np.maximum(size / most, 1e-300)) / PEAK_DECADES, 0.0, None)
    end = orders[chosen[-1]] * rpm[-1] / 60
    with new_figure(7.5, 5.2) as (made, look):
        axes = made.add_subplot()
        style_axes(axes, look)
        axes.grid(visible=False)
        axes.hlines(rpm[stacked], 0.0, 1.02 * end, color=look.grid, linewidth=GRID_WIDTH_POINTS)
        for line, k in enumerate(chosen):
            at, colour = orders[k] * rpm / 60, look.colour(line)
            tips, name = rpm + height[:, k], f"{orders[k]:g}x"
            axes.vlines(at[stacked], rpm[stacked], tips[stacked], color=colour, linewidth=LINE_WIDTH_POINTS, label=name)
            axes.plot(at, tips, color=colour, linewidth=GRID_WIDTH_POINTS)
        axes.set(xlabel="frequency [Hz]", ylabel="speed [1/min]", xlim=(0.0, 1.05 * end))
        axes.set_title(
            f"peaks: {PEAK_DECADES} decades up to {f'{most:.0f}' if most >= 100 else f'{most:.3g}'} {unit}", loc="left"
        )
        made.legend(frameon=False, labelcolor=look.ink, ncols=FIGURE_ORDERS, loc="outside lower right")
    return made


def on_block(study: Study) -> tuple[np.ndarray, str]:
    """Return the size (s, n) of the engine's forces on its block and its unit; of its moments for an engine without
    forces.
    """
    parts = (np.linalg.norm(np.abs(study.map.load[:, :, k : k + 3]), axis=2) for k in (0, 3))
    force, moment = (np.where(study.map.orders > 0, part, 0.0) for part in parts)
    single = study.preset.engine(study.preset.redline).single
    return (force, "N") if force.max() > FORCE_SHARE_MIN * single else (moment, "N m")


def order_lines(study: Study, swept: Sweep | None = None) -> "Figure":
    """Plot the force of the most loaded mount over speed, order by order; dots are full motions."""
    size = handed(study.map.force)
    chosen = largest(size)
    speeds, full = (study.rpm, study.run_force[None]) if swept is None else (swept.map.rpm, swept.full)
    with new_figure(7.5, 3.4) as (made, look):
        axes = made.add_subplot()
        style_axes(axes, look)
        for line, k in enumerate(chosen):
            colour = look.colour(line)
            axes.semilogy(
                study.map.rpm, size[:, k], color=colour, linewidth=LINE_WIDTH_POINTS, label=f"{study.map.orders[k]:g}x"
            )
            axes.semilogy(speeds, handed(full)[:, k], "o", color=colour, markersize=6 if swept is None else 3)
        axes.set(xlabel="speed [1/min]", ylabel="force [N]", ylim=(1e-4 * size.max(), 2 * size.max()))
        axes.yaxis.set_major_formatter(lambda x, _: f"{x:g}")
        made.legend(frameon=False, labelcolor=look.ink, ncols=FIGURE_ORDERS, loc="outside lower right")
    return made


def transmitted(study: Study, map: Map, force: np.ndarray) -> list[np.ndarray]:
    """Return the transmissibility from engine to car, order by order, nan for orders without load, shape (s, n):
    [force, or couple for an engine without forces, about y and z; moment about the crank].
    """
    at = np.array([mount.at for mount in study.placed])
    taken = np.concatenate([force.sum(axis=2), np.cross(at, force).sum(axis=2)], axis=2)
    first = slice(0, 3) if on_block(study)[1] == "N" else slice(4, 6)
    found = []
    for part in (first, slice(3, 4)):
        given, out = (np.linalg.norm(np.abs(both[:, :, part]), axis=2) for both in (map.load, taken))
        least = (
            1e-3 * np.linalg.norm(np.abs(map.load[:, 1:, 3:]), axis=2).max()
            if part.start
            else FORCE_SHARE_MIN * given.max()
        )
        there = (given > least) & (map.orders > 0)
        found.append(np.where(there, out / np.where(there, given, 1.0), np.nan))
    return found


def transmissibility(study: Study, swept: Sweep | None = None) -> "Figure":
    """Plot force and roll moment on the car over those of the engine, order by order; dots are full motions."""
    lines = transmitted(study, study.map, study.map.force)
    dots = transmitted(study, study.here, study.run_force[None])
    speeds, size = np.array([study.rpm]), 6
    if swept is not None:
        dots, speeds, size = transmitted(study, swept.map, swept.full), swept.map.rpm, 3
    chosen = largest(handed(study.map.force))
    titles = "force" if on_block(study)[1] == "N" else "couple", "roll"
    there = [part for part in zip(titles, lines, dots, strict=True) if np.isfinite(part[1][:, chosen]).any()]
    with new_figure(7.5, 3.2) as (made, look):
        panels = made.subplots(1, len(there), sharey=True, squeeze=False)[0]
        for axes, (title, line, dot) in zip(panels, there, strict=True):
            style_axes(axes, look)
            for number, k in enumerate(chosen):
                colour, name = look.colour(number), f"{study.map.orders[k]:g}x"
                axes.semilogy(study.map.rpm, line[:, k], color=colour, linewidth=LINE_WIDTH_POINTS, label=name)
                axes.semilogy(speeds, dot[:, k], "o", color=colour, markersize=size)
            axes.set(xlabel="speed [1/min]")
            axes.set_title(f"{title}: car over engine", loc="left")
            axes.yaxis.set_major_formatter(lambda x, _: f"{x:g}")
        made.legend(*axes.get_legend_handles_labels(), frameon=False, labelcolor=look.ink, ncols=FIGURE_ORDERS,
                    loc="outside lower right")  # fmt: skip
    return made


def seat_lines(study: Study) -> "Figure":
    """Plot the acceleration of the seat rail over speed by order, root of the sum of all directions; all orders in
    black, and dashed at the load of idling.
    """
    fine = [(x.cabin, x.over(SEAT_SPEEDS)) for x in (study, study.idling)]
    seat, idle = (np.sqrt((np.abs(cabin.seat(found)) ** 2).sum(axis=2) / 2) for cabin, found in fine)
    chosen, rpm = largest(seat), fine[0][1].rpm
    with new_figure(7.5, 3.4) as (made, look):
        axes = made.add_subplot()
        style_axes(axes, look)
        axes.plot(rpm, np.linalg.norm(seat, axis=1), color=look.ink, linewidth=LINE_WIDTH_POINTS, label="all")
        axes.plot(
            rpm, np.linalg.norm(idle, axis=1), "--", color=look.ink, linewidth=GRID_WIDTH_POINTS, label="all, idle load"
        )
        for line, k in enumerate(chosen):
            label = f"{study.map.orders[k]:g}x"
            axes.plot(rpm, seat[:, k], color=look.colour(line), linewidth=LINE_WIDTH_POINTS, label=label)
        axes.set(xlabel="speed [1/min]", ylabel="seat rail, rms [m/s²]", ylim=(0.0, None))
        made.legend(frameon=False, labelcolor=look.ink, ncols=FIGURE_ORDERS + 2, fontsize=8, loc="outside lower right")
    return made


def working_cycle(study: Study) -> "Figure":
    """Plot the pressure over volume and over the crank angle, and the torque of gas and inertia over the crank
    angle."""
    angle, cycle = np.linspace(0.0, 4 * np.pi, 1441), study.source.cycle
    gases, turning = study.source.over_the_cycle(study.rpm, angle)
    with new_figure(7.5, 5.0 if cycle else 2.6) as (made, look):
        axes = made.subplot_mosaic([["volume", "pressure"], ["torque", "torque"]] if cycle else [["torque"]])
        for part in axes.values():
            style_axes(part, look)
        if cycle:
            psi, p = cycle.samples
            axes["volume"].plot(1e3 * cycle.volume(psi), p / 1e5, color=look.colour(0), linewidth=LINE_WIDTH_POINTS)
            axes["volume"].set(xlabel="volume of a cylinder [l]", ylabel="pressure [bar]")
            axes["pressure"].plot(np.degrees(psi), p / 1e5, color=look.colour(0), linewidth=LINE_WIDTH_POINTS)
            axes["pressure"].set(xlabel="crank angle from firing [degrees]", xticks=range(-180, 541, 180))
            axes["torque"].plot(
                np.degrees(angle), gases, color=look.colour(1), linewidth=LINE_WIDTH_POINTS, label="gas"
            )
            axes["torque"].plot(
                np.degrees(angle), gases + turning, color=look.ink, linewidth=LINE_WIDTH_POINTS, label="both"
            )
        axes["torque"].plot(
            np.degrees(angle), turning, color=look.colour(0), linewidth=LINE_WIDTH_POINTS, label="inertia"
        )
        axes["torque"].set(xlabel="crank angle [degrees]", ylabel="torque on the crank [N m]", xticks=range(0, 721, 90))
        made.legend(frameon=False, labelcolor=look.ink, ncols=3, loc="outside lower right")
    return made


def bearing_loads(study: Study) -> "Figure":
    """Plot the radial loads of the main bearings over a cycle, and the paths of the load vectors on the block, seen
    along x.
    """
    R = upright(study.preset.layout)
    with new_figure(7.5, 3.6) as (made, look):
        over, path = made.subplots(1, 2, width_ratios=(2.0, 1.0))
        style_axes(over, look)
        style_axes(path, look)
        for k, bearing in enumerate(study.bearings):
            colour = look.colour(k)
            over.plot(
                bearing.angle, bearing.radial / 1e3, color=colour, linewidth=LINE_WIDTH_POINTS, label=bearing.name
            )
            across, up = -(bearing.force @ R[1:, :2].T).T / 1e3
            path.plot(-across, up, color=colour, linewidth=GRID_WIDTH_POINTS)
        over.set(xlabel="crank angle [degrees]", ylabel="radial load [kN]", xticks=range(0, 721, 180))
        made.legend(frameon=False, labelcolor=look.ink, fontsize=8, ncols=len(study.bearings), loc="outside upper left")
        path.set_aspect("equal", adjustable="datalim")
        path.set(xlabel="to the right [kN]", ylabel="up [kN]")
        path.locator_params(nbins=5)
    return made
