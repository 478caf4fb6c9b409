"""Every joint once more from its definition, as Taylor series along motions; shares no kernel with ``mbsd3d``.

Geometry is c(q, t) = 0, often in other functions than the kernels use (a x b = 0 instead of two dots, squared lengths,
three rows of rank two), or a condition s(q, v, t) = 0 on velocities (rolling, knife edge, tooth mesh). Series to second
order give exact first and second derivatives; their payload has any leading axes, vectors end with an axis of 3,
scalars with one of 1.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import mbsd3d
from mbsd3d import GROUND, Joint, State, System
from validation.twins.base import refused

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Series:
    """x(s) = x0 + x1 s + x2 s^2.

    Examples
    --------
    >>> s = Series(np.array([2.0]), np.array([1.0]), np.array([0.0]))
    >>> [float(x) for x in ((s * s).x1[0], (1.0 / s).x1[0])]
    [4.0, -0.25]
    """

    x0: Array
    x1: Array
    x2: Array

    def __add__(self, other: "Series | Array | float") -> "Series":
        other = series(other)
        return Series(self.x0 + other.x0, self.x1 + other.x1, self.x2 + other.x2)

    def __mul__(self, other: "Series | Array | float") -> "Series":
        return bilinear(np.multiply, self, other)

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self) -> "Series":
        return self * -1.0

    def __sub__(self, other: "Series | Array | float") -> "Series":
        return self + series(other) * -1.0

    def __rtruediv__(self, other: "Series | Array | float") -> "Series":
        y0 = 1.0 / self.x0
        y1 = -self.x1 * y0 * y0
        return Series(y0, y1, -(self.x2 * y0 + self.x1 * y1) * y0) * other

    def __truediv__(self, other: "Series") -> "Series":
        return other.__rtruediv__(self)


def series(x: Series | Array | float) -> Series:
    """A constant as a series; a series stays as it is."""
    return x if isinstance(x, Series) else Series(np.asarray(x, float), np.zeros(1), np.zeros(1))


def bilinear(function: Callable, a: Series | Array | float, b: Series | Array | float) -> Series:
    """Series of a product of any kind."""
    a, b = series(a), series(b)
    return Series(
        function(a.x0, b.x0),
        function(a.x0, b.x1) + function(a.x1, b.x0),
        function(a.x0, b.x2) + function(a.x1, b.x1) + function(a.x2, b.x0),
    )


def dot(a: Series, b: Series) -> Series:
    """a . b"""
    return bilinear(lambda x, y: (x * y).sum(axis=-1, keepdims=True), a, b)


def cross(a: Series, b: Series) -> Series:
    """a x b"""

    def product(x: Array, y: Array) -> Array:
        shape = np.broadcast_shapes(x.shape, y.shape, (3,))
        return np.cross(np.broadcast_to(x, shape), np.broadcast_to(y, shape))

    return bilinear(product, a, b)


def sqrt(a: Series) -> Series:
    """Square root."""
    y0 = np.sqrt(a.x0)
    y1 = a.x1 / (2.0 * y0)
    return Series(y0, y1, (a.x2 - y1 * y1) / (2.0 * y0))


def arctan2(y: Series, x: Series) -> Series:
    """Angle of (x, y): theta' = (x y' - y x') / (x^2 + y^2)."""
    n = x.x0**2 + y.x0**2
    turn = (x.x0 * y.x1 - y.x0 * x.x1) / n
    n1 = 2.0 * (x.x0 * x.x1 + y.x0 * y.x1)
    return Series(np.arctan2(y.x0, x.x0), turn, (x.x0 * y.x2 - y.x0 * x.x2) / n - 0.5 * turn * n1 / n)


