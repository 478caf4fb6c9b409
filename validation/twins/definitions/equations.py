"""Second formulation of the reference-point equations, in plain numpy, that shares no kernel with ``mbsd3d``.

It reads the public fields of bodies, joints and force elements:

- c(q, t) or s(q, v, t) of every joint from `validation.twins.definitions.rows`;
- J and gamma by Taylor series along motions: along the motion with v_dot = 0, ``J v_dot = -c_ddot`` or ``-s_dot``;
- M and h from the velocity of the centre of mass, v_G = B v with B = [1, -[s]x] (principle of virtual power);
- v_dot = J^+ gamma + N (N'M N)^-1 N'(Q - h - M J^+ gamma) with N the null space of J from its singular values.

Solved in lengths of the model, each part of a joint over its greatest slope: rank, gaps and condition are those of the
mechanism in any units.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from mbsd3d import GROUND, Joint, State, System
from mbsd3d.errors import InputError
from validation.twins.base import label
from validation.twins.definitions.rows import TURNS, Motion, law_of, rotation
from validation.twins.definitions.series import Array, Series
from validation.twins.laws import LAWS, Law
from validation.twins.laws.moving import Moving, Push, own_states

SINGULAR_VALUE_RATIO_MIN = 1e-9
"""Singular values of J below this part of the greatest count as zero: far above rounding, far below a real row."""


def coefficient(part: Series, order: int, motions: int) -> Array:
    """Return the coefficients of one order, shape (motions, rows)."""
    return np.broadcast_to((part.x0, part.x1, part.x2)[order], (motions, part.x0.shape[-1]))


@dataclass(frozen=True, eq=False)
class Reference:
    """Solution of the second formulation at one state.

    ``acceleration`` (n, 6): (r_ddot, w_dot), world [m/s^2, rad/s^2]; ``wrench``: id(joint) -> (6,) force and moment
    about O of its body b [N, N m]; ``gaps``, ``rates`` (m,): |c| and |J v - b| of the rows [rad, rad/s, or lengths of
    the model]; ``spans``: the rows of each joint; ``rank``: of J; ``condition``: of N'M N, the inertia of what is free
    to move: what any solver may lose of its digits.
    """

    acceleration: Array
    wrench: dict[int, Array]
    gaps: Array
    rates: Array
    spans: list[slice]
    rank: int
    condition: float


class Rows(NamedTuple):
    """Rows of all joints: ``J`` (m, 6 n), ``gamma`` (m,); ``c`` (m,): 0 for rows of velocities alone; ``rate`` (m,):
    J v - b; ``size`` (m,): greatest slope of the part of a joint they belong to, lengths counted in those of the model;
    ``spans``: the rows of each joint.
    """

    J: Array
    gamma: Array
    c: Array
    rate: Array
    size: Array
    spans: list[slice]


def units(system: System) -> Array:
    """Return lengths of the model and radians [m, rad], shape (6 n,)."""
    return np.tile(3 * [system.lowered.model.length] + 3 * [1.0], len(system.bodies))


def constraint_rows(system: System, state: State) -> Rows:
    """Return the constraint rows at a state."""
    n, unit, spans, first = len(system.bodies), units(system), [], 0
    single = np.concatenate([np.eye(6 * n), np.zeros((1, 6 * n))]).reshape(-1, n, 6)
    basis, motion = Motion(system, state, single), Motion(system, state, state.v.reshape(1, n, 6))
    found: list[tuple[Array, ...]] = [(np.zeros((0, 6 * n)), *4 * [np.zeros(0)])]  # a body that flies has no rows
    for joint in system.joints:
        order, law = law_of(system, joint)
        along = law(motion, joint)
        for part, moved in zip(along, law(basis, joint), strict=True):
            slopes = coefficient(moved, order, 6 * n + 1)
            J = (slopes[:-1] - slopes[-1]).T
            c, rate, bend = np.zeros(len(J)), *(coefficient(part, order + k, 1)[0] for k in (0, 1))
            if order:
                c += coefficient(part, 0, 1)[0]
            found.append((J, -(order + 1) * bend, c, rate, np.full(len(J), np.abs(J * unit).max() or 1.0)))
        found[-1][2][:] += whole_turns(system, state, motion, joint)
        last = first + sum(part.x0.shape[-1] for part in along)
        spans.append(slice(first, last))
        first = last
    J, gamma, c, rate, size = map(np.concatenate, zip(*found, strict=True))
    return Rows(J, gamma, c, rate, size, spans)


def whole_turns(system: System, state: State, now: Motion, joint: Joint) -> float:
    """Return the contribution of whole turns of hinges to the last part of c: a definition knows its angle to +-pi
    only.

    They are counted from that angle: after half a turn rounding says whether it is pi or -pi.
    """
    if state.coordinates is None:
        return 0.0
    found = 0.0
    for factor, hinge in TURNS.get(type(joint), lambda joint: [])(joint):
        x, here, turn = now.counted(hinge)
        away = state.coordinates[system.lowered.coordinate(x)] - float(np.squeeze(here.x0))
        found += factor * turn * round(away / turn)
    return found


def mass_and_force(system: System, state: State) -> tuple[Array, Array]:
    """Return (M, Q - h), (6 n, 6 n) and (6 n,): gravity and the force laws."""
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
    """Return the law of a force; raise ValueError that names a force without one."""
    what = label(system, force)
    if type(force) not in LAWS:
        raise InputError(f"{what} has no second formulation")
    return LAWS[type(force)](force, what)


def moving(now: Motion, body: Any) -> Moving:
    """Return a body of a single motion."""
    R = np.eye(3) if body is GROUND else now.R[now.index[id(body)]] @ rotation(body.orientation).T
    r, (v, omega) = now.origin(body), now.rates(body)
    return Moving(body, r.x0.reshape(3), R, v.x0.reshape(3), omega.x0.reshape(3))


def pushed(system: System, state: State, now: Motion, force: Any, law: Law) -> tuple[Push, tuple[Moving, Moving]]:
    """Return the load of a law at a state, and its bodies a, b there."""
    a, b, x, counted = moving(now, law.a), moving(now, law.b), force.record().coordinate, 0.0
    if x is not None and state.coordinates is not None:
        counted = state.coordinates[system.lowered.coordinate(x)]
    return law.push(state.t, a, b, own_states(system, force, state.z), counted), (a, b)


def solve(system: System, state: State) -> Reference:
    """Solve for accelerations and wrenches of a mechanism at a state.

    ``system``: bodies, joints of any type, gravity and force elements; ``state``: a consistent
    state; `Reference.gaps` and `Reference.rates` say how consistent. ValueError for force elements
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
    rows, unit = constraint_rows(system, state), units(system)
    M, F = mass_and_force(system, state)
    M, F, J = M * np.outer(unit, unit), F * unit, rows.J * unit / rows.size[:, None]
    U, s, Vt = np.linalg.svd(J)
    rank = int((s > SINGULAR_VALUE_RATIO_MIN * s.max(initial=0.0)).sum())
    fixed = Vt[:rank].T @ ((U[:, :rank].T @ (rows.gamma / rows.size)) / s[:rank])
    N = Vt[rank:].T
    free = N.T @ M @ N
    v_dot = fixed + N @ np.linalg.solve(free, N.T @ (F - M @ fixed))
    held = U[:, :rank] @ ((Vt[:rank] @ (M @ v_dot - F)) / s[:rank])  # J' held = force of the constraints
    wrench = {}
    for joint, span in zip(system.joints, rows.spans, strict=True):
        i = next((i for i, body in enumerate(system.bodies) if body is joint.b), None)
        if i is not None:
            wrench[id(joint)] = (held[span] @ J[span] / unit)[6 * i : 6 * i + 6]
    condition = float(np.linalg.cond(free)) if N.size else 1.0
    gaps, rates = np.abs(rows.c / rows.size), np.abs(rows.rate / rows.size)
    return Reference((v_dot * unit).reshape(-1, 6), wrench, gaps, rates, rows.spans, rank, condition)
