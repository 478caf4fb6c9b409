"""The ``@kernel`` decorators: numba in nopython mode, with compiled code on disk that cannot go stale."""

from collections.abc import Callable
from concurrent.futures import Future
from threading import Thread, current_thread, main_thread
from typing import Any

import numba

from .cache_folder import CACHE_FOLDER, EQUATIONS_CACHE_FOLDER, INTEGRATORS_FOLDER, PACKAGE_FOLDER, PLAIN_NUMBA
from .late import late
from .numba_private import Dispatcher, global_compiler_lock, njit
from .object_files import keep_code


def compiled(
    function: Callable, counting: bool = False, from_python: bool = True, fused: bool = False, merged: bool = False,
    apart: bool = False,
) -> Callable:  # fmt: skip
    """Compile in nopython mode, kept on disk under a digest of every kernel source that it may use.

    With ``MBSD3D_PLAIN_NUMBA=1`` in the environment by numba alone: slow, but its errors and warnings are its own.
    """
    if PLAIN_NUMBA:
        return numba.njit(error_model="numpy", nogil=True, inline="always" if merged else "never")(function)
    made = njit(
        error_model="numpy", nogil=True, _nrt=counting, no_cfunc_wrapper=True,
        no_cpython_wrapper=not from_python, fastmath={"contract", "reassoc", "nsz"} if fused else False,
        forceinline=fused, inline="always" if merged else "never",
    )(function)  # fmt: skip
    if isinstance(made, Dispatcher):
        compile_in_thread(made)
    below = function.__module__.startswith(PACKAGE_FOLDER.name) and INTEGRATORS_FOLDER not in function.__module__
    return keep_code(made, EQUATIONS_CACHE_FOLDER if below else CACHE_FOLDER, apart)


def compile_in_thread(made: Dispatcher) -> None:
    """Compile a function that the main thread calls in another one, where no handler of a signal can break in.

    What a handler raises within a call that LLVM makes would be lost, and the code half made. Here it is raised at once
    in the main thread, as anywhere in Python, and the other one finishes the kernel.
    """
    compile_here = made.compile

    def compile_(signature: Any) -> Any:
        if current_thread() is not main_thread() or global_compiler_lock.is_locked():  # within another compilation
            return compile_here(signature)
        ended: Future = Future()
        try:
            Thread(target=settle, args=(ended, compile_here, signature), name="mbsd3d compiler").start()
        except RuntimeError:  # Python ends
            return compile_here(signature)
        return ended.result()

    made.compile = compile_  # type: ignore[method-assign, assignment]  # one function's own, not the class's


def settle(ended: Future, function: Callable, *given: Any) -> None:
    """Set a future to what a call returns or raises."""
    try:
        ended.set_result(function(*given))
    except BaseException as error:
        ended.set_exception(error)


def kernel(function: Callable) -> Callable:
    """Compile a function that allocates nothing: without numba's reference counts calls are several times cheaper.

    Measured on one evaluation of a single body: 3.1 us with the atomic counts of some 20 array arguments, 0.9 without.
    It is compiled once, for Python and for all kernels that call it.
    """
    return compiled(function, apart=True)


def inner_kernel(function: Callable) -> Callable:
    """Compile a kernel that only kernels call: without the wrapper for Python it compiles in half the time."""
    return compiled(function, from_python=numba.config.DISABLE_JIT)


def fused_kernel(function: Callable) -> Callable:
    """Compile an inner kernel whose sums may be formed in any order, with fused multiply-add: a tenth off dot products.

    Merged into its callers by LLVM.
    """
    return compiled(function, from_python=numba.config.DISABLE_JIT, fused=True)


def merged_kernel(function: Callable) -> Callable:
    """Make an inner kernel that takes others as arguments a part of its caller before anything is compiled.

    On disk nothing can be found by the address of a function.
    """
    return compiled(function, from_python=numba.config.DISABLE_JIT, merged=True)


def late_kernel(function: Callable) -> Callable:
    """Compile an inner kernel when it is first called, and not with its callers: see `late`."""
    return late(inner_kernel(function))


def allocating_kernel(function: Callable) -> Callable:
    """Compile a kernel that may allocate arrays (the dense saddle point)."""
    return compiled(function, counting=True, from_python=numba.config.DISABLE_JIT)
