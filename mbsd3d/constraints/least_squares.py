"""Least-squares problems with sparse constraints, in time proportional to their size.

    min x'D x / 2 - f'x + |A x - b|^2 / (2 d):      [ D  A'   ] [ x ]   [ f ]
                                                    [ A  -d 1 ] [ p ] = [ b ]

d > 0 keeps the matrix regular where rows are redundant; rows that contradict each other are met in the sense of least
squares. For rows of order one, d = 1e-14 leaves singular values above 1e-5 exact to 1e-4 in one pass; further passes
with b - d p in the place of b take that away.
"""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from scipy.linalg.lapack import dgelsy as gelsy
from scipy.linalg.lapack import dgelsy_lwork as gelsy_size
from scipy.linalg.lapack import dgeqrf as geqrf
from scipy.linalg.lapack import dgetrf as getrf
from scipy.linalg.lapack import dgetrs as getrs
from scipy.linalg.lapack import dtrtri as trtri
from scipy.linalg.lapack import dtrtrs as trtrs
from scipy.sparse import coo_array, csc_array, csr_array, diags_array, eye_array, vstack
from scipy.sparse.linalg import splu

from ..base.errors import AssemblyError
from ..equations.jacobian import BlockRows, scaled

SMALL_SYSTEM_BODIES_MAX = 20  # [bodies] up to which dense matrices are faster than sparse ones
# [1] of the largest singular value: least value that proves itself; the inverse has a rounding of 1e-15 over this
SINGULAR_VALUE_RESOLUTION = 1e-6
Matrix: TypeAlias = np.ndarray | csr_array
# [1] of the largest entry: above rounding (1e-16 times the growth of a factorisation), below squares of small pivots
LEAST_SQUARES_DAMPING = 1e-14


def least(D: Matrix, A: Matrix, b: np.ndarray, f: np.ndarray | None = None, passes: int = 1) -> np.ndarray:
    """Return x (n,) of the problem above; D (n, n) and A (m, n), both dense or both sparse, with entries of order one.

    D is positive definite where A leaves x free. ``passes``: repeats that take the damping away. AssemblyError if the
    matrix is exactly singular.

    >>> from scipy.sparse import eye_array
    >>> twice = csr_array([[1.0, 1.0], [1.0, 1.0]])  # one row, twice
    >>> least(eye_array(2), twice, np.array([1.0, 1.0]), passes=2).round(12).tolist()
    [0.5, 0.5]
    """
    n, m = D.shape[0], A.shape[0]
    f = np.zeros(n) if f is None else f
    try:
        if not isinstance(A, np.ndarray):
            solve = sparse_factor(D, A)
        elif proven(A):
            solve = dense_factor(D, A)
        else:  # dense factors put large pivots before the damping, and lose it
            solve = splu(csc_array(damped(D, A))).solve
    except (RuntimeError, np.linalg.LinAlgError) as error:  # exactly singular
        raise AssemblyError(
            "the joints cannot be met: their equations are singular to the last digit",
            advice="masses, inertias or lengths differ by too many orders of magnitude; check the units",
        ) from error
    p = np.zeros(m)
    for _ in range(passes):
        x, p = np.split(solve(np.concatenate([f, b - LEAST_SQUARES_DAMPING * p])), [n])
    return x


def proven(A: np.ndarray, tolerance: float = 0.0) -> bool:
    """Return True if the rows of A (m, n) are certainly independent: A' = Q R, least singular value of A >= 1 / |R^-1|.

    That takes a third of the time of singular values.
    """
    m, n = A.shape
    if not m:
        return True
    inverse, zero = trtri(geqrf(A.T)[0][:m]) if m <= n else (A, 1)
    condition = np.linalg.norm(np.triu(inverse)) * np.linalg.norm(A)
    return bool(zero == 0 and 1.0 > max(tolerance, SINGULAR_VALUE_RESOLUTION) * condition)


