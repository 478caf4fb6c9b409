"""What the constraints do: rank, freedoms, which joints are redundant, what that means, and how to cure it."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.linalg
from threadpoolctl import threadpool_limits

from .assembly import close_pose, gap_size, newton, reference_pose
from .cures import Cure, find_cures
from .drivers import Driver
from .evaluation import driven_coordinates, load_state, worst_joint
from .kernels.kinematics import displace
from .model import Compiled, compile_system
from .reactions import left_null_space
from .selection import RANK_TOLERANCE, dense_jacobian, scaled_jacobian
from .state import State
from .tree import loop_weights


@dataclass(frozen=True)
class Share:
    """Redundancy of one joint: its rows, how many of them take part, and which reactions are determined."""

    joint: str
    rows: int
    involved: int
    force_unique: bool
    moment_unique: bool


@dataclass(frozen=True)
class Diagnosis:
    """Coordinates, rows and freedoms of a mechanism, and a verdict.

    ``mobility`` counts the velocities left free by all rows, ``configuration_freedom`` those left by the holonomic rows
    alone (both at the reference pose); ``gruebler`` is velocities - rows, what counting without geometry says.
    ``misfit`` [m] is by how much the parts as built miss their joints.
    """

    coordinates: int
    velocities: int
    rows: int
    rank: int
    gruebler: int
    mobility: int
    configuration_freedom: int
    redundant: int
    shares: tuple[Share, ...]
    verdict: str
    misfit: float
    cures: tuple[Cure, ...]
    neighbour_ranks: tuple[int, ...]
    length: float
    notes: tuple[str, ...] = field(default=())

    @property
    def velocity_freedom(self) -> int:
        """Independent velocities: 6 per body minus the rank of all rows."""
        return self.mobility

    def __str__(self) -> str:
        lines = [
            self.verdict,
            f"  {self.coordinates} coordinates, {self.velocities} velocities, {self.rows} rows of rank {self.rank}",
            f"  mobility {self.mobility} (configuration freedoms {self.configuration_freedom}), "
            f"Gruebler count {self.gruebler}",
        ]
        for share in self.shares:
            what = [] if share.force_unique else ["forces"]
            what += [] if share.moment_unique else ["moments"]
            text = f"indeterminate {' and '.join(what)}" if what else "reactions unique"
            lines.append(f"  {share.joint}: {share.involved} of {share.rows} rows in redundant sets, {text}")
        lines += [f"  cure: {cure.text}" for cure in self.cures]
        lines += [f"  {text}" for text in self.notes]
        return "\n".join(lines)


def diagnose(system: Any, as_built: float) -> Diagnosis:
    """See `System.check`."""
    compiled = compile_system(system)
    pose, misfit, stuck = closed_pose(compiled, as_built)
    data = compiled.data()
    load_state(compiled, data, pose)
    A = scaled_jacobian(compiled.model, dense_jacobian(compiled.model, data))
    s = singular_values(A)
    exact = int((s > RANK_TOLERANCE * s[0]).sum()) if s.size and s[0] > 0 else 0
    loose, slip = rank_as_built(A, compiled.model.length, as_built)
    misaligned = slip > 0.0 and loose < exact
    rank = loose if misaligned else exact
    misfit = max(misfit, slip if misaligned else 0.0)
    holonomic = compiled.model.row["holonomic"].astype(bool)
    N = left_null_space(A, as_built_cut(A, compiled.model.length, as_built) if misaligned else RANK_TOLERANCE)
    neighbours = tuple(neighbour_ranks(compiled, pose))
    shares = tuple(joint_shares(compiled, A, N))
    n = 6 * len(system.bodies)
    cures = tuple(find_cures(compiled, A, N, n - rank)) if N.shape[1] and not stuck else ()
    offset = misfit_of_lock(A, exact, compiled.model.length) if not misaligned else 0.0
    verdict = stuck or verdict_text(compiled, A.shape[0], rank, n, misfit, as_built, offset)
    notes = (
        [f"a position away from here the rank is {max(neighbours)}: this pose is singular"]
        if neighbours and (max(neighbours) > exact)
        else []
    )
    return Diagnosis(
        coordinates=7 * len(system.bodies),
        velocities=n,
        rows=A.shape[0],
        rank=rank,
        gruebler=n - A.shape[0],
        mobility=n - rank,
        configuration_freedom=n - rank_of(A[holonomic]),
        redundant=A.shape[0] - rank,
        shares=shares,
        verdict=verdict,
        misfit=misfit or offset,
        cures=cures,
        neighbour_ranks=neighbours,
        length=compiled.model.length,
        notes=tuple(notes),
    )


def singular_values(A: np.ndarray) -> np.ndarray:
    """Singular values, largest first."""
    if not A.size:
        return np.zeros(0)
    with threadpool_limits(1):
        return scipy.linalg.svdvals(A)


def rank_of(A: np.ndarray) -> int:
    """Rank at the tolerance of the solver."""
    s = singular_values(A)
    return int((s > RANK_TOLERANCE * s[0]).sum()) if s.size and s[0] > 0.0 else 0


def as_built_cut(A: np.ndarray, length: float, as_built: float) -> float:
    """Relative cut-off of singular values that stand for misfits below ``as_built`` metres."""
    s = singular_values(A)
    return max(RANK_TOLERANCE, as_built / length / s[0]) if s.size and s[0] > 0.0 else RANK_TOLERANCE


def rank_as_built(A: np.ndarray, length: float, as_built: float) -> tuple[int, float]:
    """(rank when misfits below ``as_built`` are taken up by play, the largest misfit [m] that is).

    A unit motion (one radian, one model length) along a right singular vector violates the rows by its singular value.
    """
    s = singular_values(A)
    if not s.size or s[0] == 0.0:
        return 0, 0.0
    small = (s > RANK_TOLERANCE * s[0]) & (s * length <= as_built)
    if not small.any():
        return int((s > RANK_TOLERANCE * s[0]).sum()), 0.0
    return int((s * length > as_built).sum()), violation(A, 10.0 * s[small].max()) * length


def violation(A: np.ndarray, tolerance: float) -> float:
    """Violation of the spared rows (scaled, norm), per radian or model length of a motion the kept rows leave free.

    Rows are kept in the order of the joints, so the misfit stands at the joints that came last.
    """
    kept, basis = [], np.zeros((0, A.shape[1]))
    for k, row in enumerate(A):
        rest = row - basis.T @ (basis @ row)
        rest -= basis.T @ (basis @ rest)
        if np.linalg.norm(rest) > tolerance:
            kept.append(k)
            basis = np.vstack([basis, rest / np.linalg.norm(rest)])
    spared = np.setdiff1d(np.arange(A.shape[0]), kept)
    Z = left_null_space(basis.T, 1e-6)
    if not spared.size or not Z.shape[1]:
        return 0.0
    _, _, Vt = scipy.linalg.svd(A[spared] @ Z)
    motion = (Z @ Vt[0]).reshape(-1, 6)
    turn, shift = np.linalg.norm(motion[:, 3:], axis=1).max(), np.linalg.norm(motion[:, :3], axis=1).max()
    size = turn if turn > 1e-6 * shift else shift
    return float(np.linalg.norm(A[spared] @ motion.ravel()) / size)


def misfit_of_lock(A: np.ndarray, rank: int, length: float) -> float:
    """Misfit [m] that takes the last freedom of a mechanism without mobility, 0 if it is a plain structure."""
    if not A.size or rank < A.shape[1]:
        return 0.0
    s = singular_values(A)
    return violation(A, 10.0 * s[rank - 1]) * length if s[rank - 1] < 1e-2 * s[0] else 0.0


def closed_pose(compiled: Compiled, as_built: float) -> tuple[State, float, str | None]:
    """(pose, misfit [m] left in rows that could be spared, verdict if the mechanism does not close)."""
    start = reference_pose(compiled.system)
    start = State(start.t, start.q, start.v, start.z, driven_coordinates(compiled, start.t))
    data = compiled.data()
    load_state(compiled, data, start)
    if gap_size(compiled, data.row["c"]) <= 1e-9:
        return start, 0.0, None
    pose, residual = close_pose(compiled, start, [], [], set())
    if gap_size(compiled, residual) <= 1e-9:
        return pose, 0.0, None
    # joints that close loops get little weight, so that the gap stands there and not in every joint
    pose, residual = newton(compiled, start, [], [], set(), loop_weights(compiled))
    part, gap = worst_joint(compiled, residual)
    if gap <= as_built:
        return pose, gap, None
    if gap <= 1e-2 * compiled.model.length:
        text = f"locked: redundant joints miss each other by {gap:.6g} m at {part}, more than {as_built:g} m as built"
        return pose, gap, f"{text}; align them or replace one (see cures)"
    return pose, gap, f"cannot close: a gap of {gap:.6g} m remains at {part}; correct its position or a length"


def neighbour_ranks(compiled: Compiled, pose: State) -> list[int]:
    """Rank at two poses moved a little along the motions the rows leave free."""
    model, data = compiled.model, compiled.data()
    y = load_state(compiled, data, pose)
    A = scaled_jacobian(model, dense_jacobian(model, data))
    if not A.size:
        return []
    with threadpool_limits(1):
        _, s, Vt = scipy.linalg.svd(A)
    rank = int((s > RANK_TOLERANCE * s[0]).sum()) if s.size and s[0] > 0.0 else 0
    if rank == A.shape[1]:
        return []
    free = Vt[rank:].T @ np.random.default_rng(0).normal(size=A.shape[1] - rank)
    columns = np.tile(np.repeat([model.length, 1.0], 3), model.body.size)
    free = columns * free / max(np.abs(free).max(), 1e-300)
    ranks = []
    for step in (0.05, -0.05):
        trial = y.copy()
        data.body["acceleration"][:-1] = (step * free).reshape(-1, 6)
        displace(model, data, trial)
        start = State(pose.t, trial[: 7 * model.body.size], pose.v, pose.z, pose.coordinates)
        moved, residual = newton(compiled, start, [], [], set())
        if gap_size(compiled, residual) <= 1e-9:
            load_state(compiled, data, moved)
            ranks.append(rank_of(scaled_jacobian(model, dense_jacobian(model, data))))
    return ranks


def joint_shares(compiled: Compiled, A: np.ndarray, N: np.ndarray) -> list[Share]:
    """Joints with rows in redundant sets (where the projector N N' is not zero), unique reactions told apart."""
    system, shares = compiled.system, []
    if not N.shape[1]:
        return shares
    for joint in system.joints:
        rows = compiled.rows[id(joint)]
        involved = int((np.linalg.norm(N[rows], axis=1) > 1e-8).sum())
        if not involved:
            continue
        moving = [body for body in (joint.b, joint.a) if id(body) in {id(b) for b in system.bodies}]
        i = 6 * compiled.body_index[id(moving[0])]
        G = A[rows, i : i + 6].T @ N[rows]
        arm = moment_arm(compiled, joint, moving[0])
        moment = G[3:] - np.cross(arm, G[:3], axis=0) if G.size else G[3:]
        name = f"{type(joint).__name__} '{system.name(joint)}'"
        force_unique, moment_unique = np.abs(G[:3]).max() < 1e-7, np.abs(moment).max() < 1e-7
        shares.append(Share(name, rows.stop - rows.start, involved, bool(force_unique), bool(moment_unique)))
    return shares


def moment_arm(compiled: Compiled, joint: Any, body: Any) -> np.ndarray:
    """From O of the body to the joint's point, world at the reference pose, in model lengths."""
    return np.asarray((joint.point() - body.position) / compiled.model.length).reshape(3, 1)


def verdict_text(
    compiled: Compiled, rows: int, rank: int, n: int, misfit: float, as_built: float, offset: float
) -> str:
    """One line that says what the constraints amount to."""
    driven = any(isinstance(joint, Driver) for joint in compiled.system.joints)
    if misfit > 0.0:
        return f"redundant within the as-built tolerance ({as_built:g} m): misfit {misfit:.3g} m"
    if rank == n and not driven:
        cause = f"; parts that miss each other by {offset:.6g} m take the last freedom" if offset else ""
        return f"locked: the joints leave no freedom{cause}"
    if rows > rank:
        return f"redundant, consistent: {rows - rank} of {rows} rows repeat others"
    return "regular: all rows are independent" + (", the drivers determine the motion" if rank == n else "")
