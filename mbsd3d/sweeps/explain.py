"""Explain a result: repeat the run without each term, joint and force, and with each number changed."""

import copy
import hashlib
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.ticker import SymmetricalLogLocator

from ..api.system import System
from ..base.checks import number, short_repr
from ..base.csv_files import write_table
from ..base.errors import InputError, SweepError
from ..base.fields import (
    Direction,
    DirectionOrDerived,
    DirectionOrNone,
    Orientation,
    Vector,
    VectorOrDerived,
    VectorOrNone,
    kind_of,
)
from ..base.style import aligned, html_table, new_figure, style_axes
from ..base.templates import HtmlPage, page_template
from ..files.description import describe, read_system
from ..files.schema import types
from ..mechanism.drivers import AxesOrNone
from ..mechanism.joints.curve_contact import Pin
from ..mechanism.shapes.shape import AxisOrLetter
from ..report.exhibits import inline_svg
from .experiment import check_parameters
from .store import run_stamp, stamp
from .study import Study
from .sweep import sweep

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TERMS = {"gyroscopic": "gyroscopic term w x I w", "centripetal": "centripetal term m w x (w x s)"}
BODY_NUMBERS = ("mass", "inertia", "com", "velocity", "omega")
PLACES = (
    Vector, VectorOrNone, VectorOrDerived, Direction, DirectionOrNone, DirectionOrDerived, Orientation, AxesOrNone, Pin,
    AxisOrLetter,
)  # fmt: skip
LINES_SHOWN = 15  # [1] of each list in print, in a figure and on a page
NOTHING = 10.0  # [rtol] of an output: what the errors of two runs may differ by
RTOL = 1e-8  # of simulate
NOT_FOR_CELLS = ("state", "stop_when")  # arguments of simulate that hold parts of one system


class Change(NamedTuple):
    """One change of a model: what, and how."""

    part: str
    change: str  # "left out", "+1 %"
    document: Mapping[str, Any] | None  # model as data; None = the one that build makes
    terms: Mapping[str, bool]
    parameters: Mapping[str, Any]


@dataclass(frozen=True)
class Effect:
    """What one change did: relative changes of the outputs, or why there is no run."""

    part: str
    change: str
    values: Mapping[str, float]
    error: str = ""

    @property
    def largest(self) -> float:
        """Return the largest change of an output."""
        return max((abs(x) for x in self.values.values()), default=0.0)


