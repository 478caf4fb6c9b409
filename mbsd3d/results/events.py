"""Events of a run: which parts switched when, with the impulses and the energy lost."""

from dataclasses import dataclass, field

from ..base.style import Told
from ..constraints.engagement import Impulse


@dataclass(frozen=True, eq=False, repr=False)
class Event(Told):
    """A change of what holds at a time t [s]; of an impact also energy [J] and impulses.

    ``lost`` [J] is the energy lost in the impact, ``work`` [J] the work of drivers in it, ``impulses`` are those of the
    parts on their bodies b, by name. ``rest`` [s] is the time at which bounces too low to be resolved would have ended,
    from the measured ratio of the times between them; the motion is at rest from t on. The samples of the run have the
    time twice, before and after it.
    """

    t: float
    part: str
    action: str
    lost: float = 0.0
    work: float = 0.0
    impulses: dict[str, Impulse] = field(default_factory=dict)
    rest: float | None = None

    @property
    def what(self) -> str:
        """Return what happened, in words."""
        return f"'{self.part}' {self.action}"

    def __repr__(self) -> str:
        lost = f", {self.lost:.6g} J lost" if self.impulses else ""
        return f"<{self.t:.9g} s: {self.what}{lost}>"
