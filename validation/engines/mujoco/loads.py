"""Applied forces: spatial and fixed tendons for springs, actuators at sites for forces and torques."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mbsd3d import Constant, Force, JointFriction, SpringDamper, Torque, TorsionSpring
from mbsd3d.extend import hinge_coordinate

from ..base import NotExpressible, label
from .build import Sketch
from .couplings import add_tendon, sum_of


@dataclass(frozen=True)
class Loads:
    """What acts in the model.

    Attributes
    ----------
    springs : list of (SpringDamper, tendon)
    turning : list of (tendon, its joint coordinates, stiffness, damping)
    applied : list of (actuator, part)
    signals : list of (actuator, signal)
        Whose control follows time.
    """

    springs: list = field(default_factory=list)
    turning: list = field(default_factory=list)
    applied: list = field(default_factory=list)
    signals: list = field(default_factory=list)


def load_all(made: Sketch) -> Loads:
    """All forces of the system, or an error that names the one MuJoCo has no element for."""
    loads = Loads()
    for force in made.system.forces:
        name, shown = made.system.name(force), label(made.system, force)
        if type(force) is SpringDamper:
            loads.springs.append((force, spring(made, force, name)))
        elif type(force) is TorsionSpring:
            values = force.stiffness, force.damping, force.angle
            loads.turning.append(turning(made, force, name, shown, *values))
        elif type(force) is JointFriction and force.coulomb == 0.0:
            loads.turning.append(turning(made, force, name, shown, 0.0, force.viscous, 0.0))
        elif type(force) in (Force, Torque):
            apply(made, loads, force, name)
        else:
            raise NotExpressible(f"{shown}: {REFUSED.get(type(force).__name__, 'MuJoCo has no such element')}")
    return loads


REFUSED = {
    "JointFriction": "dry friction follows tanh(v / v0) here, in MuJoCo it is a soft constraint",
    "Bushing": "MuJoCo has no spring of six components between two bodies",
    "AeroDrag": "the drag of MuJoCo is one of boxes and ellipsoids in a medium, not of an area",
    "CustomForce": "it is a function of the user's; MuJoCo has it only if it is written again for it",
    "StateFeedback": "MuJoCo has no feedback through a filter on measures",
}


def spring(made: Sketch, force: SpringDamper, name: str) -> str:
    """A spatial tendon between two sites."""
    tendon = made.spec.add_tendon(name=f"spring {name}", springlength=(force.length,) * 2)
    tendon.stiffness[0], tendon.damping[0] = force.stiffness, force.damping
    for body, at in ((force.a, force.at_a), (force.b, force.at_b)):
        tendon.wrap_site(made.site(body, at))
    return tendon.name


def turning(made: Sketch, force: Any, name: str, shown: str, stiffness: float, damping: float, rest: float) -> tuple:
    """A fixed tendon along a hinge or slide; a rest length below zero would mean "as built", so it is turned round."""
    sense = -1.0 if rest < 0.0 else 1.0
    terms = {key: sense * sign for key, sign in sum_of(made, hinge_coordinate(force.hinge, shown), shown).items()}
    name = add_tendon(made, f"spring {name}", terms)
    tendon = made.spec.tendon(name)
    tendon.springlength[:] = abs(rest)
    tendon.stiffness[0], tendon.damping[0] = stiffness, damping
    return name, terms, stiffness, damping


def apply(made: Sketch, loads: Loads, force: Force | Torque, name: str) -> None:
    """Actuators at a site, measured in the axes of the body or of the world, so that every stage has them right."""
    turns = isinstance(force, Torque)
    components = force.torque if turns else force.force
    at = force.body.position if turns else force.at
    site = made.site(force.body, at)
    constant = [float(s(0.0)) if isinstance(s, Constant) else 0.0 for s in components]
    wanted = [(None, np.array(constant))] if any(constant) else []
    wanted += [(s, axis) for s, axis in zip(components, np.eye(3), strict=True) if not isinstance(s, Constant)]
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
    """The site at the origin of the world."""
    return next((site.name for site in made.spec.sites if site.name == "world"), None) or (
        made.spec.worldbody.add_site(name="world").name
    )
