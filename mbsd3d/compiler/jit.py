"""The ``@kernel`` decorator: numba in nopython mode with compiled code on disk that cannot go stale."""

import atexit
import hashlib
import os
import re
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path

import numba

from .code_files import keep_code
from .late import late
from .second import start_second

PAUSE, STALLED = 5.0, 60.0  # s between counts of the kernels, and without a new one until the count ends
PACKAGE = Path(__file__).resolve().parent.parent
A_KERNEL = re.compile(rb"^\s*@\w*kernel\b", re.MULTILINE)


def compiled_sources() -> list[Path]:
    """All files of every folder that holds a kernel, and this one: what kernels use is in one of them."""
    files = sorted(PACKAGE.rglob("*.py"))
    folders = {Path(__file__).resolve().parent, *(path.parent for path in files if A_KERNEL.search(path.read_bytes()))}
    return [path for path in files if path.parent in folders]


def _digest(sources: list[Path]) -> str:
    """Digest of sources that are compiled: numba alone misses an edit in a callee of another file."""
    text = hashlib.sha256(numba.__version__.encode())
    for path in sources:
        text.update(path.read_bytes())
    return text.hexdigest()[:16]


def _cache_root() -> Path:
    """``$MBSD3D_CACHE``, else the user's cache folder, else a folder of the user's own in the temporary directory."""
    if "MBSD3D_CACHE" in os.environ:
        return Path(os.environ["MBSD3D_CACHE"])
    home = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    root = home / "mbsd3d"
    try:
        root.mkdir(parents=True, exist_ok=True)
    except OSError:
        root = Path(tempfile.gettempdir()) / f"mbsd3d-{os.getuid() if hasattr(os, 'getuid') else 'cache'}"
    return root


# No other kernel uses the integrators: an edit there leaves the code of all others valid.
INTEGRATORS = "integrators"
CACHE = _cache_root() / _digest(compiled_sources())
EQUATIONS = CACHE.parent / _digest([path for path in compiled_sources() if path.parent.name != INTEGRATORS])


def marker(part: str) -> Path:
    """The file that says a part has been compiled."""
    return CACHE / f"complete-{part.replace(' ', '-')}"


def is_warm(part: str = "kernels") -> bool:
    """True when a part of the compiled code of exactly this source is on disk, or none is compiled at all."""
    return bool(numba.config.DISABLE_JIT) or marker(part).exists()


@cache
def mark_warm(part: str = "kernels") -> None:
    """Note on disk that a part has been compiled."""
    if not is_warm(part):
        with suppress(OSError):  # said where the code itself could not be written
            CACHE.mkdir(parents=True, exist_ok=True)
            marker(part).touch()


@cache
def announce_compilation(part: str = "kernels") -> None:
    """Say once a process that a part of the code is being compiled, if it is not on disk yet."""
    if is_warm(part):
        return
    if part == "kernels" or is_warm():  # one line is enough at the very first run
        sys.stderr.write(f"mbsd3d: compiling {part}, once after installation (half a minute) ...\n")
        sys.stderr.flush()
        if part == "kernels":
            start_second()
        ended = threading.Event()
        atexit.register(ended.set)
        threading.Thread(target=count_kernels, args=(part, ended), daemon=True).start()


def count_kernels(part: str, ended: threading.Event) -> None:
    """Write every five seconds how many kernels are on disk, until the part is complete or nothing more comes."""
    began = last = time.perf_counter()
    before = 0
    while not ended.wait(PAUSE) and not is_warm(part) and time.perf_counter() - last < STALLED:
        done = sum(1 for folder in (CACHE, EQUATIONS) for _ in folder.rglob("*.code"))
        if done > before:
            before, last = done, time.perf_counter()
        sys.stderr.write(f"mbsd3d: {done} kernels after {time.perf_counter() - began:.0f} s\n")
        sys.stderr.flush()


def compiled(
    function: Callable, counting: bool = False, from_python: bool = True, fused: bool = False, merged: bool = False,
    apart: bool = False,
) -> Callable:  # fmt: skip
    """Compile in nopython mode, kept on disk under a digest of every kernel source that it may use."""
    made = numba.njit(
        error_model="numpy", nogil=True, _nrt=counting, no_cfunc_wrapper=True,
        no_cpython_wrapper=not from_python, fastmath={"contract", "reassoc", "nsz"} if fused else False,
        forceinline=fused, inline="always" if merged else "never",
    )(function)  # fmt: skip
    below = function.__module__.startswith(PACKAGE.name) and INTEGRATORS not in function.__module__
    return keep_code(made, EQUATIONS if below else CACHE, apart)


def kernel(function: Callable) -> Callable:
    """A compiled function that allocates nothing: without numba's reference counts calls are several times cheaper.

    Measured on one evaluation of a single body: 3.1 us with the atomic counts of some 20 array arguments, 0.9 without.
    It is compiled once, for Python and for all kernels that call it.
    """
    return compiled(function, apart=True)


def inner_kernel(function: Callable) -> Callable:
    """A kernel that only kernels call: without the wrapper for Python it compiles in half the time."""
    return compiled(function, from_python=numba.config.DISABLE_JIT)


def fused_kernel(function: Callable) -> Callable:
    """An inner kernel whose sums may be formed in any order, with fused multiply-add: a tenth off dot products.

    Merged into its callers by LLVM.
    """
    return compiled(function, from_python=numba.config.DISABLE_JIT, fused=True)


def merged_kernel(function: Callable) -> Callable:
    """An inner kernel that takes others as arguments: it becomes part of its caller before anything is compiled.

    On disk nothing can be found by the address of a function.
    """
    return compiled(function, from_python=numba.config.DISABLE_JIT, merged=True)


def late_kernel(function: Callable) -> Callable:
    """An inner kernel that is compiled when it is first called, and not with its callers: see `late`."""
    return late(inner_kernel(function))


def allocating_kernel(function: Callable) -> Callable:
    """A kernel that may allocate arrays (the dense saddle point)."""
    return compiled(function, counting=True, from_python=numba.config.DISABLE_JIT)
