"""Tyres that start deep in the ground, by a radius in millimetres or a height forgotten, are found before they fly out.

A `Contact` may be as soft as one likes, and start from a state of a run in which it sank.
"""

import numpy as np

from ..base.errors import InputError
from ..equations.compiled import Compiled
from ..mechanism.forces.tyre import Tyre
from ..results.body_motion import Poses

SUNK = 0.9
"""Share of the way from the hub down to the lowest point that may be below the plane at the start."""


class Start(Poses):
    """The poses of y, as a motion with one sample."""

    def __init__(self, compiled: Compiled, y: np.ndarray) -> None:
        n = compiled.model.body.size
        self.compiled, self.arrays, self.t = compiled, {"q": y[: 7 * n].reshape(1, n, 7)}, np.zeros(1)


def check_sunk(compiled: Compiled, y: np.ndarray) -> None:
    """ValueError for a `Tyre` whose wheel starts in the plane up to its hub, or deeper."""
    start = Start(compiled, y)
    for force in compiled.system.forces:
        if not isinstance(force, Tyre):
            continue
        at, normal = force.plane
        n, centre = start.body_axis(force.a, normal)[0], start.body_point(force.b, force.outline.centre)[0]
        height = float(n @ (centre - start.body_point(force.a, at)[0]))
        below = float(n @ (centre - force.outline.moving(start, force.a, force.b, normal)[0]))
        if height < (1.0 - SUNK) * below:
            raise InputError(
                f"force '{compiled.system.name(force)}' (Tyre): '{force.b.name}' starts {below - height:.4g} m deep in "
                f"the plane, its hub at {height:.4g} m and {below:.4g} m above its lowest point; check its radius (in "
                "m), its position and the plane"
            )
