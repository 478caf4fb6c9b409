"""Couplings, drivers and contacts in Exudyn: conditions on hinge coordinates, on rates, and on velocities of points.

Contacts without slip, for which Exudyn has no element, are rows D (V_b - V_a) = 0 at a point of space, V the velocity
of the matter of each body there: functions of Python; everything else is Exudyn's.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from mbsd3d import (
    GROUND,
    AngleDriver,
    Constant,
    Gear,
    GearMesh,
    Joint,
    KnifeEdge,
    PositionDriver,
    RackPinion,
    Rolling,
    RollingDisc,
    Signal,
    SlideDriver,
    SpeedDriver,
)
from mbsd3d.extend import Coordinate, cross, exponential, matrix, skew
from validation.twins.base import Array, speed_of
from validation.twins.exudyn.assembly import Assembly, ForceModel
from validation.twins.laws.moving import Placed, deepest, follow, one_axis

Add = Callable[[Assembly, Any, str], None]  # elements of a joint or force, which errors name so


def hinge_coordinate(model: ForceModel, x: Coordinate, what: str) -> int:
    """Return the marker of a hinge coordinate, which Exudyn measures about one axis."""
    one_axis(x, what, "Exudyn measures an angle about one axis")
    return model.coordinate(x)


def couple(model: Assembly, joint: Joint, driven: Coordinate, ratio: float, by: Coordinate, what: str) -> None:
    """Add the condition driven = ratio by."""
    markers = [hinge_coordinate(model, x, what) for x in (driven, by)]
    model.connect(joint, model.items.ObjectConnectorCoordinate(markerNumbers=markers, factor1=ratio))


def prescribe(model: Assembly, joint: Joint, x: Coordinate, signal: Signal, what: str) -> None:
    """Add the condition x = f(t)."""
    given: dict[str, Any] = {"offset": signal.value} if isinstance(signal, Constant) else {}
    if not given:
        place, rate = follow(signal), follow(signal, 1)
        given["offsetUserFunction"] = lambda mbs, t, item, offset: place(t)
        given["offsetUserFunction_t"] = lambda mbs, t, item, offset: rate(t)
    markers = [model.zero, hinge_coordinate(model, x, what)]
    model.connect(joint, model.items.ObjectConnectorCoordinate(markerNumbers=markers, **given))


def add_position_driver(model: Assembly, joint: PositionDriver, what: str) -> None:
    """Prescribe displacements along world axes."""
    for axis, signal in zip(np.eye(3), joint.signal, strict=True):
        if signal is not None:
            x = Coordinate("slide", joint.a, joint.b, axis, axis, joint.at, joint.at)
            prescribe(model, joint, x, signal, what)


def add_speed_driver(model: Assembly, joint: SpeedDriver, what: str) -> None:
    """Add x_dot = f(t) of an angle or a displacement, a condition on velocities."""
    x, speed = speed_of(joint, what, "Exudyn"), follow(joint.speed)
    moving = {}
    if not isinstance(joint.speed, Constant):
        moving = {"offsetUserFunction_t": lambda mbs, t, item, offset: speed(t)}
    markers, first = [model.zero, model.coordinate(x, counted=False)], speed(model.state.t)
    item = model.items.ObjectConnectorCoordinate(markerNumbers=markers, velocityLevel=True, offset=first, **moving)
    model.connect(joint, item)


COUPLINGS: dict[type, Add] = {
    Gear: lambda model, j, what: couple(model, j, j.hinge_b.angle(), j.ratio, j.hinge_a.angle(), what),
    RackPinion: lambda model, j, what: couple(model, j, j.rack.slide(), j.radius, j.pinion.angle(), what),
    AngleDriver: lambda model, j, what: prescribe(model, j, j.hinge.angle(), j.signal, what),
    SlideDriver: lambda model, j, what: prescribe(model, j, j.slider.slide(), j.signal, what),
    PositionDriver: add_position_driver,
    SpeedDriver: add_speed_driver,
}
"""Class -> what adds its elements."""


@dataclass(frozen=True, eq=False)
class Pose(Placed):
    """Pose of a body, with the map from Exudyn's velocities of its node to w."""

    spin: Array

    def velocity_of(self, point: Array) -> Array:
        """Return the matrix from Exudyn's velocities to that of the material point at a point of space, shape (3,
        m)."""
        return np.hstack([np.eye(3), -skew(point - self.r) @ self.spin])


def pose(model: Assembly, body: Any, q: Array) -> Pose:
    """Return the pose from all coordinates of its node; the ground has no node."""
    if body is GROUND:
        return Pose(body, np.zeros(3), np.eye(3), np.zeros((3, 0)))
    e = exponential(q[3:]) if model.rotation == "rotation vector" else q[3:]
    return Pose(body, q[:3], matrix(e), model.spin(e))


