"""Reactions of all joints of a run by one pass over its samples."""

import numpy as np

from ..equations.at_state import load_rows
from ..equations.compiled import Compiled
from ..mechanism.bodies import GROUND
from .reactions import Reaction
from .result import RunResult


def every_reaction(solution: RunResult, samples: np.ndarray) -> list[Reaction]:
    """`Solution.reaction` of every joint at the given samples, by one pass over them instead of one per joint."""
    compiled, joints = solution.compiled, solution.system.joints
    lam = solution.arrays["lam"][samples]
    for joint in (joint for joint in joints if not solution._is_unique([joint])):
        rows = compiled.rows[id(joint)]
        lam[:, rows] = solution._shares[0][samples, rows]
    states, coordinates = solution.arrays["state"][samples], solution.arrays["coordinate"][samples]
    wrenches = wrenches_about_O(compiled, solution.t[samples], states, coordinates, lam)
    found = []
    for k, joint in enumerate(joints):
        point = joint.reaction_points(solution)[samples]
        origin = 0.0 if joint.b is GROUND else solution.position(joint.b)[samples]
        force = wrenches[:, k, :3]
        moment = wrenches[:, k, 3:] - np.cross(point - origin, force)
        found.append(solution._determined([joint]).reaction(force, moment, point, samples))
    return found


def wrenches_about_O(
    compiled: Compiled, t: np.ndarray, states: np.ndarray, coordinates: np.ndarray, lam: np.ndarray
) -> np.ndarray:
    """(samples, joints, 6) force and moment of every joint on its body b about O: minus the sum of J' lam."""
    data, joints, pairs = compiled.data(), compiled.system.joints, []
    for k, joint in enumerate(joints):
        rows = compiled.rows[id(joint)]
        on_b = np.argwhere(compiled.model.row["body"][rows] == compiled.body_index[id(joint.b)])
        pairs += [(k, rows.start + row, slot) for row, slot in on_b]
    which, row, slot = np.array(pairs, dtype=int).reshape(-1, 3).T
    out = np.zeros((t.size, len(joints), 6))
    for i in range(t.size):
        load_rows(compiled, data, states[i], t[i], coordinates[i])
        np.subtract.at(out[i], which, data.row["J"][row, slot] * lam[i, row, None])
    return out