@dataclass(frozen=True, repr=False)
class Explanation:
    """Effects of all changes on the outputs of a run, the largest first.

    >>> from mbsd3d import Body, Force, System, explain
    >>> box = Body("box", 2.0, (0.1, 0.1, 0.1))
    >>> pushed = System([box], forces=[Force(box, (3.0, 0, 0), name="push")], gravity=(0, 0, 0))
    >>> print(explain(pushed, lambda run: {"way": run.position("box")[-1, 0]}, run={"t_end": 1.0, "output": 2}))
    left out                             way
    push                              -100 %
    gyroscopic term w x I w                0
    centripetal term m w x (w x s)         0
    <BLANKLINE>
    +1 %                       way
    push: force 0 value       +1 %
    box: mass              -0.99 %
    box: inertia                 0
    """

    outputs: Mapping[str, float | list[float]]
    effects: tuple[Effect, ...]
    percent: float

    @cached_property
    def groups(self) -> dict[str, list[Effect]]:
        """Return the effects by kind: left out, changed, without a run."""
        ran = sorted((x for x in self.effects if not x.error), key=lambda x: -x.largest)
        return {
            "left out": [x for x in ran if x.change == "left out"],
            f"+{self.percent:g} %": [x for x in ran if x.change != "left out"],
            "no run": [x for x in self.effects if x.error],
        }

    def rows(self, kind: str, count: int | None = LINES_SHOWN) -> list[tuple[str, ...]]:
        """Return the lines of a kind as texts."""
        return [(x.part, *(shown(x.values[name]) for name in self.outputs)) for x in self.groups[kind][:count]]

    def __str__(self) -> str:
        lines = []
        for kind in list(self.groups)[:2]:
            if rows := self.rows(kind):
                head = (kind, *self.outputs)
                rest = len(self.groups[kind]) - len(rows)
                lines += [*table(head, rows), *([f"... and {rest} with less effect"] if rest > 0 else []), ""]
        lines += [f"no run without '{x.part}': {x.error}" if x.change == "left out" else f"no run with '{x.part}' "
                  f"{x.change}: {x.error}" for x in self.groups["no run"]]  # fmt: skip
        return "\n".join(lines).rstrip()

    __repr__ = __str__

    def _repr_html_(self) -> str:
        return "".join(
            html_table(kind, ("part", *self.outputs), self.rows(kind))
            for kind in list(self.groups)[:2]
            if self.groups[kind]
        )

    def to_csv(self, path: str | Path) -> Path:
        """Write all effects: part, change, relative change of each output, error. Returns the file."""
        head = ["part", "change", *self.outputs, "error"]
        rows = ([x.part, x.change, *(x.values.get(name, "") for name in self.outputs), x.error] for x in self.effects)
        return write_table(path, head, rows)

    def figure(self, dark: bool = False) -> "Figure":
        """Return bars of the strongest effects on each output; above a percent of the strongest one to a log scale."""
        chosen = {
            kind: [x for x in self.groups[kind][:LINES_SHOWN] if x.largest][::-1] for kind in list(self.groups)[:2]
        }
        chosen = {kind: best for kind, best in chosen.items() if best}
        width = 0.8 / len(self.outputs)
        height = 0.8 + sum(0.24 * len(best) * len(self.outputs) ** 0.5 + 0.7 for best in chosen.values())
        with new_figure(7.5, height, dark) as (drawn, look):
            panels: Any = (
                drawn.subplots(len(chosen), 1, squeeze=False, height_ratios=[*map(len, chosen.values())])[:, 0]
                if chosen
                else []
            )
            for axes, (kind, best) in zip(panels, chosen.items(), strict=True):
                for k, name in enumerate(self.outputs):
                    places = np.arange(len(best)) - 0.4 + (k + 0.5) * width
                    axes.barh(places, [100.0 * x.values[name] for x in best], width, color=look.colour(k), label=name)
                axes.set_yticks(range(len(best)), [x.part for x in best], fontsize=8)
                axes.set_xscale("symlog", linthresh=best[-1].largest, linscale=0.5)
                axes.xaxis.set_major_locator(SymmetricalLogLocator(base=10.0, linthresh=best[-1].largest))
                axes.xaxis.set_major_formatter(lambda x, _: f"{x:g}".replace("-", "\N{MINUS SIGN}"))
                style_axes(axes, look)
                axes.axvline(0.0, color=look.muted, linewidth=0.8)
                axes.set_xlabel(f"change of the output when {kind} [%]")
            if chosen:
                panels[0].legend(frameon=False, fontsize=8, labelcolor=look.ink, loc="lower right")
        return drawn

    def page(self, path: str | Path | None = None, *, title: str = "Why is it so?") -> "ExplanationPage":
        """Return the effects as an offline page; written if a ``path`` is given."""
        tables = [(kind, self.rows(kind, None)) for kind in list(self.groups)[:2] if self.groups[kind]]
        drawn = inline_svg(self.figure(), "explain") if tables else ""
        html = page_template("explain.html").render(
            title=title, outputs=self.outputs, tables=tables, figure=drawn, errors=self.groups["no run"]
        )
        made = ExplanationPage(html, title)
        if path is not None:
            made.save(path)
        return made


@dataclass(frozen=True, repr=False)
class ExplanationPage(HtmlPage):
    """Offline page of an `Explanation`."""

    html: str
    title: str


