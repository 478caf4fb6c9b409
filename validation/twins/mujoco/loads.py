"""Applied forces: spatial and fixed tendons for springs, actuators at sites for forces and torques."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import mbsd3d
from mbsd3d.extend import hinge_coordinate
from validation.twins.base import NotExpressible, label, refused
from validation.twins.mujoco.build import Sketch
from validation.twins.mujoco.couplings import add_tendon, terms_of


@dataclass(frozen=True)
class Loads:
    """Applied forces of the model.

    ``springs``: (spring, tendon); ``turning``: (tendon, its joint coordinates, stiffness, damping); ``applied``:
    (actuator, force); ``signals``: (actuator, signal) whose control follows time.
    """

    springs: list = field(default_factory=list)
    turning: list = field(default_factory=list)
    applied: list = field(default_factory=list)
    signals: list = field(default_factory=list)


def load_all(made: Sketch) -> Loads:
    """Add all forces of the system; raise an error that names one MuJoCo has no element for."""
    loads = Loads()
    for force in made.system.forces:
        if type(force) not in FORCES:
            raise refused(made.system, force, REFUSED, "MuJoCo has no such element")
        FORCES[type(force)](made, loads, force, made.system.name(force))
    return loads


def spring(made: Sketch, loads: Loads, force: mbsd3d.SpringDamper, name: str) -> None:
    """Add a spatial tendon between two sites."""
    if force.damping and np.array_equal(force.at_a, force.at_b):
        text = "where the ends meet MuJoCo's damper pulls along x, here along the motion"
        raise NotExpressible(f"{label(made.system, force)}: {text}")
    tendon = made.spec.add_tendon(name=f"spring {name}", springlength=(force.length,) * 2)
    tendon.stiffness[0], tendon.damping[0] = force.stiffness, force.damping
    for body, at in ((force.a, force.at_a), (force.b, force.at_b)):
        tendon.wrap_site(made.site(body, at))
    loads.springs.append((force, tendon.name))


def torsion(made: Sketch, loads: Loads, force: mbsd3d.TorsionSpring, name: str) -> None:
    """Add a spring along a hinge or slider."""
    turning(made, loads, force, name, force.stiffness, force.damping, force.angle)


def friction(made: Sketch, loads: Loads, force: mbsd3d.JointFriction, name: str) -> None:
    """Add a damper along a hinge or slider."""
    if force.coulomb != 0.0:
        text = "dry friction follows tanh(v / v0) here, in MuJoCo it is a soft constraint"
        raise NotExpressible(f"{label(made.system, force)}: {text}")
    turning(made, loads, force, name, 0.0, force.viscous, 0.0)


def turning(made: Sketch, loads: Loads, force: Any, name: str, stiffness: float, damping: float, rest: float) -> None:
    """Add a fixed tendon along a hinge or slider; a rest length below zero would mean "as built", so its sign is
    reversed.
    """
    sense, shown = -1.0 if rest < 0.0 else 1.0, label(made.system, force)
    terms = terms_of(made, [(hinge_coordinate(force.hinge, shown), sense)], shown)
    tendon = made.spec.tendon(add_tendon(made, f"spring {name}", terms))
    tendon.springlength[:] = abs(rest)
    tendon.stiffness[0], tendon.damping[0] = stiffness, damping
    loads.turning.append((f"spring {name}", terms, stiffness, damping))


def apply(made: Sketch, loads: Loads, force: mbsd3d.Force | mbsd3d.Torque, name: str) -> None:
    """Add actuators at a site, in the axes of the body or of the world, so that every stage has the right axes."""
    turns = isinstance(force, mbsd3d.Torque)
    components, at = (
        (force.torque, force.body.position) if isinstance(force, mbsd3d.Torque) else (force.force, force.at)
    )
    site = made.site(force.body, at)
    constant = [float(s(0.0)) if isinstance(s, mbsd3d.Constant) else 0.0 for s in components]
    wanted: list[tuple[mbsd3d.Signal | None, np.ndarray]] = [(None, np.array(constant))] if any(constant) else []
    wanted += [(s, axis) for s, axis in zip(components, np.eye(3), strict=True) if not isinstance(s, mbsd3d.Constant)]
    for k, (signal, direction) in enumerate(wanted):
        actuator = made.spec.add_actuator(name=f"load {name} {k}", target=site)
        actuator.trntype = made.mujoco.mjtTrn.mjTRN_SITE
        actuator.gear[:] = [*np.zeros(3), *direction] if turns else [*direction, *np.zeros(3)]
        if force.frame == "world":
            actuator.refsite = world_site(made)
        loads.applied.append((actuator.name, force))
        if signal is not None:
            loads.signals.append((actuator.name, signal))


def world_site(made: Sketch) -> str:
    """Return the site at the origin of the world."""
    return next((site.name for site in made.spec.sites if site.name == "world"), None) or (
        made.spec.worldbody.add_site(name="world").name
    )


FORCES: dict[type, Callable[[Sketch, Loads, Any, str], None]] = {
    mbsd3d.SpringDamper: spring,
    mbsd3d.TorsionSpring: torsion,
    mbsd3d.JointFriction: friction,
    mbsd3d.Force: apply,
    mbsd3d.Torque: apply,
}
"""Force class -> what adds it to the model."""

REFUSED: dict[type, str] = {
    mbsd3d.Bushing: "MuJoCo has no spring of six components between two bodies",
    mbsd3d.AeroDrag: "the drag of MuJoCo is one of boxes and ellipsoids in a medium, not of an area",
    mbsd3d.CustomForce: "it is a function of the user's; MuJoCo has it only if it is written again for it",
    mbsd3d.Brake: "MuJoCo's dry friction is a soft row that creeps; a brake holds by a spring with a state of its own",
    mbsd3d.DryFriction: "the friction loss of MuJoCo does not follow the load of its joint",
    mbsd3d.Contact: "the contacts of MuJoCo are soft rows with a law of their own",
    mbsd3d.Tyre: "MuJoCo has no tyre",
    mbsd3d.StateFeedback: "MuJoCo has no feedback through a filter on measures",
}
"""Force class -> why not."""
