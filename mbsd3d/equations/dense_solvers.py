"""The readable truth: the saddle point of the textbook, dense, in numpy, next to the fast path that is tested equal.

    [ M(q)  J' ] [ v_dot ]   [ Q(q, v, z, t) - h(q, v) ]
    [ J     0  ] [  lam  ] = [ gamma(q, v, t)          ]

M is the block-diagonal matrix of the dense 6x6 blocks about the reference points, h the full velocity-quadratic term.
"""

import numpy as np
import scipy.linalg

from ..base.rotations import matrix
from ..dynamics.loads import loads
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from .at_state import load_state
from .compiled import Compiled, compile_system
from .jacobian import RANK_TOLERANCE, block_rows, displacement_units
from .mass_matrix import sparse_mass_matrix


def mass_matrix(system: Mechanism, state: State) -> np.ndarray:
    """(6 n, 6 n) dense reference-point mass matrix."""
    return sparse_mass_matrix(system, state).toarray()


def quadratic_term(system: Mechanism, state: State) -> np.ndarray:
    """(6 n,) h: per body (m w x (w x s), w x I_G w + m s x (w x (w x s))), on the left side of the equations."""
    h = []
    for i, body in enumerate(system.bodies):
        R, w = matrix(state.q[7 * i + 3 : 7 * i + 7]), state.v[6 * i + 3 : 6 * i + 6]
        s = R @ body.com
        pull = body.mass * np.cross(w, np.cross(w, s))
        h += [pull, np.cross(w, R @ body.inertia @ R.T @ w) + np.cross(s, pull)]
    return np.concatenate(h)


def equations(system: Mechanism, state: State) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, Compiled]:
    """(M, Q - h, J, gamma, compiled) at a state."""
    compiled = compile_system(system)
    data, n = compiled.data(), len(system.bodies)
    load_state(compiled, data, state)
    loads(compiled.model, data, state.t)
    force = data.body["Q"][:n].reshape(6 * n) - quadratic_term(system, state)
    J, gamma = block_rows(compiled.model, data).dense(), data.row["gamma"].copy()
    return mass_matrix(system, state), force, J, gamma, compiled


def solve_plain(system: Mechanism, state: State) -> tuple[np.ndarray, np.ndarray]:
    """(v_dot (6 n,), lam (m,)) from the dense matrix, for independent rows; LinAlgError if some are redundant: see
    `solve_svd`.
    """
    M, force, J, gamma, _ = equations(system, state)
    n, m = M.shape[0], J.shape[0]
    K = np.block([[M, J.T], [J, np.zeros((m, m))]])
    x = np.linalg.solve(K, np.concatenate([force, gamma]))
    return x[:n], x[n:]


def solve_svd(system: Mechanism, state: State, tolerance: float = RANK_TOLERANCE) -> tuple[np.ndarray, np.ndarray]:
    """(v_dot, lam) with the rank of J revealed by its singular values; lam of least norm in the model's own units.

    J = U S V' (scaled): v_dot = V1 S^-1 U1' gamma + V2 y with V2' M v_dot = V2' (Q - h), and
    lam = U1 S^-1 V1' (Q - h - M v_dot).
    """
    M, force, J, gamma, compiled = equations(system, state)
    model = compiled.model
    rows, columns = model.row["scale"], displacement_units(model.length, model.body.size)
    U, s, Vt = scipy.linalg.svd(J * rows[:, None] * columns)
    rank = int((s > tolerance * s[0]).sum()) if s.size else 0
    V1, V2 = columns[:, None] * Vt[:rank].T, columns[:, None] * Vt[rank:].T
    v_dot = V1 @ ((U[:, :rank].T @ (gamma * rows)) / s[:rank])
    if V2.shape[1]:
        v_dot = v_dot + V2 @ np.linalg.solve(V2.T @ M @ V2, V2.T @ (force - M @ v_dot))
    lam = U[:, :rank] @ ((V1.T @ (force - M @ v_dot)) / s[:rank])
    return v_dot, lam * rows
