"""Consistent states: poses along the motion of the mechanism, velocities by least kinetic energy."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..base.checks import number, short_repr
from ..base.concurrency import on_one_thread
from ..base.errors import AssemblyError, InputError
from ..equations.at_state import coordinate_row, driven_coordinates, load_state, worst_joint
from ..equations.compiled import Compiled, compile_system, initial_states, modes_at, tables_of
from ..kernels.layout import Data
from ..mechanism.bodies import Body
from ..mechanism.couplings import GearMesh
from ..mechanism.joints import coordinate_of, slide_of
from ..mechanism.joints.pairs import Cylindrical
from ..mechanism.measures import POSE_MEASURES, Measure, check_members
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from .conflicting_drivers import find_contradiction, rivals
from .elimination import loop_weights
from .engagement import joint_modes, modes_without_locks
from .poses.closing import Found, ambiguities, close_pose
from .poses.pose_equations import CLOSED_GAP_MAX, displacements, gap_size, newton
from .velocities import with_velocities


def reference_pose(system: Mechanism, t: float = 0.0, coordinates: np.ndarray | None = None) -> State:
    """Return poses and internal states as described; velocities are zero."""
    q = np.concatenate([x for body in system.bodies for x in (body.position, body.orientation)])
    return State.of_numbers(t, q, np.zeros(6 * len(system.bodies)), initial_states(system), coordinates)


def reference_state(system: Mechanism, as_built: float | None) -> State:
    """Return the reference pose with consistent velocities, if all joints close there (to the fit tolerance)."""
    compiled = compile_system(system)
    play = 0.0 if as_built is None else number(as_built, "as_built", positive=True)
    tolerance = max(CLOSED_GAP_MAX, play / compiled.model.length)
    data = compiled.data()
    zero = np.zeros(compiled.model.coordinate.size)
    pose = closed_or_error(compiled, data, reference_pose(system, 0.0, zero), tolerance)
    return with_velocities(compiled, data, pose, {}, tolerance=10.0 * tolerance)


def closed_or_error(compiled: Compiled, data: Data, pose: State, tolerance: float) -> State:
    """Return the pose, loaded into ``data``, or raise an AssemblyError with the joint."""
    load_state(compiled, data, pose)
    if gap_size(compiled, data.row["c"]) <= tolerance:
        return pose
    clash = find_contradiction(compiled, data, pose.t, pose.t)
    if clash is not None:
        raise clash.error()
    turned = after_whole_turns(compiled, pose, tolerance)
    if turned is not None:
        load_state(compiled, data, turned)
        return turned
    part, gap = worst_joint(compiled, data.row["c"])
    raise AssemblyError(
        "the reference pose does not close (m or rad)",
        part=part, residual=gap, time=pose.t,
        advice="start from system.assemble(), correct the part's position (at_b, axis_b, driver at t = 0), or give "
        "as_built for parts out of line",
    )  # fmt: skip


def after_whole_turns(compiled: Compiled, pose: State, tolerance: float) -> State | None:
    """Return the reference pose with the turns that drivers ask for, if their way leads back to it; else None."""
    if not compiled.drives:
        return None
    found = close_pose(compiled, pose, [], [], set(), tolerance)
    moved = moved_report(compiled.system, pose, found.state)
    if found.gap > tolerance or max(max(x / compiled.model.length, turn) for x, turn in moved.values()) > tolerance:
        return None
    return replace(pose, coordinates=found.state.coordinates)


@on_one_thread
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
    rates, measures = mapping(rates, "rates"), mapping(measures, "measures")
    modes = modes_without_locks(system, modes_at(system, near)) if near is not None and near.modes else {}
    compiled = compile_system(
        system, probes_of_poses(system, measures), modes=joint_modes(system, modes) if modes else None
    )
    asked = asked_coordinates(compiled, mapping(angles, "angles"), mapping(slides, "slides"))
    targets = [(i, value) for _, i, value in asked]
    goals = [number(value, f"assemble: {probe.label}") for probe, value in measures.items()]
    if not isinstance(pinned, Sequence) or isinstance(pinned, str):
        raise InputError(f"assemble: pinned = {short_repr(pinned)} is not a sequence; give a list of bodies")
    fixed = {compiled.body_index[id(system.part(body))] for body in pinned}
    pose = near or reference_pose(system, t)
    start = State(t, pose.q, pose.v, pose.z, pose.coordinates)
    if near is not None and near.coordinates is None:
        start = replace(start, coordinates=driven_coordinates(compiled, t))
    resting = resting_slides(compiled, start, targets)
    found = close_pose(compiled, start, [*targets, *resting], goals, fixed)
    if resting and not found.is_met:
        found = close_pose(compiled, start, targets, goals, fixed)
    check_closed(found, [name for name, _, _ in asked] + [probe.label for probe in measures], fixed)
    notes, closed, data = ambiguities(found), found.state, compiled.data()
    load_state(compiled, data, closed)
    moving = with_velocities(compiled, data, closed, rates, near=near)
    own = tables_of(system).model.coordinate.size  # others belong to measures that only this call knows
    moved = moved_report(system, pose, closed)
    return replace(moving, coordinates=found.equations.values()[:own], modes=modes, moved=moved, notes=notes)


def probes_of_poses(system: Mechanism, measures: Mapping) -> tuple[Measure, ...]:
    """Return the measures asked for, or raise an InputError for one that does not follow from a pose."""
    for probe in measures:
        if not isinstance(probe, Measure):
            raise InputError(f"assemble: {short_repr(probe)} is not a measure; build one with mbsd3d.measures")
        if probe.kind not in POSE_MEASURES:
            raise InputError(f"assemble: {probe.label} does not follow from a pose; give speeds as rates=")
        check_members(system, probe, "assemble")
    return tuple(measures)


def asked_coordinates(compiled: Compiled, angles: Mapping, slides: Mapping) -> list[tuple[str, int, float]]:
    """Return (name, number of the hinge coordinate, value) of every angle and slide asked for."""
    asked, system = [], compiled.system
    for values, kind in ((angles, "angle"), (slides, "slide")):
        for key, value in values.items():
            joint = system.part(key, "joints")
            x = coordinate_of(joint, kind, f"assemble: {kind}s")
            name = f"{kind} of '{system.name(joint)}'"
            asked.append((name, compiled.coordinate(x), number(value, f"assemble: {name}")))
    return asked


def resting_slides(compiled: Compiled, start: State, targets: list[tuple[int, float]]) -> list[tuple[int, float]]:
    """Return the slides of gears that nobody asks for, as they are: helical gears could slide instead of turning."""
    asked = {i for i, _ in targets}
    gears = [hinge for joint in compiled.system.joints if isinstance(joint, GearMesh) for hinge in joint.partners()]
    slides = {compiled.coordinate(slide_of(hinge)) for hinge in gears if isinstance(hinge, Cylindrical)} - asked
    if not slides:
        return []
    data = compiled.data()
    load_state(compiled, data, start)
    return [(i, float(coordinate_row(compiled, data, i, start.t)[0])) for i in sorted(slides)]


def mapping(given: Mapping | None, what: str) -> Mapping:
    """Return what is asked for as a dict; None = nothing."""
    if not isinstance(given, Mapping | None):
        raise InputError(f"assemble: {what} = {short_repr(given)} is not a mapping; give e.g. {{hinge: 0.3}}")
    return given or {}


def check_closed(found: Found, asked: list[str], pinned: set[int]) -> None:
    """Raise an AssemblyError with the gap and the joint where the pose does not close or misses a target.

    ``asked``: names of the targets and of the goals.
    """
    equations = found.equations
    if found.gap > CLOSED_GAP_MAX:  # show the gap where the loop closes
        compiled, task = equations.compiled, (equations.targets, equations.goals, pinned)
        clash = rivals(compiled, equations.data, found.start.t, found.start.t)
        if clash is not None:
            raise clash.error()
        residual = newton(compiled, found.start, *task, loop_weights(compiled))[1]
        part, gap = worst_joint(compiled, residual)
        wanted, other = (f" with this {', '.join(asked)}", "give other angles or values, ") if asked else ("", "")
        raise AssemblyError(
            f"the mechanism cannot close{wanted}, a gap remains (m or rad)",
            part=part, residual=gap, time=found.start.t,
            advice=f"{reached(found)}check positions and lengths, {other}or see system.check()",
        )  # fmt: skip
    if not found.is_met:
        miss = equations.misses()
        k = int(np.argmax(np.abs(miss)))
        raise AssemblyError(
            f"the mechanism closes but misses the {asked[k]} asked for by {miss[k]:.6g} rad or m",
            part="assemble", residual=float(miss[k]), time=found.start.t,
            advice=f"{reached(found)}the value is out of reach; give one within the mechanism's range or a better "
            "start with near=",
        )  # fmt: skip


def reached(found: Found) -> str:
    """Return the beginning of an advice: how far the motion leads."""
    share = 1.0 if found.way is None else found.way.gone
    return f"the motion from the start ends after {100.0 * share:.3g} % of the way; " if 0.0 < share < 1.0 else ""


def moved_report(system: Mechanism, start: State, end: State) -> dict[str, tuple[float, float]]:
    """Report how far each body moved: distance of O [m] and angle [rad]."""
    shifts, turns = np.linalg.norm(displacements(start, end).reshape(-1, 2, 3), axis=2).T
    names = [system.name(body) for body in system.bodies]
    return dict(zip(names, zip(shifts.tolist(), turns.tolist(), strict=True), strict=True))
