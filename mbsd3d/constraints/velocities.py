"""Consistent velocities: min (v - v_0)'M (v - v_0) / 2 subject to J v = b and to what the user gave.

v_0 is zero, or the motion of a known state, carried over to another pose.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import scipy.linalg
from scipy.sparse import csr_array, vstack

from ..base.checks import number, reporting_linalg_errors
from ..base.concurrency import one_thread
from ..base.errors import AssemblyError, InputError
from ..dynamics.state_rates import PROJECTED, largest_residuals, start_velocities
from ..equations.at_state import coordinate_row, load_state
from ..equations.compiled import Compiled
from ..equations.dense_solvers import mass_matrix_of
from ..equations.jacobian import block_rows, displacement_units, largest_in_rows, scaled
from ..equations.tree import repeated_rows, tree_at_start
from ..kernels.layout import Data
from ..mechanism.bodies import Body
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from ..solver.saddle_point import factor
from .conflicting_drivers import find_contradiction
from .idle_rotations import check_spins
from .least_squares import SMALL_SYSTEM_BODIES_MAX, Matrix, least
from .poses.joint_motion import joint_graph

VELOCITY_ROUNDING = 1e-12  # [rad/s, model lengths/s] of J v - b at unit speed: a factor that leaves more is not trusted


def given_velocities(system: Mechanism) -> np.ndarray:
    """Return the velocities (6 n,) the user gave, NaN where they are to be solved."""
    v = np.full((len(system.bodies), 6), np.nan)
    for i, body in enumerate(system.bodies):
        if body.velocity is not None:
            v[i, :3] = body.velocity
        if body.omega is not None:
            v[i, 3:] = body.omega
    return v.ravel()


def carried_velocities(compiled: Compiled, near: State, pose: State) -> np.ndarray:
    """Return velocities (6 n,) at a pose with which all joints move as they do in the state ``near``.

    Twists at the joints are those of ``near`` in the axes of bodies a; in closed loops in the sense of least squares.
    """
    if np.array_equal(near.q, pose.q):
        return near.v
    graph, length = joint_graph(compiled, set()), compiled.model.length
    rows = []
    for state in (near, pose):
        data = compiled.data()
        load_state(compiled, data, state)
        rows.append(graph.twist_rows(data, length))
    units = displacement_units(length, graph.parent.size)
    B = rows[1].dense() if graph.parent.size < SMALL_SYSTEM_BODIES_MAX else rows[1].sparse()
    return units * least(B.T @ B, B[:0], np.zeros(0), B.T @ rows[0].times(near.v / units))


def with_velocities(
    compiled: Compiled, data: Data, pose: State, rates: Mapping, tolerance: float = 1e-8, near: State | None = None,
    still: Sequence[Body] = (),
) -> State:  # fmt: skip
    """Return the pose, loaded in ``data``, with velocities that meet J v = b, the given ones and ``rates``.

    They change the motion of ``near`` least, in the sense of kinetic energy; None = rest. A velocity that a body was
    given counts as long as ``near`` has it. Bodies that are ``still`` have none.
    """
    system, model = compiled.system, compiled.model
    if model.singular:
        check_spins(compiled, data)
    elif not rates and near is None and not still:
        v = velocities_at_once(compiled, data, pose)
        if v is not None:
            return State.of_numbers(pose.t, pose.q.copy(), v, pose.z.copy(), pose.coordinates)
    rows, few, b = block_rows(model, data), model.body.size < SMALL_SYSTEM_BODIES_MAX, data.row["b"].copy()
    J = [rows.dense() if few else rows.sparse()]
    asked = []
    for key, value in rates.items():
        joint = system.part(key, "joints")
        x = joint.angle() or joint.slide()
        if x is None:
            raise InputError(f"assemble: rates: '{system.name(joint)}' has no angle and no slide; give a hinge")
        row = coordinate_row(compiled, data, compiled.coordinate(x), pose.t)[1][None]
        J.append(row if few else csr_array(row))
        b = np.append(b, number(value, f"assemble: rate of '{system.name(joint)}'"))
        asked.append(f"rate of '{system.name(joint)}'")
    if len(J) > 1:
        J = [np.vstack(J) if few else vstack(J, format="csr")]
    given, start = given_velocities(system), np.zeros(6 * model.body.size)
    if near is not None:
        kept = np.repeat((given == near.v).reshape(-1, 3).all(axis=1), 3)
        given, start = np.where(kept, given, np.nan), carried_velocities(compiled, near, pose)
    for body in still:
        k = 6 * compiled.body_index[id(system.part(body))]
        given[k : k + 6] = 0.0
    with one_thread(), reporting_linalg_errors("velocities at the start"):
        try:
            v = least_energy(compiled, data, J[0], b, given, start, asked, tolerance)
        except AssemblyError as error:
            clash = find_contradiction(compiled, data, pose.t, pose.t)
            raise (clash.error() if clash else error) from None
    return State(pose.t, pose.q, v, pose.z, pose.coordinates)


def velocities_at_once(compiled: Compiled, data: Data, pose: State) -> np.ndarray | None:
    """Return the velocities (6 n,) where nothing has to be weighed: all are given, none moves, or no body has any.

    v = 0 has the least kinetic energy where it meets J v = b and the given entries. None where there is more to do.
    """
    bodies, still = compiled.system.bodies, not data.row["b"].any()
    if all([body.velocity is None and body.omega is None for body in bodies]):
        return np.zeros(6 * len(bodies)) if still else velocities_by_tree(compiled, data, pose)
    given = given_velocities(compiled.system)
    if still and not given[~np.isnan(given)].any():
        return np.zeros(given.size)
    return None if data.row.size or np.isnan(given).any() else given


def velocities_by_tree(compiled: Compiled, data: Data, pose: State) -> np.ndarray | None:
    """Return the velocities (6 n,) of least kinetic energy with J v = b by the factor that runs use.

    Rows that surely repeat others change nothing: v = M^-1 J' x has the least energy whatever x is. None where the
    factor leaves a doubt which rows are independent, and where S has lost digits.
    """
    model, n = compiled.model, compiled.model.body.size
    y, v = np.zeros(13 * n + model.state.size), np.empty(6 * n)
    y[: 7 * n] = pose.q
    tree = tree_at_start(compiled, data, pose.q, pose.t)
    factor(model, data, tree)
    if repeated_rows(tree) is None or tree.state["graded"] or start_velocities(model, data, tree, y, v) != PROJECTED:
        return None
    b = data.row["b"]
    _, slip = largest_residuals(model, data, np.arange(b.size))
    return v if slip <= VELOCITY_ROUNDING * max(1.0, float(np.abs(b * model.row["scale"]).max())) else None


def least_energy(
    compiled: Compiled, data: Data, J: Matrix, b: np.ndarray, given: np.ndarray, start: np.ndarray,
    asked: list[str], tolerance: float,
) -> np.ndarray:  # fmt: skip
    """Minimise (v - start)'M (v - start) / 2 subject to J v = b and the given entries of v.

    The pose is loaded in ``data``. Errors name the joint or the massless body. ``asked``: what the rows beyond those of
    the joints are.
    """
    model = compiled.model
    known = ~np.isnan(given)
    v = np.where(known, given, start)
    scale = displacement_units(model.length, model.body.size)
    A = scaled(J, np.ones(J.shape[0]), scale)
    unit_rows = 1.0 / np.maximum(largest_in_rows(A), 1e-300)
    A = scaled(A, unit_rows, np.ones(known.size))
    M = scaled(mass_matrix_of(model, data, isinstance(J, np.ndarray)), scale, scale)
    M = M / max(abs(M).max(), 1e-300)
    free = np.flatnonzero(~known)
    if model.singular:
        check_determined(compiled.system, A, M, np.arange(known.size))  # accelerations need what given values may hide
        check_determined(compiled.system, A, M, free)
    if free.size:
        f, rest = -(M @ ((v - start) / scale))[free], (b - J @ v) * unit_rows
        if free.size < known.size:
            M, A = M[free][:, free], A[:, free]
        v[free] += scale[free] * least(M, A, rest, f, passes=3)
    residual = J @ v - b
    size = np.abs(residual) * unit_rows
    speed = max(1.0, float(np.abs(v / scale).max()), float(np.abs(b * unit_rows).max(initial=0.0)))
    if size.size and size.max() > tolerance * speed:
        k = int(np.argmax(size))
        what = "the given velocities contradict a joint"
        advice = "correct velocity or omega of its bodies, or leave one of them None to have it solved"
        if not known.any():
            what = "no velocities meet all joints and drivers"
            advice = "two of them ask for different motions: take one out, or give drivers the same speed at the start"
        raise AssemblyError(
            f"{what} (J v - b in m/s or rad/s)", part=part_of(compiled, asked, k), residual=float(residual[k]),
            time=float(data.unwrap_time[0]), advice=advice,
        )  # fmt: skip
    return v


def part_of(compiled: Compiled, asked: list[str], row: int) -> str:
    """Return the joint that a row belongs to, or what was asked besides."""
    if row >= compiled.row_joint.size:
        return asked[row - compiled.row_joint.size]
    joint = compiled.holders[compiled.row_joint[row]]
    return f"{type(joint).__name__} '{compiled.system.name(joint)}'"


def check_determined(system: Mechanism, A: Matrix, M: Matrix, free: np.ndarray) -> None:
    """Refuse a velocity that no kinetic energy determines: the error names the massless body.

    Dense, as the equations of such models are.
    """
    held = A[:, free] if isinstance(A, np.ndarray) else A[:, free].toarray()
    N = scipy.linalg.null_space(held, rcond=1e-10) if A.shape[0] else np.eye(free.size)
    if not N.shape[1]:
        return
    values, vectors = np.linalg.eigh(N.T @ (M[free][:, free] @ N))
    if values[0] > 1e-14 * max(values[-1], 1e-300):
        return
    motion = np.zeros(M.shape[0])
    motion[free] = N @ vectors[:, 0]
    i = int(np.argmax(np.abs(motion))) // 6
    name = system.name(system.bodies[i])
    raise AssemblyError(
        f"the velocity of body '{name}' is not determined: a motion the constraints allow moves no mass",
        part=f"body '{name}'",
        advice="give the body a mass or an inertia, or a joint that determines its motion",
    )
