"""The equations of motion at the samples: whether they are met, and how well they determine what was solved for."""

import numpy as np

from ...dynamics.batch import equation_residuals
from ...mechanism.forces.custom import SavedForce
from ..run_samples import RunSamples
from .check import MAY_MISS, PASSED, Check, Scales, gaping, largest, scales_of


def equation_checks(solution: RunSamples, singular: np.ndarray) -> list[Check]:
    """Newton-Euler residual per body, and rows against the accelerations, with the true terms.

    ``singular``: samples whose joints determine no reactions; Newton and Euler are not asked there.
    """
    compiled, arrays, t = solution.compiled, solution.arrays, solution.t
    data, n, scale = compiled.data(), len(solution.system.bodies), scales_of(solution)
    model = compiled.model._replace(gamma=1.0, stabilisation=0)
    known = arrays["state"], np.ascontiguousarray(arrays["coordinate"]), arrays["acceleration"], arrays["lam"]
    out, defect = np.zeros((t.size, n, 4)), np.zeros(t.size)
    equation_residuals(model, data, t, *known, out, defect)
    force, moment = max(largest(out[..., 2]), scale.force), max(largest(out[..., 3]), scale.moment)
    relative = np.where(singular[:, None], 0.0, np.maximum(out[..., 0] / force, out[..., 1] / moment))
    worst = int(np.argmax(relative.max(axis=0)))
    meaning = f"the equations of body '{solution.system.name(solution.system.bodies[worst])}' are not met"
    gap = gaping(solution.record)  # Baumgarte's terms correct accelerations by it; `saddle` takes joints as closed
    checks = [] if lost(solution) else [Check("Newton-Euler", largest(relative), max(1e-8, gap), meaning)]
    if model.row.size:
        near = MAY_MISS if solution.record.nearest < PASSED else 0.0
        limit = max(1e-8, solution.record.tolerance, gap, near, min(rounding_of_turning(solution, scale), 1e-5))
        error = largest(defect) * model.length / scale.acceleration
        checks.append(Check("acceleration rows", error, limit, "accelerations tear the joints apart"))
    return checks


def rounding_of_turning(solution: RunSamples, scale: Scales) -> float:
    """Rounding of the moments of the run as an acceleration of the body that turns most easily, relative.

    Joint forces F at an arm L cancel in the moment about the centre of mass of a small body to eps F L, which turns it
    by eps F L / I.
    """
    moments = [np.linalg.eigvalsh(body.inertia)[0] for body in solution.system.bodies if body.mass > 0.0]
    least = min((moment for moment in moments if moment > 0.0), default=np.inf)
    return 4.0 * np.finfo(float).eps * scale.moment / least * solution.compiled.model.length / scale.acceleration


def lost(solution: RunSamples) -> list[str]:
    """Names of the forces whose functions were not saved."""
    system = solution.system
    return [f"force '{system.name(force)}'" for force in system.forces if isinstance(force, SavedForce)]
