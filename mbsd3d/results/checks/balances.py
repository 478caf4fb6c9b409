"""Energy against work, momentum against impulse, since the start."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...constraints.rank import choose_rows, tree_over_rows
from ...dynamics.state_rates import FACTOR_FROM_OTHER_POSE, project_and_evaluate
from ...equations.at_state import load_state
from ...integrators.method import Method
from ...kernels.kinds import PROJECTION
from ..result import RunResult, world_velocities_of
from .check import DRIFT_LIMIT_MAX, Check, Scales, largest, longest, rounding_of, scales_of

QUADRATURE = 0.3  # of the momenta is what quadratures of fixed steps may leave open: of gears in steps of 1.6 rad,
DETERMINED = 1.0  # and of all balances where drivers determine the motion: of Cardan shafts in steps of up to 3 rad
BALANCES = ("energy balance", "momentum balance", "angular momentum")
DIFFERENCES = 3.0  # times the difference of two quadratures is what one may err
WORK_ROUNDING = 1e-6  # [1] of the energy: less work is rounding, also of poses near dead centres


def since_start(solution: RunResult) -> RunResult:
    """Return the motion at the samples, preceded by the start if that is not a sample."""
    compiled, start, model = solution.compiled, solution.start, solution.compiled.model
    if solution.t[0] <= start.t:
        return solution
    data = compiled.data()
    y = load_state(compiled, data, start)
    tree = tree_over_rows(model, data, solution.record.tolerance)
    project_and_evaluate(model, data, tree, start.t, y, np.zeros_like(y), FACTOR_FROM_OTHER_POSE)
    n, arrays = model.body.size, solution.arrays
    first = {
        "t": start.t, "q": y[: 7 * n].reshape(n, 7), "v": world_velocities_of(y[None], n)[0], "z": y[13 * n :],
        "potential": data.force["potential"], "acceleration": data.body["acceleration"][:n],
    }  # fmt: skip
    return replace(solution, arrays={name: np.concatenate([[x], arrays[name]]) for name, x in first.items()})


class Balance(NamedTuple):
    """Gain of the motion minus the work or impulse on it, and the numbers whose difference this is."""

    gap: float
    terms: float


def balances(whole: RunResult, scale: Scales) -> tuple[Balance, Balance, Balance]:
    """Return energy, momentum, and angular momentum about the centre of mass.

    With P the momentum, I the impulse of the external forces since the start: P less I; L' less the angular impulse
    about the centre of mass; T + U less W. Where no joint holds a body to the ground the energy is that of the motion
    about the centre of mass: T' + U less W, and less what external forces did to its motion, (P_0 + I/2) . I / m.
    """
    about, energy, model = whole.about_centre, whole.energy(), whole.compiled.model
    mass = whole.system.total_mass()
    impulse = change(whole.arrays["z"][:, model.z_impulse :])
    push, turn = impulse[:, :3], impulse[:, 3:]
    kinetic, carried = energy.kinetic, np.zeros(push.shape[0])
    held = any((part.compiled.model.row["body"] == model.body.size).any() for part in (whole, *whole.pieces))
    if mass and not held:
        kinetic, carried = about.kinetic, ((about.velocity[0] + 0.5 * push / mass) * push).sum(axis=1)
    gained = change(kinetic) + change(energy.potential) - change(energy.work) + carried + change(energy.lost)
    moved, turned = mass * change(about.velocity) - push, change(about.angular) - turn
    shaken = scale.rate * model.length + scale.acceleration * float(whole.t[-1] - whole.t[0])
    spread = scale.speed * scale.angular_momentum / scale.momentum + shaken * scale.reach  # by places and by velocities
    return (
        Balance(largest(gained), sum(map(largest, (kinetic, energy.potential, energy.work, carried)))),
        Balance(longest(moved), mass * scale.speed + longest(push)),
        Balance(longest(turned), mass * spread),
    )


def balance_checks(solution: RunResult, limit: float, equations_met: bool) -> list[Check]:
    """Compare energy with work and momentum with impulse, within the uncertainty of rounding and quadratures.

    Nothing bounds the error of work and impulse over fixed steps: two quadratures give their uncertainty. A motion that
    joints and drivers determine is right wherever the joints are closed, and its balances show only the error of their
    quadrature: where ``equations_met`` says that forces and accelerations agree at all samples, they are held to that.
    """
    if solution.record.kinematic:
        return []  # no ODE, so nothing was integrated along; the Newton-Euler residuals are the check
    whole, record, inertial = since_start(solution), solution.record, "an inertial term is missing"
    scale, rounding = scales_of(whole, scales_of(solution).least), rounding_of(record)
    kinds = (
        (scale.energy, DRIFT_LIMIT_MAX, energy_meaning(record.method)),
        (scale.momentum, QUADRATURE, inertial),
        (scale.angular_momentum, QUADRATURE, inertial),
    )
    checks = []
    for name, (size, most, meaning), found, open_ in zip(
        BALANCES, kinds, balances(whole, scale), record.open_audit, strict=True
    ):
        known = max(min(rounding * found.terms / size, DRIFT_LIMIT_MAX), min(DIFFERENCES * open_ / size, most))
        checks.append(Check(name, found.gap / size, max(limit, known), meaning))
    checks = checks if record.about_centre else checks[:2]
    if equations_met and not all(check.passed for check in checks) and determined(solution):
        return [check if check.passed else replace(check, limit=DETERMINED) for check in checks]
    return checks


def determined(solution: RunResult) -> bool:
    """Return whether joints and drivers leave no degree of freedom, and steps are projected onto them."""
    compiled, model, rows = solution.compiled, solution.compiled.model, solution.compiled.model.row
    if not compiled.drives or model.stabilisation != PROJECTION or rows["holonomic"].sum() < 6 * model.body.size:
        return False
    data = compiled.data()
    load_state(compiled, data, solution.start)
    return int(rows["holonomic"][choose_rows(model, data)].sum()) == 6 * model.body.size


def work_note(solution: RunResult) -> list[str]:
    """State what the energy balance shows about the work of a driven run if that is not known to 1 %."""
    if not solution.record.kinematic:
        return []
    energy = since_start(solution).energy()
    gap, work = largest(change(energy.total) - change(energy.work)), largest(change(energy.work))
    if gap <= max(DRIFT_LIMIT_MAX * work, WORK_ROUNDING * scales_of(solution).energy):
        return []
    return [f"work is known to {gap:.1e} J of {work:.1e} J: by the trapezoidal rule over the poses; shorten max_step"]


def energy_meaning(method: Method) -> str:
    """Return the likely cause of an energy defect."""
    if method.rho < 1.0:
        return f"energy vanishes, by numerical damping of rho = {method.rho:g} if by nothing else: shorten the step"
    return "energy appears or vanishes"


def change(values: np.ndarray) -> np.ndarray:
    """Return the difference of a quantity from its value at the first sample."""
    return values - values[:1]
