"""Singular poses, where the rows leave one freedom more than beside them, and poses that are all but singular."""

from typing import NamedTuple

import numpy as np

from ..base.quaternions import conjugate, logarithm, multiply
from ..equations.at_state import joint_point, load_state
from ..equations.compiled import Compiled, compile_system
from ..equations.jacobian import BlockRows, displacement_units, scaled_rows
from ..kernels.kinematics import displace
from ..kernels.layout import Data
from ..mechanism.contacts import KnifeEdge, RollingContact
from ..mechanism.drivers import Driver, SpeedDriver
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from .assembly import gap_size, newton
from .contradictions import LATER
from .least_squares import shortest
from .rank import Analysis, orthonormal

BESIDE = (0.05, -0.05)  # radians or lengths of the model
NEAR = 2e-2  # least singular value over the largest; of the reference mechanisms none is below 0.03
APART = 0.1  # over the next one: those of long chains fall evenly, one that is being lost falls away from the others
MOVES = 0.3  # of the joint that moves most: those that are named
TIMES = 4
INFINITESIMAL = "infinitesimal"  # the first word on a pose whose mobility is lost beside it
WAY_MIN = 0.3  # [1] of a step: the two branches of a dead centre leave 0.7 of it between them, a structure 1e-6
LOST_SHARE_MIN = 0.02  # [1] of a step that is taken back: the third order of one of 0.05 rad leaves 1e-3
LOST_MIN = 1e-6  # [1] singular value that counts beside: what comes back ends 1e-8 off, steps of 0.05 change 1e-3
SHARE_MIN = 1e-2  # [1] of the largest entry of a redundant combination: rows that take part; steps turn it by less


class Beside(NamedTuple):
    """The rows at a closed pose beside the one looked at."""

    found: Analysis
    rows: BlockRows
    pose: State
    motion: np.ndarray  # (6 n,) to it, per unit of the step, in lengths of the model and radians
    way: float  # share of the step that is left after the joints were closed

    @property
    def rank(self) -> int:
        """Rank of the rows there."""
        return self.found.rank


class Neighbourhood(NamedTuple):
    """What lies beside a pose along the motions that its rows leave free."""

    poses: list[Beside]  # two or more that were reached; none where the rank cannot be higher, or nothing moves
    stuck: np.ndarray | None  # (6 n,) free motion after which the joints close at the pose itself: it is infinitesimal

    def general(self, found: Analysis) -> Beside | None:
        """The pose of highest rank; None if that is the one at hand, with the rows ``found``."""
        highest = max(self.poses, key=lambda x: x.rank, default=None)
        return highest if highest is not None and highest.rank > found.rank else None


def what_is_singular(compiled: Compiled, pose: State) -> str:
    """What is singular, or nearly so, about a pose; "" for a regular one."""
    data = compiled.data()
    load_state(compiled, data, pose)
    found = Analysis(scaled_rows(compiled.model, data))
    return next(iter(singularities(compiled, data, pose, found, neighbourhood(compiled, pose, found))), "")


def singularities(
    compiled: Compiled, data: Data, pose: State, found: Analysis, beside: Neighbourhood
) -> list[str]:  # fmt: skip
    """Sentences on the pose in ``data``, with the rows ``found``: what can move there and not beside it.

    ``beside``: its `neighbourhood`.
    """
    general = beside.general(found)
    if general is None:
        if beside.stuck is not None:
            return [what_sticks(compiled, data, found, beside)]
        return steered_rolling(compiled, pose) or nearly_singular(compiled, data, found)
    if text := lost_rolling(compiled, data, pose, found, general):
        return [text]
    joints = movers(compiled, data, gained(scaled_rows(compiled.model, data), general.rows, found))
    return [f"singular (rank {found.rank}, {general.rank} beside it): {joints} can move while the rest stands"]


