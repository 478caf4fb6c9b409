"""Kernels that are compiled when they are first called, so that a run waits for no code that it does not use.

A caller knows neither the code of such a kernel nor its address, only a cell in memory. Its first word is the address
of the code, zero at first; a call costs a load and a comparison more than one by name. The others serve a caller that
finds zero there: addresses of functions that have the kernel compiled, or found on disk.

It is compiled in a thread of its own. No exception can pass the compiled code that waits, so nothing may raise one
there: neither the compiler nor the handler of a signal, which Python runs in the main thread. All that the main thread
does meanwhile is written in C, and without Python's lock, which the compiler needs. What a signal raises, Ctrl-C or an
alarm, is raised once the kernels have returned. A kernel that does not compile is replaced by one that raises
`KernelError` as all compiled code does, by its status.
"""

import _thread
import ctypes
import hashlib
import inspect
import sys
from collections.abc import Callable, Sequence
from functools import partial
from importlib import import_module
from typing import Any, NamedTuple

import numba
import numpy as np
from numba import types

from ..base.errors import InputError, KernelError
from .cache_folder import PLAIN_NUMBA
from .first_run import announce_if_slow
from .numba_private import Dispatcher, Intrinsic, address_of, cgutils, ir, llvm, njit

WORD_TYPE = ir.IntType(64)
C_FUNCTION_TYPE = ir.FunctionType(ir.VoidType(), [])
NAP_SECONDS = 1e-4  # [s] between two looks at a cell; a kernel takes some milliseconds from disk
REASON_LENGTH_MAX = 600  # [characters] of an error of the compiler that a message repeats
NAPS_MAX = 20_000  # [1] some seconds in which no thread has begun: Python starts none while it ends
CODE, START, BEGUN, FILL = range(WORDS := 4)  # words of a cell

RETURN_TYPES = {
    None: types.void, int: types.int64, float: types.float64, bool: types.boolean,
    tuple[int, int]: types.UniTuple(types.int64, 2),
}  # fmt: skip
"""What a late kernel may be annotated to return; else `Annotated` with a function of the types of its arguments."""

LATE_SYMBOLS: dict[str, tuple[str, str, tuple]] = {}  # symbol of cells -> module, name, types of arguments


class Cells(NamedTuple):
    """Those of some kernels for arguments of some types."""

    words: np.ndarray  # (kernels, WORDS)
    functions: list  # of C, kept as long as the cells


def in_c(function: Callable, *given: Any) -> Any:
    """Return a function of C that calls another one; the interpreter, which looks for signals, has no part in it."""
    return ctypes.CFUNCTYPE(None)(partial(function, *given))


def address_in_c(function: Any) -> int:
    """Return the address of a function of C."""
    return ctypes.cast(function, ctypes.c_void_p).value or 0


if sys.platform == "win32":
    PAUSE, PAUSED, SYSTEM = "Sleep", 1, ctypes.windll.kernel32
else:
    PAUSE, PAUSED, SYSTEM = "usleep", round(1e6 * NAP_SECONDS), ctypes.CDLL(None)
POINTER, NUMBER = ir.IntType(8).as_pointer(), ir.IntType(32)
C_FUNCTIONS = {  # that compiled code calls by name
    PAUSE: (SYSTEM[PAUSE], ir.VoidType(), [NUMBER]),
    "PyGILState_Check": (ctypes.pythonapi.PyGILState_Check, NUMBER, []),
    "PyEval_SaveThread": (ctypes.pythonapi.PyEval_SaveThread, POINTER, []),
    "PyEval_RestoreThread": (ctypes.pythonapi.PyEval_RestoreThread, ir.VoidType(), [POINTER]),
}
for name, (function, *_) in C_FUNCTIONS.items():
    llvm.add_symbol(name, address_in_c(function))


def call_c(builder: Any, name: str, *given: Any) -> Any:
    """Generate the call of one of the C functions in `PLAIN_C`."""
    _, result, kinds = C_FUNCTIONS[name]
    return builder.call(cgutils.get_or_insert_function(builder.module, ir.FunctionType(result, kinds), name), given)


