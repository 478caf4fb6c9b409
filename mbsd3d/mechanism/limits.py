"""Monitored joint limits: no force enforces them; the certificate reports where a run exceeds them."""

from typing import Any

import numpy as np

from ..base.checks import as_tuple, check_choice, check_name, short_repr
from ..base.errors import InputError
from ..base.fields import Checked, NumberOrNone, kept, part_class
from .joints import Joint, coordinate_of
from .motion_protocols import LoadedMotion

LIMIT_EXCESS_MIN = 1e-9  # [rad, m] beyond a limit that is said: less is rounding of a start that lies on the limit
UNITS = {"angle": "rad", "slide": "m"}


@part_class()
class Limit(Checked):
    """A range of an angle [rad] or slide [m] of a joint, from its reference pose, monitored but not enforced.

    Parameters
    ----------
    joint : Joint
        A joint of the system that has such a coordinate.
    kind : str
        "angle" or "slide".
    lower, upper : float or None
        None = no limit on that side.
    name : str
        Name of the joint in the source of the limit; "" = its own name.

    Raises
    ------
    ValueError
        For a joint without the coordinate, or a lower limit above the upper one.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, System, TorsionSpring, simulate
    >>> arm = Body("arm", mass=2.0, inertia=(0.1, 0.5, 0.5), omega=(0, 0, 2.0))
    >>> hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")
    >>> system = System([arm], [hinge], limits=[Limit(hinge, "angle", -1.0, 1.0)])
    >>> simulate(system, 1.0, output=11).certificate.notes
    ("limit of 'hinge' passed by 1 rad at 1 s",)
    """

    joint: Joint
    kind: str = "angle"
    lower: NumberOrNone = kept(default=None)
    upper: NumberOrNone = kept(default=None)
    name: str = ""

    def what(self) -> str:
        return f"limit of '{self.called}'"

    @property
    def called(self) -> str:
        """Name of the limited joint."""
        if isinstance(self.name, str) and self.name:
            return self.name
        return str(getattr(self.joint, "name", None) or type(self.joint).__name__)

    def check(self, what: str) -> None:
        check_choice(self.kind, tuple(UNITS), f"{what}: kind")
        if not (isinstance(self.name, str) and self.name == ""):
            check_name(self.name, "limit:")
        coordinate_of(self.joint, self.kind, what)
        if self.lower is not None and self.upper is not None and self.lower > self.upper:
            raise InputError(f"{what}: lower {self.lower:g} exceeds upper {self.upper:g}; exchange them")

    def excess(self, values: np.ndarray) -> np.ndarray:
        """Return how far the values of the coordinate exceed the range [rad or m], 0 inside."""
        below = 0.0 if self.lower is None else self.lower - values
        above = 0.0 if self.upper is None else values - self.upper
        return np.maximum(np.maximum(below, above), np.zeros_like(values))

    def notes(self, motion: LoadedMotion) -> list[str]:
        """Return the note for the certificate: the largest excess over all samples and its time."""
        values = motion.angle(self.joint) if self.kind == "angle" else motion.slide(self.joint)
        excess = self.excess(values)
        if not excess.size or excess.max() <= LIMIT_EXCESS_MIN:
            return []
        worst, unit = int(excess.argmax()), UNITS[self.kind]
        return [f"{self.what()} passed by {excess[worst]:.3g} {unit} at {motion.t[worst]:.4g} s"]


def as_limits(value: Any, what: str, part: Any) -> tuple[Limit, ...]:
    """Convert to a tuple of limits."""
    found = as_tuple(value, what, "a list of Limit(joint, 'angle', lower, upper)")
    for limit in found:
        if not isinstance(limit, Limit):
            raise InputError(f"{what}: {short_repr(limit)} is not a limit; give Limit(joint, 'angle', lower, upper)")
    return found


def as_sentences(value: Any, what: str, part: Any) -> tuple[str, ...]:
    """Convert to texts of one line."""
    found = (value,) if isinstance(value, str) else as_tuple(value, what, "a list of sentences")
    if wrong := [text for text in found if not isinstance(text, str)]:
        raise InputError(f"{what}: {short_repr(wrong[0])} is not a string; give sentences")
    lines = tuple(" ".join(text.split()) for text in found)
    for line in lines:
        check_name(line, what)
    return lines
