"""Files: names with their suffix, whole or not at all, and text from anywhere, limited before it is read."""

import hashlib
import os
import re
import socket
import stat
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from .errors import InputError
from .version import __version__
from .wording import with_article

FILE_NAME_BYTES_MAX = 255  # [bytes] of the name of a file; more is refused by most file systems
# name of a file that is not whole yet: machine, process
UNFINISHED_FILE_PATTERN = re.compile(r"\.[0-9a-f]{32}(?:-([0-9a-f]{16})-(\d+))?\.part")
UNFINISHED_FILE_SECONDS_MAX = 86400.0  # [s] since it was last written, for one whose process cannot be asked for


def as_path(path: str | Path, example: str) -> Path:
    """Return a path that a file can have, or raise an InputError."""
    if isinstance(path, str | os.PathLike):
        found = Path(path)
        with suppress(UnicodeEncodeError):
            size = len(os.fsencode(found.name))
            if size > FILE_NAME_BYTES_MAX:
                raise InputError(
                    f"path = {path!r:.80}: a name of {size} bytes; give one of at most {FILE_NAME_BYTES_MAX}"
                )
            if found.name and "\0" not in str(found):
                return found
    raise InputError(f"path = {path!r:.80} names no file; give a name such as '{example}'")


def with_suffix(path: str | Path, suffix: str) -> Path:
    """Append the suffix to a path unless it is there."""
    path = as_path(path, f"result{suffix}")
    return path if path.name.lower().endswith(suffix) else as_path(f"{path}{suffix}", "")


def ready_path(path: str | Path, suffix: str) -> Path:
    """Return the path with its suffix; a missing folder is found before the work, not after it."""
    path = with_suffix(path, suffix)
    if not path.parent.is_dir():
        raise InputError(f"'{path}' cannot be written: there is no folder '{path.parent}'; make it first")
    return path


def write_atomically(path: Path, content: bytes, *, replace: bool = True) -> Path:
    """Write a whole file or nothing: under a temporary name in the same folder, then renamed; returns ``path``.

    ValueError if the folder cannot be written, or an older file is there and ``replace`` is False.
    """
    if not replace and path.exists():
        raise InputError(f"'{path}' exists; give replace=True to replace it, or another name")
    with atomic_write(path) as part, part.open("xb") as handle:
        handle.write(content)
        handle.flush()
        os.fsync(handle.fileno())
    return path


_UNFINISHED_FILES: set[Path] = set()  # files that this process has begun


def drop_pieces() -> None:
    """Remove files that are not whole: for a process that ends without taking its calls back."""
    for piece in tuple(_UNFINISHED_FILES):
        piece.unlink(missing_ok=True)


@cache
def _machine() -> str:
    """Return a digest of what numbers processes: this machine since it was started, and the container on it."""
    text = socket.gethostname()
    with suppress(OSError):
        text += Path("/proc/sys/kernel/random/boot_id").read_text() + os.readlink("/proc/self/ns/pid")
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def drop_orphans(folder: Path) -> None:
    """Remove files that are not whole and never will be: of this user, and of a process that was killed.

    A process of another machine, or of another version of this package, cannot be asked for: what it has begun goes
    when nothing has been written into it for a day.
    """
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if not entry.name.endswith(".part"):  # few of many files do
                continue
            begun = UNFINISHED_FILE_PATTERN.fullmatch(entry.name)
            if begun:
                with suppress(OSError):  # another process removes it just now
                    if not _may_be_written(entry, *begun.groups()):
                        os.unlink(entry)


def _may_be_written(entry: os.DirEntry[str], machine: str, process: str) -> bool:
    """Return whether a file that is not whole may still become whole, or belongs to another user."""
    state = entry.stat(follow_symlinks=False)
    if not stat.S_ISREG(state.st_mode) or (hasattr(os, "geteuid") and state.st_uid != os.geteuid()):
        return True
    if machine == _machine() and os.name == "posix":  # elsewhere to ask for a process may end it
        return _is_alive(int(process))
    return time.time() - state.st_mtime < UNFINISHED_FILE_SECONDS_MAX


def _is_alive(process: int) -> bool:
    """Return whether a process of this number runs."""
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        return True
    return True


@contextmanager
def atomic_write(path: Path) -> Iterator[Path]:
    """Yield a name to write a file under; it takes the place of ``path`` once it is whole, and goes if that fails."""
    part = path.with_name(f".{uuid.uuid4().hex}-{_machine()}-{os.getpid()}.part")  # no longer than any name
    _UNFINISHED_FILES.add(part)
    drop_orphans(path.parent)
    try:
        try:
            yield part
            os.replace(part, path)
        finally:
            part.unlink(missing_ok=True)
            _UNFINISHED_FILES.discard(part)
    except OSError as error:
        raise InputError(
            f"'{path}' cannot be written: {error.strerror}; give a file in a folder that exists, is yours and has space"
        ) from error


def package_version() -> str:
    """Return the version of mbsd3d."""
    return __version__


def read_text(path: Path, limit: int, kind: str = "model") -> str:
    """Read a text file; ValueError if it is missing, a folder or device, too large, empty or not UTF-8."""
    one = with_article(kind)
    try:
        state = path.stat()
        if not stat.S_ISREG(state.st_mode):
            raise InputError(f"'{path}' is a folder or a device; give a file")
        if state.st_size > limit:
            raise InputError(f"'{path}' has {state.st_size} bytes; {one} file has at most {limit}")
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"'{path}' cannot be read: {error.strerror}; give a file that exists") from error
    if not content.strip():
        raise InputError(f"'{path}' is empty; give {one} file")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise InputError(f"'{path}' is not UTF-8 text (line {line}); give {one} file, or save it as UTF-8") from error
