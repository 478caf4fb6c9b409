"""Initial state: coordinates and velocities of MuJoCo from a state of mbsd3d, its mass matrix and its accelerations."""

from typing import Any

import numpy as np
import scipy.linalg

from mbsd3d import Distance, Joint, State
from mbsd3d.errors import InputError
from mbsd3d.extend import (
    Piece,
    driven_coordinates,
    key_of,
    local_axes,
    matrix,
    quaternion_from_matrix,
    rod_ends,
)
from validation.twins.base import Kinetic
from validation.twins.mujoco import rods
from validation.twins.mujoco.build import Sketch

JOINT_MISFIT_MAX = 1e-7  # [1] of its size: a state that its joints miss by more is not on the tree of MuJoCo


def coordinates(made: Sketch, model: Any, state: State) -> np.ndarray:
    """Return qpos of a state; angles are counted as the state counts them."""
    qpos, q = model.qpos0.copy(), state.q.reshape(-1, 7)
    index = {id(body): i for i, body in enumerate(made.system.bodies)}

    def pose(body: Any) -> tuple[np.ndarray, np.ndarray]:
        i = index.get(id(body))
        return (np.zeros(3), np.eye(3)) if i is None else (q[i, :3], matrix(q[i, 3:]))

    def put(name: str, value: Any) -> None:
        first = int(model.joint(name).qposadr[0])
        qpos[first : first + np.size(value)] = value

    for piece in made.layout.pieces:
        if piece.joint is None:
            put(piece.title, q[index[id(piece.body)]])
            continue
        free, joint = made.joints[piece.number], piece.joint
        (r_a, R_a), (r_b, R_b) = pose(joint.a), pose(joint.b)
        if isinstance(joint, Distance):
            span = r_b + R_b @ joint.b.local_point(joint.at_b) - r_a - R_a @ joint.a.local_point(joint.at_a)
            R_near, rod = (R_a, span) if piece.is_b else (R_b, -span)
            q1, q2 = rods.angles(piece, (R_near @ local_axes(rod_ends(piece)[0], np.eye(3))).T @ rod)
            put(rods.swing_name(piece, 0), q1)
            put(rods.swing_name(piece, 1), q2)
            put(piece.named("ball"), quaternion_from_matrix(ball(made, piece, R_a, R_b, rods.swing(piece, q1, q2))))
            continue
        A = R_a @ local_axes(joint.a, free.A)
        s = A.T @ (r_b + R_b @ joint.b.local_point(free.at_b) - r_a - R_a @ joint.a.local_point(free.at_a))
        for k in free.slides:
            put(piece.named("slide", k), s[k])
        R = A.T @ R_b @ local_axes(joint.b, free.B)
        if free.turns is None:
            put(piece.named("ball"), quaternion_from_matrix(ball(made, piece, R_a, R_b)))
            continue
        turns = counted(made, joint, state, free.angles(R))
        for k, angle in enumerate(turns):
            put(piece.named("turn", k), angle)
    return qpos


def ball(made: Sketch, piece: Piece, R_a: np.ndarray, R_b: np.ndarray, turn: np.ndarray | None = None) -> np.ndarray:
    """Return the rotation of a child in its own axes, from its pose at rest on its parent or on a rod rotated by a
    ``turn``.
    """
    R_parent, R = (R_a, R_b) if piece.is_b else (R_b, R_a)
    R0_parent = np.eye(3) if piece.parent is None else made.poses[piece.parent.number][1]
    at_rest = made.poses[piece.number][1]
    if turn is not None:
        parent = rod_ends(piece)[0]
        F = R0_parent @ local_axes(parent, np.eye(3))
        at_rest = F @ turn @ F.T @ at_rest
    return (R_parent @ R0_parent.T @ at_rest).T @ R


def counted(made: Sketch, joint: Joint, state: State, angles: tuple) -> tuple:
    """Return the angle of a hinge with the turns that the state, or else its driver, has counted [rad]."""
    own, lowered = joint.angle(), made.system.lowered
    if own is None or len(angles) != 1 or key_of(own) not in lowered.coordinate_index:
        return angles
    known = driven_coordinates(lowered, state.t) if state.coordinates is None else state.coordinates
    turns = np.round((known[lowered.coordinate_index[key_of(own)]] - angles[0]) / (2 * np.pi))
    return (angles[0] + 2 * np.pi * turns,)


