"""Definition of every joint, as Taylor series along motions; shares no kernel with ``mbsd3d``.

Geometry is c(q, t) = 0, often in other functions than the kernels use (a x b = 0 instead of two dots, squared lengths,
three rows of rank two), or a condition s(q, v, t) = 0 on velocities (rolling, knife edge, tooth mesh). Series to second
order give exact first and second derivatives; their payload has any leading axes, vectors end with an axis of 3,
scalars with one of 1.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

import mbsd3d
from mbsd3d import GROUND, Joint, State, System
from validation.twins.base import refuse_reflected, refused
from validation.twins.definitions.series import Array, Series, arctan2, cross, dot, series, sqrt


def rotation(e: Array) -> Array:
    """Return R(e) = (e0^2 - e_v'e_v) 1 + 2 e_v e_v' + 2 e0 [e_v]x for a unit quaternion."""
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
        """Return the present direction of a body-fixed vector, given at the reference pose."""
        return self.R[self.index[id(body)]] @ rotation(body.orientation).T @ reference

    def axis(self, body: Any, reference: Array) -> Series:
        """Return a body-fixed direction: a + w x a s + w x (w x a) s^2 / 2."""
        if body is GROUND:
            return series(reference)
        a, w = self.now(body, reference), self.w[:, self.index[id(body)]]
        turn = np.cross(w, a)
        return Series(np.broadcast_to(a, turn.shape), turn, 0.5 * np.cross(w, turn))

    def origin(self, body: Any) -> Series:
        """Return the reference point of a body."""
        if body is GROUND:
            return series(np.zeros(3))
        i = self.index[id(body)]
        return Series(np.broadcast_to(self.r[i], self.r_dot[:, i].shape), self.r_dot[:, i], np.zeros(3))

    def point(self, body: Any, reference: Array) -> Series:
        """Return a body-fixed point."""
        return self.origin(body) + self.axis(body, reference - body.position)

    def rates(self, body: Any) -> tuple[Series, Series]:
        """Return (r_dot, w) of a body."""
        if body is GROUND:
            return series(np.zeros(3)), series(np.zeros(3))
        i = self.index[id(body)]
        return series(self.r_dot[:, i]), series(self.w[:, i])

    def velocity(self, body: Any, point: Series) -> Series:
        """Return the velocity of the material point of a body at a point of space."""
        r_dot, w = self.rates(body)
        return r_dot + cross(w, point - self.origin(body))

    def slip(self, a: Any, b: Any, point: Series) -> Series:
        """Return the velocity of b relative to a at a point."""
        return self.velocity(b, point) - self.velocity(a, point)

    def signal(self, f: Any) -> Series:
        """Return a prescribed function of time as a series."""
        return Series(
            *(np.array([float(x)]) for x in (f(self.t), f.derivative(self.t), f.second_derivative(self.t) / 2))
        )

    def gap(self, j: Any) -> Series:
        """Return the vector from the joint's point on a to that on b."""
        return self.point(j.b, j.at_b) - self.point(j.a, j.at)

    def slide(self, j: Any) -> Series:
        """Return the displacement of b along the axis of a, or along a curve."""
        if isinstance(j, mbsd3d.CurveContact):
            return on_curve(self, j)[1] - j.start
        return dot(self.axis(j.a, j.axis), self.gap(j))

    def counted(self, j: Any) -> tuple[Any, Series, float]:
        """Return (hinge coordinate, its value here, its period: a turn, or once round a curve)."""
        if isinstance(j, mbsd3d.CurveContact):
            return j.slide(), self.slide(j), j.line.length
        return j.angle(), self.turn(j), 2 * np.pi

    def parallel(self, j: Any, a: Array, b: Array) -> Series:
        """Return a x b (3 rows of rank 2)."""
        return cross(self.axis(j.a, a), self.axis(j.b, b))

    def turn(self, j: Any) -> Series:
        """Return the rotation about the axis of a joint, which both bodies share: tan = (R21 - R12) / (R11 + R22)."""
        axis = j.angle().axis
        x = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
        x = x / np.linalg.norm(x)
        y = np.cross(axis, x)
        xa, ya, xb, yb = (self.axis(body, v) for body in (j.a, j.b) for v in (x, y))
        return arctan2(dot(ya, xb) - dot(xa, yb), dot(xa, xb) + dot(ya, yb))

    def untwisted(self, j: Any) -> Series:
        """Return the rows of no relative rotation: sum of e_a x e_b over a triad (3 rows)."""
        first, *rest = (self.parallel(j, e, e) for e in np.eye(3))
        return first + rest[0] + rest[1]


def constant_velocity(k: Motion, j: Any) -> Series:
    """Return the row of no turn about the bisector: the quaternion between yokes (n, axis x n, axis) has no third
    component.
    """
    n = np.cross(j.axis_a, j.axis_b)
    n = n / np.linalg.norm(n)
    (xa, ya), (xb, yb) = (
        [k.axis(body, v) for v in (n, np.cross(axis, n))] for body, axis in ((j.a, j.axis_a), (j.b, j.axis_b))
    )
    return dot(ya, xb) - dot(xa, yb)


def advance(k: Motion, j: Any) -> Series:
    """Return the displacement less pitch times rotation."""
    return k.slide(j) - k.turn(j) * (j.pitch / (2 * np.pi))


def distance(k: Motion, j: Any) -> Series:
    """Return the row (gap^2 - L^2) / 2 L."""
    gap = k.point(j.b, j.at_b) - k.point(j.a, j.at_a)
    return dot(gap, gap) * (0.5 / j.length) - 0.5 * j.length


def edge(k: Motion, j: Any, centre: Array, axis: Array, ring: float, tube: float) -> Series:
    """Return the point of a torus nearest to a plane: down the disc by the ring, then down the plane's normal by the
    tube.
    """
    n = k.axis(j.a, j.plane[1])
    steepest = cross(k.axis(j.b, axis), cross(k.axis(j.b, axis), n))
    return k.point(j.b, centre) + steepest * (ring / sqrt(dot(steepest, steepest))) - n * tube


def touching(k: Motion, j: Any) -> Series:
    """Return the point of a torus or an ellipsoid nearest to a plane: where the gradient of the surface is along -n."""
    form, R, n = j.surface, mbsd3d.rotations.matrix(j.b.orientation), k.axis(j.a, j.plane[1])
    centre, axes = j.b.position + R @ form.origin(j.b), (R @ mbsd3d.rotations.matrix(form.orientation)).T
    if isinstance(form, mbsd3d.shapes.Torus):
        axis = axes["xyz".index(form.axis)] if isinstance(form.axis, str) else np.asarray(form.axis) @ axes
        return edge(k, j, centre, axis / np.linalg.norm(axis), form.radius, form.tube)
    radii = form.radii if isinstance(form, mbsd3d.shapes.Ellipsoid) else 3 * (form.radius,)
    parts = [dot(k.axis(j.b, e), n) * r for r, e in zip(radii, axes, strict=True)]
    length = sqrt(sum((part * part for part in parts), series(np.zeros(1))))
    away = sum((k.axis(j.b, e) * part * r for r, e, part in zip(radii, axes, parts, strict=True)), series(np.zeros(3)))
    return k.point(j.b, centre) - away / length


def position(k: Motion, j: Any) -> list[Series]:
    """Return the displacement along the driven world axes less the signals."""
    way = k.point(j.body, j.at) - j.at
    return [dot(way, series(e)) - k.signal(f) for e, f in zip(np.eye(3), j.signal, strict=True) if f is not None]


def mesh(k: Motion, j: Any) -> list[Series]:
    """Return the row n . (v_b - v_a) = 0 at the pitch point of the carrier."""
    carrier = j.support()
    return [dot(k.axis(carrier, j.direction()), k.slip(j.a, j.b, k.point(carrier, j.at)))]


def along(curve: Callable, s: Series, order: int = 0) -> Series:
    """Return a piecewise polynomial or its derivative at s."""
    value, rate, bend = (curve(s.x0[..., 0], order + n) for n in range(3))
    return Series(value, rate * s.x1, rate * s.x2 + 0.5 * bend * s.x1**2)


def seen_from(k: Motion, body: Any, x: Series) -> Series:
    """Return a vector in axes of a body, as it points where the body is at the reference pose."""
    return sum((dot(k.axis(body, e), x) * e for e in np.eye(3)), series(np.zeros(3)))


def on_curve(k: Motion, j: Any) -> tuple[Series, Series]:
    """Return (the point of b in axes of a, s of the nearest point of a curve or of that under a face) by Newton on
    series.
    """
    p = seen_from(k, j.a, k.point(j.b, j.at) - k.origin(j.a)) + j.a.position
    e, weight = (p, 1.0) if j.face is None else (seen_from(k, j.a, k.axis(j.b, j.face)), 0.0)
    known = p.x0.reshape(-1, 3)[0] if weight else e.x0.reshape(-1, 3)[0]
    start = j.line.nearest(known) if weight else j.line.highest(known)
    s = series(np.full((*p.x1.shape[:-1], 1), start))
    tangent, bend = j.line.x(start, 1), j.line.x(start, 2)
    slope = bend @ (known - weight * j.line.x(start)) - weight * tangent @ tangent
    for _ in range(2):  # one order a step
        s = s - dot(along(j.line.x, s, 1), e - along(j.line.x, s) * weight) * (1.0 / slope)
    return p, s


def beside_curve(k: Motion, j: Any) -> list[Series]:
    """Return the distance from the nearest point of a curve along its normals, or from the point under a face."""
    p, s = on_curve(k, j)
    off = p - along(j.line.x, s)
    if j.face is not None:
        return [dot(seen_from(k, j.a, k.axis(j.b, j.face)), off)]
    return [dot(along(n, s), off) - (j.radius or 0.0) for n in j.across]


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
    mbsd3d.CurveContact: beside_curve,
    mbsd3d.Screw: lambda k, j: [
        *GEOMETRY[mbsd3d.Cylindrical](k, j),
        advance(k, j),
    ],
    mbsd3d.Gear: lambda k, j: [k.turn(j.hinge_b) - k.turn(j.hinge_a) * j.ratio],
    mbsd3d.RackPinion: lambda k, j: [k.slide(j.rack) - k.turn(j.pinion) * j.radius],
    mbsd3d.AngleDriver: lambda k, j: [k.turn(j.hinge) - k.signal(j.signal)],
    mbsd3d.SlideDriver: lambda k, j: [k.slide(j.slider) - k.signal(j.signal)],
    mbsd3d.PositionDriver: position,
}
"""Joint class -> c(q, t) as series."""

