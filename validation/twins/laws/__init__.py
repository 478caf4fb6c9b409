"""Laws of force elements from their definitions, for poses and velocities of two bodies.

Nothing of the compiled ones is used. Exudyn takes those for which it has no element, as functions of Python; the second
formulation takes all of them.
"""

from collections.abc import Callable
from typing import Any

from mbsd3d import (
    AeroDrag,
    Brake,
    Bushing,
    CentralGravity,
    Contact,
    Force,
    JointFriction,
    SpringDamper,
    Torque,
    TorsionSpring,
    Tyre,
    Weight,
)
from validation.twins.laws.hinges import brake_law, friction_law, torsion_law
from validation.twins.laws.loads import (
    attraction_law,
    bushing_law,
    drag_law,
    force_law,
    spring_law,
    torque_law,
    weight_law,
)
from validation.twins.laws.moving import Law
from validation.twins.laws.surfaces import contact_law, tyre_law

LAWS: dict[type, Callable[[Any, str], Law]] = {
    AeroDrag: drag_law,
    Brake: brake_law,
    Bushing: bushing_law,
    CentralGravity: attraction_law,
    Contact: contact_law,
    Force: force_law,
    JointFriction: friction_law,
    SpringDamper: spring_law,
    Torque: torque_law,
    TorsionSpring: torsion_law,
    Tyre: tyre_law,
    Weight: weight_law,
}
"""Force class -> its law; errors start with the text that is given."""
