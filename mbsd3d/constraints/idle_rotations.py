"""Bodies that can turn about an axis while nothing else moves, such as a rod between two ball joints."""

from dataclasses import dataclass

import numpy as np

from ..base.errors import AssemblyError
from ..equations.at_state import joint_point
from ..equations.compiled import Compiled
from ..equations.jacobian import RANK_TOLERANCE, BlockRows, displacement_units, scaled_rows
from ..kernels.layout import Data
from ..mechanism.bodies import GROUND, Body
from ..mechanism.joints import Joint
from ..mechanism.joints.pairs import Spherical

ZERO_INERTIA_RATIO = 1e-12  # [1] of the largest moment of inertia; rounding of a thin rod that is tilted in its body
AXIS_POINT_TOLERANCE = 1e-9  # [model lengths] between an axis and a point on it; rounding is 1e-15


@dataclass(frozen=True)
class Spin:
    """Rotation of one body alone about a world axis (3,) through a point (3,), at the current pose."""

    body: str
    axis: np.ndarray
    joints: tuple[str, ...]  # through which the axis goes
    own: bool  # whether the centre of mass stays where it is
    inertia: float  # about the axis [kg m^2]
    massless: bool  # that is nothing, compared with the body's other moments
    remedy: str

    @property
    def about(self) -> str:
        """Return the axis in words."""
        x, y, z = (float(f"{x:.3g}") + 0.0 for x in self.axis)
        where = " and ".join(f"'{name}'" for name in self.joints)
        own = "its own axis" if self.own else "an axis"
        return f"{own} ({x:g}, {y:g}, {z:g}){f' through {where}' if where else ''}"

    @property
    def text(self) -> str:
        """Return the rotation in words and, where it stops a run, the remedy."""
        if self.massless:
            return f"'{self.body}' spins freely about {self.about} and has no inertia about it; {self.remedy}"
        return f"'{self.body}' spins freely about {self.about}, and nothing else moves with it"


def find_idle_rotations(
    compiled: Compiled, data: Data, rows: BlockRows, members: list[Body] | None = None
) -> list[Spin]:
    """Return the rotations that scaled rows leave free, of bodies with joints to more than one neighbour.

    With one neighbour, a wheel or a pendulum, turning is what the joint is there for. The own columns J_b of a body
    have a null space of one dimension then, and its motion is a pure rotation.
    """
    found = []
    holding: dict[int, list[Joint]] = {id(body): [] for body in compiled.system.bodies}
    for joint in compiled.system.joints:
        for body in {id(body): body for body in joint.bodies() if body is not GROUND}.values():
            holding[id(body)].append(joint)
    for body in compiled.system.bodies if members is None else members:
        joints = holding[id(body)]
        if len({id(other) for joint in joints for other in joint.bodies()}) < 3:
            continue
        own = np.r_[tuple(compiled.rows[id(joint)] for joint in joints)]
        if own.size < 5:
            continue
        on = rows.body[own] == compiled.body_index[id(body)]
        s, Vt = np.linalg.svd((on[:, :, None] * rows.J[own]).sum(axis=1))[1:]
        if (s > RANK_TOLERANCE * s.max(initial=0.0)).sum() == 5:
            spin = spin_of(compiled, data, body, joints, Vt[5] * displacement_units(compiled.model.length, 1))
            found += [spin] if spin else []
    return found


def spin_of(compiled: Compiled, data: Data, body: Body, joints: list[Joint], twist: np.ndarray) -> Spin | None:
    """Return the rotation of a body whose twist (velocity of O, omega) the rows leave free; None if it also moves."""
    velocity, omega = twist[:3], twist[3:]
    length, rate = compiled.model.length, np.linalg.norm(omega)
    if rate * length < 1e-6 * np.linalg.norm(twist) or abs(velocity @ omega) > AXIS_POINT_TOLERANCE * length * rate**2:
        return None
    axis = omega / rate * np.copysign(1.0, omega[np.argmax(np.abs(omega))])
    state = data.body[compiled.body_index[id(body)]]
    R, origin = state["R"].reshape(3, 3), state["r"]
    point = origin + np.cross(omega, velocity) / rate**2
    centre = distance(origin + R @ body.com, point, axis)
    turned = R.T @ axis
    inertia = float(turned @ body.inertia @ turned) + body.mass * centre**2
    largest = float(np.linalg.eigvalsh(body.inertia)[-1]) + body.mass * (
        centre**2 if centre > AXIS_POINT_TOLERANCE * length else 0.0
    )
    through = [joint for joint in joints if near_axis(compiled, data, joint, point, axis)]
    balls = [joint for joint in through if isinstance(joint, Spherical)]
    name = compiled.system.name
    massless = inertia <= ZERO_INERTIA_RATIO * largest
    universal = [f"make Spherical '{name(ball)}' a Universal with both axes across it" for ball in balls[:1]]
    remedies = universal + massless * ["give the body a radius"]
    return Spin(
        body=name(body), axis=axis, joints=tuple(name(joint) for joint in through),
        own=centre <= AXIS_POINT_TOLERANCE * length, inertia=inertia, massless=massless,
        remedy=", or ".join(remedies) or "hold or drive it",
    )  # fmt: skip


def distance(place: np.ndarray, point: np.ndarray, axis: np.ndarray) -> float:
    """Return the distance of a place from the line through a point along a unit axis [m]."""
    return float(np.linalg.norm(np.cross(place - point, axis)))


def near_axis(compiled: Compiled, data: Data, joint: Joint, point: np.ndarray, axis: np.ndarray) -> bool:
    """Return True if the point of the joint lies on the line, at the pose in ``data``."""
    if type(joint).point is Joint.point:
        return False
    return (
        distance(joint_point(compiled, data, joint), point, axis) <= 1e3 * AXIS_POINT_TOLERANCE * compiled.model.length
    )


def check_spins(compiled: Compiled, data: Data) -> None:
    """Raise an AssemblyError where a body without inertia about an axis can turn about it: its rate is undetermined.

    ``data`` holds the pose. Only bodies with a singular inertia are looked at.
    """
    thin = [body for body in compiled.system.bodies if is_thin(body)]
    for spin in find_idle_rotations(compiled, data, scaled_rows(compiled.model, data), thin) if thin else ():
        if spin.massless:
            raise AssemblyError(
                f"the velocity of body '{spin.body}' is not determined: it spins freely about {spin.about} and has no "
                "inertia about it",
                part=f"body '{spin.body}'", advice=spin.remedy,
            )  # fmt: skip


def is_thin(body: Body) -> bool:
    """Return True for a body with mass whose smallest moment of inertia is zero beside its largest."""
    moments = np.linalg.eigvalsh(body.inertia)
    return body.mass > 0.0 and moments[0] <= ZERO_INERTIA_RATIO * moments[-1]
