"""What MuJoCo says at the start: mass matrix and accelerations. The data stand there (`MujocoTwin.begin`)."""

from typing import Any

import numpy as np
import scipy.linalg

from validation.twins.base import Kinetic

REPEATED = 1e-10  # [1] singular values below this belong to rows that repeat others
RIGID = 1e-12  # [m or 1] rows below this are zero but for rounding: of bodies that other joints keep together
MOST_ROWS = 6  # of an equality, a weld


def mass_matrix(twin: Any) -> Kinetic:
    """In MuJoCo's velocities; those of welded pieces are brought together, what drives is left out."""
    mujoco, m, d, layout = twin.made.mujoco, twin.model, twin.data, twin.made.layout
    own, M = twin.own(), np.zeros((m.nv, m.nv))
    mujoco.mj_fullM(m, d, M)
    together = np.eye(int(own.sum()))
    if layout.extra:
        pieces = [jacobian(twin, m.body(piece.name).id) for piece in layout.extra]
        mains = [jacobian(twin, m.body(layout.main[id(piece.body)].name).id) for piece in layout.extra]
        apart = np.vstack(pieces) - np.vstack(mains)
        together = scipy.linalg.null_space(apart[:, own], rcond=1e-10)  # far above rounding, far below a freedom
    map_ = np.vstack([jacobian(twin, k) for k in twin.ids])[:, own] @ together
    return Kinetic(together.T @ M[np.ix_(own, own)] @ together, map_)


def jacobian(twin: Any, body: int) -> np.ndarray:
    """(6, nv): velocity of O and angular velocity of a MuJoCo body."""
    J = np.zeros((2, 3, twin.model.nv))
    twin.made.mujoco.mj_jacBody(twin.model, twin.data, J[0], J[1], body)
    return J.reshape(6, -1)


def start_accelerations(twin: Any) -> np.ndarray:
    """(bodies, 6): acceleration of O and world angular acceleration."""
    mujoco, m, d = twin.made.mujoco, twin.model, twin.data
    if d.nefc:
        harden(twin)
    mujoco.mj_rnePostConstraint(m, d)
    out, found = np.zeros(6), np.zeros((twin.ids.size, 6))
    for i, k in enumerate(twin.ids):
        mujoco.mj_objectAcceleration(m, d, mujoco.mjtObj.mjOBJ_XBODY, int(k), out, 0)
        found[i] = [*(out[3:] + m.opt.gravity), *out[:3]]  # it feels gravity as an accelerometer does
    return found


def harden(twin: Any) -> None:
    """The accelerations that MuJoCo's rows allow without their softness, by the principle of Gauss.

    (a - a0)' M (a - a0) is least under J a = -J_dot v, with MuJoCo's own M, J and free accelerations a0; its solver
    would know a to half the digits only, and J a up to R f. J_dot v is the fourth-order difference of J v along the
    motion.
    """
    m, d = twin.model, twin.data
    step = 1e-3 / max(1.0, np.abs(twin.qvel).max())
    near, far = (row_speeds(twin, h) - row_speeds(twin, -h) for h in (step, 2 * step))
    bias = (8 * near - far) / (12 * step)
    twin.begin()
    M, J = np.zeros((m.nv, m.nv)), np.zeros((d.nefc, m.nv))
    twin.made.mujoco.mj_fullM(m, d, M)
    for row, one in zip(J, np.eye(d.nefc), strict=True):
        twin.made.mujoco.mj_mulJacTVec(m, d, row, one)
    size = np.linalg.norm(J, axis=1)
    felt = size > RIGID * max(1.0, size.max())
    L = np.linalg.cholesky(M)
    G = scipy.linalg.solve_triangular(L, J[felt].T, lower=True).T
    size, wanted = np.linalg.norm(G, axis=1), -bias[places(d)][felt] - J[felt] @ d.qacc_smooth
    y = np.linalg.lstsq(G / size[:, None], wanted / size, rcond=REPEATED)[0]
    d.qacc[:] = d.qacc_smooth + scipy.linalg.solve_triangular(L, y, lower=True, trans="T")


def places(data: Any) -> tuple[np.ndarray, np.ndarray]:
    """Equality of every row, and which of its rows; MuJoCo leaves out those whose rows are all zero."""
    first = np.searchsorted(data.efc_id, data.efc_id)
    return data.efc_id.copy(), np.arange(data.nefc) - first


def row_speeds(twin: Any, time: float) -> np.ndarray:
    """(equalities, 6): J v where the velocities of the start lead in a time, with these velocities."""
    mujoco, m, d = twin.made.mujoco, twin.model, twin.data
    d.qpos[:] = twin.qpos
    mujoco.mj_integratePos(m, d.qpos, twin.qvel, time)
    mujoco.mj_fwdPosition(m, d)
    speed, table = np.zeros(d.nefc), np.zeros((m.neq, MOST_ROWS))
    mujoco.mj_mulJacVec(m, d, speed, twin.qvel)
    table[places(d)] = speed
    return table
