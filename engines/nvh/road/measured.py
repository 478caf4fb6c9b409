"""Road given by its heights: a table of the user, from a file.

    x,left,right        or        x,z          [m], one line a point, in order, evenly spaced (up to half a step)

Behind its end the road goes on with its mirror image: so it repeats itself without a step, and no height is changed. Of
N points at x = k d, on a length of 2 L = 2 (N - 1) d,

    z(x) = sum_k a_k cos(2 pi n_k x),     n_k = k / (2 L)

The mean height is left out, and waves shorter than a tyre feels, as in the standard; `Measured.left_out` says how much.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.fft import dct

from engines.nvh.records import cell, table
from engines.nvh.road.profile import SPATIAL_FREQUENCY_MAX, summed
from mbsd3d.errors import InputError
from mbsd3d.extend import number

GAP_RATIO_MAX = 1.5  # [1] of the usual step; beyond it a point is missing
POINTS_MIN, LENGTH_MIN = 20, 5.0  # points; m
POINTS_MAX, LENGTH_MAX = 20_000, 5000.0  # what a car is driven over in minutes
STEP_HEIGHT_MAX = 0.5  # [m] from point to point, or [1] of slope: what wheels climb
HEADERS = ["x", "left", "right"], ["x", "z"]


@dataclass(frozen=True, eq=False)
class Measured:
    """Measured road: ``title``; ``x`` (n,): places [m]; ``z`` (2, n): heights of the left and the right track [m].

    ValueError for fewer than 20 points or more than 20 000, less than 5 m or more than 5 km, places that do not grow,
    a gap between them, or a step that no wheel climbs.

    >>> road = Measured("a bump", np.arange(0, 30, 0.1), np.tile(np.exp(-((np.arange(0, 30, 0.1) - 10) ** 2)), (2, 1)))
    >>> bool(abs(road.height(10.0, 0) - road.height(0.0, 0) - 1) < 1e-6)
    True
    """

    title: str
    x: np.ndarray
    z: np.ndarray

    def __post_init__(self) -> None:
        if not POINTS_MIN <= len(self.x) <= POINTS_MAX:
            raise InputError(f"road '{self.title}': {len(self.x)} points; give {POINTS_MIN} to {POINTS_MAX}")
        for name, values in (("x", self.x), ("left", self.z[0]), ("right", self.z[1])):
            for k, value in enumerate(values, start=1):
                number(value, f"road '{self.title}': {name} of point {k}")
        step = float(np.median(np.diff(self.x)))
        for k, (a, b) in enumerate(pairwise(self.x), start=1):
            if b <= a:
                raise InputError(
                    f"road '{self.title}': x goes from {a:g} to {b:g} m after point {k}; give places in order"
                )
            if b - a > GAP_RATIO_MAX * step:
                raise InputError(
                    f"road '{self.title}': a gap of {b - a:g} m after point {k}, x = {a:g} m; points stand {step:g} m "
                    "apart elsewhere; give the heights between"
                )
        rise = np.abs(np.diff(self.z)).max(axis=0)
        steep = np.flatnonzero(rise > np.maximum(STEP_HEIGHT_MAX, STEP_HEIGHT_MAX * np.diff(self.x)))
        if steep.size:
            k = steep[0]
            raise InputError(
                f"road '{self.title}': a step of {rise[k]:.4g} m after point {k + 1}, x = {self.x[k]:g} m; give "
                f"heights in m, from point to point {STEP_HEIGHT_MAX:g} m or less"
            )
        if not LENGTH_MIN <= self.x[-1] - self.x[0] <= LENGTH_MAX:
            raise InputError(
                f"road '{self.title}': {self.x[-1] - self.x[0]:g} m long; give {LENGTH_MIN:g} to {LENGTH_MAX:g} m"
            )

    @property
    def length(self) -> float:
        """Return the length after which the road repeats itself, with its mirror image [m]."""
        return 2 * float(self.x[-1] - self.x[0])

    @cached_property
    def parts(self) -> np.ndarray:
        """Return the coefficients a_k of both tracks [m]; uneven points are joined by straight lines; shape (2, n)."""
        even = np.linspace(self.x[0], self.x[-1], self.x.size)
        values = [np.interp(even, self.x, side) for side in self.z]
        found = dct(values, type=1) / (self.x.size - 1)
        found[:, [0, -1]] /= 2
        return found

    @cached_property
    def waves(self) -> np.ndarray:
        """Return the spatial frequencies n_k in use [1/m], shape (k,)."""
        n = np.arange(1, self.x.size) / self.length
        return n[n <= SPATIAL_FREQUENCY_MAX]

    @cached_property
    def amplitudes(self) -> np.ndarray:
        """Return the complex amplitudes of z = Re sum c_k exp(2 pi i n_k (x - x_1)) of left and right track [m], shape
        (2, k).
        """
        return self.parts[:, 1 : self.waves.size + 1] + 0j

    @property
    def left_out(self) -> float:
        """Return the root mean square of the waves too short for the model, of the rougher track [m]."""
        return float(np.sqrt((self.parts[:, self.waves.size + 1 :] ** 2).sum(axis=1).max() / 2))

    def height(self, x: np.ndarray, side: int) -> np.ndarray:
        """Return z of the left (0) or right (1) track about its mean, x from the first point on [m]."""
        return summed(self.waves, self.amplitudes[side], x)


def read_road(path: str | Path) -> Measured:
    """Read the road of a file of comma-separated values with a header.

    ValueError for a file that cannot be read, another header, or a cell that is not a number, with its line.
    """
    path = Path(path)
    header, lines = table(path, HEADERS, "road")
    found = [[cell(x, f"{where}: {name}") for name, x in zip(header, row, strict=True)] for where, row in lines]
    values = np.array(found).reshape(-1, len(header)).T
    return Measured(path.name, values[0], values[[1, -1]])