def explain(
    build: System | Callable[..., System] | Study,
    measure: Callable[[Any], Any] | None = None,
    *,
    run: Mapping[str, Any] | None = None,
    parameters: Mapping[str, Any] | None = None,
    percent: float = 1.0,
    executor: Any = None,
    ledger: str | Path | None = None,
    progress: bool | None = None,
) -> Explanation:
    """Find what the outputs of a run depend on: leave out each term, joint and force, change each number by a percent.

    Leaving out a joint or force also removes the parts that refer to it. Left out are the gyroscopic and the
    centripetal term and gravity too; changed are masses, inertias, centres of mass, start velocities, the numbers of
    joints, forces and their signals (not where they sit), and the ``parameters`` of ``build``. The effect is
    ``(y - y0) / |y0|``, that of the largest entry for an array; where y0 is 0, y itself. Effects within ten times rtol
    of the run count as 0.

    Parameters
    ----------
    build : System, callable or Study
        A model without functions, ``build(**parameters)`` that returns one, or a `Study`: then its measure, run and
        point x0 stand for what is not given.
    measure : callable
        ``measure(solution)`` returns a number, a 1-D array or a dict of them, as in `sweep`. It finds parts by name.
    run : mapping
        Arguments of `simulate`: t_end, method, rtol, output ...
    parameters : mapping
        Arguments of ``build``; each that is a number is changed too.
    percent : float
        Change of numbers [%].
    executor, ledger, progress
        As in `sweep`: with a ledger the same call goes on where it was interrupted.

    Returns
    -------
    Explanation
        Printed or shown in a notebook, ranked lists; ``figure``, ``page`` and ``to_csv``, and all ``effects``.

    Raises
    ------
    ValueError
        For a model with a function (`CustomForce`), or a ``run`` with state or stop_when, which belong to one system.
    SweepError
        If the unchanged model does not run or cannot be measured.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, System, TorsionSpring, explain
    >>> bob = Body("bob", mass=2.0, inertia=(0.2, 0.2, 0.1), position=(0.0, 0.0, -1.0), omega=(0, 0.5, 0))
    >>> hinge = Revolute(GROUND, bob, at=(0, 0, 0), axis="y", name="hinge")
    >>> swing = System([bob], [hinge], [TorsionSpring(hinge, stiffness=5.0, name="spring")])
    >>> found = explain(swing, lambda run: {"angle": run.angle("hinge").max()}, run={"t_end": 2.0, "output": 201})
    >>> [(x.part, round(x.values["angle"], 3)) for x in found.groups["left out"][:2]]
    [('gravity', 1.217), ('spring', 0.121)]
    """
    if isinstance(build, Study):
        make, measure, run, given = opened(build, measure, run, parameters)
        return explain(
            make, measure, run=run, parameters=given, percent=percent, executor=executor, ledger=ledger,
            progress=progress,
        )  # fmt: skip
    if measure is None:
        raise InputError("explain: no measure; give measure(solution), or a Study, which has one")
    if run is None:
        raise InputError("explain: no run; give the arguments of simulate, run={'t_end': 2.0}, or a Study that runs")
    for name, value in (("run", run), ("parameters", {} if parameters is None else parameters)):
        if not isinstance(value, Mapping):
            raise InputError(f"explain: {name} {short_repr(value)}; give a mapping of names to values")
    wrong = [name for name in NOT_FOR_CELLS if name in run]
    if wrong:
        raise InputError(
            f"explain: run has {wrong[0]}, which belongs to one system; leave it out, and start by velocities of bodies"
        )
    step, given = number(percent, "explain: percent", positive=True), dict(parameters or {})
    if given and isinstance(build, System):
        raise InputError("explain: parameters are for build(...), not for a System; give a function, or leave them out")
    if not isinstance(build, System):
        check_parameters(build, "build", given, "explain")
    made = build if isinstance(build, System) else build(**given)
    if not isinstance(made, System):
        raise InputError(f"explain: build returned {type(made).__name__}; let it return a System")
    changes = [Change("as it is", "", None, {}, given), *changes_of(made, build, given, step)]
    experiment = Cells(made, build, tuple(changes))
    table_ = sweep(
        experiment.build, {"change": np.arange(len(changes))}, measure, run=experiment.settings(run), executor=executor,
        ledger=ledger, tag="" if ledger is None else experiment.tag(run), progress=progress,
    )  # fmt: skip
    if table_.attrs["stopped_by"] and str(table_["error"].values[0]):
        raise KeyboardInterrupt  # nothing can be told without the model as it is
    return explained(table_, changes, step, run.get("rtol", RTOL))


