"""Tables of a mechanism over the parameters that a reader moves: sums of products of Chebyshev polynomials.

Each number of the tables is a smooth function of the parameters, most of them constant or of first degree. They are
taken at the nodes of a grid; what their polynomials miss is measured at other points, and a slider that fails is
refused.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from ...base.checks import number
from ...base.errors import InputError
from ...base.rotations import Carried
from ...constraints.assembly import reference_state
from ...mechanism.mechanism import Mechanism
from ...mechanism.state import State
from .lowered import Tables, lowered

DEGREE_MAX = 32  # of the polynomial of a number of the tables along one parameter
GRID_MAX = 4000  # [1] mechanisms that are built for the grid
TABLE_ERROR_MAX = 1e-9  # [1] of the size of a number of the tables
START_SIZE_MIN = 1e-3  # [rad, m] of an angle or a slide at the start
ROUNDING = 1e-13  # [1] of the size of a number: what is less is no dependence
CHECKS_COUNT = 12  # [points] at which polynomials are compared with what they stand for
GENERIC_SHARE = 0.37  # [1] of a range: where the others stand while the degree along one parameter is found

Build = Callable[..., Mechanism | tuple[Mechanism, State]]  # (**values) -> the mechanism, and where it starts
Values = dict[str, float]


@dataclass(frozen=True)
class Slider:
    """Parameter that a reader moves between two values; ``start`` is that of the run on the page.

    Examples
    --------
    >>> Slider("spin", 100.0, 300.0, 237.0, unit="rad/s").text
    'spin'
    """

    name: str
    low: float
    high: float
    start: float
    label: str = ""
    unit: str = ""
    logarithmic: bool = False  # equal ways along it are equal ratios

    def __post_init__(self) -> None:
        low, high, start = (number(getattr(self, x), f"slider '{self.name}': {x}") for x in ("low", "high", "start"))
        if self.logarithmic and low <= 0.0:
            raise InputError(f"slider '{self.name}': low = {low:g}; a logarithmic one needs values > 0")
        if not low <= start <= high or not low < high:
            raise InputError(
                f"slider '{self.name}': {low:g} <= {start:g} <= {high:g} does not hold; give a range around it"
            )

    @property
    def text(self) -> str:
        """Return the words beside it."""
        return self.label or self.name.removesuffix("_deg").replace("_", " ")

    def at(self, x: float) -> float:
        """Return the value at a place from -1 to 1."""
        if self.logarithmic:
            return math.sqrt(self.low * self.high) * math.sqrt(self.high / self.low) ** x
        return 0.5 * (self.low + self.high) + 0.5 * (self.high - self.low) * x


def tables_over(build: Build, sliders: Sequence[Slider]) -> dict[str, Any]:
    """Return the tables at the start of the sliders, and the polynomials of the numbers that depend on them.

    ``build`` takes the values of the sliders by name.

    Raises
    ------
    ValueError
        If a part is not known to the solver of a page, the structure changes within a range, or a number jumps there.
    """
    start, carried = {x.name: x.start for x in sliders}, Carried()
    tables_at(build, start)  # what is made only once is made before perpendiculars are counted
    with carried.again():
        first = tables_at(build, start)
    structure, paths, values = flat(first)
    owners = [path.rpartition(".")[0] for path in paths]

    def numbers(given: Values) -> np.ndarray:
        with carried.again():
            other, _, found = flat(aligned(tables_at(build, given), first))
        if other != structure:
            raise InputError(f"sliders: with {shown(given)} the tables have another structure; shorten the range")
        return found

    found, error = fitted(numbers, sliders, sizes_of(owners)) if sliders else (np.zeros((0,)), np.zeros(1))
    if not (worst := error.max()) <= TABLE_ERROR_MAX:
        jump = paths[int(error.argmax())]
        raise InputError(
            f"sliders {[x.name for x in sliders]}: the tables jump within these ranges (error {worst:.1e} of {jump}); "
            "shorten them"
        )
    return {"tables": first, "varying": varying(paths, values, found, len(sliders))}


def tables_at(build: Build, values: Values) -> Tables:
    """Return the tables of the mechanism with these values, at its start."""
    return lowered(*built(build, values))


def built(build: Build, values: Values) -> tuple[Mechanism, State]:
    """Return the mechanism with these values, and the state at which it starts: that of its pose of reference, unless
    ``build`` gives one."""
    made = build(**values)
    return made if isinstance(made, tuple) else (made, reference_state(made, None))


def shown(values: Mapping[str, float]) -> str:
    """Return values in words."""
    return ", ".join(f"{name} = {value:g}" for name, value in values.items())


def aligned(tables: Tables, first: Tables) -> Tables:
    """Return tables with the quaternions at the start on the sheet of the first ones, and with the first length, which
    is a unit of errors.
    """
    q, known = (np.array(x["start"]["q"]).reshape(-1, 7) for x in (tables, first))
    q[:, 3:] *= np.where((q[:, 3:] * known[:, 3:]).sum(axis=1) < 0.0, -1.0, 1.0)[:, None]
    rows = [{**row, "scale": other["scale"]} for row, other in zip(tables["row"], first["row"], strict=False)]
    start = {**tables["start"], "q": q.ravel().tolist()}
    return {**tables, "start": start, "row": rows, "length": first["length"]}


def flat(tables: Tables) -> tuple[list[Any], list[str], np.ndarray]:
    """Return (what is no float, with its path; paths of the floats, as "body.0.mass"; the floats)."""
    rest: list[Any] = []
    paths: list[str] = []
    values: list[float] = []

    def walk(item: Any, path: str) -> None:
        if isinstance(item, dict | list):
            for key, inner in item.items() if isinstance(item, dict) else enumerate(item):
                walk(inner, f"{path}.{key}" if path else str(key))
        elif isinstance(item, float):
            paths.append(path)
            values.append(item)
        else:
            rest.append((path, item))

    walk(tables, "")
    return rest, paths, np.array(values)


def sizes_of(owners: Sequence[str]) -> Callable[[np.ndarray], np.ndarray]:
    """Return a function that gives the size of each number: the largest one of its list, as of the components of an
    axis; of angles and slides at the start at least a thousandth of a radian or a metre."""
    names, group = np.unique(owners, return_inverse=True)
    least = np.array([START_SIZE_MIN if name.startswith("coordinate.") else 0.0 for name in names])

    def sizes(samples: np.ndarray) -> np.ndarray:
        largest = least.copy()
        np.maximum.at(largest, group, np.abs(samples).reshape(-1, group.size).max(axis=0))
        return largest[group]

    return sizes


def fitted(
    function: Callable[[Values], np.ndarray], sliders: Sequence[Slider],
    sizes: Callable[[np.ndarray], np.ndarray], degrees: Sequence[int] = (4, 12, DEGREE_MAX), least: float = ROUNDING,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return coefficients (d_1, ..., d_k, numbers) of a function of the sliders in products of Chebyshev polynomials,
    and by how much of their size they miss each number at other points.

    ``degrees``: that are tried along each slider until the last coefficients vanish; ``least``: what is none.
    """
    names = [x.name for x in sliders]

    def at(places: Sequence[float]) -> np.ndarray:
        return function({x.name: x.at(place) for x, place in zip(sliders, places, strict=True)})

    counts = [degree_along(at, k, len(sliders), sizes, degrees, least) + 1 for k in range(len(sliders))]
    if math.prod(counts) > GRID_MAX:
        raise InputError(f"sliders {names}: {math.prod(counts)} mechanisms would have to be built; give fewer sliders")
    axes = [nodes(count) for count in counts]
    grid = np.array([at(places) for places in product(*axes)]).reshape(*counts, -1)
    size = sizes(grid) + 1e-300
    for k, count in enumerate(counts):
        grid = np.moveaxis(np.tensordot(inverse(count), grid, axes=(1, k)), 0, k)
    found = np.where(np.abs(grid) > least * size, grid, 0.0)
    checks = np.random.default_rng(1).uniform(-1.0, 1.0, (CHECKS_COUNT, len(sliders)))
    errors = [np.abs(value_of(found, places) - at(places)) / size for places in checks]
    return found, np.where(np.isfinite(errors), errors, np.inf).max(axis=0)