def damped(D: np.ndarray, A: np.ndarray) -> np.ndarray:
    """Return the matrix above (n + m, n + m)."""
    n, m = D.shape[0], A.shape[0]
    whole = np.zeros((n + m, n + m), order="F")
    whole[:n, :n], whole[:n, n:], whole[n:, :n] = D, A.T, A
    np.fill_diagonal(whole[n:, n:], -LEAST_SQUARES_DAMPING)
    return whole


def dense_factor(D: np.ndarray, A: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Return a solver with the matrix above; raise a LinAlgError if it is singular."""
    factor, pivots, zero = getrf(damped(D, A), overwrite_a=True)
    if zero > 0:
        raise np.linalg.LinAlgError
    return lambda right: getrs(factor, pivots, right)[0]


def sparse_factor(D: csr_array, A: csr_array) -> Callable[[np.ndarray], np.ndarray]:
    """Return a solver with the matrix above; raise a RuntimeError if it is singular."""
    n, m = D.shape[0], A.shape[0]
    D, A, own = coo_array(D), coo_array(A), np.arange(n, n + m)
    data = np.concatenate([D.data, A.data, A.data, np.full(m, -LEAST_SQUARES_DAMPING)])
    i = np.concatenate([D.row, A.row + n, A.col, own])
    j = np.concatenate([D.col, A.col, A.row + n, own])
    return splu(csc_array((data, (i, j)), shape=(n + m, n + m))).solve


def deficient(A: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, int]:
    """Return x (n,) of least length with least |A x - b|, and the rank of A (m, n)."""
    m, n = A.shape
    if not (m and n):
        return np.zeros(n), 0
    right = np.zeros(max(m, n))
    right[:m] = b
    size = int(gelsy_size(m, n, 1, LEAST_SQUARES_DAMPING**0.5)[0])
    _, x, _, rank, _ = gelsy(A, right, np.zeros(n, np.int32), LEAST_SQUARES_DAMPING**0.5, size)
    return x[:n], int(rank)


def shortest(J: BlockRows, rows: np.ndarray, more: np.ndarray, columns: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return x (n,) of least length that meets A x = b in least squares; A = J times ``rows``, then ``more``.

    Columns are times ``columns``, so that entries are of order one. Dense for few bodies: setting up sparse matrices
    takes longer there than to solve.
    """
    if J.n < SMALL_SYSTEM_BODIES_MAX:
        return deficient(np.vstack([J.dense() * rows[:, None], more]) * columns, b)[0]
    A = scaled(J.sparse(), rows, columns)
    if more.shape[0]:
        A = vstack([A, csr_array(more * columns)], format="csr")
    return least(eye_array(columns.size), A, b)


def least_motion(
    J: BlockRows, rows: np.ndarray, more: np.ndarray, columns: np.ndarray, b: np.ndarray, B: BlockRows
) -> tuple[np.ndarray, int]:
    """Return x (n,) of least |B x| that meets A x = b as in `shortest`, and the rank of A, 0 where it is not computed.

    Entries of x whose column is 0 stay 0; B leaves none of the others free.
    """
    held = columns == 0.0
    if J.n < SMALL_SYSTEM_BODIES_MAX:
        A, W = np.vstack([J.dense() * rows[:, None], more]) * columns, B.dense()
        D = W.T @ W
        if held.any():
            D[held], D[:, held], D[held, held] = 0.0, 0.0, 1.0
        L = np.linalg.cholesky(D)
        y, rank = deficient(trtrs(L, A.T, lower=1)[0].T, b)
        return trtrs(L, y, lower=1, trans=1)[0], rank
    A, W = scaled(J.sparse(), rows, columns), scaled(B.sparse(), np.ones(B.body.shape[0]), (~held).astype(float))
    if more.shape[0]:
        A = vstack([A, csr_array(more * columns)], format="csr")
    return least(W.T @ W + diags_array(held.astype(float)), A, b), 0
