"""Our motion, sample by sample, against the definitions of the joints: a formulation that shares no kernel with it.

Not another engine, but every joint type has a place in it: gaps and slips of the joints, accelerations and unique
reactions of `validation.reference_point` at the states of the run, solved from those definitions.
"""

from typing import Any

import numpy as np

from mbsd3d import State, simulate
from validation import reference_point
from validation.engines.base import Array, NotExpressible

from .ours import TIGHT
from .quantities import Sizes, largest
from .verdict import AGREES, DIFFERS, SKIPPED, Compared, Finding

ENGINE = "definitions"
SAMPLES = 9
"""States that are looked at: each costs some milliseconds and a body's motion has hardly more phases."""
LIMIT = 1e-9
"""Relative; where the condition of J M^-1 J' times rounding is more, that counts (see tests/test_random.py)."""
EPS = 1e-14


def compare_definitions(system: Any, state: State, t_end: float, size: Sizes) -> Compared:
    """Findings about gaps, slips, accelerations and reactions at nine states of the run."""
    try:
        reference_point.solve(system, state)
    except (ValueError, KeyError) as error:
        text = f"no definition is written for {error}" if isinstance(error, KeyError) else str(error)
        raise NotExpressible(text) from error
    solution = simulate(system, t_end, state=state, rtol=TIGHT, output=SAMPLES)
    found: dict[str, list[tuple[float, str, float]]] = {}
    for k in range(solution.t.size):
        for name, difference, part, limit in at_state(solution, k, size):
            found.setdefault(name, []).append((difference / limit, part, difference, limit))
    findings = tuple(finding(name, max(entries), t_end) for name, entries in found.items())
    return Compared(ENGINE, findings, settings=f"accelerations from the joints' definitions at {SAMPLES} states")


def finding(name: str, worst: tuple, t_end: float) -> Finding:
    """The worst of all states."""
    excess, part, difference, limit = worst
    status = AGREES if excess <= 1.0 else DIFFERS
    return Finding(ENGINE, name, status, difference=difference, tolerance=limit, until=t_end, part=part)


def at_state(solution: Any, k: int, size: Sizes) -> list[tuple[str, float, str, float]]:
    """(quantity, greatest relative difference, whose, limit) at sample k."""
    system = solution.system
    there = reference_point.solve(system, solution.state(k))
    limit = max(LIMIT, EPS * there.condition)
    a, b = solution.arrays["acceleration"][k], there.acceleration
    pull = max(largest(b[:, :3]), float(np.linalg.norm(system.gravity)), size.speed * size.spin)
    bodies = [body.name for body in system.bodies]
    entries = [
        ("joint gaps", there.residual / max(size.length, 1.0), "joints", LIMIT),
        ("joint velocities", there.rate / max(size.speed, 1.0), "joints", LIMIT),
        ("acceleration", *worst(a[:, :3] - b[:, :3], pull, bodies), limit),
        ("angular acceleration", *worst(a[:, 3:] - b[:, 3:], pull / size.length, bodies), limit),
    ]
    return entries + reactions(solution, k, there, size, limit)


def worst(difference: Array, scale: float, parts: list[str]) -> tuple[float, str]:
    """(greatest relative difference, whose)."""
    by_part = np.abs(difference).max(axis=1, initial=0.0) / scale
    return float(by_part.max()), parts[int(by_part.argmax())]


def reactions(solution: Any, k: int, there: Any, size: Sizes, limit: float) -> list[tuple[str, float, str, float]]:
    """Wrenches about O of body b of the joints whose reaction is unique."""
    force, moment, names = [], [], []
    for joint in solution.system.joints:
        reaction = solution.reaction(joint)
        if id(joint) not in there.wrench or not reaction.unique:
            continue
        arm = reaction.point[k] - solution.position(joint.b)[k]
        about_O = reaction.moment[k] + np.cross(arm, reaction.force[k])
        force.append(reaction.force[k] - there.wrench[id(joint)][:3])
        moment.append(about_O - there.wrench[id(joint)][3:])
        names.append(solution.system.name(joint))
    if not names:
        return []
    return [
        ("reaction force", *worst(np.array(force), size.force, names), limit),
        ("reaction moment", *worst(np.array(moment), size.moment, names), limit),
    ]


def skipped(engine: str, reason: str) -> Compared:
    """An engine that could not take part, and why."""
    return Compared(engine, (Finding(engine, "everything", SKIPPED, reason=reason),))
