"""Reactions: which are determined by the constraints, and the least-norm shares of those that are not.

With N the left null space of J (scaled), the multipliers are lam + N a for any a. A wrench G lam is unique if and
only if G N = 0; the share of least norm of the others is lam - N N' lam, which depends on the unit of length.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .blocks import displacement_units
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
