"""Pulleys, drums and eyes of a rope, and the path of the rope over them at the reference pose.

Seen along the axis of a pulley, which points at the viewer: a rope from circle i to circle j, gone round by s = 1
(counterclockwise) or -1, leaves along their common tangent. With D from centre to centre, d its length in the plane of
the pulley, h the part out of it and rho = s_i R_i - s_j R_j, a tangent has the length sqrt(d^2 - rho^2 + h^2) and the
direction arg D + asin(rho / d). A point is a circle of radius 0.
"""

from dataclasses import KW_ONLY
from math import asin, atan2, cos, pi, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

from ..base.checks import as_tuple, short_repr, vector
from ..base.errors import InputError
from ..base.fields import Checked, DirectionOrDerived, Number, Stored, VectorOrDerived, kept, part_class
from ..base.rotations import cross
from .bodies import Body, Ground
from .joints import Joint, coordinate_of
from .primitives import ZERO, Coordinate

OFF_PLANE_MAX = 1e-6  # [1] of a span: by how much it may lead out of the plane of its pulley as built
WRAP_ROUNDING = 1e-9  # [rad] of a wrap: a rope that only touches a pulley has none


def as_carrier(value: Any, what: str, part: Any) -> Body | Ground | Joint:
    """Accept a body, the ground, or a hinge."""
    if isinstance(value, Body | Ground) or (isinstance(value, Joint) and value.angle() is not None):
        return value
    raise InputError(f"{what} = {short_repr(value)}; give a Body, GROUND, or the hinge about which its body b turns")


class BodyOrHinge(Stored[Body | Ground | Joint, Body | Ground | Joint]):
    """A body, or the hinge whose body b it is."""

    accepts, role, file_type = "Body | Ground | Joint", "body", str | dict[str, Any]
    convert = staticmethod(as_carrier)


def hinge_of(wheel: "Pulley", name: str) -> Joint:
    """Return the hinge of a pulley, or raise an InputError for a value that only a hinge can give."""
    if not isinstance(wheel.on, Joint):
        raise InputError(f"{wheel.what()}: on '{wheel.on.name}', which is not a hinge, without {name}; give {name}=")
    return wheel.on


def centre_of_hinge(wheel: "Pulley") -> np.ndarray:
    """Return the point of its hinge."""
    return hinge_of(wheel, "centre").point()


def axis_of_hinge(wheel: "Pulley") -> np.ndarray:
    """Return the axis of its hinge."""
    return coordinate_of(hinge_of(wheel, "axis"), "angle", wheel.what()).axis_b


def is_whole(value: Any) -> bool:
    """Return whether a value is a plain whole number."""
    return isinstance(value, int) and not isinstance(value, bool)


@part_class()
class Pulley(Checked):
    """A pulley that a `Rope` wraps: a circle fixed to a body.

    Parameters
    ----------
    on : Joint, Body or GROUND
        A hinge: the pulley is its body b. A body or GROUND: the pulley is fixed to it, as a bollard.
    radius : float
        R > 0 of the middle of the rope [m].
    sense : 1 or -1
        Along the rope from its first end to its last: 1 counterclockwise, seen with the axis pointing at the viewer, so
        that a pulley which turns about +axis carries the rope on; -1 clockwise.
    centre, axis : (3,) array_like or None
        World at the reference pose [m, -]; None = point and axis of the hinge.
    turns : int
        Whole turns, beyond the part of a turn that the path gives at the reference pose.

    Raises
    ------
    ValueError
        For a sense other than 1 and -1, turns below 0, and a pulley without a hinge that has no centre or axis.

    Examples
    --------
    >>> from mbsd3d import GROUND, Pulley
    >>> Pulley(GROUND, radius=0.1, sense=-1, centre=(0, 0, 2), axis=(0, 1, 0)).radius
    0.1
    """

    on: BodyOrHinge = kept()
    _: KW_ONLY
    radius: Number = kept(positive=True)
    sense: int
    centre: VectorOrDerived = kept(default=None, derived=centre_of_hinge)
    axis: DirectionOrDerived = kept(default=None, derived=axis_of_hinge)
    turns: int = 0

    def check(self, what: str) -> None:
        if not is_whole(self.sense) or abs(self.sense) != 1:
            raise InputError(f"{what}: sense = {short_repr(self.sense)}; give 1 or -1")
        if not is_whole(self.turns) or self.turns < 0:
            raise InputError(f"{what}: turns = {short_repr(self.turns)}; give a whole number >= 0")

    @property
    def body(self) -> Body | Ground:
        """Return the body that carries the pulley."""
        return self.on.b if isinstance(self.on, Joint) else self.on


