"""Consistent states: poses by forward kinematics and Newton, velocities by least kinetic energy."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..base.checks import number, shown
from ..base.concurrency import on_one_thread
from ..base.errors import AssemblyError, InputError
from ..base.quaternions import conjugate, logarithm, multiply
from ..equations.at_state import driven_coordinates, load_state, worst_joint
from ..equations.compiled import Compiled, compile_system, initial_states, tables_of
from ..kernels.layout import Data
from ..mechanism.bodies import Body
from ..mechanism.couplings import GearMesh
from ..mechanism.joints import coordinate_of
from ..mechanism.joints.pairs import Cylindrical
from ..mechanism.measures import OF_POSES, Measure, check_members
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from .contradictions import find_contradiction
from .poses.closing import Found, ambiguities, close_pose
from .poses.pose_equations import CLOSED_GAP_MAX, gap_size, newton
from .spanning_tree import loop_weights
from .velocities import with_velocities


def reference_pose(system: Mechanism, t: float = 0.0) -> State:
    """Poses and own states as described; velocities zero."""
    q = np.concatenate([np.concatenate([b.position, b.orientation]) for b in system.bodies])
    return State(t, q, np.zeros(6 * len(system.bodies)), initial_states(system))


def reference_state(system: Mechanism, as_built: float | None) -> State:
    """The reference pose, if all joints close there (to the tolerance of the parts), with consistent velocities."""
    compiled = compile_system(system)
    play = 0.0 if as_built is None else number(as_built, "as_built", positive=True)
    tolerance = max(CLOSED_GAP_MAX, play / compiled.model.length)
    data = compiled.data()
    pose = closed_or_error(compiled, data, reference_pose(system), tolerance)
    return with_velocities(compiled, data, pose, {}, tolerance=10.0 * tolerance)


def closed_or_error(compiled: Compiled, data: Data, pose: State, tolerance: float) -> State:
    """The pose, loaded into ``data``, with its hinge coordinates, or an AssemblyError naming the joint that gapes."""
    load_state(compiled, data, pose)
    if gap_size(compiled, data.row["c"]) > tolerance:
        turned = after_whole_turns(compiled, pose, tolerance)
        if turned is None:
            raise open_reference(compiled, data, pose)
        pose = turned
        load_state(compiled, data, pose)
    return pose


def after_whole_turns(compiled: Compiled, pose: State, tolerance: float) -> State | None:
    """The reference pose with the turns counted that drivers ask for, if their way leads back to it; else None."""
    if not compiled.drives:
        return None
    found = close_pose(compiled, pose, [], [], set(), tolerance)
    moved = moved_report(compiled.system, pose, found.state)
    if found.gap > tolerance or max(max(x / compiled.model.length, turn) for x, turn in moved.values()) > tolerance:
        return None
    return replace(pose, coordinates=found.state.coordinates)


def open_reference(compiled: Compiled, data: Data, pose: State) -> AssemblyError:
    """The error of a reference pose, loaded into ``data``, that does not close."""
    clash = find_contradiction(compiled, data, pose.t, pose.t)
    if clash is not None:
        return clash.error()
    part, gap = worst_joint(compiled, data.row["c"])
    return AssemblyError(
        "the reference pose does not close (m or rad)",
        part=part, residual=gap, time=pose.t,
        advice="start from system.assemble(), correct the part's position (at_b, axis_b, driver at t = 0), or give "
        "as_built for parts out of line",
    )  # fmt: skip


@on_one_thread  # small dense algebra
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
    if near is not None and near.coordinates is None:
        start = replace(start, coordinates=driven_coordinates(compiled, t))
    targets = [(compiled.coordinate(x), value) for x, value in wanted]
    goals = [number(v, f"assemble: {probe.label}") for probe, v in measures.items()]
    resting = resting_slides(compiled, start, targets)
    found = close_pose(compiled, start, [*targets, *resting], goals, fixed)
    if resting and not found.is_met:
        found = close_pose(compiled, start, targets, goals, fixed)
    check_closed(found, [*asked, *(probe.label for probe in probes)], fixed)
    notes, closed = ambiguities(found), found.state
    data = compiled.data()
    load_state(compiled, data, closed)
    moving = with_velocities(compiled, data, closed, rates, near=near)
    own = tables_of(system).model.coordinate.size  # others belong to measures that only this call knows
    moved = moved_report(system, pose, closed)
    return replace(moving, coordinates=closed.coordinates[:own], moved=moved, notes=notes)


def resting_slides(compiled: Compiled, start: State, targets: list[tuple[int, float]]) -> list[tuple[int, float]]:
    """Slides of gears, at the start, that nobody asks for: helical ones could slide where they are meant to turn."""
    asked = {i for i, _ in targets}
    meshes = [joint for joint in compiled.system.joints if isinstance(joint, GearMesh)]
    hinges = {hinge: None for mesh in meshes for hinge in mesh.partners() if isinstance(hinge, Cylindrical)}
    numbers = [compiled.coordinate(hinge.slide()) for hinge in hinges]
    known = {} if start.coordinates is None else dict(enumerate(start.coordinates))
    return [(i, float(known.get(i, 0.0))) for i in numbers if i not in asked]


def mapping(given: Mapping | None, what: str) -> Mapping:
    """What is asked for; None = nothing."""
    if not isinstance(given, Mapping | None):
        raise InputError(f"assemble: {what} = {shown(given)} is not a mapping; give e.g. {{hinge: 0.3}}")
    return given or {}


def check_closed(found: Found, asked: list[str], pinned: set[int]) -> None:
    """AssemblyError with the gap and the joint where the pose does not close or misses a target.

    ``asked``: names of the targets and of the goals.
    """
    equations = found.equations
    if found.gap > CLOSED_GAP_MAX:  # show the gap where the loop closes
        compiled, task = equations.compiled, (equations.targets, equations.goals, pinned)
        residual = newton(compiled, found.start, *task, loop_weights(compiled))[1]
        part, gap = worst_joint(compiled, residual)
        wanted, other = (f" with this {', '.join(asked)}", "give other angles or values, ") if asked else ("", "")
        raise AssemblyError(
            f"the mechanism cannot close{wanted}, a gap remains (m or rad)",
            part=part, residual=gap, time=found.start.t,
            advice=f"check positions and lengths, {other}or see system.check()",
        )  # fmt: skip
    if not found.is_met:
        miss = equations.misses()
        k = int(np.argmax(np.abs(miss)))
        raise AssemblyError(
            f"the mechanism closes but misses the {asked[k]} asked for by {miss[k]:.6g} rad or m",
            part="assemble", residual=float(miss[k]), time=found.start.t,
            advice="the value is out of reach; give one within the mechanism's range or a better start with near=",
        )  # fmt: skip


def moved_report(system: Mechanism, start: State, end: State) -> dict[str, tuple[float, float]]:
    """How far each body moved: distance of O [m] and angle [rad]."""
    a, b = start.q.reshape(-1, 7), end.q.reshape(-1, 7)
    shifts = np.linalg.norm(b[:, :3] - a[:, :3], axis=1)
    turns = np.linalg.norm(logarithm(multiply(b[:, 3:], conjugate(a[:, 3:]))), axis=1)
    names = [system.name(body) for body in system.bodies]
    return dict(zip(names, zip(shifts.tolist(), turns.tolist(), strict=True), strict=True))
