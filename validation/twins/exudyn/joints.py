"""Joints and force elements that Exudyn has: their items and frames, and why not the others.

A frame is three columns, world at the reference pose. Exudyn locks directions of the frame on body a (0..2 shifts,
3..5 turns); with two turns locked the third axis of frame a stays across the other two of frame b, with one locked the
first axis of a stays across the second of b.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

import mbsd3d
from mbsd3d.extend import (
    Coordinate,
    angle_of,
    cross,
    exponential,
    matched_perpendiculars,
    matrix,
    multiply,
    perpendiculars,
    slide_of,
)
from mbsd3d.extend import hinge_coordinate as coordinate_of
from validation.twins.base import Array, label, refuse_reflected, refused
from validation.twins.exudyn.assembly import Assembly, ForceModel
from validation.twins.exudyn.couplings import (
    COUPLINGS,
    Add,
    add_knife_edge,
    add_mesh,
    add_rolling,
    add_rolling_surface,
    couple,
    follow,
    hinge_coordinate,
)
from validation.twins.exudyn.laws import add_law


def add_load(model: ForceModel, load: Any, point: Any, components: tuple, element: str) -> None:
    """Add a force or torque; a Python function of time only where a component changes."""
    axes = load.body.axes if load.frame == "body" else np.eye(3)  # in Exudyn they are along the world at first
    functions = [follow(signal) for signal in components]

    def now(mbs: Any, t: float, vector: Any = None) -> Array:
        return axes @ [f(t) for f in functions]

    steady = all(isinstance(signal, mbsd3d.Constant) for signal in components)
    item = getattr(model.items, element)(
        markerNumber=model.marker(load.body, point), bodyFixed=load.frame == "body",
        loadVector=now(None, model.state.t), **{} if steady else {"loadVectorUserFunction": now},
    )  # fmt: skip
    model.mbs.AddLoad(item)


def add_spring(model: ForceModel, spring: Any, what: str) -> None:
    """Add a spring along the line between two points; without length and damper by components, as Exudyn's line needs a
    length.
    """
    markers = [model.marker(spring.a, spring.at_a), model.marker(spring.b, spring.at_b)]
    if spring.length == 0.0 and spring.damping == 0.0:
        item = model.items.ObjectConnectorCartesianSpringDamper(markerNumbers=markers, stiffness=[spring.stiffness] * 3)
        model.connect(spring, item)
        return
    item = model.items.ObjectConnectorSpringDamper(
        markerNumbers=markers, referenceLength=spring.length, stiffness=spring.stiffness, damping=spring.damping
    )
    model.connect(spring, item)


def add_torsion(model: ForceModel, spring: Any, what: str) -> None:
    """Add a spring along a hinge coordinate."""
    markers = [model.zero, hinge_coordinate(model, coordinate_of(spring.hinge, what), what)]
    item = model.items.ObjectConnectorCoordinateSpringDamper(
        markerNumbers=markers, stiffness=spring.stiffness, damping=spring.damping, offset=spring.angle
    )
    model.connect(spring, item)


def add_friction(model: ForceModel, friction: Any, what: str) -> None:
    """Add the friction T tanh(x_dot / v0) + c x_dot against the motion."""
    dry, viscous, scale = friction.coulomb, friction.viscous, friction.transition
    markers = [model.zero, hinge_coordinate(model, coordinate_of(friction.hinge, what), what)]
    smooth = {}
    if dry:
        smooth = {"springForceUserFunction": lambda mbs, t, item, x, v, k, c, x0: dry * np.tanh(v / scale) + c * v}
    item = model.items.ObjectConnectorCoordinateSpringDamper(markerNumbers=markers, damping=viscous, **smooth)
    model.connect(friction, item)


def add_drag(model: ForceModel, drag: Any, what: str) -> None:
    """Add the drag -k |u| u at a point, u its velocity relative to the wind, from Exudyn's own sensor."""
    factor, wind = 0.5 * drag.density * drag.drag_area, [follow(signal) for signal in drag.wind]
    sensor = model.velocity_sensor(drag.body, drag.at)

    def pull(mbs: Any, t: float, vector: Any) -> list[float]:
        u = np.array(mbs.GetSensorValues(sensor)) - [f(t) for f in wind]
        return list(-factor * np.linalg.norm(u) * u)

    marker = model.marker(drag.body, drag.at)
    model.mbs.AddLoad(model.items.LoadForceVector(markerNumber=marker, loadVectorUserFunction=pull))


