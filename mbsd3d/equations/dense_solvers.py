"""Dense saddle point of the textbook in numpy, beside the fast path that is tested to equal it.

    [ M(q)  J' ] [ v_dot ]   [ Q(q, v, z, t) - h(q, v) ]
    [ J     0  ] [  lam  ] = [ gamma(q, v, t)          ]

M is the block-diagonal matrix of the dense 6x6 blocks about the reference points, h the full velocity-quadratic term.
"""

from typing import NamedTuple

import numpy as np
import scipy.linalg
from scipy.sparse import bsr_array, csr_array, diags_array

from ..base.errors import InputError
from ..base.rotations import matrix, skew
from ..dynamics.applied_forces import loads
from ..dynamics.state_rates import accelerate
from ..kernels.layout import Data, Model
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from ..solver.saddle_point import SOLVED, factor
from .at_state import load_state
from .compiled import Compiled, compile_system
from .jacobian import RANK_TOLERANCE, BlockRows, block_rows, displacement_units
from .tree import build_spanning_tree


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


def mass_matrix_of(model: Model, data: Data, dense: bool) -> np.ndarray | csr_array:
    """Return the mass matrix (6 n, 6 n) at the pose that is loaded in ``data`` with its rows, dense or sparse.

    Blocks of the bodies about their reference points, and I j'j of reflected inertias, j the rates of coordinates.
    """
    n, body = model.body.size, model.body
    inertia = body["inertia"].reshape(n, 3, 3)
    blocks = inertia_about_origin(data.body["e"][:n], body["com"], body["mass"], inertia)
    held = reflected_rows(model, data)
    if dense:
        M, i = np.zeros((n, 6, n, 6)), np.arange(n)
        M[i, :, i] = blocks
        J = held.dense()
        return M.reshape(6 * n, 6 * n) + J.T @ (model.reflected["inertia"][:, None] * J)
    M = csr_array(bsr_array((blocks, np.arange(n), np.arange(n + 1)), shape=(6 * n, 6 * n)))
    J = held.sparse()
    return csr_array(M + J.T @ diags_array(model.reflected["inertia"]) @ J) if model.reflected.size else M


def reflected_rows(model: Model, data: Data) -> BlockRows:
    """Return the rates of the coordinates with a reflected inertia as rows of the velocities, from ``data``."""
    k = model.reflected.size
    body, J = np.full((k, 4), -1), np.zeros((k, 4, 6), data.reflected["J"].dtype)
    body[:, :2], J[:, :2] = model.reflected["body"], data.reflected["J"]
    return BlockRows(body, J, model.body.size)


class Terms(NamedTuple):
    """Terms of the equations at a state, dense, in world axes about the reference points."""

    M: np.ndarray  # (6 n, 6 n) mass matrix
    Q: np.ndarray  # (6 n,) applied forces and moments, gravity included
    h: np.ndarray  # (6 n,) velocity-quadratic term, on the left side
    J: np.ndarray  # (m, 6 n)
    gamma: np.ndarray  # (m,)


