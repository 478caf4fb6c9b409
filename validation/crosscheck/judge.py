"""Assessments: mass matrices and accelerations at the start, limits of the motions, causes of differences.

A difference is explained only if changing its cause, in the same run, changes it as it should.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from mbsd3d import State, System, accelerations
from mbsd3d.extend import mass_matrix
from validation.crosscheck.mbsd3d_runs import BASIC_QUANTITIES, Ours, Quantity, largest, quantities
from validation.crosscheck.result import (
    AGREES,
    DIFFERS,
    EXPLAINED,
    SKIPPED,
    UNCERTAINTY_FACTOR,
    Attribution,
    Curve,
    Finding,
)
from validation.crosscheck.step_refinement import Ladder, Limit, best_limit
from validation.twins.base import Array, NotComparable, Twin

MASS_TOLERANCE = 1e-10
"""Relative difference of mass matrices: rounding of some hundred products and of the engine's own kinematics."""
START_QUANTITIES = ("acceleration", "angular acceleration")


def judge_start(system: System, state: State, twin: Twin, ours: Ours, tolerance: float) -> list[Finding]:
    """Return findings about the mass matrix and the accelerations at the start."""
    findings = [judge_mass(system, state, twin)]
    by_quantity = acceleration_differences(system, state, twin, ours)
    for name, (difference, part) in by_quantity.items():
        status = AGREES if difference <= tolerance else DIFFERS
        found: dict[str, Any] = dict(difference=difference, tolerance=tolerance, until=state.t, part=part)
        findings.append(Finding(twin.engine, name, status, **found))
    return findings


def judge_mass(system: System, state: State, twin: Twin) -> Finding:
    """Compare T'M T of the reference-point mass matrix of mbsd3d with the engine's, T from its velocities to those of
    mbsd3d.
    """
    kinetic = twin.kinetic()
    if kinetic is None or not kinetic.matrix.size:
        why = "does not give it here" if kinetic is None else "has no degree of freedom here"
        return Finding(twin.engine, "mass matrix", SKIPPED, reason=f"{twin.engine} {why}")
    T, theirs = kinetic.map, kinetic.matrix
    ours = T.T @ mass_matrix(system, state) @ T
    difference = largest(ours - theirs) / largest(theirs)
    status = AGREES if difference <= MASS_TOLERANCE else DIFFERS
    return Finding(
        twin.engine,
        "mass matrix",
        status,
        difference=difference,
        tolerance=MASS_TOLERANCE,
        until=state.t,
        part="the whole",
    )


def acceleration_differences(system: System, state: State, twin: Twin, ours: Ours) -> dict[str, tuple[float, str]]:
    """Return quantity -> (greatest relative difference, its body): divided by the greatest acceleration, or by
    gravity."""
    a = np.asarray(accelerations(system, state).arrays["acceleration"][0])
    return relative_to(a, twin.accelerations(), system, ours)


def relative_to(a: Array, theirs: Array, system: System, ours: Ours) -> dict[str, tuple[float, str]]:
    """Return the acceleration differences for given (bodies, 6) accelerations."""
    size = ours.size
    pull = max(largest(a[:, :3]), float(np.linalg.norm(system.gravity)), size.speed * size.spin)
    scales = (pull, max(largest(a[:, 3:]), pull / size.length))
    found = {}
    for name, part, scale in zip(START_QUANTITIES, (slice(0, 3), slice(3, 6)), scales, strict=True):
        by_body = np.abs(a[:, part] - theirs[:, part]).max(axis=1) / scale
        found[name] = (float(by_body.max()), system.bodies[int(by_body.argmax())].name)
    return found


COMPARED_SHARE_MIN = 1 / 8
"""Of the run that should be comparable; if it is not at the tolerance, the tolerance is taken ten times larger."""
LOOSEST_TOLERANCE = 1e-3  # [1] tolerance beyond which agreement would say nothing
ORDER_TOLERANCE = 0.5  # [1] difference of the observed order from the expected one; a lower order has to be explained
HALVED_STEP_RATIO = 0.75  # [1] a difference that halving the step takes below this part is one of the step
ERROR_GROWTH_MAX = 100.0
"""Tolerances that momenta, energies and reactions may be uncertain by: they are made of poses and accelerations; never
more than `LOOSEST_TOLERANCE`."""


class Runs:
    """Relative values of a step refinement by quantity; reactions without the start, where multipliers are not valid
    yet.
    """

    def __init__(self, system: System, ladder: Ladder, ours: Ours) -> None:
        self.ladder, self.ours = ladder, ours
        joints = tuple(name for name in ours.motion.reactions if name in ladder.runs[-1].reactions)
        self.own = dict(ours.found)
        if ours.motion.reactions:
            self.own |= chosen(ours.found, joints)
        found = [quantities(system, motion, ours.size, joints, ours.known) for motion in ladder.runs]
        self.values = {name: [run[name].values / run[name].scale for run in found] for name in found[0]}

    def limit(self, name: str, span: int | None) -> Limit:
        """Return the limit of a quantity, with its order observed up to sample ``span``."""
        return best_limit(self.values[name], self.ladder.twin.order, span, beginning(name))


