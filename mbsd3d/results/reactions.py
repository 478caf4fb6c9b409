"""Reactions: which are determined by the constraints, and the least-norm shares of those that are not.

With N the left null space of J (scaled), the multipliers are lam + N a for any a. A wrench G lam is unique if and
only if G N = 0; the share of least norm of the others is lam - N N' lam, which depends on the unit of length.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..base.style import Sampled
from ..constraints.rank import redundant_combinations
from ..equations.at_state import load_rows, rows_at
from ..equations.compiled import Compiled
from ..equations.jacobian import BlockRows, displacement_units, islands
from ..kernels.batch import wrenches
from ..mechanism.bodies import GROUND
from ..mechanism.joints import Joint

if TYPE_CHECKING:
    from .run_result import RunResult


@dataclass(frozen=True, repr=False)
class Reaction(Sampled):
    """Wrench on body b at the joint's point, world axes; all (samples, 3) in N, N m, m."""

    force: np.ndarray
    moment: np.ndarray
    point: np.ndarray
    unique: bool


class Open(NamedTuple):
    """Shares that the constraints leave open, among rows that no other rows touch."""

    rows: np.ndarray  # (m,) which
    N: np.ndarray  # (m, k) left null space of their scaled J


class MiddleRows(NamedTuple):
    """The rows at the middle sample, where no special start position hides the general rank."""

    open: list[Open]
    place: np.ndarray  # (rows,) of each row in the list, -1 where nothing is open
    J: np.ndarray  # (rows, 4, 6) blocks per slot


def open_shares(rows: BlockRows) -> list[Open]:
    """What scaled rows leave open, island by island: a null space of all rows would grow with the cube of a system."""
    found = ((own, redundant_combinations(rows.alone(own))) for own in islands(rows))
    return [Open(own, N) for own, N in found if N.shape[1]]


def middle_rows(compiled: Compiled, t: np.ndarray, states: np.ndarray, left_out: int | None = None) -> MiddleRows:
    """Rows of a run, for `unique_wrench` and `minimum_norm`; nothing is open where the run left out no row."""
    data, k = compiled.data(), t.size // 2
    place = np.full(compiled.model.row.size, -1)
    if not place.size or not t.size or left_out == 0:
        return MiddleRows([], place, data.row["J"])
    found = open_shares(rows_at(compiled, data, t[k], states[k]))
    for i, (own, _) in enumerate(found):
        place[own] = i
    return MiddleRows(found, place, data.row["J"])


def unique_wrench(compiled: Compiled, middle: MiddleRows, parts: list) -> bool:
    """True if the summed wrench of the joints' rows on their body b is determined by the constraints."""
    if not middle.open:
        return True
    model, body = compiled.model, compiled.body_index[id(parts[0].b)]
    rows = np.concatenate([np.arange(model.row.size)[compiled.rows[id(part)]] for part in parts])
    on_b = model.row["body"][rows] == body
    G = np.where(on_b[:, :, None], middle.J[rows], 0.0).sum(axis=1) * model.row["scale"][rows, None]
    G *= displacement_units(model.length, 1)
    for i in set(middle.place[rows].tolist()) - {-1}:
        _, mine, theirs = np.intersect1d(rows, middle.open[i].rows, return_indices=True)
        if np.abs(G[mine].T @ middle.open[i].N[theirs]).max() >= 1e-7:
            return False
    return True


def minimum_norm(
    compiled: Compiled, middle: MiddleRows, t: np.ndarray, states: np.ndarray, lam: np.ndarray
) -> np.ndarray:
    """Multipliers of least norm in the model's own units that give the same forces."""
    if not middle.open:
        return lam
    data, scale, shared = compiled.data(), compiled.model.row["scale"], lam.copy()
    for k in range(t.size):
        for own, N in open_shares(rows_at(compiled, data, t[k], states[k])):
            mu = lam[k, own] / scale[own]
            shared[k, own] = (mu - N @ (N.T @ mu)) * scale[own]
    return shared


def reaction_of(solution: "RunResult", joints: tuple[Joint | str, ...]) -> Reaction:
    """See `Solution.reaction`."""
    system, compiled = solution.system, solution.compiled
    parts = [system.part(joint, "joints") for joint in joints]
    if not parts:
        raise ValueError("solution.reaction: no joint given; give one or more joints")
    body = parts[0].b
    for part in parts[1:]:
        if part.b is not body:
            raise ValueError(
                f"solution.reaction: '{system.name(part)}' acts on '{part.b.name}', "
                f"'{system.name(parts[0])}' on '{body.name}'; net wrenches need one body b"
            )
    unique, samples = unique_wrench(compiled, solution._middle, parts), solution.t.size
    lam = solution.arrays["lam"] if unique else solution._multipliers
    total, one = np.zeros((samples, 6)), np.zeros((samples, 6))
    index, data = compiled.body_index[id(body)], compiled.data()
    for part in parts:
        rows = compiled.rows[id(part)]
        wrenches(compiled.model, data, solution.t, solution.arrays["state"], lam, rows.start, rows.stop, index, one)
        total += one
    point = parts[0].reaction_points(solution)
    origin = np.zeros((samples, 3)) if body is GROUND else solution.position(body)
    force = total[:, :3]
    return Reaction(force, total[:, 3:] - np.cross(point - origin, force), point, unique)


def every_reaction(solution: "RunResult", samples: np.ndarray) -> list[Reaction]:
    """`Solution.reaction` of every joint at the given samples, by one pass over them instead of one per joint."""
    compiled, joints = solution.compiled, solution.system.joints
    unique = [unique_wrench(compiled, solution._middle, [joint]) for joint in joints]
    t, states, lam = solution.t[samples], solution.arrays["state"][samples], multipliers(solution, unique)[samples]
    wrenches = wrenches_about_O(compiled, t, states, lam)
    found = []
    for k, joint in enumerate(joints):
        point = joint.reaction_points(solution)[samples]
        origin = 0.0 if joint.b is GROUND else solution.position(joint.b)[samples]
        force = wrenches[:, k, :3]
        found.append(Reaction(force, wrenches[:, k, 3:] - np.cross(point - origin, force), point, unique[k]))
    return found


def multipliers(solution: "RunResult", unique: list[bool]) -> np.ndarray:
    """(samples, rows) multipliers, of least norm for the joints (in their order) whose wrench is not unique."""
    lam = solution.arrays["lam"].copy()
    for joint, certain in zip(solution.system.joints, unique, strict=True):
        if not certain:
            rows = solution.compiled.rows[id(joint)]
            lam[:, rows] = solution._multipliers[:, rows]
    return lam


def wrenches_about_O(compiled: Compiled, t: np.ndarray, states: np.ndarray, lam: np.ndarray) -> np.ndarray:
    """(samples, joints, 6) force and moment of every joint on its body b about O: minus the sum of J' lam."""
    data, joints, pairs = compiled.data(), compiled.system.joints, []
    for k, joint in enumerate(joints):
        rows = compiled.rows[id(joint)]
        on_b = np.argwhere(compiled.model.row["body"][rows] == compiled.body_index[id(joint.b)])
        pairs += [(k, rows.start + row, slot) for row, slot in on_b]
    which, row, slot = np.array(pairs, dtype=int).reshape(-1, 3).T
    out = np.zeros((t.size, len(joints), 6))
    for i in range(t.size):
        load_rows(compiled, data, states[i], t[i])
        np.subtract.at(out[i], which, data.row["J"][row, slot] * lam[i, row, None])
    return out
