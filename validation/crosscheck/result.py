"""Result of a comparison: per engine and quantity a verdict with its numbers; table, figure and data of all."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, NamedTuple

import numpy as np

from mbsd3d.errors import InputError

AGREES, EXPLAINED, DIFFERS, SKIPPED = "agrees", "explained", "differs", "not compared"
UNCERTAINTY_FACTOR = 3.0  # [1] of the errors of a limit, since the estimate is the last change, not a bound


class Attribution(NamedTuple):
    """Changed cause, and the relative difference before and after."""

    cause: str
    change: str
    before: float
    after: float

    def __str__(self) -> str:
        return f"{self.cause}: {self.change} takes the difference from {self.before:.1e} to {self.after:.1e}"


@dataclass(frozen=True)
class Finding:
    """Comparison of one quantity with one engine; differences are relative to the quantity's size in the run.

    ``status``: "agrees"; "explained" (differs, and a cause was changed to show why); "differs"; "not compared";
    ``difference, uncertainty``: greatest distance of the limits up to ``until``, and how far that may be wrong:
    engine's and our own error; ``tolerance``: relative difference that counts as agreement whatever the
    uncertainty; ``order, expected``: observed order of the engine's error in the step, and the one it should have;
    ``until``: end of the comparison [s]; later the engine's error, grown by the motion itself, exceeds the
    tolerance; ``part``: whose difference is greatest; ``reason``: why it was not compared, or what is noteworthy.
    """

    engine: str
    quantity: str
    status: str
    difference: float | None = None
    uncertainty: float | None = None
    tolerance: float | None = None
    order: float | None = None
    expected: float | None = None
    until: float | None = None
    part: str = ""
    reason: str = ""
    attributions: tuple[Attribution, ...] = ()

    @property
    def bound(self) -> float:
        """Return the relative difference up to which the quantity agrees."""
        return max(UNCERTAINTY_FACTOR * (self.uncertainty or 0.0), self.tolerance or 0.0)

    @property
    def verdict(self) -> str:
        """Return the "agrees", "explained: ...", "differs: ..." or "not compared: ..."."""
        if self.status == AGREES:
            return AGREES
        if self.status == SKIPPED:
            return f"{SKIPPED}: {self.reason}"
        causes = "; ".join(map(str, self.attributions))
        size = "" if self.difference is None else f"by {self.difference:.1e} of its size ({self.part})"
        return f"{self.status}: " + "; ".join(text for text in (size, self.reason, causes) if text)


class Curve(NamedTuple):
    """Difference to the motion of mbsd3d at the finest common horizon, run by run, for the convergence plot."""

    quantity: str
    steps: tuple[float, ...]
    differences: tuple[float, ...]


@dataclass(frozen=True)
class Compared:
    """Comparison with one engine: its settings, its findings, and its convergence."""

    engine: str
    findings: tuple[Finding, ...]
    settings: str = ""
    order: float | None = None
    steps: tuple[int, ...] = ()
    seconds: tuple[float, ...] = ()
    stopped: str = ""
    curves: tuple[Curve, ...] = ()


USUAL_TOLERANCE = 1.1e-6  # [1] tolerance that is not reported
HEADER = f"{'':12} {'quantity':20} {'difference':>10} {'+-':>8} {'order':>5} {'until [s]':>9}  verdict"


@dataclass(frozen=True)
class CrossCheck:
    """Result of `cross_check`.

    ``t_end``: [s]; ``tolerance``: relative; ``growth``: by how much neighbouring motions of this model
    part until t_end, relative to their start; ``own_error``: estimated error of our own poses and velocities at
    t_end, relative; ``interrupted``: Ctrl-C ended it; what was found until then is kept; ``start_only``: only mass
    matrix and accelerations were asked for.
    """

    t_end: float
    tolerance: float
    engines: tuple[Compared, ...]
    growth: float = float("nan")
    own_error: float = float("nan")
    interrupted: bool = False
    start_only: bool = False
    notes: tuple[str, ...] = field(default=())
    digest: str = ""  # of model and start; "" for a model that a file cannot hold

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Return the findings of all engines, engine by engine."""
        return tuple(finding for engine in self.engines for finding in engine.findings)

    @property
    def verdict(self) -> Mapping[tuple[str, str], str]:
        """Return (engine, quantity) -> "agrees", "explained: cause and number", "differs: ..." or "not compared:
        reason".
        """
        return {(x.engine, x.quantity): x.verdict for x in self.findings}

    @property
    def failures(self) -> tuple[str, ...]:
        """Return sentences on differences without a proven cause."""
        return tuple(f"{x.engine}, {x.quantity} {x.verdict}" for x in self.findings if x.status == DIFFERS)

    @property
    def compared(self) -> tuple[str, ...]:
        """Return the engines of which the motion or the start was compared at all."""
        return tuple(x.engine for x in self.engines if any(f.status != SKIPPED for f in x.findings))

    @property
    def followed(self) -> tuple[str, ...]:
        """Return the engines, without the definitions, whose motion was compared, or the start where only that was
        requested.
        """
        return tuple(
            x.engine
            for x in self.engines
            if x.engine != "definitions"
            and any(f.status != SKIPPED and (self.start_only or f.uncertainty is not None) for f in x.findings)
        )

    @property
    def defined(self) -> bool:
        """Return whether the definitions of the joints were compared independently of any engine."""
        return self.compared == ("definitions",)

    @property
    def passed(self) -> bool:
        """Return whether the motion was compared with another engine, or the definitions alone where none can, and
        nothing differs.
        """
        return not self.failures and not self.interrupted and (bool(self.followed) or self.defined)

    def of(self, engine: str) -> Compared:
        """Return the findings of an engine; raise ValueError for one that was not requested."""
        for found in self.engines:
            if found.engine.lower() == engine.lower():
                return found
        raise InputError(f"'{engine}' was not asked for; there are {', '.join(x.engine for x in self.engines)}")

    def __str__(self) -> str:
        return self.table()

    def table(self) -> str:
        """Return the result as text, one line per engine and quantity."""
        return table(self)

    def figure(self, dark: bool = False) -> Any:
        """Plot the convergence of every engine to the motion of mbsd3d, log-log, with the expected slopes, as a
        matplotlib Figure.
        """
        from validation.crosscheck.figure import convergence_figure  # matplotlib only where it is asked for

        return convergence_figure([(x.engine, x.order, x.curves) for x in self.engines if x.curves], dark)

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers (None where there is none), texts and lists for JSON."""
        engines: list[dict[str, Any]] = []
        plain = {
            "t_end": self.t_end, "tolerance": self.tolerance, "growth": self.growth, "own_error": self.own_error,
            "passed": self.passed, "interrupted": self.interrupted, "start_only": self.start_only,
            "failures": list(self.failures), "summary": summary(self), "digest": self.digest,
            "notes": list(self.notes), "engines": engines,
        }  # fmt: skip
        for engine in self.engines:
            entry = asdict(engine)
            entry["curves"] = [curve._asdict() for curve in engine.curves]
            for shown, finding in zip(entry["findings"], engine.findings, strict=True):
                shown["verdict"] = finding.verdict
                shown["attributions"] = [x._asdict() for x in finding.attributions]
            engines.append(entry)
        return finite(plain)


def finite(value: Any) -> Any:
    """Return plain Python types, None for numbers that are not finite: JSON cannot hold them."""
    if isinstance(value, dict):
        return {key: finite(x) for key, x in value.items()}
    if isinstance(value, list | tuple):
        return [finite(x) for x in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value


def table(check: CrossCheck) -> str:
    """Return one line per engine and quantity; differences are relative to the quantity's size in the run."""
    lines = [HEADER]
    for engine in check.engines:
        lines += [row(finding) for finding in engine.findings]
        if engine.steps:
            runs = f"{engine.steps[0]} ... {engine.steps[-1]} steps, {sum(engine.seconds):.2g} s"
            lines.append(f"{'':12} {engine.settings}; {runs}; {engine.stopped}")
    lines.append(
        f"neighbouring motions part by {check.growth:.3g} until {check.t_end:g} s; own error {check.own_error:.0e}"
    )
    return "\n".join([*lines, *check.notes, summary(check)])


