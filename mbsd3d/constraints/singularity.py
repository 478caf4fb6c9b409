"""Singular poses, where the rows leave one degree of freedom more than beside them, and poses near to them."""

from collections.abc import Collection

import numpy as np

from ..equations.at_state import joint_point, load_state
from ..equations.compiled import Compiled
from ..equations.jacobian import BlockRows, scaled_rows
from ..kernels.layout import Data
from ..mechanism.contacts import KnifeEdge, RollingContact
from ..mechanism.drivers import Driver
from ..mechanism.state import State
from .neighbourhood import (
    Beside,
    Neighbourhood,
    closed_beside,
    forbidden,
    neighbourhood,
    unit_motion,
    without_moving_drivers,
)
from .rank import Analysis, orthonormal

NEAR_SINGULAR_RATIO = 2e-2  # [1] least over largest singular value; no reference mechanism is below 0.03
# [1] of a singular value over the next one: values of long chains fall evenly, one that vanishes falls away from them
SINGULAR_VALUE_GAP = 0.1
JOINT_PARTICIPATION_MIN = 0.3  # [1] of the joint that moves most: least motion of a joint that a message names
MOVE_TIMES_COUNT = 4  # [times] at which the motion beside a pose is looked at
INFINITESIMAL = "infinitesimal"  # first word of the message on a pose that loses its mobility beside it

SHARE_MIN = 1e-2  # [1] of the largest entry of a redundant combination: rows that take part; steps turn it by less


def describe_singularity(compiled: Compiled, pose: State) -> str:
    """Return what is singular, or nearly so, about a pose; "" for a regular one."""
    data = compiled.data()
    load_state(compiled, data, pose)
    found = Analysis(scaled_rows(compiled.model, data))
    return next(iter(singularities(compiled, data, pose, found, neighbourhood(compiled, pose, found))), "")


def singularities(
    compiled: Compiled, data: Data, pose: State, found: Analysis, beside: Neighbourhood
) -> list[str]:  # fmt: skip
    """Return sentences on the pose in ``data`` with the rows ``found``: what can move there and not beside it.

    ``beside``: its `neighbourhood`.
    """
    general = beside.general(found)
    if general is None:
        if beside.stuck is not None:
            return [what_sticks(compiled, data, found, beside.poses, beside.stuck)]
        return steered_rolling(compiled, pose) or nearly_singular(compiled, data, found)
    if text := lost_rolling(compiled, data, pose, found, general):
        return [text]
    joints = movers(compiled, data, gained(scaled_rows(compiled.model, data), general.rows, found))
    return [f"singular (rank {found.rank}, {general.rank} beside it): {joints} can move while the rest stands"]


def what_sticks(compiled: Compiled, data: Data, found: Analysis, poses: list[Beside], stuck: np.ndarray) -> str:
    """Return what to say of a free motion ``stuck`` along which the joints close at none but the ``poses`` beside."""
    less = "is more than can move" if poses else "in this pose alone, and nothing can move"
    what = f"{INFINITESIMAL}: mobility {6 * found.n - found.rank} {less}"
    joints = movers(compiled, data, stuck)
    return (
        f"{what}: {joints} give way to any load, but the joints close nowhere beside this pose; change a length, or "
        "take out a joint"
    )


def lost_rolling(compiled: Compiled, data: Data, pose: State, found: Analysis, general: Beside) -> str:
    """Return what to say of wheels that roll together in this pose alone; "" where holonomic rows are lost."""
    system, row = compiled.system, compiled.model.row
    lost = independent_beside(found, general.found)
    rolling = lost[~row["holonomic"][lost].astype(bool)]
    wheels = list(dict.fromkeys(system.joints[compiled.row_joint[k]] for k in rolling))
    wheels = [wheel for wheel in wheels if not isinstance(wheel, Driver)]
    if not wheels:
        return ""
    here, there = (6 * x.n - x.rank for x in (found, general.found))
    names = listed([f"'{system.name(wheel)}'" for wheel in wheels])
    remedy = "use Tyre, which slips" if all(isinstance(x, RollingContact) for x in wheels) else "take one of them out"
    less = f"mobility {here} in this pose alone, {there} beside it"
    when = steered_by(compiled, data, pose, found, general)
    return f"{INFINITESIMAL}: {less}: {names} have no common turning centre {when}; {remedy}"


