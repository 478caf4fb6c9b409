"""`sweep`: one mechanism over a grid of parameters, in parallel, into one table."""

import time
from collections.abc import Callable, Mapping
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.checks import short_repr
from ..base.concurrency import one_thread
from ..base.errors import InputError, SweepError, checks_arguments
from ..base.paths import package_version
from ..base.progress import Progress
from ..base.wording import counted
from .executors import check_executor, outcomes
from .experiment import Experiment, MisuseError, Outcome, check_parameters, check_settings
from .grids import Grid, Samples, make_grid
from .store import Ledger, LedgerError, PointCells, identity

if TYPE_CHECKING:
    from xarray import Dataset


@checks_arguments
def sweep(
    build: Callable[..., Any],
    grid: Mapping[str, Any] | Samples,
    measure: Callable[[Any], Any],
    *,
    run: Mapping[str, Any] | Callable[..., Mapping[str, Any]] | None = None,
    executor: Any = None,
    ledger: str | Path | None = None,
    tag: str = "",
    units: Mapping[str, str] | None = None,
    progress: bool | None = None,
) -> "Dataset":
    """Build, simulate and measure a mechanism at every point of a grid.

    Parameters
    ----------
    build : callable
        ``build(**parameters)`` returns a System, or (System, dict of arguments of `simulate` for this cell).
    grid : mapping or Samples
        Parameter -> values: every combination is a cell. Or points from `samples` (or ``Samples(names, points)``).
    measure : callable
        ``measure(solution)`` returns a number, a 1-D array of numbers, or a dict of them by name.
    run : mapping or callable
        Arguments of `simulate` (t_end, method, rtol, output ...), or ``run(**parameters)`` that returns them.
    executor : None, "threads", "processes", concurrent.futures.Executor or distributed.Client
        None = threads on all cores: the kernels run side by side. "processes": own processes; a cell that kills one is
        tried once more, alone, and recorded if it does so again.
    ledger : path or None
        SQLite file that keeps every finished cell; the same sweep with the same ledger goes on where it stopped. Cells
        that failed are tried again.
    tag : str
        Part of the identity of the sweep, e.g. a version of ``build``: the code of functions is not compared.
    units : mapping
        Parameter or measure -> unit, for the dataset.
    progress : bool or None
        Show a bar with the time that remains; None = on a terminal, after two seconds.

    Returns
    -------
    xarray.Dataset
        Dimensions: the parameters ("sample" for samples), and ``<name>_index`` for an array. Variables: the measures
        (NaN where a cell failed) and ``error`` (type and message, empty where it did not). The numbers do not depend
        on the executor. After Ctrl-C: the finished cells, and ``attrs["stopped_by"]``.

    Raises
    ------
    ValueError
        Before anything runs: empty or non-finite values, parameters that ``build`` does not take, an unknown argument
        of `simulate`, a ledger of another sweep or one that cannot be opened.
    SweepError
        If ``build`` or ``measure`` return something else, or the ledger can no longer be written;
        ``error.dataset`` holds the finished cells.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, System, TorsionSpring
    >>> def pendulum(length, stiffness):
    ...     bob = Body("bob", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(0, 0, -length), omega=(0, 0.1, 0))
    ...     hinge = Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, 1, 0))
    ...     return System([bob], [hinge], [TorsionSpring(hinge, stiffness=stiffness)])
    >>> def swing(solution):
    ...     return {"largest": solution.angle("Revolute 1").max()}
    >>> table = sweep(pendulum, {"length": [1.0, 2.0], "stiffness": [0.0, 1.0, 2.0]}, swing, run={"t_end": 2.0})
    >>> table["largest"].dims, table["largest"].shape, int((table["error"] != "").sum())
    (('length', 'stiffness'), (2, 3), 0)

    Sensitivities by `scipy.stats.sobol_indices`, which makes the points itself:

    >>> from scipy.stats import sobol_indices, uniform
    >>> def largest(x):
    ...     points = Samples(("length", "stiffness"), x.T)
    ...     return sweep(pendulum, points, swing, run={"t_end": 2.0})["largest"].values
    >>> found = sobol_indices(func=largest, n=8, dists=[uniform(1, 1), uniform(0, 2)], rng=1)
    >>> found.first_order.shape
    (2,)
    """
    import xarray  # noqa: F401  # half a second, which nobody waits for after Ctrl-C

    began = time.perf_counter()
    cells, experiment = make_grid(grid), Experiment(build, measure, {} if run is None else run)
    check(experiment, cells, executor, units, tag)
    book = None if ledger is None else Ledger(ledger, identity(experiment, cells, tag), len(cells.cells))
    results: dict[int, Outcome] = {}
    try:
        with (
            one_thread(),
            Progress(f"sweep of {counted(len(cells.cells), 'cell')}", 0, len(cells.cells), progress) as bar,
        ):
            trouble = collect(experiment, cells, executor, book, results, units or {}, bar)
    finally:
        if book is not None:
            book.close()
    attrs = {"seconds": time.perf_counter() - began, "tag": tag, "mbsd3d_version": package_version()}
    table = dataset(cells, results, units or {}, attrs)
    if isinstance(trouble, SweepError):
        trouble.dataset = table
        raise trouble
    return table