def opened(study: Study, measure: Any, run: Any, parameters: Any) -> tuple[Any, Any, Any, Any]:
    """Return build, measure, run and parameters of a study, but for those that are given."""
    if isinstance(parameters, Mapping | None):
        parameters = {**study.x0, **(parameters or {})}
    if run is None and study.runs:
        run = study.experiment.run
        run = run(**{name: parameters[name] for name in study.x0}) if callable(run) else run
    return study.experiment.build, measure or study.experiment.measure, run, parameters


@dataclass(frozen=True)
class Cells:
    """Builds the changed models, one a cell."""

    system: System
    make: System | Callable[..., System]
    changes: tuple[Change, ...]

    def build(self, change: float) -> System:
        """Return the model of a change."""
        one = self.changes[int(change)]
        if one.document is not None:
            return System.of(read_system(one.document)[0])
        return self.make if isinstance(self.make, System) else self.make(**one.parameters)

    def tag(self, run: Mapping[str, Any]) -> str:
        """Return a digest of the model, its changes and the run, by which a ledger is known."""
        made = describe(self.system) if isinstance(self.make, System) else stamp(self.make)
        whole = [made, run_stamp(run), [list(change) for change in self.changes]]
        return hashlib.sha256(json.dumps(whole, default=stamp, sort_keys=True).encode()).hexdigest()

    def settings(self, run: Mapping[str, Any]) -> Callable[..., dict[str, Any]]:
        """Return the arguments of simulate by change."""

        def chosen(change: float) -> dict[str, Any]:
            return {**run, **self.changes[int(change)].terms}

        return chosen


def explained(table_: Any, changes: list[Change], percent: float, rtol: float) -> Explanation:
    """Return the effects from the outputs of all cells."""
    errors = table_["error"].values
    if errors[0]:
        raise SweepError(
            f"explain: the model as it is does not run: {errors[0]}", advice="correct the model or the run"
        )
    names = [name for name in table_.data_vars if name != "error"]
    values = {name: table_[name].values for name in names}
    odd = [name for name in names if not values[name][0].size or not np.isfinite(values[name][0]).all()]
    if odd or not names:
        found = f"'{odd[0]}' = {short_repr(values[odd[0]][0].tolist())}" if odd else "nothing"
        raise SweepError(
            f"explain: of the model as it is measure returned {found}", advice="return finite numbers, at least one"
        )
    effects = []
    for k, change in enumerate(changes[1:], 1):
        moved = (
            {} if errors[k] else {name: relative(values[name][k], values[name][0], NOTHING * rtol) for name in names}
        )
        odd = [name for name, x in moved.items() if not np.isfinite(x)]
        error = f"{', '.join(odd)} is not a number" if odd else str(errors[k])
        effects.append(Effect(change.part, change.change, {} if odd else moved, error))
    return Explanation({name: values[name][0].tolist() for name in names}, tuple(effects), percent)


def relative(value: np.ndarray, base: np.ndarray, nothing: float) -> float:
    """Return the change of the entry that changes most, relative to the largest entry of the base; 0 where it is less
    than ``nothing``.
    """
    apart, size = np.atleast_1d(value - base), float(np.max(np.abs(base)))
    most = float(apart[np.argmax(np.abs(apart))])
    found = most / size if size else most
    return 0.0 if abs(found) < nothing else found


