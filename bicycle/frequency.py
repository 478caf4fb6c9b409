"""Lean and steer of a bicycle in response to lean and steer torque, from the general model.

    x' = A x + B u,   H(omega) = C (i omega - A)^-1 B,   x = (lean, steer, rates),   u = (lean torque, steer torque)

A is that of `mbsd3d.linearize`. Accelerations are affine in torques, so the columns of B are differences between the
accelerations with a torque of 1 N m and without, exact to rounding. Positive to the right; the lean torque acts on the
frame about the forward direction, the steer torque on the fork from the frame about the steer axis.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import click
import numpy as np

from mbsd3d import System, Torque, accelerations

from .equations import canonical, checked_speeds
from .general import Build, linearization
from .models import whipple
from .options import bicycle_argument, out_option
from .parameters import Parameters
from .sheet import write_table


@dataclass(frozen=True, eq=False)
class Response:
    """Frequency response of a bicycle.

    Attributes
    ----------
    parameters : Parameters
    speeds : (k,) ndarray
        [m/s]
    frequencies : (n,) ndarray
        omega [rad/s].
    H : (k, n, 2, 2) complex ndarray
        [speed, frequency, (lean, steer), (lean torque, steer torque)], rad/(N m).
    growth : (k,) ndarray
        Fastest growth [1/s] by speed. Where it is positive the response is no steady state: a rider's control feels
        it, but left alone the bicycle falls.
    """

    parameters: Parameters
    speeds: np.ndarray
    frequencies: np.ndarray
    H: np.ndarray
    growth: np.ndarray
    outputs: tuple[str, str] = ("lean", "steer")
    inputs: tuple[str, str] = ("lean torque", "steer torque")

    def to_csv(self, path: str | Path) -> Path:
        """One row per speed and frequency; returns the file."""
        names = [f"{out} / {given}" for out in self.outputs for given in self.inputs]
        head = [
            "speed [m/s]",
            "omega [rad/s]",
            *(f"{part} {name} [rad/(N m)]" for name in names for part in ("Re", "Im")),
        ]
        rows = [
            [v, omega, *(x for h in self.H[i, j].ravel() for x in (h.real, h.imag))]
            for i, v in enumerate(self.speeds)
            for j, omega in enumerate(self.frequencies)
        ]
        return write_table(path, head, rows)


def response(parameters: Parameters, speeds: Any, frequencies: Any = None, build: Build | None = whipple) -> Response:
    """Response of lean and steer to lean and steer torque.

    Parameters
    ----------
    parameters : Parameters
    speeds : float or (k,) array_like
        [m/s]
    frequencies : (n,) array_like, optional
        omega > 0 [rad/s]; None = 0.1 ... 100 rad/s.
    build : callable or None
        The general model; None = closed form.

    Returns
    -------
    Response

    Raises
    ------
    ValueError
        For speeds or frequencies that are no numbers, or a frequency that is not positive.

    Examples
    --------
    >>> from bicycle import Meijaard2007
    >>> found = response(Meijaard2007(), 5.0, [1e-6])  # slowly: a steer torque to the right leads into a left turn
    >>> print(found.H[0, 0, :, 1].real.round(4))
    [-1.0829 -0.4552]
    """
    speeds = checked_speeds(speeds)
    omega = np.logspace(-1.0, 2.0, 301) if frequencies is None else np.atleast_1d(np.asarray(frequencies, float))
    if omega.ndim != 1 or not omega.size or not (np.isfinite(omega) & (omega > 0.0)).all():
        raise ValueError("response: frequencies: give one or more positive ones in rad/s")
    found, growth = [], []
    for v in speeds:
        A, B = closed_form(parameters, v) if build is None else model(build, parameters, v)
        found.append(np.linalg.solve(1j * omega[:, None, None] * np.eye(4) - A, B.astype(complex))[:, :2])
        growth.append(np.linalg.eigvals(A).real.max())
    return Response(parameters, speeds, omega, np.array(found), np.array(growth))


def closed_form(parameters: Parameters, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """A (4, 4) and B (4, 2) of the equations of the paper."""
    linear = canonical(parameters)
    return linear.A(speed), np.vstack([np.zeros((2, 2)), np.linalg.inv(linear.M)])


def model(build: Build, parameters: Parameters, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """A (4, 4) and B (4, 2) of the general model."""
    linear = linearization(build, parameters, speed)
    return linear.A, inputs(linear.system)


def inputs(bicycle: System) -> np.ndarray:
    """(4, 2) B: what 1 N m of lean torque and of steer torque adds to the accelerations of lean and steer."""
    frame, fork, steer = bicycle.part("frame"), bicycle.part("fork"), bicycle.part("steer", "joints")
    forward, down = np.array([1.0, 0.0, 0.0]), steer.axis
    torques = ([Torque(frame, forward)], [Torque(fork, down), Torque(frame, -down)])

    def swing(forces: list[Torque]) -> np.ndarray:
        """Accelerations of lean and steer [rad/s^2], upright and straight ahead."""
        found = accelerations(replace(bicycle, forces=[*bicycle.forces, *forces]))
        alpha = found.alpha(frame)[0]
        return np.array([alpha @ forward, (found.alpha(fork)[0] - alpha) @ down])

    rest = swing([])
    return np.vstack([np.zeros((2, 2)), np.array([swing(forces) - rest for forces in torques]).T])


def plot_response(found: Response, *, dark: bool = False) -> Any:
    """Bode plot: magnitude [rad/(N m)] and phase [deg] of lean and steer, a line per speed.

    Parameters
    ----------
    found : Response
        Lines of speeds at which the bicycle falls are dashed.
    dark : bool
        On dark paper.

    Returns
    -------
    matplotlib.figure.Figure
    """
    from .frequency_figure import draw  # matplotlib is loaded when it is needed

    return draw(found, dark)


@click.command()
@bicycle_argument
@click.option(
    "--speed", "speeds", type=float, multiple=True, help="Speed [m/s]; may be given several times. Default: 3, 5 and 8."
)
@click.option("--from", "low", type=float, default=0.1, show_default=True, help="Lowest frequency [rad/s].")
@click.option("--to", "high", type=float, default=100.0, show_default=True, help="Highest frequency [rad/s].")
@click.option("--count", type=click.IntRange(2, 100_000), default=301, show_default=True, help="Number of frequencies.")
@click.option("--dark", is_flag=True, help="Figure on dark paper.")
@out_option
def command(
    parameters: Parameters, speeds: tuple[float, ...], low: float, high: float, count: int, dark: bool, out: str
) -> None:
    """Bode plot: lean and steer in response to lean and steer torque.

    From the general model at each speed. Writes a figure and a table (.csv). Dashed: the bicycle falls at this speed
    if nobody steers. Next: mbsd3d bicycle ride
    """
    from mbsd3d.cli.support import Failure, ready_folder
    from mbsd3d.plotting.plots import save_figure

    if not 0.0 < low < high < np.inf:
        raise Failure(f"--from {low:g} --to {high:g}: give frequencies in rad/s with 0 < from < to")
    folder = ready_folder(out)
    found = response(parameters, speeds or (3.0, 5.0, 8.0), np.geomspace(low, high, count))
    for v, growth in zip(found.speeds, found.growth, strict=True):
        click.echo(f"{v:g} m/s: {'falls' if growth > 0.0 else 'self-stable'}, growth {growth:.6g} 1/s")
    target = folder / f"frequency_{parameters.name}"
    for path in (*save_figure(plot_response(found, dark=dark), target), found.to_csv(target)):
        click.echo(str(path))
