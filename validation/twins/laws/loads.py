"""Laws of springs and mounts between two bodies, loads on one, weight and attraction."""

import numpy as np

from mbsd3d import GROUND, AeroDrag, Bushing, CentralGravity, Force, SpringDamper, Torque, Weight
from mbsd3d.extend import cross, matrix
from validation.twins.base import Array
from validation.twins.laws.moving import ZERO_VECTOR, Law, Moving, Push, follow


def spring_law(spring: SpringDamper, what: str) -> Law:
    """Return the law of a tension along the line between two points, from the rate of the squared length.

    Where the points meet the line is that of the motion, along which its limit from either side is the same.
    """

    def push(t: float, a: Moving, b: Moving, z: Array, x: float) -> Push:
        p, q = a.point(spring.at_a), b.point(spring.at_b)
        square, moving = (q - p) @ (q - p), b.velocity(q) - a.velocity(p)
        if spring.length == 0.0 and square == 0.0:
            return Push(-spring.damping * moving, q)
        rate, length = 2.0 * (q - p) @ moving, np.sqrt(square)
        tension = spring.stiffness * (length - spring.length) + spring.damping * rate / (2.0 * length)
        return Push(tension * (p - q) / length, q)  # the line of action passes both points

    return Law(spring.a, spring.b, push)


def bushing_law(bushing: Bushing, what: str) -> Law:
    """Return the law of springs along and about axes in a; the moment of the energy 2 p'K p from angle and axis of the
    relative rotation.
    """
    F = matrix(bushing.axes)

    def push(t: float, a: Moving, b: Moving, z: Array, x: float) -> Push:
        axes, point = a.R @ F, b.point(bushing.at)
        d, rate = point - a.point(bushing.at), b.velocity(point) - a.velocity(point)
        force = bushing.stiffness * (axes.T @ d) + bushing.damping * (axes.T @ rate)
        turn = axes.T @ b.R @ F
        half = 0.5 * np.arccos(np.clip(0.5 * (np.trace(turn) - 1.0), -1.0, 1.0))
        away = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        p = away / (4.0 * np.cos(half))
        twist = bushing.turning_stiffness * p
        couple = 2.0 * (np.cos(half) * twist + cross(p, twist)) + bushing.turning_damping * (
            axes.T @ (b.omega - a.omega)
        )
        return Push(-axes @ force, point, -axes @ couple)

    return Law(bushing.a, bushing.b, push)


def force_law(force: Force, what: str) -> Law:
    """Return the law of prescribed force components [N] at a point."""
    parts, in_body = [follow(x) for x in force.force], force.frame == "body"

    def push(t: float, a: Moving, b: Moving, z: Array, x: float) -> Push:
        given = np.array([f(t) for f in parts])
        return Push(b.axes @ given if in_body else given, b.point(force.at))

    return Law(GROUND, force.body, push)


def torque_law(torque: Torque, what: str) -> Law:
    """Return the law of prescribed torque components [N m] in world or body axes."""
    parts, in_body = [follow(x) for x in torque.torque], torque.frame == "body"

    def push(t: float, a: Moving, b: Moving, z: Array, x: float) -> Push:
        given = np.array([f(t) for f in parts])
        return Push(ZERO_VECTOR, b.r, b.axes @ given if in_body else given)

    return Law(GROUND, torque.body, push)


def drag_law(drag: AeroDrag, what: str) -> Law:
    """Return the law -rho/2 c_d A |u| u in the wind."""
    wind, k = [follow(x) for x in drag.wind], 0.5 * drag.density * drag.drag_area

    def push(t: float, a: Moving, b: Moving, z: Array, x: float) -> Push:
        point = b.point(drag.at)
        u = b.velocity(point) - [f(t) for f in wind]
        return Push(-k * np.linalg.norm(u) * u, point)

    return Law(GROUND, drag.body, push)


def weight_law(weight: Weight, what: str) -> Law:
    """Return the law of weight along a direction of a, which does not feel it."""

    def push(t: float, a: Moving, b: Moving, z: Array, x: float) -> Push:
        return Push(weight.b.mass * a.axis(weight.acceleration), b.point(weight.b.centre))

    return Law(weight.a, weight.b, push, back=False)


def attraction_law(gravity: CentralGravity, what: str) -> Law:
    """Return the law of attraction, the gradient of MacCullagh's energy in the position and, as a moment, in the
    rotation of a body.
    """
    body, mu = gravity.b, gravity.mu

    def push(t: float, a: Moving, b: Moving, z: Array, x: float) -> Push:
        centre, axes = b.point(body.centre), b.axes
        d, I = centre - a.point(gravity.at), axes @ body.inertia @ axes.T
        square = d @ d
        trace, along = np.trace(I), d @ I @ d  # U = -mu (m s^-1/2 + tr I s^-3/2 / 2 - 3 d'I d s^-5/2 / 2), s = d'd
        slope = -0.5 * body.mass * square**-1.5 - 0.75 * trace * square**-2.5 + 3.75 * along * square**-3.5
        force = mu * (2.0 * slope * d - 3.0 * square**-2.5 * (I @ d))
        return Push(force, centre, 3.0 * mu * square**-2.5 * cross(d, I @ d))

    return Law(gravity.a, body, push)
