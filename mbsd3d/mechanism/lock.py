"""Base of the parts that hold a hinge coordinate by a row, and let it go, as loads and motion ask for it."""

from typing import ClassVar

from ..base.fields import part_class
from .force_element import ForceElement, ForceRecord
from .joints import Joint
from .measures import Condition, Measure, label, of_coordinate
from .primitives import Coordinate, Primitive, ratio
from .signals import Constant
from .switching import OPEN, Mode, Switching, Watch


@part_class()
class Lock(Switching, ForceElement):
    """Base class of what holds an angle or slide x at a value, one row x - x_held = 0, by its mode.

    ``one_sided``: it presses one way only, and is closed by impacts; else it holds both ways, up to a load.
    """

    one_sided: ClassVar[bool] = True
    leaves: ClassVar[str] = "lets go"  # what happens where a one-sided row no longer presses

    def coordinate(self) -> Coordinate:
        """Return the coordinate that is held."""
        raise NotImplementedError

    def through(self) -> Joint:
        """Return the joint along whose coordinate it acts."""
        raise NotImplementedError

    def first_mode(self) -> Mode:
        return OPEN

    @property
    def bounce(self) -> float:
        """Return the restitution of its impacts."""
        return 0.0

    def sense(self, mode: Mode) -> float:
        """Return the sign of the loads with which it presses in a held mode."""
        return 1.0

    def rows_in(self, mode: Mode) -> list[Primitive]:
        if not self.holds(mode):
            return []
        x = self.coordinate()
        return [ratio(x, 1.0, signal=Constant(mode.numbers[0]), in_metres=x.kind != "angle")]

    def holds(self, mode: Mode) -> bool:
        """Return whether the row is there in a mode."""
        return mode.name.startswith("held")

    def record_in(self, mode: Mode) -> ForceRecord:
        """Return what its law reads in a mode."""
        return self.record()

    def placed(self, mode: Mode, x: float, slack: float) -> Mode:
        """Return a mode with the numbers that belong to the value x of the coordinate."""
        return mode

    def depth(self, x: float) -> float:
        """Return how far a value is beyond what it holds back, < 0 inside."""
        return -1.0

    def opened(self, mode: Mode) -> Mode:
        """Return the mode that the part has where it does not hold: of a held one that with which it lets go."""
        return OPEN

    def moving(self, mode: Mode, rate: float, slow: float) -> Mode:
        """Return the mode that fits a rate of the coordinate, after an impact or where it has just closed."""
        return mode

    def after(self, mode: Mode, watch: Watch) -> Mode:
        """Return the mode after what it watched for, as far as it follows from that alone."""
        return self.opened(mode) if self.holds(mode) else mode

    def excess(self, load: float, mode: Mode) -> float:
        """Return by how much the load of a held mode is beyond what it holds; > 0: it lets go."""
        return -self.sense(mode) * load

    def returns(self, a: float, held: Mode, free: Mode) -> float:
        """Return how fast a free mode at rest turns back into what would hold: an acceleration, > 0: it does."""
        return -self.sense(held) * a

    def yielding(self, mode: Mode, load: float) -> Mode:
        """Return the mode after a held one that lets go at a load."""
        return self.opened(mode)

    def touching(self, mode: Mode, x: float, rate: float, slack: float, slow: float) -> Mode | None:
        """Return the held mode that it may take at a value and rate, None if there is none.

        ``slack`` and ``slow`` are what counts as no distance and as no rate.
        """
        raise NotImplementedError

    def load_measure(self) -> Measure:
        """Return the load of the row along the coordinate on body b."""
        unit = "N m" if self.coordinate().kind == "angle" else "N"
        return Measure("holding load", f"load of {label(self)}", unit, part=self)

    def rate_measure(self) -> Measure:
        """Return the rate of the coordinate."""
        return of_coordinate(self.coordinate(), f"rate at {label(self)}", rate=True)

    def value_measure(self) -> Measure:
        """Return the value of the coordinate."""
        return of_coordinate(self.coordinate(), f"place at {label(self)}")

    def watch_load(self, mode: Mode) -> list[Watch]:
        """Return that a one-sided row lets go where its load changes sign."""
        return [Watch(Condition(self.load_measure(), 0.0, -self.sense(mode)), self.leaves)]

    def partners(self) -> tuple[Joint, ...]:
        return (self.through(),)
