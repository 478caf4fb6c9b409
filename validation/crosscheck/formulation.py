"""Our motion, sample by sample, against the definitions of the joints: a formulation that shares no kernel with it.

Not another engine, but every joint type has a place in it: gaps and slips of the joints, accelerations and unique
reactions of `validation.twins.definitions.equations` at the states of the run, solved from those definitions.
"""

import time
from typing import Any

import numpy as np

from mbsd3d import Joint, Solution, State, System, accelerations
from validation.crosscheck.ours import TIGHT, Sizes, largest, whole_run
from validation.crosscheck.result import AGREES, DIFFERS, SKIPPED, Compared, Finding
from validation.twins.base import Array, NotExpressible
from validation.twins.definitions import equations as reference_point
from validation.twins.definitions import rows as definitions

ENGINE = "definitions"
ORDER = (0, 8, 4, 2, 6, 1, 3, 5, 7)
"""States in the order they are looked at: each costs milliseconds, seconds for 100 bodies, so that the time may be up
before the last; a motion has hardly more phases than nine."""
FEWEST = 2  # States that are looked at whatever they cost: the start and the end
LIMIT = 1e-9
"""Relative; where the condition of J M^-1 J' times rounding is more, that counts (tests/validation/test_random.py)."""
EPS = 1e-14


def compare_definitions(system: System, state: State, t_end: float | None, size: Sizes, budget: float) -> Compared:
    """Findings about gaps, slips, accelerations and reactions at nine states of the run; None: at the start only.

    Fewer where they take longer than ``budget`` seconds; the findings say so.
    """
    began = time.thread_time()
    try:
        reference_point.solve(system, state)
    except np.linalg.LinAlgError as error:  # a ValueError too
        raise NotExpressible(f"it needs bodies with mass and inertia and rows that move them ({error})") from error
    except ValueError as error:
        raise NotExpressible(str(error)) from error
    left = budget - (time.thread_time() - began)  # the run is our own and has no budget
    if t_end is None:
        solution = accelerations(system, state)
    else:
        solution = whole_run(system, t_end, state, TIGHT, len(ORDER))
    found, looks = look(solution, size, left)
    fewer = f"at {looks} of {solution.t.size} states: {budget:g} s are up" if looks < solution.t.size else ""
    findings = tuple(finding(name, entries, float(solution.t[-1]), fewer) for name, entries in found.items())
    states = f"{looks} states" if t_end else "the start"
    return Compared(ENGINE, findings, settings=f"accelerations from the joints' definitions at {states}")


def look(
    solution: Solution, size: Sizes, seconds: float
) -> tuple[dict[str, list[tuple[float, str, float, float]]], int]:
    """(quantity -> excess, part, difference and limit at the states looked at, how many they are)."""
    began, looks = time.thread_time(), 0
    found: dict[str, list[tuple[float, str, float, float]]] = {}
    for k in [k for k in ORDER if k < solution.t.size]:
        if looks >= FEWEST and (time.thread_time() - began) * (looks + 1) / looks > seconds:
            break
        for name, difference, part, limit in at_state(solution, k, size):
            found.setdefault(name, []).append((difference / limit, part, difference, limit))
        looks += 1
    return found, looks


def finding(name: str, entries: list[tuple[float, str, float, float]], t_end: float, fewer: str = "") -> Finding:
    """The worst of all states; what is not a number is worse than any."""
    excess, part, difference, limit = max(entries, key=lambda entry: np.nan_to_num(entry[0], nan=np.inf))
    status = AGREES if excess <= 1.0 else DIFFERS
    return Finding(ENGINE, name, status, difference=difference, tolerance=limit, until=t_end, part=part, reason=fewer)


def at_state(solution: Solution, k: int, size: Sizes) -> list[tuple[str, float, str, float]]:
    """(quantity, greatest relative difference, whose, limit) at sample k."""
    system = solution.system
    there = reference_point.solve(system, solution.state(k))
    limit = max(LIMIT, EPS * there.condition)
    a, b = solution.arrays["acceleration"][k], there.acceleration
    pull = max(largest(b[:, :3]), float(np.linalg.norm(system.gravity)), size.speed * size.spin)
    bodies = [body.name for body in system.bodies]
    entries = [
        ("joint gaps", *gaps(solution, k, max(size.length, 1.0)), LIMIT),
        ("joint velocities", there.rate / max(size.speed, 1.0), "joints", LIMIT),
        ("acceleration", *worst(a[:, :3] - b[:, :3], pull, bodies), limit),
        ("angular acceleration", *worst(a[:, 3:] - b[:, 3:], pull / size.length, bodies), limit),
    ]
    return entries + reactions(solution, k, there, size, limit)


def gaps(solution: Solution, k: int, scale: float) -> tuple[float, str]:
    """(greatest |c| of the definitions of geometry over a length, whose) at sample k."""
    system, state = solution.system, solution.state(k)
    now = definitions.Motion(system, state, state.v.reshape(1, -1, 6))
    found = [(0.0, "no joint")]
    for joint in system.joints:
        if type(joint) in definitions.GEOMETRY:
            *parts, last = definitions.GEOMETRY[type(joint)](now, joint)
            c = [*(part.x0 for part in parts), last.x0 + whole_turns(now, solution, k, joint)]
            found.append((float(np.max([largest(part) for part in c])) / scale, system.name(joint)))
    return max(found, key=lambda entry: np.nan_to_num(entry[0], nan=np.inf))


def whole_turns(now: definitions.Motion, solution: Solution, k: int, joint: Joint) -> float:
    """What the turns that a hinge has made add to c, the last part of a definition.

    They are counted from the angle of the definition: after half a turn rounding says whether that is pi or -pi.
    """
    hinges = definitions.TURNS.get(type(joint), lambda joint: [])(joint)
    beyond = [(factor, solution.angle(x)[k] - now.turn(x, x.angle().axis).x0) for factor, x in hinges]
    return sum(factor * 2 * np.pi * round(float(np.squeeze(angle)) / (2 * np.pi)) for factor, angle in beyond)


def worst(difference: Array, scale: float, parts: list[str]) -> tuple[float, str]:
    """(greatest relative difference, whose)."""
    by_part = np.abs(difference).max(axis=1, initial=0.0) / scale
    return float(by_part.max()), parts[int(by_part.argmax())]


def reactions(solution: Solution, k: int, there: Any, size: Sizes, limit: float) -> list[tuple[str, float, str, float]]:
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
