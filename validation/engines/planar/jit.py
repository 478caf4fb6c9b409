"""Decorators that compile the planar solver, cached on disk under a digest of its own sources."""

import hashlib
from collections.abc import Callable
from pathlib import Path

import numba

from mbsd3d.extend import CACHE


def _digest() -> str:
    """Of every file that is compiled: numba's own cache misses edits in callees of other files."""
    text = hashlib.sha256(numba.__version__.encode())
    for name in ("rows", "saddle", "march"):
        text.update(Path(__file__).with_name(f"{name}.py").read_bytes())
    return text.hexdigest()[:16]


FOLDER = CACHE.parent / f"planar-{_digest()}"


def _compiled(function: Callable, **options: object) -> Callable:
    """Nopython mode without reference counts: the kernels allocate nothing."""
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(FOLDER)
    try:
        return numba.njit(cache=True, error_model="numpy", nogil=True, _nrt=False, no_cfunc_wrapper=True, **options)(
            function
        )
    finally:
        numba.config.CACHE_DIR = before


def kernel(function: Callable) -> Callable:
    """A compiled function that allocates nothing."""
    return _compiled(function)


def inner(function: Callable) -> Callable:
    """A kernel that only kernels call, merged into them; its sums may be formed in any order and fused."""
    return _compiled(
        function, no_cpython_wrapper=not numba.config.DISABLE_JIT, fastmath={"contract", "reassoc", "nsz"},
        forceinline=True,
    )  # fmt: skip
