"""Cures for redundant joints: weaker types found by search and verified by rank.

A weaker joint's rows are combinations T J_i of the rows of the joint it replaces. With N the left null space of J, the
redundancy left after a replacement is the dimension of {n in span N: n_i in range T'}: small matrices, no new SVD of J.
Every cure that is reported has then been verified by rebuilding the rows and taking their rank.
"""

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
import scipy.linalg

from .assembly import reference_pose
from .drivers import Driver
from .evaluation import load_state
from .joints import (
    AxisJoint,
    Cylindrical,
    Joint,
    Planar,
    PointJoint,
    PointOnLine,
    PointOnPlane,
    Revolute,
    Spherical,
    Universal,
    perpendiculars,
)
from .model import compile_system
from .selection import dense_jacobian, scaled_jacobian

LIMIT = 12  # cures reported
UNCOMMON = {Cylindrical: 1, Universal: 2, Planar: 3, PointOnPlane: 3}  # harder to build than Spherical or PointOnLine


@dataclass(frozen=True)
class Cure:
    """Replacements (joint name -> weaker type, None = removed) after which all rows are independent."""

    replacements: tuple[tuple[str, str | None], ...]
    rows_removed: int
    text: str


def weaker(joint: Joint) -> list[Joint | None]:
    """Weaker joints at the same place, None for no joint at all."""
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
            PointOnPlane(a, b, at=at, at_b=at_b, normal=axis, name=name),
            PointOnPlane(a, b, at=at, at_b=at_b, normal=x, name=name),
        ]
    return [*[option for option in options if type(option) is not type(joint)], None]


def jacobian_of(system: Any, joint: Joint, length: float) -> np.ndarray:
    """Scaled rows of a single joint at the reference pose, columns of the whole system, in units of ``length``."""
    from .system import System

    alone = System(bodies=system.bodies, joints=[joint], gravity=system.gravity)
    compiled = compile_system(alone)
    data = compiled.data()
    load_state(compiled, data, reference_pose(alone))
    metres = np.repeat([row.in_metres for row in joint.rows()], [row.n_rows for row in joint.rows()])
    row = compiled.model.row.copy()
    row["scale"] = np.where(metres, 1.0 / length, 1.0)
    return scaled_jacobian(compiled.model._replace(row=row, length=length), dense_jacobian(compiled.model, data))


def options_of(compiled: Any, A: np.ndarray, joint: Joint, N: np.ndarray) -> list[tuple[Joint | None, np.ndarray]]:
    """(weaker joint, projector P that vanishes on range T') for the replacements whose rows lie in the joint's own."""
    rows = compiled.rows[id(joint)]
    own, found = A[rows], []
    for option in weaker(joint):
        if option is None:
            found.append((None, np.eye(own.shape[0])))
            continue
        if sum(row.n_rows for row in option.rows()) >= own.shape[0]:
            continue
        J = jacobian_of(compiled.system, option, compiled.model.length)
        T = scipy.linalg.lstsq(own.T, J.T)[0].T  # J = T own
        if np.abs(T @ own - J).max(initial=0.0) > 1e-8 * max(np.abs(J).max(initial=0.0), 1e-300):
            continue
        basis = scipy.linalg.orth(T.T) if T.size else np.zeros((own.shape[0], 0))
        found.append((option, np.eye(own.shape[0]) - basis @ basis.T))
    return found


def redundancy_left(parts: list[np.ndarray], k: int) -> int:
    """Dimension of the null vectors that survive: k minus the rank of the stacked P N_i."""
    stacked = np.vstack(parts)
    s = scipy.linalg.svdvals(stacked)
    return k - int((s > 1e-9).sum())