def summary(check: CrossCheck) -> str:
    """Return the last line of the table."""
    if check.interrupted:
        return "interrupted: what is listed above was compared"
    if check.failures:
        return f"{len(check.failures)} of {len(check.findings)} comparisons differ without a proven cause"
    partly = [name for name in check.compared if name not in (*check.followed, "definitions")]
    rest = f"; of {', '.join(partly)} only the start was compared" if partly else ""
    if check.defined:
        what = ", ".join(x.quantity for x in check.of("definitions").findings if x.status != SKIPPED)
        return f"agrees with the definitions of the joints ({what}); compared with no other engine: {missing(check)}"
    agreeing = [name for name in check.compared if name not in partly]
    if not check.passed:
        return f"no motion was compared{rest}" if partly else "nothing was compared with another engine"
    return f"agrees with {', '.join(how_far(check, x) for x in check.engines if x.engine in agreeing)}{rest}"


def missing(check: CrossCheck) -> str:
    """Return the engines that were not compared, each with its first reason."""
    others = [engine for engine in check.engines if engine.engine != "definitions"]
    reasons = [f"{x.engine} ({next((f.reason for f in x.findings if f.reason), 'no reason given')})" for x in others]
    return ", ".join(reasons) or "none was asked for"


def how_far(check: CrossCheck, engine: Compared) -> str:
    """Return the engine, with its shortfall from the whole time and from the requested tolerance."""
    motion = [x for x in engine.findings if x.uncertainty is not None and x.status != SKIPPED]
    until = min((x.until for x in motion if x.until is not None), default=check.t_end)
    bound = max((x.bound for x in motion), default=0.0)
    less = [f"until {until:.4g} s of {check.t_end:g} s"] if until < check.t_end * (1 - 1e-9) else []
    less += [f"within {bound:.0e}"] if bound > 1.5 * check.tolerance else []
    return f"{engine.engine} ({', '.join(less)})" if less else engine.engine


def row(finding: Finding) -> str:
    """Return one line of the table."""
    numbers = [
        number(finding.difference, "10.1e"), number(finding.uncertainty, "8.0e"), number(finding.order, "5.2f"),
        number(finding.until, "9.4g"),
    ]  # fmt: skip
    return f"{finding.engine:12} {finding.quantity:20} {' '.join(numbers)}  {verdict(finding)}"


def verdict(finding: Finding) -> str:
    """Return the verdict; of agreement also up to which difference where that is looser than usual, and what limits
    it."""
    if finding.status != AGREES:
        return finding.verdict
    loose = f" within {finding.bound:.0e}" if finding.bound > USUAL_TOLERANCE else ""
    return finding.verdict + loose + (f", {finding.reason}" if finding.reason else "")


def number(value: float | None, form: str) -> str:
    """Format a number, or return as many blanks with a dash."""
    return f"{value:{form}}" if value is not None else f"{'-':>{form.split('.')[0]}}"
