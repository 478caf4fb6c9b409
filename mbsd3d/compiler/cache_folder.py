"""Where compiled code is kept: in a folder named after the digest of what it was made from.

Code from there is run, so nothing is read where anybody but this user could have written: see `weakness`.
"""

import hashlib
import os
import re
import stat
import sys
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from pathlib import Path

import numba

from .numba_private import cpu_target

COMPILER_FOLDER = Path(__file__).resolve().parent
PACKAGE_FOLDER = COMPILER_FOLDER.parent
PLAIN_NUMBA = os.environ.get("MBSD3D_PLAIN_NUMBA", "") == "1"  # no files and no late kernels: to look for a culprit
KERNEL_DECORATOR_PATTERN = re.compile(rb"@\w*kernel\s")


@cache
def _compiled_texts() -> dict[Path, bytes]:
    """Return all files of every folder that holds a kernel, and of this one: what kernels use is in one of them."""
    found: dict[Path, bytes] = {}
    for folder, inside, names in os.walk(PACKAGE_FOLDER):
        inside.sort()
        texts = {
            Path(folder, name): _content(os.path.join(folder, name)) for name in sorted(names) if name[-3:] == ".py"
        }
        if Path(folder) == COMPILER_FOLDER or any(map(KERNEL_DECORATOR_PATTERN.search, texts.values())):
            found |= texts
    return found


def _content(path: str) -> bytes:
    """Return what a file holds, without a buffer: every start reads all sources of the package."""
    with open(path, "rb", buffering=0) as file:
        return file.read()


def compiled_sources() -> list[Path]:
    """Return the files whose text decides where compiled code is kept."""
    return list(_compiled_texts())


def _digest(texts: Iterable[bytes]) -> str:
    """Return the digest of sources that are compiled: numba alone misses an edit in a callee of another file."""
    made = hashlib.sha256(numba.__version__.encode())
    for text in texts:
        made.update(text)
    return made.hexdigest()[:16]


def _absolute(text: str) -> Path | None:
    """Return a folder that the environment names, "~" expanded; None for an empty or a relative one."""
    path = Path(os.path.expanduser(text))
    return path if path.is_absolute() else None


def _cache_root() -> Path:
    """Return ``$MBSD3D_CACHE``, else the user's cache folder, else one of the user's in the temporary directory."""
    given, caches = (_absolute(os.environ.get(name, "")) for name in ("MBSD3D_CACHE", "XDG_CACHE_HOME"))
    if given is not None:
        return given
    caches = caches or _absolute("~/.cache" if os.environ.get("HOME", "~") else "")
    if caches is not None:
        with suppress(OSError):
            make_private(caches / PACKAGE_FOLDER.name)
            return caches / PACKAGE_FOLDER.name
    return _temporary_folder() / f"{PACKAGE_FOLDER.name}-{os.geteuid() if hasattr(os, 'geteuid') else 'cache'}"


def _temporary_folder() -> Path:
    """Return the system's folder for temporary files, never the working directory as `tempfile` may do."""
    named = [_absolute(os.environ.get(name, "")) for name in ("TMPDIR", "TEMP", "TMP")]
    for folder in (*filter(None, named), Path("/tmp"), Path("/var/tmp")):
        if folder.is_dir() and os.access(folder, os.W_OK):
            return folder
    return Path(os.devnull)  # nothing can be kept below it, which is said when code is written


def make_private(*folders: Path) -> None:
    """Make folders that are missing, from the outermost on, open to this user alone."""
    for folder in folders:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)


def weakness(*states: os.stat_result) -> str:
    """Return why someone else may have written folders or files, given as ``lstat`` has them; "" if no one can have.

    Each must belong to this user, be no link, and not be writable by others. What the administrator made is another
    user's, too: a folder in a place for temporary files may have been made beforehand by anyone.
    """
    for state in states:
        if stat.S_ISLNK(state.st_mode):
            return "is a link"
        if hasattr(os, "geteuid"):  # elsewhere folders of a user are closed to others by their place
            if state.st_uid != os.geteuid():
                return "belongs to another user"
            if state.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
                return "can be written by others"
    return ""


def weak_folders(*folders: Path) -> str:
    """Return why nothing in a folder, the last of those from the cache's root on, is trusted; "" if it can be."""
    try:
        return weakness(*(folder.lstat() for folder in folders))
    except OSError:
        return "is not there"


# No other kernel uses the integrators: an edit there leaves the code of all others valid.
INTEGRATORS_FOLDER = "integrators"
CACHE_FOLDER = _cache_root() / _digest(_compiled_texts().values())
_EQUATIONS_TEXTS = [text for path, text in _compiled_texts().items() if path.parent.name != INTEGRATORS_FOLDER]
EQUATIONS_CACHE_FOLDER = CACHE_FOLDER.parent / _digest(_EQUATIONS_TEXTS)


# of numba, that change code
CODE_SETTINGS = ("OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "BOUNDSCHECK", "DEBUGINFO_DEFAULT")


def conditions(processor: tuple) -> tuple:
    """Return what code depends on beside its sources: processor, Python, and the settings of both compilers."""
    settings = (str(getattr(numba.config, name, None)) for name in CODE_SETTINGS)
    return processor, sys.version_info[:2], sys.flags.optimize, *settings


@cache
def marker(part: str) -> Path:
    """Return the file that says a part has been compiled, by this Python with these settings for this processor."""
    made_for = repr(conditions(cpu_target.target_context.codegen().magic_tuple()))
    return CACHE_FOLDER / f"complete-{part.replace(' ', '-')}-{hashlib.sha256(made_for.encode()).hexdigest()[:16]}"


def is_warm(part: str = "kernels") -> bool:
    """Return whether a part of the compiled code of exactly this source is on disk, or none is compiled at all."""
    return bool(numba.config.DISABLE_JIT) or (
        not weak_folders(CACHE_FOLDER.parent, CACHE_FOLDER) and marker(part).exists()
    )


@cache
def mark_warm(part: str = "kernels") -> None:
    """Note on disk that a part has been compiled."""
    if not is_warm(part):
        with suppress(OSError):  # said where the code itself could not be written
            make_private(CACHE_FOLDER.parent, CACHE_FOLDER)
            if not weak_folders(CACHE_FOLDER.parent, CACHE_FOLDER):
                marker(part).touch()