class DenseEquations:
    """Equations of a system, formed at one state after the other.

    Examples
    --------
    >>> from mbsd3d import Body, System
    >>> from mbsd3d.extend import DenseEquations
    >>> system = System([Body("stone", 2.0, (1, 2, 3), omega=(1, 1, 0), velocity=(0, 0, 0))])
    >>> terms = DenseEquations(system).at(system.state())
    >>> (terms.Q + 0.0).round(9).tolist(), terms.h.round(9).tolist()
    ([0.0, 0.0, -19.62, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    """

    def __init__(self, system: Mechanism) -> None:
        self.compiled = compile_system(system)
        self.data = self.compiled.data()
        bodies = system.bodies
        self.mass = np.array([body.mass for body in bodies])
        self.com, self.inertia = (np.array([getattr(body, x) for body in bodies]) for x in ("com", "inertia"))

    def at(self, state: State) -> Terms:
        """Return all terms at a state."""
        compiled, data, n = self.compiled, self.data, self.mass.size
        load_state(compiled, data, state)
        loads(compiled.model, data, state.t)
        if compiled.model.frictions:
            self.settle(state.t)
        Q = data.body["Q"][:n].reshape(6 * n).copy()
        J, gamma = block_rows(compiled.model, data).dense(), data.row["gamma"].copy()
        return Terms(self.mass_matrix(state), Q, self.quadratic_term(state), J, gamma)

    def settle(self, t: float) -> None:
        """Set Q with the friction that follows from the multipliers, for the rows and loads at hand."""
        model, data = self.compiled.model, self.data
        tree = build_spanning_tree(model, data)
        factor(model, data, tree)
        if accelerate(model, data, tree, t) != SOLVED:
            raise InputError(
                f"equations: at t = {t:g} s friction holds itself, or the equations have no solution; "
                "accelerations(system, state) says where"
            )

    def mass_matrix(self, state: State) -> np.ndarray:
        """Return the mass matrix (6 n, 6 n): blocks of the bodies, and I j'j of reflected inertias."""
        load_state(self.compiled, self.data, state)
        M = mass_matrix_of(self.compiled.model, self.data, dense=True)
        assert isinstance(M, np.ndarray)
        return M

    def quadratic_term(self, state: State) -> np.ndarray:
        """Return h (6 n,), per body (m w x (w x s), w x I_G w + m s x (w x (w x s))), and I (J_dot v) j."""
        load_state(self.compiled, self.data, state)
        model, held = self.compiled.model, self.data.reflected
        j = reflected_rows(model, self.data).dense()
        n = self.mass.size
        R, w = matrix(state.q.reshape(n, 7)[:, 3:]), state.v.reshape(n, 6)[:, 3:]
        s, spin = np.einsum("bij,bj->bi", R, self.com), np.einsum("bji,bj->bi", R, w)
        momentum = np.einsum("bij,bjk,bk->bi", R, self.inertia, spin)
        pull = self.mass[:, None] * np.cross(w, np.cross(w, s))
        h = np.hstack([pull, np.cross(w, momentum) + np.cross(s, pull)]).ravel()
        return h + j.T @ (model.reflected["inertia"] * held["bias"])


def mass_matrix(system: Mechanism, state: State) -> np.ndarray:
    """Return the dense reference-point mass matrix (6 n, 6 n)."""
    return DenseEquations(system).mass_matrix(state)


def equations(system: Mechanism, state: State) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, Compiled]:
    """Return (M, Q - h, J, gamma, compiled) at a state."""
    dense = DenseEquations(system)
    terms = dense.at(state)
    return terms.M, terms.Q - terms.h, terms.J, terms.gamma, dense.compiled


def saddle_matrix(M: np.ndarray, J: np.ndarray) -> np.ndarray:
    """Return the matrix [[M, J'], [J, 0]]."""
    return np.block([[M, J.T], [J, np.zeros((J.shape[0], J.shape[0]))]])


def solve_plain(system: Mechanism, state: State) -> tuple[np.ndarray, np.ndarray]:
    """Return (v_dot (6 n,), lam (m,)) from the dense matrix; LinAlgError if rows are redundant."""
    M, force, J, gamma, _ = equations(system, state)
    n = M.shape[0]
    x = np.linalg.solve(saddle_matrix(M, J), np.concatenate([force, gamma]))
    return x[:n], x[n:]


def solve_svd(system: Mechanism, state: State) -> tuple[np.ndarray, np.ndarray]:
    """Return (v_dot, lam) with the rank of J by its singular values; lam of least norm in the model's own units.

    J = U S V' (scaled): v_dot = V1 S^-1 U1' gamma + V2 y with V2' M v_dot = V2' (Q - h), and
    lam = U1 S^-1 V1' (Q - h - M v_dot).
    """
    M, force, J, gamma, compiled = equations(system, state)
    model = compiled.model
    rows, columns = model.row["scale"], displacement_units(model.length, model.body.size)
    U, s, Vt = scipy.linalg.svd(J * rows[:, None] * columns)
    rank = int((s > RANK_TOLERANCE * s[0]).sum()) if s.size else 0
    V1, V2 = columns[:, None] * Vt[:rank].T, columns[:, None] * Vt[rank:].T
    v_dot = V1 @ ((U[:, :rank].T @ (gamma * rows)) / s[:rank])
    if V2.shape[1]:
        v_dot = v_dot + V2 @ np.linalg.solve(V2.T @ M @ V2, V2.T @ (force - M @ v_dot))
    lam = U[:, :rank] @ ((V1.T @ (force - M @ v_dot)) / s[:rank])
    return v_dot, lam * rows
