"""Energy against work, momentum against impulse."""

import numpy as np

from ...integrators.method import Method
from ..run_samples import RunSamples
from .check import USEFUL, Check, largest, scales_of

NOTHING = 1e-6  # of the energy: a work that is rounding, of poses near dead centres too


def balance_checks(solution: RunSamples, limit: float) -> list[Check]:
    """Energy against work, momentum against impulse."""
    model, energy, momentum = solution.compiled.model, solution.energy(), solution.momentum()
    if solution.record.kinematic:
        return []  # no ODE, so nothing was integrated along; the Newton-Euler residuals are the check
    scale, impulse = scales_of(solution), solution.arrays["z"][:, model.z_impulse :]
    gap = change(energy.total) - change(energy.work)
    lost = change(momentum.linear) - change(impulse[:, :3])
    turned = change(momentum.angular) - change(impulse[:, 3:])
    return [
        Check("energy balance", largest(gap) / scale.energy, limit, energy_meaning(solution.record.method)),
        Check("momentum balance", largest(lost) / scale.momentum, limit, "an inertial term is missing"),
        Check("angular momentum", largest(turned) / scale.angular_momentum, limit, "an inertial term is missing"),
    ]


def work_note(solution: RunSamples) -> list[str]:
    """What the energy balance says of the work of a driven run, where that is not known to a hundredth."""
    energy = solution.energy()
    gap, work = largest(change(energy.total) - change(energy.work)), largest(change(energy.work))
    if not solution.record.kinematic or gap <= max(USEFUL * work, NOTHING * scales_of(solution).energy):
        return []
    return [f"work is known to {gap:.1e} J of {work:.1e} J: by the trapezoidal rule over the poses; shorten max_step"]


def energy_meaning(method: Method) -> str:
    """The likely cause of an energy defect."""
    if method.rho < 1.0:
        return f"energy vanishes, by numerical damping of rho = {method.rho:g} if by nothing else: shorten the step"
    return "energy appears or vanishes"


def change(values: np.ndarray) -> np.ndarray:
    """Difference from the first sample."""
    return values - values[:1]
