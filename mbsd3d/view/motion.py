"""How a mechanism moves: frames in equal steps of time, arrows, traces and curves; no plotting library."""

from typing import Any, NamedTuple

import numpy as np


class Frames(NamedTuple):
    """Poses of all bodies and the ground (last)."""

    t: np.ndarray  # (frames,) [s]
    r: np.ndarray  # (frames, n + 1, 3) [m]
    e: np.ndarray  # (frames, n + 1, 4) unit quaternions of one sheet: neighbours have a positive product


class Arrows(NamedTuple):
    """Vectors of one kind over the frames."""

    kind: str  # "angular velocity", "angular momentum", "reaction force", "reaction moment"
    unit: str  # "rad/s", "kg m^2/s", "N", "N m"
    names: list[str]  # of the bodies or joints
    colour: str
    points: np.ndarray  # (frames, k, 3) world [m]
    vectors: np.ndarray  # (frames, k, 3) world [unit]
    uncertain: tuple[bool, ...]  # True where a reaction is not determined by the constraints


class Trace(NamedTuple):
    """The path of a point."""

    name: str
    colour: str
    points: np.ndarray  # (frames, 3) world [m]


class Curve(NamedTuple):
    """One pair of axes: lines (frames,) over time."""

    label: str  # "angle of hinge"
    unit: str  # "rad"
    lines: list[tuple[str, np.ndarray]]


def frames_of(solution: Any, count: int | None = None) -> Frames:
    """Frames in equal steps of time from the first to the last sample."""
    raise NotImplementedError


def arrows_of(solution: Any, frames: Frames) -> list[Arrows]:
    """The four kinds, those that are zero throughout or cannot be had (a mode has no forces) left out."""
    raise NotImplementedError


def traces_of(solution: Any, frames: Frames, points: Any = None) -> list[Trace]:
    """Paths of the centres of mass, or of the given [(body, world point at the reference pose), ...]."""
    raise NotImplementedError


def curves_of(solution: Any, frames: Frames, wanted: Any = None) -> list[Curve]:
    """Curves [quantity or (quantity, part, ...), ...] as `Solution.plot` takes them; None = a few that tell most."""
    raise NotImplementedError
