"""From a start to a pose that closes: along the motion, else by Newton's method; what is not unique about it."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...base.concurrency import on_one_thread
from ...base.errors import AssemblyError
from ...equations.at_state import pack
from ...equations.compiled import Compiled
from ...kernels.kinematics import displace
from ...mechanism.state import State
from .continuation import Continuation
from .joint_motion import joint_graph
from .pose_equations import CLOSED_GAP_MAX, CORRECTION_MAX, PoseEquations, gap_size

FREE_RATE_MIN = 1e-4  # [1] of a hinge in a free motion of order one; less is rounding of rows near a singular pose
MOVED_MIN = 1e-6  # [rad, m] of a hinge that nobody asked for, by which it counts as moved
ASKED_MISS_MAX = 1e-8  # [rad, m] of a value asked for that counts as met
RESTART_OFFSETS = 0.05, 0.2, 0.5  # [rad, model lengths] to poses from which Newton's method starts again


@dataclass(frozen=True)
class Found:
    """A pose, and the way to it."""

    equations: PoseEquations  # at the pose
    start: State  # closed joints, drivers and asked-for values as drawn
    way: Continuation | None = None  # None: it was not far

    @property
    def state(self) -> State:
        """Return the pose with its hinge coordinates."""
        return self.equations.state()

    @property
    def gap(self) -> float:
        """Return the largest residual of the rows, in lengths of the model and radians."""
        return gap_size(self.equations.compiled, self.equations.row_residual())

    @property
    def is_met(self) -> bool:
        """Return whether the joints close and the values asked for are met."""
        return self.gap <= CLOSED_GAP_MAX and np.abs(self.equations.misses()).max(initial=0.0) <= ASKED_MISS_MAX


class MovedHinge(NamedTuple):
    """An angle or slide that nobody asked for and that has changed."""

    joint: str
    number: int  # of the hinge coordinate
    unit: str
    change: float


@on_one_thread  # small dense algebra
def close_pose(
    compiled: Compiled, start: State, targets: list[tuple[int, float]], goals: list[float], pinned: set[int],
    tolerance: float = CLOSED_GAP_MAX,
) -> Found:  # fmt: skip
    """Return the pose that the motion leads to from the start; what drivers prescribe is moved like what is asked for.

    Joints that are drawn open are closed first. Where the motion leads no further, the rest is left to `by_newton`.
    """
    task = targets, goals, pinned
    equations = PoseEquations(compiled, start, *task)
    if joint_gap(equations) > CLOSED_GAP_MAX:
        start = by_newton(compiled, start, [], [], pinned, compiled.model.row["drive"] < 0).state()
        equations = PoseEquations(compiled, start, *task)
        if joint_gap(equations) > tolerance:
            return Found(equations, start)
    if np.abs(equations.residual()).max(initial=0.0) <= CORRECTION_MAX:
        equations.close()
        return Found(equations, start)
    way = Continuation(equations, joint_graph(compiled, pinned), tolerance)
    if way.follow():
        return Found(equations, start, way)
    return Found(by_newton(compiled, start, *task, np.ones(compiled.model.row.size)), start, way)


def joint_gap(equations: PoseEquations) -> float:
    """Return the largest residual of rows that no driver moves, in lengths of the model and radians."""
    undriven = equations.model.row["drive"] < 0
    return gap_size(equations.compiled, equations.row_residual() * undriven)


def by_newton(
    compiled: Compiled, start: State, targets: list[tuple[int, float]], goals: list[float], pinned: set[int],
    used: np.ndarray,
) -> PoseEquations:  # fmt: skip
    """Return the pose that closes the rows ``used`` by Newton's method, which counts turns along its own steps.

    Where it sticks (a stretched chain that must buckle), it starts from seeded poses nearby.
    """
    tried: list[PoseEquations] = []
    for size in (0.0, *RESTART_OFFSETS):
        nearby = seeded(compiled, start, pinned, size) if size else start
        equations = PoseEquations(compiled, nearby, targets, goals, pinned, used.astype(float))
        equations.close()
        if gap_size(compiled, equations.row_residual() * used) <= CLOSED_GAP_MAX:
            return equations
        tried.append(equations)
    return tried[0]


def seeded(compiled: Compiled, start: State, pinned: set[int], size: float) -> State:
    """Return a pose near the start; how a body moves depends on its name, not on its place in the list."""
    names = [compiled.system.name(body) for body in compiled.system.bodies]
    moves = size * np.array([np.random.default_rng(list(name.encode())).normal(size=6) for name in names])
    moves[:, :3] *= compiled.model.length
    moves[sorted(pinned)] = 0.0
    y, data = pack(compiled, start), compiled.data()
    data.body["acceleration"][:-1] = moves
    displace(compiled.model, data, y)
    return State(start.t, y[: start.q.size], start.v, start.z, start.coordinates)


def ambiguities(found: Found) -> tuple[str, ...]:
    """Return sentences on what was chosen on the way to a pose; AssemblyError where the choice decides on a turn."""
    equations, way = found.equations, found.way
    if way is None:
        return ()
    if way.gone < 1.0:
        where = f"the motion from the start ends after {100.0 * way.gone:.3g} % of the way"
        check_turns(found, moved_hinges(found, way), f"{where}, which", "go there in steps with near=")
        return (f"{where}; the pose was found beside it: go there in steps with near= to choose the way",)
    notes: list[str] = []
    if 0 < way.rank < np.count_nonzero(equations.free) and way.rank < way.heading(None).rank:
        notes.append(
            "the start is a singular pose, where motions part, and one of them was followed: start near= a pose beside "
            "it to choose another"
        )
    chosen = chosen_hinges(found, way)
    remedy = "ask for its angle or slide too, or for a hinge that turns with it, or pin a body"
    check_turns(found, chosen, "what is asked for", remedy)
    if chosen:
        listed = ", ".join(f"'{hinge.joint}' by {hinge.change:.6g} {hinge.unit}" for hinge in chosen)
        notes.append(f"what is asked for leaves a choice: joints moved as little as they can, {listed}")
    return tuple(notes)


def check_turns(found: Found, hinges: list[MovedHinge], why: str, remedy: str) -> None:
    """Raise an AssemblyError if one of the hinges has turned by more than half a turn."""
    for hinge in hinges:
        if hinge.unit == "rad" and abs(hinge.change) > np.pi:
            raise AssemblyError(
                f"{why} leaves open how often '{hinge.joint}' turns: here {hinge.change:.6g} rad",
                part="assemble", time=found.start.t, advice=remedy,
            )  # fmt: skip


def moved_hinges(found: Found, way: Continuation) -> list[MovedHinge]:
    """Return the angles and slides of joints that have changed though nobody asked for them, and no driver."""
    compiled, changes, moved = found.equations.compiled, found.equations.values() - way.counted, []
    driven = [x for driver, _ in compiled.drives for row in driver.primitives for x in row.coordinates]
    asked = {i for i, _ in found.equations.targets} | {compiled.coordinate(x) for x in driven}
    for joint in compiled.system.joints:
        for x in filter(None, (joint.angle(), joint.slide())):
            i = compiled.coordinate(x)
            if i not in asked and abs(changes[i]) > MOVED_MIN:
                unit = "rad" if x.kind == "angle" else "m"
                moved.append(MovedHinge(compiled.system.name(joint), i, unit, float(changes[i])))
    return moved


def chosen_hinges(found: Found, way: Continuation) -> list[MovedHinge]:
    """Return those of `moved_hinges` that rows and asked-for values leave free."""
    equations = found.equations
    if way.rank == np.count_nonzero(equations.free):
        return []
    moved = moved_hinges(found, way)
    rates = equations.rates(free_motion(equations)) if moved else np.zeros(0)
    return [hinge for hinge in moved if abs(rates[hinge.number]) > FREE_RATE_MIN]


def free_motion(equations: PoseEquations) -> np.ndarray:
    """Return a motion (6 n,) that rows and asked-for values leave free, drawn at random; of order one, or zero."""
    motion = equations.columns * np.random.default_rng(0).normal(size=equations.columns.size)
    return motion - equations.motion(equations.change(motion))
