"""Rank and null spaces of the rows of a mechanism, by singular values of what elimination leaves.

A relative tolerance decides, against the largest singular value. Small mechanisms are not reduced at all: their
singular values are those of J itself.
"""

from functools import cached_property

import numpy as np
import scipy.linalg

from ..base.concurrency import one_thread
from ..equations.jacobian import RANK_TOLERANCE, BlockRows, scaled_rows
from ..equations.tree import build_spanning_tree
from ..kernels.layout import Data, Model, Tree
from .elimination import PIVOT_SHARE_MIN, Core, Elimination
from .least_squares import proven

DENSE_ROWS_MAX = 150  # [rows] up to which one dense factorisation is faster than elimination along bodies

OPEN_TOLERANCE = 1e-7  # [1] of unit combinations of redundant rows: what rounding leaves of one that is zero


class Analysis:
    """Rank, independent rows, redundant combinations and free motions of scaled rows.

    Parameters
    ----------
    rows : BlockRows
        Scaled to units of the model's length and radians.
    tolerance : float
        Of the rank, relative to the largest singular value.
    safe : float
        Smallest relative size of what is decided without singular values; must exceed the tolerance.

    Raises
    ------
    ValueError
        If a row is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> on, J = np.array([[0, 1, -1, -1]] * 3), np.zeros((3, 4, 6))
    >>> J[:, 0, 0], J[:, 1, 0] = -1.0, (1.0, 1.0, 2.0)  # two bodies along x: one row twice, and another
    >>> found = Analysis(BlockRows(on, J, 2))
    >>> found.rank, np.abs(found.redundant()).round(3).ravel().tolist()
    (2, [0.707, 0.707, 0.0])
    """

    def __init__(
        self, rows: BlockRows, tolerance: float = RANK_TOLERANCE, safe: float = PIVOT_SHARE_MIN, **options: int
    ) -> None:
        self.n, self.m, self.tolerance = rows.n, rows.body.shape[0], tolerance
        with one_thread():
            self.left = Elimination(rows, tolerance, max(safe, 10.0 * tolerance), **options)
            self.cores = self.left.cores
            self.decompositions = [scipy.linalg.svd(core.F, check_finite=False) for core in self.cores]
        self.picked = np.concatenate([np.zeros(0, np.int64), *(step.picked for step in self.left.steps)])

    @cached_property
    def singular(self) -> np.ndarray:
        """Return the singular values of all cores, largest first."""
        return np.sort(np.concatenate([np.zeros(0), *(s for _, s, _ in self.decompositions)]))[::-1]

    @property
    def largest(self) -> float:
        """Return the largest singular value."""
        return float(self.singular[0]) if self.singular.size else 0.0

    def core_rank(self, core: int, tolerance: float | None = None) -> int:
        """Return the number of singular values of a core above the tolerance."""
        s = self.decompositions[core][1]
        return int((s > (tolerance or self.tolerance) * self.largest).sum())

    @property
    def rank(self) -> int:
        """Return the rank of the rows."""
        return self.picked.size + sum(self.core_rank(k) for k in range(len(self.cores)))

    @property
    def counted(self) -> np.ndarray:
        """Return the singular values that count, largest first."""
        return self.singular[self.singular > self.tolerance * self.largest]

    @property
    def least(self) -> float:
        """Return the smallest singular value that counts."""
        return float(self.counted[-1]) if self.counted.size else 0.0

    @property
    def smallest(self) -> float:
        """Return the smallest singular value over the largest; 1 if all was decided without singular values."""
        return self.least / self.largest if self.largest else 1.0

    def independent(self) -> np.ndarray:
        """Return a largest independent set of rows, ascending: those picked, and of the cores by pivoted QR."""
        chosen = [self.picked]
        for k, core in enumerate(self.cores):
            _, pivot = scipy.linalg.qr(core.F.T, mode="r", pivoting=True, check_finite=False)
            chosen.append(core.rows[pivot[: self.core_rank(k)]])
        return np.sort(np.concatenate(chosen)).astype(np.int64)

    def redundant(self, tolerance: float | None = None) -> np.ndarray:
        """Return (m, k) N with J'N = 0 in the columns, k the number of redundant rows; J as seen at the tolerance."""
        alone = self.left.redundant
        ranks = [self.core_rank(k, tolerance) for k in range(len(self.cores))]
        N = np.zeros((self.m, len(alone) + sum(core.rows.size for core in self.cores) - sum(ranks)))
        N[alone, np.arange(len(alone))] = 1.0
        j = len(alone)
        for core, rank, (U, _, _) in zip(self.cores, ranks, self.decompositions, strict=True):
            N[core.rows, j : j + core.rows.size - rank] = U[:, rank:]
            j += core.rows.size - rank
        return without_rounding(self.left.row_combinations(N)) if N.shape[1] else N

    def free_motion(self, weights: np.random.Generator) -> np.ndarray:
        """Return a random motion (6 n,) that all rows leave free; it does not depend on a basis."""
        x = np.zeros((6 * self.n, 1))
        x[self.left.free, 0] = weights.normal(size=self.left.free.size)
        for k, (core, (_, _, Vt)) in enumerate(zip(self.cores, self.decompositions, strict=True)):
            free = Vt[self.core_rank(k) :]
            x[core.columns, 0] = free.T @ (free @ weights.normal(size=free.shape[1]))
        return self.left.motion(x)[:, 0]

    def least_motion(self) -> np.ndarray:
        """Return the unit motion (6 n,) of a core that violates the rows least."""
        k = min(
            range(len(self.cores)), key=lambda k: self.decompositions[k][1][: self.core_rank(k)].min(initial=np.inf)
        )
        return self.core_motion(self.cores[k], self.decompositions[k][2][self.core_rank(k) - 1])

    def core_motion(self, core: Core, x: np.ndarray) -> np.ndarray:
        """Return the motion (6 n,) of all bodies that goes with one of a core; the picked rows are met."""
        whole = np.zeros((6 * self.n, 1))
        whole[core.columns, 0] = x
        return self.left.motion(whole)[:, 0]


