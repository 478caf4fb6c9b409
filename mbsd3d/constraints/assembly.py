"""Consistent states: poses by forward kinematics and Newton, velocities by least kinetic energy."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..base.checks import number, shown
from ..base.errors import AssemblyError, InputError
from ..base.quaternions import conjugate, logarithm, multiply
from ..equations.at_state import coordinate_row, driven_coordinates, load_state, pack, worst_joint
from ..equations.compiled import Compiled, compile_system, initial_states
from ..equations.jacobian import block_rows, displacement_units
from ..kernels.coordinates import coordinate, measure, remember
from ..kernels.kinematics import displace, kinematics
from ..kernels.layout import Data
from ..kernels.rows import rows
from ..mechanism.bodies import Body
from ..mechanism.joints import coordinate_of
from ..mechanism.measures import OF_POSES, Measure, check_members
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from .contradictions import find_contradiction
from .least_squares import shortest
from .nearby_poses import nudged
from .spanning_tree import geared, loop_weights, swing
from .velocities import with_velocities


def reference_pose(system: Mechanism, t: float = 0.0) -> State:
    """Poses and own states as described; velocities zero."""
    q = np.concatenate([np.concatenate([b.position, b.orientation]) for b in system.bodies])
    return State(t, q, np.zeros(6 * len(system.bodies)), initial_states(system))


def reference_state(system: Mechanism, as_built: float | None) -> State:
    """The reference pose, if all joints close there (to the tolerance of the parts), with consistent velocities."""
    compiled = compile_system(system)
    play = 0.0 if as_built is None else number(as_built, "as_built", positive=True)
    tolerance = max(1e-9, play / compiled.model.length)
    data = compiled.data()
    pose = closed_or_error(compiled, data, reference_pose(system), tolerance)
    return with_velocities(compiled, data, pose, {}, tolerance=10.0 * tolerance)


def closed_or_error(compiled: Compiled, data: Data, pose: State, tolerance: float) -> State:
    """The pose, loaded into ``data``, with its hinge coordinates, or an AssemblyError naming the joint that gapes."""
    pose = State(pose.t, pose.q, pose.v, pose.z, driven_coordinates(compiled, pose.t))
    load_state(compiled, data, pose)
    if gap_size(compiled, data.row["c"]) > tolerance:
        clash = find_contradiction(compiled, data, pose.t, pose.t)
        if clash is not None:
            raise clash.error()
        part, gap = worst_joint(compiled, data.row["c"])
        raise AssemblyError(
            "the reference pose does not close (m or rad)",
            part=part, residual=gap, time=pose.t,
            advice="start from system.assemble(), correct the part's position (at_b, axis_b, driver at t = 0), or give "
            "as_built for parts out of line",
        )  # fmt: skip
    return pose


def constraint_extras(
    compiled: Compiled, data: Data, t: float, targets: list[tuple[int, float]], probes: list[float], y: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(residuals, Jacobian) of the asked-for coordinate values and measures at y."""
    model, n = compiled.model, compiled.model.body.size
    residual, more = [], []
    for i, value in targets:
        x, row = coordinate_row(compiled, data, i, t)
        residual.append(x - value)
        more.append(row)
    for i, value in enumerate(probes):
        residual.append(measure(model, data, i, t) - value)
        more.append(measure_gradient(compiled, data, t, i, y))
    return np.array(residual), np.array(more).reshape(-1, 6 * n)


def measure_gradient(compiled: Compiled, data: Data, t: float, i: int, y: np.ndarray) -> np.ndarray:
    """d(measure)/d(world displacement) by central differences; Newton needs no better."""
    model, n = compiled.model, compiled.model.body.size
    gradient, step = np.zeros((n, 6)), 1e-6
    probe = model.measure[i]
    on = probe["body"] if probe["coordinate"] < 0 else model.coordinate[probe["coordinate"]]["body"]
    for body in sorted({int(b) for b in on} - {n}):
        for j in range(6):
            values = []
            for sign in (1.0, -1.0):
                kinematics(model, data, nudged(y, body, j, sign * step))
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
    columns = displacement_units(model.length, model.body.size) * free
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
        J = block_rows(model, data).take(holonomic)
        dx = columns * shortest(J, scale[holonomic], J_extra, columns, -c)
        turn = np.abs(dx.reshape(-1, 6)[:, 3:]).max(initial=0.0)
        shift = np.abs(dx.reshape(-1, 6)[:, :3]).max(initial=0.0) / model.length
        dx *= min(1.0, 0.5 / max(turn, shift, 1e-300))  # stay on the branch: half a radian, half a length
        data.body["acceleration"][:-1] = dx.reshape(-1, 6)
        displace(model, data, y)
        kinematics(model, data, y)
        remember(model, data, pose.t)  # angles count their turns on the way
        rows(model, data, pose.t)
    kinematics(model, data, best_y)
    rows(model, data, pose.t)
    values = [coordinate(model, data, i, pose.t)[0] for i in range(model.coordinate.size)]
    closed = State(pose.t, best_y[: 7 * model.body.size], pose.v, pose.z, np.array(values, float))
    return closed, np.where(holonomic, data.row["c"], 0.0)


