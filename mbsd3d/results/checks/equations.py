"""Equations of motion at the samples: their residuals, and how well they determine the unknowns."""

from typing import NamedTuple

import numpy as np

from ...dynamics.batch import equation_residuals
from ...mechanism.forces.custom import SavedForce
from ..result import RunResult
from .check import GAP_LIMIT_MIN, MAY_MISS, MAY_TEAR, PASSED, Check, Scales, gaping, largest, rounding_of, scales_of


class Residuals(NamedTuple):
    """Residuals of the equations at the samples."""

    bodies: np.ndarray  # (samples, n, 4) of forces [N] and moments [N m], and the sizes of both
    joints: np.ndarray  # (samples, 3) of c, J v - b and J v_dot - gamma, in lengths of the model and radians


def residuals(solution: RunResult) -> Residuals:
    """Return the residuals of all equations at the samples, with the true terms."""
    compiled, arrays, t = solution.compiled, solution.arrays, solution.t
    model = compiled.model._replace(gamma=1.0, stabilisation=0)
    known = arrays["state"], np.ascontiguousarray(arrays["coordinate"]), arrays["acceleration"], arrays["lam"]
    found = Residuals(np.zeros((t.size, model.body.size, 4)), np.zeros((t.size, 3)))
    equation_residuals(model, compiled.data(), t, *known, *found)
    return found


def joint_checks(solution: RunResult, found: Residuals) -> list[Check]:
    """Check that joints stay closed, in position and velocity."""
    record, length, scale = solution.record, solution.compiled.model.length, scales_of(solution)
    floor = max(record.tolerance, 1e-12 * scale.reach / length, gaping(record))
    slip = max(floor, rounding_of(record) * scale.speed / (scale.rate * length))
    gape = tear = 0.0
    if record.nearest < PASSED:  # rows let go there are not projected: they are met as far as the motion is exact
        gape, tear = GAP_LIMIT_MIN, max(MAY_TEAR, record.rtol)
    gaps, speeds, _ = found.joints.T
    return [
        Check("joint gaps", largest(gaps), max(floor, gape), "joints drift apart"),
        Check("joint velocities", largest(speeds) / scale.rate, max(slip, tear), "J v = b is violated"),
    ]


def equation_checks(solution: RunResult, found: Residuals, singular: np.ndarray) -> list[Check]:
    """Check the Newton-Euler residual per body, and rows against the accelerations.

    ``singular``: samples whose joints determine no reactions; the Newton-Euler residual is not checked there.
    """
    system, model, scale = solution.system, solution.compiled.model, scales_of(solution)
    lost_force, lost_moment, force, moment = np.moveaxis(found.bodies, -1, 0)
    force, moment = max(largest(force), scale.force), max(largest(moment), scale.moment)
    relative = np.where(singular[:, None], 0.0, np.maximum(lost_force / force, lost_moment / moment))
    worst = int(np.argmax(relative.max(axis=0)))
    meaning = f"the equations of body '{system.name(system.bodies[worst])}' are not met"
    gap = gaping(solution.record)  # Baumgarte's terms correct accelerations by it; `solver` takes joints as closed
    checks = [] if lost(solution) else [Check("Newton-Euler", largest(relative), max(1e-8, gap), meaning)]
    if model.row.size:
        near = MAY_MISS if solution.record.nearest < PASSED else 0.0
        limit = max(1e-8, solution.record.tolerance, gap, near, min(rounding_of_turning(solution, scale), 1e-5))
        error = largest(found.joints[:, 2]) * model.length / scale.acceleration
        checks.append(Check("acceleration rows", error, limit, "accelerations tear the joints apart"))
    return checks


def rounding_of_turning(solution: RunResult, scale: Scales) -> float:
    """Return the rounding of the moments of the run as an acceleration of the body that turns most easily, relative.

    Joint forces F at an arm L cancel in the moment about the centre of mass of a small body to eps F L, which turns it
    by eps F L / I.
    """
    moments = [np.linalg.eigvalsh(body.inertia)[0] for body in solution.system.bodies if body.mass > 0.0]
    least = min((moment for moment in moments if moment > 0.0), default=np.inf)
    return 4.0 * np.finfo(float).eps * scale.moment / least * solution.compiled.model.length / scale.acceleration


def lost(solution: RunResult) -> list[str]:
    """Return the names of the forces whose functions were not saved."""
    system = solution.system
    return [f"force '{system.name(force)}'" for force in system.forces if isinstance(force, SavedForce)]
