"""Rounding errors of accelerations and reactions, found by one step of iterative refinement.

The residual of the equations, as they were solved, is rounding; with it as the right side, the saddle point gives its
effect. So the error of a multiplier is seen, and of the acceleration of a light body, where a small residual of forces
tells neither.
"""

from typing import NamedTuple

import numpy as np

from ...constraints.rank import tree_over_rows
from ...dynamics.batch import refinements
from ...equations.at_state import load_rows
from ..result import RunResult
from .check import Check, gaping, largest, longest, scales_of

KNOWN_MOTION = 1e-4  # of the largest acceleration: rounding of forces beside a light body moves it at random
KNOWN_FORCES = 1e-6  # of the largest force or moment of a row
SINGULAR = 1e-3  # pivot of rows that close loops, over its largest, as the square of a small angle from the pose
MOST_TIMES = 3  # that a note names


class Rounding(NamedTuple):
    """The largest relative changes at every sample, and where."""

    motion: np.ndarray  # (samples,) of an acceleration
    forces: np.ndarray  # (samples,) of a multiplier
    body: np.ndarray  # (samples,) whose acceleration changes most
    row: np.ndarray  # (samples,) whose multiplier does
    singular: np.ndarray  # (samples,) rows are nearly dependent: multipliers are kept below what they would be


def rounding(solution: RunResult) -> Rounding:
    """Return the changes by one step of refinement at the samples of a run."""
    compiled, arrays, t = solution.compiled, solution.arrays, solution.t
    model, data = compiled.model, compiled.data()
    known = arrays["state"], np.ascontiguousarray(arrays["coordinate"]), arrays["acceleration"], arrays["lam"]
    units, size, which = units_of(solution), np.zeros((t.size, 3)), np.zeros((t.size, 2), np.int64)
    first = 0
    while first < t.size:
        load_rows(compiled, data, known[0][first], t[first], known[1][first])
        tree = tree_over_rows(model, data, solution.record.tolerance)
        first = refinements(model, data, tree, t, *known, first, units, size, which)
    return Rounding(size[:, 0], size[:, 1], which[:, 0], which[:, 1], size[:, 2] < SINGULAR)


def units_of(solution: RunResult) -> np.ndarray:
    """Return the largest a_O and alpha of the run, and of each row the largest force or moment of all rows of its kind.

    Those are at least the weight of the whole; without gravity the pull of the spin stands for it, and the force that
    accelerates a body: not accelerations, which of light bodies may be rounding.
    """
    model, arrays = solution.compiled.model, solution.arrays
    a, least, metres = scales_of(solution).acceleration, scales_of(solution).least, model.row["metres"] == 1
    alpha = max(longest(arrays["acceleration"][..., 3:]), a / model.length)
    most = np.abs(arrays["lam"]).max(axis=0, initial=0.0)
    moved = max(b.mass * longest(solution.acceleration(b)) for b in solution.system.bodies)
    force = max(largest(most[metres]), solution.system.total_mass() * least, moved) or 1.0
    moment = max(largest(most[~metres]), force * model.length)
    return np.concatenate([[a, alpha], np.where(metres, force, moment)])


def rounding_checks(solution: RunResult, found: Rounding) -> list[Check]:
    """Check accelerations and reactions at regular poses; at singular ones they have no limit to meet."""
    system, joint_of = solution.system, solution.compiled.row_joint
    motion, forces = (np.where(found.singular, 0.0, x) for x in (found.motion, found.forces))
    body = system.name(system.bodies[found.body[np.argmax(motion)]])
    meaning = f"rounding of the forces on body '{body}' moves it; it is too light for them"
    gap = gaping(solution.record)  # `solver` takes joints as closed
    checks = [Check("accelerations", largest(motion), max(KNOWN_MOTION, gap), meaning)]
    if joint_of.size:
        joint = system.name(solution.compiled.holders[joint_of[found.row[np.argmax(forces)]]])
        meaning = f"rounding leaves the reactions of '{joint}' open; masses or lengths differ too much"
        checks.append(Check("reactions", largest(forces), max(KNOWN_FORCES, gap), meaning))
    return checks


def singular_notes(solution: RunResult, found: Rounding) -> list[str]:
    """Say which samples are at singular poses."""
    times = solution.t[found.singular]
    if not times.size:
        return []
    at = ", ".join(f"{t:.6g}" for t in times[:MOST_TIMES]) + (" ..." if times.size > MOST_TIMES else "")
    count = f"{times.size} of {solution.t.size} samples"
    return [f"singular at t = {at} s ({count}): the joints hardly determine their reactions there"]
