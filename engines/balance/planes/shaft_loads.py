"""Hypothesis H4 of the reduction to planes, on loads: they act in the planes and couple no units.

Forces on the frame alone do not load the moving parts and are left out.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from engines import planar
from engines.balance.planes.shaft import EXACT_TOLERANCE, Failure, Shaft, bound, contains
from engines.balance.planes.units import Unit
from mbsd3d import Force, SpringDamper, Torque
from mbsd3d.extend import ForceElement, evaluate, kinds

Loads = dict[int | None, list]


def heavy(shaft: Shaft) -> list[Failure]:
    """Return a failure of H4 if gravity has a component along the shaft [m/s^2]."""
    along = shaft.rows.height(shaft.rows.system.gravity)
    if abs(along) <= EXACT_TOLERANCE * max(1.0, float(np.linalg.norm(shaft.rows.system.gravity))):
        return []
    return [Failure("H4", "gravity", "has a component along the shaft", along, "m/s^2")]


def carried_loads(shaft: Shaft, units: list[Unit], bodies: dict) -> tuple[Loads, list[Failure]]:
    """Return planar loads by number of their unit (None: the shaft), and the loads that couple units or act across the
    planes.
    """
    loads: Loads = {}
    failures = []
    for force in shaft.rows.system.forces:
        if not any(shaft.moves(body) for body in force.bodies()):
            continue
        name, record = shaft.rows.system.name(force), force.record()
        own = [k for k, unit in enumerate(units) if any(contains(unit.bodies, body) for body in force.bodies())]
        if len(own) > 1:
            text = f"couples '{units[own[0]].name}' and '{units[own[1]].name}'"
            failures.append(Failure("H4", name, text, len(own), "units"))
            continue
        z = units[own[0]].z if own else nearest(shaft, units, record)
        off, unit = leaving(shaft, force, z)
        if off > EXACT_TOLERANCE:
            failures.append(Failure("H4", name, "acts across its plane", off, unit))
            continue
        found = flat_loads(shaft, force, bodies)
        if found is None:
            failures.append(Failure("H4", name, "is of a kind that the planes do not carry", 1, "load"))
            continue
        key = own[0] if own else next((k for k, other in enumerate(units) if other.z == z), None)
        loads.setdefault(key, []).extend(found)
    return loads, failures


def nearest(shaft: Shaft, units: list[Unit], record: Any) -> float:
    """Return the height of the plane nearest to the first point of a load on the shaft [m]."""
    heights = np.array([unit.z for unit in units] or [0.0])
    z = shaft.rows.height(record.points[-1]) if record.points else 0.0
    return float(heights[np.argmin(np.abs(heights - z))])


def leaving(shaft: Shaft, force: ForceElement, z: float) -> tuple[float, str]:
    """Return how far a load acts beside its plane [m] or out of it [N], with its unit."""
    rows, record = shaft.rows, force.record()
    off = max((abs(rows.height(point) - z) for point in record.points), default=0.0)
    if off > EXACT_TOLERANCE * rows.length:
        return off, "m"
    if isinstance(force, Force | Torque):
        axes = rows.axes @ record.bodies[-1].axes if record.option else rows.axes
        across = axes[2:] if isinstance(force, Force) else axes[:2]  # in which there must be none
        size = max(bound(signal.terms(), 0, 1.0) for signal in record.signals)
        parts = [[float(x) * signal for x, signal in zip(axis, record.signals, strict=True)] for axis in across]
        off = max(bound([term for signal in part for term in signal.terms()], 0, 1.0) for part in parts)
        return (off, "N" if isinstance(force, Force) else "N m") if off > EXACT_TOLERANCE * size else (0.0, "N")
    return 0.0, "N"


def flat_loads(shaft: Shaft, force: ForceElement, bodies: dict) -> list | None:
    """Return a load in its plane, or None if the plane cannot represent it."""
    rows, record = shaft.rows, force.record()
    ends = [bodies.get(id(body), planar.GROUND) for body in record.bodies]
    if isinstance(force, SpringDamper):
        start, end = (rows.flat(point) for point in record.points)
        return [
            planar.Spring(
                *ends, at_a=start, at_b=end, stiffness=force.stiffness, damping=force.damping, length=force.length
            )
        ]
    if not isinstance(force, Force | Torque):
        return None
    turned = record.bodies[-1].axes if record.option else np.eye(3)
    options: dict[str, Any] = {"frame": "body" if record.option else "world"}
    found = []
    for axis, signal in zip(turned.T, record.signals, strict=True):
        for term in signal.terms():
            motion = flat_motion(term)
            if motion is None:
                return None
            if isinstance(force, Force):
                at = rows.flat(record.points[-1])
                found.append(planar.Force(ends[-1], rows.flat(axis), at=at, motion=motion, **options))
            else:
                found.append(planar.Force(ends[-1], torque=rows.height(axis), motion=motion, **options))
    return found


def flat_motion(term: Any) -> planar.Motion | None:
    """Return a term of a signal as a planar motion, or None for polynomials of degree 6 and more."""
    if term.kind == kinds.SINE:
        return planar.Sine(*term.data)
    if term.kind == kinds.POLYNOMIAL and len(term.data) <= 6:
        return planar.Polynomial(tuple(term.data))
    if term.kind == kinds.SPLINE:
        breaks = term.data[1 : int(term.data[0]) + 2]
        return planar.Table(breaks, evaluate([term], breaks))  # not-a-knot at both ends, like the signal
    return None


def moved(part: Any, body: planar.Body, other: planar.Body) -> Any:
    """Return a planar joint or load with one body replaced by another at the same place."""
    ends = {key: other for key in ("a", "b", "body") if getattr(part, key, None) is body}
    if ends and isinstance(part, planar.Force):
        ends["at"] = body.position + part.at  # `at` is kept in body axes, which are those of the world here
    return replace(part, **ends) if ends else part
