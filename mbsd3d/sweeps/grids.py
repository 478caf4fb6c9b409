"""Cells of a sweep: a full factorial grid of named values, or points sampled from named ranges."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import as_tuple, check_choice, number, numbers, short_repr
from ..base.errors import InputError, checks_arguments
from ..base.fields import Array, Checked, Stored, kept, locked, part_class

SAMPLING_METHODS = ("sobol", "latin hypercube", "random")
POINTS_MAX = 10_000_000  # [1] points of a sample


def as_names(value: Any, what: str, part: Any) -> tuple[str, ...]:
    """Names of parameters."""
    return as_tuple(value, what, "a tuple of names")


def as_points(value: Any, what: str, part: Any) -> np.ndarray:
    """An own array of numbers."""
    return locked(numbers(value, what).copy())


class Names(Stored[Sequence[str], tuple[str, ...]]):
    """Names of parameters."""

    accepts, file_type = "Sequence[str]", list[str]
    convert = staticmethod(as_names)


@part_class()
class Samples(Checked):
    """Points (count, k) of k named parameters, in their units: one cell of a sweep per row.

    ValueError if the shape does not fit the names, or a number is not finite.

    >>> Samples(("bend", "rate"), [[0.1, 8.0], [0.4, 12.0]]).points.shape
    (2, 2)
    """

    names: Names = kept()
    points: Array = kept(by=as_points)

    def check(self, what: str) -> None:
        names, points = self.names, self.points
        if points.ndim != 2 or points.shape[1] != len(names) or not points.size:
            raise InputError(
                f"Samples: points have shape {points.shape}; give (count, {len(names)}), names {short_repr(names)}"
            )
        check_names(names)
        bad = np.argwhere(~np.isfinite(points))
        if bad.size:
            raise InputError(f"Samples: '{names[bad[0, 1]]}' of point {bad[0, 0]} is not finite; give finite numbers")


@checks_arguments
def samples(ranges: Mapping[str, tuple[float, float]], count: int, *, method: str = "sobol", seed: int = 0) -> Samples:
    """Sample points over named ranges for `sweep`, the same for the same seed; its dataset has the dimension "sample".

    ``ranges``: name -> (least, greatest) value of the parameter. ``count``: number of points; a power of two for
    "sobol", whose points are even only then. ``method``: "sobol" (scrambled Sobol sequence), "latin hypercube" or
    "random"; see `scipy.stats.qmc`. ValueError for an empty range, an unknown method, or another count.

    >>> points = samples({"bend": (0.1, 0.5), "rate": (5.0, 10.0)}, 4, seed=3).points
    >>> bool((points.min(axis=0) >= (0.1, 5.0)).all() and (points.max(axis=0) <= (0.5, 10.0)).all())
    True
    """
    from scipy.stats import qmc

    if not isinstance(ranges, Mapping):
        raise InputError(f"samples: ranges {short_repr(ranges)}; give a mapping of names to (least, greatest)")
    check_choice(method, SAMPLING_METHODS, "samples: method")
    if not isinstance(count, int | np.integer) or isinstance(count, bool) or not 1 <= count <= POINTS_MAX:
        raise InputError(f"samples: count {short_repr(count)}; give a whole number of points, 1 ... {POINTS_MAX}")
    if method == "sobol" and count & (count - 1):
        raise InputError(f"samples: count {count} is not a power of two, which Sobol points need; give 2, 4, 8, ...")
    if not isinstance(seed, int | np.integer) or isinstance(seed, bool) or seed < 0:
        raise InputError(f"samples: seed {short_repr(seed)}; give a whole number >= 0")
    check_names(tuple(ranges))
    limits = np.array([check_range(name, values) for name, values in ranges.items()])
    if method == "random":
        unit = np.random.default_rng(seed).random((count, len(limits)))
    else:
        kind = qmc.Sobol if method == "sobol" else qmc.LatinHypercube
        unit = kind(len(limits), rng=seed).random(count)
    return Samples(tuple(ranges), limits[:, 0] + unit * (limits[:, 1] - limits[:, 0]))


def check_range(name: str, values: Any) -> tuple[float, float]:
    """Return (least, greatest) of a parameter."""
    try:
        low, high = values
    except (TypeError, ValueError):
        raise InputError(f"samples: range {short_repr(values)} of '{name}'; give (least, greatest)") from None
    low, high = number(low, f"samples: least '{name}'"), number(high, f"samples: greatest '{name}'")
    if not low < high:
        raise InputError(f"samples: range of '{name}' is empty, {low:g} ... {high:g}; give (least, greatest)")
    return low, high


def check_names(names: tuple) -> None:
    """Check that names of parameters are Python names, each once."""
    if not names:
        raise InputError("sweep: the grid is empty; give at least one parameter with its values")
    for name in names:
        if not isinstance(name, str) or not name.isidentifier():
            raise InputError(f"sweep: parameter {short_repr(name)}; give the name of a parameter of build")
        if name in ("error", "sample") or names.count(name) > 1:
            raise InputError(f"sweep: parameter '{name}' is taken; give every parameter a unique name")


@dataclass(frozen=True, eq=False)
class Grid:
    """Cells in a fixed order; the last dimension runs fastest."""

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    columns: dict[str, tuple[str, np.ndarray]]  # parameter -> (its dimension, its values)
    cells: list[dict[str, Any]]

    def title(self, cell: int) -> str:
        """Return number and parameters of a cell, for messages."""
        return f"cell {cell} ({', '.join(f'{name}={value!r}' for name, value in self.cells[cell].items())})"


def make_grid(grid: Mapping[str, ArrayLike] | Samples) -> Grid:
    """Return the cells of a mapping (every combination of its values) or of samples."""
    if isinstance(grid, Samples):
        columns = {name: ("sample", grid.points[:, i]) for i, name in enumerate(grid.names)}
        cells = [dict(zip(grid.names, point, strict=True)) for point in grid.points.tolist()]
        return Grid(("sample",), (len(cells),), columns, cells)
    if not isinstance(grid, Mapping):
        raise InputError(
            f"sweep: grid {short_repr(grid)}; give a mapping of parameter names to values, or samples(...)"
        )
    check_names(tuple(grid))
    values = {name: check_values(name, given) for name, given in grid.items()}
    lists = [array.tolist() for array in values.values()]
    cells = [dict(zip(values, point, strict=True)) for point in itertools.product(*lists)]
    shape = tuple(array.size for array in values.values())
    return Grid(tuple(values), shape, {name: (name, array) for name, array in values.items()}, cells)


def check_values(name: str, given: Any) -> np.ndarray:
    """Return numbers or texts, none twice, shape (k,)."""
    array = np.array(given)
    if array.ndim != 1 or array.dtype.kind not in "fiubU":
        raise InputError(f"sweep: '{name}': {short_repr(given)}; give a list of numbers or texts")
    if not array.size:
        raise InputError(f"sweep: '{name}' has no values; give at least one")
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        where = int(np.flatnonzero(~np.isfinite(array))[0])
        raise InputError(f"sweep: '{name}': value {where} is {array[where]}; give finite numbers")
    for value, stored in zip(given, array.tolist(), strict=True):
        if value != stored:
            raise InputError(f"sweep: '{name}': {short_repr(value)} would become {stored!r}; give one kind of values")
    if np.unique(array).size < array.size:
        raise InputError(f"sweep: '{name}': a value appears twice in {array.tolist()}; list every value once")
    return array