def without_rounding(N: np.ndarray) -> np.ndarray:
    """Return combinations of order one with entries of rounding set to zero; N is as sparse as loops are."""
    return np.where(np.abs(N) > 1e-13, N, 0.0)


def surely_independent(rows: BlockRows, tolerance: float) -> bool:
    """Return True if a bound proves that few rows are independent; otherwise singular values decide."""
    if not 0 < rows.body.shape[0] <= min(6 * rows.n, DENSE_ROWS_MAX):
        return False
    with one_thread():
        return proven(rows.dense(), tolerance)


def redundant_combinations(rows: BlockRows, tolerance: float = RANK_TOLERANCE) -> np.ndarray:
    """Return (m, k) orthonormal N with J'N = 0: the left null space of the scaled rows."""
    if surely_independent(rows, tolerance):
        return np.zeros((rows.body.shape[0], 0))
    return orthonormal(Analysis(rows, tolerance).redundant())


def orthonormal(N: np.ndarray) -> np.ndarray:
    """Return an orthonormal basis of the same columns."""
    return scipy.linalg.qr(N, mode="economic")[0] if N.shape[1] else N


def projector(A: np.ndarray, tolerance: float) -> np.ndarray:
    """Return the projector (3, 3) onto the directions that the columns of A (3, k) do not have.

    >>> D = projector(np.array([[0.0, 0.0], [3.0, 6.0], [-4.0, -8.0]]), 1e-9)
    >>> (D @ (1.0, 4.0, 3.0) + D @ (0.0, 3.0, -4.0)).round(12).tolist()
    [1.0, 4.0, 3.0]
    """
    if np.abs(A).max(initial=0.0) <= tolerance:
        return np.eye(3)
    U, s, _ = np.linalg.svd(A, full_matrices=False)
    U = U[:, s > tolerance]
    return np.eye(3) - U @ U.T


def choose_rows(model: Model, data: Data, tolerance: float = RANK_TOLERANCE) -> np.ndarray:
    """Return a largest independent set of rows at the state in ``data``, ascending.

    For drivers that must determine everything, small motions, and parts as built.
    """
    rows = scaled_rows(model, data)
    if surely_independent(rows, tolerance):
        return np.arange(model.row.size)
    return Analysis(rows, tolerance).independent()


def tree_over_rows(model: Model, data: Data, tolerance: float) -> Tree:
    """Return the tree of the equations at the state in ``data``, over all rows; independent ones of parts as built.

    ``tolerance``: within which these may miss each other, in model lengths; 0 = they do not.
    """
    return build_spanning_tree(
        model, data, choose_rows(model, data, max(tolerance, RANK_TOLERANCE)) if tolerance else None
    )
