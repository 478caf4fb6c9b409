"""Reactions: which are determined by the constraints, and the least-norm shares of those that are not.

With N the left null space of J (scaled), the multipliers are lam + N a for any a. A wrench G lam is unique if and
only if G N = 0; the share of least norm of the others is lam - N N' lam, which depends on the unit of length.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from .evaluation import rows_at
from .model import Compiled
from .rank import redundant_combinations


@dataclass(frozen=True)
class Reaction:
    """Wrench on body b at the joint's point, world axes; all (samples, 3) in N, N m, m."""

    force: np.ndarray
    moment: np.ndarray
    point: np.ndarray
    unique: bool


def may_be_redundant(compiled: Compiled, data: Any, t: np.ndarray, states: np.ndarray) -> np.ndarray:
    """Left null space at the middle sample, where no special start position hides the general rank."""
    k = t.size // 2
    return redundant_combinations(rows_at(compiled, data, t[k], states[k]))


def unique_wrench(compiled: Compiled, t: np.ndarray, states: np.ndarray, parts: list) -> bool:
    """True if the summed wrench of the joints' rows on their body b is determined by the constraints."""
    if not compiled.model.row.size or not t.size:
        return True
    data = compiled.data()
    N = may_be_redundant(compiled, data, t, states)
    if not N.shape[1]:
        return True
    model, G = compiled.model, np.zeros((6, compiled.model.row.size))
    body = compiled.body_index[id(parts[0].b)]
    for part in parts:
        span = compiled.rows[id(part)]
        for k in range(span.start, span.stop):
            for slot in range(4):
                if model.row["body"][k, slot] == body:
                    G[:, k] += data.row["J"][k, slot] * model.row["scale"][k] * np.repeat([model.length, 1.0], 3)
    return bool(np.abs(G @ N).max() < 1e-7)


def minimum_norm(compiled: Compiled, t: np.ndarray, states: np.ndarray, lam: np.ndarray) -> np.ndarray:
    """Multipliers of least norm in the model's own units that give the same forces."""
    data = compiled.data()
    if not lam.shape[1] or not t.size or not may_be_redundant(compiled, data, t, states).shape[1]:
        return lam
    scale, shared = compiled.model.row["scale"], np.empty_like(lam)
    for k in range(t.size):
        N = redundant_combinations(rows_at(compiled, data, t[k], states[k]))
        mu = lam[k] / scale
        shared[k] = (mu - N @ (N.T @ mu)) * scale
    return shared