def waiting_function(module: ir.Module) -> ir.Function:
    """Generate the function that has a cell filled and waits for it; where no thread begins, it fills it itself."""
    name = "mbsd3d.wait_until_filled"
    if name in module.globals:
        return module.globals[name]
    made = ir.Function(module, ir.FunctionType(ir.VoidType(), [WORD_TYPE.as_pointer()]), name)
    made.linkage = "internal"
    made.attributes.add("noinline")
    builder = ir.IRBuilder(made.append_basic_block())
    code, start, begun, fill = (builder.gep(made.args[0], [WORD_TYPE(i)]) for i in range(WORDS))
    thread, naps = (cgutils.alloca_once_value(builder, first) for first in (POINTER(None), WORD_TYPE(0)))
    with builder.if_then(cgutils.is_not_null(builder, call_c(builder, "PyGILState_Check"))):
        builder.store(call_c(builder, "PyEval_SaveThread"), thread)
    builder.call(builder.inttoptr(builder.load(start), C_FUNCTION_TYPE.as_pointer()), [])
    waiting, filled = (builder.append_basic_block(name) for name in ("waiting", "filled"))
    builder.branch(waiting)
    builder.position_at_end(waiting)
    call_c(builder, PAUSE, NUMBER(PAUSED))
    builder.store(builder.add(builder.load(naps), WORD_TYPE(1)), naps)
    nobody = cgutils.is_null(builder, builder.or_(builder.load(begun), builder.load(code)))
    with builder.if_then(builder.and_(nobody, builder.icmp_unsigned(">", builder.load(naps), WORD_TYPE(NAPS_MAX)))):
        builder.call(builder.inttoptr(builder.load(fill), C_FUNCTION_TYPE.as_pointer()), [])
    builder.cbranch(cgutils.is_null(builder, builder.load(code)), waiting, filled)
    builder.position_at_end(filled)
    with builder.if_then(cgutils.is_not_null(builder, builder.load(thread))):
        call_c(builder, "PyEval_RestoreThread", builder.load(thread))
    builder.ret_void()
    return made


class Late(Intrinsic):  # type: ignore[misc]  # final in numba's stubs, not in numba
    """Kernels of the same arguments that callers do not compile; ``numbered``: a number in front of them says which."""

    def __init__(self, where: str, name: str, kernels: Sequence[Dispatcher], result: Any, numbered: bool) -> None:
        self.kernels, self.result, self.numbered = tuple(kernels), result, numbered
        self.cells: dict[tuple, Cells] = {}
        self.__module__, self.__name__ = where, name
        super().__init__(name, self.definition())
        self._register()

    def __call__(self, *given: Any) -> Any:
        """Call the kernel from Python."""
        number, given = (given[0], given[1:]) if self.numbered else (0, given)
        return self.kernels[number](*given)

    def definition(self) -> Callable:
        """Return type and code of a call by its signature, as numba asks: the context in front of the arguments."""
        names = ["context", *["number"] * self.numbered, *inspect.signature(self.kernels[0].py_func).parameters]

        def typed(context: Any, *given: types.Type) -> tuple:
            return self.returned(given[self.numbered :])(*given), self.call

        kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
        parameters = [inspect.Parameter(name, kind) for name in names]
        typed.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]  # typeshed lacks it
        typed.__doc__, typed.__name__, typed.__module__ = self.kernels[0].__doc__, self.__name__, self.__module__
        return typed

    def returned(self, passed: tuple) -> types.Type:
        """Return the type of what the kernels return for arguments of some types."""
        return RETURN_TYPES[self.result] if self.result in RETURN_TYPES else self.result.__metadata__[0](*passed)

    def call(self, context: Any, builder: Any, signature: Any, values: Any) -> Any:
        """Generate the code of a call, in numba's own convention."""
        passed, result = signature.args[self.numbered :], signature.return_type
        number = builder.sext(values[0], WORD_TYPE) if self.numbered else WORD_TYPE(0)
        address = self.address(builder, self.symbol(passed), number)
        function = context.call_conv.get_function_type(result, passed)
        called = builder.inttoptr(address, function.as_pointer())
        status, found = context.call_conv.call_function(builder, called, result, passed, values[self.numbered :])
        with cgutils.if_unlikely(builder, status.is_error):
            context.call_conv.return_status_propagate(builder, status)
        return found

    def address(self, builder: Any, symbol: str, number: Any) -> Any:
        """Generate code that reads the address from the cell, and has the cell filled first if it is empty."""
        module, size = builder.module, ir.ArrayType(ir.ArrayType(WORD_TYPE, WORDS), len(self.kernels))
        cells = module.globals.get(symbol) or cgutils.add_global_variable(module, size, symbol)
        code = builder.gep(cells, [WORD_TYPE(0), number, WORD_TYPE(CODE)])
        with cgutils.if_unlikely(builder, cgutils.is_null(builder, builder.load(code))):
            builder.call(waiting_function(module), [code])
        return builder.load(code)

    def symbol(self, passed: tuple) -> str:
        """Return the name of the cells for arguments of some types, which compiled code can refer to from now on."""
        digest = hashlib.blake2b(repr(passed).encode(), digest_size=8).hexdigest()
        symbol = f"{self.__module__}.{self.__name__}.{digest}"
        if passed not in self.cells:
            words, functions = np.zeros((len(self.kernels), WORDS), np.uint64), []
            for i in range(len(self.kernels)):
                fill = in_c(self.fill_or_fail, passed, i)
                start = in_c(_thread.start_new_thread, self.fill_or_fail, (passed, i))
                words[i, [START, FILL]] = address_in_c(start), address_in_c(fill)
                functions += [start, fill]
            self.cells[passed] = Cells(words, functions)
            LATE_SYMBOLS[symbol] = self.__module__, self.__name__, passed
            llvm.add_symbol(symbol, words.ctypes.data)
        return symbol

    def fill(self, passed: tuple, number: int) -> None:
        """Compile a kernel and write its address into its cell."""
        words = self.cells[passed].words[number]
        words[BEGUN] = 1
        with announce_if_slow(self.kernels[number].py_func.__name__):
            words[CODE] = self.compiled(passed, number)

    def fill_or_fail(self, passed: tuple, number: int) -> None:
        """Fill the cell for compiled code that waits; where the kernel does not compile, with one that raises."""
        try:
            self.fill(passed, number)
        except BaseException as error:
            self.cells[passed].words[number, CODE] = self.failing(passed, number, error)

    def failing(self, passed: tuple, number: int, error: BaseException) -> int:
        """Return the address of a kernel of the same arguments that raises a `KernelError` with the reason."""
        reason = " ".join(str(error).split())[:REASON_LENGTH_MAX]
        names = ", ".join(f"x{k}" for k in range(len(passed)))
        text = (
            f"kernel {self.kernels[number].py_func.__name__} cannot be compiled: {type(error).__name__}: {reason}; "
            "MBSD3D_PLAIN_NUMBA=1 shows where"
        )
        scope: dict[str, Any] = {"KernelError": KernelError}
        exec(f"def failing({names}):\n    raise KernelError({text!r})", scope)  # of a text that is made here
        kernel = njit(_nrt=False, no_cfunc_wrapper=True, no_cpython_wrapper=True)(scope["failing"])
        kernel.compile(passed)
        return address_of(kernel.overloads[passed])

    def compiled(self, passed: tuple, number: int) -> int:
        """Return the address of the code of a kernel."""
        kernel = self.kernels[number]
        kernel.compile(passed)
        made = kernel.overloads[passed]
        found, wanted = types.unliteral(made.signature.return_type), self.returned(passed)
        if found != wanted:
            raise InputError(f"{kernel.py_func.__name__} returns {found}, not {wanted}")
        return address_of(made)


