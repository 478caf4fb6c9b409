"""Test case of the suite: a mechanism, its run, and its judges."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from mbsd3d import Solution, State, System, simulate
from mbsd3d.errors import InputError
from validation.suite.findings import CERTIFICATE, DIFFERS, Finding, Record, judged

RTOL = 1e-10  # Of our runs: a hundredth of the tightest limit
ERROR_MAX = 100 * RTOL  # [1] accumulated error of some hundred steps where nothing is amplified
LONG_RUN_REASON = "other engines take too long for a short run; see {} instead"
"""Why a trial is not compared with engines in a short run."""


@dataclass(frozen=True, eq=False)
class Run:
    """Mechanism with its motion.

    ``t_end``: [s]; 0 where only the start counts; ``solution``: our motion; None without one; ``state``: start; None =
    as the bodies give it; ``source``: what the judges of a group need: a `validation.cases.Case`, an outcome of a demo;
    ``accuracy``: what our own motion may be wrong, relative to ``max(1, largest value)``: nobody is judged more finely.
    """

    system: System
    t_end: float = 0.0
    solution: Solution | None = None
    state: State | None = None
    source: Any = None
    accuracy: float = ERROR_MAX

    @property
    def motion(self) -> Solution:
        """Return our motion; raise InputError for a mechanism that does not move."""
        if self.solution is None:
            raise InputError("this case compares the start alone and has no motion; ask a case with a solution")
        return self.solution


def run(
    system: System,
    t_end: float,
    *,
    state: State | None = None,
    source: Any = None,
    accuracy: float = ERROR_MAX,
    **options: Any,
) -> Run:
    """Simulate a mechanism at `RTOL`; other options as for `simulate`."""
    solution = simulate(system, t_end, state=state, **{"rtol": RTOL, **options})
    return Run(system, t_end, solution, state, source, accuracy)


def recorded(solution: Solution, source: Any = None, state: State | None = None) -> Run:
    """Return the run of a motion that is known; raise InputError for one of a mechanism that is no `System`."""
    system = solution.system
    if not isinstance(system, System):
        raise InputError(f"the motion is one of a {type(system).__name__}; give the solution of a System")
    return Run(system, float(solution.t[-1]), solution, state, source)


Judge = Callable[[Run], Iterable[Finding]]


@dataclass(frozen=True, eq=False)
class Trial:
    """Test case of the suite.

    ``name, group, title``: name on the command line; heading in the table; a few words; ``make``: builds and runs the
    mechanism; ``judges``: judge of `findings.JUDGES` -> function that gives its findings for a `Run`; ``drawn``:
    whether the page shows a picture of it; ``alone``: why other engines are not asked; "" = they are.
    """

    name: str
    group: str
    title: str
    make: Callable[[], Run] = field(repr=False)
    judges: Mapping[str, Judge] = field(default_factory=dict, repr=False)
    drawn: bool = True
    alone: str = ""


def certificate(run: Run) -> list[Finding]:
    """Yield the checks of the run's own certificate, each over its limit; the largest error with its limit is kept."""
    if run.solution is None:
        return []
    found = run.solution.certificate
    if not found.checks:
        return [judged(CERTIFICATE, "run", 0.0, 1.0)]
    worst = max(found.checks, key=lambda check: check.error / check.limit)
    if found.passed:
        return [judged(CERTIFICATE, worst.name, worst.error, worst.limit)]
    return [Finding(CERTIFICATE, DIFFERS, worst.name, worst.error, worst.limit, "; ".join(found.failures))]


def examine(trial: Trial) -> tuple[Record, Run | None]:
    """Run a test case and its judges; an exception of a judge is a finding that differs."""
    try:
        made = trial.make()
    except ValueError as error:
        return Record(trial.name, trial.group, trial.title, (stopped(CERTIFICATE, "run", error),)), None
    judges = {CERTIFICATE: certificate, **trial.judges}
    findings = [finding for name, judge in judges.items() for finding in asked(name, judge, made)]
    return Record(trial.name, trial.group, trial.title, tuple(findings), facts_of(made)), made


def asked(name: str, judge: Judge, made: Run) -> list[Finding]:
    """Return the findings of a judge; its exception is a finding that differs."""
    try:
        return list(judge(made))
    except Exception as error:  # one judge that breaks must not take the other cases with it
        return [stopped(name, "run", error)]


def stopped(judge: str, quantity: str, error: Exception) -> Finding:
    """Return a finding for a comparison that could not be finished."""
    return Finding(judge, DIFFERS, quantity, note=f"stopped: {type(error).__name__}: {' '.join(str(error).split())}")


def facts_of(made: Run) -> dict[str, Any]:
    """Return the sizes of a mechanism and of its run."""
    system = made.system
    facts: dict[str, Any] = {"bodies": len(system.bodies), "joints": len(system.joints), "forces": len(system.forces)}
    facts["t_end"] = made.t_end
    return facts | ({"steps": made.solution.record.steps} if made.solution is not None else {})
