"""Energy against work, momentum against impulse, since the start."""

from dataclasses import replace

import numpy as np

from ...constraints.rank import tree_over_rows
from ...dynamics.state_rates import FAR, project_and_evaluate
from ...equations.at_state import load_state
from ...integrators.method import Method
from ..run_samples import RunSamples, world_velocities
from .check import USEFUL, Check, largest, scales_of

NOTHING = 1e-6  # of the energy: a work that is rounding, of poses near dead centres too


def since_start(solution: RunSamples) -> RunSamples:
    """The motion at the samples, and at the start before them if it is not one of them."""
    compiled, start, model = solution.compiled, solution.start, solution.compiled.model
    if solution.t[0] <= start.t:
        return solution
    data = compiled.data()
    y = load_state(compiled, data, start)
    tree = tree_over_rows(model, data, solution.record.tolerance)
    project_and_evaluate(model, data, tree, start.t, y, np.zeros_like(y), FAR)
    n, arrays = model.body.size, solution.arrays
    first = {
        "t": start.t, "q": y[: 7 * n].reshape(n, 7), "v": world_velocities(y[None], n)[0], "z": y[13 * n :],
        "potential": data.force["potential"], "acceleration": data.body["acceleration"][:n],
    }  # fmt: skip
    return replace(solution, arrays={name: np.concatenate([[x], arrays[name]]) for name, x in first.items()})


def balance_checks(solution: RunSamples, limit: float) -> list[Check]:
    """Energy against work, momentum against impulse."""
    if solution.record.kinematic:
        return []  # no ODE, so nothing was integrated along; the Newton-Euler residuals are the check
    whole, model = since_start(solution), solution.compiled.model
    scale = scales_of(whole)
    energy, momentum, impulse = whole.energy(), whole.momentum(), whole.arrays["z"][:, model.z_impulse :]
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
    if not solution.record.kinematic:
        return []
    energy = since_start(solution).energy()
    gap, work = largest(change(energy.total) - change(energy.work)), largest(change(energy.work))
    if gap <= max(USEFUL * work, NOTHING * scales_of(solution).energy):
        return []
    return [f"work is known to {gap:.1e} J of {work:.1e} J: by the trapezoidal rule over the poses; shorten max_step"]


def energy_meaning(method: Method) -> str:
    """The likely cause of an energy defect."""
    if method.rho < 1.0:
        return f"energy vanishes, by numerical damping of rho = {method.rho:g} if by nothing else: shorten the step"
    return "energy appears or vanishes"


def change(values: np.ndarray) -> np.ndarray:
    """Difference from the start."""
    return values - values[:1]
