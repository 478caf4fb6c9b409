"""What a comparison finds: per engine and quantity a verdict with its numbers."""

from dataclasses import dataclass
from typing import NamedTuple

AGREES, EXPLAINED, DIFFERS, SKIPPED = "agrees", "explained", "differs", "not compared"
SURE = 3.0
"""Errors of a limit by which another may be away from it: the estimate is the last change, not a bound."""


class Attribution(NamedTuple):
    """A cause that was changed, and what that did to the difference (relative, before and after)."""

    cause: str
    change: str
    before: float
    after: float

    def __str__(self) -> str:
        return f"{self.cause}: {self.change} takes the difference from {self.before:.1e} to {self.after:.1e}"


@dataclass(frozen=True)
class Finding:
    """One quantity against one engine; differences are relative to the quantity's size in the run.

    Attributes
    ----------
    status : str
        "agrees"; "explained" (differs, and a cause was changed to show why); "differs"; "not compared".
    difference, uncertainty : float or None
        Greatest distance of the limits up to ``until``, and how far that may be wrong: engine's and our own error.
    tolerance : float
        Relative difference that counts as agreement whatever the uncertainty.
    order, expected : float or None
        Observed order of the engine's error in the step, and the one it should have.
    until : float or None
        End of the comparison [s]; later the engine's error, grown by the motion itself, exceeds the tolerance.
    part : str
        Whose difference is greatest.
    reason : str
        Why it was not compared, or what is noteworthy.
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
        """Relative difference up to which it agrees."""
        return max(SURE * (self.uncertainty or 0.0), self.tolerance or 0.0)

    @property
    def verdict(self) -> str:
        """ "agrees", "explained: ...", "differs: ..." or "not compared: ..."."""
        if self.status == AGREES:
            return AGREES
        if self.status == SKIPPED:
            return f"{SKIPPED}: {self.reason}"
        causes = "; ".join(map(str, self.attributions))
        size = "" if self.difference is None else f"by {self.difference:.1e} of its size ({self.part})"
        return f"{self.status}: " + "; ".join(text for text in (size, self.reason, causes) if text)


class Curve(NamedTuple):
    """Difference to our motion at the finest common horizon, run by run: what the convergence plot shows."""

    quantity: str
    steps: tuple[float, ...]
    differences: tuple[float, ...]


@dataclass(frozen=True)
class Compared:
    """One engine: how it was run, what was found, and its convergence."""

    engine: str
    findings: tuple[Finding, ...]
    settings: str = ""
    order: float | None = None
    steps: tuple[int, ...] = ()
    seconds: tuple[float, ...] = ()
    stopped: str = ""
    curves: tuple[Curve, ...] = ()
