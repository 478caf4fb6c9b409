"""Reduction of a large sparse Jacobian: bodies are eliminated until the rest is small enough for an SVD.

Rows F = [F_b F_o] act on body b and on others. Of the rows, those with well independent parts on b are picked:

    F_pb Q = [L 0],  x_b = Q y,  L y_1 = -F_po x_o,      C = F_qb Q_1 L^-1,  F_q <- F_q - C F_p

so rank F = |p| + rank of the rest, with real rows p. A body at the end of a chain takes its joint along: rows of a
tree of joints are independent by construction. A body between two joints leaves the joint they amount to in series,
and a closed loop leaves rows without bodies: redundant ones. A part on b that is neither large nor zero decides
nothing here: its rows and columns stay in the core, for the singular values. Fewest neighbours first, so the cost is
proportional to the number of bodies for chains, trees and ladders of loops.
"""

import heapq
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy.linalg

from ..base.errors import InputError
from ..equations.compiled import Compiled
from ..equations.jacobian import BlockRows
from ..equations.tree import Groups

PIVOT_SHARE_MIN = 1e-3  # [1] of the row: least part of a pivot row on its body; bounds the growth of the remaining rows
DENSE_CORE_ROWS = 64  # [rows] left for a dense decomposition; one of this size takes a millisecond


class Part(NamedTuple):
    """Rows that act on the same bodies: F has the present columns of these bodies side by side."""

    rows: np.ndarray  # (k,)
    bodies: list[int]
    F: np.ndarray  # (k, columns)


@dataclass(frozen=True)
class Repeat:
    """Change that takes C times the rows ``picked`` out of the rows ``rest``."""

    picked: np.ndarray
    rest: np.ndarray
    C: np.ndarray  # (rest, picked)


@dataclass(frozen=True)
class Step(Repeat):
    """One eliminated body."""

    columns: np.ndarray  # its columns: y_1 stands in the first of them, y_2 in the others
    others: np.ndarray  # columns of F
    Q: np.ndarray
    L: np.ndarray
    F: np.ndarray  # (picked, others)


@dataclass(frozen=True)
class Core:
    """Dense rows that remain of one connected set of bodies."""

    rows: np.ndarray
    columns: np.ndarray
    F: np.ndarray


