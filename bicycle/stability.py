"""Stability of a straight run: eigenvalues over the speed, from the general model and in closed form."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import click
import numpy as np

from mbsd3d import Mode
from mbsd3d.base.checks import number

from .equations import canonical, checked_speeds
from .general import Build, eigenvalues, linear_equations, linearization
from .models import whipple
from .options import bicycle_argument, out_option
from .parameters import Parameters
from .sheet import write_table
from .speeds import CriticalSpeeds, critical_speeds, speeds_of
from .stability_figure import draw
from .tracking import MODES, NAMES, follow

__all__ = ["CriticalSpeeds", "Stability", "canonical", "critical_speeds", "eigenvalues", "figure", "study"]


TYPICAL = 5.0
"""[m/s] of critical speeds, which a linearisation at far slower ones does not give to all digits."""


@dataclass(frozen=True, eq=False)
class Stability:
    """Modes of a bicycle over the speed, as `study` finds them.

    Attributes
    ----------
    parameters : Parameters
    speeds : (n,) ndarray
        [m/s]
    values : (n, 4) complex ndarray
        Eigenvalues [1/s] of the general model, a column per mode, see ``names``.
    vectors : (n, 4, 4) complex ndarray
        [speed, (lean, steer, rates), mode]
    closed : (n, 4) complex ndarray or None
        Those of the closed form by real part; None if there is none (round tyres).
    critical : CriticalSpeeds
        From the general model.
    """

    build: Build
    parameters: Parameters
    speeds: np.ndarray
    values: np.ndarray
    vectors: np.ndarray
    closed: np.ndarray | None
    critical: CriticalSpeeds
    names: tuple[str, ...] = NAMES

    @cached_property
    def difference(self) -> float:
        """Largest distance of an eigenvalue in closed form from the next of the general model [1/s]; NaN for none."""
        if self.closed is None:
            return float("nan")
        return float(np.abs(self.values[:, :, None] - self.closed[:, None, :]).min(axis=1).max())

    def mode(self, name: str, speed: float) -> Mode:
        """The mode of the general model at a speed [m/s]: ``.animate()`` shows it with all wheels on the ground.

        Raises
        ------
        ValueError
            If the name is none of weave, capsize, castering.
        """
        check_mode(name)
        fastest = np.copysign(max(np.abs([*self.speeds, speed, 1.0])), speed)
        linear = linear_equations(self.build, self.parameters, fastest)
        value = follow(linear, np.array([fastest, speed]))[0][1, NAMES.index(name)]
        found = linearization(self.build, self.parameters, speed)
        return min(found.modes, key=lambda mode: min(abs(mode.eigenvalue - s) for s in (value, value.conjugate())))

    def figure(self, *, dark: bool = False) -> Any:
        """Matplotlib figure: lines of the general model, dots of the closed form, stable ranges shaded."""
        return draw(self, dark)

    def to_csv(self, path: str | Path) -> Path:
        """Write the eigenvalues by mode [1/s] over the speed [m/s]."""
        head = ["speed [m/s]"] + [f"{part} {name} [1/s]" for name in self.names for part in ("Re", "Im")]
        return write_table(path, head, np.column_stack([self.speeds, self.values.view(float)]))


def check_mode(name: str) -> None:
    """A name of a mode, or a ValueError."""
    if name not in MODES:
        raise ValueError(f"mode '{name}' is unknown; give weave, capsize or castering")


def study(parameters: Parameters, speeds: Any = None, build: Build = whipple) -> Stability:
    """Follow the modes of a bicycle over the speed.

    Parameters
    ----------
    parameters : Parameters
    speeds : (n,) array_like or None
        [m/s], also negative; None = 0 ... 10 m/s.
    build : callable
        The model, see `eigenvalues`.

    Returns
    -------
    Stability

    Examples
    --------
    >>> from bicycle import Meijaard2007
    >>> found = study(Meijaard2007(), [0.0, 5.0])
    >>> found.values[1].round(5).tolist()
    [(-0.77534+4.46487j), (-0.77534-4.46487j), (-0.32287+0j), (-14.07839+0j)]
    """
    speeds = checked_speeds(np.linspace(0.0, 10.0, 201) if speeds is None else speeds)
    linear = linear_equations(build, parameters, max(float(np.abs(speeds).max()), TYPICAL))
    if linear is None:
        raise ValueError(
            f"bicycle '{parameters.name}': a force depends on speed otherwise than through the motion; modes are "
            "followed for ideal wheels only, see stability.eigenvalues"
        )
    values, vectors = follow(linear, speeds)
    closed = None if parameters.tR or parameters.tF else canonical(parameters).eigenvalues(speeds)
    return Stability(build, parameters, speeds, values, vectors, closed, speeds_of(linear))


def figure(found: Stability, *, dark: bool = False) -> Any:
    """The figure of a study."""
    return found.figure(dark=dark)


@click.command()
@bicycle_argument
@click.option(
    "--from", "first", type=float, default=0.0, show_default=True, help="Lowest speed [m/s], may be negative."
)
@click.option("--to", "last", type=float, default=10.0, show_default=True, help="Highest speed [m/s].")
@click.option("--count", type=click.IntRange(2, 100_000), default=401, show_default=True, help="Number of speeds.")
@click.option("--mode", "shown", help="Write a page (.html) too that shows this mode: weave, capsize or castering,")
@click.option("--speed", type=float, default=5.0, show_default=True, help="at this speed [m/s].")
@click.option("--dark", is_flag=True, help="Figure on dark paper.")
@out_option
def command(
    parameters: Parameters, first: float, last: float, count: int, shown: str | None, speed: float, dark: bool, out: str
) -> None:
    """Eigenvalues over the speed: weave, capsize, castering and the stable range.

    BICYCLE is a name, e.g. Browser, or a file with parameters (.txt, .yml). Writes a figure and a table (.csv).
    """
    from mbsd3d.cli.support import Failure, can_view, ready_folder
    from mbsd3d.plotting.plots import save_figure

    if not -np.inf < first < last < np.inf:
        raise Failure(f"--from {first:g} is not below --to {last:g}; give two finite speeds in m/s")
    if shown:
        check_mode(shown)
        number(speed, "--speed")
        can_view(needed=True)
    folder = ready_folder(out)
    found = study(parameters, np.linspace(first, last, count))
    target = folder / f"stability_{parameters.name}"
    click.echo(f"{parameters.name}\n{found.critical}")
    if found.closed is not None:
        click.echo(f"general model and closed form differ by {found.difference:.1e} 1/s")
    for path in (*save_figure(found.figure(dark=dark), target), found.to_csv(target)):
        click.echo(str(path))
    if shown:
        page = found.mode(shown, speed).animate(title=f"{parameters.name}: {shown} at {speed:g} m/s")
        click.echo(str(page.save(folder / f"{shown}_{parameters.name}")))
