"""What is drawn of a system: triangles, lines and names, each fixed in a body; no plotting library.

Bodies are given by their places in ``system.bodies``; the ground comes last (place ``len(system.bodies)``).
"""

from typing import Any, NamedTuple

import numpy as np

from ..shapes import Mesh


class Piece(NamedTuple):
    """Triangles that move with a body."""

    name: str  # of the body or joint they show
    layer: str  # "body", "joint", "centre of mass" or "reference point": what a switch shows and hides together
    body: int
    mesh: Mesh  # body axes from O
    colour: str  # "#rrggbb"


class Wire(NamedTuple):
    """A polyline that moves with a body; rows of NaN separate its strokes."""

    name: str
    layer: str  # "body" (arms to the joints, shapes given as polylines) or "joint" (axes)
    body: int
    points: np.ndarray  # (k, 3) body axes from O [m]
    colour: str


class Link(NamedTuple):
    """A straight connection of two body points: spring, distance."""

    name: str
    ends: tuple[tuple[int, np.ndarray], tuple[int, np.ndarray]]  # (body, point in body axes from O)


class Tag(NamedTuple):
    """A name at a point of a body."""

    text: str
    layer: str  # "body" or "joint"
    body: int
    point: np.ndarray  # (3,) body axes from O [m]
    colour: str


class Camera(NamedTuple):
    """Where one looks from, world [m]; z is up."""

    position: np.ndarray
    look_at: np.ndarray
    distance: float


class Drawing(NamedTuple):
    """All that is drawn of a system; ``size`` is its largest extent at the reference pose [m]."""

    pieces: list[Piece]
    wires: list[Wire]
    links: list[Link]
    tags: list[Tag]
    size: float
    floor: float  # height of the ground grid, world [m]


def draw_system(system: Any) -> Drawing:
    """What is drawn of a system; raises ValueError naming body and remedy for a shape that cannot be drawn."""
    raise NotImplementedError


def poses_of(system: Any, state: Any = None) -> tuple[np.ndarray, np.ndarray]:
    """(n + 1, 3) positions and (n + 1, 4) quaternions with the ground last, at a state or the reference pose."""
    raise NotImplementedError


def bounds(drawing: Drawing, r: np.ndarray, e: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner over poses (frames, n + 1, 3), (frames, n + 1, 4), world [m]."""
    raise NotImplementedError


def frame_camera(low: np.ndarray, high: np.ndarray, fov: float = 0.7) -> Camera:
    """A camera that sees the box at an oblique angle, with a little air; ``fov`` vertical [rad]."""
    raise NotImplementedError