def rotation(e: Array) -> Array:
    """R(e) = (e0^2 - e_v'e_v) 1 + 2 e_v e_v' + 2 e0 [e_v]x for a unit quaternion."""
    e0, v = e[0], e[1:]
    return (e0**2 - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * e0 * np.cross(np.eye(3), v)


class Motion:
    """Bodies at a pose, moving with constant world velocities (r_dot, w); many motions side by side.

    Parameters
    ----------
    velocities : (d, n, 6) ndarray
        d motions of n bodies.
    """

    def __init__(self, system: System, state: State, velocities: Array) -> None:
        self.t, self.index = state.t, {id(body): i for i, body in enumerate(system.bodies)}
        poses = state.q.reshape(-1, 7)
        self.r, self.R = poses[:, :3], [rotation(e / np.linalg.norm(e)) for e in poses[:, 3:]]
        self.r_dot, self.w = velocities[..., :3], velocities[..., 3:]

    def now(self, body: Any, reference: Array) -> Array:
        """Where a direction fixed in the body points now, given as it points at the reference pose."""
        return self.R[self.index[id(body)]] @ rotation(body.orientation).T @ reference

    def axis(self, body: Any, reference: Array) -> Series:
        """A body-fixed direction: a + w x a s + w x (w x a) s^2 / 2."""
        if body is GROUND:
            return series(reference)
        a, w = self.now(body, reference), self.w[:, self.index[id(body)]]
        turn = np.cross(w, a)
        return Series(np.broadcast_to(a, turn.shape), turn, 0.5 * np.cross(w, turn))

    def origin(self, body: Any) -> Series:
        """The reference point."""
        if body is GROUND:
            return series(np.zeros(3))
        i = self.index[id(body)]
        return Series(np.broadcast_to(self.r[i], self.r_dot[:, i].shape), self.r_dot[:, i], np.zeros(3))

    def point(self, body: Any, reference: Array) -> Series:
        """A body-fixed point."""
        return self.origin(body) + self.axis(body, reference - body.position)

    def rates(self, body: Any) -> tuple[Series, Series]:
        """(r_dot, w)."""
        if body is GROUND:
            return series(np.zeros(3)), series(np.zeros(3))
        i = self.index[id(body)]
        return series(self.r_dot[:, i]), series(self.w[:, i])

    def velocity(self, body: Any, point: Series) -> Series:
        """Velocity of the matter of a body that passes a point of space."""
        r_dot, w = self.rates(body)
        return r_dot + cross(w, point - self.origin(body))

    def slip(self, a: Any, b: Any, point: Series) -> Series:
        """Velocity of b relative to a at a point."""
        return self.velocity(b, point) - self.velocity(a, point)

    def signal(self, f: Any) -> Series:
        """A prescribed function of time."""
        return Series(
            *(np.array([float(x)]) for x in (f(self.t), f.derivative(self.t), f.second_derivative(self.t) / 2))
        )

    def gap(self, j: Any) -> Series:
        """From the joint's point on a to that on b."""
        return self.point(j.b, j.at_b) - self.point(j.a, j.at)

    def slide(self, j: Any) -> Series:
        """Way of b along the axis of a."""
        return dot(self.axis(j.a, j.axis), self.gap(j))

    def parallel(self, j: Any, a: Array, b: Array) -> Series:
        """a x b (3 rows of rank 2)."""
        return cross(self.axis(j.a, a), self.axis(j.b, b))

    def turn(self, j: Any, axis: Array) -> Series:
        """Twist about an axis that both bodies share: tan = (R21 - R12) / (R11 + R22)."""
        x = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
        x = x / np.linalg.norm(x)
        y = np.cross(axis, x)
        xa, ya, xb, yb = (self.axis(body, v) for body in (j.a, j.b) for v in (x, y))
        return arctan2(dot(ya, xb) - dot(xa, yb), dot(xa, xb) + dot(ya, yb))

    def untwisted(self, j: Any) -> Series:
        """No relative rotation: sum of e_a x e_b over a triad (3 rows)."""
        first, *rest = (self.parallel(j, e, e) for e in np.eye(3))
        return first + rest[0] + rest[1]


def constant_velocity(k: Motion, j: Any) -> Series:
    """No turn about the bisector: the quaternion between yokes (n, axis x n, axis) has no third component."""
    n = np.cross(j.axis_a, j.axis_b)
    n = n / np.linalg.norm(n)
    (xa, ya), (xb, yb) = (
        [k.axis(body, v) for v in (n, np.cross(axis, n))] for body, axis in ((j.a, j.axis_a), (j.b, j.axis_b))
    )
    return dot(ya, xb) - dot(xa, yb)


def advance(k: Motion, j: Any) -> Series:
    """Slide less pitch times turn."""
    return k.slide(j) - k.turn(j, j.axis) * (j.pitch / (2 * np.pi))


def distance(k: Motion, j: Any) -> Series:
    """(gap^2 - L^2) / 2 L."""
    gap = k.point(j.b, j.at_b) - k.point(j.a, j.at_a)
    return dot(gap, gap) * (0.5 / j.length) - 0.5 * j.length


def contact(k: Motion, j: Any) -> Series:
    """Point of a torus nearest to a plane: down the disc by radius - crown, then down the plane's normal by crown."""
    n, u = k.axis(j.a, j.plane[1]), k.axis(j.b, j.axis)
    steepest = cross(u, cross(u, n))
    ring = steepest * ((j.radius - j.crown) / sqrt(dot(steepest, steepest)))
    return k.point(j.b, j.centre) + ring - n * j.crown


def touching(k: Motion, j: Any) -> Series:
    """Point of a sphere, an ellipsoid or a torus nearest to a plane: there the gradient of the surface is along -n."""
    form, n = j.surface, k.axis(j.a, j.plane[1])
    R, own = mbsd3d.rotations.matrix(j.b.orientation), mbsd3d.rotations.matrix(form.orientation)
    centre = k.point(j.b, j.b.position + R @ (j.b.com if form.at is None else form.at))
    if isinstance(form, mbsd3d.shapes.Sphere):
        return centre - n * form.radius
    if isinstance(form, mbsd3d.shapes.Torus):
        axis = dict(zip("xyz", np.eye(3), strict=True))[form.axis] if isinstance(form.axis, str) else form.axis
        u = k.axis(j.b, R @ own @ axis / np.linalg.norm(axis))
        steepest = cross(u, cross(u, n))
        return centre + steepest * (form.radius / sqrt(dot(steepest, steepest))) - n * form.tube
    away, square = series(np.zeros(3)), series(np.zeros(1))
    for radius, e in zip(form.radii, (R @ own).T, strict=True):
        part = dot(k.axis(j.b, e), n) * radius
        away, square = away + k.axis(j.b, e) * part * radius, square + part * part
    return centre - away / sqrt(square)


def position(k: Motion, j: Any) -> list[Series]:
    """Displacement along the driven world axes less the signals."""
    way = k.point(j.body, j.at) - j.at
    return [dot(way, series(e)) - k.signal(f) for e, f in zip(np.eye(3), j.signal, strict=True) if f is not None]


def mesh(k: Motion, j: Any) -> list[Series]:
    """n . (v_b - v_a) = 0 at the pitch point of the carrier."""
    carrier = j.support()
    return [dot(k.axis(carrier, j.direction()), k.slip(j.a, j.b, k.point(carrier, j.at)))]


GEOMETRY: dict[type, Callable] = {
    mbsd3d.Spherical: lambda k, j: [k.gap(j)],
    mbsd3d.Revolute: lambda k, j: [k.gap(j), k.parallel(j, j.axis, j.axis_b)],
    mbsd3d.Universal: lambda k, j: [k.gap(j), dot(k.axis(j.a, j.axis_a), k.axis(j.b, j.axis_b))],
    mbsd3d.Prismatic: lambda k, j: [cross(k.axis(j.a, j.axis), k.gap(j)), k.untwisted(j)],
    mbsd3d.Cylindrical: lambda k, j: [cross(k.axis(j.a, j.axis), k.gap(j)), k.parallel(j, j.axis, j.axis_b)],
    mbsd3d.Planar: lambda k, j: [dot(k.axis(j.a, j.normal), k.gap(j)), k.parallel(j, j.normal, j.normal)],
    mbsd3d.Fixed: lambda k, j: [k.gap(j), k.untwisted(j)],
    mbsd3d.PointOnLine: lambda k, j: [cross(k.axis(j.a, j.axis), k.gap(j))],
    mbsd3d.PointOnPlane: lambda k, j: [dot(k.axis(j.a, j.normal), k.gap(j))],
    mbsd3d.Distance: lambda k, j: [distance(k, j)],
    mbsd3d.Parallel: lambda k, j: [k.parallel(j, j.axis, j.axis_b)],
    mbsd3d.Perpendicular: lambda k, j: [dot(k.axis(j.a, j.axis_a), k.axis(j.b, j.axis_b))],
    mbsd3d.ConstantVelocity: lambda k, j: [k.gap(j), constant_velocity(k, j)],
    mbsd3d.Screw: lambda k, j: [
        *GEOMETRY[mbsd3d.Cylindrical](k, j),
        k.slide(j) - k.turn(j, j.axis) * (j.pitch / (2 * np.pi)),
    ],
    mbsd3d.Gear: lambda k, j: [k.turn(j.hinge_b, j.hinge_b.axis) - k.turn(j.hinge_a, j.hinge_a.axis) * j.ratio],
    mbsd3d.RackPinion: lambda k, j: [k.slide(j.rack) - k.turn(j.pinion, j.pinion.axis) * j.radius],
    mbsd3d.AngleDriver: lambda k, j: [k.turn(j.hinge, j.hinge.angle().axis) - k.signal(j.signal)],
    mbsd3d.SlideDriver: lambda k, j: [k.slide(j.slider) - k.signal(j.signal)],
    mbsd3d.PositionDriver: position,
}
"""Joint class -> c(q, t) as series."""

VELOCITY: dict[type, Callable] = {
    mbsd3d.GearMesh: mesh,
    mbsd3d.RollingDisc: lambda k, j: [k.slip(j.a, j.b, contact(k, j))],
    mbsd3d.Rolling: lambda k, j: [k.slip(j.a, j.b, touching(k, j))],
    mbsd3d.KnifeEdge: lambda k, j: [dot(k.axis(j.b, j.lateral), k.slip(j.a, j.b, k.point(j.b, j.at_b)))],
    mbsd3d.SpeedDriver: lambda k, j: [
        dot(k.axis(j.a, j.axis), k.rates(j.b)[1] - k.rates(j.a)[1]) - k.signal(j.speed)
        if j.direction is None
        else dot(k.axis(j.b, j.direction), k.slip(j.a, j.b, k.point(j.b, j.at))) - k.signal(j.speed)
    ],
}  # fmt: skip
"""Joint class -> s(q, v, t), linear in v."""

TURNS: dict[type, Callable] = {
    mbsd3d.AngleDriver: lambda j: [(1.0, j.hinge)],
    mbsd3d.Gear: lambda j: [(1.0, j.hinge_b), (-j.ratio, j.hinge_a)],
    mbsd3d.RackPinion: lambda j: [(-j.radius, j.pinion)],
    mbsd3d.Screw: lambda j: [(-j.pitch / (2 * np.pi), j)],
}
"""Joint class -> (factor, hinge): whole turns of hinges add to the last part of c, which knows angles to +-pi only."""


def law_of(system: System, joint: Joint) -> tuple[int, Callable]:
    """(1 for c or 0 for s, the function); NotExpressible for a class without a definition."""
    for order, table in ((1, GEOMETRY), (0, VELOCITY)):
        if type(joint) in table:
            return order, table[type(joint)]
    raise refused(system, joint, {}, "no definition is written for it")
