"""MuJoCo, Exudyn and the definitions of the joints as judges: what `cross_check` says, in the words of the suite."""

from typing import Any

from validation.crosscheck import CrossCheck, cross_check
from validation.crosscheck import Finding as PeerFinding
from validation.suite.findings import AGREES, DIFFERS, EXPLAINED, EXUDYN, MUJOCO, NOT_COMPARED, Finding, not_compared
from validation.suite.trials.trial import Run, Trial

PEERS = {MUJOCO: "mujoco", EXUDYN: "exudyn"}
"""Judge -> engine of `cross_check`."""
ANSWERS = {"agrees": AGREES, "explained": EXPLAINED, "differs": DIFFERS, "not compared": NOT_COMPARED}
"""Its words -> ours."""
SURE = 3.0
"""Uncertainties by which limits may be apart, as `crosscheck.judge` has it."""

MORE = 5.0
"""Times the budget for a second look at a difference."""


def compared(made: Run, trial: Trial, budget: float) -> tuple[list[Finding], CrossCheck | None]:
    """Everything that the engines and the definitions say of a mechanism.

    ``made``: mechanism and start; ``trial``: how long it is compared, and why not; ``budget``: seconds that an engine's
    runs may take. Returns findings; check: attributions and curves; None if nothing was compared.
    """
    if trial.alone:
        return [not_compared(judge, trial.alone) for judge in PEERS], None
    check = asked(made, budget)
    if check.failures:  # finer steps, and time to change what may be to blame
        check = asked(made, MORE * budget)
    if check.interrupted:
        raise KeyboardInterrupt
    return [translated(finding) for finding in check.findings], check


def asked(made: Run, budget: float) -> CrossCheck:
    """What `cross_check` finds; of a case without a motion at its start."""
    return cross_check(made.system, made.t_end or None, state=made.state, budget=budget, progress=False)


def translated(finding: PeerFinding) -> Finding:
    """A finding of `cross_check`: limits may be apart by the tolerance, or by what they are uncertain."""
    allowed = [x for x in (finding.tolerance, SURE * (finding.uncertainty or 0.0)) if x is not None]
    limit = max(allowed) if finding.difference is not None else None
    order = "" if finding.order is None else f"order {finding.order:.2f} of {finding.expected:g}"
    until = "" if finding.until is None else f"until {finding.until:.4g} s"
    causes = "; ".join(map(str, finding.attributions))
    note = "; ".join(text for text in (finding.reason, causes, order, until, finding.part) if text)
    return Finding(finding.engine, ANSWERS[finding.status], finding.quantity, finding.difference, limit, note)


def attributions(check: CrossCheck) -> tuple[dict[str, Any], ...]:
    """Every cause that was changed, with the difference before and after."""
    return tuple(
        {"engine": finding.engine, "quantity": finding.quantity, **attribution._asdict()}
        for finding in check.findings
        for attribution in finding.attributions
    )


def settings(check: CrossCheck) -> dict[str, str]:
    """Engine -> formulation, integrator, steps and seconds of its runs."""
    found = {}
    for engine in check.engines:
        steps = f"; {engine.steps[0]} ... {engine.steps[-1]} steps, {sum(engine.seconds):.2g} s" if engine.steps else ""
        found[engine.engine] = f"{engine.settings}{steps}{'; ' if engine.stopped else ''}{engine.stopped}"
    return {name: text for name, text in found.items() if text}