def check(experiment: Experiment, grid: Grid, executor: Any, units: Mapping[str, str] | None, tag: str) -> None:
    """Check everything before a cell runs."""
    run = experiment.run
    check_parameters(experiment.build, "build", grid.cells[0])
    if callable(run):
        check_parameters(run, "run", grid.cells[0])
    elif isinstance(run, Mapping):
        try:
            check_settings(run)
        except MisuseError as error:
            raise InputError(f"sweep: {error}") from None
    else:
        raise InputError(f"sweep: run {short_repr(run)}; give a mapping of arguments of simulate, or a function")
    if not callable(experiment.measure):
        raise InputError(f"sweep: measure {short_repr(experiment.measure)} is not a function; give one of a solution")
    if not isinstance(tag, str):
        raise InputError(f"sweep: tag {short_repr(tag)}; give a text")
    if units is not None and not isinstance(units, Mapping):
        raise InputError(f"sweep: units {short_repr(units)}; give a mapping of names to units")
    functions = [experiment.build, experiment.measure, *([run] if callable(run) else [])]
    check_executor(executor, functions)


def collect(
    experiment: Experiment,
    grid: Grid,
    executor: Any,
    book: Ledger | PointCells | None,
    results: dict[int, Outcome],
    units: Mapping[str, str],
    bar: Progress,
) -> SweepError | None:
    """Fill ``results``; return the error that stopped the sweep early, if any."""
    if book is not None:
        results.update(book.finished())
    todo = [cell for cell in range(len(grid.cells)) if cell not in results]
    first: tuple[int, Outcome] | None = min(results.items(), default=None)
    try:
        with closing(outcomes(experiment, grid.cells, todo, executor)) as arriving:
            for cell, outcome in arriving:
                first = agree(grid, units, first, cell, outcome)
                results[cell] = outcome
                if book is not None:
                    book.keep(cell, outcome)
                bar.update(len(results))
    except KeyboardInterrupt:
        return None
    except LedgerError as error:
        return SweepError(str(error))
    except SweepError as error:
        return error
    except Exception as error:  # an executor may fail as it likes: what has finished is kept
        trouble = SweepError(f"the executor failed, {type(error).__name__}: {error}", advice="give another executor")
        trouble.__cause__ = error
        return trouble
    return None


def agree(
    grid: Grid, units: Mapping[str, str], first: tuple[int, Outcome] | None, cell: int, outcome: Outcome
) -> tuple[int, Outcome] | None:
    """Return the cell that others are compared with; raise SweepError where a cell does not fit the others."""
    if outcome.misuse:
        raise SweepError(f"sweep: {grid.title(cell)}: {outcome.error}")
    if outcome.error:
        return first
    if first is None:
        check_names(grid, units, cell, outcome)
        return cell, outcome
    if shapes(first[1]) != shapes(outcome):
        raise SweepError(
            f"sweep: measure returned {shapes(first[1])} in {grid.title(first[0])}, but {shapes(outcome)} in "
            f"{grid.title(cell)}",
            advice="return the same names and lengths everywhere, e.g. with run=dict(output=count)",
        )
    return first


def check_names(grid: Grid, units: Mapping[str, str], cell: int, outcome: Outcome) -> None:
    """Raise SweepError for measures named like parameters, or units of unknown names."""
    indices = {f"{name}_index" for name, length in shapes(outcome).items() if length is not None}
    taken = sorted({*outcome.values, *indices} & {*grid.columns, *grid.dims} | outcome.values.keys() & indices)
    if taken:
        raise SweepError(
            f"sweep: {grid.title(cell)}: measure returned a value named '{taken[0]}', as a parameter or the index "
            "of an array is",
            advice="give it another name",
        )
    unknown = sorted(units.keys() - outcome.values.keys() - grid.columns.keys())
    if unknown:
        known = ", ".join([*grid.columns, *outcome.values])
        raise SweepError(f"sweep: units of '{unknown[0]}': give one of {known}", advice="correct the name")


def shapes(outcome: Outcome) -> dict[str, int | None]:
    """Return the length of each value, None for a single number."""
    return {name: len(value) if isinstance(value, list) else None for name, value in outcome.values.items()}


def dataset(grid: Grid, results: dict[int, Outcome], units: Mapping[str, str], attrs: dict[str, Any]) -> "Dataset":
    """Return the table; cells that failed or did not run are NaN, with the reason in ``error``."""
    import xarray

    count = len(grid.cells)
    good = {cell: outcome for cell, outcome in results.items() if not outcome.error}
    errors = [results[cell].error if cell in results else "not run" for cell in range(count)]
    unit_of = {name: {"units": unit} for name, unit in units.items()}
    variables: dict[str, Any] = {"error": (grid.dims, np.array(errors, dtype=str).reshape(grid.shape), {})}
    for name, length in shapes(good[min(good)]).items() if good else ():
        whole = np.full((count,) if length is None else (count, length), np.nan)
        for cell, outcome in good.items():
            whole[cell] = outcome.values[name]
        extra = () if length is None else (f"{name}_index",)
        shape = (*grid.shape, *whole.shape[1:])
        variables[name] = ((*grid.dims, *extra), whole.reshape(shape), unit_of.get(name, {}))
    coordinates = {name: (dim, values, unit_of.get(name, {})) for name, (dim, values) in grid.columns.items()}
    attrs = attrs | {
        "cells": count,
        "failed": sum(bool(outcome.error) for outcome in results.values()),
        "runs": "; ".join(sorted({outcome.settings for outcome in good.values()})),
        "stopped_by": f"stopped after {len(results)} of {count} cells" if len(results) < count else "",
    }
    return xarray.Dataset(variables, coordinates, attrs)