def changes_of(
    system: System, build: System | Callable[..., System], given: Mapping[str, Any], percent: float
) -> Iterator[Change]:
    """Yield all changes of a model."""
    for term, text in TERMS.items():
        yield Change(text, "left out", None, {term: False}, given)
    whole = named(system)
    if any(whole["gravity"]):
        yield Change("gravity", "left out", {**whole, "gravity": [0.0, 0.0, 0.0]}, {}, given)
    for kind in ("joints", "forces"):
        for entry in whole[kind]:
            rest, gone = without(whole, entry["name"])
            with_it = f" (with {', '.join(gone)})" if gone else ""
            yield Change(f"{entry['name']}{with_it}", "left out", rest, {}, given)
    factor, text = 1.0 + percent / 100.0, f"+{percent:g} %"
    for name, value in given.items():
        if isinstance(value, float | int) and not isinstance(value, bool) and value:
            yield Change(f"parameter {name}", text, None, {}, {**given, name: value * factor})
    for kind in ("bodies", "joints", "forces"):
        for k, entry in enumerate(whole[kind]):
            for path, value in numbers_of(entry, kind):
                other = copy.deepcopy(whole)
                place = other[kind][k]
                for key in path[:-1]:
                    place = place[key]
                place[path[-1]] = scaled(value, factor)
                yield Change(f"{entry['name']}: {' '.join(map(str, path))}", text, other, {}, given)


def named(system: System) -> dict[str, Any]:
    """Return a model as data in which every part has its name."""
    whole = describe(system)
    for kind in ("joints", "forces"):
        for entry, part in zip(whole[kind], getattr(system, kind), strict=True):
            entry["name"] = system.name(part)
    return whole


def without(whole: Mapping[str, Any], name: str) -> tuple[dict[str, Any], list[str]]:
    """Return a model without a joint or force and without what refers to it, and the names of the latter."""
    gone = [name]
    for one in gone:
        for entry in (*whole["joints"], *whole["forces"]):
            if entry["name"] not in gone and refers(entry, one):
                gone.append(entry["name"])
    rest = {kind: [entry for entry in whole[kind] if entry["name"] not in gone] for kind in ("joints", "forces")}
    if "limits" in whole:
        rest["limits"] = [limit for limit in whole["limits"] if not any(refers(limit, one) for one in gone)]
    return {**whole, **rest}, gone[1:]


def refers(entry: Any, name: str) -> bool:
    """Return whether a part, or something in it, names another part."""
    if isinstance(entry, Mapping):
        return any(refers(value, name) for key, value in entry.items() if key not in ("name", "type"))
    return any(refers(value, name) for value in entry) if isinstance(entry, list) else bool(entry == name)


def numbers_of(entry: Mapping[str, Any], kind: str) -> Iterator[tuple[tuple[Any, ...], Any]]:
    """Yield (path, value) of what is changed in a part: numbers of it and of its signals, of bodies vectors too."""
    if kind == "bodies":
        yield from (((name,), entry[name]) for name in BODY_NUMBERS if name in entry and np.any(entry[name]))
        return
    yield from inner_numbers((), entry)


def inner_numbers(path: tuple[Any, ...], value: Any) -> Iterator[tuple[tuple[Any, ...], Any]]:
    """Yield the numbers in a value: it itself, a list of them, or those of a part, signal or shape, without places."""
    if isinstance(value, float) and value:
        yield path, value
    elif isinstance(value, Mapping):
        part = types().get(value.get("type", ""))
        places = {x.name for x in fields(part) if kind_of(x.type) in PLACES} if part else set()
        for key, inner in value.items():
            if key not in places:
                yield from inner_numbers((*path, key), inner)
    elif isinstance(value, list) and all(isinstance(inner, float) for inner in value):
        if any(value):
            yield path, value
    elif isinstance(value, list) and any(isinstance(inner, Mapping) for inner in value):
        for k, inner in enumerate(value):
            yield from inner_numbers((*path, k), inner)


def scaled(value: Any, factor: float) -> Any:
    """Return a number or an array of them times a factor."""
    return (np.asarray(value, float) * factor).tolist()


def shown(effect: float) -> str:
    """Return a relative change as readable text."""
    return "0" if effect == 0.0 else f"{100.0 * effect:+.3g} %"


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> list[str]:
    """Return a head and rows side by side."""
    blank = [(row[0], "", *row[1:]) for row in (head, *rows)]
    return aligned(blank)
