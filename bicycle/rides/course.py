"""Rider of five loops on the nonlinear model: a lane change or a slalom, on ideal wheels or on tyres."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mbsd3d import CustomForce
from mbsd3d.errors import InputError
from mbsd3d.extend import LINE_WIDTH_POINTS, Result, new_figure, number, style_axes, write_table

from ..model.kinematics import steer_axis
from ..model.mechanism import Bicycle, whipple
from ..model.tyres import Tyres
from ..parameters import Parameters
from ..riders.rider import MUSCLES, Gains, checked_gains, gains_of
from .manoeuvres import FALLEN
from .motion import Ride, legend_above, lines, on_tyres
from .ride import ended

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Course:
    """Desired path, to the right: a lane change, smooth as tanh, and a slalom, y_c over time."""

    lane: float = 0.0  # [m]
    at: float = 3.0  # [s] its middle
    within: float = 1.0  # [s] from 12 to 88 % of it
    slalom: float = 0.0  # [m]
    period: float = 8.0  # [s]

    def __post_init__(self) -> None:
        for name in ("lane", "at", "slalom"):
            number(getattr(self, name), f"course: {name}")
        for name in ("within", "period"):
            number(getattr(self, name), f"course: {name}", positive=True)

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """Return y_c [m] at times [s]."""
        change = 0.5 * self.lane * (1.0 + np.tanh(2.0 * (t - self.at) / self.within))
        return change + self.slalom * np.sin(2.0 * np.pi * t / self.period)

    @property
    def numbers(self) -> tuple[float, ...]:
        """Return the numbers that the compiled rider reads."""
        return self.lane, self.at, 2.0 / self.within, self.slalom, 2.0 * np.pi / self.period


COURSES = {"lane-change": Course(lane=2.0), "slalom": Course(slalom=1.0)}


def steer(t, bodies, z, parameters, loads, z_dot):
    """Apply the torque z[0] about the steer axis on the fork and back on the frame, from five loops and muscles.

    ``bodies`` are frame and fork, its point the front hub; parameters: gains (5), course (5), steer axis (3), arm of
    the front wheel along its disc, stiffness and damping of the muscles.
    """
    R, S, w = bodies[0].R, bodies[1].R, bodies[0].w  # scalars: numba compiles them several times faster than arrays
    ax, ay, az = R[0, 1], R[1, 1], R[2, 1]  # axle of the rear wheel, to the left
    fx, fy, fz = S[0, 1], S[1, 1], S[2, 1]  # and of the front wheel
    p, q, r = parameters[10], parameters[11], parameters[12]
    nx = p * R[0, 0] + q * ax + r * R[0, 2]  # steer axis
    ny = p * R[1, 0] + q * ay + r * R[1, 2]
    nz = p * R[2, 0] + q * az + r * R[2, 2]
    sine = fx * (ny * az - nz * ay) + fy * (nz * ax - nx * az) + fz * (nx * ay - ny * ax)
    delta = np.arctan2(sine, fx * ax + fy * ay + fz * az)
    roll, roll_rate = np.arcsin(az), (w[0] * ay - w[1] * ax) / np.sqrt(1.0 - az * az)
    heading = np.arctan2(ax, ay)
    y = -bodies[1].r[1] - parameters[13] * fy * fz / np.sqrt(1.0 - fz * fz)
    lane = 0.5 * parameters[5] * (1.0 + np.tanh(parameters[7] * (t - parameters[6])))
    command = lane + parameters[8] * np.sin(parameters[9] * t) - y
    command = parameters[4] * command - heading
    command = parameters[3] * command - roll
    command = parameters[2] * command - roll_rate
    command = parameters[1] * command - delta
    z_dot[0] = z[1]
    z_dot[1] = parameters[14] * (parameters[0] * command - z[0]) - parameters[15] * z[1]
    loads[1, 3], loads[1, 4], loads[1, 5] = z[0] * nx, z[0] * ny, z[0] * nz
    loads[0, 3], loads[0, 4], loads[0, 5] = -z[0] * nx, -z[0] * ny, -z[0] * nz


def ridden(parameters: Parameters, speed: float, course: Course, gains: Gains, **fittings: Any) -> Bicycle:
    """Build the bicycle with the rider as the force "rider", whose internal states are the torque [N m] and its
    rate."""
    system = whipple(parameters, speed=speed, **fittings)
    frame, fork = system.part("frame"), system.part("fork")
    numbers = (*gains, *course.numbers, *steer_axis(parameters)[1], parameters.rF - parameters.tF, *MUSCLES)
    states = {"torque": 0.0, "torque rate": 0.0}
    rider = CustomForce(steer, on=(frame, fork), parameters=numbers, states=states, scales=(1.0, 30.0), name="rider")
    start = system.state()
    start = replace(start, z=np.r_[start.z, 0.0, 0.0])
    return replace(system, forces=[*system.forces, rider], start=start)


@dataclass(frozen=True, eq=False, repr=False)
class RiddenCourse(Result):
    """Run over a course; lean, steer, heading and deviation to the right."""

    ride: Ride
    course: Course
    gains: Gains

    @property
    def torque(self) -> np.ndarray:
        """Return the torque of the rider's arms [N m], shape (n,)."""
        return self.ride.solution.force("rider", on="fork").states["torque"]

    @property
    def deviation(self) -> np.ndarray:
        """Return the deviation of the front contact from the first heading [m], shape (n,)."""
        return -self.ride.contacts["front"].point[:, 1]

    def commands(self) -> dict[str, np.ndarray]:
        """Return what every loop commands the next: heading, roll, roll rate, steer angle."""
        heading = self.gains.deviation * (self.course(self.ride.t) - self.deviation)
        roll = self.gains.heading * (heading - self.ride.heading)
        roll_rate = self.gains.roll * (roll - self.ride.lean)
        found = {"heading": heading, "roll": roll, "roll rate": roll_rate}
        return found | {"steer": self.gains.roll_rate * (roll_rate - self.ride.lean_rate)}

    def to_csv(self, path: str | Path) -> Path:
        """Write the table of the ride with torque, course and commands; ".csv" is appended if it is missing."""
        table = self.ride.columns() | {"torque [N m]": self.torque, "course [m]": self.course(self.ride.t)}
        table |= {
            f"commanded {name} [{'rad/s' if 'rate' in name else 'rad'}]": x for name, x in self.commands().items()
        }
        return write_table(path, [*table], np.column_stack([*table.values()]))

    def __str__(self) -> str:
        loops = ", ".join(f"{name} {value:.4g}" for name, value in self.gains._asdict().items())
        return "\n".join([
            str(self.ride), f"  gains: {loops}", f"  torque up to {np.abs(self.torque).max():.3g} N m, "
            f"{np.abs(self.deviation - self.course(self.ride.t)).max():.3g} m off the course at most",
        ])  # fmt: skip


