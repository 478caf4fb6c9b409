"""Rank, degrees of freedom and redundant joints of a mechanism, with remedies."""

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from ..base.style import Result
from ..equations.at_state import joint_point, load_state, worst_joint
from ..equations.compiled import Compiled, compile_system
from ..equations.jacobian import BlockRows, scaled_rows
from ..equations.plausibility import doubtful_inertias, loose_bodies
from ..kernels.layout import Data
from ..mechanism.drivers import Driver
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from .assembly import reference_pose
from .conflicting_drivers import TOLERANCE, find_contradiction
from .elimination import PIVOT_SHARE_MIN, Core, loop_weights
from .idle_rotations import find_idle_rotations
from .neighbourhood import Beside, neighbourhood
from .poses.closing import close_pose
from .poses.pose_equations import gap_size, newton
from .rank import OPEN_TOLERANCE, Analysis, orthonormal, projector
from .remedies import Cure, direction_text, find_cures
from .singularity import singularities

FIT_TOLERANCE_DEFAULT = 1e-5  # [m] by which parts as built may fail to fit; a usual tolerance of manufacture
FIT_TOLERANCE_RATIO = 1e-4  # [1] of the model length: the limit of mechanisms smaller than a hand


@dataclass(frozen=True)
class Share:
    """Redundancy of one joint: its rows, how many of them take part, and which reactions are determined.

    ``force_open`` and ``moment_open`` say in which directions they are not: "", "along (x, y, z)", "across (x, y, z)",
    or "all".
    """

    joint: str
    rows: int
    involved: int
    force_open: str
    moment_open: str

    @property
    def force_unique(self) -> bool:
        """Return True if the constraints determine the force."""
        return not self.force_open

    @property
    def moment_unique(self) -> bool:
        """Return True if the constraints determine the moment."""
        return not self.moment_open

    def __str__(self) -> str:
        kinds = (("forces", self.force_open), ("moments", self.moment_open))
        what = [kind if where == "all" else f"{kind} {where}" for kind, where in kinds if where]
        text = f"indeterminate {' and '.join(what)}" if what else "reactions unique"
        return f"{self.joint}: {self.involved} of {self.rows} rows in redundant sets, {text}"