@part_class()
class Winch(Pulley):
    """A drum to which an end of a `Rope` is fixed: as it turns by theta, it takes in or pays out R theta.

    The parameters are those of `Pulley` without ``turns``. In place of the first end of a rope it pays out as it turns
    in its ``sense``, in place of the last one it takes in. What is wound on it has no stretch, and there is always
    enough of it.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, Rope, System, Torque, Winch, accelerations
    >>> drum = Body("drum", mass=20.0, inertia=(0.4, 0.4, 0.4), position=(0, 0, 5))
    >>> load = Body("load", mass=80.0, inertia=(1, 1, 1), position=(0.1, 0, 0))
    >>> hinge = Revolute(GROUND, drum, at=(0, 0, 5), axis=(0, 1, 0))
    >>> rope = Rope((Winch(hinge, radius=0.1, sense=1), (load, (0.1, 0, 0.5))), stiffness=1e5, pretension=1000.0)
    >>> system = System([drum, load], [hinge], [rope, Torque(drum, (0, -120.0, 0))])
    >>> round(float(accelerations(system).alpha(drum)[0, 1]), 9)  # (1000 N * 0.1 m - 120 N m) / 0.4 kg m2
    -50.0
    """

    def check(self, what: str) -> None:
        super().check(what)
        if self.turns:
            raise InputError(f"{what}: turns = {self.turns}; leave it out, a drum always has enough rope on it")


class Node(NamedTuple):
    """Node of a rope: a circle or a point of a body."""

    body: Body | Ground
    point: np.ndarray  # world at the reference pose [m]
    arm: float = 0.0  # s R [m], 0 of a point
    axis: np.ndarray = ZERO  # of a circle
    turns: int = 0

    @property
    def is_circle(self) -> bool:
        """Return whether the node is a circle and not a point."""
        return self.arm != 0.0


Given = Pulley | tuple[Body | Ground, np.ndarray]


def as_point(value: Any, what: str) -> Given:
    """Convert (body, point) to a body and an array."""
    pair = as_tuple(value, what, "(body, point)")
    if len(pair) != 2 or not isinstance(pair[0], Body | Ground):
        raise InputError(f"{what} = {short_repr(value)}; give (body, point)")
    return pair[0], vector(pair[1], f"{what}: point")


def as_ends(value: Any, what: str, part: Any) -> tuple[Given, ...]:
    """Convert two ends: points of bodies, or drums."""
    ends = as_tuple(value, what, "two ends, each (body, point) or a Winch")
    if len(ends) != 2 or any(isinstance(x, Pulley) and not isinstance(x, Winch) for x in ends):
        raise InputError(f"{what}: {short_repr(value)}; give two ends, each (body, point) or a Winch")
    return tuple(x if isinstance(x, Winch) else as_point(x, f"{what} no. {k + 1}") for k, x in enumerate(ends))


def as_passed(value: Any, what: str, part: Any) -> tuple[Given, ...]:
    """Convert the nodes between the ends: pulleys, and points of bodies as eyes."""
    passed = (value,) if isinstance(value, Pulley) else as_tuple(value, what, "Pulleys")
    if any(isinstance(x, Winch) for x in passed):
        raise InputError(f"{what}: a Winch stands at an end of a rope; give a Pulley, or give the Winch in points=")
    return tuple(x if isinstance(x, Pulley) else as_point(x, f"{what} no. {k + 1}") for k, x in enumerate(passed))


class Ends(Stored[Any, tuple[Given, ...]]):
    """Two ends of a rope."""

    accepts, file_type = "two of (Body | Ground, array_like) | Winch", list
    convert = staticmethod(as_ends)


class Passed(Stored[Any, tuple[Given, ...]]):
    """Pulleys and eyes, one after the other."""

    accepts, file_type = "Sequence[Pulley | (Body | Ground, array_like)]", list
    convert = staticmethod(as_passed)


def nodes_of(given: tuple[Given, ...], what: str) -> list[Node]:
    """Return the nodes of a rope; pulleys that follow each other get one direction of their axes."""
    found: list[Node] = []
    for x in given:
        if not isinstance(x, Pulley):
            found.append(Node(*x))
            continue
        axis, sense = x.axis, x.sense
        if found and found[-1].is_circle:
            before = found[-1].axis
            if np.linalg.norm(cross(before, axis)) > OFF_PLANE_MAX:
                raise InputError(
                    f"{what}: the pulleys no. {len(found) - 1} and {len(found)} of its path have axes that are not "
                    "parallel; make them so, or lead the rope through an eye, (body, point), between them"
                )
            if before @ axis < 0.0:
                axis, sense = -axis, -sense
        found.append(Node(x.body, x.centre, sense * x.radius, axis, x.turns))
    return found


