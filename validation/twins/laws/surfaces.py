"""Laws of contacts and tyres from their definitions, the tyre by the bristles of `validation.theory.free_wheel`."""

from dataclasses import fields
from typing import Any, cast

import numpy as np

from mbsd3d import Contact, Tyre, shapes
from mbsd3d.extend import cross, perpendiculars, skew
from validation.theory.free_wheel import Rubber, contact_point, tread
from validation.twins.base import Array
from validation.twins.laws.moving import Law, Moving, Push, deepest, follow


def contact_law(contact: Contact, what: str) -> Law:
    """Return the law of a rounded ellipsoid on a plane, or of a sphere on a sphere or capsule: normal force, friction,
    rolling and spinning resistance.
    """
    form = contact.outline
    sizes = (contact.friction, contact.rolling, contact.spinning)

    def push(t: float, a: Moving, b: Moving, z: Array, x: float) -> Push:
        n, first, point, depth = (over_plane if contact.other is None else over_bar)(contact, a, b)
        along = np.array([first, cross(n, first)])
        V, turn = b.velocity(point) - a.velocity(point), b.omega - a.omega
        rate = -n @ V
        N = 0.0
        if depth > 0.0:
            elastic = contact.stiffness * depth**contact.exponent
            N = max(elastic * (1.0 + contact.loss * rate) + contact.damping * rate, 0.0)
        motions = along @ V, along @ turn, n @ turn
        against, rates = resistance(contact, [mu * N for mu in sizes], contact.bristles, form.size, motions, z)
        friction, roll, spin = against
        return Push(N * n - friction @ along, point, -(roll @ along + spin * n), rates)

    return Law(contact.a, contact.b, push)


def over_plane(contact: Contact, a: Moving, b: Moving) -> tuple[Array, Array, Array, float]:
    """Return (normal, first axis of the plane, point of contact, depth) of a surface over a plane."""
    at, normal = contact.plane
    n = a.axis(normal)
    point = deepest(b, contact.outline, n)
    return n, a.axis(perpendiculars(normal)[0]), point, float(-n @ (point - a.point(at)))


def over_bar(contact: Contact, a: Moving, b: Moving) -> tuple[Array, Array, Array, float]:
    """Return the same of a sphere over a sphere or capsule: from the nearest of the ends and the foot on the line.

    The first axis is turned from that of the element by the rotation that takes its normal to the present one.
    """
    record, radius, form = contact.record(), contact.outline.size, cast(Any, contact.other)
    half = 0.5 * form.length if isinstance(form, shapes.Capsule) else 0.0
    middle, centre = a.point(record.points[0]), b.point(record.points[1])
    axis, _, normal = (a.axis(x) for x in record.frame.T)
    foot = float(axis @ (centre - middle))
    feet = [middle + s * axis for s in (-half, half, *([foot] if abs(foot) < half else []))]
    line = min((centre - x for x in feet), key=lambda x: float(x @ x))
    distance = float(np.linalg.norm(line))
    n = line / distance
    K = skew(cross(normal, n))
    turn = np.eye(3) + K + K @ K / (1.0 + normal @ n)
    low, high = distance - radius, form.radius  # along n from the axis: where both surfaces are
    return n, turn @ axis, centre - line + 0.5 * (low + high) * n, high - low


def resistance(
    contact: Contact, most: list[float], grip: tuple[float, float], size: float, motions: tuple[Array, Array, float],
    z: Array,
) -> tuple[tuple[Array, Array, float], Array]:  # fmt: skip
    """Return ((friction, moment against rolling, against spinning), rates of the internal states) in axes of the
    plane."""
    slips, lengths = [np.atleast_1d(x) for x in motions], (1.0, size, size)
    if not contact.state_names():
        v0 = contact.creep or 1.0
        found = [m * x / np.hypot(np.linalg.norm(x), v0 / s) for m, x, s in zip(most, slips, lengths, strict=True)]
        return (found[0], found[1], float(found[2][0])), np.zeros(0)
    parts = np.split(np.concatenate([z, np.zeros(5 - len(z))]), [2, 4])
    found, rates = [], []
    for m, x, s, bent in zip(most, slips, lengths, parts, strict=True):
        k, c = (value * s**2 for value in grip)
        wanted = k * bent + c * x
        held = wanted * min(1.0, m / max(float(np.linalg.norm(wanted)), 1e-300))
        found.append(held)
        rates.append((held - k * bent) / c)
    return (found[0], found[1], float(found[2][0])), np.concatenate(rates)[: len(z)]


def tyre_law(tyre: Tyre, what: str) -> Law:
    """Return the law of a torus on a plane, with deflections and the forces of bristles."""
    at, normal = tyre.plane
    first = perpendiculars(normal)[0]
    numbers = {one.name: getattr(tyre, one.name) for one in fields(Rubber)}
    (longitudinal, relaxation_x), nominal_load = tyre.ahead, tyre.nominal_load or 1.0
    numbers |= {"longitudinal": longitudinal, "relaxation_x": relaxation_x, "nominal_load": nominal_load, "mu": None}
    rubber = Rubber(**numbers)
    mu = None if tyre.mu is None else follow(tyre.mu)

    def push(t: float, a: Moving, b: Moving, z: Array, x: float) -> Push:
        n, first_now = a.axis(normal), a.axis(first)
        axes = np.array([first_now, cross(n, first_now), n])
        hub = b.point(tyre.centre)
        here, axle = axes @ (hub - a.point(at)), axes @ b.axis(tyre.axis)
        point = hub + axes.T @ contact_point(rubber, here, axle)
        v, turning = b.velocity(hub) - a.velocity(point), b.omega - a.omega
        grip = None if mu is None else mu(t)
        found = tread(rubber, grip, here, axle, axes @ v, axes @ b.omega, z, axes @ turning)
        return Push(axes.T @ found[0], hub, axes.T @ found[1], found[2])

    return Law(tyre.a, tyre.b, push)