@dataclass(frozen=True, repr=False)
class Diagnosis(Result):
    """Coordinates, rows and degrees of freedom of a mechanism, and an assessment.

    ``mobility`` counts the velocities left free by all rows, ``configuration_freedom`` those left by the holonomic rows
    alone (both at the reference pose); ``gruebler`` is velocities - rows, what counting without geometry says.
    ``neighbour_ranks`` are those of poses nearby, none where the rows are independent here, so that they cannot gain,
    or where nothing moves.
    ``misfit`` [m] is by how much the parts as built miss their joints. ``least_singular`` is the smallest singular
    value that counts over the largest, 1 where all was decided without: it falls to 0 towards a singular pose.
    ``notes`` say which body spins without moving another one, whether the pose is singular or nearly so, and which
    mobility is infinitesimal: lost as soon as the mechanism moves. They name bodies that nothing acts on, and inertias
    in other units than the lengths. The verdict names drivers that contradict each other and bodies whose spin nothing
    determines.
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
    least_singular: float
    notes: tuple[str, ...]

    @property
    def velocity_freedom(self) -> int:
        """Return the number of independent velocities: 6 a body minus the rank of all rows."""
        return self.mobility

    def __str__(self) -> str:
        lines = [
            self.verdict,
            f"  {self.coordinates} coordinates, {self.velocities} velocities, {self.rows} rows of rank {self.rank}",
            f"  mobility {self.mobility} (configuration degrees of freedom {self.configuration_freedom}), "
            f"Gruebler count {self.gruebler}",
        ]
        lines += [f"  {share}" for share in self.shares]
        lines += [f"  remedy: {cure.text}" for cure in self.cures]
        lines += [f"  {text}" for text in self.notes]
        return "\n".join(lines)


def diagnose(system: Mechanism, as_built: float | None) -> Diagnosis:
    """Analyse the constraints, as `System.check`."""
    compiled = compile_system(system)
    data, length, n = compiled.data(), compiled.model.length, 6 * len(system.bodies)
    as_built = min(FIT_TOLERANCE_DEFAULT, FIT_TOLERANCE_RATIO * length) if as_built is None else as_built
    pose, misfit, stuck = closed_pose(compiled, as_built)
    load_state(compiled, data, pose)
    rows = scaled_rows(compiled.model, data)
    found = Analysis(rows, safe=max(PIVOT_SHARE_MIN, 10.0 * as_built / length))
    slip = misfit_as_built(found, length, as_built)
    if slip > 0.0:  # from here on rows that play takes up repeat others
        found.tolerance = as_built / length / found.largest
    rank, N, misfit = found.rank, found.redundant(), max(misfit, slip)
    beside = neighbourhood(compiled, pose, found)
    shares = tuple(joint_shares(compiled, data, rows, N, 10.0 * found.tolerance * found.largest))
    cures = () if stuck else tuple(cures_of(compiled, pose, rows, found, beside.general(found)))
    offset = 0.0 if slip else misfit_of_lock(found, length)
    spins = find_idle_rotations(compiled, data, rows)
    slack = max(TOLERANCE, 10.0 * as_built / length)
    clash = find_contradiction(compiled, data, pose.t, N=orthonormal(N), slack=slack)
    verdict = stuck or verdict_text(compiled, found.m, rank, n, misfit, as_built, offset)
    loose_ends = [spin for spin in spins if spin.massless]
    if clash or loose_ends:
        verdict = f"contradictory: {clash.text}" if clash else f"undetermined: {loose_ends[0].text}"
    notes = [f"freedom: {spin.text}" for spin in spins if not (spin.massless and spin is loose_ends[0] and not clash)]
    notes += singularities(compiled, data, pose, found, beside)
    notes += doubtful_inertias(system) + loose_bodies(system)
    return Diagnosis(
        coordinates=7 * len(system.bodies),
        velocities=n,
        rows=found.m,
        rank=rank,
        gruebler=n - found.m,
        mobility=n - rank,
        configuration_freedom=n - holonomic_rank(compiled, rows, found),
        redundant=found.m - rank,
        shares=shares,
        verdict=verdict,
        misfit=misfit or offset,
        cures=cures,
        neighbour_ranks=tuple(x.rank for x in beside.poses),
        length=length,
        least_singular=found.smallest,
        notes=tuple(notes),
    )


def cures_of(
    compiled: Compiled, pose: State, rows: BlockRows, found: Analysis, general: Beside | None
) -> list[Cure]:  # fmt: skip
    """Return remedies of the redundancies at the pose; of a singular one, of those that are left beside it."""
    if general is not None:
        pose, rows, found = general.pose, general.rows, general.found
    N = found.redundant()
    return find_cures(compiled, pose, rows, N, 6 * found.n - found.rank) if N.shape[1] else []


def holonomic_rank(compiled: Compiled, rows: BlockRows, found: Analysis) -> int:
    """Return the rank of the rows that have a residual."""
    holonomic = compiled.model.row["holonomic"].astype(bool)
    return found.rank if holonomic.all() else Analysis(rows.take(holonomic), found.tolerance).rank


def misfit_as_built(found: Analysis, length: float, as_built: float) -> float:
    """Return the largest misfit below ``as_built`` [m], which play takes up.

    A unit motion (one radian, one model length) along a right singular vector violates the rows by its singular value.
    """
    small = found.counted[found.counted * length <= as_built]
    return violation(found, 10.0 * small.max()) * length if small.size else 0.0


def violation(found: Analysis, tolerance: float) -> float:
    """Return the largest violation of spared rows, per radian or model length of a motion of the kept rows."""
    return max((core_violation(found, core, tolerance) for core in found.cores), default=0.0)


def core_violation(found: Analysis, core: Core, tolerance: float) -> float:
    """Return the violation of the spared rows of a core (scaled, norm).

    Rows are kept in the order of the joints, so the last joints show the misfit.
    """
    kept, basis = [], np.zeros((0, core.columns.size))
    for k, row in enumerate(core.F):
        rest = row - basis.T @ (basis @ row)
        rest -= basis.T @ (basis @ rest)
        if np.linalg.norm(rest) > tolerance:
            kept.append(k)
            basis = np.vstack([basis, rest / np.linalg.norm(rest)])
    spared = np.setdiff1d(np.arange(core.rows.size), kept)
    Z = scipy.linalg.null_space(basis, rcond=1e-6) if kept else np.eye(core.columns.size)
    if not spared.size or not Z.shape[1]:
        return 0.0
    _, _, Vt = scipy.linalg.svd(core.F[spared] @ Z)
    x = Z @ Vt[0]
    motion = found.core_motion(core, x).reshape(-1, 6)
    turn, shift = np.linalg.norm(motion[:, 3:], axis=1).max(), np.linalg.norm(motion[:, :3], axis=1).max()
    size = turn if turn > 1e-6 * shift else shift
    return float(np.linalg.norm(core.F[spared] @ x) / size)


def misfit_of_lock(found: Analysis, length: float) -> float:
    """Return the misfit [m] that takes the last degree of freedom of a mechanism, 0 for a structure."""
    if found.rank < 6 * found.n or not found.least < 1e-2 * found.largest:
        return 0.0
    return violation(found, 10.0 * found.least) * length


def closed_pose(compiled: Compiled, as_built: float) -> tuple[State, float, str | None]:
    """Return (pose, misfit [m] left in rows that could be spared, verdict if the mechanism does not close)."""
    start = reference_pose(compiled.system)
    data = compiled.data()
    load_state(compiled, data, start)
    if gap_size(compiled, data.row["c"]) <= 1e-9:
        return start, 0.0, None
    found = close_pose(compiled, start, [], [], set())
    if found.gap <= 1e-9:
        return found.state, 0.0, None
    # joints that close loops get little weight, so that the gap appears there and not in every joint
    pose, residual = newton(compiled, start, [], [], set(), loop_weights(compiled))
    part, gap = worst_joint(compiled, residual)
    if gap <= as_built:
        return pose, gap, None
    if gap <= 1e-2 * compiled.model.length:
        text = f"locked: redundant joints miss each other by {gap:.6g} m at {part}, more than {as_built:g} m as built"
        return pose, gap, f"{text}; align them, or replace one by a joint with fewer rows"
    return pose, gap, f"cannot close: a gap of {gap:.6g} m remains at {part}; correct its position or a length"


def joint_shares(compiled: Compiled, data: Data, rows: BlockRows, N: np.ndarray, off: float) -> list[Share]:
    """Return the joints with rows in redundant sets, with their unique reactions.

    ``off``: what J'N may be off zero, in model lengths and radians.
    """
    system = compiled.system
    shares: list[Share] = []
    if not N.shape[1]:
        return shares
    for joint in system.joints:
        own = compiled.rows[id(joint)]
        involved = int((np.linalg.norm(N[own], axis=1) > max(1e-8, off)).sum())
        if not involved:
            continue
        moving = joint.b if compiled.body_index[id(joint.b)] < rows.n else joint.a
        i = compiled.body_index[id(moving)]
        on = rows.body[own] == i
        G = np.where(on[:, :, None], rows.J[own], 0.0).sum(axis=1).T @ N[own]
        arm = (joint_point(compiled, data, joint) - data.body["r"][i]) / compiled.model.length  # from O
        moment = G[3:] - np.cross(arm[:, None], G[:3], axis=0)
        name = f"{type(joint).__name__} '{system.name(joint)}'"
        open_to = (open_directions(x, max(OPEN_TOLERANCE, off)) for x in (G[:3], moment))
        shares.append(Share(name, own.stop - own.start, involved, *open_to))
    return shares


def open_directions(A: np.ndarray, tolerance: float) -> str:
    """Return the directions of the columns of A (3, k) in words, as `Share` says them."""
    size, axes = np.linalg.eigh(projector(A, tolerance))  # 0 for those of A, then 1
    count = int((size < 0.5).sum())
    axis = axes[:, 2 if count == 2 else 0].round(9)
    axis = axis * np.copysign(1.0, axis[np.argmax(np.abs(axis))])
    return ("", f"along {direction_text(axis, 3)}", f"across {direction_text(axis, 3)}", "all")[count]


def verdict_text(
    compiled: Compiled, rows: int, rank: int, n: int, misfit: float, as_built: float, offset: float
) -> str:
    """Return one line on what the constraints amount to."""
    driven = any(isinstance(joint, Driver) for joint in compiled.system.joints)
    if misfit > 0.0:
        return f"redundant within the as-built tolerance ({as_built:g} m): misfit {misfit:.3g} m"
    if rank == n and not driven:
        cause = f"; parts that miss each other by {offset:.6g} m take the last degree of freedom" if offset else ""
        return f"locked: the joints leave no degree of freedom{cause}"
    if rows > rank:
        return f"redundant, consistent: {rows - rank} of {rows} rows repeat others"
    return "regular: all rows are independent" + (", the drivers determine the motion" if rank == n else "")