def run(
    parameters: Parameters,
    course: Course,
    *,
    speed: float,
    gains: Gains | None = None,
    tyres: Tyres | None = None,
    steer_damping: float = 0.0,
    head_stiffness: float | None = None,
    head_damping: float = 0.0,
    t_end: float = 12.0,
    rtol: float = 1e-8,
    samples: int = 1201,
) -> RiddenCourse:
    """Simulate a rider who follows a course on the nonlinear bicycle, on ideal wheels or on tyres.

    Parameters
    ----------
    speed : float
        At the start [m/s]; nobody pedals.
    gains : Gains or None
        None = by the rule of `bicycle.rider.gains_of`, at this speed.
    tyres, steer_damping, head_stiffness, head_damping
        As in `bicycle.whipple`; the rule for gains knows neither.
    t_end, rtol, samples
        End [s], tolerance and number of samples of the run.

    Raises
    ------
    ValueError
        If the rule finds no gains, or a value is not a number.
    IntegrationError
        If the run cannot go on.

    Returns
    -------
    RiddenCourse
        Until the end, or until the rider falls or a wheel lifts, as in `bicycle.ride.run`.
    """
    speed = number(speed, "rider: speed", positive=True)
    gains = gains_of(parameters, speed) if gains is None else checked_gains(gains)
    if not isinstance(course, Course):
        raise InputError(f"rider: course = {course!r:.80}; give a Course, e.g. COURSES['slalom']")
    system = ridden(
        parameters, speed, course, gains, tyres=tyres, steer_damping=steer_damping, head_stiffness=head_stiffness,
        head_damping=head_damping,
    )  # fmt: skip
    settings = {"state": system.state(), "rtol": rtol, "output": samples}
    return RiddenCourse(ended(parameters, system, t_end, FALLEN, on_tyres(system.forces), settings), course, gains)


def figure(found: RiddenCourse, title: str | None = None, *, dark: bool = False) -> "Figure":
    """Plot angles, steer torque, the loops with their commands, and the path with the course."""
    ride, commands = found.ride, found.commands()
    with new_figure(10.0, 8.2, dark) as (sheet, look):
        sheet.set_layout_engine("constrained", w_pad=0.1, h_pad=0.08)
        axes = sheet.subplot_mosaic(
            [["angles", "torque"], ["roll", "heading"], ["way", "way"]], height_ratios=(1.0, 1.0, 1.2)
        )
        for one in axes.values():
            style_axes(one, look)
            one.set_xlabel("time [s]")
        lines(axes["angles"], ride.t, {"lean": np.degrees(ride.lean), "steer": np.degrees(ride.steer)}, look)
        lines(axes["torque"], ride.t, {"torque": found.torque}, look)
        pairs = {"roll": ride.lean, "heading": ride.heading}
        for name, is_ in pairs.items():
            wanted = {f"{name} wanted": np.degrees(commands[name]), name: np.degrees(is_)}
            lines(axes[name], ride.t, wanted, look)
        course = found.course(ride.t)
        axes["way"].plot(
            ride.speed[0] * ride.t,
            course,
            color=look.muted,
            linestyle="--",
            linewidth=LINE_WIDTH_POINTS,
            label="course",
        )
        front = ride.contacts["front"].point
        axes["way"].plot(
            front[:, 0] - front[0, 0], found.deviation, color=look.colour(0), linewidth=LINE_WIDTH_POINTS, label="path"
        )
        axes["way"].invert_yaxis()
        axes["way"].set_xlabel("distance along the first heading [m]")
        legend_above(axes["way"], look)
        labels = {"angles": "angle, right > 0 [°]", "torque": "steer torque [N m]", "roll": "roll [°]"}
        for name, label in {**labels, "heading": "heading [°]", "way": "offset to the right [m]"}.items():
            axes[name].set_ylabel(label)
        who = ride.parameters.name + " on tyres" * on_tyres(ride.solution.system.forces)
        sheet.suptitle(f"{who}: {title}" if title else who, fontweight="bold")
    return sheet
