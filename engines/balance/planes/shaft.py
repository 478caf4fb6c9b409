"""Hypothesis H1 of the reduction to planes: one rigid shaft about a fixed axis at a prescribed constant speed.

The shaft is cut into slices, one per station.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from engines import planar
from engines.balance.planes.mirror import Rows, row_space
from mbsd3d import GROUND, Body, Joint, Signal, System
from mbsd3d.extend import Ground, kinds

EXACT_TOLERANCE = 1e-9  # [1] of the size of the model [m], its speed [rad/s], its inertia [kg m^2]; angles [rad]
PlanarJoint = planar.PointJoint | planar.Distance


class Failure(NamedTuple):
    """Hypothesis that does not hold, with its cause and size."""

    hypothesis: str
    """"H1" to "H4"."""
    part: str
    text: str
    amount: float
    unit: str

    def __str__(self) -> str:
        return f"{self.hypothesis}: '{self.part}' {self.text} ({self.amount:.6g} {self.unit})"


class Shaft(NamedTuple):
    """Shaft of an engine and the bodies at rest around it."""

    body: Any
    driver: Any
    rows: Rows  # With the axis as normal
    point: np.ndarray  # (2,) of the axis, components along e1, e2 [m]
    speed: float  # [rad/s] about the normal
    frame: tuple  # Bodies at rest, the ground among them
    parts: tuple  # The body itself and what is welded to it

    def moves(self, body: Any) -> bool:
        """Return whether a body is not part of the frame."""
        return not contains(self.frame, body)


def contains(bodies: Sequence[Any], body: Any) -> bool:
    """Return whether a body is among some bodies."""
    return any(body is other for other in bodies)


def turning_rows(joint: Joint) -> list[tuple[Body | Ground, Body | Ground, np.ndarray, Signal, int]]:
    """Return (a, b, axis, signal, order of the derivative that the signal prescribes) of the rows that drive an
    angle."""
    found = []
    for row in joint.primitives:
        if row.signal is not None and row.kind == kinds.RATIO and row.coordinates[0].kind == "angle":
            x = row.coordinates[0]
            found.append((x.a, x.b, x.axis, row.signal, 0))
        elif row.signal is not None and row.kind == kinds.TURN_RATE:
            found.append((*row.bodies, row.axes[0], row.signal, 1))
    return found


def find_shaft(system: System) -> tuple[Shaft | None, list[Failure]]:
    """Return the shaft, or None, and what contradicts H1."""
    drivers = [joint for joint in system.joints if any(row.signal is not None for row in joint.primitives)]
    turning = [(joint, *row) for joint in drivers for row in turning_rows(joint)]
    if not turning:
        return None, [Failure("H1", "system", "has no driver that turns a body about an axis", 0, "drivers")]
    rows = Rows(system, np.eye(3)[2])
    frame = tuple(welded(rows, GROUND))
    loose = [x for x in turning if not (contains(frame, x[1]) or contains(frame, x[2]))]
    joint, a, b, axis, signal, order = (loose or turning)[0]
    others = [system.name(other) for other in drivers if other is not joint]
    failures = [Failure("H1", other, "prescribes a second motion", len(drivers), "drivers") for other in others]
    if loose:
        speed, turn = np.linalg.norm(rows.velocity[rows.index[id(a)]], axis=1)
        text, (size, unit) = "is not at rest", (turn, "rad/s") if turn > EXACT_TOLERANCE else (speed, "m/s")
        if size <= EXACT_TOLERANCE:
            text, size, unit = "is not welded to the ground", 1, "body"
        text = f"carries the axis of '{b.name}' and {text}"
        return None, [Failure("H1", a.name, text, float(size), unit), *failures]
    body = b if contains(frame, a) else a
    rows = Rows(system, np.asarray(axis, float))
    if body is not b:
        axis = -np.asarray(axis)
        rows = Rows(system, axis)
    v, w = rows.velocity[rows.index[id(body)]]
    speed = float(w @ rows.axes[2])
    if abs(speed) < EXACT_TOLERANCE:
        return None, [*failures, Failure("H1", body.name, "does not turn", speed, "rad/s")]
    failures += unsteady(system, joint, signal, order, speed)
    point = rows.flat(body.position) + np.array([-1, 1]) * rows.flat(v)[::-1] / speed
    shaft = Shaft(body, joint, rows, point, speed, frame, tuple(welded(rows, body)))
    return shaft, failures + loose_axis(system, shaft)


def welded(rows: Rows, root: Any) -> list:
    """Return a body or the ground with all bodies fixed rigidly to it, nearest first (a piston at dead centre is not
    fixed).
    """
    found = [root]
    joints = [joint for joint in rows.system.joints if all(row.signal is None for row in joint.primitives)]
    for fixed in found:
        for body in rows.system.bodies:
            own = [x for x in joints if {id(end) for end in x.bodies()} == {id(fixed), id(body)}]
            if own and not contains(found, body) and len(row_space(rows.twists(own, body, 0.0, rows.poses[0]))) == 6:
                found.append(body)
    return found


def unsteady(system: System, joint: Joint, signal: Any, order: int, speed: float) -> list[Failure]:
    """Return a failure of H1 for a speed that changes [rad/s^2]."""
    change = bound(signal.terms(), 1 if order else 2, 2 * np.pi / abs(speed))
    if change <= EXACT_TOLERANCE * speed**2:
        return []
    return [Failure("H1", system.name(joint), "does not turn at a constant speed", float(change), "rad/s^2")]


def bound(terms: Sequence[Any], order: int, time: float) -> float:
    """Return an upper bound of |d^order f / dt^order| of a sum of terms: polynomials for |t| <= time, sines and splines
    always.

    From the terms themselves; samples can miss a sine whose period they repeat. Terms of one shape, as components of a
    force have them, are added up first; others that cancel are taken for more than they are.
    """
    total = 0.0
    alike: dict[tuple, np.ndarray] = {}
    for term in terms:
        first = int(term.data[0]) + 2 if term.kind == kinds.SPLINE else 0
        key, part = (term.data.size, *term.data[:first]), term.data[first:]
        if term.kind == kinds.SINE:
            key, part = (term.data[1],), term.data[0] * np.exp(1j * term.data[2])
        alike[term.kind, *key] = alike.get((term.kind, *key), 0.0) + part
    for (kind, *shape), part in alike.items():
        if kind == kinds.SINE:
            total += abs(part) * abs(shape[0]) ** order
            continue
        pieces, reach = part[None], np.array([time])
        if kind == kinds.SPLINE:
            pieces, reach = part.reshape(-1, 4)[:, ::-1], np.diff(shape[2:])
        powers = np.arange(max(pieces.shape[1] - order, 0))
        factors = [np.prod(k + 1 + np.arange(order)) for k in powers]  # d^order t^(k + order) = factor t^k
        total += np.max(np.sum(np.abs(pieces[:, order:]) * factors * reach[:, None] ** powers, axis=1), initial=0.0)
    return float(total)


def loose_axis(system: System, shaft: Shaft) -> list[Failure]:
    """Return degrees of freedom between shaft and frame other than the rotation, or a rotation about another axis."""
    bearings = [joint for joint in system.joints if joint is not shaft.driver and between(shaft, joint)]
    name, rows = shaft.body.name, shaft.rows
    if not bearings:
        return [Failure("H1", name, "has no bearing in the frame", 5, "freedoms")]
    for pose in rows.poses:
        held = row_space(rows.twists(bearings, shaft.body, 0.0, pose))
        if len(held) != 5:
            text = "is not held on a fixed axis by its bearings alone: freedoms besides the turn"
            return [Failure("H1", name, text, 5 - len(held), "freedoms")]
    arm = rows.flat(shaft.body.position) - shaft.point
    turn = np.array([-arm[1], arm[0], 0.0, 0.0, 0.0, rows.length])  # v and w length of a unit turn about the axis
    held = row_space(rows.twists(bearings, shaft.body, 0.0, rows.poses[0]))
    off = np.linalg.norm(held @ turn) / np.linalg.norm(turn)
    if off <= EXACT_TOLERANCE:
        return []
    return [Failure("H1", name, "turns about another axis than it is driven", np.degrees(off), "deg")]


def between(shaft: Shaft, joint: Joint) -> bool:
    """Return whether a joint connects the shaft with the frame and nothing else."""
    moving = [body for body in joint.bodies() if shaft.moves(body)]
    return len(moving) == 1 and moving[0] is shaft.body


def tensor(shaft: Shaft, body: Any) -> np.ndarray:
    """Return the inertia of a body about its centre of mass along e1, e2, n [kg m^2], shape (3, 3)."""
    R = shaft.rows.axes @ body.axes
    return R @ body.inertia @ R.T


def throw(shaft: Shaft, joints: list[PlanarJoint], bodies: dict) -> complex:
    """Sum the arms from the axis to the pins of a unit [m], x + i y; welds do not count."""
    crank = bodies[id(shaft.body)]
    pins = [joint for joint in joints if joint.a is crank and not isinstance(joint, planar.Fixed)]
    return complex(*sum((pin(joint, crank) - shaft.point for joint in pins), np.zeros(2)))


def pin(joint: PlanarJoint, body: planar.Body) -> np.ndarray:
    """Return the point where a hinge, massless rod or weld holds a body [m], shape (2,)."""
    if isinstance(joint, planar.Distance):
        return joint.at_a if joint.a is body else joint.at_b
    return joint.at


def cut(shaft: Shaft, z: np.ndarray, throws: np.ndarray) -> tuple[np.ndarray, list[planar.Body], list[Failure]]:
    """Return heights and bodies of the slices of the shaft, and the product of inertia that they leave out [kg m^2].

    With U = m r_G and P = int (z - z_G) r dm as complex numbers x + i y from the axis: slice i of mass mu_i carries
    u s_i + (U - u sum s) mu_i / m, u by least squares from ``u sum s_i = U``, ``u sum (z_i - z_G) s_i = P``. Masses
    keep m and m z_G: the last slice, half of the shaft, is left out if the stations are centred on z_G. A shaft that
    is not a stack of such throws may do better with u = 0: then so.
    """
    body, k = shaft.body, len(z)
    com, inertia = shaft.rows.height(body.centre), tensor(shaft, body)
    whole = body.mass * complex(*(shaft.rows.flat(body.centre) - shaft.point))
    product = -complex(*inertia[:2, 2])
    rest = abs(z.mean() - com) > EXACT_TOLERANCE * shaft.rows.length
    heights = np.append(z, 2 * com - z.mean())[: k + rest]
    shares = np.append(np.full(k, (0.5 if rest else 1.0) / k), 0.5)[: k + rest]
    levers = np.array([throws.sum(), (z - com) @ throws / shaft.rows.length])
    moments = np.array([whole, product / shaft.rows.length])
    seen = np.linalg.norm(levers) > EXACT_TOLERANCE * np.abs(throws).max()
    found = [np.vdot(levers, moments) / np.vdot(levers, levers), 0.0] if seen else [0.0]
    u = min(found, key=lambda u: abs(product - u * ((z - com) @ throws)))
    carried = u * np.append(throws, 0.0)[: k + rest] + (whole - u * throws.sum()) * shares
    slices = [
        planar.Body(
            body.name, share * body.mass, share * inertia[2, 2], position=shaft.point,
            com=np.array([moment.real, moment.imag]) / (share * body.mass),
        )
        for share, moment in zip(shares, carried, strict=True)
    ]  # fmt: skip
    left = abs(product - u * ((z - com) @ throws))
    if left <= EXACT_TOLERANCE * np.trace(inertia):
        return heights, slices, []
    text = "has a product of inertia with its axis that its throws do not explain"
    return heights, slices, [Failure("H4", body.name, text, left, "kg m^2")]