class Span(NamedTuple):
    """A straight part of a rope between two nodes at the reference pose."""

    length: float  # m
    direction: np.ndarray  # along the rope
    lean: float  # rad, from the line of centres to the direction
    ways: tuple[Coordinate, ...]  # bearing or slide from node to node; then the turn of the second pulley by the first

    @property
    def in_plane(self) -> bool:
        """Return whether the span leads to a pulley."""
        return self.ways[0].kind == "bearing"


def span_between(first: Node, second: Node, what: str) -> Span:
    """Return the tangent of two nodes."""
    gap = second.point - first.point
    distance = float(np.linalg.norm(gap))
    if not first.is_circle and not second.is_circle:
        if distance == 0.0:
            raise InputError(f"{what}: two points of it that follow each other coincide; move one of them")
        direction = gap / distance
        way = Coordinate("slide", first.body, second.body, direction, direction, first.point, second.point)
        return Span(distance, direction, 0.0, (way,))
    frame, other = (first, second) if first.is_circle else (second, first)
    n, rho = frame.axis, first.arm - second.arm
    off = float(n @ gap)
    if abs(off) > OFF_PLANE_MAX * distance:
        raise InputError(
            f"{what}: it leaves the plane of the pulley on '{frame.body.name}' by {abs(off):.4g} m on its way to "
            f"'{other.body.name}'; put both into one plane, or lead it through an eye, (body, point), in that plane"
        )
    flat = gap - off * n
    d = float(np.linalg.norm(flat))
    if d <= abs(rho) * (1.0 + WRAP_ROUNDING):
        inside = "one pulley lies inside the other" if other.is_circle else "the point lies inside the pulley"
        raise InputError(
            f"{what}: there is no tangent from '{first.body.name}' to '{second.body.name}', with centres {d:.4g} m "
            f"apart and radii that take {abs(rho):.4g} m: {inside}; move them apart, or give a smaller radius"
        )
    x, lean = flat / d, asin(rho / d)
    toward = x if frame is first else -x
    ways = [Coordinate("bearing", frame.body, other.body, n, n, frame.point, other.point, toward, toward)]
    if other.is_circle and other.body is not frame.body:
        ways.append(Coordinate("angle", frame.body, other.body, n, n))
    return Span(sqrt(d * d - rho * rho + off * off), cos(lean) * x + sin(lean) * cross(n, x), lean, tuple(ways))


def wrap_at(node: Node, before: Span, after: Span, what: str) -> float:
    """Return the angle [rad] over which a rope lies on a pulley."""
    u, v = before.direction, after.direction
    turn = np.sign(node.arm) * atan2(float(node.axis @ cross(u, v)), float(u @ v)) % (2.0 * pi)
    wrap = (turn if turn < 2.0 * pi - WRAP_ROUNDING else 0.0) + 2.0 * pi * node.turns
    if wrap < WRAP_ROUNDING:
        raise InputError(
            f"{what}: it passes the pulley on '{node.body.name}' without lying on it; move it, or leave it out"
        )
    return wrap


class Path(NamedTuple):
    """A rope at the reference pose."""

    nodes: list[Node]
    spans: list[Span]
    wraps: list[float]  # rad, by node; 0 of ends and eyes

    @property
    def length(self) -> float:
        """Return the length between the ends [m], without what is wound on drums."""
        arcs = (abs(node.arm) * wrap for node, wrap in zip(self.nodes, self.wraps, strict=True))
        return float(sum(span.length for span in self.spans) + sum(arcs))

    def rests(self) -> list[float]:
        """Return what the law finds of each span at the reference pose: its length and rho times its lean [m]."""
        pairs = zip(self.nodes[:-1], self.nodes[1:], self.spans, strict=True)
        return [span.length + (a.arm - b.arm) * span.lean for a, b, span in pairs]

    def offsets(self) -> list[float]:
        """Return the wrap of each node less what the law finds of it from the leans at the reference pose [rad]."""
        inner = zip(self.nodes[1:-1], self.wraps[1:-1], self.spans[:-1], self.spans[1:], strict=True)
        return [0.0, *(wrap - np.sign(node.arm) * (b.lean - a.lean) for node, wrap, a, b in inner), 0.0]


def path_of(given: tuple[Given, ...], what: str) -> Path:
    """Return the path over ends, pulleys and eyes in their order, or raise an InputError that names the obstacle."""
    nodes = nodes_of(given, what)
    spans = [span_between(a, b, what) for a, b in zip(nodes[:-1], nodes[1:], strict=True)]
    inner = zip(nodes[1:-1], spans[:-1], spans[1:], strict=True)
    wraps = [wrap_at(node, a, b, what) if node.is_circle else 0.0 for node, a, b in inner]
    return Path(nodes, spans, [0.0, *wraps, 0.0])
