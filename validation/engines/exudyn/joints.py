"""Every joint that Exudyn has an element for: how, and its frames.

A frame is three columns, world at the reference pose. Exudyn locks directions of the frame on body a (0..2 shifts,
3..5 turns); with two turns locked the third axis of frame a stays across the other two of frame b, with one locked the
first axis of a stays across the second of b.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from mbsd3d import joints as j
from mbsd3d.contacts import RollingDisc
from mbsd3d.couplings import Gear, GearMesh, RackPinion
from mbsd3d.drivers import AngleDriver, PositionDriver, SlideDriver, SpeedDriver
from mbsd3d.joints import cross, matched_perpendiculars, perpendiculars
from mbsd3d.primitives import Coordinate
from mbsd3d.signals import Constant

from ..base import Array, NotExpressible
from .assembly import Assembly


class Expression(NamedTuple):
    """One line how, and the function that adds the elements."""

    how: str
    add: Callable[[Assembly, Any, str], None]


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

    def add(model: Assembly, joint: Any, what: str) -> None:
        axes_a, axes_b = frames(joint)
        at = getattr(joint, "at", joint.a.position)
        at_b = getattr(joint, "at_b", joint.b.position)
        markers = [model.marker(joint.a, at, axes_a), model.marker(joint.b, at_b, axes_b)]
        model.connect(joint, model.items.ObjectJointGeneric(markerNumbers=markers, constrainedAxes=list(locked)))

    return add


def along(place: int) -> Callable[[Any], tuple[Array, Array]]:
    """Frames along axis and axis_b."""
    return lambda joint: frames_along(joint.axis, joint.axis_b, place)


def one_sided(joint: Any) -> tuple[Array, Array]:
    """Frames along the axis or normal of a; only a's matters."""
    axis = joint.normal if hasattr(joint, "normal") else joint.axis
    return frames_along(axis, axis, 2)


def crossed(joint: Any) -> tuple[Array, Array]:
    """Frames of axis_a and axis_b."""
    return frames_across(joint.axis_a, joint.axis_b)


def add_spherical(model: Assembly, joint: Any, what: str) -> None:
    """Points coincide."""
    markers = [model.marker(joint.a, joint.at), model.marker(joint.b, joint.at_b)]
    model.connect(joint, model.items.ObjectJointSpherical(markerNumbers=markers))


def add_distance(model: Assembly, joint: Any, what: str) -> None:
    """Constant distance."""
    markers = [model.marker(joint.a, joint.at_a), model.marker(joint.b, joint.at_b)]
    model.connect(joint, model.items.ObjectConnectorDistance(markerNumbers=markers, distance=joint.length))


def add_rolling(model: Assembly, joint: Any, what: str) -> None:
    """All three rows are held as velocities there."""
    if joint.crown:
        raise NotExpressible(f"{what}: crown {joint.crown:g} m; the rolling disc of Exudyn has a sharp rim")
    # rows on velocities do not ask where the plane lies, and Exudyn wants its marker in the body's O
    markers = [model.marker(joint.a, joint.a.position), model.marker(joint.b, joint.centre)]
    disc = model.items.ObjectJointRollingDisc(
        markerNumbers=markers, discRadius=joint.radius, discAxis=joint.axis, planeNormal=joint.plane[1]
    )
    model.connect(joint, disc)


def hinge_coordinate(model: Assembly, x: Coordinate, what: str) -> int:
    """Marker of a hinge coordinate, which Exudyn measures about one axis."""
    if np.linalg.norm(x.axis - x.axis_b) > 1e-12:  # rounding of unit vectors
        raise NotExpressible(f"{what}: the axes on both sides differ as built; Exudyn measures an angle about one axis")
    return model.coordinate(x)


def couple(model: Assembly, joint: Any, driven: Coordinate, ratio: float, by: Coordinate, what: str) -> None:
    """driven = ratio by."""
    markers = [hinge_coordinate(model, x, what) for x in (driven, by)]
    model.connect(joint, model.items.ObjectConnectorCoordinate(markerNumbers=markers, factor1=ratio))


def add_screw(model: Assembly, joint: Any, what: str) -> None:
    """A cylindrical joint and slide = pitch angle / (2 pi)."""
    generic((1, 1, 0, 1, 1, 0), along(2))(model, joint, what)
    couple(model, joint, joint.slide(), joint.pitch / (2 * np.pi), joint.angle(), what)


def add_gear(model: Assembly, joint: Any, what: str) -> None:
    """angle b = ratio angle a."""
    couple(model, joint, joint.hinge_b.angle(), joint.ratio, joint.hinge_a.angle(), what)


def add_rack(model: Assembly, joint: Any, what: str) -> None:
    """slide = radius angle."""
    couple(model, joint, joint.rack.slide(), joint.radius, joint.pinion.angle(), what)


def add_mesh(model: Assembly, joint: Any, what: str) -> None:
    """Angles of the gears on their carrier in a fixed ratio: the same motion, other loads."""
    row, n = joint.primitives[0], joint.direction()
    for hinge in (joint.hinge_a, joint.hinge_b):
        if hinge.slide() is not None and abs(n @ hinge.axis) > 1e-12:  # rounding of unit vectors
            name = model.system.name(hinge)
            raise NotExpressible(f"{what}: its teeth push along '{name}', which slides; Exudyn couples angles only")
    a, b = row.coordinates
    couple(model, joint, b, -row.values[0] / row.values[1], a, what)


