"""Degrees of freedom of each joint, the joints of the tree, and the loop closures of the others.

A joint of mbsd3d is a frame A on body a, a frame B on body b, and between them slides s along axes of A and turns:
p_b - p_a = A s, B = A R(turns) rest. All coordinates are zero where B = A rest, at the reference pose if a and b are
built to fit.

A tree joint is the joint of a MuJoCo body with its parent. What closes a loop is two points kept together (Spherical),
two such pairs on the axis (Revolute); any other joint carries a *piece* of its body b, an equal share of mass and
inertia, that is welded to the rest: the two together move as the body does.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import mbsd3d
from mbsd3d import GROUND, Body, Joint, System
from mbsd3d.extend import matched_perpendiculars, perpendiculars
from validation.twins.base import NotExpressible, spanning

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
    slides: tuple
    turns: np.ndarray | None
    angles: Callable[[np.ndarray], tuple]
    rest: np.ndarray

    def turn_axis(self) -> np.ndarray | None:
        """Return the world axis of the only hinge, fixed in a and in b; None if there are none or several."""
        return None if self.turns is None or len(self.turns) != 1 else self.A @ self.rest @ self.turns[0]


def no_angle(R: np.ndarray) -> tuple:
    """Return no angles, for a joint without hinges."""
    return ()


def about_z(R: np.ndarray) -> tuple:
    """Return the angle of R = Rz(q) [rad]."""
    return (np.arctan2(R[1, 0], R[0, 0]),)


def about_xy(R: np.ndarray) -> tuple:
    """Return the angles of R = Rx(q1) Ry(q2): its second column is (0, cos q1, sin q1), its first row (cos q2, 0, sin
    q2).
    """
    return np.arctan2(R[2, 1], R[1, 1]), np.arctan2(R[0, 2], R[0, 0])


def about_zyz(R: np.ndarray) -> tuple:
    """Return the angles of R = Rz(q1) Ry(q2) Rz(q3), q2 in (0, pi): third column (cos q1 sin q2, sin q1 sin q2, cos
    q2).
    """
    bend = np.arctan2(np.hypot(R[0, 2], R[1, 2]), R[2, 2])
    return np.arctan2(R[1, 2], R[0, 2]), bend, np.arctan2(R[2, 1], -R[2, 0])


TABLE: dict[type, tuple] = {  # slides, hinges about axes of B, their angles
    mbsd3d.Fixed: ((), (), no_angle),
    mbsd3d.Revolute: ((), (Z,), about_z),
    mbsd3d.Spherical: ((), BALL_ANGLES, no_angle),
    mbsd3d.Universal: ((), (X, Y), about_xy),
    mbsd3d.Prismatic: ((Z,), (), no_angle),
    mbsd3d.Cylindrical: ((Z,), (Z,), about_z),
    mbsd3d.Screw: ((Z,), (Z,), about_z),
    mbsd3d.Planar: ((X, Y), (Z,), about_z),
    mbsd3d.PointOnLine: ((Z,), BALL_ANGLES, no_angle),
    mbsd3d.PointOnPlane: ((X, Y), BALL_ANGLES, no_angle),
    mbsd3d.PositionDriver: (
        (X, Y, Z),
        BALL_ANGLES,
        no_angle,
    ),  # a point of b and its three places, some of which are driven
    mbsd3d.Parallel: ((X, Y, Z), (Z,), about_z),
    mbsd3d.Perpendicular: ((X, Y, Z), (X, Y), about_xy),
}


def freedoms_of(joint: Joint, name: str) -> Freedoms:
    """Return frames and degrees of freedom of a joint of `TABLE`, of a ConstantVelocity or Distance; errors name it."""
    if type(joint) is mbsd3d.ConstantVelocity:
        return shafts(joint, name)
    if type(joint) is mbsd3d.Distance:  # see `rods`
        return Freedoms(np.eye(3), np.eye(3), joint.at_a, joint.at_b, (), BALL_ANGLES, no_angle, np.eye(3))
    slides, hinges, angles = TABLE[type(joint)]
    A, B = frames(joint)
    at_a, at_b = getattr(joint, "at", joint.point()), joint.point()
    turns = None if hinges is BALL_ANGLES else np.eye(3)[list(hinges)]
    return Freedoms(A, B, at_a, at_b, slides, turns, angles, np.eye(3))


def frames(joint: Joint) -> tuple[np.ndarray, np.ndarray]:
    """Return the axes of A and B: z is the axis of the joint, x and y of A and B those from which mbsd3d counts its
    angle.
    """
    if isinstance(joint, mbsd3d.Universal | mbsd3d.Perpendicular):  # a cross: x is axis_a, y is axis_b
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


def shafts(joint: mbsd3d.ConstantVelocity, name: str) -> Freedoms:
    """Return hinges about shaft a, the common normal n and shaft b; constant velocity is the additional row q3 = -q1.

    B = A Rz(q) Ry(bend) Rz(-q) turns about an axis across z, which is what the row of mbsd3d says: with n of both
    sides, n_a . (z_b x n_b) = (z_a x n_a) . n_b.
    """
    normal = np.cross(joint.axis_a, joint.axis_b)
    bend = np.arctan2(np.linalg.norm(normal), joint.axis_a @ joint.axis_b)
    if bend < BEND_MIN:
        raise NotExpressible(
            f"joint '{name}' (ConstantVelocity): its shafts enclose {np.degrees(bend):.3g} degrees; MuJoCo has it as "
            f"three hinges, and above {np.degrees(BEND_MIN):.3g} degrees only"
        )
    A, B = (right_handed(np.cross(normal, z), normal) for z in (joint.axis_a, joint.axis_b))
    rest = A.T @ B
    turns = np.array([rest.T[:, Z], np.eye(3)[Y], np.eye(3)[Z]])

    def angles(R: np.ndarray) -> tuple:
        first, second, third = about_zyz(R)
        return first, second - bend, third

    return Freedoms(A, B, joint.at, joint.at_b, (), turns, angles, rest)


CLOSED_BY_EQUALITY = (mbsd3d.Revolute, mbsd3d.Spherical)  # close a loop by equalities of their own
CLOSED_LATE = (mbsd3d.PointOnLine, mbsd3d.PointOnPlane)
"""Where body a is the child, a ball before slides: MuJoCo 4.0.1 has its J_dot wrong."""
CLOSED_LOOSELY = (mbsd3d.Parallel, mbsd3d.Perpendicular, mbsd3d.Distance, mbsd3d.PositionDriver)
"""Keep no two points together: last to span the tree."""


@dataclass(eq=False)
class Piece:
    """MuJoCo body: a body or a share of it, and the joint with its parent (None: free)."""

    number: int
    body: Body
    parent: "Piece | None"  # None is the ground
    joint: Joint | None
    is_b: bool = True  # whether it is body b of the joint

    @property
    def name(self) -> str:
        """Return the name of the MuJoCo body."""
        return f"piece {self.number}"


@dataclass(frozen=True)
class Layout:
    """Pieces in the order of the tree, parents first; ``main`` is the piece of a body in the tree.

    ``extra`` are the pieces that are welded to the main one; ``closing`` the joints closed by equalities.
    """

    pieces: list[Piece]
    main: dict[int, Piece]
    extra: list[Piece]
    closing: list[mbsd3d.Revolute | mbsd3d.Spherical]

    def shares(self, body: Body) -> int:
        """Return the number of pieces of a body."""
        return 1 + sum(piece.body is body for piece in self.extra)


def lay_out(system: System, rods: bool) -> Layout:
    """Return the best tree for the loops: first what MuJoCo cannot close by itself, balls last; ``rods``: also
    these."""
    known = {*TABLE, mbsd3d.ConstantVelocity, *((mbsd3d.Distance,) if rods else ())}
    joints = [joint for joint in system.joints if type(joint) in known]
    referred = {id(other) for part in (*system.joints, *system.forces) for other in part.partners()}
    referred |= {id(joint) for joint in joints for driver in system.joints if turns_it(joint, driver)}
    tree = spanning(sorted(joints, key=lambda joint: rank(joint, id(joint) in referred)))
    layout = Layout([], {}, [], [])
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
    if not isinstance(driver, mbsd3d.SpeedDriver) or driver.axis is None:
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
    if type(joint) not in (mbsd3d.Revolute, mbsd3d.Spherical) or referred:
        return 0 if isinstance(joint, mbsd3d.Fixed) else 1
    return 2 if isinstance(joint, mbsd3d.Revolute) else 3


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
    piece = Piece(len(layout.pieces), body, parent, joint, is_b)
    layout.pieces.append(piece)
    return piece
