"""From a start to a pose that closes: along the motion, else by Newton's method; what is not unique about it."""

from dataclasses import dataclass

import numpy as np

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
SEEDED_MOVES = 0.05, 0.2, 0.5  # [rad, lengths of the model] to poses nearby


@dataclass(frozen=True)
class Found:
    """A pose, and the way to it."""

    equations: PoseEquations  # at the pose
    start: State  # closed joints, drivers and asked-for values as drawn
    way: Continuation | None = None  # None: it was not far

    @property
    def state(self) -> State:
        """The pose with its hinge coordinates."""
        return self.equations.state()

    @property
    def residual(self) -> np.ndarray:
        """(m,) residual of the rows [m, rad]."""
        return self.equations.row_residual()

    @property
    def gap(self) -> float:
        """The largest of them, in lengths of the model and radians."""
        return gap_size(self.equations.compiled, self.residual)

    @property
    def is_met(self) -> bool:
        """Whether the joints close and the values asked for are met."""
        return self.gap <= CLOSED_GAP_MAX and np.abs(self.equations.misses()).max(initial=0.0) <= ASKED_MISS_MAX


def close_pose(
    compiled: Compiled, start: State, targets: list[tuple[int, float]], goals: list[float], pinned: set[int],
    tolerance: float = CLOSED_GAP_MAX,
) -> Found:  # fmt: skip
    """Return the pose that the motion leads to from the start; what drivers prescribe is moved like what is asked for.

    Where that leads no further, Newton's method from the start, and where that sticks (a stretched chain that must
    buckle), from seeded poses nearby; both count turns along their own steps.
    """
    task = targets, goals, pinned
    equations = PoseEquations(compiled, start, *task)
    if joint_gap(equations) > CLOSED_GAP_MAX:
        start = joints_closed(compiled, start, pinned)
        equations = PoseEquations(compiled, start, *task)
    if np.abs(equations.residual()).max(initial=0.0) <= CORRECTION_MAX:
        equations.close()
        return Found(equations, start)
    way = Continuation(equations, joint_graph(compiled, pinned), tolerance)
    if way.follow():
        return Found(equations, start, way)
    equations = PoseEquations(compiled, start, *task)
    equations.close()
    for size in SEEDED_MOVES:
        if gap_size(compiled, equations.row_residual()) <= tolerance:
            break
        again = PoseEquations(compiled, seeded(compiled, start, pinned, size), *task)
        again.close()
        if gap_size(compiled, again.row_residual()) <= tolerance:
            equations = again
    return Found(equations, start, way)


def joint_gap(equations: PoseEquations) -> float:
    """Return the largest residual of rows that no driver moves, in lengths of the model and radians."""
    undriven = equations.model.row["drive"] < 0
    return gap_size(equations.compiled, equations.row_residual() * undriven)


def joints_closed(compiled: Compiled, start: State, pinned: set[int]) -> State:
    """Return the start with its joints closed, whatever drivers prescribe; as it is where they cannot be."""
    equations = PoseEquations(compiled, start, [], [], pinned, (compiled.model.row["drive"] < 0).astype(float))
    equations.close()
    return equations.state() if joint_gap(equations) <= CLOSED_GAP_MAX else start


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
    notes = []
    if way.gone < 1.0:
        notes.append(
            f"the motion from the start ends after {100.0 * way.gone:.3g} % of the way; the pose was found beside it, "
            "with turns counted along the steps of Newton's method: go in steps with near= to choose the way"
        )
    elif 0 < way.rank < np.count_nonzero(equations.free) and way.rank < way.heading(None).rank:
        notes.append(
            "the start is a singular pose, where motions part, and one of them was followed: start near= a pose beside "
            "it to choose another"
        )
    if way.rank == np.count_nonzero(equations.free):
        return tuple(notes)
    chosen = chosen_coordinates(found)
    for joint, unit, change in chosen:
        if unit == "rad" and abs(change) > np.pi:
            raise AssemblyError(
                f"what is asked for does not say how often '{joint}' turns: {change:.6g} rad if joints move least",
                part="assemble", time=found.start.t,
                advice="ask for its angle or slide too, or for a hinge that turns with it, or pin a body",
            )  # fmt: skip
    if chosen:
        listed = ", ".join(f"'{joint}' by {change:.6g} {unit}" for joint, unit, change in chosen)
        notes.append(f"what is asked for leaves a choice: joints moved as little as they can, {listed}")
    return tuple(notes)


def chosen_coordinates(found: Found) -> list[tuple[str, str, float]]:
    """Return (joint, unit, change) of angles and slides that moved though nothing asked for determines them."""
    equations, compiled = found.equations, found.equations.compiled
    changes = found.state.coordinates - found.way.counted
    moved = np.abs(changes) > MOVED_MIN
    moved[[i for i, _ in equations.targets]] = False
    if not moved.any():
        return []
    moved &= np.abs(equations.rates(free_motion(equations))) > FREE_RATE_MIN
    return [
        (compiled.system.name(joint), "rad" if x.kind == "angle" else "m", float(changes[compiled.coordinate(x)]))
        for joint in compiled.system.joints
        for x in (joint.angle(), joint.slide())
        if x is not None and moved[compiled.coordinate(x)]
    ]


def free_motion(equations: PoseEquations) -> np.ndarray:
    """Return a motion (6 n,) that rows and asked-for values leave free, drawn at random; of order one, or zero."""
    motion = equations.columns * np.random.default_rng(0).normal(size=equations.columns.size)
    return motion - equations.motion(equations.change(motion))
