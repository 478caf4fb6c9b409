"""Closed loops of hinges with one degree of freedom, despite the count of rows, against the product of exponentials."""

from collections.abc import Iterable
from functools import partial

import numpy as np

from validation.benchmark.counts import Count
from validation.cases.loops import FAMILIES, as_axes
from validation.suite.findings import FREEDOMS, THEORY, Finding
from validation.suite.trials.closed_forms import Pairs
from validation.suite.trials.references import counts, theory_of
from validation.suite.trials.trial import Judge, Run, Trial, run

SEED_COUNT = 3  # [1] of each family in the whole list
HINGE_RATE, T_END, SAMPLES = 2.0, 1.5, 31  # rad/s of the first hinge at the start, s


def trials(quick: bool) -> list[Trial]:
    """Return one of each family, or three: parameters, masses, inertias and base pose are random, the first hinge
    turns.
    """
    judges: dict[str, Judge] = {FREEDOMS: freedoms, THEORY: partial(theory_of, turned)}
    return [
        Trial(f"loop_{name}_{seed}", "closed loops", f"{name.replace('_', ' ')}, seed {seed}",
              partial(let_go, name, seed), judges, drawn=seed == 0)
        for name in FAMILIES for seed in range(1 if quick else SEED_COUNT)
    ]  # fmt: skip


def let_go(name: str, seed: int) -> Run:
    """Simulate the free motion of a random loop."""
    system = FAMILIES[name](np.random.default_rng(seed))
    return run(system, T_END, state=system.assemble(rates={"hinge 1": HINGE_RATE}), output=SAMPLES)


def turned(made: Run) -> Pairs:
    """Compare the angles of all hinges since the start."""
    ours = np.array([made.motion.angle(hinge) for hinge in made.system.joints]).T
    return {"angles": (ours - ours[0], as_axes(made.system).motion(HINGE_RATE, made.motion.t))}


def freedoms(made: Run) -> Iterable[Finding]:
    """Compare the count: n hinges have 5 n rows and leave n - 1 bodies one degree of freedom."""
    n = len(made.system.joints)
    rank = 6 * (n - 1) - 1
    return counts(made, {"geometry": Count(5 * n, rank, 1, 5 * n - rank)})
