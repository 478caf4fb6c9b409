"""Degrees of freedom of each joint, the joints of the tree, and the loop closures of the others.

A joint is a frame A on body a, a frame B on body b, and between them slides s along axes of A and turns:
p_b - p_a = A s, B = A R(turns) rest. All coordinates are zero where B = A rest, at the reference pose if a and b are
built to fit.

A tree joint is the joint of a MuJoCo body with its parent. What closes a loop is two points kept together (Spherical),
two such pairs on the axis (Revolute); any other joint carries a *piece* of its body b, an equal share of mass and
inertia, that is welded to the rest: the two together move as the body does.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ...base.errors import InputError
from ...base.rotations import matched_perpendiculars, perpendiculars
from ...mechanism.bodies import GROUND, Body
from ...mechanism.drivers import PositionDriver, SpeedDriver
from ...mechanism.joints import Joint
from ...mechanism.joints.conditions import (
    ConstantVelocity,
    Distance,
    Parallel,
    Perpendicular,
    PointOnLine,
    PointOnPlane,
)
from ...mechanism.joints.pairs import Cylindrical, Fixed, Planar, Prismatic, Revolute, Screw, Spherical, Universal
from ...mechanism.mechanism import Mechanism
from .exported import NotExportable

X, Y, Z = range(3)
BALL_ANGLES = None  # turns of a ball: a quaternion
PARALLEL_TOLERANCE = 1e-9  # [1] difference of axes of hinges that count as one: rounding
BEND_MIN = 0.05  # [rad] below this bend the first and third turn of a constant-velocity joint are one


@dataclass(frozen=True)
class Freedoms:
    """Frames of a joint, world at the reference pose, and the degrees of freedom between them.

    ``A, B`` (3, 3): axes as columns, on a and on b; ``at_a, at_b`` (3,): origins [m]; ``slides``: columns of A;
    ``turns`` (k, 3) array or None: axes of the hinges in B at rest, the first next to a; None is a ball; ``angles``:
    hinge angles from R = A'B; ``rest`` (3, 3): A'B where all angles are zero.
    """

    A: np.ndarray
    B: np.ndarray
    at_a: np.ndarray
    at_b: np.ndarray
    slides: tuple[int, ...]
    turns: np.ndarray | None
    angles: Callable[[np.ndarray], tuple[float, ...]]
    rest: np.ndarray

    def turn_axis(self) -> np.ndarray | None:
        """Return the world axis of the only hinge, fixed in a and in b; None if there are none or several."""
        return None if self.turns is None or len(self.turns) != 1 else self.A @ self.rest @ self.turns[0]


def no_angle(R: np.ndarray) -> tuple[float, ...]:
    """Return no angles, for a joint without hinges."""
    return ()


def about_z(R: np.ndarray) -> tuple[float, ...]:
    """Return the angle of R = Rz(q) [rad]."""
    return (np.arctan2(R[1, 0], R[0, 0]),)


def about_xy(R: np.ndarray) -> tuple[float, ...]:
    """Return the angles of R = Rx(q1) Ry(q2): its second column is (0, cos q1, sin q1), its first row (cos q2, 0, sin
    q2).
    """
    return np.arctan2(R[2, 1], R[1, 1]), np.arctan2(R[0, 2], R[0, 0])


def about_zyz(R: np.ndarray) -> tuple[float, ...]:
    """Return the angles of R = Rz(q1) Ry(q2) Rz(q3), q2 in (0, pi): third column (cos q1 sin q2, sin q1 sin q2, cos
    q2).
    """
    bend = np.arctan2(np.hypot(R[0, 2], R[1, 2]), R[2, 2])
    return np.arctan2(R[1, 2], R[0, 2]), bend, np.arctan2(R[2, 1], -R[2, 0])


TABLE: dict[type, tuple[Any, ...]] = {  # slides, hinges about axes of B, their angles
    Fixed: ((), (), no_angle),
    Revolute: ((), (Z,), about_z),
    Spherical: ((), BALL_ANGLES, no_angle),
    Universal: ((), (X, Y), about_xy),
    Prismatic: ((Z,), (), no_angle),
    Cylindrical: ((Z,), (Z,), about_z),
    Screw: ((Z,), (Z,), about_z),
    Planar: ((X, Y), (Z,), about_z),
    PointOnLine: ((Z,), BALL_ANGLES, no_angle),
    PointOnPlane: ((X, Y), BALL_ANGLES, no_angle),
    PositionDriver: (
        (X, Y, Z),
        BALL_ANGLES,
        no_angle,
    ),  # a point of b and its three places, some of which are driven
    Parallel: ((X, Y, Z), (Z,), about_z),
    Perpendicular: ((X, Y, Z), (X, Y), about_xy),
}


def freedoms_of(joint: Joint, name: str) -> Freedoms:
    """Return frames and degrees of freedom of a joint of `TABLE`, of a ConstantVelocity or Distance; errors name it."""
    if type(joint) is ConstantVelocity:
        return shafts(joint, name)
    if type(joint) is Distance:  # see `rods`
        return Freedoms(np.eye(3), np.eye(3), joint.at_a, joint.at_b, (), BALL_ANGLES, no_angle, np.eye(3))
    slides, hinges, angles = TABLE[type(joint)]
    A, B = frames(joint)
    at_a, at_b = getattr(joint, "at", joint.point()), joint.point()
    turns = None if hinges is BALL_ANGLES else np.eye(3)[list(hinges)]
    return Freedoms(A, B, at_a, at_b, slides, turns, angles, np.eye(3))


def frames(joint: Joint) -> tuple[np.ndarray, np.ndarray]:
    """Return the axes of A and B: z is the axis of the joint, its angle is counted from x and y of A and B."""
    if isinstance(joint, Universal | Perpendicular):  # a cross: x is axis_a, y is axis_b
        x, y = joint.axis_a, joint.axis_b
        y_a, x_b = y - x * (x @ y), x - y * (x @ y)
        return right_handed(x, y_a), right_handed(x_b, y)
    axis = getattr(joint, "axis", getattr(joint, "normal", None))
    if axis is None:
        return np.eye(3), np.eye(3)
    axis_b = getattr(joint, "axis_b", axis)
    (x, y), (x_b, y_b) = perpendiculars(axis), matched_perpendiculars(axis, axis_b)
    return np.column_stack([x, y, axis]), np.column_stack([x_b, y_b, axis_b])


def right_handed(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return axes with x and y along the given vectors, which are perpendicular."""
    x, y = x / np.linalg.norm(x), y / np.linalg.norm(y)
    return np.column_stack([x, y, np.cross(x, y)])


