"""Contacts, tyres and brakes in Exudyn: loads of bodies by functions of Python.

Own states are velocities of coordinates of their own, of unit mass, so that the solvers of Exudyn keep their order.
The laws are written out here and in `validation.theory.free_wheel`, from their definitions; nothing of the compiled
ones is used. Place and motion of the bodies are Exudyn's own at every evaluation.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from mbsd3d import GROUND, Brake, Contact, Tyre
from mbsd3d.extend import cross, hinge_coordinate, perpendiculars
from validation.theory.free_wheel import Rubber, contact_point, tread
from validation.twins.base import Array, NotExpressible
from validation.twins.exudyn.assembly import Assembly
from validation.twins.exudyn.couplings import Placed, deepest, follow

Law = Callable[[float, "Moving", "Moving", Array], tuple[Array, Array, Array, Array]]
"""(t, a, b, own states) -> (force on b, its point, couple on b, rates of the own states), world axes."""


@dataclass(frozen=True, eq=False)
class Moving(Placed):
    """With its velocities."""

    v: Array
    omega: Array

    def velocity(self, point: Array) -> Array:
        """Velocity of its matter at a point of space."""
        return self.v + cross(self.omega, point - self.r)


def moving(model: Assembly, mbs: Any, body: Any) -> Moving:
    """A body, asked of Exudyn."""
    if body is GROUND:
        return Moving(body, np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3))
    kinds, number = model.module.OutputVariableType, model.body[id(body)]
    wanted = (kinds.Position, kinds.RotationMatrix, kinds.Velocity, kinds.AngularVelocity)
    r, R, v, omega = (np.array(mbs.GetObjectOutputBody(number, kind, [0.0, 0.0, 0.0])) for kind in wanted)
    return Moving(body, r, R.reshape(3, 3), v, omega)


def add_law(model: Assembly, force: Any, bodies: tuple[Any, Any], law: Law, what: str) -> None:
    """Loads on the bodies a, b of a force, and coordinates whose velocities are its own states."""
    if not isinstance(model, Assembly):
        raise NotExpressible(f"{what}: a kinematic tree has no place for its law; take the formulation 'rigid bodies'")
    count = len(force.state_names())
    first = sum(len(other.state_names()) for other in model.system.forces[: model.system.forces.index(force)])
    start = model.state.z[first : first + count]
    node = None
    if count:
        still = [0.0] * count
        node = model.mbs.AddNode(model.items.NodeGenericODE2(
            referenceCoordinates=still, initialCoordinates=still, initialCoordinates_t=start,
            numberOfODE2Coordinates=count,
        ))  # fmt: skip
    last: dict[str, Any] = {}

    def now(mbs: Any, t: float) -> tuple[Array, Array, Array, Array, Moving, Moving]:
        """The law at the state that Exudyn evaluates; asked for up to five times there."""
        a, b = (moving(model, mbs, body) for body in bodies)
        kind = model.module.OutputVariableType.Coordinates_t
        z = np.atleast_1d(mbs.GetNodeOutput(node, kind)) if count else np.zeros(0)
        key = b"".join(x.tobytes() for x in (np.array(t), a.r, a.R, a.v, a.omega, b.r, b.R, b.v, b.omega, z))
        if last.get("key") != key:
            last.update(key=key, found=law(t, a, b, z))
        return *last["found"], a, b

    for sign, body, which in ((1.0, bodies[1], 5), (-1.0, bodies[0], 4)):
        if body is GROUND:
            continue
        marker = model.marker(body, body.position)

        def push(mbs: Any, t: float, vector: Any, sign: float = sign) -> Array:
            return sign * now(mbs, t)[0]

        def turn(mbs: Any, t: float, vector: Any, sign: float = sign, which: int = which) -> Array:
            found = now(mbs, t)
            return sign * (cross(found[1] - found[which].r, found[0]) + found[2])

        model.mbs.AddLoad(model.items.LoadForceVector(markerNumber=marker, loadVectorUserFunction=push))
        model.mbs.AddLoad(model.items.LoadTorqueVector(markerNumber=marker, loadVectorUserFunction=turn))
    if count:
        item = model.items.ObjectGenericODE2(
            nodeNumbers=[node], massMatrix=np.eye(count), forceUserFunction=lambda mbs, t, item, q, q_t: now(mbs, t)[3]
        )
        model.connect(force, item)


def add_contact(model: Assembly, contact: Contact, what: str) -> None:
    """The lowest point of a rounded ellipsoid presses, rubs, and resists rolling and spinning."""
    form, (at, normal) = contact.outline, contact.plane
    sizes = (contact.friction, contact.rolling, contact.spinning)

    def law(t: float, a: Moving, b: Moving, z: Array) -> tuple[Array, Array, Array, Array]:
        n = a.axis(normal)
        first = a.axis(perpendiculars(normal)[0])
        along = np.array([first, cross(n, first)])
        point = deepest(b, form, n)
        V, turn = b.velocity(point) - a.velocity(point), b.omega - a.omega
        depth, rate = -n @ (point - a.point(at)), -n @ V
        N = 0.0
        if depth > 0.0:
            elastic = contact.stiffness * depth**contact.exponent
            N = max(elastic * (1.0 + contact.loss * rate) + contact.damping * rate, 0.0)
        motions = along @ V, along @ turn, n @ turn
        against, rates = resistance(contact, [mu * N for mu in sizes], contact.bristles, form.size, motions, z)
        friction, roll, spin = against
        return N * n - friction @ along, point, -(roll @ along + spin * n), rates

    add_law(model, contact, (contact.a, contact.b), law, what)


def resistance(
    contact: Contact, most: list[float], grip: tuple[float, float], size: float, motions: tuple[Array, Array, float],
    z: Array,
) -> tuple[tuple[Array, Array, float], Array]:  # fmt: skip
    """((friction, moment against rolling, against spinning), rates of the own states) in axes of the plane."""
    motions, lengths = [np.atleast_1d(x) for x in motions], (1.0, size, size)
    if not contact.state_names():
        v0 = contact.creep or 1.0
        found = [m * x / np.hypot(np.linalg.norm(x), v0 / s) for m, x, s in zip(most, motions, lengths, strict=True)]
        return (found[0], found[1], float(found[2][0])), np.zeros(0)
    parts = np.split(np.concatenate([z, np.zeros(5 - len(z))]), [2, 4])
    found, rates = [], []
    for m, x, s, bent in zip(most, motions, lengths, parts, strict=True):
        k, c = (value * s**2 for value in grip)
        wanted = k * bent + c * x
        held = wanted * min(1.0, m / max(np.linalg.norm(wanted), 1e-300))
        found.append(held)
        rates.append((held - k * bent) / c)
    return (found[0], found[1], float(found[2][0])), np.concatenate(rates)[: len(z)]


def add_tyre(model: Assembly, tyre: Tyre, what: str) -> None:
    """A torus on a plane, with deflections and the forces of bristles."""
    at, normal = tyre.plane
    first = perpendiculars(normal)[0]
    numbers = {one.name: getattr(tyre, one.name) for one in fields(Rubber)}
    (longitudinal, relaxation_x), nominal_load = tyre.ahead, tyre.nominal_load or 1.0
    numbers |= {"longitudinal": longitudinal, "relaxation_x": relaxation_x, "nominal_load": nominal_load, "mu": None}
    rubber = Rubber(**numbers)
    mu = None if tyre.mu is None else follow(tyre.mu)

    def law(t: float, a: Moving, b: Moving, z: Array) -> tuple[Array, Array, Array, Array]:
        n, x = a.axis(normal), a.axis(first)
        axes = np.array([x, cross(n, x), n])
        hub = b.point(tyre.centre)
        here, axle = axes @ (hub - a.point(at)), axes @ b.axis(tyre.axis)
        point = hub + axes.T @ contact_point(rubber, here, axle)
        v, turning = b.velocity(hub) - a.velocity(point), b.omega - a.omega
        grip = None if mu is None else mu(t)
        found = tread(rubber, grip, here, axle, axes @ v, axes @ b.omega, z, axes @ turning)
        return axes.T @ found[0], hub, axes.T @ found[1], found[2]

    add_law(model, tyre, (tyre.a, tyre.b), law, what)


def add_brake(model: Assembly, brake: Brake, what: str) -> None:
    """A spring and a damper along a hinge or slide that slip at a torque or force, which may change."""
    x, most = hinge_coordinate(brake.hinge, what), follow(brake.torque)
    if np.linalg.norm(x.axis - x.axis_b) > 1e-12:  # rounding of unit vectors
        raise NotExpressible(f"{what}: the axes on both sides differ as built; its law is written about one axis")
    k, c = brake.stiffness, brake.damping

    def law(t: float, a: Moving, b: Moving, z: Array) -> tuple[Array, Array, Array, Array]:
        axis, point, limit = a.axis(x.axis), b.r, max(most(t), 0.0)
        if x.kind == "slide":
            point = b.point(x.point_b)
            rate = axis @ (b.velocity(point) - a.velocity(point))
        else:
            rate = axis @ (b.omega - a.omega)
        f = np.clip(k * z[0] + c * rate, -limit, limit)
        load, none = -f * axis, np.zeros(3)
        return *((load, point, none) if x.kind == "slide" else (none, point, load)), np.array([(f - k * z[0]) / c])

    add_law(model, brake, (x.a, x.b), law, what)
