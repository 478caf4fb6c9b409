"""Steady turns on tyres at a speed and a lean: steer, torques of rider and pedals, slip and grip, up to the limit."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import root

from mbsd3d import Input, Signal, Solution, State, accelerations
from mbsd3d.errors import InputError
from mbsd3d.extend import LINE, Rates, as_signal, cross, dress, number

from ..model.kinematics import Pose, X, Y, Z, placed, pose_of, rotation_about, steer_axis
from ..model.mechanism import Bicycle, steer_torque, whipple
from ..model.tyres import Tyres
from ..output import new_figure, write_table
from ..parameters import Parameters
from ..rides.ride import axle_torque
from .turning import SteadyTurn, Turn

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIZES = np.array([0.1, 0.01, 0.01, 0.1, 0.1, 1.0, 1.0, 1.0, 1.0, 0.01, 0.01, 0.01, 0.01])
"""Of the unknowns: steer, pitch, height of the rear hub over that of an ideal wheel, its speed to the left, yaw rate,
spins of the wheels over frame and fork, steer and drive torque, deflections of the tyres."""
STEP = 0.1  # [rad] of lean from one turn to the next
HALVED = 5
STEADY = 1e-8
"""Largest acceleration left over [m/s^2, rad/s^2], and rate of a deflection; rounding leaves 1e-12."""


@dataclass(frozen=True, eq=False)
class TyreTurn(SteadyTurn):
    """A steady turn; angles, yaw rate and torques are positive to the right, drive ahead."""

    parameters: Parameters
    speed: float  # [m/s] of the rear hub, ahead
    lean: float  # [rad]
    x: np.ndarray  # (13,) the unknowns as solved, see `SIZES`
    system: Bicycle  # under the torques that hold it
    state: State
    at: Solution  # one sample: ``.force("rear tyre")`` and so on

    @property
    def steer(self) -> float:
        """Steer angle [rad]."""
        return float(self.x[0])

    @property
    def yaw_rate(self) -> float:
        """Yaw rate [rad/s]."""
        return -float(self.x[4])

    @property
    def radius(self) -> float:
        """Radius of the way of the rear hub [m]; infinite straight ahead."""
        return float(np.hypot(self.speed, self.x[3]) / abs(self.x[4])) if self.x[4] else np.inf

    @property
    def steer_torque(self) -> float:
        """That holds the turn [N m]."""
        return float(self.x[7])

    @property
    def drive_torque(self) -> float:
        """Torque on the rear wheel, against the drag of the tyres in the turn [N m]."""
        return float(self.x[8])

    @cached_property
    def saturation(self) -> float:
        """The larger part of the grip that a tyre uses."""
        return max(float(self.at.force(f"{wheel} tyre").saturation[0]) for wheel in ("rear", "front"))

    @property
    def friction(self) -> float:
        """The larger horizontal force of a wheel over its load."""
        loads = [self.at.force(f"{wheel} tyre") for wheel in ("rear", "front")]
        return max(float(np.hypot(x.longitudinal[0], x.lateral[0]) / x.normal[0]) for x in loads)

    def columns(self) -> dict[str, float]:
        """The line of the table that `to_csv` writes."""
        found = {"speed [m/s]": self.speed, "lean [rad]": self.lean, "steer [rad]": self.steer}
        found |= {"yaw rate [rad/s]": self.yaw_rate, "radius [m]": self.radius}
        found |= {"steer torque [N m]": self.steer_torque, "drive torque [N m]": self.drive_torque}
        for wheel in ("rear", "front"):
            load = self.at.force(f"{wheel} tyre")
            found |= {f"{wheel} load [N]": load.normal[0], f"{wheel} slip angle [rad]": -load.slip_angle[0]}
            found[f"{wheel} saturation [-]"] = load.saturation[0]
        return found


class Balance:
    """What a state lacks to be a steady turn."""

    def __init__(self, parameters: Parameters, tyres: Tyres, speed: float, lean: float) -> None:
        self.parameters, self.speed, self.lean = parameters, speed, lean
        self.free = whipple(parameters, tyres=tyres)
        self.axis = steer_axis(parameters)[1]
        start = self.state(guess(parameters, self.free, speed, lean))[0]
        self.rates = Rates(self.held(Input("steer"), Input("drive")), start)

    def held(self, steer: Signal | float, drive: Signal | float) -> Bicycle:
        """The bicycle under a steer and a drive torque [N m]."""
        forces = [*self.free.forces, *steer_torque(self.free, self.parameters, steer)]
        forces += axle_torque(self.free, "rear wheel", "frame", as_signal(drive, "turn: drive"), "drive")
        return replace(self.free, forces=forces)

    def state(self, x: np.ndarray) -> tuple[State, Pose]:
        """State and pose of the unknowns."""
        at = placed(self.parameters, self.lean, x[0], x[1])
        shift = np.array([0.0, -at.rear[1], x[2]])
        at = at._replace(rear=at.rear + shift, front=at.front + shift)
        turn = x[4] * Z
        v_r = np.array([self.speed, x[3], 0.0])
        v_f = v_r + cross(turn, at.front - at.rear)
        v = [v_r, turn + x[5] * at.frame @ Y, v_r, turn, v_f, turn, v_f, turn + x[6] * at.fork @ Y]
        return State(0.0, at.q, np.concatenate(v), z=x[9:], coordinates=np.array([0.0, x[0], 0.0])), at

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """(13,) accelerations of frame, fork and wheels over those of a steady turn, and rates of the deflections."""
        state, at = self.state(x)
        self.rates.set("steer", x[7])
        self.rates.set("drive", x[8])
        (rear, frame, fork, front), z_dot = self.rates(state)
        gap = frame[:3] - x[4] * np.array([-x[3], self.speed, 0.0])
        about = [at.frame @ self.axis @ (fork - frame)[3:], at.frame @ Y @ (rear - frame)[3:]]
        return np.r_[gap, frame[3:], about, at.fork @ Y @ (front - fork)[3:], z_dot]


def pitch_of(p: Parameters, lean: float, steer: float) -> float:
    """Pitch at which both ideal wheels stand on the ground [rad]."""
    upright = rotation_about(X, -lean) @ pose_of(p, lean, steer).frame
    return float(np.arctan2(-upright[2, 0], upright[0, 0]))


def turn(parameters: Parameters, tyres: Tyres, *, speed: float, lean: float, near: TyreTurn | None = None) -> TyreTurn:
    """The steady turn at a speed of the rear hub [m/s] and a lean [rad].

    Parameters
    ----------
    near : TyreTurn or None
        Where the search starts; None = a turn of ideal wheels by its textbook formula.

    Raises
    ------
    ValueError
        If there is no such turn near it: beyond the grip of a tyre there is none.

    Examples
    --------
    >>> from bicycle import Meijaard2007, TYPICAL
    >>> round(turn(Meijaard2007(), TYPICAL, speed=5.0, lean=0.1).steer, 9)
    0.041078062
    """
    what = f"bicycle '{parameters.name}': turn on tyres"
    speed, lean = number(speed, f"{what}: speed", positive=True), number(lean, f"{what}: lean")
    balance = Balance(parameters, tyres, speed, lean)
    if near is None and abs(lean) > 1.5 * STEP:
        near = turn(parameters, tyres, speed=speed, lean=lean - np.copysign(STEP, lean))
    start = guess(parameters, balance.free, speed, lean)
    if near is not None:
        start += near.x - guess(parameters, balance.free, near.speed, near.lean)
    found = root(lambda x: balance(SIZES * x), start / SIZES, tol=1e-14)
    left = float(np.abs(found.fun).max())
    if not left < STEADY:
        raise InputError(
            f"{what}: none at {speed:g} m/s and a lean of {lean:.4g} rad ({left:.2g} m/s^2 are left over); give a "
            "smaller lean, or a turn near it"
        )
    x = SIZES * found.x
    system, state = balance.held(*x[7:9].tolist()), balance.state(x)[0]
    return TyreTurn(parameters, speed, lean, x, system, state, accelerations(system, state))


def guess(p: Parameters, system: Bicycle, speed: float, lean: float) -> np.ndarray:
    """The unknowns of a leaning bicycle whose wheels follow a circle with little slip."""
    yaw_rate = -p.g * np.tan(lean) / speed
    steer = -p.w * yaw_rate / speed * np.cos(lean) / np.cos(p.lam)
    rear, front = (system.part(f"{wheel} tyre", "forces") for wheel in ("rear", "front"))
    start = [steer, pitch_of(p, lean, steer), 0.0, 0.0, yaw_rate, speed / p.rR, speed / p.rF, 0.0, 0.0]
    return np.array([*start, 0.0, -np.tan(lean) / rear.cornering, 0.0, -np.tan(lean) / front.cornering])


def turns(parameters: Parameters, tyres: Tyres, speed: float, leans: Iterable[float]) -> list[TyreTurn]:
    """Turns at rising leans [rad], each sought near the one before, until none is left: the limit of grip.

    Between the last lean that has a turn and the first that has none the limit is halved in `HALVED` times.
    """
    found: list[TyreTurn] = []
    for lean in leans:
        try:
            found.append(turn(parameters, tyres, speed=speed, lean=float(lean), near=found[-1] if found else None))
        except ValueError:
            if not found:
                raise
            return found + up_to_the_limit(parameters, tyres, found[-1], float(lean))
    return found


def up_to_the_limit(parameters: Parameters, tyres: Tyres, last: TyreTurn, beyond: float) -> list[TyreTurn]:
    """Turns between one that there is and a lean [rad] at which there is none."""
    found = [last]
    for _ in range(HALVED):
        lean = 0.5 * (found[-1].lean + beyond)
        try:
            found.append(turn(parameters, tyres, speed=last.speed, lean=lean, near=found[-1]))
        except ValueError:
            beyond = lean
    return found[1:]


def to_csv(found: Iterable[TyreTurn], path: str | Path) -> Path:
    """Write one line per turn; ".csv" is appended if it is missing."""
    rows = [one.columns() for one in found]
    return write_table(path, [*rows[0]], [list(row.values()) for row in rows])


def figure(
    found: Sequence[Sequence[TyreTurn]], ideal: Sequence[Sequence[Turn]], title: str, *, dark: bool = False
) -> "Figure":
    """Steer, steer torque, drive torque and grip over the lean, a colour per speed; dashed: ideal wheels."""
    with new_figure(10.0, 7.0, dark) as (sheet, look):
        axes = sheet.subplots(2, 2, sharex=True)
        labels = ("steer [°]", "steer torque that holds it [N m]", "drive torque that keeps the speed [N m]")
        for one, label in zip(axes.flat, (*labels, "grip used [-]"), strict=True):
            dress(one, look)
            one.set_ylabel(label)
        for k, group in enumerate(found):
            lean, style = np.degrees([one.lean for one in group]), {"color": look.colour(k), "linewidth": LINE}
            values = [[np.degrees(x.steer), x.steer_torque, x.drive_torque, x.saturation] for x in group]
            for one, line in zip(axes.flat, np.transpose(values), strict=True):
                one.plot(lean, line, label=f"{group[0].speed:g} m/s", **style)
        for k, group in enumerate(ideal):
            lean, style = np.degrees([one.lean for one in group]), {"color": look.colour(k), "linewidth": LINE}
            for one, line in zip(
                axes.flat, ([np.degrees(x.steer) for x in group], [x.torque for x in group]), strict=False
            ):
                one.plot(lean, line, linestyle="--", label="ideal wheels" if k == len(ideal) - 1 else None, **style)
        for one in axes[1]:
            one.set_xlabel("lean [°]")
        axes[0, 1].legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize=9, labelcolor=look.ink)
        sheet.suptitle(title, fontweight="bold")
    return sheet
