"""Drawing of a system: triangles, lines and names, each fixed in a body, and the layers that show and hide them.

Bodies are given by their places in ``system.bodies``; the ground comes last (place ``len(system.bodies)``).
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...base.checks import as_tuple, short_repr
from ...base.errors import InputError
from ...base.rotations import matrix
from ...base.wording import counted
from ...mechanism.bodies import GROUND
from ...mechanism.mechanism import Mechanism
from ...mechanism.shapes import Mesh
from ...mechanism.state import State
from ...run.simulation import check_state

ARROWS = ("angular velocity", "angular momentum", "reaction force", "reaction moment", "engaged")
NAMES = ("body names", "joint names")
MARKS = ("inertia ellipsoids", "centre of mass", "reference point")
DEFAULT_LAYERS = ("bodies", "joints", "springs and rods", "traces", "ground grid")
LAYERS = ("bodies", "body names", "joints", "joint names", "springs and rods", "traces", "ground grid", *ARROWS, *MARKS)
WORLD_AXES = np.eye(3)
BOUND_POINTS_MAX = 20_000_000  # [points times poses] from which the bounds are found


class Piece(NamedTuple):
    """Triangles that move with a body."""

    name: str  # of the body or joint they show
    layer: str  # "bodies", "joints" or one of MARKS
    body: int
    mesh: Mesh  # body axes from O
    colour: str  # "#rrggbb"


class Wire(NamedTuple):
    """A polyline that moves with a body; rows of NaN separate its strokes."""

    name: str
    layer: str  # "bodies" (arms to the joints, shapes given as polylines) or "joints" (axes)
    body: int
    points: np.ndarray  # (k, 3) body axes from O [m]
    colour: str


class Rounds(NamedTuple):
    """Circles that a link is a tangent of, in place of its ends."""

    body: int  # whose
    axis: np.ndarray  # they have, in body axes
    arms: tuple[float, float]  # radii [m], below 0 for a link that leads clockwise about the axis; 0 of a point


class Link(NamedTuple):
    """A straight connection of two body points, or of two circles: spring, distance, span of a rope."""

    name: str
    ends: tuple[tuple[int, np.ndarray], tuple[int, np.ndarray]]  # (body, point in body axes from O)
    spring: bool = False  # a force, drawn as a coil; else a joint or rope, drawn as a rod
    rounds: Rounds | None = None

    def placed(self, place: Callable[[int, np.ndarray], np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Return both ends (..., 3), where ``place(body, point)`` gives the points (..., 3) of a body."""
        start, end = (place(*x) for x in self.ends)
        if self.rounds is None:
            return start, end
        body, axis, (first, second) = self.rounds
        n, gap = place(body, axis) - place(body, np.zeros(3)), end - start
        flat = gap - np.sum(gap * n, axis=-1, keepdims=True) * n
        d = np.linalg.norm(flat, axis=-1, keepdims=True)
        sine = np.clip((first - second) / d, -1.0, 1.0)
        side = sine * flat / d - np.sqrt(1.0 - sine * sine) * np.cross(n, flat) / d
        return start + first * side, end + second * side


class Tag(NamedTuple):
    """A name at a point of a body."""

    text: str
    layer: str  # "body names" or "joint names"
    body: int
    point: np.ndarray  # (3,) body axes from O [m]
    colour: str


class Drawing(NamedTuple):
    """Drawing of a system; ``size`` is its largest extent at the reference pose [m]."""

    pieces: list[Piece]
    wires: list[Wire]
    links: list[Link]
    tags: list[Tag]
    size: float
    floor: float  # height of the ground grid, world [m]
    origin: np.ndarray = np.zeros(3)  # a round point about which viewers show it, which count in single precision [m]


def title_of(system: Mechanism) -> str:
    """Return the name of the system, else those of its bodies, the first ones of many."""
    if system.title:
        return system.title
    names = [body.name for body in system.bodies]
    if len(names) == 1:
        return names[0]
    if len(names) <= 4:
        return f"{', '.join(names[:-1])} and {names[-1]}"
    return f"{', '.join(names[:3])} and {len(names) - 3} more bodies"