def add_contact(
    model: Assembly, joint: Joint, contact: Callable[[Pose, Pose, Any], tuple[Array, Array]], rows: int
) -> None:
    """Add rows of ``contact(a, b, mbs)`` = (point, directions (rows, 3))."""

    def jacobian(mbs: Any, t: float, item: int, q: Any, q_t: Any, on_velocities: bool) -> Array:
        q = np.array(q)
        sizes = [0 if body is GROUND else len(q) // sides for body in (joint.a, joint.b)]
        a, b = pose(model, joint.a, q[: sizes[0]]), pose(model, joint.b, q[sizes[0] :])
        point, directions = contact(a, b, mbs)
        blocks = [sign * directions @ side.velocity_of(point) for sign, side in ((-1.0, a), (1.0, b)) if side.spin.size]
        return np.hstack(blocks)

    def residual(mbs: Any, t: float, item: int, q: Any, q_t: Any, on_velocities: bool) -> Array:
        return jacobian(mbs, t, item, q, q_t, on_velocities) @ np.array(q_t)

    sides = sum(body is not GROUND for body in (joint.a, joint.b))
    nodes = [model.zero_node if body is GROUND else model.nodes[id(body)] for body in (joint.a, joint.b)]
    markers = [model.mbs.AddMarker(model.items.MarkerNodeCoordinates(nodeNumber=node)) for node in nodes]
    item = model.items.ObjectConnectorCoordinateVector(
        markerNumbers=markers, scalingMarker0=np.zeros((rows, 1)), velocityLevel=True,
        constraintUserFunction=residual, jacobianUserFunction=jacobian,
    )  # fmt: skip
    model.connect(joint, item)


def add_knife_edge(model: Assembly, joint: KnifeEdge, what: str) -> None:
    """Add the condition that the point of b does not move along a direction of b."""
    add_contact(model, joint, lambda a, b, mbs: (b.point(joint.at_b), b.axis(joint.lateral)[None]), 1)


def add_rolling(model: Assembly, joint: RollingDisc, what: str) -> None:
    """Add the joint of Exudyn for a sharp rim, else all three components of the velocity at the point of a torus."""
    if joint.crown:
        add_contact(model, joint, lambda a, b, mbs: (lowest(joint, a, b), np.eye(3)), 3)
        return
    # rows on velocities do not ask where the plane lies, and Exudyn wants its marker in the body's O
    markers = [model.marker(joint.a, joint.a.position), model.marker(joint.b, joint.centre)]
    disc = model.items.ObjectJointRollingDisc(
        markerNumbers=markers, discRadius=joint.radius, discAxis=joint.axis, planeNormal=joint.plane[1]
    )
    model.connect(joint, disc)


def add_rolling_surface(model: Assembly, joint: Rolling, what: str) -> None:
    """Add all three components of the velocity at the lowest point of a rounded ellipsoid."""
    form = joint.outline

    def contact(a: Pose, b: Pose, mbs: Any) -> tuple[Array, Array]:
        return deepest(b, form, a.axis(joint.plane[1])), np.eye(3)

    add_contact(model, joint, contact, 3)


def add_mesh(model: Assembly, joint: GearMesh, what: str) -> None:
    """Add a tooth mesh: the gears do not slip along the line of action at the pitch point of the carrier."""
    carrier, n = joint.support(), joint.direction()

    def contact(a: Pose, b: Pose, mbs: Any) -> tuple[Array, Array]:
        frame = carried(model, mbs, carrier)
        return frame.point(joint.at), frame.axis(n)[None]

    add_contact(model, joint, contact, 1)


def carried(model: Assembly, mbs: Any, body: Any) -> Pose:
    """Return the pose, from Exudyn, of a body that no row moves."""
    if body is GROUND:
        return pose(model, body, np.zeros(0))
    kinds, number = model.module.OutputVariableType, model.body[id(body)]
    r, R = (mbs.GetObjectOutputBody(number, kind, [0.0, 0.0, 0.0]) for kind in (kinds.Position, kinds.RotationMatrix))
    return Pose(body, np.array(r), np.reshape(R, (3, 3)), np.zeros((3, 0)))


def lowest(joint: RollingDisc, a: Pose, b: Pose) -> Array:
    """Return the point of the torus nearest to the plane: down the disc by radius - crown, down the plane's normal by
    crown.
    """
    n, u = a.axis(joint.plane[1]), b.axis(joint.axis)
    steepest = cross(u, cross(u, n))
    return b.point(joint.centre) + (joint.radius - joint.crown) * steepest / np.linalg.norm(steepest) - joint.crown * n
