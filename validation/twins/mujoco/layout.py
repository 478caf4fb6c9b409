"""Which joints span the tree, and how the others close loops.

A tree joint is the joint of a MuJoCo body with its parent. What closes a loop is two points kept together (Spherical),
two such pairs on the axis (Revolute); any other joint carries a *piece* of its body b, an equal share of mass and
inertia, that is welded to the rest: the two together move as the body does.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import mbsd3d
from mbsd3d import GROUND, Body, Joint, System
from validation.twins.mujoco.freedoms import ALONG, TABLE

DIRECT = (mbsd3d.Revolute, mbsd3d.Spherical)  # close a loop by equalities of their own
LATE = (mbsd3d.PointOnLine, mbsd3d.PointOnPlane)
"""Where body a is the child, a ball before slides: MuJoCo 4.0.1 has its J_dot wrong."""
LOOSE = (mbsd3d.Parallel, mbsd3d.Perpendicular, mbsd3d.Distance, mbsd3d.PositionDriver)
"""Keep no two points together: last to span the tree."""


@dataclass(eq=False)
class Piece:
    """A MuJoCo body: a body or a share of it, and the joint with its parent (None: it flies free)."""

    number: int
    body: Body
    parent: "Piece | None"  # None is the ground
    joint: Joint | None
    is_b: bool = True  # whether it is body b of the joint

    @property
    def name(self) -> str:
        """Of the MuJoCo body."""
        return f"piece {self.number}"


@dataclass(frozen=True)
class Layout:
    """Pieces in the order of the tree, parents first; ``main`` is the piece of a body in the tree.

    ``extra`` are the pieces that are welded to the main one; ``closing`` the joints closed by equalities.
    """

    pieces: list[Piece]
    main: dict[int, Piece]
    extra: list[Piece]
    closing: list[Joint]

    def shares(self, body: Body) -> int:
        """Into how many pieces a body is divided."""
        return 1 + sum(piece.body is body for piece in self.extra)


def lay_out(system: System, rods: bool) -> Layout:
    """The tree of most worth to the loops: what has no closure of its own first, balls last; ``rods``: these too."""
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
        if isinstance(joint, DIRECT) and id(joint) not in referred:
            layout.closing.append(joint)
        else:
            body, before = (joint.a, joint.b) if joint.b is GROUND else (joint.b, joint.a)
            piece = add(layout, body, layout.main.get(id(before)), joint, is_b=body is joint.b)
            layout.extra.append(piece)
    return layout


def turns_it(joint: Joint, driver: Joint) -> bool:
    """Whether a speed driver turns a hinge, which it does not name."""
    own = joint.angle() if isinstance(driver, mbsd3d.SpeedDriver) and driver.axis is not None else None
    return own is not None and {own.a, own.b} == {driver.a, driver.b} and abs(abs(own.axis @ driver.axis) - 1.0) < ALONG


def rank(joint: Joint, referred: bool) -> int:
    """Order in which joints are asked into the tree; one whose angle or slide is used must have it as a coordinate."""
    if isinstance(joint, LATE + LOOSE):
        return 4 if isinstance(joint, LATE) else 5
    if type(joint) not in (mbsd3d.Revolute, mbsd3d.Spherical) or referred:
        return 0 if isinstance(joint, mbsd3d.Fixed) else 1
    return 2 if isinstance(joint, mbsd3d.Revolute) else 3


def spanning(joints: Iterable[Joint]) -> list[Joint]:
    """The joints that join what was not joined by those before."""
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


def grow(layout: Layout, start: Any, tree: list[Joint]) -> None:
    """Hang on everything that the tree joins to ``start``."""
    links: dict[int, list[Joint]] = {}
    for joint in tree:
        for body in (joint.a, joint.b):
            links.setdefault(id(body), []).append(joint)
    queue = [start]
    while queue:
        before = queue.pop(0)
        for joint in links.get(id(before), []):
            body = joint.b if joint.a is before else joint.a
            if body is GROUND or id(body) in layout.main:
                continue
            layout.main[id(body)] = add(layout, body, layout.main.get(id(before)), joint, is_b=body is joint.b)
            queue.append(body)


def add(layout: Layout, body: Body, parent: Piece | None, joint: Joint | None, is_b: bool = True) -> Piece:
    """A new piece."""
    piece = Piece(len(layout.pieces), body, parent, joint, is_b)
    layout.pieces.append(piece)
    return piece
