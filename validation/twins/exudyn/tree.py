"""Tree of hinges and guides as one kinematic tree of Exudyn, in its hinge coordinates.

Every joint becomes one or two hinge coordinates; between two of one joint is a massless link. The frame of a
link is its joint frame, z along the axis; coordinates count from the reference pose as in `mbsd3d`.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from mbsd3d import GROUND, Cylindrical, Prismatic, Revolute, State, System, Universal
from mbsd3d.extend import (
    Coordinate,
    angle_of,
    conjugate,
    cross,
    matched_perpendiculars,
    matrix,
    multiply,
    perpendiculars,
    slide_of,
)
from validation.twins.base import Array, NotExpressible, label, refuse_reflected

TURN, SHIFT = "RevoluteZ", "PrismaticZ"


class Frame(NamedTuple):
    """Point and axes (columns), world at the reference pose."""

    point: Array
    axes: Array


class Link(NamedTuple):
    """Hinge coordinate of a tree: its kind, its parent link (-1: ground), its frame there and on its own body."""

    kind: str
    parent: int
    there: Frame
    here: Frame
    body: Any  # None for a link without mass
    value: float  # Of the coordinate at the start [rad or m]


def axis_frames(joint: Revolute | Prismatic | Cylindrical, reverse: bool) -> tuple[Frame, Frame]:
    """Return frames (inner, outer) along the axis, which counts from a to b whichever side is the inner one."""
    x, y = perpendiculars(joint.axis)
    first = Frame(joint.at, np.column_stack([x, y, joint.axis]))
    second = Frame(joint.at_b, np.column_stack([*matched_perpendiculars(joint.axis, joint.axis_b), joint.axis_b]))
    return (turned(second), turned(first)) if reverse else (first, second)


def turned(frame: Frame) -> Frame:
    """Return the frame with z against the axis."""
    return Frame(frame.point, frame.axes * (1.0, -1.0, -1.0))


def along(axis: Array, point: Array, sign: float) -> Frame:
    """Return a frame with z along plus or minus an axis."""
    x, y = perpendiculars(axis)
    return Frame(point, np.column_stack([x, sign * y, sign * axis]))


class Start:
    """Hinge coordinates at the start, by the poses of the bodies."""

    def __init__(self, system: System, state: State) -> None:
        self.system, self.state = system, state
        q = state.q.reshape(-1, 7)
        turns = multiply(q[:, 3:], conjugate(np.array([body.orientation for body in system.bodies])))
        self.turn = {id(body): e for body, e in zip(system.bodies, turns, strict=True)}
        self.turn[id(GROUND)] = np.array([1.0, 0.0, 0.0, 0.0])
        self.place = {id(body): r for body, r in zip(system.bodies, q[:, :3], strict=True)} | {id(GROUND): np.zeros(3)}

    def point(self, body: Any, point: Array) -> Array:
        """Return the present position of a point of a body."""
        return self.place[id(body)] + matrix(self.turn[id(body)]) @ (point - body.position)

    def angle(self, x: Coordinate) -> float:
        """Return an angle [rad]; its whole turns do not matter to a tree."""
        relative = matrix(multiply(conjugate(self.turn[id(x.a)]), self.turn[id(x.b)]))
        x_a, y_a = perpendiculars(x.axis)
        x_b = relative @ matched_perpendiculars(x.axis, x.axis_b)[0]
        return float(np.arctan2(y_a @ x_b, x_a @ x_b))

    def slide(self, x: Coordinate) -> float:
        """Return the displacement along the axis [m]."""
        axis = matrix(self.turn[id(x.a)]) @ x.axis
        return float(axis @ (self.point(x.b, x.point_b) - self.point(x.a, x.point_a)))

    def cross(self, joint: Universal) -> tuple[float, float]:
        """Return the angles about axis_a and axis_b: relative = turn(axis_a, first) turn(axis_b, second)."""
        R = matrix(multiply(conjugate(self.turn[id(joint.a)]), self.turn[id(joint.b)]))
        a, b = joint.axis_a, joint.axis_b
        c, d = cross(a, b), R.T @ a
        return float(np.arctan2(c @ (R @ b), b @ (R @ b))), float(np.arctan2(d @ cross(a, b), d @ a))


def revolute(joint: Revolute, start: Start, reverse: bool) -> list[tuple]:
    """Return the single rotation axis of a revolute joint."""
    return [(TURN, *axis_frames(joint, reverse), start.angle(angle_of(joint)))]


def prismatic(joint: Prismatic, start: Start, reverse: bool) -> list[tuple]:
    """Return the single translation of a prismatic joint."""
    return [(SHIFT, *axis_frames(joint, reverse), start.slide(slide_of(joint)))]


def cylindrical(joint: Cylindrical, start: Start, reverse: bool) -> list[tuple]:
    """Return a translation, then a rotation about the same axis."""
    inner, outer = axis_frames(joint, reverse)
    return [(SHIFT, inner, inner, start.slide(slide_of(joint))), (TURN, inner, outer, start.angle(angle_of(joint)))]


def universal(joint: Universal, start: Start, reverse: bool) -> list[tuple]:
    """Return the two rotations of a universal joint."""
    first, second = start.cross(joint)
    sign = -1.0 if reverse else 1.0
    inner, outer = (joint.at_b, joint.at) if reverse else (joint.at, joint.at_b)
    turns = [(joint.axis_a, first), (joint.axis_b, second)][:: int(sign)]
    return [
        (TURN, along(turns[0][0], inner, sign), along(turns[0][0], inner, sign), turns[0][1]),
        (TURN, along(turns[1][0], inner, sign), along(turns[1][0], outer, sign), turns[1][1]),
    ]


TREE_JOINTS: dict[type, tuple[str, Callable]] = {
    Revolute: ("RevoluteZ", revolute),
    Prismatic: ("PrismaticZ", prismatic),
    Cylindrical: ("PrismaticZ and RevoluteZ", cylindrical),
    Universal: ("two RevoluteZ", universal),
}
"""Joint class -> how a kinematic tree has it, and its coordinates from the inner to the outer side."""


def links_of(system: System, state: State) -> tuple[list[Link], dict[tuple, int]]:
    """Return links from the ground outwards, and the number of every hinge coordinate (kind, joint).

    NotExpressible for joints that a tree has not, loops and free bodies.
    """
    start, last = Start(system, state), {id(GROUND): -1}
    links: list[Link] = []
    numbers: dict[tuple, int] = {}
    waiting = list(system.joints)
    for joint in waiting:
        refuse_reflected(system, joint)
    for joint in waiting:
        if type(joint) not in TREE_JOINTS:
            known = ", ".join(kind.__name__ for kind in TREE_JOINTS)
            raise NotExpressible(f"{label(system, joint)}: a kinematic tree of Exudyn has only {known}")
    while waiting:
        ready = [joint for joint in waiting if id(joint.a) in last or id(joint.b) in last]
        if not ready:
            raise NotExpressible(f"{label(system, waiting[0])}: does not hang on the ground; use rigid bodies")
        joint = ready[0]
        waiting.remove(joint)
        if id(joint.a) in last and id(joint.b) in last:
            raise NotExpressible(f"{label(system, joint)}: closes a loop, which a kinematic tree has not")
        reverse = id(joint.b) in last
        outer, parent = (joint.a, last[id(joint.b)]) if reverse else (joint.b, last[id(joint.a)])
        steps = TREE_JOINTS[type(joint)][1](joint, start, reverse)
        for k, (kind, there, here, value) in enumerate(steps):
            links.append(Link(kind, parent, there, here, outer if k == len(steps) - 1 else None, value))
            parent = len(links) - 1
            numbers.setdefault((kind, id(joint)), parent)
        last[id(outer)] = parent
    for body in system.bodies:
        if id(body) not in last:
            raise NotExpressible(f"body '{body.name}': is free, which no link of a kinematic tree is; use rigid bodies")
    return links, numbers
