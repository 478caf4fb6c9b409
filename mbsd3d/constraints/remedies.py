"""Remedies for redundant joints: weaker types, found by search and verified by rank.

A weaker joint's rows are combinations T J_i of the rows of the joint it replaces. With N the left null space of J, the
redundancy left after a replacement is the dimension of {n in span N: n_i in range T'}: small matrices, no new SVD of J.
Every remedy that is reported has then been verified by rebuilding the rows and taking their rank.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
import scipy.linalg

from ..base.rotations import perpendiculars
from ..base.wording import counted
from ..equations.at_state import load_state
from ..equations.compiled import Compiled, compile_system
from ..equations.jacobian import BlockRows, block_rows
from ..mechanism.bodies import Body
from ..mechanism.drivers import Driver
from ..mechanism.joints import AxisJoint, Joint, PointJoint
from ..mechanism.joints.conditions import PointOnLine, PointOnPlane
from ..mechanism.joints.pairs import Cylindrical, Planar, Spherical, Universal
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from .rank import Analysis, without_rounding

REMEDIES_REPORTED_MAX = 12  # [remedies] that a report lists; more are not read
EXHAUSTIVE_JOINTS_MAX = 40  # [joints] among which all singles and pairs are tried; beyond, a set is built up greedily
# [1] over Spherical and PointOnLine
JOINT_COST: dict[type, int] = {Cylindrical: 1, Universal: 2, Planar: 3, PointOnPlane: 3}


@dataclass(frozen=True)
class Cure:
    """Replacements (joint name -> weaker type, None = removed) after which all rows are independent."""

    replacements: tuple[tuple[str, str | None], ...]
    rows_removed: int
    text: str


def weaker(joint: Joint) -> list[Joint | None]:
    """Return weaker joints at the same place, None for no joint at all."""
    if not isinstance(joint, PointJoint) or isinstance(joint, Driver):
        return [None]
    a, b, at, at_b, name = joint.a, joint.b, joint.at, joint.at_b, joint.name
    options: list[Joint | None] = [Spherical(a, b, at=at, at_b=at_b, name=name)]
    if isinstance(joint, AxisJoint):
        axis, x, y = joint.axis, *perpendiculars(joint.axis)
        options = [
            Cylindrical(a, b, at=at, at_b=at_b, axis=axis, axis_b=joint.axis_b, name=name),
            Universal(a, b, at=at, at_b=at_b, axis_a=x, axis_b=axis, name=name),
            Universal(a, b, at=at, at_b=at_b, axis_a=y, axis_b=axis, name=name),
            *options,
            PointOnLine(a, b, at=at, at_b=at_b, axis=axis, name=name),
            Planar(a, b, at=at, at_b=at_b, normal=axis, name=name),
            *(PointOnPlane(a, b, at=at, at_b=at_b, normal=normal, name=name) for normal in (axis, x, y)),
        ]
    return [*[option for option in options if type(option) is not type(joint)], None]


def serves(joint: Joint, option: Joint | None) -> bool:
    """Return True if drivers, couplings and springs on the angle or slide of a joint also fit the weaker one."""
    if option is None:
        return False
    pairs = (joint.angle(), option.angle()), (joint.slide(), option.slide())
    return all(own is None or other is not None for own, other in pairs)


def rows_of(compiled: Compiled, pose: State, joint: Joint) -> BlockRows:
    """Return the scaled rows of a joint that may not be in the system, at the pose."""
    bodies = [body for body in joint.bodies() if isinstance(body, Body)]
    index = np.array([*(compiled.body_index[id(body)] for body in bodies), compiled.model.body.size])
    alone = compile_system(Mechanism(bodies=bodies, joints=[joint]))
    data, length = alone.data(), compiled.model.length
    load_state(alone, data, State(pose.t, pose.q.reshape(-1, 7)[index[:-1]].ravel(), np.zeros(6 * len(bodies))))
    metres = np.repeat([row.in_metres for row in joint.rows()], [row.n_rows for row in joint.rows()])
    on = alone.model.row["body"]
    rows = block_rows(alone.model, data)._replace(body=np.where(on >= 0, index[on], -1), n=int(index[-1]))
    return rows.scaled(np.where(metres, 1.0 / length, 1.0), length)


class Search:
    """Effect of replacements on the redundant combinations N (columns); projectors are made on first use."""

    def __init__(self, compiled: Compiled, pose: State, rows: BlockRows, N: np.ndarray) -> None:
        self.compiled, self.pose, self.rows, self.N = compiled, pose, rows, N
        self.projectors: dict[tuple[Joint, Joint | None], np.ndarray | None] = {}
        system = compiled.system
        self.acted_on = {id(partner) for part in (*system.joints, *system.forces) for partner in part.partners()}

    def own(self, joint: Joint) -> slice:
        """Return the rows of a joint."""
        return self.compiled.rows[id(joint)]

    def candidates(self, joint: Joint) -> list[tuple[Joint, Joint | None]]:
        """Return (joint, weaker joint) for all weaker joints with fewer rows that can stand in its place."""
        fewer = [(joint, option) for option in weaker(joint) if self.lost([(joint, option)]) > 0]
        return [(joint, option) for _, option in fewer if id(joint) not in self.acted_on or serves(joint, option)]

    def lost(self, chosen: list) -> int:
        """Return the rows given up by a set of replacements."""
        own = sum(self.own(joint).stop - self.own(joint).start for joint, _ in chosen)
        return own - sum(row.n_rows for _, option in chosen if option is not None for row in option.rows())

    def projector(self, joint: Joint, option: Joint | None) -> np.ndarray | None:
        """Return P that vanishes on range T' with J_option = T J_joint; None where the rows are not in the joint's."""
        if (joint, option) not in self.projectors:
            self.projectors[joint, option] = self.make_projector(joint, option)
        return self.projectors[joint, option]

    def make_projector(self, joint: Joint, option: Joint | None) -> np.ndarray | None:
        """Compute the projector of `projector`."""
        own = self.rows.take(self.own(joint)).sparse().toarray()
        if option is None:
            return np.eye(own.shape[0])
        J, used = rows_of(self.compiled, self.pose, option).sparse().toarray(), own.any(axis=0)
        T = scipy.linalg.lstsq(own[:, used].T, J[:, used].T)[0].T
        if np.abs(T @ own - J).max(initial=0.0) > 1e-8 * max(np.abs(J).max(initial=0.0), 1e-300):
            return None
        basis = scipy.linalg.orth(T.T) if T.size else np.zeros((own.shape[0], 0))
        return np.eye(own.shape[0]) - basis @ basis.T

    def cured(self, chosen: list) -> bool:
        """Return True if no redundancy is left and no more rows are given up, so that the mobility stays."""
        k = self.N.shape[1]
        if self.lost(chosen) != k:
            return False
        projectors = [self.projector(*c) for c in chosen]
        if any(P is None for P in projectors):
            return False
        stacked = np.vstack([P @ self.N[self.own(c[0])] for P, c in zip(projectors, chosen, strict=True)])
        return rank_in_N(stacked) == k

    def greedy(self, joints: list) -> list:
        """Replace joint by joint, most rows first, where as many redundancies vanish as rows, until none is left."""
        chosen, done, left, N = [], set(), self.N.shape[1], self.N.copy()
        candidates = [(self.lost([c]), c) for joint in joints for c in self.candidates(joint)]
        for lost, (joint, option) in sorted(candidates, key=lambda pair: -pair[0]):  # stable: joints in their order
            own = N[self.own(joint)]
            if joint in done or lost > left or rank_in_N(own) < lost:
                continue
            P = self.projector(joint, option)
            if P is not None and rank_in_N(P @ own) == lost:
                left -= remove_redundancies(P @ own, N)
                done.add(joint)
                chosen.append((joint, option))
        return chosen if left == 0 else []


def rank_in_N(B: np.ndarray) -> int:
    """Return the rank of a few rows of combinations, entries of order one."""
    touched = B.any(axis=0)
    return int((scipy.linalg.svdvals(B[:, touched]) > 1e-9).sum()) if touched.any() else 0


def remove_redundancies(B: np.ndarray, N: np.ndarray) -> int:
    """Replace the columns of N by combinations with B = 0, in place; return how many have ended."""
    touched = np.flatnonzero(B.any(axis=0))
    _, R, pivot = scipy.linalg.qr(B[:, touched], mode="economic", pivoting=True)
    rank = int((np.abs(np.diag(R)) > 1e-9).sum())
    ended, others = touched[pivot[:rank]], touched[pivot[rank:]]
    rows = np.flatnonzero(N[:, ended].any(axis=1))
    change = N[np.ix_(rows, ended)] @ np.linalg.solve(R[:rank, :rank], R[:rank, rank:])
    N[np.ix_(rows, others)] = without_rounding(N[np.ix_(rows, others)] - change)
    N[:, ended] = 0.0
    return rank


def find_cures(compiled: Compiled, pose: State, rows: BlockRows, N: np.ndarray, mobility: int) -> list[Cure]:
    """Find single replacements, then pairs, then a greedy set; fewest joints and fewest lost rows first."""
    search = Search(compiled, pose, rows, N)
    involved = [j for j in compiled.system.joints if np.abs(N[compiled.rows[id(j)]]).max(initial=0.0) > 1e-8]
    involved = [j for j in involved if not isinstance(j, Driver)]
    candidates = [search.candidates(joint) for joint in involved[:EXHAUSTIVE_JOINTS_MAX]]
    sets = [[c] for group in candidates for c in group if search.cured([c])]
    if len(candidates) <= 20:
        sets += [
            [c, d]
            for one, two in combinations(candidates, 2)
            for c in one
            for d in two
            if c[1] is not None and d[1] is not None and search.cured([c, d])
        ]
    if not sets:
        greedy = search.greedy(involved)
        sets = [greedy] if greedy else []
    remedies: list[Cure] = []
    for chosen in sorted(sets, key=lambda s: (len(s), sum(JOINT_COST.get(type(option), 0) for _, option in s))):
        if len(remedies) == REMEDIES_REPORTED_MAX:
            break
        if verified(compiled, pose, rows, chosen, mobility):
            remedies.append(describe(compiled, chosen, search.lost(chosen)))
    return remedies


def verified(compiled: Compiled, pose: State, rows: BlockRows, chosen: list, mobility: int) -> bool:
    """Rebuild the rows with the replacements; return True if all are independent and the mobility is unchanged."""
    swapped = [rows_of(compiled, pose, option) for _, option in chosen if option is not None]
    kept = np.ones(rows.body.shape[0], bool)
    for joint, _ in chosen:
        kept[compiled.rows[id(joint)]] = False
    parts = [rows.take(kept), *swapped]
    cured = BlockRows(np.concatenate([p.body for p in parts]), np.concatenate([p.J for p in parts]), rows.n)
    rank = Analysis(cured).rank
    return rank == cured.body.shape[0] and 6 * rows.n - rank == mobility


def describe(compiled: Compiled, chosen: list, lost: int) -> Cure:
    """Return the remedy in words."""
    system, texts, pairs = compiled.system, [], []
    for joint, option in chosen:
        name = system.name(joint)
        pairs.append((name, None if option is None else type(option).__name__))
        if option is None:
            texts.append(f"remove '{name}' ({type(joint).__name__})")
        else:
            detail = axis_text(option)
            texts.append(f"'{name}' {type(joint).__name__} -> {type(option).__name__}{detail}")
    left = compiled.model.row.size - lost
    return Cure(tuple(pairs), lost, f"{' and '.join(texts)} ({counted(left, 'row')}, all independent)")


def axis_text(option: Joint) -> str:
    """Return the directions of a weaker joint, those of a cross in all digits, so that loops still close."""
    if isinstance(option, Universal):
        return f" with axis_a = {direction_text(option.axis_a, 16)}, axis_b = {direction_text(option.axis_b, 16)}"
    axis = getattr(option, "axis", getattr(option, "normal", None))
    return "" if axis is None else f" along {direction_text(axis, 4)}"


def direction_text(axis: np.ndarray, digits: int) -> str:
    """Return a direction in the given number of digits."""
    return "({})".format(", ".join(f"{x:.{digits}g}" for x in axis.round(16) + 0.0))