def chosen(found: Mapping[str, Quantity], joints: tuple[str, ...]) -> dict[str, Quantity]:
    """Return the reactions of some joints, in their order; nothing where there are none."""
    if not joints:
        return {}
    take = [found["reaction force"].parts.index(name) for name in joints]
    return {
        name: Quantity(found[name].values[:, take], joints, found[name].scale)
        for name in ("reaction force", "reaction moment")
    }


def horizon(runs: Runs, tolerance: float, own: float) -> int:
    """Return the number of samples over which the engine's limit is known to the tolerance, also if errors grow.

    Our own motion has to be known to ``own``, however much the engine is allowed.
    """
    unsure = np.max([runs.limit(name, None).error + runs.ours.error[name] for name in BASIC_QUANTITIES], axis=0)
    grown = runs.ours.growth * unsure[1]
    known = (np.maximum(unsure, grown) <= tolerance) & (own_error(runs.ours) <= own)
    return int(known.size if known.all() else np.argmin(known))


def own_error(ours: Ours) -> Array:
    """Return the relative error of the poses and velocities of mbsd3d up to each sample, shape (n,)."""
    return np.max([ours.error[name] for name in BASIC_QUANTITIES], axis=0)


def least_samples(ours: Ours) -> int:
    """Return the least number of samples that should be comparable."""
    return max(2, int(COMPARED_SHARE_MIN * (ours.motion.t.size - 1)) + 1)


def reach(runs: Runs, tolerance: float) -> tuple[int, float]:
    """Return (samples to compare, tolerance used): ten times looser until an eighth of the run can be compared."""
    used, count = tolerance, 0
    least = least_samples(runs.ours)
    while used <= LOOSEST_TOLERANCE * (1 + 1e-9):
        count = horizon(runs, used, tolerance)
        if count >= least:
            return count, used
        used *= 10.0
    return count if count >= least else 0, LOOSEST_TOLERANCE


def judge_motion(runs: Runs, engine: str, tolerance: float) -> tuple[list[Finding], int]:
    """Return (a finding for every quantity of the motion, samples compared)."""
    span, used = reach(runs, tolerance)
    if span == 0:
        error, own = max(float(runs.limit(name, None).error[1]) for name in BASIC_QUANTITIES), own_error(runs.ours)
        text = f"after {runs.ladder.steps[-1]} steps the limit is known only to {error:.0e} at the first sample"
        last = least_samples(runs.ours) - 1
        if not own[last] <= tolerance:
            text = f"mbsd3d's own motion is known only to {own[last]:.0e} at t = {runs.ours.motion.t[last]:.4g} s"
        return [Finding(engine, name, SKIPPED, reason=text) for name in runs.values], 0
    return [judge(runs, engine, name, span, used) for name in runs.values], span


def limit_difference(runs: Runs, name: str, span: int) -> tuple[float, str, Limit]:
    """Return (greatest relative difference of the limits over the first ``span`` samples, its part, the engine's
    limit).
    """
    own, limit = runs.own[name], runs.limit(name, span)
    by_part = np.abs(limit.values - own.values / own.scale)[beginning(name) : span].max(axis=(0, 2))
    return float(by_part.max()), own.parts[int(by_part.argmax())], limit


def beginning(name: str) -> int:
    """Return the first sample to compare: multipliers of an engine are those of its steps, and none has led to the
    start.
    """
    return 1 if name.startswith("reaction") else 0


