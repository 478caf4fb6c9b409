"""Reactions: which are determined by the constraints, and the least-norm shares of those that are not.

With N the left null space of J (scaled), the multipliers are lam + N a for any a. A wrench G lam is unique if and
only if G N = 0; the share of least norm of the others is lam - N N' lam, which depends on the unit of length.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from .blocks import displacement_units
from .evaluation import load_rows, rows_at
from .model import Compiled
from .parts import GROUND
from .rank import redundant_combinations


@dataclass(frozen=True)
class Reaction:
    """Wrench on body b at the joint's point, world axes; all (samples, 3) in N, N m, m."""

    force: np.ndarray
    moment: np.ndarray
    point: np.ndarray
    unique: bool


class MiddleRows(NamedTuple):
    """The rows at the middle sample, where no special start position hides the general rank."""

    N: np.ndarray  # (rows, k) left null space of the scaled J
    J: np.ndarray  # (rows, 4, 6) blocks per slot


def middle_rows(compiled: Compiled, t: np.ndarray, states: np.ndarray, left_out: int | None = None) -> MiddleRows:
    """Rows of a run, for `unique_wrench` and `minimum_norm`; nothing is open where the run left out no row."""
    data, k = compiled.data(), t.size // 2
    if not compiled.model.row.size or not t.size or left_out == 0:
        return MiddleRows(np.zeros((compiled.model.row.size, 0)), data.row["J"])
    return MiddleRows(redundant_combinations(rows_at(compiled, data, t[k], states[k])), data.row["J"])


def unique_wrench(compiled: Compiled, middle: MiddleRows, parts: list) -> bool:
    """True if the summed wrench of the joints' rows on their body b is determined by the constraints."""
    if not middle.N.shape[1]:
        return True
    model, G = compiled.model, np.zeros((6, compiled.model.row.size))
    body = compiled.body_index[id(parts[0].b)]
    for part in parts:
        span = compiled.rows[id(part)]
        for k in range(span.start, span.stop):
            for slot in range(4):
                if model.row["body"][k, slot] == body:
                    G[:, k] += middle.J[k, slot] * model.row["scale"][k] * displacement_units(model.length, 1)
    return bool(np.abs(G @ middle.N).max() < 1e-7)


def minimum_norm(
    compiled: Compiled, middle: MiddleRows, t: np.ndarray, states: np.ndarray, lam: np.ndarray
) -> np.ndarray:
    """Multipliers of least norm in the model's own units that give the same forces."""
    if not middle.N.shape[1]:
        return lam
    data, scale, shared = compiled.data(), compiled.model.row["scale"], np.empty_like(lam)
    for k in range(t.size):
        N = redundant_combinations(rows_at(compiled, data, t[k], states[k]))
        mu = lam[k] / scale
        shared[k] = (mu - N @ (N.T @ mu)) * scale
    return shared


def every_reaction(solution: Any, samples: np.ndarray) -> list[Reaction]:
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


def multipliers(solution: Any, unique: list[bool]) -> np.ndarray:
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
