"""Laws along a hinge or slider: springs, friction, brakes."""

from collections.abc import Callable
from typing import Any

import numpy as np

from mbsd3d import Brake, CurveContact, JointFriction, TorsionSpring
from mbsd3d.extend import Coordinate, cross, hinge_coordinate, perpendiculars
from validation.twins.base import Array
from validation.twins.laws.moving import STATELESS, ZERO_VECTOR, Law, Moving, Placed, Push, follow, one_axis


def along_hinge(force: Any, what: str, load: Callable) -> Law:
    """Return the law of ``load(t, x, x_dot, z)`` = (load on b along a hinge or slider, rates of the internal
    states)."""
    x = hinge_coordinate(force.hinge, what)
    if isinstance(force.hinge, CurveContact):
        return along_curve(force.hinge, load)
    one_axis(x, what, "its law is written about one axis")
    sliding = x.kind == "slide"

    def push(t: float, a: Moving, b: Moving, z: Array, counted: float) -> Push:
        axis, point = a.axis(x.axis), b.point(x.point_b) if sliding else b.r
        rate = axis @ (b.velocity(point) - a.velocity(point) if sliding else b.omega - a.omega)
        value = axis @ (point - a.point(x.point_a)) if sliding else angle(x, a, b, counted)
        size, rates = load(t, value, rate, z)
        return Push(size * axis, point, ZERO_VECTOR, rates) if sliding else Push(ZERO_VECTOR, point, size * axis, rates)

    return Law(x.a, x.b, push)


def along_curve(joint: CurveContact, load: Callable) -> Law:
    """Return the same law along a curve: s where x'. (p - x) = 0 of a point p, or x'. e = 0 under a face e, all in axes
    of a.
    """
    line, face = joint.line, joint.face

    def push(t: float, a: Moving, b: Moving, z: Array, counted: float) -> Push:
        point = b.point(joint.at)
        e = a.R.T @ (point - a.r + a.R @ a.body.position if face is None else b.axis(face))
        s = line.nearest(e) if face is None else line.highest(e)
        tangent, bend = line.x(s, 1), line.x(s, 2)
        if face is None:
            way = a.R @ tangent / (tangent @ tangent - (e - line.x(s)) @ bend)
            rate = way @ (b.velocity(point) - a.velocity(point))
        else:
            way = a.R @ cross(tangent, e) / (e @ bend)
            rate = way @ (b.omega - a.omega)
        value = s - joint.start
        size, rates = load(t, value + line.length * round((counted - value) / line.length), rate, z)
        along, about = (size * way, ZERO_VECTOR) if face is None else (ZERO_VECTOR, size * way)
        return Push(along, point, about, rates)

    return Law(joint.a, joint.b, push)


def angle(x: Coordinate, a: Placed, b: Placed, counted: float) -> float:
    """Return the angle from a line of a to that of b about their axis [rad], with the turns of the counted one."""
    first, axis = perpendiculars(x.axis)[0], a.axis(x.axis)
    u, w = a.axis(first), b.axis(first)
    principal = np.arctan2(axis @ cross(u, w), u @ w)
    return principal + 2 * np.pi * round((counted - principal) / (2 * np.pi))


def brake_law(brake: Brake, what: str) -> Law:
    """Return the law of a spring and a damper that slip at a torque or force, which may change."""
    most, k, c = follow(brake.torque), brake.stiffness, brake.damping

    def load(t: float, x: float, rate: float, z: Array) -> tuple[float, Array]:
        limit = max(most(t), 0.0)
        f = np.clip(k * z[0] + c * rate, -limit, limit)
        return -f, np.array([(f - k * z[0]) / c])

    return along_hinge(brake, what, load)


def friction_law(friction: JointFriction, what: str) -> Law:
    """Return the law of dry friction smoothed at rest, and viscous friction."""
    T, c, v0 = friction.coulomb, friction.viscous, friction.transition
    return along_hinge(friction, what, lambda t, x, rate, z: (-T * np.tanh(rate / v0) - c * rate, STATELESS))


def torsion_law(spring: TorsionSpring, what: str) -> Law:
    """Return the law of spring and damper of a hinge or slider."""
    k, c, x0 = spring.stiffness, spring.damping, spring.angle
    return along_hinge(spring, what, lambda t, x, rate, z: (-k * (x - x0) - c * rate, STATELESS))
