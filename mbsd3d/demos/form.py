"""Definition of a demo: a question, a mechanism by its parameters, numbers with their theory, and an ablation."""

import inspect
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from functools import cached_property, partial
from math import isfinite
from typing import Any, NamedTuple, TypeVar

import numpy as np

from ..api.solution import Solution
from ..api.system import System
from ..api.viewable import AnimateOptions
from ..base.errors import InputError, MbsError
from ..mechanism.state import State
from ..view.explore.ridden import Ride
from .base import Outcome, Row, Show
from .figure import PANELS_PER_ROW_MAX, Curve, Drawn, Panel, Points, same
from .parameters import OMITTABLE_TERMS, Values, checked, lacking, listed, refusing

T = TypeVar("T")
Numbers = Mapping[str, float]


@dataclass(frozen=True)
class Quantity:
    """Number that proves the effect: its meaning, its unit, and its tolerance against theory."""

    label: str
    unit: str = ""
    relative: float = 1e-8
    absolute: float = 1e-9

    def tolerance(self, theory: float) -> float:
        """Return the largest accepted error for a theoretical value."""
        return max(self.absolute, self.relative * abs(theory)) if isfinite(theory) else self.absolute


class Against(NamedTuple):
    """Figure of the first quantity over a parameter: theory as a line, some values computed."""

    parameter: str
    low: float
    high: float
    label: str  # with its unit in brackets
    computed: int = 5


class Control(NamedTuple):
    """Parameter that a reader of the page moves, or an item of one, "w[1]"; the mechanism starts as it says."""

    parameter: str
    low: float
    high: float
    unit: str = ""
    label: str = ""
    logarithmic: bool = False


class Beat(NamedTuple):
    """Sentence of the story at its moment of the film with the first parameters: a time [s], or found in the run."""

    at: float | Callable[[Solution], float]
    says: str


class Symbol(NamedTuple):
    """Meaning of a letter of the equation, and where its value is seen on the page.

    ``value`` names a parameter, or is a function of the parameters it names; ``curve`` is a line, as (curve, line), of
    the curves that are shown, whose value changes with the time; ``arrow`` is a kind of arrows.
    """

    text: str
    unit: str = ""
    value: str | Callable[..., float] = ""
    curve: tuple[int, int] | None = None
    arrow: str = ""


GRAVITY = Symbol("weight of a kilogram", "N/kg", lambda: 9.81)


@dataclass(frozen=True, eq=False)
class Measured:
    """Computed results: quantities by name, runs to show (the first one moves on the page), curves.

    Curves and notes that take their time are functions, called when somebody wants to see them.
    """

    values: Numbers
    solutions: Sequence[Solution] = ()
    curves: Sequence[Drawn] | Callable[[], Sequence[Drawn]] = ()
    views: Mapping[str, Show] = field(default_factory=dict)  # besides the first run's, by what they add to its name
    notes: Sequence[str] | Callable[[], Sequence[str]] = ()


@dataclass(frozen=True, eq=False)
class Ablation:
    """Removal of a term that makes the effect vanish, and the values to be found then.

    ``term`` is a teaching switch ("gyroscopic", "centripetal", "gamma") or a word for ``change``, which are other
    values of parameters. ``values`` gives the quantities that must then be found; None = theory with the change.
    """

    term: str
    then: str  # in words
    change: Values = field(default_factory=dict)
    values: Callable[..., Numbers] | None = None


