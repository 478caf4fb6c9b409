"""Results of a ride: lean, steer, heading, path, forces of the ground and the friction they need, errors of the run."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mbsd3d import Solution
from mbsd3d.extend import LINE_WIDTH_POINTS, ForceElement, Result, Theme, new_figure, style_axes, write_table

from ..model.kinematics import X, Y, Z
from ..parameters import Parameters

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from pandas import DataFrame

WHEELS = ("rear", "front")
FRICTION_MAX = 2.0  # [1] coefficient of friction that no tyre reaches on any road
SPEED_CHANGE_SHARE = 0.1  # [1] of the speed; a larger change is drawn instead of the yaw rate
ASPECT_RATIO_MAX = 6.0  # [1] length over width; longer tracks are not drawn to scale
LABELS = {
    "angles": "angle, right > 0 [°]",
    "rates": "yaw rate, right > 0 [°/s]",
    "loads": "load of the wheel [N]",
    "friction": "friction needed [-]",
}


def on_tyres(forces: Iterable[ForceElement]) -> bool:
    """Return whether the wheels of a system with these forces run on tyres; otherwise they roll without slip."""
    return any(force.name == "rear tyre" for force in forces)


def ground_force(solution: Solution, wheel: str) -> tuple[np.ndarray, np.ndarray]:
    """Return (contact point [m], force of the ground [N]) of a wheel, (n, 3) each."""
    tyres = on_tyres(solution.system.forces)
    found = solution.force(f"{wheel} tyre") if tyres else solution.reaction(f"{wheel} contact")
    return found.point, found.force


class Event(NamedTuple):
    """Cause of the early end of a ride."""

    name: str  # "fallen", "rear wheel unloaded", "front wheel unloaded"
    t: float  # [s]


class Contact(NamedTuple):
    """Force of the ground on a wheel over time: arrays (n,), the point and the force (n, 3) in world axes."""

    point: np.ndarray  # [m]
    force: np.ndarray  # [N]
    normal: np.ndarray  # upward [N]
    along: np.ndarray  # along the track, forward [N]
    across: np.ndarray  # across the track, to the right [N]

    @property
    def friction(self) -> np.ndarray:
        """Return the coefficient of friction that prevents slip of the wheel; infinite where the wheel is pulled, not
        pressed.
        """
        horizontal = np.hypot(self.along, self.across)
        return np.divide(horizontal, self.normal, out=np.where(horizontal, np.inf, 0.0), where=self.normal > 0.0)


@dataclass(frozen=True, eq=False, repr=False)
class Ride(Result):
    """Run of the Whipple bicycle. Arrays over time (n,); lean, steer and heading are positive to the right [rad]."""

    parameters: Parameters
    solution: Solution  # the run itself: ``.animate()``, ``.certificate``, ``.save()``
    event: Event | None = None  # what ended it early; the samples end there

    @property
    def t(self) -> np.ndarray:
        """Return the times [s]."""
        return self.solution.t

    @property
    def interrupted(self) -> bool:
        """Return whether Ctrl-C interrupted the run."""
        return (self.solution.record.stopped_by or "").startswith("interrupted")

    @cached_property
    def axle(self) -> np.ndarray:
        """Return the axle of the rear wheel, to the left, shape (n, 3)."""
        return self.solution.rotation("frame") @ Y

    @cached_property
    def axle_rate(self) -> np.ndarray:
        """Return the rate of the axle [1/s], shape (n, 3)."""
        return np.cross(self.solution.omega("frame"), self.axle)

    @property
    def lean(self) -> np.ndarray:
        """Return the angle of the frame's plane from the vertical [rad]."""
        return np.arctan2(self.axle[:, 2], np.hypot(self.axle[:, 0], self.axle[:, 1]))

    @property
    def lean_rate(self) -> np.ndarray:
        """Return the rate of the lean [rad/s]."""
        return self.axle_rate[:, 2] / np.hypot(self.axle[:, 0], self.axle[:, 1])

    @property
    def steer(self) -> np.ndarray:
        """Return the steer angle [rad]."""
        return self.solution.angle("steer")

    @property
    def steer_rate(self) -> np.ndarray:
        """Return the rate of the steer angle [rad/s]."""
        return self.solution.rate("steer")

    @property
    def heading(self) -> np.ndarray:
        """Return the direction of the rear wheel's track [rad], to the right, unwrapped over full turns."""
        ahead = self.ahead(self.axle)
        return -np.unwrap(np.arctan2(ahead[:, 1], ahead[:, 0]))

    @property
    def yaw_rate(self) -> np.ndarray:
        """Return the rate of the heading [rad/s]."""
        (x, y, _), (x_dot, y_dot, _) = self.axle.T, self.axle_rate.T
        return (y * x_dot - x * y_dot) / (x**2 + y**2)

    @property
    def pitch(self) -> np.ndarray:
        """Return the pitch of the frame about its lateral axis, nose up > 0 [rad]."""
        along = self.solution.rotation("frame") @ X
        ahead = self.ahead(self.axle)
        return np.arctan2(np.sum(np.cross(along, ahead) * self.axle, axis=1), np.sum(ahead * along, axis=1))

    @property
    def speed(self) -> np.ndarray:
        """Return the radius times rate of the rear hub [m/s]: speed of the contact point of a knife-edge wheel."""
        return self.rolling("rear")

    def rolling(self, wheel: str) -> np.ndarray:
        """Return the radius times rate of the hub of the "rear" or "front" wheel [m/s]; 0 where it is locked."""
        radius = self.parameters.rR if wheel == "rear" else self.parameters.rF
        return radius * self.solution.rate(f"{wheel} hub")

    @property
    def advance(self) -> np.ndarray:
        """Return the speed of the rear hub along the heading [m/s]."""
        return np.sum(self.solution.velocity("frame") * self.ahead(self.axle), axis=1)

    @staticmethod
    def ahead(axle: np.ndarray) -> np.ndarray:
        """Return the horizontal directions in which a wheel with these axles rolls, shape (n, 3)."""
        level = np.cross(axle, Z)
        return level / np.linalg.norm(level, axis=1, keepdims=True)

    @cached_property
    def contacts(self) -> dict[str, Contact]:
        """Return the forces of the ground on the wheels "rear" and "front"."""
        found = {}
        for wheel in WHEELS:
            point, force = ground_force(self.solution, wheel)
            ahead = self.ahead(self.solution.rotation(f"{wheel} wheel") @ Y)
            right = np.cross(ahead, Z)
            along, across = (np.sum(force * way, axis=1) for way in (ahead, right))
            found[wheel] = Contact(point, force, force[:, 2], along, across)
        return found

    @property
    def friction(self) -> float:
        """Return the largest coefficient of friction that a wheel needs."""
        return max(float(contact.friction.max(initial=0.0)) for contact in self.contacts.values())

    @property
    def energy_drift(self) -> float:
        """Return the largest |E - E(0) - work| over E(0), with the ground as level of zero potential energy [-]."""
        energy = self.solution.energy()
        gap = energy.total - energy.total[0] - (energy.work - energy.work[0])
        return float(np.abs(gap).max() / abs(energy.total[0]))

    def columns(self) -> dict[str, np.ndarray]:
        """Return the table of `to_csv` and `to_dataframe`: header with unit -> (n,) values."""
        table = {"t [s]": self.t}
        for name in ("lean", "steer", "heading", "pitch"):
            table[f"{name} [rad]"] = getattr(self, name)
        for name in ("lean_rate", "steer_rate", "yaw_rate"):
            table[f"{name} [rad/s]"] = getattr(self, name)
        table["speed [m/s]"] = self.speed
        for wheel, contact in self.contacts.items():
            table |= {f"{wheel}_{axis} [m]": contact.point[:, k] for k, axis in enumerate("xy")}
            table |= {f"{wheel}_{name} [N]": getattr(contact, name) for name in ("normal", "along", "across")}
            table[f"{wheel}_friction [-]"] = contact.friction
        return table

    def to_csv(self, path: str | Path) -> Path:
        """Write `columns`, one line per sample, all digits; ".csv" is appended if it is missing."""
        table = self.columns()
        return write_table(path, [*table], np.column_stack([*table.values()]))

    def to_dataframe(self) -> "DataFrame":
        """Return `columns` as a pandas DataFrame, one row a sample, indexed by the time [s]."""
        import pandas

        return pandas.DataFrame(self.columns()).set_index("t [s]")

    def __str__(self) -> str:
        checks = self.solution.certificate
        bar = {name: f"{np.degrees(np.abs(getattr(self, name)).max()):.2f}°" for name in ("lean", "steer")}
        least = {wheel: f"{contact.normal.min():.1f}" for wheel, contact in self.contacts.items()}
        lines = [
            f"{self.parameters.name}: {self.t[-1]:.6g} s, {self.speed[0]:.4g} m/s at the start",
            f"  {f'{self.event.name} at t = {self.event.t:.6g} s' if self.event else 'upright until the end'}",
            f"  largest lean {bar['lean']}, steer {bar['steer']}; last heading {np.degrees(self.heading[-1]):.2f}°",
            f"  least load: rear wheel {least['rear']} N, front wheel {least['front']} N; friction needed"
            f" {f'{self.friction:.3g}' if self.friction < FRICTION_MAX else 'beyond any road'}",
            f"  energy audit {self.energy_drift:.1e} of E(0), momentum {checks['momentum balance'].error:.1e}, angular"
            f" momentum {checks['angular momentum'].error:.1e}; certificate {'passed' if checks.passed else 'FAILED'}",
        ]
        return "\n".join(lines)


