"""Every force element that Exudyn has: how, and why not the others."""

from typing import Any

import numpy as np

from mbsd3d.elements import hinge_coordinate as coordinate_of
from mbsd3d.forces import Force, JointFriction, SpringDamper, Torque, TorsionSpring
from mbsd3d.signals import Constant

from ..base import NotExpressible
from .assembly import Assembly
from .couplings import Expression, hinge_coordinate


def add_load(model: Assembly, load: Any, point: Any, components: tuple, element: str) -> None:
    """A force or torque; a Python function of time only where a component changes."""
    moving = {}
    if not all(isinstance(signal, Constant) for signal in components):
        moving = {"loadVectorUserFunction": lambda mbs, t, vector: [float(signal(t)) for signal in components]}
    item = getattr(model.items, element)(
        markerNumber=model.marker(load.body, point), bodyFixed=load.frame == "body",
        loadVector=[float(signal(model.state.t)) for signal in components], **moving,
    )  # fmt: skip
    if load.frame == "body":  # given in the body's own axes; those of the marker stand along the world at the reference
        R = load.body.axes
        item.loadVector = R @ item.loadVector
        if moving:
            item.loadVectorUserFunction = lambda mbs, t, vector: list(R @ [float(s(t)) for s in components])
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


FORCES: dict[type, Expression] = {
    Force: Expression("LoadForceVector", add_force),
    Torque: Expression("LoadTorqueVector", add_torque),
    SpringDamper: Expression("SpringDamper", add_spring),
    TorsionSpring: Expression("CoordinateSpringDamper on the angle or slide", add_torsion),
    JointFriction: Expression("CoordinateSpringDamper with a force function", add_friction),
}
"""Force class -> how it is expressed."""

REFUSED: dict[str, str] = {
    "Bushing": "Exudyn measures large relative rotations of a bushing by Tait-Bryan angles, another law of force",
    "AeroDrag": "Exudyn has no force of a wind on a body",
    "StateFeedback": "Exudyn has no force with states and measures of its own",
    "CustomForce": "its function is compiled for mbsd3d",
}
"""Force class -> why not."""


def add_force_element(model: Assembly, force: Any) -> None:
    """Add a force element, or NotExpressible with its name."""
    kind = type(force)
    what = f"force '{model.system.name(force)}' ({kind.__name__})"
    if kind not in FORCES:
        raise NotExpressible(f"{what}: {REFUSED.get(kind.__name__, 'Exudyn has no element for it')}")
    FORCES[kind].add(model, force, what)