def close_pose(
    compiled: Compiled, start: State, targets: list[tuple[int, float]], probes: list[float], pinned: set[int]
) -> tuple[State, np.ndarray]:
    """Newton from the start and, where that sticks (a stretched chain that must buckle), from seeded poses nearby."""
    first = newton(compiled, start, targets, probes, pinned)
    if gap_size(compiled, first[1]) <= 1e-9:
        return first
    random, model = np.random.default_rng(0), compiled.model
    for size in (0.05, 0.2, 0.5):
        y, data = pack(compiled, start), compiled.data()
        moves = size * random.normal(size=(model.body.size, 6))
        moves[:, :3] *= model.length
        moves[sorted(pinned)] = 0.0
        data.body["acceleration"][:-1] = moves
        displace(model, data, y)
        nearby = State(start.t, y[: 7 * model.body.size], start.v, start.z, start.coordinates)
        again = newton(compiled, nearby, targets, probes, pinned)
        if gap_size(compiled, again[1]) <= 1e-9:
            return again
    return first


def gap_size(compiled: Compiled, residual: np.ndarray) -> float:
    """Largest residual in units of the model (lengths, radians)."""
    return float(np.abs(residual * compiled.model.row["scale"]).max(initial=0.0))


def assemble(
    system: Mechanism,
    angles: Mapping | None,
    slides: Mapping | None,
    rates: Mapping | None,
    measures: Mapping | None,
    pinned: Sequence[Body],
    near: State | None,
    t: float,
) -> State:
    """See `System.assemble`."""
    angles, slides = mapping(angles, "angles"), mapping(slides, "slides")
    rates, measures = mapping(rates, "rates"), mapping(measures, "measures")
    probes = tuple(measures)
    for probe in probes:
        if not isinstance(probe, Measure):
            raise InputError(f"assemble: {shown(probe)} is not a measure; build one with mbsd3d.measures")
        if probe.kind not in OF_POSES:
            raise InputError(f"assemble: {probe.label} does not follow from a pose; give speeds as rates=")
        check_members(system, probe, "assemble")
    compiled = compile_system(system, probes)
    wanted, asked = [], []
    for values, kind in ((angles, "angle"), (slides, "slide")):
        for key, value in values.items():
            joint = system.part(key, "joints")
            x = coordinate_of(joint, kind, f"assemble: {kind}s")
            asked.append(f"{kind} of '{system.name(joint)}'")
            wanted.append((x, number(value, f"assemble: {asked[-1]}")))
    if not isinstance(pinned, Sequence) or isinstance(pinned, str):
        raise InputError(f"assemble: pinned = {shown(pinned)} is not a sequence; give a list of bodies")
    fixed = {compiled.body_index[id(system.part(body))] for body in pinned}
    pose = near or reference_pose(system, t)
    start = State(t, pose.q, pose.v, pose.z, pose.coordinates)
    known = geared(compiled, wanted)
    if near is None:
        start = swing(compiled, start, known, fixed)
    reference = driven_coordinates(compiled, t) if start.coordinates is None else start.coordinates.copy()
    targets = [(compiled.coordinate(x), value) for x, value in wanted]
    for x, value in known:
        reference[compiled.coordinate(x)] = value
    start = State(t, start.q, start.v, start.z, reference)
    goals = [number(v, f"assemble: {probe.label}") for probe, v in measures.items()]
    closed, residual = close_pose(compiled, start, targets, goals, fixed)
    if gap_size(compiled, residual) > 1e-9:  # show the gap where the loop closes
        residual = newton(compiled, start, targets, goals, fixed, loop_weights(compiled))[1]
    check_closed(compiled, closed, residual, targets, goals, [*asked, *(probe.label for probe in probes)])
    moved = moved_report(system, pose, closed)
    data = compiled.data()
    load_state(compiled, data, closed)
    return replace(with_velocities(compiled, data, closed, rates), moved=moved)


def mapping(given: Mapping | None, what: str) -> Mapping:
    """What is asked for; None = nothing."""
    if not isinstance(given, Mapping | None):
        raise InputError(f"assemble: {what} = {shown(given)} is not a mapping; give e.g. {{hinge: 0.3}}")
    return given or {}


def check_closed(
    compiled: Compiled, closed: State, residual: np.ndarray, targets: list[tuple[int, float]], goals: list[float],
    asked: list[str],
) -> None:  # fmt: skip
    """AssemblyError with the gap and the joint where the pose does not close or misses a target.

    ``asked``: names of the targets and of the goals.
    """
    if gap_size(compiled, residual) > 1e-9:
        part, gap = worst_joint(compiled, residual)
        wanted, other = (f" with this {', '.join(asked)}", "give other angles or values, ") if asked else ("", "")
        raise AssemblyError(
            f"the mechanism cannot close{wanted}, a gap remains (m or rad)",
            part=part, residual=gap, time=closed.t,
            advice=f"check positions and lengths, {other}or see system.check()",
        )  # fmt: skip
    data = compiled.data()
    y = load_state(compiled, data, closed)
    miss, _ = constraint_extras(compiled, data, closed.t, targets, goals, y)
    if miss.size and np.abs(miss).max() > 1e-8:
        k = int(np.argmax(np.abs(miss)))
        raise AssemblyError(
            f"the mechanism closes but misses the {asked[k]} asked for by {miss[k]:.6g} rad or m",
            part="assemble", residual=float(miss[k]), time=closed.t,
            advice="the value is out of reach; give one within the mechanism's range or a better start with near=",
        )  # fmt: skip


def moved_report(system: Mechanism, start: State, end: State) -> dict[str, tuple[float, float]]:
    """How far each body moved: distance of O [m] and angle [rad]."""
    n = len(system.bodies)
    a, b = start.q.reshape(n, 7), end.q.reshape(n, 7)
    report = {}
    for i, body in enumerate(system.bodies):
        turn = float(np.linalg.norm(logarithm(multiply(b[i, 3:], conjugate(a[i, 3:])))))
        report[system.name(body)] = (float(np.linalg.norm(b[i, :3] - a[i, :3])), turn)
    return report
