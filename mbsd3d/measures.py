"""What can be measured of a mechanism: scalar functions of its state, named by part.

One vocabulary: `solution.measure`, curves of plots, reports and pages, ``stop_when``, `StateFeedback`, targets of
`System.assemble` and outputs of `linearize` all take them.
"""

from .mechanism.measures import (
    Condition,
    Measure,
    angle,
    clearance,
    distance,
    lean,
    lean_rate,
    leaves,
    normal_force,
    omega,
    position,
    rate,
    slide,
    slide_rate,
    state,
    touches,
    velocity,
)
from .mechanism.relative_measures import (
    angle_between,
    between,
    camber,
    heading,
    heading_rate,
    length,
    offset,
    offset_rate,
    turn,
    turn_rate,
)

__all__ = [
    "Condition", "Measure", "angle", "angle_between", "between", "camber", "clearance", "distance", "heading",
    "heading_rate", "lean", "lean_rate", "leaves", "length", "normal_force", "offset", "offset_rate", "omega",
    "position", "rate", "slide", "slide_rate", "state", "touches", "turn", "turn_rate", "velocity",
]  # fmt: skip