@dataclass(frozen=True, eq=False)
class Demo:
    """Demo of one effect. Its module defines ``mechanism``, ``measure`` and ``theory``, each called with the parameters
    it names, and ``film(build, **parameters)`` where another mechanism or another start moves on its page.

    The parameters and their defaults are the keyword arguments of ``mechanism(**parameters) -> System`` and of
    ``measure(build, terms, **parameters) -> Measured``, where ``build`` is a `Builder` and ``terms`` are the switches
    of an ablation for `simulate`, `accelerations` and `linearize`. ``theory(**parameters)`` gives the
    same quantities by formulas; it raises a ValueError where they do not hold.
    """

    module: str  # __name__: its last part is the name, the first line of its package the family
    title: str
    question: str
    why: str
    equation: str
    source: str
    quantities: Mapping[str, Quantity]
    ablation: Ablation
    against: Against | None = None
    alone: str = ""  # why its run is not compared with that of other engines; "" = it is
    show: AnimateOptions | Callable[..., AnimateOptions] = field(default_factory=AnimateOptions)  # by the parameters
    ranges: Mapping[str, Sequence | None] = field(default_factory=dict)  # see `varied`
    may_vanish: Sequence[str] = ()  # parameters, besides those that the ablation takes away
    # up to four, of parameters of what moves on the page, as `Control` or as its numbers; () = the page replays its run
    sliders: Sequence[Control | tuple] = ()
    # by quantity, how the page finds it: ("crossings", curve, line), "turning" or "last" of the curves of `show`
    readings: Mapping[str, tuple[str, int, int]] = field(default_factory=dict)
    theory_moves: bool = True  # with the sliders; False: it takes too long to be found over their ranges
    attempt: str = ""  # what to try with the sliders, in a sentence
    beats: Sequence[Beat] = ()  # what happens, sentence by sentence
    symbols: Mapping[str, Symbol] = field(default_factory=dict)  # of the equation, as they are written there

    @property
    def name(self) -> str:
        """Return the name of the demo: that of its file."""
        return self.module.rpartition(".")[2]

    @property
    def family(self) -> str:
        """Return the family of the demo: the first line of its package."""
        text = sys.modules[self.module.rpartition(".")[0]].__doc__ or ""
        return text.splitlines()[0].rstrip(".")

    @property
    def mechanism(self) -> Callable[..., System]:
        """Return the function ``mechanism`` of the module of the demo."""
        return sys.modules[self.module].mechanism

    @property
    def ride(self) -> Callable[..., Ride] | None:
        """Return the function ``ride`` of the module of the demo: what a reader of its page moves himself."""
        return getattr(sys.modules[self.module], "ride", None)

    @property
    def measure(self) -> Callable[..., Measured]:
        """Return the function ``measure`` of the module of the demo."""
        return sys.modules[self.module].measure

    @property
    def theory(self) -> Callable[..., Numbers]:
        """Return the function ``theory`` of the module of the demo."""
        return sys.modules[self.module].theory

    @cached_property
    def parameters(self) -> dict[str, Any]:
        """Return names and defaults of the parameters."""
        named = [inspect.signature(function).parameters.values() for function in (self.mechanism, self.measure)]
        found = {x.name: x.default for xs in named for x in xs if x.default is not inspect.Parameter.empty}
        return {name: plain(value) for name, value in found.items()}

    @property
    def vanishing(self) -> tuple[str, ...]:
        """Return the parameters that may be arbitrarily small."""
        return (*(name for name, value in self.ablation.change.items() if value == 0), *self.may_vanish)

    def varied(self, rng: np.random.Generator) -> dict[str, Any]:
        """Draw other parameters at random: numbers within their range, by default 15 % about theirs; None leaves
        one."""

        def other(value: Any) -> Any:
            if isinstance(value, Mapping):
                return {key: other(item) for key, item in value.items()}
            if isinstance(value, list):
                return [other(item) for item in value]
            return value * float(rng.uniform(0.85, 1.15)) if isinstance(value, float) else value

        found = {name: other(value) for name, value in self.parameters.items() if name not in self.ranges}
        for name, ends in self.ranges.items():
            if ends is not None:
                found[name] = np.asarray(rng.uniform(*np.transpose(ends))).tolist()
        return found

    def call(self, function: Callable[..., T], values: Values, *arguments: object) -> T:
        """Call a function of this demo with the parameters it names."""
        return function(*arguments, **{name: values[name] for name in inspect.signature(function).parameters
                                       if name in self.parameters})  # fmt: skip

    def filmed(self, values: Values) -> System | tuple[System, State]:
        """Return the mechanism that moves on the page, or it and where it starts: that of ``film``, if there is one."""
        film = getattr(sys.modules[self.module], "film", None)
        return self.call(film, values, Builder(self, values)) if film else self.call(self.mechanism, values)

    def computed(self, values: Values, terms: Mapping[str, bool]) -> Measured:
        """Measure the quantities with these parameters; raise InputError where there are none."""
        with self.refusing(values):
            return self.call(self.measure, values, Builder(self, values), terms)

    def refusing(self, values: Values) -> AbstractContextManager[None]:
        """Raise an error that names the changed parameters if a run fails, or its numbers or theory are not finite,
        within the block.
        """
        return refusing(self.name, self.parameters, values)

    def expected(self, values: Values) -> Numbers:
        """Return the values of theory; raise InputError where there are none."""
        try:
            with np.errstate(all="ignore"):
                found = self.call(self.theory, values)
        except (ArithmeticError, ValueError) as error:
            if isinstance(error, MbsError):
                raise
            found = dict.fromkeys(self.quantities, np.nan)
        lost = ", ".join(key for key, value in found.items() if np.isnan(value))
        require(not lost, f"demo '{self.name}': theory has no {lost} for these parameters; stay nearer to the defaults")
        return found

    def without(self, term: str | None, values: Values) -> tuple[dict, dict]:
        """Return parameters and switches of an ablation; a term is a switch, or that of the demo."""
        if term is None:
            return dict(values), {}
        if term == self.ablation.term and self.ablation.change:
            return {**values, **self.ablation.change}, {}
        terms = dict.fromkeys((self.ablation.term, *OMITTABLE_TERMS))
        if term not in terms:
            raise InputError(f"demo '{self.name}' has no term '{term}'; {listed(term, list(terms))}")
        return dict(values), {term: False}

    def expected_without(self, values: Values) -> Numbers:
        """Return the values to be found under the demo's own ablation."""
        changed, _ = self.without(self.ablation.term, values)
        return self.call(self.ablation.values, values) if self.ablation.values else self.expected(changed)

    def shown(self, values: Values) -> AnimateOptions:
        """Return the options of the first run's page with these parameters."""
        return self.call(self.show, values) if callable(self.show) else self.show

    def run(self, without: str | None = None, /, **changes: object) -> Outcome:
        """Compute with some parameters changed, and perhaps without a term; theory is that of the whole effect."""
        values = checked(self.name, self.parameters, changes, self.vanishing)
        with self.refusing(values):
            self.call(self.mechanism, values)  # a mechanism that there cannot be is refused before theory tries it
            theory = self.expected(values)
        found = self.computed(*self.without(without, values))
        rows = tuple(
            Row(quantity.label, found.values[key], theory[key], quantity.tolerance(theory[key]), quantity.unit, key)
            for key, quantity in self.quantities.items()
        )
        stem = self.name if without is None else f"{self.name}_without_{without}"
        stems = [stem, *(f"{stem}_{k + 2}" for k in range(len(found.solutions)))]
        solutions = dict(zip(stems, found.solutions, strict=False))
        options: AnimateOptions = {"hidden": ["joint names"], **self.shown(values)}
        if found.solutions and without is None and values == self.parameters:
            options["captions"] = self.story(found.solutions[0])
        if self.ride and without is None:
            options["ride"] = self.call(self.ride, values)
        views = {stem: Show(found.solutions[0], options)} if found.solutions else {}
        views |= {f"{stem}_{name}": view for name, view in found.views.items()}
        drawn = partial(self.panels, values, found, without)

        def noted() -> tuple[str, ...]:
            return (*wanted(found.notes), f"{lacking(self.ablation.term)}: {self.ablation.then}")

        return Outcome(rows, drawn, solutions, noted, views, values, self.title)

    def story(self, run: Solution) -> list[tuple[float, str]]:
        """Return the moments [s] of the beats in the run with the first parameters, and their sentences."""
        return [(float(at(run) if callable(at) else at), says) for at, says in self.beats]

    def meanings(self, values: Values) -> list[dict[str, Any]]:
        """Return the symbols of the equation with their values for these parameters, if they have one."""
        found = []
        for letter, symbol in self.symbols.items():
            value = self.call(symbol.value, values) if callable(symbol.value) else values.get(symbol.value)
            found.append({"letter": letter, **symbol._asdict(), "value": value, "parameter": symbol.value})
        return found

    def panels(self, values: Values, found: Measured, without: str | None) -> list[Panel]:
        """Return curves with theory and ablation, and the first quantity over a parameter."""
        try:
            ablated = self.computed(*self.without(None if without else self.ablation.term, values))
            others = wanted(ablated.curves)
        except ValueError:
            others = ()  # some mechanisms do not run without what they need
        label = "all terms" if without else lacking(self.ablation.term)
        panels = [
            Panel(curve, others[k] if k < len(others) and not same(curve, others[k]) else None, label)
            for k, curve in enumerate(wanted(found.curves))
        ]
        if self.against and not without:
            panels.append(self.panel_against(self.against, values, found))
        return panels[:PANELS_PER_ROW_MAX]

    def panel_against(self, against: Against, values: Values, found: Measured) -> Panel:
        """Return the panel of the first quantity over a parameter."""
        name, low, high, along, count = against
        key, quantity = next(iter(self.quantities.items()))
        few, fine = np.linspace(low, high, count), np.linspace(low, high, 61)

        def sampled(function: Callable[..., Numbers], places: np.ndarray) -> list[float]:
            return [valid(function, {**values, name: type(values[name])(place)}, key) for place in places]

        label = f"{quantity.label} [{quantity.unit or '-'}]"
        here = values[name]
        few_values = sampled(lambda changed: self.computed(changed, {}).values, few)
        line = Curve(label, fine, sampled(self.expected, fine), None, along)
        return Panel(Points(line, (few, few_values), (here, found.values[key])))


class Builder(NamedTuple):
    """Builder of the mechanism of a demo, ``build(**changes)``; ``theory`` is for curves, not for computed values."""

    demo: Demo
    values: Values

    def __call__(self, **changes: object) -> System:
        return self.demo.call(self.demo.mechanism, {**self.values, **changes})

    @property
    def theory(self) -> Numbers:
        """Return the values of theory for the parameters."""
        return self.demo.expected(self.values)


def wanted(given: Sequence[T] | Callable[[], Sequence[T]]) -> Sequence[T]:
    """Return a value, or the result of a function without arguments."""
    return given() if callable(given) else given


def plain(value: Any) -> Any:
    """Return a default as JSON would give it: lists for tuples."""
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    return [plain(item) for item in value] if isinstance(value, list | tuple) else value


def valid(function: Callable[..., Numbers], values: Values, key: str) -> float:
    """Return a quantity, or nan where it does not exist."""
    try:
        return float(function(values)[key])
    except ValueError:
        return np.nan


def require(condition: bool | np.bool_, what: str) -> None:
    """Raise ValueError where the assumptions of a formula end; ``what`` says which, and what to give."""
    if not condition:
        raise InputError(what)