def plot_ride(ride: Ride, title: str | None = None, *, dark: bool = False) -> "Figure":
    """Plot lean, steer, loads of the wheels and friction they need over time, and the tracks of both wheels from
    above."""
    with new_figure(10.0, 8.2, dark) as (figure, look):
        figure.set_layout_engine("constrained", w_pad=0.1, h_pad=0.08)
        axes = figure.subplot_mosaic(
            [["angles", "loads"], ["rates", "friction"], ["way", "way"]], height_ratios=(1.0, 1.0, 1.3)
        )
        for one in axes.values():
            style_axes(one, look)
        lines(axes["angles"], ride.t, {"lean": np.degrees(ride.lean), "steer": np.degrees(ride.steer)}, look)
        hubs, label = {wheel: ride.rolling(wheel) for wheel in WHEELS}, LABELS["rates"]
        if max(np.ptp(speed) for speed in hubs.values()) > SPEED_CHANGE_SHARE * abs(ride.speed[0]):
            lines(axes["rates"], ride.t, {"way": ride.advance, **hubs}, look)
            label = "speed of way and wheels [m/s]"
        else:
            lines(axes["rates"], ride.t, {"yaw rate": np.degrees(ride.yaw_rate)}, look)
        lines(axes["loads"], ride.t, {wheel: contact.normal for wheel, contact in ride.contacts.items()}, look)
        friction = {wheel: contact.friction for wheel, contact in ride.contacts.items()}
        lines(axes["friction"], ride.t, friction, look)
        axes["friction"].set_ylim(0.0, min(1.05 * ride.friction, FRICTION_MAX) or 1.0)
        for name, text in {**LABELS, "rates": label}.items():
            axes[name].set_ylabel(text)
            axes[name].set_xlabel("time [s]")
        way(axes["way"], ride, look)
        figure.suptitle(f"{ride.parameters.name}: {title}" if title else ride.parameters.name, fontweight="bold")
    return figure