def velocities(made: Sketch, mujoco: Any, model: Any, data: Any, state: State) -> np.ndarray:
    """Return qvel of a state, piece by piece: the axes of its joints times their rates are its velocity less its
    parent's.
    """
    qvel, v = np.zeros(model.nv), state.v.reshape(-1, 6)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    index = {id(body): i for i, body in enumerate(made.system.bodies)}
    scale = np.abs(v).max(initial=1e-3)

    def twist(piece: Piece | None, centre: np.ndarray) -> np.ndarray:
        if piece is None:
            return np.zeros(6)
        r_dot, omega = np.split(v[index[id(piece.body)]], 2)
        return np.concatenate([omega, r_dot + np.cross(omega, centre - data.xpos[model.body(piece.name).id])])

    for piece in made.layout.pieces:
        b = model.body(piece.name).id
        first, count = model.body_dofadr[b], model.body_dofnum[b]
        if not count:
            continue
        centre = data.subtree_com[model.body_rootid[b]]
        S, wanted = data.cdof[first : first + count].T, twist(piece, centre) - twist(piece.parent, centre)
        rates = np.linalg.lstsq(S, wanted, rcond=None)[0]
        if np.abs(S @ rates - wanted).max() > JOINT_MISFIT_MAX * scale * max(1.0, np.abs(S).max()):
            raise InputError(
                f"state: the velocity of body '{piece.body.name}' does not fit its joint "
                f"'{made.system.name(piece.joint)}'; start from system.state() or system.assemble()"
            )
        qvel[first : first + count] = rates
    return qvel


SINGULAR_VALUE_RATIO_MIN = 1e-10  # [1] singular values below this belong to redundant rows
ZERO_ROW_MAX = 1e-12  # [m or 1] rows below this are zero but for rounding: of bodies that other joints keep together
EQUALITY_ROWS_MAX = 6  # [1] rows of an equality, a weld


def mass_matrix(twin: Any) -> Kinetic:
    """Return the mass matrix in MuJoCo's velocities; those of welded pieces are combined, generators are left out."""
    mujoco, m, d, layout = twin.made.mujoco, twin.model, twin.data, twin.made.layout
    own, M = twin.own(), np.zeros((m.nv, m.nv))
    mujoco.mj_fullM(m, d, M)
    together = np.eye(int(own.sum()))
    if layout.extra:
        pieces = [jacobian(twin, m.body(piece.name).id) for piece in layout.extra]
        mains = [jacobian(twin, m.body(layout.main[id(piece.body)].name).id) for piece in layout.extra]
        apart = np.vstack(pieces) - np.vstack(mains)
        together = scipy.linalg.null_space(apart[:, own], rcond=1e-10)  # above rounding, below a degree of freedom
    map_ = np.vstack([jacobian(twin, k) for k in twin.ids])[:, own] @ together
    return Kinetic(together.T @ M[np.ix_(own, own)] @ together, map_)


def jacobian(twin: Any, body: int) -> np.ndarray:
    """Return the Jacobian of velocity of O and angular velocity of a MuJoCo body, shape (6, nv)."""
    J = np.zeros((2, 3, twin.model.nv))
    twin.made.mujoco.mj_jacBody(twin.model, twin.data, J[0], J[1], body)
    return J.reshape(6, -1)


def start_accelerations(twin: Any) -> np.ndarray:
    """Return the acceleration of O and world angular acceleration, shape (bodies, 6)."""
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
    """Compute the accelerations that MuJoCo's rows allow without their softness, by the principle of Gauss.

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
    felt = size > ZERO_ROW_MAX * max(1.0, size.max())
    L = np.linalg.cholesky(M)
    G = scipy.linalg.solve_triangular(L, J[felt].T, lower=True).T
    size, wanted = np.linalg.norm(G, axis=1), -bias[places(d)][felt] - J[felt] @ d.qacc_smooth
    y = np.linalg.lstsq(G / size[:, None], wanted / size, rcond=SINGULAR_VALUE_RATIO_MIN)[0]
    d.qacc[:] = d.qacc_smooth + scipy.linalg.solve_triangular(L, y, lower=True, trans="T")


def places(data: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the equality of every row, and which of its rows; MuJoCo leaves out those whose rows are all zero."""
    first = np.searchsorted(data.efc_id, data.efc_id)
    return data.efc_id.copy(), np.arange(data.nefc) - first


def row_speeds(twin: Any, time: float) -> np.ndarray:
    """Return J v at the pose reached with the velocities of the start after a time, with these velocities, shape
    (equalities, 6).
    """
    mujoco, m, d = twin.made.mujoco, twin.model, twin.data
    d.qpos[:] = twin.qpos
    mujoco.mj_integratePos(m, d.qpos, twin.qvel, time)
    mujoco.mj_fwdPosition(m, d)
    speed, table = np.zeros(d.nefc), np.zeros((m.neq, EQUALITY_ROWS_MAX))
    mujoco.mj_mulJacVec(m, d, speed, twin.qvel)
    table[places(d)] = speed
    return table
