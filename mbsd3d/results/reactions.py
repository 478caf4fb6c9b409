"""Reactions: which are determined by the constraints, and the least-norm shares of those that are not.

With N the left null space of J (scaled), the multipliers are lam + N a for any a. A wrench G lam is unique if and
only if G N = 0; the share of least norm of the others is lam - N N' lam, which depends on the unit of length. Of parts
as built, N is that of the rows as the run saw them: what fits within the tolerance repeats other rows.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..base.style import Sampled
from ..constraints.rank import redundant_combinations, surely_independent
from ..equations.at_state import rows_at
from ..equations.compiled import Compiled
from ..equations.jacobian import RANK_TOLERANCE, BlockRows, displacement_units, islands
from .record import Record


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
    slip: float  # largest entry of J'N: rounding, or what parts as built miss each other by


class MiddleRows(NamedTuple):
    """The rows at the middle sample, where no special start position hides the general rank."""

    open: list[Open]
    place: np.ndarray  # (rows,) of each row in the list, -1 where nothing is open
    J: np.ndarray  # (rows, 4, 6) blocks per slot
    tolerance: float  # of the rank


def open_shares(rows: BlockRows, tolerance: float) -> list[Open]:
    """What scaled rows leave open, island by island: a null space of all rows would grow with the cube of a system."""
    if surely_independent(rows, tolerance):
        return []
    found = ((own, redundant_combinations(rows.alone(own), tolerance)) for own in islands(rows))
    return [Open(own, N, np.abs(rows.take(own).sparse().T @ N).max()) for own, N in found if N.shape[1]]


def middle_rows(
    compiled: Compiled, t: np.ndarray, states: np.ndarray, coordinates: np.ndarray, record: Record
) -> MiddleRows:
    """Rows of a run, for `unique_wrench` and `minimum_norm`; nothing is open where the run left out no row."""
    data, k, tolerance = compiled.data(), t.size // 2, max(RANK_TOLERANCE, record.tolerance)
    place = np.full(compiled.model.row.size, -1)
    if not place.size or not t.size or record.rows_left_out == 0:
        return MiddleRows([], place, data.row["J"], tolerance)
    found = open_shares(rows_at(compiled, data, t[k], states[k], coordinates[k]), tolerance)
    for i, island in enumerate(found):
        place[island.rows] = i
    return MiddleRows(found, place, data.row["J"], tolerance)


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
        if np.abs(G[mine].T @ middle.open[i].N[theirs]).max() >= max(1e-7, 10.0 * middle.open[i].slip):
            return False
    return True


def minimum_norm(
    compiled: Compiled, middle: MiddleRows, t: np.ndarray, states: np.ndarray, coordinates: np.ndarray, lam: np.ndarray
) -> np.ndarray:
    """Multipliers of least norm in the model's own units that give the same forces."""
    if not middle.open:
        return lam
    data, scale, shared = compiled.data(), compiled.model.row["scale"], lam.copy()
    for k in range(t.size):
        for own, N, _ in open_shares(rows_at(compiled, data, t[k], states[k], coordinates[k]), middle.tolerance):
            mu = lam[k, own] / scale[own]
            shared[k, own] = (mu - N @ (N.T @ mu)) * scale[own]
    return shared