def what_sticks(compiled: Compiled, data: Data, found: Analysis, beside: Neighbourhood) -> str:
    """What to say of a free motion that is none."""
    mobility = 6 * found.n - found.rank
    less = (
        f"mobility {mobility} is more than can move" if beside.poses else f"mobility {mobility}, and nothing can move"
    )
    return (
        f"{INFINITESIMAL}: {less}: {movers(compiled, data, beside.stuck)} give way to any load, but the joints close "
        "nowhere beside this pose; change a length, or take out a joint"
    )


def lost_rolling(compiled: Compiled, data: Data, pose: State, found: Analysis, general: Beside) -> str:
    """What to say of wheels that roll together in this pose alone; "" where holonomic rows become independent."""
    system, row = compiled.system, compiled.model.row
    lost = independent_beside(found, general.found)
    rolling = lost[~row["holonomic"][lost].astype(bool)]
    wheels = list(dict.fromkeys(system.joints[compiled.row_joint[k]] for k in rolling))
    wheels = [wheel for wheel in wheels if not isinstance(wheel, Driver)]
    if not wheels:
        return ""
    turn, when = kept(scaled_rows(compiled.model, data), general.rows, found), "beside it"
    if any(x.rank > found.rank for x in closed_beside(compiled, pose, found, unit_motion(turn))):
        when = f"as soon as {movers(compiled, data, turn, turning=True)} move"
    here, there = (6 * x.n - x.rank for x in (found, general.found))
    names = listed([f"'{system.name(wheel)}'" for wheel in wheels])
    remedy = "use Tyre, which slips" if all(isinstance(x, RollingContact) for x in wheels) else "take one of them out"
    less = f"mobility {here} in this pose alone, {there} beside it"
    return f"{INFINITESIMAL}: {less}: {names} have no common turning centre {when}; {remedy}"


def steered_rolling(compiled: Compiled, pose: State) -> list[str]:
    """What `lost_rolling` says of a mechanism without the drivers that will move it: they lead it where it is lost."""
    system = compiled.system
    moving = [x for x in system.joints if isinstance(x, Driver) and will_move(x, pose.t)]
    if not moving or not any(isinstance(x, RollingContact | KnifeEdge) for x in system.joints):
        return []
    alone = compile_system(Mechanism(bodies=system.bodies, joints=[x for x in system.joints if x not in moving]))
    text = what_is_singular(alone, State(pose.t, pose.q, pose.v))
    return [text] if text.startswith(INFINITESIMAL) else []


def will_move(driver: Driver, t: float) -> bool:
    """True for a driver whose position varies after the time t, or whose speed is not zero."""
    signals = [row.signal for row in driver.primitives if row.signal is not None]
    values = [[float(signal(x)) for x in t + LATER if x <= signal.interval[1]] for signal in signals]
    return any(np.any(x) if isinstance(driver, SpeedDriver) else np.ptp(x or [0.0]) > 0.0 for x in values)


def independent_beside(found: Analysis, there: Analysis) -> np.ndarray:
    """Rows of the redundant combinations that are none any more at a pose beside.

    Those that stay turn by the size of the step; the others leave the space of those found there.
    """
    N, stays = orthonormal(found.redundant()), orthonormal(there.redundant())
    U, s, _ = np.linalg.svd(N - stays @ (stays.T @ N), full_matrices=False)
    size = np.linalg.norm(U[:, s > 0.5], axis=1)
    return np.flatnonzero(size > SHARE_MIN * size.max(initial=0.0))