class Elimination:
    """Elimination of bodies one by one; ``changes``, ``cores`` and ``redundant`` rows are the outcome."""

    def __init__(
        self, rows: BlockRows, tolerance: float, safe: float = PIVOT_SHARE_MIN, core_rows: int = DENSE_CORE_ROWS
    ) -> None:
        self.n, self.m = rows.n, rows.body.shape[0]
        self.size = np.sqrt((rows.J.real**2).sum(axis=(1, 2)))
        if not np.isfinite(self.size).all():
            k = int(np.flatnonzero(~np.isfinite(self.size))[0])
            raise InputError(f"rank: row {k} of the Jacobian is not finite; correct the geometry of its joint")
        self.zero, self.safe = tolerance * self.size.max(initial=0.0), safe
        self.columns = [np.arange(6 * b, 6 * b + 6) for b in range(self.n)]
        self.parts: dict[int, Part] = {}
        self.on: list[set[int]] = [set() for _ in range(self.n)]  # parts on each body
        self.changes: list[Repeat] = []
        self.redundant: list[int] = []
        self.made = self.left = 0  # parts so far; rows in the present ones
        for part in parts_of(rows) if self.m > core_rows else [whole(rows)]:
            self.add(part)
        self.run(core_rows)
        self.cores = self.connected()
        self.free = self.free_columns()

    def free_columns(self) -> np.ndarray:
        """Return the columns that no row touches any more."""
        used = np.zeros(6 * self.n, bool)
        for step in self.steps:
            used[step.columns[: step.picked.size]] = True
        for core in self.cores:
            used[core.columns] = True
        return np.flatnonzero(~used)

    @property
    def steps(self) -> list[Step]:
        """Return the changes that eliminated bodies."""
        return [change for change in self.changes if isinstance(change, Step)]

    def add(self, part: Part) -> None:
        """Add rows; those that vanish are redundant."""
        large = np.abs(part.F).max(axis=1, initial=0.0) > self.zero if part.bodies else np.zeros(part.rows.size, bool)
        self.redundant += part.rows[~large].tolist()
        if not large.any():
            return
        key = self.made = self.made + 1
        self.parts[key] = Part(part.rows[large], part.bodies, part.F[large])
        self.left += int(large.sum())
        for b in part.bodies:
            self.on[b].add(key)

    def pivoted(self, rows: np.ndarray, F: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return (p, q, Q, L): rows p of F, well independent, and the others; F_p Q = [L 0]."""
        Q, R, pivot = scipy.linalg.qr((F / self.size[rows][:, None]).T, pivoting=True, check_finite=False)
        r = int((np.abs(np.diag(R)) > self.safe).sum())
        p, q = pivot[:r], np.sort(pivot[r:])
        return p, q, Q, R[:r, :r].T * self.size[rows[p]][:, None]

    def without_repeats(self, part: Part) -> Part:
        """Set rows that are combinations of others to zero, so that parts do not grow."""
        if part.rows.size <= part.F.shape[1] or not part.bodies:
            return part
        p, q, Q, L = self.pivoted(part.rows, part.F)
        C = np.linalg.solve(L.T, (part.F[q] @ Q[:, : p.size]).T).T
        rest = part.F[q] - C @ part.F[p]
        zero = np.abs(rest).max(axis=1) <= self.zero
        self.changes.append(Repeat(part.rows[p], part.rows[q[zero]], C[zero]))
        part.F[q[zero]] = 0.0
        return part

    def neighbours(self, b: int) -> int:
        """Return the number of other bodies that share rows with b."""
        return len({c for key in self.on[b] for c in self.parts[key].bodies}) - 1

    def run(self, core_rows: int) -> None:
        """Eliminate bodies, fewest neighbours first, until few rows are left."""
        queue = [(self.neighbours(b), b) for b in range(self.n) if self.on[b]]
        heapq.heapify(queue)
        done = set()
        while queue and self.left > core_rows:
            degree, b = heapq.heappop(queue)
            if b in done or not self.on[b]:
                continue
            if degree != self.neighbours(b):
                heapq.heappush(queue, (self.neighbours(b), b))
                continue
            done.add(b)
            for c in self.eliminate(b):
                if c not in done:
                    heapq.heappush(queue, (self.neighbours(c), c))

    def merged(self, keys: set[int], first: list[int]) -> Part:
        """Take parts out and put them side by side, the columns of ``first`` in front."""
        parts = [self.parts.pop(key) for key in sorted(keys)]
        others = sorted({b for part in parts for b in part.bodies} - set(first))
        bodies = [*first, *others]
        place = dict(zip(bodies, np.cumsum([0, *(self.columns[b].size for b in bodies)]), strict=False))
        F = np.zeros((sum(part.rows.size for part in parts), sum(self.columns[b].size for b in bodies)))
        top = 0
        for key, part in zip(sorted(keys), parts, strict=True):
            i, left = slice(top, top + part.rows.size), 0
            for b in part.bodies:
                width = self.columns[b].size
                F[i, place[b] : place[b] + width] += part.F[:, left : left + width]
                left += width
                self.on[b].discard(key)
            top = i.stop
        self.left -= top
        return Part(np.concatenate([part.rows for part in parts]), bodies, F)

    def eliminate(self, b: int) -> list[int]:
        """Pick rows for body b, take them out of the others, and return the bodies that shared rows with it."""
        rows, bodies, F = self.merged(set(self.on[b]), [b])
        columns, others = self.columns[b], bodies[1:]
        w = columns.size
        p, q, Q, L = self.pivoted(rows, F[:, :w])
        r, G = p.size, F[q, :w] @ Q
        C = np.linalg.solve(L.T, G[:, :r].T).T
        rest = F[q, w:] - C @ F[p, w:]
        undecided = np.abs(G[:, r:]).max(initial=0.0) > self.zero
        ids = np.concatenate([np.zeros(0, np.int64), *(self.columns[c] for c in others)])
        self.changes.append(Step(rows[p], rows[q], C, columns, ids, Q, L, F[p, w:]))
        self.columns[b] = columns[r:]
        if undecided:
            others, rest = [*others, b], np.hstack([rest, G[:, r:]])
        if q.size:
            self.add(self.without_repeats(Part(rows[q], others, rest)))
        return others

    def connected(self) -> list[Core]:
        """Return the remaining rows by connected sets of bodies, rows ascending."""
        found = []
        while self.parts:
            reached, queue = set(), [min(self.parts)]
            while queue:
                key = queue.pop()
                if key not in reached:
                    reached.add(key)
                    queue += [other for b in self.parts[key].bodies for other in self.on[b]]
            rows, bodies, F = self.merged(reached, [])
            order = np.argsort(rows)
            found.append(Core(rows[order], np.concatenate([self.columns[b] for b in bodies]), F[order]))
        return found

    def row_combinations(self, N: np.ndarray) -> np.ndarray:
        """Turn combinations of the remaining rows into combinations of all rows, in place; (m, k)."""
        for change in reversed(self.changes):
            N[change.picked] -= change.C.T @ N[change.rest]
        return N

    def motion(self, x: np.ndarray) -> np.ndarray:
        """Turn the motion of core and free columns into the motion of all bodies, in place; (6 n, k)."""
        for step in reversed(self.steps):
            r = step.picked.size
            if r:
                x[step.columns[:r]] = -np.linalg.solve(step.L, step.F @ x[step.others])
            x[step.columns] = step.Q @ x[step.columns]
        return x


def whole(rows: BlockRows) -> Part:
    """Return all rows as one part; few rows are not worth taking apart."""
    bodies = np.unique(rows.body[(rows.body >= 0) & (rows.body < rows.n)])
    columns = (6 * bodies[:, None] + np.arange(6)).ravel()
    return Part(np.arange(rows.body.shape[0]), bodies.tolist(), rows.dense().real[:, columns])


def parts_of(rows: BlockRows) -> list[Part]:
    """Return neighbouring rows on the same bodies as parts."""
    ends = np.flatnonzero((np.diff(rows.body, axis=0) != 0).any(axis=1)) + 1
    found = []
    for i in np.split(np.arange(rows.body.shape[0]), ends) if rows.body.size else []:
        slots = rows.body[i[0]] if i.size else []
        bodies = list(dict.fromkeys(int(b) for b in slots if 0 <= b < rows.n))
        F = np.zeros((i.size, 6 * len(bodies)))
        for slot, b in enumerate(slots):
            if 0 <= b < rows.n:
                k = 6 * bodies.index(b)
                F[:, k : k + 6] += rows.J[i, slot].real
        found.append(Part(i, bodies, F))
    return found


def loop_weights(compiled: Compiled) -> np.ndarray:
    """Return 1 for the rows of a spanning tree of joints, 1e-4 for those that close loops."""
    weights, trees = np.ones(compiled.model.row.size), Groups(compiled.model.body.size + 1)
    for joint in compiled.system.joints:
        first, *others = (compiled.body_index[id(body)] for body in joint.bodies())
        if not any([trees.merge(first, other) for other in others]):
            weights[compiled.rows[id(joint)]] = 1e-4
    return weights
