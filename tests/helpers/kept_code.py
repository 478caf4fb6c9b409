"""A function whose code is kept on disk, and structures that kernels take by address."""

from typing import NamedTuple

import numba
import numpy as np

from mbsd3d.compiler import object_files
from mbsd3d.compiler.arguments import by_reference
from mbsd3d.extend import keep_code


def area(a, b):
    return 0.5 * a * b


def fresh(folder):
    """The function as a new process finds it."""
    object_files.say_once.cache_clear()
    return keep_code(numba.njit(area), folder)


def hits(function):
    return sum(function._cache_hits.values())


@by_reference
class Inner(NamedTuple):
    count: int
    weights: np.ndarray


@by_reference
class Outer(NamedTuple):
    inner: Inner
    factor: float
    table: np.ndarray
    limits: tuple[float, float]
