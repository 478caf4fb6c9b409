"""Handling quality of a bicycle over the speed: the feedback of roll rate that a rider needs to lean as wanted.

    HQM(omega) = |U/phi_c| |400/(s^2 + 40 s + 400)| / |k_phi|,    U = phi_dot + delta/k_phidot,    s = i omega

With the loops of steer angle, roll rate and roll closed, U is all that the rider feeds back inside the roll loop, phi_c
the roll angle wanted. The metric is that of R. A. Hess (2006) for pilots, extended to bicycles by Hess, J. K. Moore and
M. Hubbard (2012). Pilots call an aircraft whose peak is below 5 good (level 1), above 8 bad (level 3).
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize_scalar

from mbsd3d.errors import InputError
from mbsd3d.extend import GRID_WIDTH_POINTS, LINE_WIDTH_POINTS, Result, new_figure, style_axes, write_table

from ..linear.equations import checked_speeds
from ..output import collected
from ..parameters import Parameters
from .rider import Gains, by_rule, checked_gains, closed_loops, eigenvalues, gains_of, spans

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEVELS = (5.0, 8.0)
"""Below the first: little compensation by the rider; above the second: much."""
FREQUENCIES = np.geomspace(0.01, 60.0, 1200)
"""[rad/s] between two of which the peak is sought."""


class Peak(NamedTuple):
    """Largest value of the metric, and its frequency."""

    value: float
    frequency: float  # [rad/s]


def metric(parameters: Parameters, speed: float, gains: Gains, frequencies: ArrayLike) -> np.ndarray:
    """Return the handling quality metric (HQM) at frequencies (n,) [rad/s] and a speed [m/s], shape (n,)."""
    omega = np.atleast_1d(np.asarray(frequencies, float))
    x = closed_loops(parameters, speed, gains, 3).response(omega)
    fed_back = x[:, 2] + x[:, 1] / gains.roll_rate
    return np.abs(fed_back * 400.0 / (400.0 - omega**2 + 40j * omega)) / abs(gains.roll)


def peak(parameters: Parameters, speed: float, gains: Gains | None = None) -> Peak:
    """Return the largest HQM up to 60 rad/s.

    Parameters
    ----------
    speed : float
        [m/s]
    gains : Gains or None
        None = by the rule of `bicycle.rider.gains_of`.

    Raises
    ------
    ValueError
        If the rule finds no gains, or the rider does not balance the bicycle with them: then the metric has no meaning.

    Examples
    --------
    >>> from bicycle import Meijaard2007, handling
    >>> print(round(handling.peak(Meijaard2007(), 5.0).value, 4))
    4.7647
    """
    gains = gains_of(parameters, speed) if gains is None else checked_gains(gains)
    growth = eigenvalues(parameters, speed, gains).real.max()
    if growth >= 0.0:
        raise InputError(
            f"bicycle '{parameters.name}': at {speed:g} m/s the rider does not balance it (growth {growth:.3g} 1/s) "
            "with these gains; give others"
        )
    values = metric(parameters, speed, gains, FREQUENCIES)
    k = int(np.clip(np.argmax(values), 1, len(values) - 2))
    found = minimize_scalar(
        lambda omega: -metric(parameters, speed, gains, omega)[0], bounds=FREQUENCIES[[k - 1, k + 1]],
        method="bounded", options={"xatol": 1e-9},
    )  # fmt: skip
    return Peak(float(-found.fun), float(found.x))


@dataclass(frozen=True, eq=False, repr=False)
class Handling(Result):
    """Peaks over the speed; NaN where the rule finds no gains, or none that balance the bicycle."""

    parameters: Parameters
    speeds: np.ndarray  # (n,) [m/s]
    gains: np.ndarray  # (n, 5) as `Gains`
    values: np.ndarray  # (n,)
    frequencies: np.ndarray  # (n,) [rad/s]

    def figure(self, *, dark: bool = False) -> "Figure":
        """Plot the peak over the speed, and the metric over the frequency at a few speeds."""
        return figure(self, dark=dark)

    def to_csv(self, path: str | Path) -> Path:
        """Write one row per speed; return the file."""
        units = ("N m/rad", "s", "1/s", "1", "rad/m")
        head = [f"{name} [{unit}]" for name, unit in zip(Gains._fields, units, strict=True)]
        table = np.column_stack([self.speeds, self.values, self.frequencies, self.gains])
        return write_table(path, ["speed [m/s]", "peak [-]", "at [rad/s]", *head], table)

    def __str__(self) -> str:
        wide = max(map(len, LABELS))
        known = ~np.isnan(self.values)
        rows = [
            f"  {label:{wide}}  {spans(self.speeds, known & (self.values > low) & (self.values <= high))}"
            for label, low, high in zip(LABELS, (0.0, *LEVELS), (*LEVELS, np.inf), strict=True)
        ]
        if not known.all():
            rows.append(f"  {'no gains by rule':{wide}}  {spans(self.speeds, ~known)}")
        return "\n".join([f"{self.parameters.name}: handling quality by the speed (peak of the metric)", *rows])


LABELS = (f"level 1, up to {LEVELS[0]:g}", f"level 2, up to {LEVELS[1]:g}", "level 3, above")


def study(parameters: Parameters, speeds: ArrayLike, *, progress: bool | None = None) -> Handling:
    """Compute handling quality over the speed after Hess: the peak of the rider's feedback, with the gains of the rule.

    Parameters
    ----------
    speeds : (n,) array_like
        Positive [m/s].
    progress : bool or None
        Show a progress bar; None = on a terminal, after two seconds.

    Returns
    -------
    Handling
        Gains and peaks; after Ctrl-C of the speeds that were finished, NaN where the rule finds no gains.

    Raises
    ------
    ValueError
        For speeds that are not positive numbers.

    Examples
    --------
    >>> from bicycle import Meijaard2007, handling
    >>> print(handling.study(Meijaard2007(), [3.0, 4.0, 5.0]))
    Meijaard2007: handling quality by the speed (peak of the metric)
      level 1, up to 5  5 m/s
      level 2, up to 8  4 m/s
      level 3, above    3 m/s
    """
    speeds = np.unique(checked_speeds(speeds))
    if speeds[0] <= 0.0:
        raise InputError(f"handling: speed = {speeds[0]:g} m/s; give positive ones")
    rows = (row(parameters, v) for v in speeds.tolist())
    found = np.array(collected(f"riders on {parameters.name}", rows, len(speeds), progress)).reshape(-1, 7)
    return Handling(parameters, speeds[: len(found)], found[:, :5], found[:, 5], found[:, 6])


def row(parameters: Parameters, speed: float) -> tuple[float, ...]:
    """Return gains by rule, peak and its frequency; NaN without such gains."""
    gains = by_rule(parameters, speed)
    try:
        return (np.nan,) * 7 if gains is None else (*gains, *peak(parameters, speed, gains))
    except InputError:  # they do not balance the bicycle
        return (np.nan,) * 7


def figure(found: Handling, *, dark: bool = False) -> "Figure":
    """Plot the peak over the speed, and the metric over the frequency at four speeds."""
    known = np.flatnonzero(~np.isnan(found.values))
    with new_figure(9.2, 4.4, dark) as (sheet, look):
        over, spectra = sheet.subplots(1, 2)
        over.plot(found.speeds, found.values, color=look.colour(0), linewidth=LINE_WIDTH_POINTS)
        over.set_xlabel("speed [m/s]")
        over.set_ylabel("peak of the handling quality metric")
        for k, at in enumerate(known[np.linspace(0, len(known) - 1, min(4, len(known))).astype(int)]):
            line = metric(found.parameters, found.speeds[at], Gains(*found.gains[at]), FREQUENCIES)
            label = f"{found.speeds[at]:.3g} m/s"
            spectra.plot(FREQUENCIES, line, color=look.colour(k), linewidth=LINE_WIDTH_POINTS, label=label)
        spectra.set_xlim(0.0, 40.0)
        spectra.set_xlabel("frequency ω [rad/s]")
        spectra.set_ylabel("handling quality metric")
        top = 1.05 * np.max(found.values[known], initial=LEVELS[1])
        for axes in (over, spectra):
            style_axes(axes, look)
            axes.set_ylim(0.0, min(20.0, top))
            for level in LEVELS:
                axes.axhline(level, color=look.muted, linewidth=GRID_WIDTH_POINTS, linestyle="--")
        if known.size:
            spectra.legend(frameon=False, labelcolor=look.ink)
        sheet.suptitle(f"{found.parameters.name}: handling quality, good below {LEVELS[0]:g}, bad above {LEVELS[1]:g}")
    return sheet
