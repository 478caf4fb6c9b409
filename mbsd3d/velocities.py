"""Consistent velocities of least kinetic energy: min v'M v / 2 subject to J v = b and to what the user gave."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import scipy.linalg

from .errors import AssemblyError
from .evaluation import coordinate_row, load_state
from .model import Compiled, inertia_about_origin
from .parts import number
from .selection import dense_jacobian
from .state import State
from .threads import one_thread


def given_velocities(system: Any) -> np.ndarray:
    """(6 n,) velocities the user gave, NaN where they are to be solved."""
    v = np.full((len(system.bodies), 6), np.nan)
    for i, body in enumerate(system.bodies):
        if body.velocity is not None:
            v[i, :3] = body.velocity
        if body.omega is not None:
            v[i, 3:] = body.omega
    return v.ravel()


def with_velocities(compiled: Compiled, pose: State, rates: Mapping, tolerance: float = 1e-8) -> State:
    """The pose with velocities that meet J v = b, the given ones and ``rates``, with least kinetic energy."""
    system, model, data = compiled.system, compiled.model, compiled.data()
    load_state(compiled, data, pose)
    J, b = dense_jacobian(model, data), data.row["b"].copy()
    names = [f"{type(system.joints[j]).__name__} '{system.name(system.joints[j])}'" for j in compiled.row_joint]
    for key, value in rates.items():
        joint = system.part(key, "joints")
        x = joint.angle() or joint.slide()
        if x is None:
            raise ValueError(f"assemble: rates: '{system.name(joint)}' has no angle and no slide; give a hinge")
        _, row = coordinate_row(compiled, data, compiled.coordinate(x), pose.t)
        J, b = np.vstack([J, row]), np.append(b, number(value, f"assemble: rate of '{system.name(joint)}'"))
        names.append(f"rate of '{system.name(joint)}'")
    with one_thread():
        v = least_energy(compiled, pose, J, b, given_velocities(system), names, tolerance)
    return State(pose.t, pose.q, v, pose.z, pose.coordinates)


def least_energy(
    compiled: Compiled, pose: State, J: np.ndarray, b: np.ndarray, given: np.ndarray, names: list[str],
    tolerance: float,
) -> np.ndarray:  # fmt: skip
    """min v'M v / 2 subject to J v = b and the given entries of v; errors name the joint or the massless body."""
    system, model = compiled.system, compiled.model
    n = len(system.bodies)
    known = ~np.isnan(given)
    v = np.where(known, given, 0.0)
    scale = np.tile(np.repeat([model.length, 1.0], 3), n)
    unit_rows = np.array([1.0 / max(np.abs(row * scale).max(), 1e-300) for row in J])
    A, rhs = (J[:, ~known] * scale[~known]) * unit_rows[:, None], (b - J @ v) * unit_rows
    M = scipy.linalg.block_diag(
        *[
            inertia_about_origin(pose.q[7 * i + 3 : 7 * i + 7], body.com, body.mass, body.inertia)
            for i, body in enumerate(system.bodies)
        ]
    )
    if model.singular:  # the accelerations need what given velocities may hide
        everything = np.ones(6 * n, bool)
        Z = scale[:, None] * scipy.linalg.null_space(J * scale, rcond=1e-10) if J.size else np.diag(scale)
        if Z.shape[1]:
            check_determined(system, Z.T @ M @ Z, Z, everything)
    free = ~known
    x, null = np.zeros(free.sum()), np.eye(int(free.sum()))
    if A.shape[0] and A.shape[1]:
        U, s, Vt = scipy.linalg.svd(A)
        rank = int((s > 1e-10 * s[0]).sum()) if s.size and s[0] > 0 else 0
        x = Vt[:rank].T @ ((U[:, :rank].T @ rhs) / s[:rank])
        null = Vt[rank:].T
    N = scale[free, None] * null
    if N.shape[1]:
        momentum = M @ v
        momentum += M[:, free] @ (scale[free] * x)
        reduced = N.T @ M[np.ix_(free, free)] @ N
        check_determined(system, reduced, N, free)
        x = x - null @ np.linalg.solve(reduced, N.T @ momentum[free])
    v[free] += scale[free] * x
    residual = J @ v - b
    size = np.abs(residual) * unit_rows
    speed = max(1.0, float(np.abs(v / scale).max()), float(np.abs(b * unit_rows).max(initial=0.0)))
    if size.size and size.max() > tolerance * speed:
        k = int(np.argmax(size))
        raise AssemblyError(
            "the given velocities contradict a joint (J v - b in m/s or rad/s)",
            part=names[k], residual=float(residual[k]), time=pose.t,
            advice="correct velocity or omega of its bodies, or leave one of them None to have it solved",
        )  # fmt: skip
    return v


def check_determined(system: Any, reduced: np.ndarray, N: np.ndarray, free: np.ndarray) -> None:
    """A motion without kinetic energy has an undetermined velocity: an error that names the massless body."""
    values, vectors = np.linalg.eigh(reduced)
    if values[0] > 1e-14 * max(values[-1], 1e-300):
        return
    motion = np.zeros(free.size)
    motion[free] = N @ vectors[:, 0]
    i = int(np.argmax(np.abs(motion))) // 6
    name = system.name(system.bodies[i])
    raise AssemblyError(
        f"the velocity of body '{name}' is not determined: a motion the constraints allow moves no mass",
        part=f"body '{name}'",
        advice="give the body a mass or an inertia, or a joint that determines its motion",
    )
