"""What parts have in common whose rows are switched at events of a run: their mode, and what they watch for."""

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

from .primitives import Primitive


class Mode(NamedTuple):
    """What a part that switches does at the time: its name, and the numbers that go with it."""

    name: str
    numbers: tuple[float, ...] = ()


OPEN = Mode("open")
Modes = Mapping[str, Mode]  # by the name of the part


class Watch(NamedTuple):
    """A condition that is watched in a mode, and what happens when it comes true."""

    condition: Any  # Condition
    action: str


class Switching:
    """A part, joint or force, whose rows depend on its mode."""

    switches: Any = True  # False: a part of the class that never does
    without_events: ClassVar[str] = "leave the part out"  # what to do where no events are looked for

    def first_mode(self) -> Mode:
        """Return the mode at the reference pose."""
        raise NotImplementedError

    def rows_in(self, mode: Mode) -> Sequence[Primitive]:
        """Return the rows in a mode."""
        raise NotImplementedError

    def watched(self, mode: Mode) -> list[Watch]:
        """Return what is watched in a mode."""
        raise NotImplementedError


def is_switching(part: Any) -> bool:
    """Return whether the rows of a part are switched at events."""
    return isinstance(part, Switching) and bool(part.switches)