def shafts(joint: ConstantVelocity, name: str) -> Freedoms:
    """Return hinges about shaft a, the common normal n and shaft b; constant velocity is the additional row q3 = -q1.

    B = A Rz(q) Ry(bend) Rz(-q) turns about an axis across z, which is what the row here says: with n of both
    sides, n_a . (z_b x n_b) = (z_a x n_a) . n_b.
    """
    normal = np.cross(joint.axis_a, joint.axis_b)
    bend = np.arctan2(np.linalg.norm(normal), joint.axis_a @ joint.axis_b)
    if bend < BEND_MIN:
        raise NotExportable(
            f"joint '{name}' (ConstantVelocity): its shafts enclose {np.degrees(bend):.3g} degrees; MuJoCo has it as "
            f"three hinges, and above {np.degrees(BEND_MIN):.3g} degrees only"
        )
    A, B = (right_handed(np.cross(normal, z), normal) for z in (joint.axis_a, joint.axis_b))
    rest = A.T @ B
    turns = np.array([rest.T[:, Z], np.eye(3)[Y], np.eye(3)[Z]])

    def angles(R: np.ndarray) -> tuple[float, ...]:
        first, second, third = about_zyz(R)
        return first, second - bend, third

    return Freedoms(A, B, joint.at, joint.at_b, (), turns, angles, rest)


CLOSED_BY_EQUALITY = (Revolute, Spherical)  # close a loop by equalities of their own
CLOSED_LATE = (PointOnLine, PointOnPlane)
"""Where body a is the child, a ball before slides: MuJoCo 4.0.1 has its J_dot wrong."""
CLOSED_LOOSELY = (Parallel, Perpendicular, Distance, PositionDriver)
"""Keep no two points together: last to span the tree."""


@dataclass(eq=False)
class Piece:
    """A body of the tree: a body or a share of it, and the joint with its parent (None: free).

    ``name``: of the body in the tree; ``title``: of its joint.
    """

    number: int
    name: str
    body: Body
    parent: "Piece | None"  # None is the ground
    joint: Joint | None
    title: str = ""
    is_b: bool = True  # whether it is body b of the joint

    def named(self, kind: str, k: int | str = "") -> str:
        """Return the name of a coordinate of the joint: its own name, if it has no other."""
        single = isinstance(self.joint, Revolute | Prismatic | Spherical)
        return self.title if single else f"{self.title} {kind} {k}".rstrip()


@dataclass(frozen=True)
class Layout:
    """Pieces in the order of the tree, parents first; ``main`` is the piece of a body in the tree.

    ``extra`` are the pieces that are welded to the main one; ``closing`` the joints closed by equalities.
    """

    pieces: list[Piece]
    main: dict[int, Piece]
    extra: list[Piece]
    closing: list[Revolute | Spherical]
    system: Mechanism

    def shares(self, body: Body) -> int:
        """Return the number of pieces of a body."""
        return 1 + sum(piece.body is body for piece in self.extra)