def add_bushing(model: ForceModel, bushing: Any, what: str) -> None:
    """Add six components in axes of the ground; the elastic moment of large rotations by a function.

    Between two bodies that of Exudyn pulls each side at its own point: all of it by a function.
    """
    if bushing.a is not mbsd3d.GROUND:
        add_law(model, bushing, what)
        return
    axes = matrix(bushing.axes)
    markers = [model.marker(body, bushing.at, axes) for body in (bushing.a, bushing.b)]
    stiffness = np.concatenate([bushing.stiffness, bushing.turning_stiffness])
    damping = np.concatenate([bushing.damping, bushing.turning_damping])

    def load(mbs: Any, t: float, item: int, d: Any, angles: Any, d_dot: Any, w: Any, *rest: Any) -> Array:
        x, y, z = (exponential(angle * axis) for angle, axis in zip(angles, np.eye(3), strict=True))
        p0, *p = multiply(multiply(x, y), z)  # of the Tait-Bryan angles that Exudyn hands over
        twist = stiffness[3:] * p
        moment = 2.0 * (p0 * twist + np.cross(p, twist))
        return np.concatenate([stiffness[:3] * d, moment]) + damping * np.concatenate([d_dot, w])

    by_function = {"springForceTorqueUserFunction": load} if bushing.turning_stiffness.any() else {}
    item = model.items.ObjectConnectorRigidBodySpringDamper(
        markerNumbers=markers, stiffness=np.diag(stiffness), damping=np.diag(damping), **by_function
    )
    model.connect(bushing, item)


FORCES: dict[type, Callable[[ForceModel, Any, str], None]] = {
    mbsd3d.Force: lambda model, x, what: add_load(model, x, x.at, x.force, "LoadForceVector"),
    mbsd3d.Torque: lambda model, x, what: add_load(model, x, x.body.position, x.torque, "LoadTorqueVector"),
    mbsd3d.SpringDamper: add_spring,
    mbsd3d.TorsionSpring: add_torsion,
    mbsd3d.JointFriction: add_friction,
    mbsd3d.AeroDrag: add_drag,
    mbsd3d.Bushing: add_bushing,
} | dict.fromkeys((mbsd3d.Brake, mbsd3d.CentralGravity, mbsd3d.Contact, mbsd3d.Tyre, mbsd3d.Weight), add_law)
"""Force class -> what adds its elements; the last ones by functions of Python."""

REFUSED: dict[type, str] = {
    mbsd3d.StateFeedback: "Exudyn has no force element with internal states and measures",
    mbsd3d.CustomForce: "its function is compiled for mbsd3d",
}
"""Force class -> why not."""


def add_force_element(model: ForceModel, force: Any) -> None:
    """Add a force element; raise NotExpressible with its name if Exudyn has none."""
    if type(force) not in FORCES:
        raise refused(model.system, force, REFUSED, "Exudyn has no element for it")
    FORCES[type(force)](model, force, label(model.system, force))


def frames_along(axis: Array, axis_b: Array, place: int) -> tuple[Array, Array]:
    """Return frames on a and b whose axis number ``place`` is the joint's axis."""
    first = np.column_stack([*perpendiculars(axis), axis])
    second = np.column_stack([*matched_perpendiculars(axis, axis_b), axis_b])
    return np.roll(first, place - 2, axis=1), np.roll(second, place - 2, axis=1)


def frames_across(axis_a: Array, axis_b: Array) -> tuple[Array, Array]:
    """Return frames with first axis ``axis_a`` on a, second axis ``axis_b`` on b."""
    z = cross(axis_a, axis_b)
    z /= np.linalg.norm(z)
    return np.column_stack([axis_a, cross(z, axis_a), z]), np.column_stack([cross(axis_b, z), axis_b, z])


def generic(locked: tuple[int, ...], frames: Callable[[Any], tuple[Array, Array]]) -> Callable:
    """Return a function that adds a joint with locked directions of its frames."""

    def add(model: Assembly, joint: mbsd3d.Joint, what: str) -> None:
        axes_a, axes_b = frames(joint)
        at, at_b = getattr(joint, "at", joint.a.position), getattr(joint, "at_b", joint.b.position)
        markers = [model.marker(joint.a, at, axes_a), model.marker(joint.b, at_b, axes_b)]
        model.connect(joint, model.items.ObjectJointGeneric(markerNumbers=markers, constrainedAxes=locked))

    return add


def along(place: int) -> Callable[[Any], tuple[Array, Array]]:
    """Return a function for frames along axis and axis_b."""
    return lambda joint: frames_along(joint.axis, joint.axis_b, place)


