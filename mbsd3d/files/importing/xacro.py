"""Files that xacro expands: ``python -m mbsd3d.files.importing.xacro FILE SECONDS FOLDER ...`` prints the result.

It runs in a process with limits on time and memory that may open files in the folders given only.
"""

import os
import re
import sys
from collections.abc import Iterable
from math import ceil
from pathlib import Path
from types import ModuleType
from typing import Any

from ...base.errors import InputError
from .folders import Folders
from .guarded import answer_of, reply

COMMENT_PATTERN = re.compile(r"<!--.*?-->", re.DOTALL)
XACRO_MARKS = ("${", "$(", "<xacro:")
# events of Python: nothing is run or sent
FORBIDDEN_EVENTS = ("os.", "subprocess.", "socket.", "shutil.", "ctypes.", "pty.")
IMPORT_EVENTS = ("os.listdir", "os.scandir", "os.walk", "os.fwalk")  # of importing a module


def is_xacro(path: Path, text: str) -> bool:
    """Return whether a text has to go through xacro, by what is in it; its output keeps the name space only."""
    return any(mark in COMMENT_PATTERN.sub("", text) for mark in XACRO_MARKS)


def expanded(path: Path, folders: Folders, timeout: float) -> str:
    """Return what xacro makes of a file, or raise an InputError with the command to run elsewhere."""
    arguments = [str(path.absolute()), str(ceil(timeout)), *map(str, folders.given)]
    try:
        answer = answer_of("mbsd3d.files.importing.xacro", arguments, timeout, "xacro")
    except InputError as error:
        raise InputError(f"'{path}': {error}") from error
    if "error" in answer:
        raise InputError(f"'{path}': xacro: {answer['error']}")
    return answer["text"]


def run(path: str, folders: Folders) -> str:
    """Expand a file in this process, which then can open files in the folders given only."""
    try:
        import xacro
        import yaml  # noqa: F401 - before files are watched
    except ImportError:
        stem = Path(path).name.split(".")[0]
        raise InputError(
            f"it needs xacro, which is not installed here; pip install xacro, or give what it makes: "
            f"xacro {Path(path).name} > {stem}.urdf"
        ) from None
    sys.modules["ament_index_python"] = sys.modules["ament_index_python.packages"] = Finder(folders)
    watch(folders)
    return xacro.process_file(path).toprettyxml()


class Finder(ModuleType):
    """What xacro asks for the folder of a package: the folders given, then upwards from the file."""

    def __init__(self, folders: Folders) -> None:
        super().__init__("ament_index_python.packages")
        self.folders, self.packages = folders, self

    def get_package_share_directory(self, package: str) -> str:
        """Return the folder of a package."""
        for folder in self.folders.packages(package):
            return str(folder)
        raise InputError(f"$(find {package}): there is no such package; give the folder it lies in with package_paths")


def watch(folders: Folders) -> None:
    """Refuse, from now on, whatever opens a file elsewhere, starts a program or asks the network."""
    libraries = [Path(place).resolve() for place in (sys.prefix, sys.base_prefix, os.__file__) if place]

    def hook(event: str, arguments: Any) -> None:
        if event == "open" and isinstance(arguments[0], str | bytes | os.PathLike):
            path, mode = Path(os.fsdecode(arguments[0])), str(arguments[1] or "r")
            writes = any(letter in mode for letter in "wax+")
            inside = path.suffix in (".py", ".pyc", ".so") and within(path, libraries)
            if writes or not (folders.allow(path) or any_package(path, folders) or inside):
                raise InputError(f"it opens '{path}', outside of its folder and of package_paths; give the folder")
        elif event.startswith(FORBIDDEN_EVENTS) and event not in IMPORT_EVENTS:
            raise InputError(f"it asks for '{event}', which is not done; leave it out")

    sys.addaudithook(hook)


def within(path: Path, folders: Iterable[Path]) -> bool:
    """Return whether a path lies in one of some folders."""
    real = path.resolve()
    return any(real.is_relative_to(folder) for folder in folders)


def any_package(path: Path, folders: Folders) -> bool:
    """Return whether a path lies in a package that the file lies in, or a neighbour of it."""
    real = path.resolve()
    return any(real.is_relative_to(folder) for part in real.parts for folder in folders.packages(part))


def main() -> None:
    """Print ``{"text": ...}`` or ``{"error": ...}``."""
    path, seconds, *given = sys.argv[1:]
    reply(int(seconds), lambda: {"text": run(path, Folders(Path(path), given))})


if __name__ == "__main__":
    main()
