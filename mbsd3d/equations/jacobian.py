"""Sparse Jacobian by its blocks: rows that touch up to four bodies, six columns each."""

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from ..kernels.layout import Data, Model

RANK_TOLERANCE = 1e-10  # relative; must exceed the drift, else drift makes a redundant row look independent


def displacement_units(length: float, n: int) -> np.ndarray:
    """Return the units (6 n,) in which displacements and rotations of n bodies are of order one [m, rad]."""
    return np.tile(np.repeat([length, 1.0], 3), n)


class BlockRows(NamedTuple):
    """Rows of a Jacobian by blocks: row i has ``J[i, slot]`` in the columns of ``body[i, slot]``."""

    body: np.ndarray  # (m, 4); outside 0 ... n - 1: the ground, or unused
    J: np.ndarray  # (m, 4, 6)
    n: int

    def take(self, rows: np.ndarray | slice) -> "BlockRows":
        """Return some of the rows."""
        return BlockRows(self.body[rows], self.J[rows], self.n)

    def alone(self, rows: np.ndarray) -> "BlockRows":
        """Return some of the rows, and of the bodies those that they touch."""
        body, J = self.body[rows], self.J[rows]
        on = (body >= 0) & (body < self.n)
        bodies, numbers = np.unique(body[on], return_inverse=True)
        renumbered = np.full_like(body, -1)
        renumbered[on] = numbers
        return BlockRows(renumbered, J, bodies.size)

    def scaled(self, rows: np.ndarray, length: float) -> "BlockRows":
        """Return rows times ``rows``, columns in units of ``length`` and radians."""
        columns = displacement_units(length, 1)
        return self._replace(J=self.J * (np.asarray(rows)[:, None, None] * columns))

    def dense(self) -> np.ndarray:
        """Return the matrix (m, 6 n), for few rows faster than by `sparse`."""
        m = self.body.shape[0]
        A, i = np.zeros((m, self.n + 1, 6), self.J.dtype), np.arange(m)
        on = np.where(self.body < 0, self.n, self.body)
        for slot in np.flatnonzero((on < self.n).any(axis=0)):  # every row once per slot: no pair comes twice
            A[i, on[:, slot]] += self.J[:, slot]
        return A[:, : self.n].reshape(m, 6 * self.n)

    def times(self, v: np.ndarray) -> np.ndarray:
        """Return the product (m,) with velocities v (6 n,)."""
        each = np.concatenate((v, np.zeros(6))).reshape(-1, 6)  # the ground last
        on = np.where(self.body < 0, self.n, self.body)
        return np.einsum("isj,isj->i", self.J, each[on])

    def sparse(self) -> csr_array:
        """Return the sparse matrix (m, 6 n)."""
        i, slot = np.nonzero((self.body >= 0) & (self.body < self.n))
        columns = 6 * self.body[i, slot][:, None] + np.arange(6)
        at = (np.repeat(i, 6), columns.ravel())
        return csr_array((self.J[i, slot].ravel(), at), shape=(self.body.shape[0], 6 * self.n))


def islands(rows: BlockRows) -> list[np.ndarray]:
    """Return sets of rows that share no body with each other, each ascending."""
    m = rows.body.shape[0]
    i, slot = np.nonzero((rows.body >= 0) & (rows.body < rows.n))
    graph = coo_array((np.ones(i.size), (i, m + rows.body[i, slot])), shape=(m + rows.n,) * 2)
    labels = connected_components(graph, directed=False)[1][:m]
    order = np.argsort(labels, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(labels[order])) + 1) if m else []


def scaled(A: np.ndarray | csr_array, rows: np.ndarray, columns: np.ndarray) -> np.ndarray | csr_array:
    """Return rows and columns of a matrix times factors."""
    if isinstance(A, np.ndarray):
        return A * rows[:, None] * columns
    data = A.data * np.repeat(rows, np.diff(A.indptr)) * columns[A.indices]
    return csr_array((data, A.indices, A.indptr), shape=A.shape)


def largest_in_rows(A: np.ndarray | csr_array) -> np.ndarray:
    """Return the largest absolute entry of every row, 0 for an empty one."""
    if isinstance(A, np.ndarray):
        return np.abs(A).max(axis=1, initial=0.0)
    largest = np.zeros(A.shape[0])
    np.maximum.at(largest, np.repeat(np.arange(A.shape[0]), np.diff(A.indptr)), np.abs(A.data))
    return largest


def block_rows(model: Model, data: Data) -> BlockRows:
    """Return J by its blocks in ``data``, not scaled."""
    return BlockRows(model.row["body"], data.row["J"], model.body.size)


def scaled_rows(model: Model, data: Data) -> BlockRows:
    """Return J by its blocks in units of the model's length and radians: entries are of order one."""
    return block_rows(model, data).scaled(model.row["scale"], model.length)
