"""Protocols of the motions that joints evaluate: runs and modes."""

from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from .bodies import Body, Ground


class Motion(Protocol):
    """Positions of points and directions of axes of bodies over time, world axes."""

    def body_point(self, body: Body | Ground, point: ArrayLike) -> np.ndarray:
        """Return (samples, 3) position of a point fixed in a body, given at the reference pose [m]."""

    def body_axis(self, body: Body | Ground, axis: np.ndarray) -> np.ndarray:
        """Return (samples, 3) direction of an axis fixed in a body, given at the reference pose."""


class LoadedMotion(Motion, Protocol):
    """A motion whose reactions are known."""

    @property
    def t(self) -> np.ndarray:
        """Return (samples,) times [s]."""

    @property
    def system(self) -> Any:
        """Return the system that moves."""

    def angle(self, joint: Any) -> np.ndarray:
        """(samples,) angle of a hinge [rad], unwrapped, zero at the reference pose."""

    def slide(self, joint: Any) -> np.ndarray:
        """Return (samples,) displacement of b along the axis or the curve of a joint [m]."""

    def reaction(self, *joints: Any) -> Any:
        """Force and moment of joints; see `Solution.reaction`."""
