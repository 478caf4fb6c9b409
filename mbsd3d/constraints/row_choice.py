"""A largest set of independent rows: for drivers that must determine everything, small motions, and parts as built.

Rank is decided by the singular values of the scaled J (columns: displacements in units of the model's length, rotations
in radians), of which the bodies have been eliminated that need no such decision (`mbsd3d.constraints.elimination`).
"""

import numpy as np
import scipy.linalg

from ..base.concurrency import one_thread
from ..equations.jacobian import RANK_TOLERANCE, scaled_rows
from ..kernels.layout import Data, Model
from .rank import Analysis, surely_independent


def independent_rows(A: np.ndarray) -> tuple[np.ndarray, float]:
    """(indices of a largest independent set of rows of A, smallest kept singular value relative to the largest).

    The readable truth: column-pivoted QR of A', its singular values as the authority on the rank, cost cubic.
    """
    if not A.size or not A.any():
        return np.zeros(0, np.int64), 1.0
    with one_thread():
        _, pivot = scipy.linalg.qr(A.T, mode="r", pivoting=True)
        singular = scipy.linalg.svdvals(A)
    rank = int((singular > RANK_TOLERANCE * singular[0]).sum())
    return np.sort(pivot[:rank]).astype(np.int64), float(singular[rank - 1] / singular[0])


def choose_rows(model: Model, data: Data, tolerance: float = RANK_TOLERANCE) -> np.ndarray:
    """A largest independent set of rows at the state in ``data``, ascending."""
    rows = scaled_rows(model, data)
    if surely_independent(rows, tolerance):
        return np.arange(model.row.size)
    return Analysis(rows, tolerance).independent()
