"""A second formulation of the reference-point equations, in plain numpy, that shares no kernel with ``mbsd3d``.

It reads the public fields of bodies, joints and force elements:

- c(q, t) or s(q, v, t) of every joint from `validation.twins.definitions.rows`;
- J and gamma by Taylor series along motions: along the motion with v_dot = 0, ``J v_dot = -c_ddot`` or ``-s_dot``;
- M and h from the velocity of the centre of mass, v_G = B v with B = [1, -[s]x] (principle of virtual power);
- v_dot = J^+ gamma + N (N'M N)^-1 N'(Q - h - M J^+ gamma) with N the null space of J from its singular values.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from mbsd3d import GROUND, State, System
from mbsd3d.errors import InputError
from validation.twins.base import label
from validation.twins.definitions.rows import Motion, law_of, rotation
from validation.twins.definitions.series import Array, Series
from validation.twins.laws import LAWS, Law
from validation.twins.laws.moving import Moving, Push, own_states

RANK = 1e-9
"""Singular values of J below this part of the greatest count as zero: far above rounding, far below a real row."""


def column(parts: list[Series], order: int, motions: int) -> Array:
    """(motions, rows) coefficients of one order."""
    found = []
    for part in parts:
        x, rows = (part.x0, part.x1, part.x2)[order], part.x0.shape[-1]
        found.append(np.broadcast_to(x, (motions, rows)))
    return np.concatenate(found, axis=1)


@dataclass(frozen=True, eq=False)
class Reference:
    """Solution of the second formulation at one state.

    ``acceleration`` (n, 6): (r_ddot, w_dot), world [m/s^2, rad/s^2]; ``wrench``: id(joint) -> (6,) force and moment
    about O of its body b [N, N m]; ``residual``: greatest |c| [m or rad]; ``rate``: greatest |J v - b| [m/s or rad/s];
    ``rank``: of J; ``condition``: of J M^-1 J' on its range: what solvers that form this matrix may lose of their
    digits.
    """

    acceleration: Array
    wrench: dict[int, Array]
    residual: float
    rate: float
    rank: int
    condition: float


def constraint_rows(system: System, state: State) -> tuple[Array, Array, list[slice], float, float]:
    """(J, gamma, rows of each joint, greatest |c|, greatest |J v - b|)."""
    n = len(system.bodies)
    unit = np.concatenate([np.eye(6 * n), np.zeros((1, 6 * n))]).reshape(-1, n, 6)
    basis, motion = Motion(system, state, unit), Motion(system, state, state.v.reshape(1, n, 6))
    J, gamma, spans, residual, rate = [np.zeros((0, 6 * n))], [np.zeros(0)], [], 0.0, 0.0
    for joint in system.joints:
        order, law = law_of(system, joint)
        slopes, along = column(law(basis, joint), order, 6 * n + 1), law(motion, joint)
        J.append((slopes[:-1] - slopes[-1]).T)
        gamma.append(-(order + 1) * column(along, order + 1, 1)[0])
        if order:
            residual = max(residual, np.abs(column(along, 0, 1)).max())
        rate = max(rate, np.abs(column(along, order, 1)).max())
        first = spans[-1].stop if spans else 0
        spans.append(slice(first, first + gamma[-1].size))
    none = np.zeros((0, 6 * n))  # a body that flies has no rows
    return np.concatenate([none, *J]), np.concatenate([none[:, 0], *gamma]), spans, residual, rate


def mass_and_force(system: System, state: State) -> tuple[Array, Array]:
    """(M, Q - h), (6 n, 6 n) and (6 n,): gravity and the laws of the forces."""
    n = len(system.bodies)
    M, F, v = np.zeros((6 * n, 6 * n)), np.zeros(6 * n), state.v.reshape(n, 6)
    now = Motion(system, state, v[None])
    for i, body in enumerate(system.bodies):
        R, w, part = now.R[i], v[i, 3:], slice(6 * i, 6 * i + 6)
        s, inertia = R @ body.com, R @ body.inertia @ R.T
        B = np.hstack([np.eye(3), np.cross(np.eye(3), s).T])  # v_G = r_dot + w x s
        M[part, part] = body.mass * B.T @ B
        M[part, part][3:, 3:] += inertia
        F[part] = body.mass * B.T @ (system.gravity - np.cross(w, np.cross(w, s)))
        F[part][3:] -= np.cross(w, inertia @ w)
    for force in system.forces:
        law = law_of_force(system, force)
        push, sides = pushed(system, state, now, force, law)
        for sign, k in law.sides:
            i = now.index[id(sides[k].body)]
            F[6 * i : 6 * i + 6] += sign * np.concatenate([push.force, push.moment(sides[k].r)])
    return M, F


def law_of_force(system: System, force: Any) -> Law:
    """Its law, or a ValueError that names it."""
    what = label(system, force)
    if type(force) not in LAWS:
        raise InputError(f"{what} has no second formulation")
    return LAWS[type(force)](force, what)


def moving(now: Motion, body: Any) -> Moving:
    """A body of a single motion."""
    R = np.eye(3) if body is GROUND else now.R[now.index[id(body)]] @ rotation(body.orientation).T
    r, (v, omega) = now.origin(body), now.rates(body)
    return Moving(body, r.x0.reshape(3), R, v.x0.reshape(3), omega.x0.reshape(3))


def pushed(system: System, state: State, now: Motion, force: Any, law: Law) -> tuple[Push, tuple[Moving, Moving]]:
    """What a law says at a state, and its bodies a, b there."""
    a, b, x, counted = moving(now, law.a), moving(now, law.b), force.record().coordinate, 0.0
    if x is not None and state.coordinates is not None:
        counted = state.coordinates[system.lowered.coordinate(x)]
    return law.push(state.t, a, b, own_states(system, force, state.z), counted), (a, b)


def solve(system: System, state: State) -> Reference:
    """Accelerations and wrenches of a mechanism at a state.

    ``system``: bodies with mass and inertia, joints of any type, gravity and force elements; ``state``: a consistent
    state; `Reference.residual` and `Reference.rate` say how consistent. ValueError for force elements
    without a second formulation.

    Examples
    --------
    >>> from mbsd3d import Body, Revolute, System
    >>> bar = Body("bar", 3.0, (0.1, 1.0, 1.0), com=(0.5, 0, 0))
    >>> hinge = Revolute(GROUND, bar, at=(0, 0, 0), axis=(0, 1, 0))
    >>> system = System([bar], [hinge])
    >>> round(float(solve(system, system.state()).acceleration[0, 4]), 9)  # m g l / (I + m l^2)
    8.408571429
    """
    M, F = mass_and_force(system, state)
    J, gamma, spans, residual, rate = constraint_rows(system, state)
    U, s, Vt = np.linalg.svd(J)
    rank = int((s > RANK * s.max(initial=0.0)).sum())
    fixed = Vt[:rank].T @ ((U[:, :rank].T @ gamma) / s[:rank])
    N = Vt[rank:].T
    v_dot = fixed + N @ np.linalg.solve(N.T @ M @ N, N.T @ (F - M @ fixed))
    held = U[:, :rank] @ ((Vt[:rank] @ (M @ v_dot - F)) / s[:rank])  # J' held = force of the constraints
    wrench = {}
    for joint, span in zip(system.joints, spans, strict=True):
        i = next((i for i, body in enumerate(system.bodies) if body is joint.b), None)
        if i is not None:
            wrench[id(joint)] = (held[span] @ J[span])[6 * i : 6 * i + 6]
    spread = np.linalg.svd(np.linalg.solve(np.linalg.cholesky(M), J.T), compute_uv=False)[:rank]
    condition = float((spread[0] / spread[-1]) ** 2) if rank else 1.0
    return Reference(v_dot.reshape(-1, 6), wrench, residual, rate, rank, condition)
