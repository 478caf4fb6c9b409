"""All that this package takes from numba and llvmlite beyond their documented interface; nothing else imports it.

Each name stands with what it is for. `tests/compiler/test_numba_private.py` asks for them on the oldest and the newest
numba that ``pyproject.toml`` allows.
"""

from collections.abc import Callable
from typing import Any

import numba

try:
    from llvmlite import binding as llvm  # symbols that compiled code calls by name
    from llvmlite import ir  # code of calls through an address
    from numba.core import cgutils, sigutils  # the same; types of a signature
    from numba.core.caching import NullCache  # base of the files of compiled code
    from numba.core.ccallback import CFunc  # the C function of a user's force
    from numba.core.compiler import CompileResult  # what a cache keeps
    from numba.core.compiler_lock import global_compiler_lock  # to compile in one thread at a time, and to know it
    from numba.core.dispatcher import Dispatcher  # a function that is to be compiled
    from numba.core.environment import Environment, lookup_environment  # globals of code that is read from a file
    from numba.core.extending import _Intrinsic as Intrinsic  # base of kernels that callers do not compile
    from numba.core.funcdesc import PythonFunctionDescriptor  # how code from a file is called
    from numba.core.imputils import impl_ret_borrowed  # a field of a named tuple that is passed by address
    from numba.core.registry import cpu_target  # the processor, for the names of files
    from numba.core.runtime import rtsys  # memory that code from a file may allocate
    from numba.core.serialize import dumps  # digest of what a function closes over
    from numba.core.typing import signature as signature_of  # types of code from a file
    from numba.core.typing.templates import AttributeTemplate  # types of the fields of a named tuple
except ImportError as error:  # pragma: no cover - another numba than pyproject.toml allows
    raise ImportError(
        f"numba {numba.__version__} lacks what mbsd3d compiles with ({error}); install a version that pyproject.toml "
        "allows: pip install 'numba>=0.62,<0.69'"
    ) from error

__all__ = [
    "AttributeTemplate", "CFunc", "CompileResult", "Dispatcher", "Environment", "Intrinsic", "NullCache",
    "PythonFunctionDescriptor", "address_of", "cgutils", "cpu_target", "declarations", "dumps", "empty_library",
    "global_compiler_lock", "impl_ret_borrowed", "ir", "is_compiling", "keep_in", "llvm", "lookup_environment", "njit",
    "object_code", "rebuilt", "signature_of", "sigutils", "strip_to_symbols", "symbol_of",
]  # fmt: skip


def njit(**options: Any) -> Callable[[Callable], Any]:
    """Return numba's decorator with options that it takes and does not document."""
    return numba.njit(**options)


def keep_in(files: NullCache, function: Dispatcher) -> None:
    """Let a function that is to be compiled look for its code in files first."""
    function._cache = files  # type: ignore[attr-defined]  # numba's stubs lack it


def symbol_of(made: CompileResult) -> str:
    """Return the name of a compiled function in its object code."""
    return made.fndesc.llvm_func_name


def address_of(made: CompileResult) -> int:
    """Return the address of a compiled function."""
    return made.library.get_pointer_to_function(symbol_of(made))


def declarations(made: CompileResult) -> list[str]:
    """Return the symbols that a compiled function refers to and does not define."""
    module = made.library._final_module
    return [found.name for found in (*module.functions, *module.global_variables) if found.is_declaration]


def strip_to_symbols(made: CompileResult) -> None:
    """Keep the external names that a library defines, without their code, so that callers link to them."""
    defined = [function for function in made.library._final_module.functions if not function.is_declaration]
    names = [function.name for function in defined if function.linkage == llvm.Linkage.external]
    made.library._shared_module = llvm.parse_assembly(
        "\n".join(f'define void @"{name}"() {{\n  unreachable\n}}' for name in names)
    )


def empty_library(made: CompileResult) -> None:
    """Let callers link nothing of a compiled function."""
    made.library._shared_module = llvm.parse_assembly("")


def object_code(made: CompileResult) -> tuple[str, str, tuple[bytes, bytes]]:
    """Return (name, kind, (object code, what callers link)) of a library."""
    return made.library.serialize_using_object_code()


def rebuilt(target: object, parts: tuple) -> CompileResult:
    """Return a compiled function from what a file holds of it.

    numba's own cache has all that the compiler can translate loaded first, a tenth of a second; code from a file needs
    none of it, only what allocates memory.
    """
    rtsys.initialize(target)
    return CompileResult._rebuild(target, *parts)


def is_compiling() -> bool:
    """Return whether another thread holds the lock of the compiler right now."""
    if global_compiler_lock._lock.acquire(blocking=False):
        global_compiler_lock._lock.release()
        return False
    return True