def lay_out(system: Mechanism, rods: bool) -> Layout:
    """Return the best tree for the loops: first what MuJoCo cannot close by itself, balls last; ``rods``: also
    these."""
    known = {*TABLE, ConstantVelocity, *((Distance,) if rods else ())}
    joints = [joint for joint in system.joints if type(joint) in known]
    referred = {id(other) for part in (*system.joints, *system.forces) for other in part.partners()}
    referred |= {id(joint) for joint in joints for driver in system.joints if turns_it(joint, driver)}
    tree = spanning(sorted(joints, key=lambda joint: rank(joint, id(joint) in referred)))
    layout = Layout([], {}, [], [], system)
    grow(layout, GROUND, tree)
    for body in system.bodies:
        if id(body) not in layout.main:
            layout.main[id(body)] = add(layout, body, None, None)
            grow(layout, body, tree)
    spanned = {id(joint) for joint in tree}
    for joint in joints:
        if id(joint) in spanned:
            continue
        if isinstance(joint, CLOSED_BY_EQUALITY) and id(joint) not in referred:
            layout.closing.append(joint)
        else:
            end = next(side for side in (joint.b, joint.a) if isinstance(side, Body))
            before = joint.a if end is joint.b else joint.b
            layout.extra.append(add(layout, end, layout.main.get(id(before)), joint, is_b=end is joint.b))
    return layout


def turns_it(joint: Joint, driver: Joint) -> bool:
    """Return whether a speed driver turns a hinge, which it does not name."""
    if not isinstance(driver, SpeedDriver) or driver.axis is None:
        return False
    own = joint.angle()
    return (
        own is not None
        and {own.a, own.b} == {driver.a, driver.b}
        and abs(abs(own.axis @ driver.axis) - 1.0) < PARALLEL_TOLERANCE
    )


def rank(joint: Joint, referred: bool) -> int:
    """Return the order in which joints enter the tree; one whose angle or displacement is used must have it as a
    coordinate.
    """
    if isinstance(joint, CLOSED_LATE + CLOSED_LOOSELY):
        return 4 if isinstance(joint, CLOSED_LATE) else 5
    if type(joint) not in (Revolute, Spherical) or referred:
        return 0 if isinstance(joint, Fixed) else 1
    return 2 if isinstance(joint, Revolute) else 3


def grow(layout: Layout, start: Any, tree: list[Joint]) -> None:
    """Add all pieces that the tree connects to ``start``."""
    links: dict[int, list[Joint]] = {}
    for joint in tree:
        for body in (joint.a, joint.b):
            links.setdefault(id(body), []).append(joint)
    queue = [start]
    while queue:
        before = queue.pop(0)
        for joint in links.get(id(before), []):
            body = joint.b if joint.a is before else joint.a
            if not isinstance(body, Body) or id(body) in layout.main:
                continue
            layout.main[id(body)] = add(layout, body, layout.main.get(id(before)), joint, is_b=body is joint.b)
            queue.append(body)


def add(layout: Layout, body: Body, parent: Piece | None, joint: Joint | None, is_b: bool = True) -> Piece:
    """Add a new piece."""
    title = f"{body.name} free" if joint is None else layout.system.name(joint)
    name = body.name if id(body) not in layout.main else f"{body.name} at {title}"
    taken = {piece.name for piece in layout.pieces} | {"world"}
    while name in taken:
        name += " (body)"
    piece = Piece(len(layout.pieces), name, body, parent, joint, title, is_b)
    layout.pieces.append(piece)
    return piece


def spanning(joints: Iterable[Joint]) -> list[Joint]:
    """Return the joints that connect bodies not yet connected by those before."""
    group: dict[int, int] = {}

    def root(i: int) -> int:
        while group.setdefault(i, i) != i:
            group[i] = group[group[i]]
            i = group[i]
        return i

    tree = []
    for joint in joints:
        a, b = root(id(joint.a)), root(id(joint.b))
        if a != b:
            group[a] = b
            tree.append(joint)
    return tree


class Coordinate(NamedTuple):
    """Joint of one coordinate of a piece: "slide", "hinge" or "ball", at a point along an axis, both of the body."""

    name: str
    kind: str
    at: np.ndarray
    axis: np.ndarray


