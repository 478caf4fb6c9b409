"""Dependence of the critical speeds of a bicycle on its parameters: exact derivatives, Monte Carlo, maps.

A critical speed v solves f(v, x) = 0 with f one of e (capsize), h (weave), and p at the double root s, where dp/ds = 0:

    dv/dx = - (df/dx) / (df/dv)

Both derivatives are complex steps through the equations in closed form. For round tyres, which these do not know, the
coefficients of p come from the general model and their derivatives from differences of fourth order, to some 1e-9.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING

import numpy as np

from mbsd3d.errors import InputError
from mbsd3d.extend import Result, new_figure, style_axes, write_table

from ..parameters import MEANING, SYMBOL, SYMBOLS, TYRES, UNIT, Parameters, check_set
from . import critical
from .critical import Quartic, double_roots, value
from .general import Build
from .maps import StableMap, StableSpeeds, plot_map, plot_speeds, stable_map, stable_speeds
from .uncertainty import MonteCarlo, Sobol, monte_carlo, plot_uncertainty, sobol

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "Derivatives", "MonteCarlo", "NoSpeedsError", "Sobol", "StableMap", "StableSpeeds", "derivatives", "monte_carlo",
    "plot_derivatives", "plot_map", "plot_speeds", "plot_uncertainty", "sobol", "stable_map", "stable_speeds",
]  # fmt: skip

DIFFERENCES = {  # of fourth order: multiples of the step, and their weights
    "central": ((-2, -1, 1, 2), (1 / 12, -2 / 3, 2 / 3, -1 / 12)),
    "forward": ((0, 1, 2, 3, 4), (-25 / 12, 4, -3, 4 / 3, -1 / 4)),
    "backward": ((0, -1, -2, -3, -4), (25 / 12, -4, 3, -4 / 3, 1 / 4)),
}
DIFFERENCE_STEP = 1e-3
"""Step of a difference, relative to the parameter, or to `DIFFERENCE_STEP_MIN` if that is larger: the error is its
fourth power, and 1e-12 of rounding over it."""
DIFFERENCE_STEP_MIN = 0.1
COMPLEX_STEP = 1e-30  # [1] far below rounding, so that its square vanishes


FIGURE_PARAMETERS = 14  # [1] parameters of a figure: those that matter most


class NoSpeedsError(InputError):
    """Error for a bicycle without any critical speed."""


@dataclass(frozen=True, eq=False, repr=False)
class Derivatives(Result):
    """Derivatives of the critical speeds of a bicycle: ``by[speed][symbol]`` [m/s per unit of the parameter]."""

    parameters: Parameters
    speeds: Mapping[str, float]  # those of "weave", "capsize" and "double root" that the bicycle has [m/s]
    by: Mapping[str, Mapping[str, float]]

    def per_percent(self, speed: str) -> dict[str, float]:
        """Return the change of a speed [m/s] by one percent of each parameter."""
        return {key: 0.01 * getattr(self.parameters, key) * slope for key, slope in self.by[speed].items()}

    def spread(self, speed: str, deviations: Mapping[str, float]) -> float:
        """Return the standard deviation of a speed [m/s], to first order, from those of independent parameters."""
        return float(np.sqrt(sum((self.by[speed][key] * std) ** 2 for key, std in deviations.items())))

    def to_csv(self, path: str | Path) -> Path:
        """Write one row per parameter; return the file."""
        head = ["parameter", "value [SI]", *(f"d {name} [m/s per SI unit]" for name in self.speeds), "SI unit"]
        keys = next(iter(self.by.values()))
        rows = [[key, getattr(self.parameters, key), *(x[key] for x in self.by.values()), UNIT[key]] for key in keys]
        return write_table(path, head, rows)

    def __str__(self) -> str:
        head = "  ".join(f"{f'd {name}':>14}" for name in self.speeds)
        lines = [f"{self.parameters.name}: " + ", ".join(f"{name} {v:.6f} m/s" for name, v in self.speeds.items())]
        lines.append(f"{'':5}{'value':>12} {'unit':7}  {head}   [m/s per unit]")
        for key in next(iter(self.by.values())):
            row = "  ".join(f"{self.by[name][key]:14.6g}" for name in self.speeds)
            lines.append(f"{key:5}{getattr(self.parameters, key):12.6g} {UNIT[key]:7}  {row}   {MEANING[key]}")
        return "\n".join(lines)


def derivatives(parameters: Parameters, build: Build | None = None) -> Derivatives:
    """Compute derivatives of weave, capsize and double-root speed with respect to all parameters.

    Parameters
    ----------
    build : callable or None
        None = closed form, exact, of knife-edge wheels; `bicycle.whipple` = general model by differences, with the
        crown radii of tyres that have them.

    Raises
    ------
    ValueError
        If the bicycle has none of these speeds (`NoSpeedsError`) or round tyres without a model; or if a parameter of
        the general model can be changed to neither side.

    Examples
    --------
    >>> from bicycle import Meijaard2007, sensitivity
    >>> found = sensitivity.derivatives(Meijaard2007())
    >>> print(f"{found.speeds['weave']:.6f} m/s, {found.by['weave']['c']:.3f} m/s per metre of trail")
    4.292383 m/s, 11.480 m/s per metre of trail
    """
    check_set(parameters, "derivatives")
    keys = [*SYMBOLS, *(key for key in TYRES if getattr(parameters, key))]
    if build is None:
        q, stepped = critical.polynomial(parameters), critical.polynomial(perturbed(parameters))
    else:
        q, stepped = varied(parameters, keys, build)
    speeds, slopes = {}, {}
    for name, v, f in conditions(q):
        speeds[name] = float(v)
        by_speed = f(q, v + 1j * COMPLEX_STEP).imag / COMPLEX_STEP
        slopes[name] = dict(zip(keys, (0.0 - f(stepped, v).imag / COMPLEX_STEP / by_speed).tolist(), strict=True))
    if not speeds:
        raise NoSpeedsError(f"bicycle '{parameters.name}': it has neither weave nor capsize speed nor a double root")
    return Derivatives(parameters, speeds, slopes)


def perturbed(parameters: Parameters) -> SimpleNamespace:
    """Return the parameters as (26,) arrays: entry k has the complex step in parameter k."""
    steps = 1j * COMPLEX_STEP * np.eye(len(SYMBOLS))
    values = {key: getattr(parameters, key) + steps[k] for k, key in enumerate(SYMBOLS)}
    return SimpleNamespace(**values, tR=parameters.tR, tF=parameters.tF, name=parameters.name)


def varied(parameters: Parameters, keys: list[str], build: Build) -> tuple[Quartic, Quartic]:
    """Return (p, p with the complex step in parameter k as entry k) of the general model."""
    q, slopes = critical.model_polynomial(parameters, build), []
    for key in keys:
        step = DIFFERENCE_STEP * max(abs(getattr(parameters, key)), DIFFERENCE_STEP_MIN)
        cells, weights = neighbours(parameters, key, step)
        found = zip(*(critical.model_polynomial(cell, build, check=False) for cell in cells), strict=True)
        slopes.append([np.tensordot(weights, x, 1) / step for x in map(np.array, found)])
    return q, Quartic(
        *(x + 1j * COMPLEX_STEP * np.array(dx) for x, dx in zip(q, zip(*slopes, strict=True), strict=True))
    )


def neighbours(parameters: Parameters, key: str, step: float) -> tuple[list[Parameters], tuple[float, ...]]:
    """Return bicycles with one parameter changed, and their weights in its difference: central where all can be
    built."""
    here = getattr(parameters, key)
    for places, weights in DIFFERENCES.values():
        try:
            return [replace(parameters, **{key: here + k * step}, unphysical=True) for k in places], weights
        except ValueError as error:  # e.g. a moment of inertia below zero
            refused = error
    raise InputError(
        f"bicycle '{parameters.name}': {key} = {here:g} can be changed to neither side in the general model: {refused}"
    )


def conditions(q: Quartic) -> list[tuple[str, float, Callable[[Quartic, complex], np.ndarray]]]:
    """Return (name, speed, f) with f(quartic, speed) = 0, for each critical speed of the bicycle."""
    found: list[tuple[str, float, Callable[[Quartic, complex], np.ndarray]]] = [
        ("weave", float(critical.weave(q)), lambda q, v: value(q.h, v * v)),
        ("capsize", float(critical.capsize(q)), lambda q, v: value(q.e, v * v)),
    ]
    meeting = [(v, s) for v, s in double_roots(q) if s > 0.0]
    if meeting:
        v, s = meeting[0]
        found.append(("double root", v, lambda q, v: value(q.at(v), s)))
    return [entry for entry in found if np.isfinite(entry[1])]


def plot_derivatives(found: Derivatives, *, dark: bool = False) -> "Figure":
    """Plot the change of the critical speeds by one percent of the parameters that matter most."""
    changes = {name: found.per_percent(name) for name in found.speeds}
    sizes = {key: max(abs(change[key]) for change in changes.values()) for key in next(iter(changes.values()))}
    keys = sorted(sizes, key=lambda key: -sizes[key])[:FIGURE_PARAMETERS]
    with new_figure(9.0, 1.5 + 0.28 * len(keys), dark) as (figure, look):
        panels = figure.subplots(1, len(changes), sharey=True, sharex=True, squeeze=False)[0]
        for k, (axes, (name, change)) in enumerate(zip(panels, changes.items(), strict=True)):
            style_axes(axes, look)
            axes.barh(range(len(keys)), [change[key] for key in keys], height=0.65, color=look.colour(k))
            axes.axvline(0.0, color=look.ink, linewidth=0.8)
            axes.set_title(f"{name}, {found.speeds[name]:.4f} m/s", loc="left")
            axes.grid(False, axis="y")
            axes.set_xlabel("change by +1 % [m/s]")
            axes.tick_params(axis="y", length=0)
        title = f"{found.parameters.name}: what one percent of a parameter does to the critical speeds"
        figure.suptitle(title, x=0.01, ha="left", color=look.ink, fontsize=11)
        panels[0].set_yticks(range(len(keys)), [SYMBOL[key] for key in keys])
        panels[0].set_ylim(len(keys) - 0.4, -0.6)
    return figure