def neighbourhood(compiled: Compiled, pose: State, found: Analysis) -> Neighbourhood:
    """Poses moved a little along what the rows leave free, and a free motion that leads nowhere, if there is one.

    Along a random motion first: if it leads on, so do all, for the poses that can be reached have the rank of a random
    one. If a part of it is taken back when the joints close, the two parts each on their own.
    """
    if found.rank in (0, found.m, 6 * found.n):
        return Neighbourhood([], None)
    free = unit_motion(found.free_motion(np.random.default_rng(0)))
    first = closed_beside(compiled, pose, found, free)
    if not first:
        return Neighbourhood([], None)
    X, size = found.free_motions(), np.linalg.norm(free)
    stays = X @ (X.T @ np.mean([x.motion for x in first], axis=0))  # ahead and behind: curved ways leave nothing
    back = free - stays
    if np.linalg.norm(back) < LOST_SHARE_MIN * size:
        return Neighbourhood(first, None)
    some = [x for x in (stays, back) if np.linalg.norm(x) > LOST_SHARE_MIN * size]
    tried = [closed_beside(compiled, pose, found, unit_motion(x)) for x in some]
    poses = [x for group in tried for x in group if x.way > WAY_MIN]
    sticks = bool(some) and some[-1] is back and bool(tried[-1]) and all(x.way <= WAY_MIN for x in tried[-1])
    return Neighbourhood(poses if poses or sticks else first, back if sticks else None)


def unit_motion(motion: np.ndarray) -> np.ndarray:
    """The motion with a largest entry of one."""
    return motion / max(np.abs(motion).max(), 1e-300)


def closed_beside(compiled: Compiled, pose: State, found: Analysis, free: np.ndarray) -> list[Beside]:
    """The poses a step ahead and behind along a unit motion (6 n,) at which the joints close."""
    model, data, beside = compiled.model, compiled.data(), []
    y, columns = load_state(compiled, data, pose), displacement_units(model.length, found.n)
    tolerance = max(10.0 * found.tolerance, min(LOST_MIN, 0.1 * found.smallest))
    for step in BESIDE:
        trial = y.copy()
        data.body["acceleration"][:-1] = (step * columns * free).reshape(-1, 6)
        displace(model, data, trial)
        start = State(pose.t, trial[: 7 * model.body.size], pose.v, pose.z, pose.coordinates)
        moved, residual = newton(compiled, start, [], [], set())
        if gap_size(compiled, residual) <= 1e-9:
            motion = moved_by(pose, moved, model.length) / step
            load_state(compiled, data, moved)
            rows = scaled_rows(model, data)
            beside.append(Beside(Analysis(rows, tolerance), rows, moved, motion, float(free @ motion / (free @ free))))
    return beside


def moved_by(before: State, after: State, length: float) -> np.ndarray:
    """(6 n,) displacement of all bodies between two poses, in lengths of the model and radians."""
    one, two = (state.q.reshape(-1, 7) for state in (before, after))
    turn = logarithm(multiply(two[:, 3:], conjugate(one[:, 3:])))
    return np.hstack([(two[:, :3] - one[:, :3]) / length, turn]).ravel()


def gained(rows: BlockRows, beside: BlockRows, found: Analysis) -> np.ndarray:
    """(6 n,) a motion that is free here and not beside: what is free at both is taken out of a random one.

    What is free turns a little on the way, so once leaves some of it; each further time takes that to its square.
    """
    x = found.free_motion(np.random.default_rng(0))
    for _ in range(TIMES):
        x = forbidden(beside, x)
        x -= forbidden(rows, x)
    return x


def kept(rows: BlockRows, beside: BlockRows, found: Analysis) -> np.ndarray:
    """(6 n,) a motion that is free here and beside."""
    x = found.free_motion(np.random.default_rng(0))
    for _ in range(TIMES):
        x -= forbidden(beside, x)
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


def movers(compiled: Compiled, data: Data, motion: np.ndarray, turning: bool = False) -> str:
    """Names of the joints that move most in a motion; ``turning``: of those with an angle or a slide, if there are."""
    moving = joint_motion(compiled, data, motion)
    system = compiled.system
    own = {system.name(x) for x in system.joints if turning and (x.angle() is not None or x.slide() is not None)}
    moving = {name: size for name, size in moving.items() if name in own} or moving
    return listed([f"'{name}'" for name, size in moving.items() if size >= MOVES * max(moving.values())] or ["bodies"])


def listed(names: list[str]) -> str:
    """Names in a sentence."""
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
