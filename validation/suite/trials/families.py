"""Families of cases: demos with their theory, ladders of four-bars, random mechanisms.

A ladder of N four-bars has three redundant rows in each, and poses in which N + 1 freedoms open; its motion is known in
closed form. Nobody knows the motion of random mechanisms, so only other formulations and engines judge them.
"""

from collections.abc import Iterable
from functools import partial

from mbsd3d import IntegrationError, Solution, State, System
from mbsd3d.extend import Demo, discover
from validation.benchmark.counts import Count, counted_by_exudyn
from validation.cases.examples import mechanism, moving
from validation.cases.mechanisms import four_bars
from validation.crosscheck.mbsd3d_runs import LOOSE_RTOL, TIGHT_RTOL
from validation.suite.findings import FREEDOMS, THEORY, Finding, judged
from validation.suite.trials import closed_forms
from validation.suite.trials.references import counts, theory_of
from validation.suite.trials.trial import Judge, Run, Trial, recorded, run

QUICK_DEMOS = ("cardan", "door", "dzhanibekov", "heavy_top")
"""Demos compared with other engines in a short run too."""
SHORT_RUN_REASON = "in a short run a demo of the gallery is compared with its theory only"


def demonstrations(quick: bool) -> list[Trial]:
    """Return one test case per demo: its first run, and its theory."""
    return [
        Trial(f"gallery_{demo.name}", "gallery", demo.title, partial(shown, demo), {THEORY: rows},
              alone=SHORT_RUN_REASON if quick and demo.name not in QUICK_DEMOS else demo.alone)
        for demo in discover().values()
    ]  # fmt: skip


def shown(demo: Demo) -> Run:
    """Return the first run of a demo with all terms; its certificate is checked."""
    done = demo.run()
    solution = next(filter(complete, done.solutions.values()))
    return recorded(solution, done, solution.state(0))


def complete(solution: Solution) -> bool:
    """Return whether a run had all terms, and its joints held by projection."""
    switches = solution.certificate.switches
    return switches == type(switches)()


def rows(made: Run) -> Iterable[Finding]:
    """Yield the rows of the demo's table, in their units."""
    for row in made.source.rows:
        yield judged(THEORY, row.quantity, row.error, row.tolerance, f"absolute, [{row.unit or '-'}]")


LADDER_SIZES = (10, 40)
LADDER_END, LADDER_SAMPLES = 3.0, 7  # s: twice through a pose in which all rods lie on one line
LADDER_RTOL = 1e-10
LARGE_LADDER_REASON = "Exudyn takes minutes for this size; see iftomm_A02_fourbar_N2 instead"


def ladders(quick: bool) -> list[Trial]:
    """Return the smaller ladder, or both; 605 rows of rank 485 for N = 40."""
    judges: dict[str, Judge] = {FREEDOMS: freedoms, THEORY: partial(theory_of, closed_forms.four_bars)}
    return [
        Trial(
            f"four_bars_N{n}",
            "ladders",
            f"{n} four-bars in a row",
            partial(falling, n),
            judges,
            alone=LARGE_LADDER_REASON,
        )
        for n in (LADDER_SIZES[:1] if quick else LADDER_SIZES)
    ]


def falling(n: int) -> Run:
    """Simulate rods that fall from upright over the side and up again."""
    return run(four_bars(n), LADDER_END, output=LADDER_SAMPLES, source=n, rtol=LADDER_RTOL)


def freedoms(made: Run) -> Iterable[Finding]:
    """Compare the planar count: 15 N + 5 rows, three redundant ones per window; Exudyn counts the smaller one."""
    n = made.source
    known: dict[str, Count | str] = {"planar counting": Count(15 * n + 5, 12 * n + 5, 1, 3 * n)}
    if n == LADDER_SIZES[0]:
        known["Exudyn"] = counted_by_exudyn(made.system)
    return counts(made, known)


QUICK_RANDOM_COUNT, RANDOM_COUNT = 20, 200
T_END = 0.25  # s; with speeds of some m/s all terms with velocities take part
SAMPLES = 9
T_END_MIN = 0.01  # [s] of a run that ends before a dead centre


def randoms(quick: bool) -> list[Trial]:
    """Return random mechanisms, seeded so that a name is always the same mechanism."""
    return [random(seed) for seed in range(QUICK_RANDOM_COUNT if quick else RANDOM_COUNT)]


def random(seed: int) -> Trial:
    """Return the random mechanism of a seed."""
    title = f"random mechanism of seed {seed}"
    return Trial(f"random_{seed:03d}", "random mechanisms", title, partial(started, seed), drawn=False)


def started(seed: int) -> Run:
    """Simulate a motion from general velocities."""
    system = mechanism(seed)
    return run_to(system, moving(system, seed), T_END)


def run_to(system: System, state: State, t_end: float) -> Run:
    """Simulate a run, half as long where a driver pulls the mechanism to a dead centre before.

    As tight as the two of `cross_check`, which must reach the end too.
    """
    try:
        run(system, t_end, state=state, output=SAMPLES, rtol=LOOSE_RTOL)
        return run(system, t_end, state=state, output=SAMPLES, rtol=TIGHT_RTOL)
    except IntegrationError:
        if t_end < T_END_MIN:
            raise
        return run_to(system, state, 0.5 * t_end)
