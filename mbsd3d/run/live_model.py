"""Model of a live run: the system, the controls that change while it moves, and the curves beside it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, repeat
from typing import NamedTuple, Protocol

import numpy as np

from ..base.checks import as_tuple, number, short_repr
from ..base.errors import InputError, similar
from ..equations.compiled import compile_system, starts
from ..mechanism.measures import Measure, angle, check_members, slide, velocity
from ..mechanism.mechanism import Mechanism
from ..mechanism.signals.signal import Input, InputOrName
from ..mechanism.state import State
from .segments import driver_of

KEYS = (
    (("ArrowLeft", "ArrowRight"), ("j", "l")), (("ArrowDown", "ArrowUp"), ("k", "i")), (("a", "d"),), (("s", "w"),),
)  # fmt: skip
"""Pairs of keys of the first four inputs, as browsers name them: to the lower end, to the upper end."""
PADS = ("left stick", "left stick up", "right stick", "right stick up")
"""Their sticks on a gamepad: to the right or up is to the upper end. There are "left trigger", "right trigger" too."""
LINES = 6  # of one panel that nobody asked for
HANDS = tuple(zip(KEYS, PADS, strict=True))
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
PANELS = {
    "rad": "angles", "m": "lengths", "rad/s": "rates", "m/s": "speeds", "N": "forces", "N m": "moments", "-": "states",
}  # fmt: skip


@dataclass(frozen=True)
class Control:
    """A number with a slider, keys, and a stick or trigger of a gamepad, one of `PADS`.

    A pressed key holds an end of its range, a stick its share of the way there; released it is what it was.
    """

    name: str
    low: float
    high: float
    value: float  # at the start
    unit: str = ""
    keys: tuple[tuple[str, str], ...] = ()
    pad: str = ""
    springs: bool = False  # the slider goes back when it is let go
    builds: bool = False  # a change makes the model anew, and it goes on from where it is
    hint: str = ""  # a sentence below it, for who has not used it before


class Panel(NamedTuple):
    """Curves over time with common axes."""

    label: str
    unit: str
    lines: tuple[str, ...]


class Built(NamedTuple):
    """A model that can go on from a state."""

    system: Mechanism
    state: State
    measures: Sequence[Measure]
    curves: Sequence[Measure | str | tuple] | None = None  # of the page of a ride, as `Solution.animate` takes them


class Seen(NamedTuple):
    """Displayed state of the model at one time."""

    curves: Sequence[float]  # a value per line of the panels
    values: Mapping[str, float] = {}  # of controls that follow the motion
    good: Mapping[str, Sequence[tuple[float, float]]] = {}  # ranges of controls that are marked
    over: str = ""  # why it does not go on


class Playable(Protocol):
    """Model that `Playing` runs; ``values`` are those of the controls by name, ``measured`` those of the measures."""

    @property
    def controls(self) -> Sequence[Control]:
        """Return the numbers that change while the model moves."""

    @property
    def panels(self) -> Sequence[Panel]:
        """Return the curves beside the scene."""

    def built(self, values: Mapping[str, float], state: State | None) -> Built:
        """Return the model, at its start, or as it goes on from a state of the one before."""

    def inputs(self, values: Mapping[str, float], measured: Sequence[float] | np.ndarray) -> Mapping[str, float]:
        """Return the values of the `Input` signals for the next segment."""

    def seen(self, values: Mapping[str, float], measured: Sequence[float] | np.ndarray) -> Seen:
        """Return the text and values shown beside the scene."""


@dataclass(frozen=True, eq=False)
class Plain:
    """An unchanged system with a control for each of some inputs."""

    system: Mechanism
    start: State
    controls: Sequence[Control]
    measures: Sequence[Measure]
    panels: Sequence[Panel] = field(init=False)

    def __post_init__(self) -> None:
        panels = [
            Panel(PANELS[unit], unit, tuple(x.label for x in self.measures if x.unit == unit))
            for unit in dict.fromkeys(x.unit for x in self.measures)
        ]
        if self.controls:
            panels.append(Panel("inputs", "", tuple(control.name for control in self.controls)))
        order = sorted(range(len(self.measures)), key=lambda k: [p.unit for p in panels].index(self.measures[k].unit))
        object.__setattr__(self, "measures", tuple(self.measures[k] for k in order))
        object.__setattr__(self, "panels", tuple(panels))

    def built(self, values: Mapping[str, float], state: State | None) -> Built:
        return Built(self.system, state or self.start, self.measures, [*self.measures, "energy"])

    def inputs(self, values: Mapping[str, float], measured: Sequence[float] | np.ndarray) -> Mapping[str, float]:
        return values

    def seen(self, values: Mapping[str, float], measured: Sequence[float] | np.ndarray) -> Seen:
        return Seen([*measured, *values.values()])


def plain(
    system: Mechanism,
    start: State,
    ranges: Mapping[InputOrName, Sequence[float]] | None = None,
    curves: Sequence[Measure] | None = None,
) -> Plain:
    """Return a system with a control for each input that a range (low, high) is given for, and curves of measures.

    Raises
    ------
    ValueError
        For an unknown input, or one that prescribes a motion; an invalid range, or one that excludes the value
        at the start; a measure of another system.
    """
    if curves is None:
        curves = usual_curves(system)
    curves = as_tuple(curves, "play: curves", "a list of mbsd3d.measures")
    for x in curves:
        if not isinstance(x, Measure):
            raise InputError(f"play: curves: {short_repr(x)} is not a measure; build one with mbsd3d.measures")
        check_members(system, x, "play: curves")
    return Plain(system, start, controls_of(system, {} if ranges is None else ranges), curves)


def controls_of(system: Mechanism, ranges: Mapping[InputOrName, Sequence[float]]) -> list[Control]:
    """Return a control for each range given, in their order."""
    if not isinstance(ranges, Mapping):
        raise InputError(f"play: inputs = {short_repr(ranges)}; give a dict, e.g. {{'motor': (-5, 5)}}")
    have, made = starts(compile_system(system)), []
    named = {key.name if isinstance(key, Input) else key: given for key, given in ranges.items()}
    for (name, given), (keys, pad) in zip(named.items(), chain(HANDS, repeat(((), ""))), strict=False):
        if name not in have:
            near = similar(name, have)
            hint = f", did you mean '{near[0]}'? There" if near else "; there"
            there = (
                ", ".join(f"'{x}'" for x in have) or "none: a force takes one, e.g. Force(body, (Input('push'), 0, 0))"
            )
            raise InputError(f"play: {short_repr(name)} is not an input of this system{hint} are {there}")
        what = f"play: input '{name}'"
        pair = as_tuple(given, what, "a range (low, high)")
        if len(pair) != 2:
            raise InputError(f"{what}: {short_repr(given)} is not a range; give (low, high)")
        low, high = (number(x, what) for x in pair)
        if not low < high:
            raise InputError(f"{what}: the range {low:g} ... {high:g} is empty or the wrong way round; give low < high")
        if not low <= have[name] <= high:
            raise InputError(
                f"{what} starts with {have[name]:g}, outside {low:g} ... {high:g}; give a range that holds it"
            )
        if (driver := driver_of(system, name)) is not None:
            raise InputError(
                f"{what} prescribes the motion of driver '{driver}', and a jump would tear the joints apart; let it "
                "set a force, or a reference of a controller"
            )
        made.append(Control(name, low, high, have[name], keys=keys, pad=pad))
    return made


def usual_curves(system: Mechanism) -> list[Measure]:
    """Return angles and slides of the first joints that have one; without any, the velocity of the heaviest body."""
    found = []
    for kind, of in (("angle", angle), ("slide", slide)):
        joints = [joint for joint in system.joints if getattr(joint, kind)() is not None][:LINES]
        found += [replace(of(joint), label=f"{kind} of {system.name(joint)}") for joint in joints]
    heaviest = max(system.bodies, key=lambda body: body.mass)
    return found or [replace(velocity(heaviest, axis=way), label=f"{x} of {heaviest.name}") for x, way in AXES.items()]