def judge(runs: Runs, engine: str, name: str, span: int, tolerance: float) -> Finding:
    """Return the finding about one quantity over the first ``span`` samples."""
    difference, part, limit = limit_difference(runs, name, span)
    order = runs.ladder.twin.order
    unsure = float((limit.error + runs.ours.error[name])[span - 1])
    found = dict(
        difference=difference, uncertainty=unsure, tolerance=tolerance, order=limit.order, expected=order,
        until=float(runs.ours.motion.t[span - 1]), part=part,
    )  # fmt: skip
    if not difference <= max(UNCERTAINTY_FACTOR * unsure, tolerance):
        return Finding(engine, name, DIFFERS, **found)
    if unsure > min(ERROR_GROWTH_MAX * tolerance, LOOSEST_TOLERANCE):
        return Finding(engine, name, SKIPPED, **found, reason=f"{engine}'s limit is known only to {unsure:.0e}")
    gaps, own = differences(runs, name, span), runs.own[name]
    first = float(np.abs(limit.values[0] - own.values[0] / own.scale).max())  # at the start
    if first > max(UNCERTAINTY_FACTOR * unsure, tolerance):
        found["attributions"] = (Attribution("first sample", "leaving the start out", first, difference),)
    converging = gaps[-1] <= HALVED_STEP_RATIO * gaps[-2]
    scattered = not converging and min(gaps) <= tolerance  # the runs themselves agree, down to their rounding
    if limit.order is None or limit.order >= order - ORDER_TOLERANCE or scattered:
        return Finding(engine, name, EXPLAINED if "attributions" in found else AGREES, **found)
    text = f"of order {limit.order:.1f} in the step where {order:g} is expected"
    if not converging:
        return Finding(engine, name, SKIPPED, **found, reason=f"{engine}'s runs scatter by {unsure:.0e}, {text}")
    halved = Attribution(f"error of {engine}'s step", "halving it", gaps[-2], gaps[-1])
    found["attributions"] = (*found.get("attributions", ()), halved)
    return Finding(engine, name, EXPLAINED, **found, reason=text)


def differences(runs: Runs, name: str, span: int) -> tuple[float, ...]:
    """Return the greatest relative difference of every run from the motion of mbsd3d over the compared time."""
    own = runs.own[name].values / runs.own[name].scale
    return tuple(float(np.abs(x - own)[beginning(name) : span].max()) for x in runs.values[name])


def curves(runs: Runs, span: int) -> tuple[Curve, ...]:
    """Return the curves for the plot of convergence."""
    end = float(runs.ours.motion.t[-1] - runs.ours.motion.t[0])
    steps = tuple(end / count for count in runs.ladder.steps)
    return tuple(Curve(name, steps, differences(runs, name, span)) for name in runs.values if span)


class Cause(NamedTuple):
    """Setting of an engine that may cause a difference, its changed value, and the part of the difference that then
    stays.
    """

    name: str
    setting: str
    value: Any
    stays: float


CAUSES: dict[str, tuple[Cause, ...]] = {
    "MuJoCo": (Cause("softness of the equalities (solref)", "softness", 8.0, 0.25),),  # half: error as its square
    "Exudyn": (Cause("tolerance of Newton's iterations", "tolerance", 1e-13, 0.0),),
}
"""By engine, in the order they are tried."""
CAUSE_TOLERANCE = 0.2
"""By how much of the whole the remaining part may miss ``stays``: a second cause of that size would not be seen.

So it is never more than `LOOSEST_TOLERANCE` of the quantity's size, however great the difference."""


def explained(
    findings: Sequence[Finding], make: Callable[..., Twin], system: System, state: State, ours: Ours,
    climb: Callable[[Twin], Runs] | None = None, span: int = 0,
) -> list[Finding]:  # fmt: skip
    """Return the findings with a measured cause for those that differ; without a cause they stay as they are."""
    suspects = {x.quantity: x for x in findings if x.status == DIFFERS}
    if not suspects:
        return list(findings)
    proofs: dict[str, list[Attribution]] = {name: [] for name in suspects}
    for cause in CAUSES.get(findings[0].engine, ()):
        for name, after in changed(cause, make, system, state, ours, climb, span).items():
            before = suspects[name].difference if name in suspects else None
            if before and abs(after - cause.stays * before) <= unseen(cause, suspects[name]):
                proofs[name].append(Attribution(cause.name, f"{cause.setting} = {cause.value:g}", before, after))
    return [
        replace(x, status=EXPLAINED, attributions=(*x.attributions, *proofs[x.quantity]))
        if x.status == DIFFERS and proofs[x.quantity]
        else x
        for x in findings
    ]


def unseen(cause: Cause, finding: Finding) -> float:
    """Return how far the difference may be from what the cause leaves; where that is nothing, the rest has to agree."""
    share = CAUSE_TOLERANCE * max(cause.stays, 0.05) * (finding.difference or 0.0)
    return min(share, LOOSEST_TOLERANCE if cause.stays else finding.bound)


def changed(
    cause: Cause, make: Callable[..., Twin], system: System, state: State, ours: Ours,
    climb: Callable[[Twin], Runs] | None, span: int,
) -> dict[str, float]:  # fmt: skip
    """Return quantity -> difference with the cause changed; for motions the difference of the limits, as everywhere."""
    try:
        twin = make(**{cause.setting: cause.value})
        found = {name: x[0] for name, x in acceleration_differences(system, state, twin, ours).items()}
        if climb is not None and span:
            runs = climb(twin)
            found |= {name: limit_difference(runs, name, span)[0] for name in runs.values}
    except NotComparable:
        return {}
    return found