def lines(axes: "Axes", t: np.ndarray, values: dict[str, np.ndarray], look: Theme) -> None:
    """Draw curves over time, named beside the axes if there are several."""
    for k, (name, line) in enumerate(values.items()):
        axes.plot(t, line, color=look.colour(k), linewidth=LINE_WIDTH_POINTS, label=name)
    if len(values) > 1:
        legend_above(axes, look)


def legend_above(axes: "Axes", look: Theme) -> None:
    """Draw names of the lines above the axes."""
    axes.legend(frameon=False, labelcolor=look.ink, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3)


def way(axes: "Axes", ride: Ride, look: Theme) -> None:
    """Draw tracks of both wheels from above, to scale unless the path is slender; the end is marked."""
    points = {wheel: contact.point for wheel, contact in ride.contacts.items()}
    for k, (wheel, point) in enumerate(points.items()):
        axes.plot(point[:, 0], -point[:, 1], color=look.colour(k), linewidth=LINE_WIDTH_POINTS, label=f"{wheel} wheel")
        axes.plot(point[-1, 0], -point[-1, 1], "o", color=look.colour(k), markersize=5)
    size = np.ptp(np.concatenate([*points.values()]), axis=0)
    axes.set_xlabel("way along the first heading [m]")
    axes.set_ylabel("way to the right [m]")
    axes.invert_yaxis()  # seen from above, what is to the right is below
    if size[0] < ASPECT_RATIO_MAX * size[1]:
        axes.set_aspect("equal", adjustable="datalim")
    if ride.event:
        axes.set_title(f"{ride.event.name} at {ride.event.t:.3g} s", loc="right", color=look.ink)
    legend_above(axes, look)
