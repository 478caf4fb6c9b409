"""Singular poses, where the rows leave one freedom more than beside them, and poses that are all but singular."""

import numpy as np

from ..equations.at_state import joint_point, load_state
from ..equations.compiled import Compiled
from ..equations.jacobian import BlockRows, displacement_units, scaled_rows
from ..kernels.kinematics import displace
from ..kernels.layout import Data
from ..mechanism.drivers import Driver
from ..mechanism.state import State
from .least_squares import shortest
from .poses.pose_equations import gap_size, newton
from .rank import Analysis

BESIDE = (0.05, -0.05)  # radians or lengths of the model
NEAR = 2e-2  # least singular value over the largest; of the reference mechanisms none is below 0.03
APART = 0.1  # over the next one: those of long chains fall evenly, one that is being lost falls away from the others
MOVES = 0.3  # of the joint that moves most: those that are named
TIMES = 4


def what_is_singular(compiled: Compiled, pose: State) -> str:
    """What is singular, or nearly so, about a pose; "" for a regular one."""
    data = compiled.data()
    load_state(compiled, data, pose)
    found = Analysis(scaled_rows(compiled.model, data))
    return next(iter(singularities(compiled, data, found, rows_beside(compiled, pose, found))), "")


def singularities(compiled: Compiled, data: Data, found: Analysis, beside: list[tuple[int, BlockRows]]) -> list[str]:
    """Sentences on the pose at hand, whose rows are ``found``: which joints move in the freedom that is gained there.

    Beside it the rows are those of `rows_beside`.
    """
    rank, rows = max(beside, key=lambda pair: pair[0], default=(0, None))
    if rank <= found.rank:
        return nearly_singular(compiled, data, found)
    joints = movers(compiled, data, gained(scaled_rows(compiled.model, data), rows, found))
    return [f"singular (rank {found.rank}, {rank} beside it): {joints} can move while the rest stands"]


def rows_beside(compiled: Compiled, pose: State, found: Analysis) -> list[tuple[int, BlockRows]]:
    """(rank, rows) at two poses moved a little along what the rows leave free; none where the rank cannot be higher."""
    model, data = compiled.model, compiled.data()
    if found.rank in (0, found.m, 6 * found.n):
        return []
    y = load_state(compiled, data, pose)
    free = found.free_motion(np.random.default_rng(0))
    columns = displacement_units(model.length, model.body.size)
    free = columns * free / max(np.abs(free).max(), 1e-300)
    beside = []
    for step in BESIDE:
        trial = y.copy()
        data.body["acceleration"][:-1] = (step * free).reshape(-1, 6)
        displace(model, data, trial)
        start = State(pose.t, trial[: 7 * model.body.size], pose.v, pose.z, pose.coordinates)
        moved, residual = newton(compiled, start, [], [], set())
        if gap_size(compiled, residual) <= 1e-9:
            load_state(compiled, data, moved)
            rows = scaled_rows(model, data)
            beside.append((Analysis(rows, 10.0 * found.tolerance).rank, rows))
    return beside


def gained(rows: BlockRows, beside: BlockRows, found: Analysis) -> np.ndarray:
    """(6 n,) a motion that is free here and not beside: what is free at both is taken out of a random one.

    What is free turns a little on the way, so once leaves some of it; each further time takes that to its square.
    """
    x = found.free_motion(np.random.default_rng(0))
    for _ in range(TIMES):
        x = forbidden(beside, x)
        x -= forbidden(rows, x)
    return x


def forbidden(rows: BlockRows, x: np.ndarray) -> np.ndarray:
    """The part of a motion (6 n,) that the rows do not leave free, the shortest y with J y = J x."""
    return shortest(rows, np.ones(rows.body.shape[0]), np.zeros((0, x.size)), np.ones(x.size), rows.times(x))


def nearly_singular(compiled: Compiled, data: Data, found: Analysis) -> list[str]:
    """What to say of a pose where one singular value is about to vanish: which joints could move then."""
    if found.counted.size < 2 or found.smallest >= NEAR or found.least >= APART * found.counted[-2]:
        return []
    joints = movers(compiled, data, found.least_motion())
    return [
        f"nearly singular: {joints} can all but move while the rest stands; rates and reactions grow up to "
        f"{1.0 / found.smallest:.0f} times (least singular value {found.smallest:.1e} of the largest)"
    ]


def movers(compiled: Compiled, data: Data, motion: np.ndarray) -> str:
    """Names of the joints that move most in a motion."""
    moving = joint_motion(compiled, data, motion)
    names = [f"'{name}'" for name, size in moving.items() if size >= MOVES * max(moving.values())] or ["the bodies"]
    return f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else names[0]


def joint_motion(compiled: Compiled, data: Data, motion: np.ndarray) -> dict[str, float]:
    """Name of each joint and how far its bodies part at its point, radians or lengths of the model, in a motion.

    ``motion`` (6 n,) in lengths of the model and radians.
    """
    system, length, n = compiled.system, compiled.model.length, len(compiled.system.bodies)
    v = np.concatenate([motion.reshape(n, 6), np.zeros((1, 6))])  # the ground last
    r, found = data.body["r"], {}
    for joint in system.joints:
        if isinstance(joint, Driver) or len(joint.bodies()) != 2:
            continue
        a, b = (compiled.body_index[id(body)] for body in (joint.a, joint.b))
        point = joint_point(compiled, data, joint)
        at_a, at_b = (v[i, :3] + np.cross(v[i, 3:], point - r[i]) / length for i in (a, b))
        slip, turn = at_b - at_a, v[b, 3:] - v[a, 3:]
        found[system.name(joint)] = float(np.linalg.norm([slip, turn]))
    return found
