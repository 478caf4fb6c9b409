"""Frequency response of a bicycle: lean and steer to lean and steer torque, from the general model, with a Bode plot.

The general model is that of `mbsd3d.state_space`; growth is that of lean and steer alone, or of what
`bicycle.linear.tyre_equations` keeps. The closed form is the inverse of its dynamic stiffness.
Positive to the right; the lean torque acts on the frame about the forward direction, the steer torque on the fork from
the frame about the steer axis.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mbsd3d import Input, StateSpace, System, Torque, linearize, state_space
from mbsd3d.errors import InputError
from mbsd3d.extend import (
    GRID_WIDTH_POINTS,
    LINE_WIDTH_POINTS,
    Result,
    Theme,
    label_decades,
    label_quarter_turns,
    new_figure,
    style_axes,
    write_table,
)

from ..model.mechanism import outputs, whipple
from ..model.tyres import Tyres
from ..parameters import Parameters
from .equations import canonical, checked_list, checked_speeds
from .general import Build
from .tyre_equations import GROWTH_ROUNDING, growth, matrix

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TORQUES = ("lean torque", "steer torque")


@dataclass(frozen=True, eq=False, repr=False)
class Response(Result):
    """Frequency response ``H[speed, frequency, (lean, steer), (lean torque, steer torque)]`` of a bicycle [rad/(N m)].

    Where the fastest ``growth`` is positive there is no steady state: the response matters to a rider's control, but
    left alone the bicycle falls.
    """

    parameters: Parameters
    speeds: np.ndarray  # (k,) [m/s]
    frequencies: np.ndarray  # (n,) omega [rad/s]
    H: np.ndarray  # (k, n, 2, 2) complex
    growth: np.ndarray  # (k,) [1/s]
    outputs: tuple[str, str] = ("lean", "steer")
    inputs: tuple[str, str] = TORQUES

    def to_csv(self, path: str | Path) -> Path:
        """Write one row per speed and frequency; return the file."""
        names = [f"{out} / {given}" for out in self.outputs for given in self.inputs]
        columns = [f"{part} {name} [rad/(N m)]" for name in names for part in ("Re", "Im")]
        rows = [
            [v, omega, *self.H[i, j].ravel().view(float)]
            for i, v in enumerate(self.speeds)
            for j, omega in enumerate(self.frequencies)
        ]
        return write_table(path, ["speed [m/s]", "omega [rad/s]", *columns], rows)

    def __str__(self) -> str:
        w = self.frequencies
        lines = [f"{self.parameters.name}: response at {w.size} frequencies {w.min():g} ... {w.max():g} rad/s"]
        for v, grows, H in zip(self.speeds, self.growth, np.abs(self.H[:, :, 1, 1]), strict=True):
            state = "falls" if grows > 0.0 else "self-stable"
            most = f"{self.outputs[1]} / {self.inputs[1]} up to {H.max():.4g} rad/(N m) at {w[H.argmax()]:.4g} rad/s"
            lines.append(f"  {v:g} m/s: {state}, growth {grows:.6g} 1/s; {most}")
        return "\n".join(lines)


def response(
    parameters: Parameters, speeds: ArrayLike, frequencies: ArrayLike | None = None, build: Build | None = whipple, *,
    tyres: Tyres | None = None, **fittings: float,
) -> Response:  # fmt: skip
    """Compute the response of lean and steer to lean and steer torque [rad/(N m)].

    Parameters
    ----------
    speeds : float or (k,) array_like
        [m/s]
    frequencies : (n,) array_like, optional
        omega > 0 [rad/s]; None = 0.1 ... 100 rad/s.
    build : callable or None
        The general model; None = closed form.
    tyres : mapping, pair of them or None
        As in `bicycle.whipple`; None = ideal wheels.
    **fittings : float
        Further arguments of `bicycle.whipple` for a bicycle on tyres, e.g. ``steer_damping``, ``head_stiffness``.

    Examples
    --------
    >>> from bicycle import Meijaard2007, frequency
    >>> found = frequency.response(Meijaard2007(), 5.0, [1e-6])  # slowly: a torque to the right turns it left
    >>> print(found.H[0, 0, :, 1].real.round(4))
    [-1.0829 -0.4552]
    """
    speeds = checked_speeds(speeds)
    omega = np.logspace(-1.0, 2.0, 301) if frequencies is None else frequencies
    omega = checked_list(omega, "response: frequencies", remedy := "one or more positive ones in rad/s")
    if omega.min() <= 0.0:
        raise InputError(f"response: frequencies: {omega.min():g} is not positive; give {remedy}")
    if build is None and tyres is not None:
        raise InputError("response: the closed form has ideal wheels; leave out tyres, or give a model")
    if fittings and tyres is None:
        raise InputError(f"response: {', '.join(fittings)} without tyres; give tyres, e.g. bicycle.TYPICAL")
    found, grows = [], []
    for v in speeds.tolist():
        if build is None:
            linear = canonical(parameters)
            H, fastest = np.linalg.inv(linear.dynamic_stiffness(v, omega)), growth(linear.A(v))
        else:
            model, fastest = torqued(build(parameters, speed=v, **({"tyres": tyres} | fittings if tyres else {})), v)
            H = model.frequency_response(omega).H
        found.append(H)
        grows.append(fastest)
    return Response(parameters, speeds, omega, np.array(found), np.array(grows))


def torqued(bicycle: System, speed: float) -> tuple[StateSpace, float]:
    """Return the model from torques to lean and steer of a straight run at a speed [m/s], and its fastest growth."""
    on_tyres = any(force.name == "rear tyre" for force in bicycle.forces)
    A = matrix(bicycle, speed) if on_tyres else linearize(bicycle, outputs=outputs(bicycle)).A
    frame, fork, down = bicycle.part("frame"), bicycle.part("fork"), bicycle.part("steer", "joints").axis
    lean, steer = map(Input, TORQUES)
    torques = [Torque(frame, (lean, 0.0, 0.0)), Torque(fork, tuple(x * steer for x in down)),
               Torque(frame, tuple(-x * steer for x in down))]  # fmt: skip
    driven = replace(bicycle, forces=[*bicycle.forces, *torques])
    found = state_space(driven, driven.state(), inputs=TORQUES, outputs=outputs(driven)[:2], tolerance=GROWTH_ROUNDING)
    return found, growth(A)


def plot_response(found: Response, *, beside: Response | None = None, dark: bool = False) -> "Figure":
    """Draw a Bode plot: magnitude and phase of lean and steer (rows) to lean and steer torque (columns), a line per
    speed.

    Lines of speeds at which the bicycle falls are dashed. ``beside`` is drawn thin: ideal wheels beside tyres.
    """
    with new_figure(9.0, 9.0, dark) as (figure, look):
        panels = figure.subplots(4, 2, sharex=True, height_ratios=(1.5, 1.0, 1.5, 1.0))
        for out, given in np.ndindex(2, 2):
            size, phase = panels[2 * out : 2 * out + 2, given]
            for axes in (size, phase):
                style_axes(axes, look)
            if beside is not None:
                draw_lines(size, phase, beside, beside.H[:, :, out, given], look, thin=True)
            draw_lines(size, phase, found, found.H[:, :, out, given], look)
            size.set_title(f"{found.outputs[out]} / {found.inputs[given]}")
        for out in (0, 1):
            panels[2 * out, 0].set_ylabel("magnitude [rad/(N m)]")
            panels[2 * out + 1, 0].set_ylabel("phase [°]")
        for axes in panels[-1]:
            axes.set_xlabel("frequency ω [rad/s]")
        handles, names = panels[0, 0].get_legend_handles_labels()
        columns = min(len(names), 4)
        figure.legend(handles, names, loc="outside lower center", ncols=columns, frameon=False, labelcolor=look.ink)
        on = "" if beside is None else " on tyres (thin: on ideal wheels)"
        figure.suptitle(f"{found.parameters.name}{on}: response of lean and steer to torques")
        figure.align_ylabels(panels[:, 0])
    return figure


def draw_lines(size: "Axes", phase: "Axes", found: Response, H: np.ndarray, look: Theme, *, thin: bool = False) -> None:
    """Draw magnitude and phase of one output to one input, (speeds, frequencies)."""
    for k, (v, fastest) in enumerate(zip(found.speeds, found.growth, strict=True)):
        falls = fastest > 0.0
        style = {
            "color": look.colour(k),
            "linestyle": "--" if falls else "-",
            "linewidth": GRID_WIDTH_POINTS if thin else LINE_WIDTH_POINTS,
        }
        label = f"{v:g} m/s{', falls' if falls else ''}"
        size.loglog(found.frequencies, np.abs(H[k]), label="_" if thin else label, **style)
        degrees = np.degrees(np.unwrap(np.angle(H[k])))
        turns = np.round((degrees[0] - 10.0) / 360.0)  # begins in -170 ... 190: against the torque is 180 on both sides
        phase.semilogx(found.frequencies, degrees - 360.0 * turns, **style)
    label_decades(size.yaxis)
    label_decades(size.xaxis)
    label_quarter_turns(phase)
