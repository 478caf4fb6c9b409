"""Dense reference-point mass matrix, body by body."""

import numpy as np
from scipy.sparse import bsr_array, csr_array

from ..base.quaternions import skew
from ..base.rotations import matrix
from ..kernels.layout import Model
from ..mechanism.state import State


def inertia_about_origin(e: np.ndarray, com: np.ndarray, mass: float | np.ndarray, inertia: np.ndarray) -> np.ndarray:
    """Return the 6x6 block M_b = [[m 1, -m [s]x], [m [s]x, I_O]] or a stack; I_O = R I_G R' + m [s]x[s]x'."""
    R, m = matrix(e), np.asarray(mass)[..., None, None]
    S = skew(np.einsum("...ij,...j->...i", R, com))
    block = np.empty((*R.shape[:-2], 6, 6))
    block[..., :3, :3] = m * np.eye(3)
    block[..., :3, 3:] = -m * S
    block[..., 3:, :3] = m * S
    block[..., 3:, 3:] = R @ inertia @ R.swapaxes(-1, -2) + m * S @ S.swapaxes(-1, -2)
    return block


def mass_matrix_of(model: Model, pose: State, dense: bool) -> np.ndarray | csr_array:
    """Return the block diagonal (6 n, 6 n) of the reference-point mass matrices, dense or sparse."""
    n, body = model.body.size, model.body
    inertia = body["inertia"].reshape(n, 3, 3)
    blocks = inertia_about_origin(pose.q.reshape(n, 7)[:, 3:], body["com"], body["mass"], inertia)
    if dense:
        M, i = np.zeros((n, 6, n, 6)), np.arange(n)
        M[i, :, i] = blocks
        return M.reshape(6 * n, 6 * n)
    return csr_array(bsr_array((blocks, np.arange(n), np.arange(n + 1)), shape=(6 * n, 6 * n)))
