"""The result of a run: its samples, and the certificate that says how far they can be trusted."""

from dataclasses import dataclass, replace
from functools import cached_property

from .certificate import Certificate, certify
from .result import RunSamples


@dataclass(frozen=True, eq=False, repr=False)
class RunResult(RunSamples):
    """Samples of a run with their certificate."""

    estimated: tuple[float | None, float | None, float | None] = (None, None, None)  # of the global error, `estimate`:
    # itself, its order, and the time in which it doubles [s]

    @cached_property
    def certificate(self) -> Certificate:
        """What can be said for this result; see `Certificate`."""
        error, order, doubling = self.estimated
        return replace(certify(self), error=error, order=order, doubling=doubling)
