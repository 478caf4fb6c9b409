"""Demos, and how they are found: in this folder and in other packages."""

import pkgutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module, metadata
from math import inf, isfinite
from typing import TYPE_CHECKING, NamedTuple, TypeVar

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..api.solution import Solution

GROUP = "mbsd3d.demos"
T = TypeVar("T")


@dataclass(frozen=True)
class Row:
    """One line of a demo's table: a computed number beside its theory.

    Examples
    --------
    >>> Row("period", 2.0000001, 2.0, 1e-6, "s").passed
    True
    """

    quantity: str
    computed: float
    theory: float
    tolerance: float  # largest accepted |computed - theory|
    unit: str = ""  # e.g. "N m"; "" for a pure number

    @property
    def error(self) -> float:
        """|computed - theory|; infinite if a number is not finite."""
        error = abs(float(self.computed) - float(self.theory))
        return error if isfinite(error) else inf

    @property
    def passed(self) -> bool:
        """True if the error is within the tolerance."""
        return self.error <= self.tolerance


class Show(NamedTuple):
    """A run to animate, with options of `Solution.animate`."""

    solution: "Solution"
    options: Mapping[str, object] = {}


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a demo gives: the table, a figure, runs and views by the names of their files, and lines to print below."""

    rows: tuple[Row, ...]
    figure: "Figure"
    solutions: Mapping[str, "Solution"]
    notes: tuple[str, ...] = ()
    views: Mapping[str, Show] = field(default_factory=dict)

    @property
    def passed(self) -> bool:
        """True if every row is within its tolerance."""
        return all(row.passed for row in self.rows)


@dataclass(frozen=True, eq=False)
class Demo:
    """One effect with its theory; without changes every row of ``run(**changes)`` passes."""

    name: str  # for the command line and the files
    title: str  # a few words
    why: str  # one sentence: why the effect exists only in space
    source: str  # of the theory
    run: Callable[..., Outcome]
    ablation: Mapping[str, object] = field(default_factory=dict)  # changes that put a row off by 100 tolerances


class Demos(dict[str, Demo]):
    """Demos by name; ``broken`` says of each entry point that could not be loaded why not."""

    def __init__(self, demos: Mapping[str, Demo], broken: Mapping[str, str]) -> None:
        super().__init__(demos)
        self.broken = dict(broken)


def load_entry(entry: metadata.EntryPoint, kind: type[T]) -> T:
    """The object of an entry point, an instance of ``kind``.

    A ValueError of one line names the package, and the error of its import (SystemExit included) or the type found.
    """
    package = f"package '{entry.dist.name}'" if entry.dist else f"'{entry.value}'"
    try:
        found = entry.load()
    except (Exception, SystemExit) as error:
        text = " ".join(str(error).split())
        raise ValueError(f"{package} cannot be loaded: {type(error).__name__}: {text}; repair or remove it") from error
    if not isinstance(found, kind):
        raise ValueError(f"{package} gives a {type(found).__name__}, not a {kind.__name__}; repair or remove it")
    return found


def discover() -> Demos:
    """All demos by name: every module of this folder with a ``demo``, then the entry points of "mbsd3d.demos".

    Entry points that cannot be loaded, or whose name is taken, are in ``broken``.
    """
    found, broken = own_demos(), {}
    for entry in metadata.entry_points(group=GROUP):
        try:
            demo = load_entry(entry, Demo)
            if demo.name in found:
                raise ValueError(f"a demo is already named '{demo.name}'; rename one")
            found[demo.name] = demo
        except ValueError as error:
            broken[entry.name] = str(error)
    return Demos(found, broken)


def own_demos() -> dict[str, Demo]:
    """The demos of this folder, in the order of their names."""
    package = __name__.rpartition(".")[0]
    paths = import_module(package).__path__
    modules = [import_module(f"{package}.{module.name}") for module in pkgutil.iter_modules(paths)]
    demos = [module.demo for module in modules if isinstance(getattr(module, "demo", None), Demo)]
    return {demo.name: demo for demo in sorted(demos, key=lambda demo: demo.name)}