def steered_by(compiled: Compiled, data: Data, pose: State, found: Analysis, general: Beside) -> str:
    """Find the hinges and slides that turn wheels away from a common centre, in the motion that is lost or stays.

    The wheels' own axles turn in both.
    """
    system, rows = compiled.system, scaled_rows(compiled.model, data)
    wheels = {id(joint.b) for joint in system.joints if isinstance(joint, RollingContact)}
    axles = [joint for joint in system.joints if any(id(body) in wheels for body in joint.bodies())]
    others = [joint for joint in system.joints if joint.angle() is None and joint.slide() is None]
    but = {system.name(joint) for joint in (*axles, *others)}
    for motion in (gained(rows, general.rows, found), kept(rows, general.rows, found)):
        beside = closed_beside(compiled, compiled, pose, found, unit_motion(motion))
        if any(x.rank > found.rank for x in beside):
            return f"as soon as {movers(compiled, data, motion, but)} move"
    return "beside it"


def steered_rolling(compiled: Compiled, pose: State) -> list[str]:
    """Describe `lost_rolling` of a mechanism without the drivers that will move it: they lead it where it is lost."""
    if not any(isinstance(x, RollingContact | KnifeEdge) for x in compiled.system.joints):
        return []
    alone = without_moving_drivers(compiled, pose.t)
    text = describe_singularity(alone, State(pose.t, pose.q, pose.v)) if alone else ""
    return [text] if text.startswith(INFINITESIMAL) else []


def independent_beside(found: Analysis, there: Analysis) -> np.ndarray:
    """Return the redundant rows that are independent at a pose beside.

    Those that stay turn by the size of the step; the others leave the space of those found there.
    """
    N, stays = orthonormal(found.redundant()), orthonormal(there.redundant())
    U, s, _ = np.linalg.svd(N - stays @ (stays.T @ N), full_matrices=False)
    size = np.linalg.norm(U[:, s > 0.5], axis=1)
    return np.flatnonzero(size > SHARE_MIN * size.max(initial=0.0))


def gained(rows: BlockRows, beside: BlockRows, found: Analysis) -> np.ndarray:
    """Return a motion (6 n,) that is free here and not beside: what is free at both is taken out of a random one.

    What is free turns a little on the way, so once leaves some of it; each further time takes that to its square.
    """
    x = found.free_motion(np.random.default_rng(0))
    for _ in range(MOVE_TIMES_COUNT):
        x = forbidden(beside, x)
        x -= forbidden(rows, x)
    return x


def kept(rows: BlockRows, beside: BlockRows, found: Analysis) -> np.ndarray:
    """Return a motion (6 n,) that is free here and beside."""
    x = found.free_motion(np.random.default_rng(0))
    for _ in range(MOVE_TIMES_COUNT):
        x -= forbidden(beside, x)
        x -= forbidden(rows, x)
    return x


def nearly_singular(compiled: Compiled, data: Data, found: Analysis) -> list[str]:
    """Return what to say of a pose where one singular value is about to vanish: which joints could move then."""
    if (
        found.counted.size < 2
        or found.smallest >= NEAR_SINGULAR_RATIO
        or found.least >= SINGULAR_VALUE_GAP * found.counted[-2]
    ):
        return []
    joints = movers(compiled, data, found.least_motion())
    return [
        f"nearly singular: {joints} can all but move while the rest stands; rates and reactions grow up to "
        f"{1.0 / found.smallest:.0f} times (least singular value {found.smallest:.1e} of the largest)"
    ]


def movers(compiled: Compiled, data: Data, motion: np.ndarray, but: Collection[str] = ()) -> str:
    """Return the names of the joints that move most in a motion; ``but``: not these, if there are others."""
    moving = joint_motion(compiled, data, motion)
    moving = {name: size for name, size in moving.items() if name not in but} or moving
    return listed(
        [f"'{name}'" for name, size in moving.items() if size >= JOINT_PARTICIPATION_MIN * max(moving.values())]
        or ["bodies"]
    )


def listed(names: list[str]) -> str:
    """Return names joined as in a sentence."""
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