def one_sided(joint: mbsd3d.Planar | mbsd3d.PointOnLine | mbsd3d.PointOnPlane) -> tuple[Array, Array]:
    """Return frames along the axis or normal of a; only a's matters."""
    axis = joint.axis if isinstance(joint, mbsd3d.PointOnLine) else joint.normal
    return frames_along(axis, axis, 2)


def crossed(joint: mbsd3d.Universal | mbsd3d.Perpendicular) -> tuple[Array, Array]:
    """Return frames of axis_a and axis_b."""
    return frames_across(joint.axis_a, joint.axis_b)


def add_spherical(model: Assembly, joint: mbsd3d.Spherical | mbsd3d.ConstantVelocity, what: str) -> None:
    """Add the condition that points coincide."""
    markers = [model.marker(joint.a, joint.at), model.marker(joint.b, joint.at_b)]
    model.connect(joint, model.items.ObjectJointSpherical(markerNumbers=markers))


def add_constant_velocity(model: Assembly, joint: mbsd3d.ConstantVelocity, what: str) -> None:
    """Add coincident points and no turn about the bisector: (axis_a + axis_b) . (w_b - w_a) = 0, kept as velocities."""
    add_spherical(model, joint, what)
    turn_a = Coordinate("angle", joint.a, joint.b, joint.axis_a, joint.axis_a)
    turn_b = Coordinate("angle", joint.b, joint.a, joint.axis_b, joint.axis_b)
    markers = [model.coordinate(x, counted=False) for x in (turn_a, turn_b)]
    model.connect(joint, model.items.ObjectConnectorCoordinate(markerNumbers=markers, velocityLevel=True))


def add_distance(model: Assembly, joint: mbsd3d.Distance, what: str) -> None:
    """Add a constant distance."""
    markers = [model.marker(joint.a, joint.at_a), model.marker(joint.b, joint.at_b)]
    model.connect(joint, model.items.ObjectConnectorDistance(markerNumbers=markers, distance=joint.length))


def add_screw(model: Assembly, joint: mbsd3d.Screw, what: str) -> None:
    """Add a cylindrical joint and slide = pitch angle / (2 pi)."""
    generic((1, 1, 0, 1, 1, 0), along(2))(model, joint, what)
    couple(model, joint, slide_of(joint), joint.pitch / (2 * np.pi), angle_of(joint), what)


JOINTS: dict[type, Add] = {  # of a GenericJoint: which of three shifts and three turns are locked
    mbsd3d.Spherical: add_spherical,
    mbsd3d.Revolute: generic((1, 1, 1, 1, 1, 0), along(2)),
    mbsd3d.Universal: generic((1, 1, 1, 0, 0, 1), crossed),  # x of a across y of b
    mbsd3d.Prismatic: generic((0, 1, 1, 1, 1, 1), along(0)),
    mbsd3d.Cylindrical: generic((1, 1, 0, 1, 1, 0), along(2)),
    mbsd3d.Planar: generic((0, 0, 1, 1, 1, 0), one_sided),
    mbsd3d.Fixed: generic((1, 1, 1, 1, 1, 1), lambda joint: (np.eye(3), np.eye(3))),
    mbsd3d.PointOnLine: generic((1, 1, 0, 0, 0, 0), one_sided),
    mbsd3d.PointOnPlane: generic((0, 0, 1, 0, 0, 0), one_sided),
    mbsd3d.Distance: add_distance,
    mbsd3d.Parallel: generic((0, 0, 0, 1, 1, 0), along(2)),
    mbsd3d.Perpendicular: generic((0, 0, 0, 0, 0, 1), crossed),
    mbsd3d.ConstantVelocity: add_constant_velocity,
    mbsd3d.Screw: add_screw,
    **COUPLINGS,
    mbsd3d.RollingDisc: add_rolling,  # a rounded rim with its rows in Python
    mbsd3d.Rolling: add_rolling_surface,
    mbsd3d.GearMesh: add_mesh,
    mbsd3d.KnifeEdge: add_knife_edge,
}
"""Joint class -> what adds its elements."""


def add_joint(model: Assembly, joint: mbsd3d.Joint) -> None:
    """Add a joint; raise NotExpressible with its name if Exudyn has none."""
    refuse_reflected(model.system, joint)
    if type(joint) not in JOINTS:
        raise refused(model.system, joint, {}, "Exudyn has no element for it")
    JOINTS[type(joint)](model, joint, label(model.system, joint))
