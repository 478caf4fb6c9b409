"""Where a run ends, and how far that is from where it should."""

from typing import Any, NamedTuple

import numpy as np

from mbsd3d import System, simulate


class Poses(NamedTuple):
    """All bodies at the end of a run: reference points (bodies, 3) [m], rotations (bodies, 3, 3)."""

    position: np.ndarray
    rotation: np.ndarray

    def distance(self, other: "Poses", length: float) -> float:
        """Greatest distance of a reference point over ``length``, or angle between rotations [rad]."""
        shift = np.linalg.norm(self.position - other.position, axis=1) / length
        # |R - R'| = 2 sqrt(2) sin(angle / 2), which is exact where arccos of the trace is not
        chord = np.linalg.norm(self.rotation - other.rotation, axis=(1, 2)) / np.sqrt(8.0)
        return float(max(shift.max(), (2.0 * np.arcsin(np.minimum(chord, 1.0))).max()))


def whole(system: System, t_end: float, output: int = 2, **options: Any) -> Any:
    """A run to its end: `simulate` keeps what there is after Ctrl-C, which here is of no use."""
    solution = simulate(system, t_end, output=output, progress=False, **options)
    if solution.record.stopped_by:
        raise KeyboardInterrupt(solution.record.stopped_by)
    return solution


def poses(solution: Any) -> Poses:
    """End of a solution."""
    bodies = solution.system.bodies
    return Poses(
        np.array([solution.position(body)[-1] for body in bodies]),
        np.array([solution.rotation(body)[-1] for body in bodies]),
    )