@dataclass
class Placed:
    """Where the pieces of a layout lie with all coordinates at zero.

    ``poses``: number of a piece -> (r, R), world; ``joints``: number of a piece -> its `Freedoms`.
    """

    layout: Layout
    poses: dict[int, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    joints: dict[int, Freedoms] = field(default_factory=dict)

    def relative(self, piece: Piece, other: Piece | None) -> tuple[np.ndarray, np.ndarray]:
        """Return (r, R) of a piece in another one, None is the ground."""
        r, R = self.poses[piece.number]
        origin, axes = self.poses[other.number] if other else (np.zeros(3), np.eye(3))
        return axes.T @ (r - origin), axes.T @ R

    def place(self, piece: Piece) -> None:
        """Place a piece, whose parent is placed."""
        body, parent = piece.body, piece.parent
        origin, R_parent = (np.zeros(3), np.eye(3)) if parent is None else self.poses[parent.number]
        if piece.joint is None:
            r, R = body.position, body.axes
        else:
            free = self.joints[piece.number] = freedoms_of(piece.joint, piece.title)
            if isinstance(piece.joint, Distance):
                r, R = rod_rest_pose(piece, origin, R_parent @ local_axes(rod_ends(piece)[0], np.eye(3)))
            else:
                r, R = rest_pose(piece, free, origin, R_parent)
        self.poses[piece.number] = r, R

    def coordinates(self, piece: Piece) -> list[Coordinate]:
        """Return the translations and rotations of a piece; where it is body a, in the reverse order and sense."""
        if isinstance(piece.joint, Distance):
            return rod_coordinates(piece)
        free, sense = self.joints[piece.number], 1.0 if piece.is_b else -1.0
        at = piece.body.local_point(free.at_b if piece.is_b else free.at_a)
        own = local_axes(piece.body, free.B if piece.is_b else free.A)
        back = np.eye(3) if piece.is_b else free.rest
        parts = [(piece.named("slide", k), "slide", free.rest.T[:, k]) for k in free.slides]
        if free.turns is None:
            parts.append((piece.named("ball"), "ball", np.eye(3)[2]))
        else:
            parts += [(piece.named("turn", k), "hinge", axis) for k, axis in enumerate(free.turns)]
        ordered = parts if piece.is_b else parts[::-1]
        return [Coordinate(name, kind, at, sense * (own @ back @ axis)) for name, kind, axis in ordered]


def rest_pose(piece: Piece, free: Freedoms, origin: np.ndarray, R_parent: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (r, R) of the child where all coordinates are zero: there the origins are one and B = A rest."""
    joint: Any = piece.joint
    before, point, axes, turn = (
        (joint.a, free.at_a, free.A, free.rest) if piece.is_b else (joint.b, free.at_b, free.B, free.rest.T)
    )
    own_point, own_axes = (free.at_b, free.B) if piece.is_b else (free.at_a, free.A)
    F = R_parent @ local_axes(before, axes) @ turn
    R = F @ local_axes(piece.body, own_axes).T
    return origin + R_parent @ before.local_point(point) - R @ piece.body.local_point(own_point), R


def local_axes(body: Any, axes: np.ndarray) -> np.ndarray:
    """Return world axes at the reference pose as columns in body axes."""
    return axes if body is GROUND else body.axes.T @ axes


def rod_of(piece: Piece) -> Distance:
    """Return the joint of a piece that hangs on a rod."""
    if not isinstance(piece.joint, Distance):
        raise InputError(f"{piece.name} hangs on no rod; give one whose joint is a Distance")
    return piece.joint


def rod_ends(piece: Piece) -> tuple[Any, np.ndarray, np.ndarray]:
    """Return the parent, its point and the child's, world at the reference pose."""
    rod = rod_of(piece)
    return (rod.a, rod.at_a, rod.at_b) if piece.is_b else (rod.b, rod.at_b, rod.at_a)


def rod_axes(piece: Piece) -> np.ndarray:
    """Return E, world at the reference pose: z along the rod, to the child."""
    _, near, far = rod_ends(piece)
    z = (far - near) / np.linalg.norm(far - near)
    return np.column_stack([*perpendiculars(z), z])


def rod_rest_pose(piece: Piece, origin: np.ndarray, F: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (r, R) of the child with both angles zero; the parent has its O at ``origin``, and F rotates it from the
    reference pose.
    """
    parent, near, far = rod_ends(piece)
    R = F @ piece.body.axes
    tip = origin + F @ (near - parent.position + rod_of(piece).length * rod_axes(piece)[:, 2])
    return tip - R @ piece.body.local_point(far), R


def rod_coordinates(piece: Piece) -> list[Coordinate]:
    """Return two hinges at the parent's end of a rod and a ball at the child's, all in the child.

    Nothing lies between them, so that the rod has no mass. The rod points along E (sin q2, -sin q1 cos q2, cos q1 cos
    q2), E fixed in the parent, and at cos q2 = 0 it lies along the first hinge: there the joint is lost.
    """
    _, _, far = rod_ends(piece)
    E = rod_axes(piece)
    at, near = piece.body.local_point(far), piece.body.local_point(far - rod_of(piece).length * E[:, 2])
    hinges = [Coordinate(piece.named("swing", k), "hinge", near, piece.body.local_axis(E[:, k])) for k in range(2)]
    return [*hinges, Coordinate(piece.named("ball"), "ball", at, np.eye(3)[2])]