def degree_along(
    at: Callable[[Sequence[float]], np.ndarray], k: int, count: int, sizes: Callable[[np.ndarray], np.ndarray],
    degrees: Sequence[int], least: float,
) -> int:  # fmt: skip
    """Return the degree that a function needs along slider ``k``, the others off their middle."""
    for degree in degrees:
        places = [[x if i == k else GENERIC_SHARE for i in range(count)] for x in nodes(degree + 1)]
        samples = np.array([at(x) for x in places])
        found = np.abs(inverse(degree + 1) @ samples) > least * sizes(samples)
        last = int(np.flatnonzero(found.any(axis=1)).max(initial=0))
        if last < degree - 1:
            return last
    return degrees[-1]


def nodes(count: int) -> np.ndarray:
    """Return the Chebyshev points of a polynomial of so many coefficients, from -1 to 1."""
    return -np.cos(np.pi * (np.arange(count) + 0.5) / count)


def inverse(count: int) -> np.ndarray:
    """Return the matrix that takes values at the nodes to coefficients."""
    return np.linalg.inv(np.polynomial.chebyshev.chebvander(nodes(count), count - 1))


def value_of(coefficients: np.ndarray, places: Sequence[float]) -> np.ndarray:
    """Return the sums of products at places from -1 to 1."""
    for place in places:
        ladder = np.polynomial.chebyshev.chebvander(np.array([place]), coefficients.shape[0] - 1)[0]
        coefficients = np.tensordot(ladder, coefficients, axes=(0, 0))
    return coefficients


def varying(paths: Sequence[str], values: np.ndarray, found: np.ndarray, count: int) -> list[dict[str, Any]]:
    """Return path and terms (degrees, then the coefficient, side by side) of the numbers that are not constant."""
    if not count:
        return []
    lines = []
    for j in np.flatnonzero((found.reshape(-1, len(paths))[1:] != 0.0).any(axis=0)).tolist():
        terms = [
            x
            for place in zip(*np.nonzero(found[..., j]), strict=True)
            for x in (*map(int, place), float(found[*place, j]))
        ]
        lines.append({"path": paths[j], "terms": terms})
    return lines
