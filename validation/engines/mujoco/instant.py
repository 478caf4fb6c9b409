"""What MuJoCo says at the start: mass matrix and accelerations. The data stand there (`MujocoTwin.begin`)."""

from typing import Any

import numpy as np
import scipy.linalg

from ..base import Kinetic

SWEEPS, STILL = 200, 1e-13  # at most; [1] last change of the accelerations, a little over rounding


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
    """The accelerations that the rows allow without softness, J v_dot = -J_dot v, by MuJoCo's own solver.

    It solves J v_dot + R f = a_ref; with a_ref = R f - J_dot v of the last f this is a proximal iteration that ends at
    R f on both sides. J_dot v is the fourth-order difference of J v along the motion.
    """
    mujoco, m, d = twin.made.mujoco, twin.model, twin.data
    step, speeds = 1e-3 / max(1.0, np.abs(twin.qvel).max()), []
    for k in (-2, -1, 1, 2):
        d.qpos[:] = twin.qpos
        mujoco.mj_integratePos(m, d.qpos, twin.qvel, k * step)
        mujoco.mj_fwdPosition(m, d)
        speed = np.zeros(d.nefc)
        mujoco.mj_mulJacVec(m, d, speed, twin.qvel)
        speeds.append(speed)
    bias = (8 * (speeds[2] - speeds[1]) - (speeds[3] - speeds[0])) / (12 * step)
    twin.begin()
    force, before = np.zeros(d.nefc), np.full(m.nv, np.inf)
    for _ in range(SWEEPS):
        d.efc_aref[:] = d.efc_R * force - bias
        mujoco.mj_fwdConstraint(m, d)
        force = d.efc_force.copy()
        if np.abs(d.qacc - before).max() <= STILL * np.abs(d.qacc).max():
            break
        before = d.qacc.copy()
