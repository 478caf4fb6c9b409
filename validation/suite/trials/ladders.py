"""N four-bars in a row: three redundant rows each, and poses in which N + 1 freedoms open; closed form for any N."""

from collections.abc import Iterable
from functools import partial

from validation.benchmark.counts import Count, counted_by_exudyn
from validation.cases.mechanisms import four_bars
from validation.suite.findings import FREEDOMS, THEORY, Finding
from validation.suite.trials import closed_forms
from validation.suite.trials.references import counts, theory_of
from validation.suite.trials.trial import Run, Trial, run

SIZES = (10, 40)
T_END, SAMPLES = 3.0, 7  # s: twice through a pose in which all rods lie on one line
RTOL = 1e-8  # Closer to rounding, which 605 rows make larger, the steps of N = 40 become tiny
LARGE = "Exudyn takes minutes for this size; see iftomm_A02_fourbar_N2 instead"


def trials(quick: bool) -> list[Trial]:
    """The smaller one, or both; 605 rows of rank 485 for N = 40."""
    judges = {FREEDOMS: freedoms, THEORY: partial(theory_of, closed_forms.four_bars)}
    return [
        Trial(f"four_bars_N{n}", "ladders", f"{n} four-bars in a row", partial(falling, n), judges, alone=LARGE)
        for n in (SIZES[:1] if quick else SIZES)
    ]


def falling(n: int) -> Run:
    """From upright over the side and up again."""
    return run(four_bars(n), T_END, output=SAMPLES, source=n, rtol=RTOL)


def freedoms(made: Run) -> Iterable[Finding]:
    """Planar counting: 15 N + 5 rows, of which each window repeats three; Exudyn counts the smaller one."""
    n = made.source
    known: dict[str, Count | str] = {"planar counting": Count(15 * n + 5, 12 * n + 5, 1, 3 * n)}
    if n == SIZES[0]:
        known["Exudyn"] = counted_by_exudyn(made.system)
    return counts(made, known)
