"""Base of the parts that hold a hinge coordinate by a row, and let it go, as loads and motion ask for it."""

from typing import ClassVar

from ..base.fields import part_class
from .force_element import ForceElement, ForceRecord
from .joints import Joint
from .measures import HOLDING_MEASURES, Condition, Measure, label, of_coordinate
from .primitives import Coordinate, Primitive, ratio
from .signals import Constant
from .switching import OPEN, Mode, Switching, Watch


@part_class()
class Lock(Switching, ForceElement):
    """Base class of what holds an angle or slide x at a value, one row x - x_held = 0, by its mode.

    ``one_sided``: it presses one way only, and is closed by impacts; else it holds both ways, up to a load.
    """

    one_sided: ClassVar[bool] = True
    sticks: ClassVar[bool] = False  # held by its row, as far as that is independent, wherever it is at rest
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
        return [self.row_at(mode.numbers[0])] if self.holds(mode) else []

    def row_at(self, value: float) -> Primitive:
        """Return the row x - value = 0."""
        x = self.coordinate()
        return ratio(x, 1.0, signal=Constant(value), in_metres=self.in_metres)

    @property
    def in_metres(self) -> bool:
        """Return whether x is a length, not an angle."""
        return self.coordinate().kind != "angle"

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

    def idle(self, mode: Mode) -> Mode:
        """Return the mode at rest in which it neither holds nor acts, where the other rows decide."""
        return self.opened(mode)

    def moving(self, mode: Mode, rate: float, slow: float) -> Mode:
        """Return the mode that fits a rate of the coordinate, after an impact or where it has just closed."""
        return mode

    def after(self, mode: Mode, watch: Watch) -> Mode:
        """Return the mode after what it watched for, as far as it follows from that alone."""
        return self.opened(mode) if self.holds(mode) else mode

    def excess(self, load: float, mode: Mode, capacity: float) -> float:
        """Return by how much the load of a held mode is beyond what it holds; > 0: it lets go.

        ``capacity``: the load of its own law at the multipliers of the moment.
        """
        return -self.sense(mode) * load

    def returns(self, a: float, held: Mode, free: Mode) -> float:
        """Return how fast a free mode at rest turns back into what would hold: an acceleration, > 0: it does."""
        return -self.sense(held) * a

    def starts(self, a: float, slow: float, free: Mode, others_hold: bool) -> Mode:
        """Return the mode of a free one at rest with an acceleration, by more than ``slow`` if it moves."""
        return free

    def helps(self, free: Mode, rate: float) -> bool:
        """Return whether the load of a free one at rest is along a rate."""
        return False

    def resting(self, mode: Mode, slow: float) -> Mode:
        """Return the mode in which it stays at rest, if it does, where ``slow`` counts as no rate."""
        return mode

    def outcome(self, before: Mode, after: Mode, action: str) -> str:
        """Return the text of the event that a part reports when its condition comes true."""
        return action

    def yielding(self, mode: Mode, load: float) -> Mode:
        """Return the mode after a held one that lets go at a load."""
        return self.opened(mode)

    def touching(self, mode: Mode, x: float, rate: float, slack: float, slow: float) -> Mode | None:
        """Return the held mode that it may take at a value and rate, None if there is none.

        ``slack`` and ``slow`` are what counts as no distance and as no rate.
        """
        raise NotImplementedError

    def bounds(self, mode: Mode) -> list[Condition]:
        """Return the conditions on value and rate of the coordinate that are false as long as it is in a mode."""
        watched = [watch.condition for watch in self.watched(mode)]
        return [one for one in watched if one.measure.kind not in HOLDING_MEASURES]

    def load_measure(self) -> Measure:
        """Return the load of the row along the coordinate on body b."""
        unit = "N" if self.in_metres else "N m"
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
