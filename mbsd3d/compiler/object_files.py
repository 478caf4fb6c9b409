"""Compiled code on disk: one file a kernel and signature, named after what is in it, with a check sum.

numba's own files have numbers, which an index beside them gives to signatures: of two processes that compile at the
same time one may find the other's code under its number, and a damaged file ends in an error of pickle or in a crash.
Here a file is whole or is compiled anew, and where none can be written the code is used all the same. It holds object
code, and texts and numbers that say how it is called and what it calls; nothing in it is unpickled or imported. It is
still code that runs: it is read where nobody but this user can have written it, see `cache_folder.weakness`.

numba also puts a copy of all that a function calls into its code, and optimises the copy again: an integrator would
hold the equations of motion ten times over. Of a kernel that stands *apart* callers hold the name alone; their files
say whom they call, so that it is there before they are.
"""

import hashlib
import os
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from ..base.errors import InputError
from ..base.paths import atomic_write
from .cache_folder import conditions, make_private, weak_folders, weakness
from .first_run import write_message
from .late import LATE_SYMBOLS, Late
from .numba_private import (
    CompileResult,
    Dispatcher,
    NullCache,
    address_of,
    declarations,
    dumps,
    empty_library,
    keep_in,
    llvm,
    rebuilt,
    strip_to_symbols,
    symbol_of,
)
from .written_code import FormError, packed, unpacked

CHECKSUM_BYTES = 16  # [bytes]

# symbol in compiled code -> module, function, types of arguments
SEPARATE_KERNELS: dict[str, tuple[str, str, tuple]] = {}


def checksum(content: bytes) -> bytes:
    """Return the checksum that precedes the content of a cache file (16 bytes)."""
    return hashlib.blake2b(content, digest_size=CHECKSUM_BYTES).digest()


def mark_separate(function: Callable, made: CompileResult) -> None:
    """Register a separately compiled kernel: callers link to its symbol and hold no copy of its code."""
    SEPARATE_KERNELS[symbol_of(made)] = (function.__module__, function.__name__, made.signature.args)
    empty_library(made)


def separate_callees(made: CompileResult) -> list[tuple]:
    """Return the separately compiled kernels that a compiled function calls."""
    known = SEPARATE_KERNELS | LATE_SYMBOLS
    return [(name, *known[name]) for name in declarations(made) if name in known]


def load_callees(called_ones: list[tuple]) -> None:
    """Load the kernels that code from a file calls, under the names it has for them."""
    for symbol, module, name, arguments in called_ones:
        dispatcher = getattr(sys.modules[module], name)
        if isinstance(dispatcher, Late):
            dispatcher.symbol(arguments)
            continue
        dispatcher.compile(arguments)
        made = dispatcher.overloads[arguments]
        SEPARATE_KERNELS[symbol] = (module, name, arguments)
        llvm.add_symbol(symbol, address_of(made))  # another process may have compiled the caller, under another name


class CodeFiles(NullCache):
    """What numba asks for the compiled forms of one function."""

    def __init__(self, function: Callable, folder: Path, apart: bool) -> None:
        self.function, self.folder, self.apart = function, folder / function.__module__, apart
        self.folders = folder.parent, folder, self.folder  # from the root of the cache on

    @property
    def cache_path(self) -> str:
        """Return the folder that holds the compiled files of this function."""
        return str(self.folder)

    def path(self, signature: Any, target: Any) -> Path:
        """Return the file for one signature and processor."""
        code = self.function.__code__
        inside = dumps(tuple(cell.cell_contents for cell in self.function.__closure__ or ()))
        made_of = (signature, conditions(target.codegen().magic_tuple()), code.co_firstlineno, code.co_code)
        key = hashlib.blake2b(repr((made_of, inside)).encode(), digest_size=CHECKSUM_BYTES).hexdigest()
        return self.folder / f"{self.function.__name__}.{key}.code"

    def load_overload(self, signature: Any, target: Any) -> CompileResult | None:
        """Load the compiled function; return None if it is not there, damaged or not to be trusted."""
        content = self.read(self.path(signature, target))
        if content is None:
            return None
        if checksum(content[CHECKSUM_BYTES:]) != content[:CHECKSUM_BYTES]:
            say_once(f"compiled code in '{self.folder.parent}' is damaged; what is, is compiled anew")
            return None
        try:
            needed, parts = unpacked(content[CHECKSUM_BYTES:], self.function, signature)
            load_callees(needed)
        except (LookupError, AttributeError, TypeError, ValueError):  # a function of a script that is another one today
            return None
        made = rebuilt(target, parts)
        if self.apart:
            mark_separate(self.function, made)
        return made

    def read(self, path: Path) -> bytes | None:
        """Return what a file holds; None if it is not there, or if somebody else can have written it."""
        try:
            weak = weakness(path.lstat())
            if not self.trusted():
                return None
            if not weak:
                return path.read_bytes()
        except OSError:
            return None
        say_once(f"a file of compiled code in '{self.folder.parent}' {weak}: it is not run, but compiled anew")
        return None

    def trusted(self) -> bool:
        """Return whether nobody else can have written in the folder; said once if somebody may have."""
        weak = weak_folders(*self.folders)
        if weak:
            say_once(
                f"no compiled code is read or kept in '{self.folder.parent}', as a folder there {weak}: every start "
                "compiles again; make them your own and closed to others (chmod -R go-w), or name another folder in "
                "the environment variable MBSD3D_CACHE"
            )
        return not weak

    def save_overload(self, signature: Any, compiled: CompileResult) -> None:
        """Write it, unless it holds addresses of this process or what cannot be written."""
        kept = not (compiled.lifted or compiled.library.has_dynamic_globals)
        if self.apart:
            strip_to_symbols(compiled)
        try:
            content = packed(separate_callees(compiled), compiled) if kept else b""
        except FormError:
            kept = False
        if self.apart:
            mark_separate(self.function, compiled)
        if kept:
            self.write(self.path(signature, compiled.target_context), checksum(content) + content)

    def write(self, path: Path, content: bytes) -> None:
        """Write a file, or say why not."""
        try:
            make_private(*self.folders)
            if self.trusted():
                with atomic_write(path) as part, open(part, "xb", opener=for_this_user) as file:
                    file.write(content)
        except (OSError, InputError) as error:
            reason = getattr(error.__cause__ or error, "strerror", None) or error
            say_once(
                f"compiled code cannot be kept in '{self.folder.parent}' ({reason}), every start compiles again; make "
                "room, or name a folder that can be written in the environment variable MBSD3D_CACHE"
            )


def for_this_user(path: str, flags: int) -> int:
    """Open a new file that nobody else can write, whatever the user's umask is."""
    return os.open(path, flags, 0o600)


def keep_code(compiled: Callable, folder: Path, apart: bool = False) -> Callable:
    """Return the same function with its code kept in a folder; one that is not to be compiled stays as it is."""
    if isinstance(compiled, Dispatcher):
        function = compiled.py_func
        keep_in(CodeFiles(function, folder, apart and "<locals>" not in function.__qualname__), compiled)
    return compiled


@cache
def say_once(text: str) -> None:
    """Write a line to stderr, once a process."""
    write_message(text)
