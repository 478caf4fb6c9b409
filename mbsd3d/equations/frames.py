"""Points and directions of the reference pose in body axes, all of a table at a time."""

from collections.abc import Sequence

import numpy as np

from ..base.checks import floats
from ..base.rotations import matrix
from ..mechanism.bodies import GROUND
from ..mechanism.mechanism import Mechanism


class Frames:
    """Poses of the bodies at the reference pose; the ground is the last one."""

    def __init__(self, system: Mechanism) -> None:
        bodies = (*system.bodies, GROUND)
        self.index = {id(body): i for i, body in enumerate(bodies)}
        self.r = np.array([body.position for body in bodies])
        self.R = matrix(np.array([body.orientation for body in bodies]))
        self.centre = self.r + turned(self.R, np.array([body.com for body in bodies]))

    def points(self, on: Sequence[int], points: Sequence) -> np.ndarray:
        """Return (k, 3) R'(p - r) of world points p (k, 3) in the bodies ``on`` (k,)."""
        given, on = floats(points, "points of rows", "finite coordinates"), np.array(on)
        return self._local(on, given, given - self.r[on])

    def axes(self, on: Sequence[int], axes: Sequence) -> np.ndarray:
        """Return (k, 3) R'x of world directions x (k, 3) in the bodies ``on`` (k,)."""
        given, on = floats(axes, "axes of rows", "finite numbers"), np.array(on)
        return self._local(on, given, given)

    def _local(self, on: np.ndarray, given: np.ndarray, arms: np.ndarray) -> np.ndarray:
        """Return R' arms; on the ground what was given, to the sign of a zero."""
        return np.where((on == len(self.R) - 1)[:, None], given, turned(self.R[on].swapaxes(1, 2), arms))


def turned(R: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return R x of stacks (k, 3, 3) and (k, 3)."""
    return (R @ x[:, :, None])[:, :, 0]