def find_cures(compiled: Any, A: np.ndarray, N: np.ndarray, mobility: int) -> list[Cure]:
    """Single replacements, then pairs, then a greedy set; fewest joints touched and fewest rows lost first."""
    k = N.shape[1]
    involved = [j for j in compiled.system.joints if np.abs(N[compiled.rows[id(j)]]).max(initial=0.0) > 1e-8]
    involved = [j for j in involved if not isinstance(j, Driver)]
    table = [(j, compiled.rows[id(j)], options_of(compiled, A, j, N)) for j in involved[:40]]
    candidates = [[(j, o, P @ N[rows]) for o, P in options] for j, rows, options in table]

    def cured(chosen: list) -> bool:
        """No redundancy left, and not one row more than that given up: the mobility stays."""
        return lost_rows(compiled, chosen) == k and redundancy_left([c[2] for c in chosen], k) == 0

    sets = [[c] for group in candidates for c in group if cured([c])]
    if len(candidates) <= 20:
        sets += [
            [c, d]
            for one, two in combinations(candidates, 2)
            for c in one
            for d in two
            if c[1] is not None and d[1] is not None and cured([c, d])
        ]
    if not sets:
        greedy = greedy_set(compiled, candidates, k)
        sets = [greedy] if greedy else []
    cures, before = [], A.shape[0]
    for chosen in sorted(sets, key=lambda s: (len(s), sum(UNCOMMON.get(type(option), 0) for _, option, _ in s))):
        if len(cures) == LIMIT:
            break
        if verified(compiled, chosen, mobility):
            cures.append(describe(compiled, chosen, before))
    return cures


def lost_rows(compiled: Any, chosen: list) -> int:
    """Rows given up by a set of replacements."""
    own = sum(compiled.rows[id(j)].stop - compiled.rows[id(j)].start for j, _, _ in chosen)
    return own - sum(row.n_rows for _, option, _ in chosen if option is not None for row in option.rows())


def greedy_set(compiled: Any, candidates: list, k: int) -> list:
    """Replace joint by joint, each time the one that removes most redundancy and no other row."""
    chosen, left, remaining = [], k, list(candidates)
    while left > 0 and remaining:
        best = None
        for group in remaining:
            for c in group:
                after = redundancy_left([x[2] for x in chosen] + [c[2]], k)
                if 0 < left - after == lost_rows(compiled, [c]) and (best is None or after < best[2]):
                    best = (c, group, after)
        if best is None:
            return []
        chosen.append(best[0])
        remaining = [group for group in remaining if group is not best[1]]
        left = best[2]
    return chosen


def verified(compiled: Any, chosen: list, mobility: int) -> bool:
    """Rebuild the rows with the replacements: all independent, and the mobility unchanged."""
    system = compiled.system
    swap = {id(j): option for j, option, _ in chosen}
    blocks = []
    for joint in system.joints:
        option = swap.get(id(joint), joint)
        if option is joint:
            blocks.append(None)
        elif option is not None:
            blocks.append(jacobian_of(system, option, compiled.model.length))
    compiled_rows = [compiled.rows[id(j)] for j in system.joints if swap.get(id(j), j) is j]
    data = compiled.data()
    load_state(compiled, data, reference_pose(system))
    A = scaled_jacobian(compiled.model, dense_jacobian(compiled.model, data))
    rows = [A[r] for r in compiled_rows] + [block for block in blocks if block is not None]
    stacked = np.vstack(rows) if rows else np.zeros((0, A.shape[1]))
    s = scipy.linalg.svdvals(stacked) if stacked.size else np.zeros(0)
    rank = int((s > 1e-10 * s[0]).sum()) if s.size else 0
    return rank == stacked.shape[0] and A.shape[1] - rank == mobility


def describe(compiled: Any, chosen: list, before: int) -> Cure:
    """The cure in words."""
    system, texts, pairs = compiled.system, [], []
    for joint, option, _ in chosen:
        name = system.name(joint)
        pairs.append((name, None if option is None else type(option).__name__))
        if option is None:
            texts.append(f"remove '{name}' ({type(joint).__name__})")
        else:
            detail = axis_text(option)
            texts.append(f"'{name}' {type(joint).__name__} -> {type(option).__name__}{detail}")
    lost = lost_rows(compiled, chosen)
    left = before - lost
    return Cure(tuple(pairs), lost, f"{' and '.join(texts)} ({left} rows, all independent)")


def axis_text(option: Joint) -> str:
    """Direction of a weaker joint, where it has one."""
    axis = getattr(option, "axis", getattr(option, "normal", getattr(option, "axis_a", None)))
    if axis is None or isinstance(option, Revolute):
        return ""
    return " along ({:.4g}, {:.4g}, {:.4g})".format(*(axis + 0.0))
