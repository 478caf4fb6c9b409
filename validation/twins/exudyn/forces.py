"""Every force element that Exudyn has: how, and why not the others."""

from typing import Any

import numpy as np

from mbsd3d import (
    GROUND,
    AeroDrag,
    Bushing,
    Constant,
    CustomForce,
    Force,
    JointFriction,
    SpringDamper,
    StateFeedback,
    Torque,
    TorsionSpring,
)
from mbsd3d.extend import exponential, matrix, multiply
from mbsd3d.extend import hinge_coordinate as coordinate_of
from validation.twins.base import Array, NotExpressible, label, refused
from validation.twins.exudyn.assembly import Assembly
from validation.twins.exudyn.couplings import Expression, follow, hinge_coordinate


def add_load(model: Assembly, load: Any, point: Any, components: tuple, element: str) -> None:
    """A force or torque; a Python function of time only where a component changes."""
    axes = load.body.axes if load.frame == "body" else np.eye(3)  # in Exudyn they are along the world at first
    functions = [follow(signal) for signal in components]

    def now(mbs: Any, t: float, vector: Any = None) -> Array:
        return axes @ [f(t) for f in functions]

    steady = all(isinstance(signal, Constant) for signal in components)
    item = getattr(model.items, element)(
        markerNumber=model.marker(load.body, point), bodyFixed=load.frame == "body",
        loadVector=now(None, model.state.t), **{} if steady else {"loadVectorUserFunction": now},
    )  # fmt: skip
    model.mbs.AddLoad(item)


def add_force(model: Assembly, force: Any, what: str) -> None:
    """A force at a point."""
    add_load(model, force, force.at, force.force, "LoadForceVector")


def add_torque(model: Assembly, torque: Any, what: str) -> None:
    """A torque."""
    add_load(model, torque, torque.body.position, torque.torque, "LoadTorqueVector")


def add_spring(model: Assembly, spring: Any, what: str) -> None:
    """Along the line between two points."""
    markers = [model.marker(spring.a, spring.at_a), model.marker(spring.b, spring.at_b)]
    item = model.items.ObjectConnectorSpringDamper(
        markerNumbers=markers, referenceLength=spring.length, stiffness=spring.stiffness, damping=spring.damping
    )
    model.connect(spring, item)


def add_torsion(model: Assembly, spring: Any, what: str) -> None:
    """Along a hinge coordinate."""
    markers = [model.zero, hinge_coordinate(model, coordinate_of(spring.hinge, what), what)]
    item = model.items.ObjectConnectorCoordinateSpringDamper(
        markerNumbers=markers, stiffness=spring.stiffness, damping=spring.damping, offset=spring.angle
    )
    model.connect(spring, item)


def add_friction(model: Assembly, friction: Any, what: str) -> None:
    """T tanh(x_dot / v0) + c x_dot against the motion."""
    dry, viscous, scale = friction.coulomb, friction.viscous, friction.transition
    markers = [model.zero, hinge_coordinate(model, coordinate_of(friction.hinge, what), what)]
    smooth = {}
    if dry:
        smooth = {"springForceUserFunction": lambda mbs, t, item, x, v, k, c, x0: dry * np.tanh(v / scale) + c * v}
    item = model.items.ObjectConnectorCoordinateSpringDamper(markerNumbers=markers, damping=viscous, **smooth)
    model.connect(friction, item)


def add_drag(model: Assembly, drag: Any, what: str) -> None:
    """-k |u| u at a point, u its velocity relative to the wind, asked of Exudyn's own sensor."""
    factor, wind = 0.5 * drag.density * drag.drag_area, [follow(signal) for signal in drag.wind]
    sensor = model.velocity_sensor(drag.body, drag.at)

    def pull(mbs: Any, t: float, vector: Any) -> list[float]:
        u = np.array(mbs.GetSensorValues(sensor)) - [f(t) for f in wind]
        return list(-factor * np.linalg.norm(u) * u)

    marker = model.marker(drag.body, drag.at)
    model.mbs.AddLoad(model.items.LoadForceVector(markerNumber=marker, loadVectorUserFunction=pull))


def add_bushing(model: Assembly, bushing: Any, what: str) -> None:
    """Six components in axes of the ground; the elastic moment of large rotations by a function."""
    if bushing.a is not GROUND:
        raise NotExpressible(f"{what}: hangs on '{bushing.a.name}'; the one of Exudyn pulls each side at its own point")
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


FORCES: dict[type, Expression] = {
    Force: Expression("LoadForceVector", add_force),
    Torque: Expression("LoadTorqueVector", add_torque),
    SpringDamper: Expression("SpringDamper", add_spring),
    TorsionSpring: Expression("CoordinateSpringDamper on the angle or slide", add_torsion),
    JointFriction: Expression("CoordinateSpringDamper with a force function", add_friction),
    AeroDrag: Expression("LoadForceVector by a function of the velocity", add_drag),
    Bushing: Expression("RigidBodySpringDamper with a force function, from the ground only", add_bushing),
}
"""Force class -> how it is expressed."""

REFUSED: dict[type, str] = {
    StateFeedback: "Exudyn has no force element with internal states and measures",
    CustomForce: "its function is compiled for mbsd3d",
}
"""Force class -> why not."""


def add_force_element(model: Assembly, force: Any) -> None:
    """Add a force element, or NotExpressible with its name."""
    if type(force) not in FORCES:
        raise refused(model.system, force, REFUSED, "Exudyn has no element for it")
    FORCES[type(force)].add(model, force, label(model.system, force))
