"""Compiled code on disk: one file a kernel and signature, named after what is in it, with a check sum.

numba's own files have numbers, which an index beside them gives to signatures: of two processes that compile at the
same time one may find the other's code under its number, and a damaged file ends in an error of pickle or in a crash.
Here a file is whole or is compiled anew, and where none can be written the code is used all the same.
"""

import hashlib
import pickle
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from numba.core.caching import NullCache
from numba.core.compiler import CompileResult
from numba.core.dispatcher import Dispatcher
from numba.core.serialize import dumps

from ..base.errors import InputError
from ..base.paths import write_atomically

SUM = 16  # bytes


def check_sum(content: bytes) -> bytes:
    """What stands in front of it."""
    return hashlib.blake2b(content, digest_size=SUM).digest()


class CodeFiles(NullCache):
    """What numba asks for the compiled forms of one function."""

    def __init__(self, function: Callable, folder: Path) -> None:
        self.function, self.folder = function, folder / function.__module__

    @property
    def cache_path(self) -> str:
        """The folder of the files."""
        return str(self.folder)

    def path(self, signature: Any, target: Any) -> Path:
        """The file for one signature and processor."""
        code = self.function.__code__
        inside = dumps(tuple(cell.cell_contents for cell in self.function.__closure__ or ()))
        made_of = (signature, target.codegen().magic_tuple(), sys.version_info[:2], code.co_firstlineno, code.co_code)
        key = hashlib.blake2b(repr((made_of, inside)).encode(), digest_size=SUM).hexdigest()
        return self.folder / f"{self.function.__name__}.{key}.code"

    def load_overload(self, signature: Any, target: Any) -> CompileResult | None:
        """The compiled function; None if it is not there or damaged."""
        target.refresh()
        path = self.path(signature, target)
        try:
            content = path.read_bytes()
        except OSError:
            return None
        if check_sum(content[SUM:]) != content[:SUM]:
            say_once(f"compiled code in '{self.folder.parent}' is damaged; what is, is compiled anew")
            return None
        return CompileResult._rebuild(target, *pickle.loads(content[SUM:]))

    def save_overload(self, signature: Any, compiled: CompileResult) -> None:
        """Write it, unless it holds addresses of this process."""
        if compiled.lifted or compiled.library.has_dynamic_globals:
            return
        content = dumps(compiled._reduce())
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            write_atomically(self.path(signature, compiled.target_context), check_sum(content) + content)
        except (OSError, InputError) as error:
            reason = getattr(error.__cause__ or error, "strerror", None) or error
            say_once(
                f"compiled code cannot be kept in '{self.folder.parent}' ({reason}), every start compiles again; make "
                "room, or name a folder that can be written in the environment variable MBSD3D_CACHE"
            )


def keep_code(compiled: Callable, folder: Path) -> Callable:
    """The same function with its code kept in a folder; one that is not to be compiled stays as it is."""
    if isinstance(compiled, Dispatcher):
        compiled._cache = CodeFiles(compiled.py_func, folder)
    return compiled


@cache
def say_once(text: str) -> None:
    """A line on stderr, once a process."""
    sys.stderr.write(f"mbsd3d: {text}\n")
    sys.stderr.flush()
