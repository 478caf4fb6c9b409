"""What is drawn of a system: triangles, lines and names, each fixed in a body; no plotting library.

Bodies are given by their places in ``system.bodies``; the ground comes last (place ``len(system.bodies)``).
"""

from typing import Any, NamedTuple

import numpy as np

from ..contacts import RollingDisc
from ..guesses import shapes_of
from ..joints import perpendiculars
from ..parts import GROUND
from ..rotations import matrix, quaternion_from_matrix
from ..shapes import Ellipsoid, Lines, Mesh
from ..solids import Shape
from ..style import GREY, colour
from ..surfaces import ball, block, joined
from .glyphs import anchor, joints_of, scaled, solids, spokes

DARK, LIGHT = "#4d4d4d", "#e0e0e0"
LIFT = np.full(3, np.nan)  # lifts the pen between two strokes
WORK = 20_000_000  # points times poses that are looked at for the bounds
AIR = 1.12  # of the picture around the box
AZIMUTH, HEIGHT = np.radians((-58.0, 22.0))  # of the camera, seen from the middle
VIEW = np.array([  # towards the camera, right, up
    (np.cos(HEIGHT) * np.cos(AZIMUTH), np.cos(HEIGHT) * np.sin(AZIMUTH), np.sin(HEIGHT)),
    (-np.sin(AZIMUTH), np.cos(AZIMUTH), 0.0),
    (-np.sin(HEIGHT) * np.cos(AZIMUTH), -np.sin(HEIGHT) * np.sin(AZIMUTH), np.cos(HEIGHT)),
])  # fmt: skip


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


class Artist:
    """Makes the drawing of a system, step by step: bodies first, since their size gives that of the marks."""

    def __init__(self, system: Any) -> None:
        self.system = system
        self.place = {id(body): i for i, body in enumerate((*system.bodies, GROUND))}
        self.drawing = Drawing([], [], [], [], 0.0, 0.0)
        self.rolling = {id(joint.b): joint for joint in system.joints if isinstance(joint, RollingDisc)}

    def bodies(self) -> None:
        """Shapes of the bodies; those without one that roll as a disc are a lens of its radius."""
        for i, body in enumerate(self.system.bodies):
            for shape in self.shapes(body):
                tint = shape.colour or colour(i)
                try:
                    if isinstance(shape, Lines):
                        self.drawing.wires.append(Wire(body.name, "body", i, shape.line(body), tint))
                    else:
                        self.drawing.pieces.append(Piece(body.name, "body", i, shape.mesh(body), tint))
                except ValueError as error:
                    raise ValueError(f"body '{body.name}': {error}") from error

    def shapes(self, body: Any) -> tuple[Shape, ...]:
        """Those of a body; a wheel's ellipsoid would reach into the road."""
        disc = self.rolling.get(id(body))
        if body.shape is not None or disc is None or not np.allclose(disc.centre, body.centre, atol=1e-9 * disc.radius):
            return shapes_of(body)
        axis = body.local_axis(disc.axis)
        turn = quaternion_from_matrix(np.column_stack([*perpendiculars(axis), axis]))
        return (Ellipsoid((disc.radius, disc.radius, 0.1 * disc.radius), orientation=turn),)

    def arms(self) -> None:
        """Wires from the centres of mass to joints and springs, and the links."""
        strokes: dict[int, list[np.ndarray]] = {}
        for part in (*self.system.joints, *self.system.forces):
            points = joints_of(part)
            for body, point in points:
                if body is not GROUND:
                    strokes.setdefault(self.place[id(body)], []).extend([body.com, body.local_point(point), LIFT])
            if hasattr(part, "at_a") and len(points) == 2:
                first, second = ((self.place[id(body)], body.local_point(point)) for body, point in points)
                self.drawing.links.append(Link(self.system.name(part), (first, second)))
        for i, points in strokes.items():
            self.drawing.wires.append(Wire(self.system.bodies[i].name, "body", i, np.array(points[:-1]), colour(i)))

    def grain(self, size: float) -> float:
        """Size of joints: a twenty-fifth of the mechanism's, but not more than a part of that of a usual body."""
        extents = [float(np.ptp(points, axis=0).max()) for i, points in corners(self.drawing).items()]
        extents = [extent for extent in extents if extent > 0.0]
        return min(0.04 * size, 0.15 * float(np.median(extents))) if extents else 0.04 * size

    def marks(self, size: float) -> None:
        """Centres of mass, reference points, and the bodies that have no shape."""
        bar = [scaled(block(), *np.where(np.arange(3) == k, 1.5, 0.12) * size) for k in range(3)]
        cross, dot = joined(*bar), scaled(ball(), *3 * (0.4 * size,))
        shown = {piece.body for piece in self.drawing.pieces} | {wire.body for wire in self.drawing.wires}
        add = self.drawing.pieces.append
        for i, body in enumerate(self.system.bodies):
            centre = dot._replace(vertices=dot.vertices + body.com)
            if i not in shown or not (body.inertia.any() or body.shape is not None):
                add(Piece(body.name, "body", i, centre, colour(i)))
            add(Piece(body.name, "centre of mass", i, centre, LIGHT))
            add(Piece(body.name, "reference point", i, cross, GREY))
            self.drawing.tags.append(Tag(body.name, "body", i, body.com, colour(i)))

    def joints(self, size: float) -> None:
        """Solids, axes and names of the joints."""
        for joint in self.system.joints:
            name = self.system.name(joint)
            for body, mesh in solids(joint, size):
                self.drawing.pieces.append(Piece(name, "joint", self.place[id(body)], mesh, DARK))
            for body, ends in spokes(joint, 3.0 * size):
                self.drawing.wires.append(Wire(name, "joint", self.place[id(body)], ends, DARK))
            body, point = anchor(joint)
            self.drawing.tags.append(Tag(name, "joint", self.place[id(body)], body.local_point(point), DARK))


