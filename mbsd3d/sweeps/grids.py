"""Cells of a sweep: a full factorial grid of named values, or points sampled from named ranges or distributions."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import as_tuple, check_choice, number, numbers, short_repr
from ..base.errors import InputError, checks_arguments
from ..base.fields import Array, Checked, Stored, kept, locked, part_class
from ..base.style import Told
from ..base.wording import counted

SAMPLING_METHODS = ("sobol", "latin hypercube", "random")
NAMED = {  # distributions by name, with what their numbers mean
    "normal": ("mean", "standard deviation"),
    "uniform": ("least", "greatest"),
    "triangular": ("least", "likeliest", "greatest"),
}
POINTS_MAX = 10_000_000  # [1] points of a sample


def as_names(value: Any, what: str, part: Any) -> tuple[str, ...]:
    """Convert to names of parameters."""
    return as_tuple(value, what, "a tuple of names")


def as_points(value: Any, what: str, part: Any) -> np.ndarray:
    """Convert to a new array of numbers."""
    return locked(numbers(value, what).copy())


class Names(Stored[Sequence[str], tuple[str, ...]]):
    """Names of parameters."""

    accepts, file_type = "Sequence[str]", list[str]
    convert = staticmethod(as_names)


@part_class()
class Samples(Checked, Told):
    """Points (count, k) of k named parameters, in their units: one cell of a sweep per row.

    ValueError if the shape does not fit the names, or a number is not finite.

    >>> Samples(("bend", "rate"), [[0.1, 8.0], [0.4, 12.0]]).points.shape
    (2, 2)
    """

    names: Names = kept()
    points: Array = kept(by=as_points)

    def __repr__(self) -> str:
        return f"<samples: {counted(len(self.points), 'point')} of {', '.join(self.names)}>"

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
def samples(
    ranges: Mapping[str, Any],
    count: int,
    *,
    method: str = "sobol",
    seed: int = 0,
    correlation: Mapping[tuple[str, str], float] | None = None,
) -> Samples:
    """Sample points over named ranges for `sweep`, the same for the same seed; its dataset has the dimension "sample".

    ``ranges``: name -> (least, greatest) value of the parameter, or its distribution: ``("normal", mean, standard
    deviation)``, ``("uniform", least, greatest)``, ``("triangular", least, likeliest, greatest)``, or a frozen one of
    `scipy.stats`. ``count``: number of points; a power of two for "sobol", whose points are even only then.
    ``method``: "sobol" (scrambled Sobol sequence), "latin hypercube" or "random"; see `scipy.stats.qmc`.
    ``correlation``: (name, other) -> -1 < rho < 1 of two parameters, others are independent: that of the normal
    variables z whose probabilities ``F_i(x_i) = Phi(z_i)`` are, which of normal parameters is their own.
    ValueError for an empty range, an unknown method, another count, or correlations that no variables have.

    >>> points = samples({"bend": (0.1, 0.5), "rate": (5.0, 10.0)}, 4, seed=3).points
    >>> bool((points.min(axis=0) >= (0.1, 5.0)).all() and (points.max(axis=0) <= (0.5, 10.0)).all())
    True
    >>> made = {"mass": ("normal", 3.0, 0.1), "load": ("triangular", 0.0, 0.2, 1.0)}
    >>> masses = samples(made, 256, correlation={("mass", "load"): 0.6}).points
    >>> masses[:, 0].mean().round(2)  # of a sweep: dataset.quantile([0.05, 0.95], "sample")
    np.float64(3.0)
    """
    from scipy.stats import norm, qmc

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
    marginals = [distribution_of(name, values, "samples") for name, values in ranges.items()]
    root = root_of_correlation(tuple(ranges), {} if correlation is None else correlation)
    if method == "random":
        unit = np.random.default_rng(seed).random((count, len(marginals)))
    else:
        kind = qmc.Sobol if method == "sobol" else qmc.LatinHypercube
        unit = kind(len(marginals), rng=seed).random(count)
    if correlation:
        unit = norm.cdf(norm.ppf(unit) @ root.T)
    return Samples(tuple(ranges), np.column_stack([one.ppf(unit[:, i]) for i, one in enumerate(marginals)]))


def distribution_of(name: str, values: Any, caller: str) -> Any:
    """Return the distribution of a parameter with its inverse ``ppf``: probability -> value."""
    from scipy.stats import norm, triang, uniform

    if callable(getattr(values, "ppf", None)):
        return values
    kind, found = named_numbers(name, values, caller)
    if kind == "normal":
        if not found[1] > 0.0:
            raise InputError(f"{caller}: standard deviation {found[1]:g} of '{name}'; give a number > 0")
        return norm(*found)
    low, likeliest, high = found[0], found[-2], found[-1]
    if not (low < high and low <= likeliest <= high):
        shown = " ... ".join(f"{x:g}" for x in found)
        order = ", ".join(NAMED[kind])
        raise InputError(f"{caller}: range of '{name}' is empty, {shown}; give ({order}) in this order")
    return uniform(low, high - low) if kind == "uniform" else triang((likeliest - low) / (high - low), low, high - low)


def named_numbers(name: str, values: Any, caller: str) -> tuple[str, list[float]]:
    """Return the name of a distribution and its numbers; two numbers alone are those of "uniform"."""
    kind, given = "uniform", list(values) if isinstance(values, list | tuple | np.ndarray) else []
    if given and isinstance(given[0], str):
        kind, *given = given
        check_choice(kind, tuple(NAMED), f"{caller}: distribution of '{name}'")
    if len(given) != len(NAMED[kind]):
        forms = ", ".join(f"({', '.join([repr(key), *words])})" for key, words in NAMED.items())
        raise InputError(
            f"{caller}: range {short_repr(values)} of '{name}'; give (least, greatest), {forms} or a distribution of "
            "scipy.stats"
        )
    return kind, [number(x, f"{caller}: {what} '{name}'") for x, what in zip(given, NAMED[kind], strict=True)]


def root_of_correlation(names: tuple[str, ...], given: Mapping[tuple[str, str], float]) -> np.ndarray:
    """Return L of the matrix L L' of the correlations of named parameters."""
    if not isinstance(given, Mapping):
        raise InputError(f"samples: correlation {short_repr(given)}; give a mapping of (name, other) to a number")
    matrix = np.eye(len(names))
    for pair, value in given.items():
        if not isinstance(pair, tuple) or len(pair) != 2 or pair[0] == pair[1] or not {*pair} <= {*names}:
            raise InputError(f"samples: correlation of {short_repr(pair)}; give two of {', '.join(names)}")
        i, j = map(names.index, pair)
        matrix[i, j] = matrix[j, i] = number(value, f"samples: correlation of {pair[0]} and {pair[1]}")
    try:
        return np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        raise InputError(
            f"samples: correlation {short_repr(dict(given))} is that of no variables; give smaller numbers"
        ) from None


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