@dataclass(frozen=True)
class Layers:
    """Return the visible layers, in their order: the default ones and ``shown``, without ``hidden``."""

    shown: Collection[str] = ()
    hidden: Collection[str] = ()

    def __post_init__(self) -> None:
        for option in ("shown", "hidden"):
            object.__setattr__(self, option, known_layers(getattr(self, option), option))
        for layer in self.shown:
            if layer in self.hidden:
                raise InputError(f"shown, hidden: layer {layer!r} is in both; take it out of one")

    def visible(self, usual: Collection[str]) -> tuple[str, ...]:
        """Return the visible layers in the order in which they are drawn."""
        wanted = {*usual, *self.shown}.difference(self.hidden)
        return tuple(layer for layer in LAYERS if layer in wanted)


def known_layers(wanted: Collection[str], option: str) -> tuple[str, ...]:
    """Return names of layers as a tuple; ValueError for an unknown one."""
    wanted = (wanted,) if isinstance(wanted, str) else as_tuple(wanted, option, "a list, e.g. ['angular velocity']")
    for layer in wanted:
        if not isinstance(layer, str) or layer not in LAYERS:
            raise InputError(f"{option}: layer {short_repr(layer)} is unknown; give some of {', '.join(LAYERS)}")
    return wanted


USUAL_LAYERS = Layers()


def poses_of(system: Mechanism, state: State | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (n + 1, 3) and unit quaternions (n + 1, 4), ground last, at a state or the reference pose."""
    if state is None:
        r = np.array([body.position for body in system.bodies])
        e = np.array([body.orientation for body in system.bodies])
    else:
        check_state(state, "picture")
        q, n = state.q.reshape(-1, 7), len(system.bodies)
        if len(q) != n:
            raise InputError(f"state has {counted(len(q), 'body')}, the system {n}; give a state of this system")
        r, e = q[:, :3], q[:, 3:]
    e = e / np.linalg.norm(e, axis=1, keepdims=True)
    return np.vstack([r, GROUND.position]), np.vstack([e, GROUND.orientation])


def corners(drawing: Drawing, layers: Collection[str] = LAYERS) -> dict[int, np.ndarray]:
    """Return for each body all its points (k, 3) in some layers, body axes from O [m]."""
    found: dict[int, list[np.ndarray]] = {}
    for piece in drawing.pieces:
        if piece.layer in layers:
            found.setdefault(piece.body, []).append(piece.mesh.vertices)
    for wire in drawing.wires:
        if wire.layer in layers:
            found.setdefault(wire.body, []).append(wire.points[np.isfinite(wire.points).all(axis=1)])
    ends = [end for link in drawing.links for end in link.ends] if "springs and rods" in layers else []
    for body, point in (*ends, *(tag[2:4] for tag in drawing.tags if tag.layer in layers)):
        found.setdefault(body, []).append(np.reshape(point, (1, 3)))
    return {body: np.concatenate(points) for body, points in found.items()}


def bounds(
    drawing: Drawing, r: np.ndarray, e: np.ndarray, layers: Collection[str] = LAYERS, axes: np.ndarray = WORLD_AXES
) -> tuple[np.ndarray, np.ndarray]:
    """Return lowest and highest corner along ``axes`` (rows, world) [m], over poses.

    These are r (frames, n + 1, 3) and e (frames, n + 1, 4), the ground last. Of what is in some layers, of all if these
    are empty. In long runs of large systems every k-th pose is looked at.
    """
    points = corners(drawing, layers) or corners(drawing)
    step = 1 + len(r) * sum(map(len, points.values())) // BOUND_POINTS_MAX
    r, e = r[::step], e[::step]
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for body, local in points.items():
        seen = axes @ (matrix(e[:, body]) @ local.T + r[:, body, :, None])  # (frames, 3, k)
        low, high = np.minimum(low, seen.min(axis=(0, 2))), np.maximum(high, seen.max(axis=(0, 2)))
    return low, high