def draw_system(system: Any) -> Drawing:
    """What is drawn of a system.

    Parameters
    ----------
    system : System

    Returns
    -------
    Drawing
        True to scale; only the marks of joints and points have a size of their own.

    Raises
    ------
    ValueError
        Naming body and remedy for a shape that cannot be drawn.
    """
    artist, (r, e) = Artist(system), poses_of(system)
    artist.bodies()
    artist.arms()
    points = [anchor(joint) for joint in system.joints]
    here = [Tag("", "", artist.place[id(body)], body.local_point(point), "") for body, point in points]
    here += [Tag("", "", i, body.com, "") for i, body in enumerate(system.bodies)]
    low, high = bounds(artist.drawing._replace(tags=here), r[None], e[None])
    size = float((high - low).max()) or 1.0
    mark = artist.grain(size)
    artist.marks(mark)
    artist.joints(mark)
    return artist.drawing._replace(size=size, floor=float(low[2]))


def poses_of(system: Any, state: Any = None) -> tuple[np.ndarray, np.ndarray]:
    """(n + 1, 3) positions and (n + 1, 4) unit quaternions with the ground last, at a state or the reference pose.

    Raises
    ------
    ValueError
        If the state is one of another system.
    """
    if state is None:
        r = np.array([body.position for body in system.bodies])
        e = np.array([body.orientation for body in system.bodies])
    else:
        q, n = state.q.reshape(-1, 7), len(system.bodies)
        if len(q) != n:
            raise ValueError(f"state has {len(q)} bodies, the system {n}; give a state of this system")
        r, e = q[:, :3], q[:, 3:]
    e = e / np.linalg.norm(e, axis=1, keepdims=True)
    return np.vstack([r, GROUND.position]), np.vstack([e, GROUND.orientation])


def corners(drawing: Drawing) -> dict[int, np.ndarray]:
    """Body -> (k, 3) all its points, body axes from O [m]."""
    found: dict[int, list[np.ndarray]] = {}
    for piece in drawing.pieces:
        found.setdefault(piece.body, []).append(piece.mesh.vertices)
    for wire in drawing.wires:
        found.setdefault(wire.body, []).append(wire.points[np.isfinite(wire.points).all(axis=1)])
    for body, point in (*(end for link in drawing.links for end in link.ends), *(tag[2:4] for tag in drawing.tags)):
        found.setdefault(body, []).append(np.reshape(point, (1, 3)))
    return {body: np.concatenate(points) for body, points in found.items()}


def bounds(drawing: Drawing, r: np.ndarray, e: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner over poses; of long runs of large systems only every k-th pose is looked at.

    Parameters
    ----------
    drawing : Drawing
    r, e : (frames, n + 1, 3), (frames, n + 1, 4) ndarray
        Positions [m] and unit quaternions, the ground last.

    Returns
    -------
    (3,), (3,) ndarray
        World [m].
    """
    points = corners(drawing)
    step = 1 + len(r) * sum(map(len, points.values())) // WORK
    r, e = r[::step], e[::step]
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for body, local in points.items():
        world = matrix(e[:, body]) @ local.T + r[:, body, :, None]  # (frames, 3, k)
        low, high = np.minimum(low, world.min(axis=(0, 2))), np.maximum(high, world.max(axis=(0, 2)))
    return low, high


def frame_camera(low: np.ndarray, high: np.ndarray, fov: float = 0.7) -> Camera:
    """A camera that sees the whole box at an oblique angle, with a little air, in a picture at least as wide as high.

    A corner at w from the middle is seen if its distances across the view are below (d - w . u) tan(fov / 2), with u
    towards the camera and d the distance.

    Parameters
    ----------
    low, high : (3,) ndarray
        Corners of the box, world [m]; it may be flat, or a point (then it is taken as 1 m wide).
    fov : float
        Vertical angle of view [rad].

    Returns
    -------
    Camera
        Looking at the middle of the box.
    """
    low, high = np.asarray(low, float), np.asarray(high, float)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    half = half if half.any() else np.full(3, 0.5)
    towards, right, up = VIEW
    w = half * np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    across = AIR * np.abs(w @ np.column_stack([right, up])).max(axis=1)
    distance = float((w @ towards + across / np.tan(0.5 * fov)).max())
    return Camera(middle + distance * towards, middle, distance)
