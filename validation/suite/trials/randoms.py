"""Random mechanisms as cases: nobody knows their motion, so only other formulations and engines judge them."""

from functools import partial

from mbsd3d import IntegrationError, System
from validation.cases.examples import mechanism, moving
from validation.crosscheck.ours import TIGHT
from validation.suite.trials.trial import Run, Trial, run

FEW, MANY = 20, 200
T_END = 0.25  # s; with speeds of some m/s all terms with velocities take part
SAMPLES = 9
SHORTEST = 0.01  # s


def trials(quick: bool) -> list[Trial]:
    """Seeded, so that a name is always the same mechanism."""
    return [trial_of(seed) for seed in range(FEW if quick else MANY)]


def trial_of(seed: int) -> Trial:
    """The random mechanism of a seed."""
    title = f"random mechanism of seed {seed}"
    return Trial(f"random_{seed:03d}", "random mechanisms", title, partial(started, seed), drawn=False)


def started(seed: int) -> Run:
    """A motion from general velocities."""
    system = mechanism(seed)
    return run_to(system, moving(system, seed), T_END)


def run_to(system: System, state: object, t_end: float) -> Run:
    """A run, half as long where a driver pulls the mechanism to a dead centre before.

    As tight as in `cross_check`, which must reach the end too.
    """
    try:
        return run(system, t_end, state=state, output=SAMPLES, rtol=TIGHT)
    except IntegrationError:
        if t_end < SHORTEST:
            raise
        return run_to(system, state, 0.5 * t_end)
