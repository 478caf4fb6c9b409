"""Consistent states: poses by forward kinematics and Newton, velocities by least kinetic energy."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import scipy.linalg

from .errors import AssemblyError
from .joints import coordinate_of
from .kernels.coordinates import coordinate
from .kernels.kinematics import displace, displace_body, kinematics
from .kernels.layout import Data
from .kernels.probes import measure
from .kernels.rows import rows
from .measures import Measure
from .model import Compiled, compile_system, inertia_about_origin
from .parts import number
from .rotations import conjugate, exponential, logarithm, matrix, multiply
from .selection import dense_jacobian
from .state import State


def pack(compiled: Compiled, state: State) -> np.ndarray:
    """y = (q, u, z) with u = (r_dot, R'w), audit states zero."""
    n = len(compiled.system.bodies)
    if state.q.size != 7 * n:
        raise ValueError(f"state: {state.q.size // 7} bodies, the system has {n}; give a state of this system")
    v = state.v.reshape(n, 6)
    R = matrix(state.q.reshape(n, 7)[:, 3:])
    u = np.concatenate([v[:, :3], np.einsum("nji,nj->ni", R, v[:, 3:])], axis=1)
    z = np.zeros(compiled.model.state.size)
    z[: compiled.model.z_work] = state.z
    return np.concatenate([state.q, u.ravel(), z])


def load_state(compiled: Compiled, data: Data, state: State) -> np.ndarray:
    """Fill kinematics and rows of ``data`` at a state; returns y."""
    y = pack(compiled, state)
    if state.coordinates is not None:
        known = state.coordinates.size  # a condition on other hinges adds coordinates at the end of the table
        data.coordinate["value"][:known] = state.coordinates[: data.coordinate.size]
    data.coordinate["rate"] = 0.0
    data.unwrap_time[0] = state.t
    kinematics(compiled.model, data, y)
    rows(compiled.model, data, state.t)
    return y


def reference_pose(system: Any, t: float = 0.0) -> State:
    """Poses as described; velocities zero."""
    q = np.concatenate([np.concatenate([b.position, b.orientation]) for b in system.bodies])
    return State(t, q, np.zeros(6 * len(system.bodies)))


def driven_coordinates(compiled: Compiled, t: float) -> np.ndarray:
    """Unwrapping references at a start: the signal where a coordinate is driven, else zero."""
    reference = np.zeros(compiled.model.coordinate.size)
    for joint, _ in compiled.drives:
        for row in joint.rows():
            if len(row.coordinates) == 1:
                reference[compiled.coordinate(row.coordinates[0])] = float(row.signal(t)) / row.values[0]
    return reference


def worst_joint(compiled: Compiled, residual: np.ndarray) -> tuple[str, float]:
    """(text naming the joint with the largest residual, its size)."""
    size = np.abs(residual) * compiled.model.row["scale"]
    k = int(np.argmax(size))
    joint = compiled.system.joints[compiled.row_joint[k]]
    metres = compiled.model.row["scale"][k] != 1.0 or compiled.model.length == 1.0
    group = residual[compiled.rows[id(joint)]]
    largest = float(np.abs(residual[k])) if not metres else float(np.linalg.norm(group[: min(3, group.size)]))
    return f"{type(joint).__name__} '{compiled.system.name(joint)}'", largest


def reference_state(system: Any, as_built: float | None = None) -> State:
    """The reference pose, if all joints close there (to the tolerance of the parts), with consistent velocities."""
    compiled = compile_system(system)
    tolerance = 1e-9 if as_built is None else max(1e-9, as_built / compiled.model.length)
    pose = closed_or_error(compiled, reference_pose(system), tolerance)
    return with_velocities(compiled, pose, {}, tolerance=10.0 * tolerance)


def closed_or_error(compiled: Compiled, pose: State, tolerance: float) -> State:
    """The pose with its hinge coordinates, or an AssemblyError naming the joint that gapes."""
    data = compiled.data()
    pose = State(pose.t, pose.q, pose.v, pose.z, driven_coordinates(compiled, pose.t))
    load_state(compiled, data, pose)
    size = np.abs(data.row["c"]) * compiled.model.row["scale"]
    if size.size and size.max() > tolerance:
        part, gap = worst_joint(compiled, data.row["c"])
        raise AssemblyError(
            "the reference pose does not close (m or rad)",
            part=part, residual=gap, time=pose.t,
            advice="start from system.assemble(), or correct the part's position (at_b, axis_b, driver at t = 0)",
        )  # fmt: skip
    return pose


def constraint_extras(
    compiled: Compiled, data: Data, t: float, targets: list[tuple[int, float]], probes: list[float], y: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(residuals, Jacobian) of the asked-for coordinate values and measures at y."""
    model, n = compiled.model, compiled.model.body.size
    residual, blocks = [], []
    for i, value in targets:
        x, _, la, ta, lb, tb = coordinate(model, data, i, t)
        row = np.zeros((n + 1, 6))
        a, b = model.coordinate["body"][i]
        row[a] += np.concatenate([la, ta])
        row[b] += np.concatenate([lb, tb])
        residual.append(x - value)
        blocks.append(row[:n].ravel())
    for i, value in enumerate(probes):
        residual.append(measure(model, data, i, t) - value)
        blocks.append(measure_gradient(compiled, data, t, i, y))
    return np.array(residual), np.array(blocks).reshape(len(residual), 6 * n)


def measure_gradient(compiled: Compiled, data: Data, t: float, i: int, y: np.ndarray) -> np.ndarray:
    """d(measure)/d(world displacement) by central differences; Newton needs no better."""
    model, n = compiled.model, compiled.model.body.size
    gradient, step = np.zeros((n, 6)), 1e-6
    for body in range(n):
        for j in range(6):
            values = []
            for sign in (1.0, -1.0):
                dx, trial = np.zeros(6), y.copy()
                dx[j] = sign * step
                displace_body(trial, 7 * body, tuple(dx[:3]), tuple(dx[3:]))
                kinematics(model, data, trial)
                values.append(measure(model, data, i, t))
            gradient[body, j] = (values[0] - values[1]) / (2 * step)
    kinematics(model, data, y)
    return gradient.ravel()


def newton(
    compiled: Compiled, pose: State, targets: list[tuple[int, float]], probes: list[float], pinned: set[int],
    weights: np.ndarray | None = None,
) -> tuple[State, np.ndarray]:  # fmt: skip
    """Least-displacement Newton onto c = 0 and the targets; (closest state, residual left in the rows).

    Where the rows cannot all be met, the sum of squares of the weighted residuals is least.
    """
    model, data = compiled.model, compiled.data()
    scale = model.row["scale"] * (1.0 if weights is None else weights)
    y = load_state(compiled, data, pose)
    free = np.repeat([i not in pinned for i in range(model.body.size)], 6)
    columns = np.tile(np.repeat([model.length, 1.0], 3), model.body.size) * free
    holonomic = model.row["holonomic"].astype(bool)
    best, best_y, stalled = np.inf, y.copy(), 0
    for _ in range(200):
        c_extra, J_extra = constraint_extras(compiled, data, pose.t, targets, probes, y)
        c = np.concatenate([data.row["c"][holonomic] * scale[holonomic], c_extra])
        size = float(np.abs(c).max()) if c.size else 0.0
        stalled = 0 if size < 0.9 * best else stalled + 1
        if size < best:
            best, best_y = size, y.copy()
        if size < 1e-15 or stalled > (8 if best > 1e-12 else 1):
            break
        J = dense_jacobian(model, data)[holonomic] * scale[holonomic][:, None]
        A = np.concatenate([J, J_extra]) * columns
        dx = columns * scipy.linalg.lstsq(A, -c, cond=1e-9)[0]
        turn = np.abs(dx.reshape(-1, 6)[:, 3:]).max(initial=0.0)
        shift = np.abs(dx.reshape(-1, 6)[:, :3]).max(initial=0.0) / model.length
        dx *= min(1.0, 0.5 / max(turn, shift, 1e-300))  # stay on the branch: half a radian, half a length
        data.body["acceleration"][:-1] = dx.reshape(-1, 6)
        displace(model, data, y)
        kinematics(model, data, y)
        rows(model, data, pose.t)
    kinematics(model, data, best_y)
    rows(model, data, pose.t)
    values = [coordinate(model, data, i, pose.t)[0] for i in range(model.coordinate.size)]
    closed = State(pose.t, best_y[: 7 * model.body.size], pose.v, pose.z, np.array(values, float))
    return closed, np.where(holonomic, data.row["c"], 0.0)


def loop_weights(compiled: Compiled) -> np.ndarray:
    """1 for the rows of a spanning tree of joints, 1e-4 for those that close loops."""
    weights, group = np.ones(compiled.model.row.size), {}

    def root(i: int) -> int:
        while group.get(i, i) != i:
            i = group[i]
        return i

    for joint in compiled.system.joints:
        roots = {root(compiled.body_index[id(body)]) for body in joint.bodies()}
        if len(roots) == 1:
            weights[compiled.rows[id(joint)]] = 1e-4
        for i in roots:
            group[i] = min(roots)
    return weights


def swing(compiled: Compiled, pose: State, targets: list[tuple[Any, float]]) -> State:
    """Forward kinematics: everything beyond a joint in the spanning tree moves by the asked-for angle or slide."""
    from .kernels import kinds

    system, index = compiled.system, compiled.body_index
    n = len(system.bodies)
    poses = pose.q.reshape(n, 7).copy()
    for x, value in targets:
        beyond = bodies_beyond(system, index, x)
        if beyond is None:
            continue  # the joint closes a loop: Newton's task
        side = next(body for body in (x.b, x.a) if index[id(body)] in beyond)
        sign = 1.0 if side is x.b else -1.0
        fixed = x.a if side is x.b else x.b
        i = index[id(fixed)]
        e, r = (fixed.orientation, fixed.position) if i == n else (poses[i, 3:], poses[i, :3])
        own = x.axis if fixed is x.a else x.axis_b
        axis = matrix(e) @ fixed.local_axis(own)
        point_of = x.point_a if fixed is x.a else x.point_b
        pivot = r + matrix(e) @ fixed.local_point(hinge_point(system, x, point_of))
        for k in beyond:
            if x.kind == kinds.SLIDE:
                poses[k, :3] += sign * value * axis
                continue
            turn = exponential(sign * value * axis)
            poses[k, :3] = pivot + matrix(turn) @ (poses[k, :3] - pivot)
            poses[k, 3:] = multiply(turn, poses[k, 3:])
    return State(pose.t, poses.ravel(), pose.v, pose.z)


def hinge_point(system: Any, x: Any, default: np.ndarray) -> np.ndarray:
    """A point on the hinge line, world at the reference pose."""
    for joint in system.joints:
        own = joint.angle()
        if own is not None and own.a is x.a and own.b is x.b and np.array_equal(own.axis, x.axis):
            return getattr(joint, "at", default)
    return default


def bodies_beyond(system: Any, index: dict[int, int], x: Any) -> set[int] | None:
    """Bodies that hang on the ground through this hinge only; None where the hinge is part of a loop."""
    ground = len(system.bodies)
    links: dict[int, set[int]] = {i: set() for i in range(ground + 1)}
    pair = {index[id(x.a)], index[id(x.b)]}
    for joint in system.joints:
        ends = [index[id(body)] for body in joint.bodies()]
        for i in ends:
            links[i].update(j for j in ends if j != i and {i, j} != pair)
    reached, queue = {ground}, [ground]
    while queue:
        for j in links[queue.pop()] - reached:
            reached.add(j)
            queue.append(j)
    inside = pair & reached
    if len(inside) != 1:
        return None
    start = (pair - inside).pop()
    beyond, queue = {start}, [start]
    while queue:
        for j in links[queue.pop()] - beyond:
            beyond.add(j)
            queue.append(j)
    return beyond


def assemble(
    system: Any, angles: Mapping, slides: Mapping, rates: Mapping, measures: Mapping, pinned: tuple, near: Any, t: float
) -> State:
    """See `System.assemble`."""
    probes = tuple(measures)
    for probe in probes:
        if not isinstance(probe, Measure):
            raise ValueError(f"assemble: {probe!r} is not a measure; build one with mbsd3d.measures")
    compiled = compile_system(system, probes)
    wanted = []
    for values, kind in ((angles, "angle"), (slides, "slide")):
        for key, value in values.items():
            joint = system.part(key, "joints")
            x = coordinate_of(joint, kind, f"assemble: {kind}s")
            wanted.append((x, number(value, f"assemble: {kind} of '{system.name(joint)}'")))
    fixed = {compiled.body_index[id(system.part(body))] for body in pinned}
    pose = near or reference_pose(system, t)
    start = State(t, pose.q, pose.v, pose.z, pose.coordinates)
    if near is None:
        start = swing(compiled, start, wanted)
    reference = driven_coordinates(compiled, t) if start.coordinates is None else start.coordinates.copy()
    targets = [(compiled.coordinate(x), value) for x, value in wanted]
    for i, value in targets:
        reference[i] = value
    start = State(t, start.q, start.v, start.z, reference)
    goals = [number(v, f"assemble: {probe.label}") for probe, v in measures.items()]
    closed, residual = newton(compiled, start, targets, goals, fixed)
    if np.abs(residual * compiled.model.row["scale"]).max(initial=0.0) > 1e-9:  # show the gap where the loop closes
        residual = newton(compiled, start, targets, goals, fixed, loop_weights(compiled))[1]
    check_closed(compiled, closed, residual, targets, goals)
    return with_velocities(compiled, closed, rates, pose)


def check_closed(
    compiled: Compiled, closed: State, residual: np.ndarray, targets: list[tuple[int, float]], goals: list[float]
) -> None:
    """AssemblyError with the gap and the joint where the pose does not close or misses a target."""
    size = np.abs(residual) * compiled.model.row["scale"]
    if size.size and size.max() > 1e-9:
        part, gap = worst_joint(compiled, residual)
        raise AssemblyError(
            "the mechanism cannot close, a gap remains (m or rad)",
            part=part, residual=gap, time=closed.t,
            advice="check positions and lengths, give other angles, or see system.check()",
        )  # fmt: skip
    data = compiled.data()
    y = load_state(compiled, data, closed)
    miss, _ = constraint_extras(compiled, data, closed.t, targets, goals, y)
    if miss.size and np.abs(miss).max() > 1e-8:
        k = int(np.argmax(np.abs(miss)))
        raise AssemblyError(
            f"the mechanism closes but misses the asked-for value no. {k + 1} by {miss[k]:.6g} rad or m",
            part="assemble", residual=float(miss[k]), time=closed.t,
            advice="the value is out of reach; give one within the mechanism's range or a better start with near=",
        )  # fmt: skip


def moved_report(system: Any, start: State, end: State) -> dict[str, tuple[float, float]]:
    """How far each body moved: distance of O [m] and angle [rad]."""
    n = len(system.bodies)
    a, b = start.q.reshape(n, 7), end.q.reshape(n, 7)
    report = {}
    for i, body in enumerate(system.bodies):
        turn = float(np.linalg.norm(logarithm(multiply(b[i, 3:], conjugate(a[i, 3:])))))
        report[system.name(body)] = (float(np.linalg.norm(b[i, :3] - a[i, :3])), turn)
    return report


def given_velocities(system: Any) -> np.ndarray:
    """(6 n,) velocities the user gave, NaN where they are to be solved."""
    v = np.full((len(system.bodies), 6), np.nan)
    for i, body in enumerate(system.bodies):
        if body.velocity is not None:
            v[i, :3] = body.velocity
        if body.omega is not None:
            v[i, 3:] = body.omega
    return v.ravel()


def with_velocities(
    compiled: Compiled, pose: State, rates: Mapping, start: State | None = None, tolerance: float = 1e-8
) -> State:
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
        _, block = constraint_extras(compiled, data, pose.t, [(compiled.coordinate(x), 0.0)], [], np.zeros(0))
        J, b = np.vstack([J, block]), np.append(b, number(value, f"assemble: rate of '{system.name(joint)}'"))
        names.append(f"rate of '{system.name(joint)}'")
    v = least_energy(compiled, pose, J, b, given_velocities(system), names, tolerance)
    moved = moved_report(system, start, pose) if start is not None else {}
    return State(pose.t, pose.q, v, pose.z, pose.coordinates, moved)


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
        advice="give the body a mass or an inertia, its velocity and omega, or a joint that determines its motion",
    )
