"""Joints that stay closed, energy against work, momentum against impulse."""

import numpy as np

from ...integrators.method import Method
from ..run_samples import RunSamples
from .check import MAY_TEAR, Check, drift_limit, scales_of


def residual_checks(solution: RunSamples, singular: bool) -> list[Check]:
    """Constraint residuals at the samples; ``singular``: some are at poses where rows depend on each other."""
    model, drift = solution.compiled.model, solution.drift()
    reach = 1.0 + float(np.abs(solution.arrays["q"][..., :3]).max(initial=0.0)) / model.length
    speed = max(float(np.abs(solution.arrays["v"]).max(initial=0.0)), 1.0)
    floor = max(solution.record.tolerance, 1e-12 * reach)
    if solution.record.switches.stabilisation == "baumgarte":  # joints are held by the integration, not by projection
        floor = max(floor, drift_limit(solution.record))
    scale, tear = max(model.length, 1.0), max(floor, MAY_TEAR) if singular else floor
    return [
        Check("joint gaps", float(drift.position.max(initial=0.0)) / scale, floor, "joints drift apart"),
        Check(
            "joint velocities", float(drift.velocity.max(initial=0.0)) / (scale * speed), tear, "J v = b is violated"
        ),
    ]


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


def energy_meaning(method: Method) -> str:
    """The likely cause of an energy defect."""
    if method.rho < 1.0:
        return f"energy vanishes, by numerical damping of rho = {method.rho:g} if by nothing else: shorten the step"
    return "energy appears or vanishes"


def change(values: np.ndarray) -> np.ndarray:
    """Difference from the first sample."""
    return values - values[:1]


def largest(values: np.ndarray) -> float:
    """Largest absolute value, 0 for none."""
    return float(np.abs(values).max(initial=0.0))
