"""Certificate of a result: the checks, the size of the errors, and the reasons if it fails.

Every check is made from the stored samples with the true equations, whatever the teaching switches dropped:
constraint residuals, energy against work, momentum against impulse, Newton-Euler residuals, acceleration rows.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from ..base.checks import short_repr
from ..base.errors import NameMissingError
from ..base.style import Result
from ..base.wording import error_text
from ..constraints.singularity import INFINITESIMAL, describe_singularity
from ..equations.plausibility import loose_bodies
from ..mechanism.joints import Joint
from ..mechanism.limits import Limit
from .checks.balances import BALANCES, balance_checks, work_note
from .checks.between_stages import TOUCHES, overlap_checks, signal_checks, stage_notes, touch_checks
from .checks.check import DRIFT_LIMIT_MAX, PASSED, Check, drift_limit, scales_of
from .checks.equations import equation_checks, joint_checks, lost, residuals
from .checks.friction import OF_GAIN, friction_notes, held_checks, limit_checks, rope_checks
from .checks.rounding import rounding, rounding_checks, singular_notes
from .checks.turns import turning_checks
from .record import HasOptions, RankEvent, Record, RunOptions
from .result import RunResult

FAR_TURN = 1.0  # rad in a step: beyond, its error is not a small share of the turn
COARSE_ORDER = 2  # of methods whose steps follow no estimate that sees a turn


@dataclass(frozen=True, repr=False)
class Certificate(HasOptions, Result):
    """How a result was computed and how far it can be trusted.

    ``passed`` is True if every check is within its limit and the run reached its end; ``failures`` lists what is not.
    The checks are of local consistency: whether every sample meets the equations and the balances. How far the motion
    is from the true one is the global error: ``error``, ``order`` and ``doubling`` (the time [s] in which
    errors double, if they grow exponentially) are None until `Solution.estimate` has compared with tighter runs.
    """

    options: RunOptions
    steps: int
    rejected: int
    evaluations: int
    svd_calls: int
    rank_events: tuple[RankEvent, ...]
    seconds: float
    checks: tuple[Check, ...]
    stopped_by: str | None = None
    error: float | None = None
    order: float | None = None
    doubling: float | None = None
    turned: str = ""
    begin: float = 0.0  # s
    notes: tuple[str, ...] = field(default=())

    @property
    def method(self) -> str:
        """Return the method of integration with its settings."""
        return str(self.options.method)

    @property
    def passed(self) -> bool:
        """Return whether no check fails and the run was not interrupted."""
        return not self.failures

    @property
    def failures(self) -> tuple[str, ...]:
        """Return one sentence per check that failed."""
        found = [f"{c.name} {c.error:.2e} exceeds {c.limit:.0e}: {c.meaning}" for c in self.checks if not c.passed]
        if self.error is not None and not self.error <= DRIFT_LIMIT_MAX:
            remedy = "tighten rtol or shorten the step" if self.doubling is None else "shorten the run"
            found.append(
                f"global error {self.error:.2e} exceeds {DRIFT_LIMIT_MAX:.0e}: "
                f"{self.growth or 'steps are coarse'}; {remedy}"
            )
        if self.stopped_by and self.stopped_by.startswith("interrupted"):
            found.append(self.stopped_by)
        return tuple(found)

    @property
    def growth(self) -> str:
        """Describe how errors grow in an unstable motion; empty if it is stable or its stability is unknown."""
        return "" if self.doubling is None else f"the motion is unstable, errors double every {self.doubling:.3g} s"

    def __getitem__(self, name: str) -> Check:
        """Return a check by its name."""
        for check in self.checks:
            if isinstance(name, str) and check.name == name:
                return check
        raise NameMissingError(f"no check {short_repr(name)}; there are {', '.join(repr(c.name) for c in self.checks)}")

    def __str__(self) -> str:
        dropped = [k for k in ("gyroscopic", "centripetal", "gamma") if not getattr(self.switches, k)]
        head = f"{'passed' if self.passed else 'FAILED'}: {self.method}, rtol {self.rtol:g}, {self.steps} steps "
        head += f"({self.rejected} rejected), {self.evaluations} evaluations, {self.seconds:.3g} s"
        lines = [head]
        if dropped or self.switches.stabilisation != "projection":
            text = ", ".join(f"without {k}" for k in dropped) or "all terms"
            lines.append(f"  teaching: {text}; stabilisation {self.switches.stabilisation}")
        lines.append(f"  local consistency: {'ok' if all(c.passed for c in self.checks) else 'FAILED'}")
        lines.append(f"  global error: {self.global_error}")
        lines += [
            f"  {'ok  ' if c.passed else 'FAIL'} {c.name:<22} {error_text(c.error, 3):>9}  (limit {c.limit:.0e})"
            for c in self.checks
        ]
        lines += [f"  {text}" for text in (*self.notes, *((self.stopped_by,) if self.stopped_by else ()))]
        return "\n".join(lines)

    @property
    def global_error(self) -> str:
        """Describe what is known about the deviation from the true motion."""
        if self.error is None:
            what = f"what is{self.since}" if self.since else "it"
            return f"unknown{self.turned}; solution.estimate() finds {what}"
        order = "" if self.order is None else f", observed order {self.order:.2f}"
        verdict = "ok" if self.error <= DRIFT_LIMIT_MAX else f"FAILED, limit {DRIFT_LIMIT_MAX:.0e}"
        growth = f"; {self.growth}" if self.growth else ""
        return f"{verdict}, {error_text(self.error, 3)} (model lengths, radians){self.since}{order}{growth}"

    @property
    def since(self) -> str:
        """State the time from which errors are known, for a run that does not start at 0 s."""
        return f" added from {self.begin:.6g} s on" if self.begin else ""


def certificate_of(solution: RunResult) -> Certificate:
    """Return the certificate of a result; it is made once."""
    if "certificate" not in solution.derived:
        error, order, doubling = solution.estimated
        solution.derived["certificate"] = replace(certify(solution), error=error, order=order, doubling=doubling)
    return solution.derived["certificate"]


def certify(solution: RunResult) -> Certificate:
    """Make all checks of a solution."""
    record, limit, remarks = solution.record, drift_limit(solution.record), notes(solution)
    if solution.pieces:
        checks = [*worst_of_pieces(solution), *touch_checks(solution), *balance_checks(solution, limit, False)]
        of_pieces = [text for piece in solution.pieces for text in certificate_of(piece).notes]
        remarks += [text for text in dict.fromkeys(of_pieces) if text not in remarks and OF_GAIN not in text]
    elif solution.t.size:
        missed, opened = residuals(solution), rounding(solution)
        joints = joint_checks(solution, missed) + turning_checks(solution) + signal_checks(solution)
        joints += touch_checks(solution) + overlap_checks(solution) + rope_checks(solution)
        joints += held_checks(solution) + limit_checks(solution)
        equations = equation_checks(solution, missed, opened.singular)
        met = all(check.passed for check in joints + equations)
        checks = [*joints, *balance_checks(solution, limit, met), *equations]
        checks += [] if lost(solution) else rounding_checks(solution, opened)
        remarks += [] if all(check.passed for check in checks) else start_notes(solution)
        remarks += singular_notes(solution, opened) + work_note(solution)
    else:
        checks = [Check("samples", np.inf, 0.0, "there are none to look at; keep some, or run it to a later time")]
    return Certificate(
        options=record.options,
        steps=record.steps,
        rejected=record.rejected,
        evaluations=record.evaluations,
        svd_calls=record.svd_calls,
        rank_events=tuple(record.rank_events),
        seconds=record.seconds,
        checks=tuple(checks),
        stopped_by=record.stopped_by,
        turned=far_turn(record),
        begin=solution.start.t,
        notes=tuple(remarks),
    )


def worst_of_pieces(solution: RunResult) -> list[Check]:
    """Return each check of the piece between events that is closest to failing it.

    Balances and changes by contacts add up over the run, so they are judged over the whole run.
    """
    worst: dict[str, Check] = {}
    for piece, later in zip(solution.pieces, [*solution.pieces[1:], None], strict=True):
        piece.derived["scales"] = scales_of(solution)
        piece.derived["switch at the end"] = () if later is None else switched_between(piece, later)
        for check in certificate_of(piece).checks if piece.t.size else ():
            known = worst.get(check.name)
            if check.name not in (*BALANCES, TOUCHES) and (
                known is None or check.error * known.limit > known.error * check.limit
            ):
                worst[check.name] = check
    return list(worst.values())


def switched_between(piece: RunResult, later: RunResult) -> tuple[str, ...]:
    """Return the names of the parts whose mode changed at an event."""
    modes = later.compiled.modes
    return tuple(name for name, mode in piece.compiled.modes.items() if modes.get(name) != mode)


def far_turn(record: Record) -> str:
    """Describe what the global error may be where steps without an error estimate of high order turned a body far."""
    coarse = record.method.dt is not None or 0 < record.method.order <= COARSE_ORDER
    if not coarse or record.farthest <= FAR_TURN:
        return ""
    return f" (body '{record.farthest_by}' turned by {record.farthest:.2g} rad in a step: poses may err as much)"


def start_notes(solution: RunResult) -> list[str]:
    """Explain why a run fails that starts in a pose of infinitesimal mobility."""
    what = describe_singularity(solution.compiled, solution.start)
    return [f"the mobility at the start is {what}"] if what.startswith(INFINITESIMAL) else []


def notes(solution: RunResult) -> list[str]:
    """Return notes on the system, choices at the start, singular positions, rank events and missing checks."""
    found = [*solution.system.notes, *solution.record.coupled, *(f"start: {text}" for text in solution.start.notes)]
    events = solution.record.rank_events
    found += [f"rank event at t = {t:.6g} s: {rank} rows kept ({why})" for t, rank, why, _ in events]
    if solution.record.nearest < PASSED:
        inexact = ("" if solution.record.kinematic else "accelerations and ") + "reactions there are not exact"
        found.append(f"the run passes a singular position; it goes on along the tangent of the motion; {inexact}")
    watched: tuple[Joint | Limit, ...] = (*solution.system.joints, *solution.system.limits)
    found += [text for part in watched for text in part.notes(solution)]
    found += stage_notes(solution) + friction_notes(solution)
    if solution.record.never_armed:
        never = "it just came true at the start, and has not been false since"
        found.append(f"stop_when: {solution.record.never_armed} was never armed: {never}")
    if not (solution.record.about_centre or solution.record.kinematic):
        found.append("angular momentum not checked: the file is of an older version; run the simulation again")
    found += loose_bodies(solution.system)
    return found + [f"Newton-Euler not checked: {name} was saved without its function" for name in lost(solution)]
