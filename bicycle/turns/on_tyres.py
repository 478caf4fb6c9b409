"""Steady turns on tyres at a speed and a lean: steer, torques of rider and pedals, slip and grip, up to the limit."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import root

from mbsd3d import AssemblyError, Input, Signal, Solution, State, accelerations
from mbsd3d.errors import InputError
from mbsd3d.extend import LINE_WIDTH_POINTS, Rates, as_signal, cross, new_figure, number, style_axes, write_table

from ..model.kinematics import Pose, Y, Z, placed, steer_axis
from ..model.mechanism import Bicycle, steer_torque, whipple
from ..model.tyres import Tyres
from ..parameters import Parameters
from ..rides.motion import WHEELS
from ..rides.ride import axle_torque
from .turning import SteadyTurn, Turn

if TYPE_CHECKING:
    from matplotlib.figure import Figure

UNKNOWN_SIZES = np.array([0.1, 0.01, 0.01, 0.1, 0.1, 1.0, 1.0, 1.0, 1.0, 0.01, 0.01, 0.01, 0.01])
"""Of the unknowns: steer, pitch, height of the rear hub over that of an ideal wheel, its speed to the left, yaw rate,
spins of the wheels over frame and fork, steer and drive torque, deflections of the tyres."""
DIFFERENCE_STEP = 1e-6
"""Of the lean [rad] and, over `UNKNOWN_SIZES`, of the unknowns, for derivatives."""
CHANGE_MAX = 0.5
"""Largest distance of a turn from where the tangent leads, over the way there."""
LEAN_STEP_MIN = 1e-3
"""[rad] Shortest step of lean on the way to one that has no turn."""
RESIDUAL_MAX = 1e-8
"""Largest acceleration left over [m/s^2, rad/s^2], and rate of a deflection; rounding leaves 1e-12."""


@dataclass(frozen=True, eq=False, repr=False)
class TyreTurn(SteadyTurn):
    """Steady turn; angles, yaw rate and torques are positive to the right, drive ahead."""

    parameters: Parameters
    speed: float  # [m/s] of the rear hub, ahead
    lean: float  # [rad]
    x: np.ndarray  # (13,) the unknowns as solved, see `UNKNOWN_SIZES`
    system: Bicycle  # under the torques that hold it
    state: State
    at: Solution  # one sample: ``.force("rear tyre")`` and so on

    @property
    def steer(self) -> float:
        """Return the steer angle [rad]."""
        return float(self.x[0])

    @property
    def yaw_rate(self) -> float:
        """Return the yaw rate [rad/s]."""
        return -float(self.x[4])

    @property
    def radius(self) -> float:
        """Return the radius of the path of the rear hub [m]; infinite straight ahead."""
        return float(np.hypot(self.speed, self.x[3]) / abs(self.x[4])) if self.x[4] else np.inf

    @property
    def steer_torque(self) -> float:
        """Return the steer torque that holds the turn [N m]."""
        return float(self.x[7])

    @property
    def drive_torque(self) -> float:
        """Return the torque on the rear wheel, against the drag of the tyres in the turn [N m]."""
        return float(self.x[8])

    @cached_property
    def forces(self) -> list[Any]:
        """Return the forces of the ground on the rear and the front wheel, one sample each [N]."""
        return [self.at.force(f"{wheel} tyre") for wheel in WHEELS]

    @property
    def saturation(self) -> float:
        """Return the larger share of the grip that a tyre uses [-]."""
        return max(float(load.saturation[0]) for load in self.forces)

    @property
    def friction(self) -> float:
        """Return the larger ratio of horizontal force to load of a wheel [-]."""
        return max(float(np.hypot(x.longitudinal[0], x.lateral[0]) / x.normal[0]) for x in self.forces)

    def columns(self) -> dict[str, float]:
        """Return the line of the table that `to_csv` writes."""
        found = {"speed [m/s]": self.speed, "lean [rad]": self.lean, "steer [rad]": self.steer}
        found |= {"yaw rate [rad/s]": self.yaw_rate, "radius [m]": self.radius}
        found |= {"steer torque [N m]": self.steer_torque, "drive torque [N m]": self.drive_torque}
        for wheel, load in zip(WHEELS, self.forces, strict=True):
            found |= {f"{wheel} load [N]": load.normal[0], f"{wheel} slip angle [rad]": -load.slip_angle[0]}
            found[f"{wheel} saturation [-]"] = load.saturation[0]
        return found

    def __str__(self) -> str:
        return (
            f"{self.parameters.name} on tyres: steady turn at {self.speed:.6g} m/s, lean {self.lean:.6g} rad, steer "
            f"{self.steer:.6g} rad, radius {self.radius:.6g} m, steer torque {self.steer_torque:.6g} N m, "
            f"{100 * self.saturation:.3g} % of the grip"
        )


class Balance:
    """Steady turns at one speed, and the residual of a state against a steady turn."""

    def __init__(self, parameters: Parameters, tyres: Tyres, speed: float) -> None:
        self.parameters, self.speed = parameters, speed
        self.free = whipple(parameters, tyres=tyres)
        self.axis = steer_axis(parameters)[1]
        self.straight = np.zeros(len(UNKNOWN_SIZES))
        self.straight[5:7] = speed / parameters.rR, speed / parameters.rF
        self.rates = Rates(self.held(Input("steer"), Input("drive")), self.state(self.straight, 0.0)[0])

    def held(self, steer: Signal | float, drive: Signal | float) -> Bicycle:
        """Build the bicycle under a steer and a drive torque [N m]."""
        forces = [*self.free.forces, *steer_torque(self.free, self.parameters, steer)]
        forces += axle_torque(self.free, "rear wheel", "frame", as_signal(drive, "turn: drive"), "drive")
        return replace(self.free, forces=forces)

    def state(self, x: np.ndarray, lean: float) -> tuple[State, Pose]:
        """Return state and pose of the unknowns at a lean [rad]."""
        at = placed(self.parameters, lean, x[0], x[1])
        shift = np.array([0.0, -at.rear[1], x[2]])
        at = at._replace(rear=at.rear + shift, front=at.front + shift)
        turn = x[4] * Z
        v_r = np.array([self.speed, x[3], 0.0])
        v_f = v_r + cross(turn, at.front - at.rear)
        v = [v_r, turn + x[5] * at.frame @ Y, v_r, turn, v_f, turn, v_f, turn + x[6] * at.fork @ Y]
        return State(0.0, at.q, np.concatenate(v), z=x[9:], coordinates=np.array([0.0, x[0], 0.0])), at

    def lack(self, x: np.ndarray, lean: float) -> np.ndarray:
        """Return accelerations of frame, fork and wheels over those of a steady turn, and rates of the deflections,
        shape (13,).
        """
        state, at = self.state(x, lean)
        self.rates.set("steer", x[7])
        self.rates.set("drive", x[8])
        (rear, frame, fork, front), z_dot = self.rates(state)
        gap = frame[:3] - x[4] * np.array([-x[3], self.speed, 0.0])
        about = [at.frame @ self.axis @ (fork - frame)[3:], at.frame @ Y @ (rear - frame)[3:]]
        return np.r_[gap, frame[3:], about, at.fork @ Y @ (front - fork)[3:], z_dot]

    def slope(self, at: "TyreTurn") -> np.ndarray:
        """Return the change of the unknowns with the lean along the turns [1/rad], shape (13,)."""
        here = self.lack(at.x, at.lean)
        columns = [self.lack(at.x + change, at.lean) - here for change in np.diag(DIFFERENCE_STEP * UNKNOWN_SIZES)]
        by_lean = self.lack(at.x, at.lean + DIFFERENCE_STEP) - here
        return -UNKNOWN_SIZES * np.linalg.solve(np.transpose(columns), by_lean)

    def turn(self, start: np.ndarray, lean: float) -> "TyreTurn | None":
        """Return the turn at a lean [rad] near unknowns (13,); None if none presses both wheels to the ground."""
        try:
            found = root(lambda x: self.lack(UNKNOWN_SIZES * x, lean), start / UNKNOWN_SIZES, tol=1e-14)
        except AssemblyError:
            return None
        if not np.abs(found.fun).max() < RESIDUAL_MAX:
            return None
        x = UNKNOWN_SIZES * found.x
        system, state = self.held(*x[7:9].tolist()), self.state(x, lean)[0]
        made = TyreTurn(self.parameters, self.speed, lean, x, system, state, accelerations(system, state))
        return made if min(load.normal[0] for load in made.forces) > 0.0 else None

    def followed(self, last: "TyreTurn", lean: float) -> "TyreTurn":
        """Return the turn at a lean [rad], followed from another one along the tangent; the last of them if there is
        none.

        A turn far from where the tangent leads, in view of the step, is another one: then the step is halved.
        """
        slope, step = self.slope(last), lean - last.lean
        while last.lean != lean:
            there = lean if abs(step) >= abs(lean - last.lean) else last.lean + step
            ahead = (there - last.lean) * slope
            new = self.turn(last.x + ahead, there)
            if new is None or size(new.x - last.x - ahead) > CHANGE_MAX * size(ahead) + RESIDUAL_MAX:
                step = 0.5 * (there - last.lean)
                if abs(step) < LEAN_STEP_MIN:
                    break
                continue
            last, slope, step = new, self.slope(new), 2.0 * step
        return last


def size(change: np.ndarray) -> float:
    """Return the scaled size of a change of the unknowns [-]."""
    return float(np.linalg.norm(change / UNKNOWN_SIZES))


def turn(parameters: Parameters, tyres: Tyres, *, speed: float, lean: float) -> TyreTurn:
    """Compute the steady turn at a speed of the rear hub [m/s] and a lean [rad], followed from straight running.

    Raises
    ------
    ValueError
        If the turns end before this lean: at the limit of grip, where a wheel lifts, or where the speed allows no more.

    Examples
    --------
    >>> from bicycle import Meijaard2007, TYPICAL
    >>> round(turn(Meijaard2007(), TYPICAL, speed=5.0, lean=0.1).steer, 9)
    0.041078062
    """
    return turns(parameters, tyres, speed, [lean])[0]


def turns(parameters: Parameters, tyres: Tyres, speed: float, leans: Iterable[float]) -> list[TyreTurn]:
    """Compute turns at leans of rising size [rad] until there are no more, and one within `LEAN_STEP_MIN` of the last
    that exists.

    Raises
    ------
    ValueError
        If there is no turn at the first lean, or a value is not a number.
    """
    what = f"bicycle '{parameters.name}': turn on tyres"
    balance = Balance(parameters, tyres, number(speed, f"{what}: speed", positive=True))
    found: list[TyreTurn] = []
    last = balance.turn(balance.straight, 0.0)
    if last is None:
        raise InputError(f"{what}: at {speed:g} m/s it does not run straight with both wheels on the ground")
    for lean in leans:
        before, last = last, balance.followed(last, number(lean, f"{what}: lean"))
        if last.lean != lean and not found:
            raise InputError(
                f"{what}: none at {speed:g} m/s and a lean of {lean:.4g} rad; those from straight ahead on end at a "
                f"lean of {last.lean:.4g} rad; give a smaller one"
            )
        if last is not before or not found:
            found.append(last)
        if last.lean != lean:
            break
    return found


def to_csv(found: Iterable[TyreTurn], path: str | Path) -> Path:
    """Write one line per turn; ".csv" is appended if it is missing."""
    rows = [one.columns() for one in found]
    return write_table(path, [*rows[0]], [list(row.values()) for row in rows])


def figure(
    found: Sequence[Sequence[TyreTurn]], ideal: Sequence[Sequence[Turn]], title: str, *, dark: bool = False
) -> "Figure":
    """Plot steer, steer torque, drive torque and grip over the lean, a colour per speed; dashed: ideal wheels."""
    with new_figure(10.0, 7.0, dark) as (sheet, look):
        axes = sheet.subplots(2, 2, sharex=True)
        labels = ("steer [°]", "steer torque that holds it [N m]", "drive torque that keeps the speed [N m]")
        for one, label in zip(axes.flat, (*labels, "grip used [-]"), strict=True):
            style_axes(one, look)
            one.set_ylabel(label)
        for k, group in enumerate(found):
            lean, style = (
                np.degrees([one.lean for one in group]),
                {"color": look.colour(k), "linewidth": LINE_WIDTH_POINTS},
            )
            values = [[np.degrees(x.steer), x.steer_torque, x.drive_torque, x.saturation] for x in group]
            for one, line in zip(axes.flat, np.transpose(values), strict=True):
                one.plot(lean, line, label=f"{group[0].speed:g} m/s", **style)
        for k, circles in enumerate(ideal):
            lean, style = (
                np.degrees([one.lean for one in circles]),
                {"color": look.colour(k), "linewidth": LINE_WIDTH_POINTS},
            )
            for one, line in zip(
                axes.flat, ([np.degrees(x.steer) for x in circles], [x.torque for x in circles]), strict=False
            ):
                one.plot(lean, line, linestyle="--", label="ideal wheels" if k == len(ideal) - 1 else None, **style)
        for one in axes[1]:
            one.set_xlabel("lean [°]")
        axes[0, 1].legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize=9, labelcolor=look.ink)
        sheet.suptitle(title, fontweight="bold")
    return sheet
