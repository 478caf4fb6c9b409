"""A largest set of independent rows: for drivers that must determine everything, small motions, and parts as built.

Rank is decided by the singular values of the scaled J (columns: displacements in units of the model's length, rotations
in radians), of which the bodies have been eliminated that need no such decision (`mbsd3d.constraints.elimination`).
"""

import numpy as np

from ..equations.elimination import eliminate
from ..equations.jacobian import RANK_TOLERANCE, scaled_rows
from ..kernels.layout import Data, Model, Tree
from .rank import Analysis, surely_independent


def choose_rows(model: Model, data: Data, tolerance: float = RANK_TOLERANCE) -> np.ndarray:
    """A largest independent set of rows at the state in ``data``, ascending."""
    rows = scaled_rows(model, data)
    if surely_independent(rows, tolerance):
        return np.arange(model.row.size)
    return Analysis(rows, tolerance).independent()


def tree_over_rows(model: Model, data: Data, tolerance: float) -> Tree:
    """The tree of the equations at the state in ``data``, over all rows; over independent ones of parts as built.

    ``tolerance``: within which these may miss each other, in model lengths; 0 = they do not.
    """
    return eliminate(model, data, choose_rows(model, data, max(tolerance, RANK_TOLERANCE)) if tolerance else None)