def prescribe(model: Assembly, x: Coordinate, signal: Any, what: str) -> Any:
    """x = f(t)."""
    markers = [model.zero, hinge_coordinate(model, x, what)]
    if isinstance(signal, Constant):
        return model.items.ObjectConnectorCoordinate(markerNumbers=markers, offset=signal.value)
    return model.items.ObjectConnectorCoordinate(
        markerNumbers=markers,
        offsetUserFunction=lambda mbs, t, item, offset: float(signal(t)),
        offsetUserFunction_t=lambda mbs, t, item, offset: float(signal.derivative(t)),
    )


def add_angle_driver(model: Assembly, joint: Any, what: str) -> None:
    """theta = f(t)."""
    model.connect(joint, prescribe(model, joint.hinge.angle(), joint.signal, what))


def add_slide_driver(model: Assembly, joint: Any, what: str) -> None:
    """s = f(t)."""
    model.connect(joint, prescribe(model, joint.slider.slide(), joint.signal, what))


def add_position_driver(model: Assembly, joint: Any, what: str) -> None:
    """Displacements along world axes."""
    for axis, signal in zip(np.eye(3), joint.signal, strict=True):
        if signal is not None:
            x = Coordinate("slide", joint.a, joint.b, axis, axis, joint.at, joint.at)
            model.connect(joint, prescribe(model, x, signal, what))


def add_speed_driver(model: Assembly, joint: Any, what: str) -> None:
    """x_a . (w_b - w_a) = f(t), a condition on velocities."""
    x, signal = Coordinate("angle", joint.a, joint.b, joint.axis, joint.axis), joint.speed
    moving = {}
    if not isinstance(signal, Constant):
        moving = {"offsetUserFunction_t": lambda mbs, t, item, offset: float(signal(t))}
    model.connect(
        joint,
        model.items.ObjectConnectorCoordinate(
            markerNumbers=[model.zero, model.coordinate(x, counted=False)],
            velocityLevel=True,
            offset=float(signal(0.0)),
            **moving,
        ),
    )


JOINTS: dict[type, Expression] = {
    j.Spherical: Expression("SphericalJoint", add_spherical),
    j.Revolute: Expression("GenericJoint, turn about z free", generic((1, 1, 1, 1, 1, 0), along(2))),
    j.Universal: Expression("GenericJoint, x of a across y of b", generic((1, 1, 1, 0, 0, 1), crossed)),
    j.Prismatic: Expression("GenericJoint, shift along x free", generic((0, 1, 1, 1, 1, 1), along(0))),
    j.Cylindrical: Expression("GenericJoint, shift and turn along z free", generic((1, 1, 0, 1, 1, 0), along(2))),
    j.Planar: Expression("GenericJoint, shifts in xy and turn about z free", generic((0, 0, 1, 1, 1, 0), one_sided)),
    j.Fixed: Expression("GenericJoint, all locked", generic((1, 1, 1, 1, 1, 1), lambda joint: (np.eye(3), np.eye(3)))),
    j.PointOnLine: Expression("GenericJoint, shifts across z locked", generic((1, 1, 0, 0, 0, 0), one_sided)),
    j.PointOnPlane: Expression("GenericJoint, shift along z locked", generic((0, 0, 1, 0, 0, 0), one_sided)),
    j.Distance: Expression("DistanceConstraint", add_distance),
    j.Parallel: Expression("GenericJoint, turns about x and y locked", generic((0, 0, 0, 1, 1, 0), along(2))),
    j.Perpendicular: Expression("GenericJoint, x of a across y of b", generic((0, 0, 0, 0, 0, 1), crossed)),
    j.Screw: Expression("GenericJoint (cylindrical) and CoordinateConstraint of slide and angle", add_screw),
    Gear: Expression("CoordinateConstraint of two angles", add_gear),
    RackPinion: Expression("CoordinateConstraint of slide and angle", add_rack),
    GearMesh: Expression("CoordinateConstraint of two angles (motion only: no tooth force on the bearings)", add_mesh),
    RollingDisc: Expression("RollingDiscJoint, all rows on velocities; sharp rim only", add_rolling),
    AngleDriver: Expression("CoordinateConstraint with offset f(t)", add_angle_driver),
    SlideDriver: Expression("CoordinateConstraint with offset f(t)", add_slide_driver),
    PositionDriver: Expression("CoordinateConstraint per direction with offset f(t)", add_position_driver),
    SpeedDriver: Expression("CoordinateConstraint on velocities", add_speed_driver),
}
"""Joint class -> how it is expressed."""

REFUSED: dict[str, str] = {
    "ConstantVelocity": "Exudyn has no joint that keeps two shafts turning alike about their bisector",
    "KnifeEdge": "Exudyn has no condition on the velocity of a body's point along a direction fixed in the body",
}
"""Joint class -> why not."""


def add_joint(model: Assembly, joint: Any) -> None:
    """Add a joint, or NotExpressible with its name."""
    kind = type(joint)
    what = f"joint '{model.system.name(joint)}' ({kind.__name__})"
    if kind not in JOINTS:
        raise NotExpressible(f"{what}: {REFUSED.get(kind.__name__, 'Exudyn has no element for it')}")
    JOINTS[kind].add(model, joint, what)
