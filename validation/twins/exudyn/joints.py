"""Every joint that Exudyn has an element for: how, and its frames.

A frame is three columns, world at the reference pose. Exudyn locks directions of the frame on body a (0..2 shifts,
3..5 turns); with two turns locked the third axis of frame a stays across the other two of frame b, with one locked the
first axis of a stays across the second of b.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

import mbsd3d
from mbsd3d import GearMesh, Joint, KnifeEdge, RollingDisc
from mbsd3d.extend import Coordinate, cross, matched_perpendiculars, perpendiculars
from validation.twins.base import Array, label, refused
from validation.twins.exudyn.assembly import Assembly
from validation.twins.exudyn.couplings import COUPLINGS, Expression, add_knife_edge, add_mesh, add_rolling, couple


def frames_along(axis: Array, axis_b: Array, place: int) -> tuple[Array, Array]:
    """Frames on a and b whose axis number ``place`` is the joint's axis."""
    first = np.column_stack([*perpendiculars(axis), axis])
    second = np.column_stack([*matched_perpendiculars(axis, axis_b), axis_b])
    return np.roll(first, place - 2, axis=1), np.roll(second, place - 2, axis=1)


def frames_across(axis_a: Array, axis_b: Array) -> tuple[Array, Array]:
    """Frames with first axis ``axis_a`` on a, second axis ``axis_b`` on b."""
    z = cross(axis_a, axis_b)
    z /= np.linalg.norm(z)
    return np.column_stack([axis_a, cross(z, axis_a), z]), np.column_stack([cross(axis_b, z), axis_b, z])


def generic(locked: tuple[int, ...], frames: Callable[[Any], tuple[Array, Array]]) -> Callable:
    """A joint that locks directions of its frames."""

    def add(model: Assembly, joint: Joint, what: str) -> None:
        axes_a, axes_b = frames(joint)
        at, at_b = getattr(joint, "at", joint.a.position), getattr(joint, "at_b", joint.b.position)
        markers = [model.marker(joint.a, at, axes_a), model.marker(joint.b, at_b, axes_b)]
        model.connect(joint, model.items.ObjectJointGeneric(markerNumbers=markers, constrainedAxes=locked))

    return add


def along(place: int) -> Callable[[Any], tuple[Array, Array]]:
    """Frames along axis and axis_b."""
    return lambda joint: frames_along(joint.axis, joint.axis_b, place)


def one_sided(joint: Joint) -> tuple[Array, Array]:
    """Frames along the axis or normal of a; only a's matters."""
    axis = joint.normal if hasattr(joint, "normal") else joint.axis
    return frames_along(axis, axis, 2)


def crossed(joint: Joint) -> tuple[Array, Array]:
    """Frames of axis_a and axis_b."""
    return frames_across(joint.axis_a, joint.axis_b)


def add_spherical(model: Assembly, joint: Joint, what: str) -> None:
    """Points coincide."""
    markers = [model.marker(joint.a, joint.at), model.marker(joint.b, joint.at_b)]
    model.connect(joint, model.items.ObjectJointSpherical(markerNumbers=markers))


def add_constant_velocity(model: Assembly, joint: Joint, what: str) -> None:
    """Points coincide; no turn about the bisector: (axis_a + axis_b) . (w_b - w_a) = 0, kept as velocities."""
    add_spherical(model, joint, what)
    turn_a = Coordinate("angle", joint.a, joint.b, joint.axis_a, joint.axis_a)
    turn_b = Coordinate("angle", joint.b, joint.a, joint.axis_b, joint.axis_b)
    markers = [model.coordinate(x, counted=False) for x in (turn_a, turn_b)]
    model.connect(joint, model.items.ObjectConnectorCoordinate(markerNumbers=markers, velocityLevel=True))


def add_distance(model: Assembly, joint: Joint, what: str) -> None:
    """Constant distance."""
    markers = [model.marker(joint.a, joint.at_a), model.marker(joint.b, joint.at_b)]
    model.connect(joint, model.items.ObjectConnectorDistance(markerNumbers=markers, distance=joint.length))


def add_screw(model: Assembly, joint: Joint, what: str) -> None:
    """A cylindrical joint and slide = pitch angle / (2 pi)."""
    generic((1, 1, 0, 1, 1, 0), along(2))(model, joint, what)
    couple(model, joint, joint.slide(), joint.pitch / (2 * np.pi), joint.angle(), what)


JOINTS: dict[type, Expression] = {
    mbsd3d.Spherical: Expression("SphericalJoint", add_spherical),
    mbsd3d.Revolute: Expression("GenericJoint, turn about z free", generic((1, 1, 1, 1, 1, 0), along(2))),
    mbsd3d.Universal: Expression("GenericJoint, x of a across y of b", generic((1, 1, 1, 0, 0, 1), crossed)),
    mbsd3d.Prismatic: Expression("GenericJoint, shift along x free", generic((0, 1, 1, 1, 1, 1), along(0))),
    mbsd3d.Cylindrical: Expression("GenericJoint, shift and turn along z free", generic((1, 1, 0, 1, 1, 0), along(2))),
    mbsd3d.Planar: Expression(
        "GenericJoint, shifts in xy and turn about z free", generic((0, 0, 1, 1, 1, 0), one_sided)
    ),
    mbsd3d.Fixed: Expression(
        "GenericJoint, all locked", generic((1, 1, 1, 1, 1, 1), lambda joint: (np.eye(3), np.eye(3)))
    ),
    mbsd3d.PointOnLine: Expression("GenericJoint, shifts across z locked", generic((1, 1, 0, 0, 0, 0), one_sided)),
    mbsd3d.PointOnPlane: Expression("GenericJoint, shift along z locked", generic((0, 0, 1, 0, 0, 0), one_sided)),
    mbsd3d.Distance: Expression("DistanceConstraint", add_distance),
    mbsd3d.Parallel: Expression("GenericJoint, turns about x and y locked", generic((0, 0, 0, 1, 1, 0), along(2))),
    mbsd3d.Perpendicular: Expression("GenericJoint, x of a across y of b", generic((0, 0, 0, 0, 0, 1), crossed)),
    mbsd3d.ConstantVelocity: Expression(
        "SphericalJoint and CoordinateConstraint of two rates about the shafts, on velocities", add_constant_velocity
    ),
    mbsd3d.Screw: Expression("GenericJoint (cylindrical) and CoordinateConstraint of slide and angle", add_screw),
    **COUPLINGS,
    RollingDisc: Expression(
        "RollingDiscJoint, all rows on velocities; a rounded rim by CoordinateVectorConstraint with the rows in Python",
        add_rolling,
    ),
    GearMesh: Expression("CoordinateVectorConstraint with the row in Python, on velocities", add_mesh),
    KnifeEdge: Expression("CoordinateVectorConstraint with the row in Python, on velocities", add_knife_edge),
}
"""Joint class -> how it is expressed."""


def add_joint(model: Assembly, joint: Joint) -> None:
    """Add a joint, or NotExpressible with its name."""
    if type(joint) not in JOINTS:
        raise refused(model.system, joint, {}, "Exudyn has no element for it")
    JOINTS[type(joint)].add(model, joint, label(model.system, joint))
