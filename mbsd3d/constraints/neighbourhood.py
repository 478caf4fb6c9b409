"""Poses beside a given one: what moves away from it, and what closes only at it.

Steps along the motions that the rows leave free are closed by Newton's method. A free motion is infinitesimal if the
joints close at the pose itself; it is finite if they close where the step led; where the rank is higher there, freedoms
are lost on the way.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..equations.at_state import load_state
from ..equations.compiled import Compiled, compile_system
from ..equations.jacobian import BlockRows, displacement_units, scaled_rows
from ..kernels.kinematics import displace
from ..mechanism.drivers import Driver, SpeedDriver
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from .conflicting_drivers import SIGNAL_COMPARISON_TIMES
from .least_squares import shortest
from .poses.pose_equations import displacements, gap_size, newton
from .rank import Analysis

NEIGHBOUR_OFFSETS = (0.05, -0.05)  # [rad, model lengths] of the poses beside; small for a turn, large for rounding

WAY_MIN = 0.3  # [1] of a step: the two branches of a dead centre leave 0.7 of it between them, a structure 1e-6
LOST_SHARE_MIN = 0.02  # [1] of a step that is taken back: the third order of one of 0.05 rad leaves 1e-3
LOST_MIN = 1e-6  # [1] singular value that counts beside: what comes back ends 1e-8 off, steps of 0.05 change 1e-3


class Beside(NamedTuple):
    """Rows at a closed pose beside the given one."""

    found: Analysis
    rows: BlockRows
    pose: State
    motion: np.ndarray  # (6 n,) to it, per unit of the step, in lengths of the model and radians
    way: float  # share of the step that is left after the joints were closed

    @property
    def rank(self) -> int:
        """Return the rank of the rows at this pose."""
        return self.found.rank


class Neighbourhood(NamedTuple):
    """Poses beside a given one, along the motions that its rows leave free."""

    poses: list[Beside]  # two or more that were reached; none where the rank cannot be higher, or nothing moves
    stuck: np.ndarray | None  # (6 n,) free motion after which the joints close at the pose itself: it is infinitesimal

    def general(self, found: Analysis) -> Beside | None:
        """Return the pose of highest rank; None if that is the one at hand, with the rows ``found``."""
        highest = max(self.poses, key=lambda x: x.rank, default=None)
        return highest if highest is not None and highest.rank > found.rank else None


def neighbourhood(compiled: Compiled, pose: State, found: Analysis) -> Neighbourhood:
    """Return poses moved a little along what the rows ``found`` leave free, and a free motion that leads nowhere.

    A motion may stick only because a driver that is about to move holds it: then the poses without it are looked at.
    """
    if found.rank in (0, found.m, 6 * found.n):
        return Neighbourhood([], None)
    data = compiled.data()
    load_state(compiled, data, pose)
    here = look_beside(compiled, compiled, pose, scaled_rows(compiled.model, data), found)
    if here.stuck is None or (alone := without_moving_drivers(compiled, pose.t)) is None:
        return here
    data, bare = alone.data(), State(pose.t, pose.q, pose.v)
    load_state(alone, data, bare)
    rows = scaled_rows(alone.model, data)
    return look_beside(alone, compiled, bare, rows, Analysis(rows, found.tolerance))


def look_beside(
    compiled: Compiled, seen: Compiled, pose: State, rows: BlockRows, found: Analysis
) -> Neighbourhood:  # fmt: skip
    """Return the `neighbourhood` of a pose with these ``rows``; ``seen``: the mechanism whose rows are taken there.

    A random motion is tried first: if it leads on, so do all, for the poses that can be reached have the rank of a
    random one. If a part of it is taken back when the joints close, the two parts are tried each on their own.
    """
    free = unit_motion(found.free_motion(np.random.default_rng(0)))
    first = closed_beside(compiled, seen, pose, found, free)
    if not first:
        return Neighbourhood([], None)
    least = LOST_SHARE_MIN * np.linalg.norm(free)
    back = free - np.mean([x.motion for x in first], axis=0)  # ahead and behind: curved ways leave nothing
    back -= forbidden(rows, back)
    if np.linalg.norm(back) < least:
        return Neighbourhood(first, None)
    stays, went = free - back, closed_beside(compiled, seen, pose, found, unit_motion(back))
    led = closed_beside(compiled, seen, pose, found, unit_motion(stays)) if np.linalg.norm(stays) > least else []
    poses = [x for x in (*led, *went) if x.way > WAY_MIN]
    sticks = bool(went) and all(x.way <= WAY_MIN for x in went)
    return Neighbourhood(poses if poses or sticks else first, back if sticks else None)


def without_moving_drivers(compiled: Compiled, t: float) -> Compiled | None:
    """Return the bodies and joints without the drivers that will move them after the time t; None if none will."""
    joints = [x for x in compiled.system.joints if not (isinstance(x, Driver) and will_move(x, t))]
    if len(joints) == len(compiled.system.joints):
        return None
    return compile_system(Mechanism(bodies=compiled.system.bodies, joints=joints))


def will_move(driver: Driver, t: float) -> bool:
    """Return True for a driver whose position varies after the time t, or whose speed is not zero."""
    signals = [row.signal for row in driver.primitives if row.signal is not None]
    values = [[float(signal(x)) for x in t + SIGNAL_COMPARISON_TIMES if x <= signal.interval[1]] for signal in signals]
    return any(np.any(x) if isinstance(driver, SpeedDriver) else np.ptp(x or [0.0]) > 0.0 for x in values)


def unit_motion(motion: np.ndarray) -> np.ndarray:
    """Return the motion scaled to a largest entry of one."""
    return motion / max(np.abs(motion).max(), 1e-300)


def closed_beside(
    compiled: Compiled, seen: Compiled, pose: State, found: Analysis, free: np.ndarray
) -> list[Beside]:  # fmt: skip
    """Return the poses a step ahead and behind along a unit motion (6 n,) that close, with the rows of ``seen``."""
    model, data, beside = compiled.model, compiled.data(), []
    y, columns = load_state(compiled, data, pose), displacement_units(model.length, found.n)
    tolerance = max(10.0 * found.tolerance, min(LOST_MIN, 0.1 * found.smallest))
    for step in NEIGHBOUR_OFFSETS:
        trial = y.copy()
        data.body["acceleration"][:-1] = (step * columns * free).reshape(-1, 6)
        displace(model, data, trial)
        start = State(pose.t, trial[: 7 * model.body.size], pose.v, pose.z, pose.coordinates)
        moved, residual = newton(compiled, start, [], [], set())
        if gap_size(compiled, residual) <= 1e-9:
            motion = displacements(pose, moved).ravel() / displacement_units(model.length, model.body.size) / step
            there = seen.data()
            load_state(seen, there, moved if seen is compiled else replace(moved, coordinates=None))
            rows = scaled_rows(seen.model, there)
            beside.append(Beside(Analysis(rows, tolerance), rows, moved, motion, float(free @ motion / (free @ free))))
    return beside


def forbidden(rows: BlockRows, x: np.ndarray) -> np.ndarray:
    """Return the part of a motion (6 n,) that the rows do not leave free, the shortest y with J y = J x."""
    return shortest(rows, np.ones(rows.body.shape[0]), np.zeros((0, x.size)), np.ones(x.size), rows.times(x))
