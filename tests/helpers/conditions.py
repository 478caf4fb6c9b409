"""The condition of a reference case, as ``validation/references/conditions.json`` stores it."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from mbsd3d import simulate
from validation.cases.comparison import _columns, _scale
from validation.cases.reference import Array, Case, _rotation, build


def measure_condition(case: Case, perturbation: float = 1e-7, *, rtol: float = 1e-12, seeds: int = 5) -> float:
    """How much a small change of the mechanism is amplified at the output times.

    Gravity, the speed of everything (initial velocities and motors alike), masses and moments of inertia are changed by
    the relative amount ``perturbation`` times seeded normal numbers, and principal axes turned by such an angle [rad];
    the start stays consistent. The result is the greatest change of a column (over its largest value where that exceeds
    1) divided by ``perturbation``, over all seeds.

    ``case``: with a reference over time; ``perturbation``: relative change, small enough for linearity and large
    against ``rtol`` times the result [-]; ``rtol``: tolerance of the runs [-]; ``seeds``: number of changes tried.
    Returns condition [-].
    """
    near = dict(zip(case.labels, case.reference.T, strict=True))

    def columns(run: Case) -> dict[str, Array]:
        return _columns(run, simulate(run.system, run.t_end, rtol=rtol, output=run.times), near)

    base, worst = columns(case), 0.0
    for seed in range(seeds):
        changed = columns(build(_perturbed(case.raw, perturbation, seed)))
        worst = max(worst, *(np.abs(changed[key] - base[key]).max() / _scale(base[key]) for key in base))
    return worst / perturbation


def _perturbed(raw: Mapping[str, Any], amount: float, seed: int) -> dict[str, Any]:
    """Copy of a case file with slightly other gravity, speed and bodies."""
    rng = np.random.default_rng(seed)
    gravity, speed = np.array(raw["gravity"]) * (1 + amount * rng.normal(size=3)), 1 + amount * rng.normal()
    joints = [{**spec, "omega": spec["omega"] * speed} if "omega" in spec else spec for spec in raw["joints"]]
    moving = [{**spec, **{key: speed * np.array(spec[key]) for key in ("v0", "w0")}} for spec in raw["bodies"]]
    bodies = [{**spec, **_perturbed_inertia(spec, amount, rng)} for spec in moving]
    return {**raw, "bodies": bodies, "joints": joints, "gravity": gravity}


def _perturbed_inertia(body: Mapping[str, Any], amount: float, rng: np.random.Generator) -> dict[str, Any]:
    """Slightly other mass and inertia; turned and scaled, so that the principal moments stay those of a body."""
    inertia = np.array(body["inertia"], dtype=float)
    inertia = np.diag(inertia) if inertia.ndim == 1 else inertia
    turn = _rotation([1.0, *(amount / 2 * rng.normal(size=3))])
    scale = 1 + amount * rng.normal()
    return {"mass": body["mass"] * (1 + amount * rng.normal()), "inertia": scale * turn @ inertia @ turn.T}
