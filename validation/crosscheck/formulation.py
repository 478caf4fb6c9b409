"""Check of a motion of mbsd3d, sample by sample, against the definitions of the joints: a formulation without common
kernels.

Not another engine, but every joint type has a place in it: gaps and slips of the joints, accelerations and unique
reactions of `validation.twins.definitions.equations` at the states of the run, solved from those definitions.
"""

import time

import numpy as np

from mbsd3d import Solution, State, System, accelerations
from validation.crosscheck.judge import LOOSEST_TOLERANCE
from validation.crosscheck.mbsd3d_runs import TIGHT_RTOL, Sizes, largest, whole_run
from validation.crosscheck.result import AGREES, DIFFERS, SKIPPED, Compared, Finding
from validation.twins.base import Array, NotExpressible
from validation.twins.definitions.equations import Reference, solve

ENGINE = "definitions"
SAMPLE_ORDER = (0, 8, 4, 2, 6, 1, 3, 5, 7)
"""States in the order they are looked at: each costs milliseconds, seconds for 100 bodies, so that the time may be up
before the last; a motion has hardly more phases than nine."""
STATES_MIN = 2  # [1] states that are examined at any cost: the start and the end
DIFFERENCE_MAX = 1e-9
"""Relative; where the condition of the inertia of what can move, times rounding, is more, that counts."""
ROUNDING = 1e-14


def compare_definitions(system: System, state: State, t_end: float | None, size: Sizes, budget: float) -> Compared:
    """Return findings about gaps, slips, accelerations and reactions at nine states of the run; None: at the start
    only.

    Fewer where they take longer than ``budget`` seconds; the findings say so.
    """
    began = time.thread_time()
    try:
        solve(system, state)
    except np.linalg.LinAlgError as error:  # a ValueError too
        raise NotExpressible(f"something moves without inertia there ({error})") from error
    except ValueError as error:
        raise NotExpressible(str(error)) from error
    left = budget - (time.thread_time() - began)  # the run is our own and has no budget
    if t_end is None:
        solution = accelerations(system, state)
    else:
        solution = whole_run(system, t_end, state, TIGHT_RTOL, len(SAMPLE_ORDER))
    found, looks = look(system, solution, size, left)
    fewer = f"at {looks} of {solution.t.size} states: {budget:g} s are up" if looks < solution.t.size else ""
    findings = tuple(finding(name, entries, float(solution.t[-1]), fewer) for name, entries in found.items())
    states = "the start" if t_end is None else f"{looks} states"
    return Compared(ENGINE, findings, settings=f"accelerations from the joints' definitions at {states}")


def look(
    system: System, solution: Solution, size: Sizes, seconds: float
) -> tuple[dict[str, list[tuple[float, str, float, float]]], int]:
    """Return (quantity -> excess, part, difference and limit at the examined states, their number)."""
    began, looks = time.thread_time(), 0
    found: dict[str, list[tuple[float, str, float, float]]] = {}
    for k in [k for k in SAMPLE_ORDER if k < solution.t.size]:
        if looks >= STATES_MIN and (time.thread_time() - began) * (looks + 1) / looks > seconds:
            break
        for name, difference, part, limit in at_state(system, solution, k, size):
            found.setdefault(name, []).append((difference / limit, part, difference, limit))
        looks += 1
    return found, looks


def finding(name: str, entries: list[tuple[float, str, float, float]], t_end: float, fewer: str = "") -> Finding:
    """Return the worst finding of all states; NaN is worse than any, and a limit above `LOOSEST_TOLERANCE` is none."""
    excess, part, difference, limit = max(entries, key=lambda entry: np.nan_to_num(entry[0], nan=np.inf))
    status = AGREES if excess <= 1.0 else DIFFERS
    if status == AGREES and max(entry[3] for entry in entries) > LOOSEST_TOLERANCE:
        reason = f"inertias of what can move are so unlike that rounding alone may make {limit:.0e}"
        return Finding(ENGINE, name, SKIPPED, difference=difference, tolerance=limit, until=t_end, reason=reason)
    return Finding(ENGINE, name, status, difference=difference, tolerance=limit, until=t_end, part=part, reason=fewer)


def at_state(system: System, solution: Solution, k: int, size: Sizes) -> list[tuple[str, float, str, float]]:
    """Return (quantity, greatest relative difference, its part, limit) at sample k."""
    there = solve(system, solution.state(k))
    limit = max(DIFFERENCE_MAX, ROUNDING * there.condition)
    a, b = solution.arrays["acceleration"][k], there.acceleration
    pull = max(largest(b[:, :3]), float(np.linalg.norm(system.gravity)), size.speed * size.spin)
    bodies = [body.name for body in system.bodies]
    entries = [
        ("joint gaps", *greatest(there.gaps, there, system), DIFFERENCE_MAX),
        ("joint velocities", *greatest(there.rates / size.spin, there, system), DIFFERENCE_MAX),
        ("acceleration", *worst(a[:, :3] - b[:, :3], pull, bodies), limit),
        ("angular acceleration", *worst(a[:, 3:] - b[:, 3:], pull / size.length, bodies), limit),
    ]
    return entries + reactions(solution, k, there, size, limit)


def greatest(values: Array, there: Reference, system: System) -> tuple[float, str]:
    """Return (greatest value of all rows, its joint)."""
    by_joint = [
        (largest(values[span]), system.name(joint)) for joint, span in zip(system.joints, there.spans, strict=True)
    ]
    return max(by_joint, key=lambda entry: np.nan_to_num(entry[0], nan=np.inf), default=(0.0, "no joint"))


def worst(difference: Array, scale: float, parts: list[str]) -> tuple[float, str]:
    """Return (greatest relative difference, its part)."""
    by_part = np.abs(difference).max(axis=1, initial=0.0) / scale
    return float(by_part.max()), parts[int(by_part.argmax())]


def reactions(
    solution: Solution, k: int, there: Reference, size: Sizes, limit: float
) -> list[tuple[str, float, str, float]]:
    """Return the determined components of wrenches at the joints' points, of joints with at least partly determined
    reactions.
    """
    force, moment, names = [], [], []
    for joint in solution.system.joints:
        reaction = solution.reaction(joint)
        D = reaction.force_projector[k], reaction.moment_projector[k]
        if id(joint) not in there.wrench or not np.trace(D[0] + D[1]) > 0.5:
            continue
        expected, about_O = np.split(there.wrench[id(joint)], 2)
        arm = reaction.point[k] - solution.body_point(joint.b, joint.b.position)[k]
        force.append(D[0] @ (reaction.force[k] - expected))
        moment.append(D[1] @ (reaction.moment[k] - about_O + np.cross(arm, expected)))
        names.append(solution.system.name(joint))
    if not names:
        return []
    return [
        ("reaction force", *worst(np.array(force), size.force, names), limit),
        ("reaction moment", *worst(np.array(moment), size.moment, names), limit),
    ]


def skipped(engine: str, reason: str) -> Compared:
    """Return a finding for an engine that could not take part, with the reason."""
    return Compared(engine, (Finding(engine, "everything", SKIPPED, reason=reason),))
