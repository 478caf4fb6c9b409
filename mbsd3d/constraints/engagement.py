"""Joints that engage or let go at the pose of the moment: the new system, and the plastic impact that starts it.

The joint engages at once, at the pose q and with all other joints closed. With the velocities v before and u after it

    M (u - v) + J' L = 0,   J u = b,        lost = (u - v)' M (u - v) / 2

over the rows J of all joints; L are the impulses of the multipliers. u is the motion nearest to v in the sense of
kinetic energy, so momentum is kept and energy is lost. Where rows are redundant, L has the least norm.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from scipy.sparse import csr_array, eye_array

from ..base.concurrency import one_thread
from ..base.errors import AssemblyError, InputError
from ..base.rotations import conjugate, matrix, multiply
from ..base.style import html_table
from ..equations.at_state import joint_point, load_state, worst_joint
from ..equations.compiled import Compiled, compile_system, first_modes, holders_of, modes_at
from ..equations.dense_solvers import mass_matrix_of, reflected_rows
from ..equations.jacobian import BlockRows, block_rows, displacement_units, scaled
from ..kernels import kinds
from ..kernels.layout import Data, Model
from ..mechanism.bodies import GROUND, Body, Ground
from ..mechanism.couplings import Coupling
from ..mechanism.drivers import Driver
from ..mechanism.engaged import Engaged
from ..mechanism.force_element import ForceElement
from ..mechanism.joints import Joint
from ..mechanism.lock import Lock
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from ..mechanism.switching import Mode, is_switching
from .least_squares import SMALL_SYSTEM_BODIES_MAX, Matrix, deficient, least
from .poses.pose_equations import CLOSED_GAP_MAX, gap_size
from .rank import redundant_combinations
from .velocities import least_energy

OPEN_SHARE_MAX = 1e-7  # [1] of a unit impulse: what redundant rows may change of a determined one; rounding


@dataclass(frozen=True, repr=False)
class Impulse:
    """Impulse of a joint on body b at its point, world axes: force [N s], moment [N m s], and point [m], (3,) each.

    ``unique`` says whether the constraints determine it; if not, it is the share of least norm.
    """

    force: np.ndarray
    moment: np.ndarray
    point: np.ndarray
    unique: bool

    def __repr__(self) -> str:
        force, moment = (np.array2string(x, precision=6, separator=", ") for x in (self.force, self.moment))
        return f"<impulse {force} N s, {moment} N m s{'' if self.unique else ', not unique'}>"


M = TypeVar("M", bound=Mechanism)


@dataclass(frozen=True, eq=False, repr=False)
class Engagement(Generic[M]):
    """A system after a joint has engaged or been released, and the state from which it moves on.

    ``joint`` is the part of the new system, None after a release. ``lost`` [J] is the energy that the impact takes,
    ``work`` [J] what drivers give to it; ``impulses`` has the impulse of every joint by name.
    """

    system: M
    joint: Joint | None
    state: State
    lost: float
    work: float
    impulses: dict[str, Impulse] = field(default_factory=dict)

    @property
    def impulse(self) -> Impulse:
        """Return the impulse of the joint that engaged; ValueError after a release."""
        if self.joint is None:
            raise InputError("a release has no impulse; read .state")
        return self.impulses[self.system.name(self.joint)]

    def __repr__(self) -> str:
        if self.joint is None:
            return f"<released at t = {self.state.t:g} s>"
        name = self.system.name(self.joint)
        return f"<'{name}' engaged at t = {self.state.t:g} s, {self.lost:.6g} J lost>"

    def _repr_html_(self) -> str:
        rows = [(name, str(x.force.round(6)), str(x.moment.round(6)), "" if x.unique else "no")
                for name, x in self.impulses.items()]  # fmt: skip
        return html_table(repr(self).strip("<>"), ("joint", "impulse [N s]", "[N m s]", "unique"), rows)


def engage(system: M, joint: Joint, state: State) -> Engagement[M]:
    """Engage a joint at a state; see `System.engage`."""
    joint = joint.joint if isinstance(joint, Engaged) else joint
    check_engaging(system, joint)
    compiled, data = loaded(system, state)
    made = joint_at(compiled, data, joint, state)
    new = with_joints(system, (*system.joints, made))
    after = compile_system(new, modes=joint_modes(new, carried_modes(system, state, new)))
    pose = carried(state, compiled, data, after)
    data = after.data()
    load_state(after, data, pose)
    check_closed(after, data, new.name(made), state.t)
    struck = strike(after, data, pose)
    moving = replace(pose, v=struck.v, modes=modes_without_locks(new, pose.modes))
    return Engagement(new, made, moving, struck.lost, struck.work, impulses(after, data, struck.rows, struck.lam))


def check_closed(compiled: Compiled, data: Data, name: str, t: float) -> None:
    """Raise an AssemblyError for a joint with which the joints do not close at a state, which is loaded in ``data``."""
    if not gap_size(compiled, data.row["c"]) <= CLOSED_GAP_MAX:
        part, gap = worst_joint(compiled, data.row["c"])
        raise AssemblyError(
            f"'{name}' cannot engage: the joints do not close at this state (m or rad)", part=part,
            residual=gap, time=t, advice="give a state of a run of this system, or one from assemble",
        )  # fmt: skip


def release(system: M, joint: Joint | str, state: State) -> Engagement[M]:
    """Release a joint at a state; see `System.release`."""
    gone = system.part(joint, "joints")
    others: tuple[Joint | ForceElement, ...] = (*system.joints, *system.forces)
    for other in others:
        if gone in other.partners():
            raise InputError(
                f"release: '{system.name(other)}' acts through '{system.name(gone)}'; release or leave out that first"
            )
    compiled, data = loaded(system, state)
    new = with_joints(system, [other for other in system.joints if other is not gone])
    pose = carried(state, compiled, data, compile_system(new))
    return Engagement(new, None, pose, lost=0.0, work=0.0)


def carried(state: State, before: Compiled, data: Data, after: Compiled) -> State:
    """Return a state as that of another system with the same parts: what they count and which of them hold."""
    old, new = before.system, after.system
    modes, coordinates = carried_modes(old, state, new), carried_coordinates(before, data, after)
    return replace(state, coordinates=coordinates, modes=modes, moved={}, notes=())


def carried_modes(old: Mechanism, state: State, new: Mechanism) -> dict[str, Mode]:
    """Return which parts hold, by their names in another system with these parts."""
    stays = [x for x in holders_of(new) if x in holders_of(old) and old.name(x) in state.modes]
    return {new.name(x): Mode(*state.modes[old.name(x)]) for x in stays}


def joint_modes(system: Mechanism, modes: Mapping[str, Mode]) -> dict[str, Mode]:
    """Return the modes with which a system takes an impact: joints as they hold, and what yields or opens as built."""
    joints = {system.name(joint) for joint in system.joints}
    return first_modes(system) | {name: mode for name, mode in modes.items() if name in joints}


def modes_without_locks(system: Mechanism, modes: Mapping[str, tuple[str, tuple[float, ...]]]) -> dict[str, Mode]:
    """Return the modes for other velocities: joints hold as they did, a run finds at its start which locks do."""
    locks = {system.name(x): x for x in system.forces if isinstance(x, Lock)}
    given = {name: Mode(*mode) for name, mode in modes.items()}
    return {name: locks[name].opened(mode) if name in locks else mode for name, mode in given.items()}


def with_joints(system: M, joints: Sequence[Joint]) -> M:
    """Return the system with other joints."""
    limits = [limit for limit in system.limits if limit.joint in joints]
    besides = system.besides() | {"limits": limits}
    return type(system)(system.bodies, joints, system.forces, system.gravity, **besides)


def check_engaging(system: Mechanism, joint: Joint) -> None:
    """Raise an InputError for a joint that cannot engage."""
    if not isinstance(joint, Joint):
        raise InputError(f"engage: {joint!r} is not a joint; give a joint that is not in the system")
    what = f"engage: {type(joint).__name__} '{joint.name or ''}'".replace(" ''", "")
    if joint in system.joints:
        raise InputError(f"{what} is in the system already; give a joint that is not, or release this one first")
    if isinstance(joint, Driver):
        raise InputError(f"{what} is a driver, which moves by its signal at any time; engage a joint instead")
    if is_switching(joint):
        raise InputError(f"{what} switches by itself, which it would not once engaged by hand; engage the joint in it")
    for body in joint.bodies():
        if body is not GROUND and body not in system.bodies:
            raise InputError(f"{what}: body '{body.name}' is not in the system; give joints between its bodies")


def loaded(system: Mechanism, state: State) -> tuple[Compiled, Data]:
    """Return the tables of a system, and its work space at a state."""
    modes = joint_modes(system, modes_at(system, state)) if isinstance(state, State) else {}
    compiled = compile_system(system, modes=modes)
    data = compiled.data()
    load_state(compiled, data, state)
    return compiled, data


def pose_of(system: Mechanism, state: State, body: Body | Ground) -> tuple[np.ndarray, np.ndarray]:
    """Return (reference point [m], unit quaternion) of a body at a state, world."""
    if body is GROUND:
        return GROUND.position, GROUND.orientation
    r, e = np.split(state.q.reshape(-1, 7)[system.bodies.index(body)], [3])
    return r, e / np.linalg.norm(e)


def joint_at(compiled: Compiled, data: Data, joint: Joint, state: State) -> Engaged:
    """Return the joint as it engages at a state, which is loaded in ``data``."""
    system = compiled.system
    if isinstance(joint, Coupling):
        return Engaged(joint, offset=coupling_offset(compiled, data, joint, state), name=joint.name)
    a, b = joint.a, joint.b
    (r_a, e_a), (r_b, e_b) = (pose_of(system, state, body) for body in (a, b))
    # What rests in a at its reference pose is carried by a to this pose, and by b back to the reference pose of b.
    back = multiply(b.orientation, conjugate(e_b))
    turn = multiply(back, multiply(e_a, conjugate(a.orientation)))
    shift = b.position + matrix(back) @ (r_a - r_b) - matrix(turn) @ a.position
    return Engaged(joint, shift=shift, turn=turn, length=rod_length(joint, (r_a, e_a), (r_b, e_b)), name=joint.name)


def rod_length(joint: Joint, *poses: tuple[np.ndarray, np.ndarray]) -> float | None:
    """Return the length [m] that a `Distance` takes at the poses of its bodies, None for other joints."""
    for row in joint.rows():
        if row.kind == kinds.DISTANCE:
            first, second = (
                r + matrix(e) @ body.local_point(x)
                for (r, e), body, x in zip(poses, row.bodies, row.points, strict=True)
            )
            length = float(np.linalg.norm(second - first))
            if length > 0.0:
                return length
            raise InputError(
                f"engage: the end points of '{joint.name}' coincide, so it has no direction; engage a ball"
            )
    return None


def coupling_offset(compiled: Compiled, data: Data, joint: Coupling, state: State) -> float:
    """Return the residual [rad or m] of a coupling of hinges at a state, which is loaded in ``data``."""
    system = compiled.system
    for other in joint.partners():
        if other not in system.joints:
            raise InputError(
                f"engage: '{joint.name}' couples '{other.name}', which is not in the system; couple joints of it"
            )
    after = compile_system(with_joints(system, (*system.joints, joint)))
    work = after.data()
    load_state(after, work, replace(state, coordinates=carried_coordinates(compiled, data, after)))
    return float(work.row["c"][np.flatnonzero(after.row_joint == len(system.joints))[0]])


def carried_coordinates(before: Compiled, data: Data, after: Compiled) -> np.ndarray:
    """Return the hinge coordinates of another system of the same bodies: those it shares, and zero of new joints."""
    known = {key: data.coordinate["value"][i] for key, i in before.coordinate_index.items()}
    return np.array([known.get(key, 0.0) for key in after.coordinate_index])


class Strike(NamedTuple):
    """What an impact does: velocities (6 n,) after it, impulses of the rows (m,), energies [J], and the rows."""

    v: np.ndarray
    lam: np.ndarray
    lost: float
    work: float  # of drivers
    rows: BlockRows
    momenta: np.ndarray  # (6 n,) N s, N m s about O: what rows and reflected inertias give to each body


def strike(
    compiled: Compiled, data: Data, pose: State, active: np.ndarray | None = None, goal: np.ndarray | None = None
) -> Strike:
    """Return the impact M (u - v) + J' L = 0, J u = b at a pose, which is loaded in ``data``.

    ``active``: the rows that take part, None = all; ``goal`` (m,): what stands for b, as -e (J v - b) of a stop.
    """
    model, row = compiled.model, data.row
    rows, few = block_rows(model, data), model.body.size < SMALL_SYSTEM_BODIES_MAX
    J, M = rows.dense() if few else rows.sparse(), mass_matrix_of(model, data, few)
    which = np.arange(row.size) if active is None else np.flatnonzero(active)
    b = row["b"].copy() if goal is None else goal
    free = np.full(6 * model.body.size, np.nan)
    lam = np.zeros(row.size)
    with one_thread():
        u = least_energy(compiled, data, J[which], b[which], free, pose.v, [], 1e-8)
        change = M @ (u - pose.v)
        rotors = reflected_rows(model, data).sparse()
        spun = rotors.T @ (model.reflected["inertia"] * (rotors @ (u - pose.v)))
        lam[which] = multipliers(model, J[which], model.row["scale"][which], change)
    driven = model.row["drive"] >= 0
    work = -float(lam[driven] @ b[driven])
    return Strike(u, lam, work - 0.5 * float((u + pose.v) @ change), work, rows, -(J.T @ lam) - spun)


def multipliers(model: Model, J: Matrix, scale: np.ndarray, change: np.ndarray) -> np.ndarray:
    """Return the impulses L (m,) of the rows with J' L = -change of the momenta, of least norm in scaled rows."""
    n = model.body.size
    units, few = displacement_units(model.length, n), n < SMALL_SYSTEM_BODIES_MAX
    A = scaled(J, scale, units).T
    b = -change * units
    size = max(float(np.abs(b).max(initial=0.0)), 1e-300)
    found = deficient(A, b / size)[0] if few else least(eye_array(scale.size), csr_array(A), b / size, passes=3)
    return found * size * scale


def impulses(compiled: Compiled, data: Data, rows: BlockRows, lam: np.ndarray) -> dict[str, Impulse]:
    """Return the impulse of every joint on its body b, by name."""
    system, scale = compiled.system, compiled.model.row["scale"]
    N = redundant_combinations(rows.scaled(scale, compiled.model.length)) * scale[:, None]
    found = {}
    for k, part in enumerate(compiled.holders):
        joint: Any = part if isinstance(part, Joint) or not part.partners() else part.partners()[0]
        own, body = np.flatnonzero(compiled.row_joint == k), compiled.body_index[id(joint.b)]
        if is_switching(part) and not lam[own].any():
            continue  # open, or not struck
        W = -np.where((rows.body[own] == body)[:, :, None], rows.J[own], 0.0).sum(axis=1)  # (k, 6) of unit multipliers
        point = joint_point(compiled, data, joint)
        force, moment = np.split(W.T @ lam[own], [3])
        moment = moment - np.cross(point - data.body["r"][body], force)
        open_share = np.abs(W.T @ N[own]).max(initial=0.0)
        unique = bool(open_share <= OPEN_SHARE_MAX * np.abs(W).max(initial=0.0))
        found[system.name(part)] = Impulse(force, moment, point, unique)
    return found
