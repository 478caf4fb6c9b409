"""Poses over time, read by part: of runs, modes and single states."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import vector
from ..base.rotations import by_letter, matrix
from ..base.wording import counted
from ..equations.compiled import Compiled
from ..mechanism.bodies import Body, Ground
from ..mechanism.mechanism import Mechanism


@dataclass(frozen=True, eq=False, repr=False)
class Motion:
    """Poses of a mechanism over time (no forces, no energy): read like a `Solution`.

    ``arrays["q"]`` (samples, n, 7) holds reference points [m] and unit quaternions at the times ``arrays["t"]`` [s].
    Parts are given as objects or by name.
    """

    compiled: Compiled
    arrays: dict[str, np.ndarray]

    def __repr__(self) -> str:
        return f"<motion: {counted(self.t.size, 'sample')}, {self.t[0]:g} ... {self.t[-1]:g} s>"

    @property
    def t(self) -> np.ndarray:
        """Return the times [s] (samples,)."""
        return self.arrays["t"]

    @property
    def system(self) -> Mechanism:
        """Return the system that moves."""
        return self.compiled.system

    def _body(self, body: Body | str) -> int:
        index = self.compiled.body_index.get(id(body), self.compiled.model.body.size)
        return index if index < self.compiled.model.body.size else self.compiled.body_index[id(self.system.part(body))]

    def position(self, body: Body | str) -> np.ndarray:
        """Return the reference point of a body [m]."""
        return self.arrays["q"][:, self._body(body), :3]

    def orientation(self, body: Body | str) -> np.ndarray:
        """Return the unit quaternion of a body (samples, 4), scalar first, body -> world."""
        return self.arrays["q"][:, self._body(body), 3:]

    def rotation(self, body: Body | str) -> np.ndarray:
        """Return the rotation matrix of a body (samples, 3, 3), body -> world."""
        return matrix(self.orientation(body))

    def com(self, body: Body | str) -> np.ndarray:
        """Return the centre of mass [m]."""
        return self.point(body, self.system.part(body).com)

    def point(self, body: Body | str, local: ArrayLike) -> np.ndarray:
        """Return the world position of a point given in body axes from the reference point [m]."""
        return self.position(body) + self.rotation(body) @ vector(local, "point: local")

    def body_axis(self, body: Body | Ground | str, axis: str | ArrayLike) -> np.ndarray:
        """Return the world direction (samples, 3) of an axis fixed in a body or GROUND, given at the reference pose."""
        axis = by_letter(axis, "body_axis: axis")
        if isinstance(body, Ground):
            return np.broadcast_to(vector(axis, "body_axis: axis"), (self.t.size, 3))
        return self.rotation(body) @ self.system.part(body).local_axis(axis)

    def body_point(self, body: Body | Ground | str, point: ArrayLike) -> np.ndarray:
        """Return the world position (samples, 3) [m] of a point of a body or GROUND, given at the reference pose."""
        if isinstance(body, Ground):
            return np.broadcast_to(vector(point, "body_point: point"), (self.t.size, 3))
        return self.point(body, self.system.part(body).local_point(point))
