"""Forces by functions of the user's, of which nobody knows what they do between the stages of steps."""

import numpy as np

from ...mechanism.forces.custom import FunctionForce
from ..run_samples import RunSamples


def unwatched(solution: RunSamples) -> list[FunctionForce]:
    """Return the forces by functions for which nobody has bounded the length of steps."""
    if solution.record.kinematic or solution.record.method.max_step < np.inf:
        return []  # poses follow from drivers
    forces = [force for force in solution.system.forces if isinstance(force, FunctionForce)]
    return [force for force in forces if force.max_step == np.inf]


def stage_notes(solution: RunSamples) -> list[str]:
    """Which forces were not looked for between stages, and what to do about it."""
    return [
        f"force '{solution.system.name(force)}' was not looked for between the stages of steps"
        f"{', but at its times' if force.times else ''}: what it does for a shorter time is stepped over; give it "
        "max_step=, the shortest time it acts, or times= at which it jumps"
        for force in unwatched(solution)
    ]