def late(kernel: Callable) -> Callable:
    """Make a kernel that its callers do not compile; what it returns is annotated, see `RESULTS`."""
    if PLAIN_NUMBA or not isinstance(kernel, Dispatcher):
        return kernel
    function = kernel.py_func
    return Late(function.__module__, function.__name__, [kernel], function.__annotations__.get("return"), False)


def late_choice(where: str, name: str, kernels: Sequence[Callable]) -> Callable:
    """Make ``name(number, *arguments)``, which calls one of some kernels without result; module ``where`` holds it."""
    jitted = [one for one in kernels if isinstance(one, Dispatcher)]
    if not jitted:  # the compiler is switched off
        return lambda number, *given: kernels[number](*given)
    if PLAIN_NUMBA:
        return plain_choice(kernels)
    return Late(where, name, jitted, None, True)


def plain_choice(kernels: Sequence[Callable]) -> Callable:
    """Return the choice of one of some kernels as numba compiles it without this module."""
    first, *others = kernels
    if not others:
        return numba.njit(error_model="numpy")(lambda number, *given: first(*given))
    rest = plain_choice(others)

    @numba.njit(error_model="numpy")
    def chosen(number, *given):
        if number == 0:
            first(*given)
        else:
            rest(number - 1, *given)

    return chosen


def uncompiled_kernels() -> list[tuple[Late, tuple, int]]:
    """Return (kernels, types of arguments, number) of what callers know and nothing has called yet."""
    found = []
    for module, name, passed in LATE_SYMBOLS.values():
        one = getattr(import_module(module), name)
        found += [(one, passed, int(number)) for number in np.flatnonzero(one.cells[passed].words[:, CODE] == 0)]
    return found
