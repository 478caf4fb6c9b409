"""Spread of what a study measures when its parameters are uncertain: percentiles, and the share of each parameter.

    S_k = Var(E(y | x_k)) / Var(y),   T_k = 1 - Var(E(y | all but x_k)) / Var(y)

Saltelli's points: two independent sets A and B of n points, and A with column k from B for each of the k parameters.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.checks import number, short_repr, whole
from ..base.concurrency import one_thread
from ..base.csv_files import write_table
from ..base.errors import InputError, SweepError, checks_arguments, checks_method_arguments
from ..base.progress import Progress
from ..base.style import LINE_WIDTH_POINTS, Result, Theme, new_figure, style_axes
from ..base.wording import counted
from .executors import check_executor
from .experiment import Outcome
from .grids import Samples, check_names, distribution_of, make_grid, samples
from .study import Study
from .sweep import collect

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

RESAMPLES = 400  # [1] of the runs, for intervals of indices: their ends are then known to a tenth of their width
RUNS_MAX = 10_000_000  # [1] of one study
SHOWN = 14  # [1] parameters of a figure and in print: those that matter most
VARYING_MIN = 1e-12  # [1] of the mean square of an output: a variance below it is rounding
BINS = 60  # [1] of a histogram, at most
PERCENTILES = (5.0, 50.0, 95.0)
LEVEL = 0.95  # of intervals in print and in figures


@checks_method_arguments
@dataclass(frozen=True, eq=False, repr=False)
class Sobol(Result):
    """Sobol' indices: the share of each parameter in the variance of an output.

    Attributes
    ----------
    names : tuple of str
        The k parameters.
    first, total : mapping
        Output -> (k,) indices, (k, m) of an output of m numbers: what a parameter does alone, and with all in which it
        acts together with others. Estimates: what is 0 may come out slightly negative. 0 for an output that does not
        vary, NaN where a run failed or gave no number.

    Examples
    --------
    >>> import numpy as np
    >>> from mbsd3d import uncertainty
    >>> ranges = {name: ("uniform", -np.pi, np.pi) for name in "abc"}
    >>> def ishigami(a, b, c):
    ...     return {"y": np.sin(a) + 7.0 * np.sin(b) ** 2 + 0.1 * c**4 * np.sin(a)}
    >>> shares = uncertainty(ishigami, ranges, 4096).sobol
    >>> shares.first["y"].round(2) + 0.0, shares.total["y"].round(2)  # exact: 0.314, 0.442, 0; 0.558, 0.442, 0.244
    (array([0.32, 0.45, 0.  ]), array([0.56, 0.44, 0.24]))
    """

    names: tuple[str, ...]
    first: Mapping[str, np.ndarray]
    total: Mapping[str, np.ndarray]
    runs: Mapping[str, tuple[np.ndarray, np.ndarray, np.ndarray]] = field(repr=False)  # of A, B and A with columns of B
    seed: int = 0

    def confidence_interval(self, output: str, level: float = LEVEL) -> tuple[np.ndarray, np.ndarray]:
        """Return (least, greatest) of the first and of the total indices of an output, each (2, k) or (2, k, m).

        From 400 bootstrap resamples of the points, always the same for the same seed. They are wide
        where outputs are smooth, as Sobol points err less than random ones.
        """
        if output not in self.total:
            raise InputError(f"Sobol: there is no output {short_repr(output)}; there are {', '.join(self.total)}")
        share = number(level, "confidence_interval: level")
        if not 0.0 < share < 1.0:
            raise InputError(f"confidence_interval: level {share:g}; give a probability between 0 and 1")
        low, high = np.quantile(self.drawn[output], [0.5 - 0.5 * share, 0.5 + 0.5 * share], axis=0)
        return np.array([low[0], high[0]]), np.array([low[1], high[1]])

    @cached_property
    def drawn(self) -> dict[str, np.ndarray]:
        """Return the indices (400, 2, k, ...) of resampled points, by output."""
        n = len(next(iter(self.runs.values()))[0]) if self.runs else 0
        rng = np.random.default_rng(self.seed)
        weights = np.array([np.bincount(rng.integers(n, size=n), minlength=n) for _ in range(RESAMPLES)], float)
        return {name: estimates(given, weights) for name, given in self.runs.items()}

    def ranked(self, output: str) -> list[int]:
        """Return the numbers of the parameters, that of the largest total index first; of an output of several numbers
        by their means.
        """
        size = np.nan_to_num(self.total[output]).reshape(len(self.names), -1).mean(axis=1)
        return np.argsort(-size, kind="stable").tolist()

    def to_csv(self, path: str | Path) -> Path:
        """Write one row per parameter: first and total index of every output with their intervals of 95 %."""
        head, columns = ["parameter"], []
        for name in self.total:
            for kind, values, ends in zip(
                ("first", "total"), (self.first[name], self.total[name]), self.confidence_interval(name), strict=True
            ):
                for what, array in (("", values), (" from", ends[0]), (" to", ends[1])):
                    flat = array.reshape(len(self.names), -1)
                    inner = [""] if array.ndim == 1 else [f"[{i}]" for i in range(flat.shape[1])]
                    head += [f"{kind} of {name}{i}{what}" for i in inner]
                    columns.append(flat)
        return write_table(path, head, [[n, *x] for n, x in zip(self.names, np.hstack(columns).tolist(), strict=True)])

    def __str__(self) -> str:
        width = max(19, *map(len, self.total)) if self.total else 0
        columns = []
        for name, total in self.total.items():
            low, high = self.confidence_interval(name)[1]
            shape = (len(self.names), -1)  # of an output of several numbers their mean
            wide, middle = (x.reshape(shape).mean(axis=1) for x in (0.5 * (high - low), total))
            columns.append([f"{x:.4f} +- {w:.4f}" for x, w in zip(middle, wide, strict=True)])
        most = np.array([np.nan_to_num(x).reshape(len(self.names), -1).mean(axis=1) for x in self.total.values()])
        order: Any = np.argsort(-most.max(axis=0), kind="stable") if columns else []
        lines = [f"{'total indices [1]':25}" + "  ".join(f"{name:>{width}}" for name in self.total)]
        lines += [f"{self.names[k]:25}" + "  ".join(f"{column[k]:>{width}}" for column in columns) for k in order]
        return "\n".join(lines)


def estimates(runs: Sequence[np.ndarray], weights: np.ndarray) -> np.ndarray:
    """Return first and total indices (draws, 2, k, ...) by Saltelli's estimators, for weights (draws, n) of the points.

    ``runs``: the output at A (n, ...), at B (n, ...), and at A with each column of B (k, n, ...). NaN where a number is
    missing; 0 where nothing varies.
    """
    draws, (k, n, *inner) = len(weights), runs[2].shape
    A, B = (x.reshape(n, -1) for x in runs[:2])
    centre = 0.5 * (A.mean(axis=0) + B.mean(axis=0))
    A, B, AB = A - centre, B - centre, runs[2].reshape(k, n, -1) - centre
    apart = AB - A
    w = weights / weights.sum(axis=1, keepdims=True)
    mean, square = w @ (A + B) / 2.0, w @ (A * A + B * B) / 2.0
    variance = square - mean**2
    with np.errstate(divide="ignore", invalid="ignore"):
        first = np.array([w @ (B * x) - mean * (w @ x) for x in apart]) / variance
        total = np.array([w @ (x * x) for x in apart]) / (2.0 * variance)
    found = np.where((variance <= VARYING_MIN * square), 0.0, np.array([first, total]))
    there = np.isfinite(A).all(axis=0) & np.isfinite(B).all(axis=0) & np.isfinite(AB).all(axis=(0, 1))
    return np.where(there, found, np.nan).transpose(2, 0, 1, 3).reshape(draws, 2, k, *inner)


@checks_method_arguments
@dataclass(frozen=True, eq=False, repr=False)
class Uncertainty(Result):
    """What a study measures at sampled parameters: percentiles, and Sobol' indices.

    Attributes
    ----------
    samples : Samples
        Independent points (m, k) of the k parameters.
    values : mapping
        Output -> (m,) values, (m, l) of an output of l numbers; NaN where a run failed.
    sobol : Sobol or None
        Indices; None for correlated parameters, which have none.
    errors : tuple of str
        Of the runs that failed, with their parameters; of those that give the indices too.
    stopped_by : str
        Why there are fewer runs than asked for, e.g. after Ctrl-C.

    Examples
    --------
    >>> from mbsd3d import Body, Study, System, uncertainty
    >>> def stone(speed, drag):
    ...     return System([Body("stone", 1.0 + drag, (0.1, 0.1, 0.1), velocity=(speed, 0, 3.0), omega=(0, 0, 0))])
    >>> study = Study(stone, {"speed": 2.0, "drag": 0.1}, lambda run: run.position("stone")[-1, 0], {"t_end": 0.5})
    >>> found = uncertainty(study, {"speed": ("normal", 2.0, 0.1), "drag": (0.0, 0.2)}, 64)
    >>> found.percentiles("value", (5, 50, 95)).round(2), found.sobol.total["value"].round(2)
    (array([0.92, 1.  , 1.08]), array([1., 0.]))
    """

    samples: Samples
    values: Mapping[str, np.ndarray]
    sobol: Sobol | None
    units: Mapping[str, str] = field(default_factory=dict)
    errors: tuple[str, ...] = ()
    stopped_by: str = ""

    def percentiles(self, output: str, at: Sequence[float] = PERCENTILES) -> np.ndarray:
        """Return percentiles [unit of the output] over the runs that have a number, (p,) or (p, l); NaN of none."""
        if output not in self.values:
            raise InputError(f"Uncertainty: no output {short_repr(output)}; there are {', '.join(self.values)}")
        wanted = [number(x, "percentiles: at", minimum=0.0) for x in np.atleast_1d(at)]
        if max(wanted, default=0.0) > 100.0:
            raise InputError(f"percentiles: at {max(wanted):g}; give percents, 0 ... 100")
        values = self.values[output]
        flat, found = values.reshape(len(values), -1), []
        for column in flat.T:
            there = column[np.isfinite(column)]
            found.append(np.percentile(there, wanted) if there.size else np.full(len(wanted), np.nan))
        return np.array(found).T.reshape(len(wanted), *values.shape[1:])

    def to_csv(self, path: str | Path) -> Path:
        """Write one row per point: parameters and outputs."""
        head, columns = [*self.samples.names], [self.samples.points]
        for name, values in self.values.items():
            flat = values.reshape(len(values), -1)
            head += [name] if values.ndim == 1 else [f"{name}[{i}]" for i in range(flat.shape[1])]
            columns.append(flat)
        return write_table(path, head, np.hstack(columns).tolist())

    def __str__(self) -> str:
        count, k = self.samples.points.shape
        width = max(map(len, self.values), default=0)
        head = f"{counted(count, 'point')} of {counted(k, 'parameter')}"
        lines = [head.ljust(width) + "".join(f"{x:10g} %" for x in PERCENTILES)]
        width = max(width, len(lines[0]) - 12 * len(PERCENTILES))
        for name, values in self.values.items():
            if values.ndim == 1:
                lines.append(f"{name:{width}}" + "".join(f"{x:12.6g}" for x in self.percentiles(name)))
            else:
                lines.append(f"{name:{width}}  {values.shape[1]} numbers: see percentiles and figure")
        lines += [f"{counted(len(self.errors), 'run')} failed, the first: {self.errors[0]}"] if self.errors else []
        lines += [self.stopped_by] if self.stopped_by else []
        return "\n".join([*lines, str(self.sobol)] if self.sobol else lines)

    def figure(self, dark: bool = False) -> "Figure":
        """Return a row for each output: its histogram, or the band of its numbers, with the 5th, 50th and 95th
        percentile; and the total indices of the parameters, the largest on top, a stroke for the first index and a line
        for the interval of 95 %.
        """
        columns = 1 if self.sobol is None else 2
        lines = min(SHOWN, len(self.samples.names))
        with new_figure(4.6 * columns, max(2.6, 1.1 + 0.28 * lines) * len(self.values), dark) as (drawn, look):
            panels = drawn.subplots(len(self.values), columns, squeeze=False)
            for i, name in enumerate(self.values):
                self.draw_spread(panels[i, 0], name, look, look.colour(i))
                if self.sobol is not None:
                    draw_shares(panels[i, 1], self.sobol, name, look, look.colour(i))
        return drawn

    def draw_spread(self, axes: "Axes", name: str, look: Theme, colour: str) -> None:
        """Draw a histogram, or a band over the number of the entry."""
        style_axes(axes, look)
        values, unit = self.values[name], self.units.get(name, "")
        label = f"{name} [{unit}]" if unit else name
        low, middle, high = self.percentiles(name)
        if values.ndim == 1:
            there = values[np.isfinite(values)]
            bins = max(1, min(BINS, math.isqrt(there.size)))
            axes.hist(there, bins, density=True, histtype="step", linewidth=LINE_WIDTH_POINTS, color=colour)
            for x in (low, middle, high):
                axes.axvline(x, color=look.muted, linewidth=0.8)
            axes.set_xlabel(label)
            per = f"({unit})" if {*" /^"} & {*unit} else unit
            axes.set_ylabel(f"probability density [1/{per}]" if unit else "probability density")
        else:
            axes.fill_between(range(middle.size), low, high, color=colour, alpha=0.3, linewidth=0.0)
            axes.plot(middle, color=colour, linewidth=LINE_WIDTH_POINTS)
            axes.set_xlabel("number of the entry")
            axes.set_ylabel(label)
            axes.margins(x=0.0)
        axes.set_title("5 %, 50 % and 95 %", loc="left", fontsize=9)


def draw_shares(axes: "Axes", shares: Sobol, name: str, look: Theme, colour: str) -> None:
    """Draw the indices of an output: bars, or lines over the number of the entry."""
    style_axes(axes, look)
    order = shares.ranked(name)[:SHOWN]
    total = np.nan_to_num(shares.total[name])
    if total.ndim == 1:
        low, high = np.nan_to_num(shares.confidence_interval(name)[1])[:, order]
        places = np.arange(len(order))
        axes.barh(places, total[order], height=0.65, color=colour)
        axes.plot(np.nan_to_num(shares.first[name])[order], places, "|", color=look.ink, markersize=9)
        axes.hlines(places, low, high, color=look.ink, linewidth=0.8)
        axes.set_yticks(places, [shares.names[k] for k in order])
        axes.set_ylim(len(order) - 0.4, -0.6)
        axes.grid(False, axis="y")
        axes.set_xlabel("share of the variance [1]")
        axes.set_title("total index; stroke: first index", loc="left", fontsize=9)
        return
    for i, k in enumerate(order[: len(look.lines)]):
        axes.plot(total[k], color=look.colour(i), linewidth=LINE_WIDTH_POINTS, label=shares.names[k])
    axes.set_xlabel("number of the entry")
    axes.set_ylabel("total index [1]")
    axes.margins(x=0.0)
    axes.legend(frameon=False, fontsize=8, labelcolor=look.ink)


@checks_arguments
def uncertainty(
    study: Study | Callable[..., Mapping[str, np.ndarray]],
    distributions: Mapping[str, Any],
    count: int,
    *,
    seed: int = 0,
    correlation: Mapping[tuple[str, str], float] | None = None,
    executor: Any = None,
    progress: bool | None = None,
) -> Uncertainty:
    """Find how what is measured spreads when parameters are uncertain, and which of them cause it.

    Parameters
    ----------
    study : Study or callable
        What is run; its ledger, if it has one, keeps every run, and the same call goes on where it was interrupted. Or
        a function ``f(**columns)`` of arrays (n,) that returns arrays (n,) or (n, l) by name, e.g. a closed form.
    distributions : mapping
        Parameter -> its distribution, as in `samples`: ``("normal", mean, standard deviation)``, ``("uniform", least,
        greatest)``, ``("triangular", least, likeliest, greatest)``, (least, greatest), or a frozen one of
        `scipy.stats`. Others stay at ``study.x0``.
    count : int
        Points n of a set, a power of two. Of k parameters that takes n (k + 2) runs: percentiles come from 2 n of them,
        indices from all; these err by some 1 / sqrt(n), see `Sobol.confidence_interval`. Correlated: n runs.
    seed : int
        Of the points: the same seed gives the same ones.
    correlation : mapping
        (name, other) -> correlation of two parameters, as in `samples`; then there are no Sobol' indices.
    executor, progress
        As in `sweep`.

    Returns
    -------
    Uncertainty
        After Ctrl-C with the runs that had finished.

    Raises
    ------
    InputError
        For an unknown parameter or distribution, or a count that is no power of two.
    SweepError
        If the study's functions return something else, or no run succeeds.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, Study, System, uncertainty
    >>> def pendulum(length, mass):
    ...     bob = Body("bob", mass, (0.01, 0.01, 0.01), position=(length, 0, 0), omega=(0, 0, 0))
    ...     return System([bob], [Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")])
    >>> study = Study(pendulum, {"length": 0.7, "mass": 1.3}, lambda run: {"rate": run.rate("hinge")[-1]},
    ...               {"t_end": 0.3, "output": 2})
    >>> found = uncertainty(study, {"length": ("normal", 0.7, 0.01), "mass": ("triangular", 1.2, 1.3, 1.5)}, 64)
    >>> found.percentiles("rate").round(2), found.sobol.ranked("rate")
    (array([3.9 , 3.99, 4.07]), [0, 1])
    """
    n = whole(count, "uncertainty: count", 2)
    if n & (n - 1):
        raise InputError(f"uncertainty: count {n} is not a power of two; give 64, 128, 256, ...")
    seed = whole(seed, "uncertainty: seed", 0)
    points = points_of(distributions, n, seed, correlation)
    if len(points.points) > RUNS_MAX:
        raise InputError(f"uncertainty: {len(points.points)} runs; give a smaller count, for at most {RUNS_MAX}")
    if isinstance(study, Study):
        values, errors, stopped = runs_of(study, points, executor, progress)
        units = study.units
    elif callable(study):
        values, errors, stopped, units = columns_of(study, points), (), "", {}
    else:
        raise InputError(f"uncertainty: study {short_repr(study)}; give a Study, or a function of columns")
    own = points.points.shape[0] if correlation else 2 * n
    shares = None if correlation else shares_of(points.names, values, n, seed)
    first = Samples(points.names, points.points[:own])
    return Uncertainty(first, {name: x[:own] for name, x in values.items()}, shares, units, errors, stopped)


def points_of(
    distributions: Mapping[str, Any], n: int, seed: int, correlation: Mapping[tuple[str, str], float] | None
) -> Samples:
    """Return the points A (n, k), B (n, k), and A with each column of B in turn; of correlated parameters A alone."""
    from scipy.stats import qmc

    if not isinstance(distributions, Mapping):
        raise InputError(f"uncertainty: distributions {short_repr(distributions)}; give a mapping of names to them")
    check_names(tuple(distributions))
    if correlation is not None and not isinstance(correlation, Mapping):
        raise InputError(f"uncertainty: correlation {short_repr(correlation)}; give a mapping of (name, other) to it")
    if correlation:
        return samples(distributions, n, seed=seed, correlation=correlation)
    k = len(distributions)
    unit = qmc.Sobol(2 * k, rng=seed, bits=64).random(n).reshape(n, 2, k)
    A, B = np.empty((n, k)), np.empty((n, k))
    for j, (name, values) in enumerate(distributions.items()):
        one = distribution_of(name, values, "uncertainty")
        A[:, j], B[:, j] = one.ppf(unit[:, 0, j]), one.ppf(unit[:, 1, j])
    mixed = np.tile(A, (k, 1, 1))
    mixed[np.arange(k), :, np.arange(k)] = B.T
    return Samples(tuple(distributions), np.concatenate([A, B, mixed.reshape(-1, k)]))


def shares_of(names: tuple[str, ...], values: Mapping[str, np.ndarray], n: int, seed: int) -> Sobol:
    """Return the indices of outputs at the points of `points_of`."""
    runs = {name: (x[:n], x[n : 2 * n], x[2 * n :].reshape(len(names), n, *x.shape[1:])) for name, x in values.items()}
    found = {name: estimates(given, np.ones((1, n)))[0] for name, given in runs.items()}
    first, total = ({name: x[kind] for name, x in found.items()} for kind in (0, 1))
    return Sobol(names, first, total, runs, seed)


def columns_of(function: Callable[..., Mapping[str, np.ndarray]], points: Samples) -> dict[str, np.ndarray]:
    """Return what a function of columns gives at all points."""
    found = function(**dict(zip(points.names, points.points.T, strict=True)))
    if not isinstance(found, Mapping) or not found:
        raise InputError(f"uncertainty: the function returned {short_repr(found)}; return arrays by name")
    values = {str(name): np.array(x, float) for name, x in found.items()}
    for name, x in values.items():
        if x.ndim not in (1, 2) or len(x) != len(points.points):
            raise InputError(
                f"uncertainty: '{name}' has shape {x.shape}; return {len(points.points)} values, one for each point"
            )
    return values


def runs_of(
    study: Study, points: Samples, executor: Any, progress: bool | None
) -> tuple[dict[str, np.ndarray], tuple[str, ...], str]:
    """Return what a study measures at all points, the errors of runs, and why some are missing."""
    unknown = [name for name in points.names if name not in study.names]
    if unknown:
        raise InputError(f"uncertainty: study has no parameter '{unknown[0]}'; it has {', '.join(study.names)}")
    whole_points = np.tile(study.point(None), (len(points.points), 1))
    whole_points[:, [study.names.index(name) for name in points.names]] = points.points
    grid = make_grid(Samples(study.names, whole_points))
    check_executor(executor, study.functions)
    results: dict[int, Outcome] = {}
    title = f"uncertainty: {len(grid.cells)} runs"
    book = study.cells(whole_points)
    try:
        with one_thread(), Progress(title, 0, len(grid.cells), progress) as bar:
            trouble = collect(study.experiment, grid, executor, book, results, {}, bar)
    finally:
        if book is not None:
            book.close()
    if trouble is not None:
        raise trouble
    good = {cell: outcome.values for cell, outcome in results.items() if not outcome.error}
    errors = tuple(f"{grid.title(cell)}: {results[cell].error}" for cell in sorted(results) if results[cell].error)
    if not good and errors:
        raise SweepError(f"uncertainty: no run succeeded; the first: {errors[0]}", advice="correct the model or ranges")
    values = {}
    for name, value in good[min(good)].items() if good else ():
        values[name] = np.full((len(grid.cells), *np.shape(value)), np.nan)
        for cell, given in good.items():
            values[name][cell] = given[name]
    stopped = f"stopped after {len(results)} of {len(grid.cells)} runs" if len(results) < len(grid.cells) else ""
    return values, errors, stopped
