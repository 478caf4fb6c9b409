"""A `System` as Exudyn has it: rigid bodies with constraints, or a kinematic tree in minimal coordinates."""

from typing import Any

from ..base import Twin
from .bodies import BodyTwin
from .minimal import TreeTwin
from .assembly import ROTATIONS
from .forces import FORCES
from .joints import JOINTS
from .library import exudyn
from .solvers import Scheme

EXPRESSES = {kind: expression.how for kind, expression in JOINTS.items()}
"""Joint class -> one line how."""

EXPRESSES_FORCES = {kind: expression.how for kind, expression in FORCES.items()}
"""Force class -> one line how."""

FORMULATIONS = ("rigid bodies", "kinematic tree")


def twin(
    system: Any,
    *,
    state: Any = None,
    formulation: str = "rigid bodies",
    rotation: str = "rotation vector",
    **scheme: Any,
) -> Twin:
    """A twin in Exudyn."""
    module = exudyn()
    start = system.state() if state is None else state
    if formulation == "kinematic tree":
        return TreeTwin(module, system, start, Scheme(**scheme))
    return BodyTwin(module, system, start, Scheme(**scheme), rotation)