VELOCITY: dict[type, Callable] = {
    mbsd3d.GearMesh: mesh,
    mbsd3d.RollingDisc: lambda k, j: [k.slip(j.a, j.b, edge(k, j, j.centre, j.axis, j.radius - j.crown, j.crown))],
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
    mbsd3d.SlideDriver: lambda j: [(1.0, j.slider)] * isinstance(j.slider, mbsd3d.CurveContact),
    mbsd3d.Gear: lambda j: [(1.0, j.hinge_b), (-j.ratio, j.hinge_a)],
    mbsd3d.RackPinion: lambda j: [(-j.radius, j.pinion), *[(1.0, j.rack)] * isinstance(j.rack, mbsd3d.CurveContact)],
    mbsd3d.Screw: lambda j: [(-j.pitch / (2 * np.pi), j)],
}
"""Joint class -> (factor, joint): whole turns add to the last part of c, which knows angles to +-pi only."""


def law_of(system: System, joint: Joint) -> tuple[int, Callable]:
    """Return (1 for c or 0 for s, the function); raise NotExpressible for a class without a definition."""
    refuse_reflected(system, joint)
    for order, table in ((1, GEOMETRY), (0, VELOCITY)):
        if type(joint) in table:
            return order, table[type(joint)]
    raise refused(system, joint, {}, "no definition is written for it")
