"""Where the files lie that a model names: nothing outside of the folders given is looked at."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from ...base.checks import as_tuple, short_repr
from ...base.errors import InputError

PACKAGE_PREFIXES = ("package://", "model://")  # the first part of what follows is the name of a package
PACKAGE_FILES = ("package.xml", "model.config")  # that make a folder a package


class Folders:
    """The folder of a model, and those a user gives in which packages lie."""

    def __init__(self, model: Path, package_paths: Sequence[str | Path] = ()) -> None:
        self.home = model.parent.resolve()
        self.given = tuple(Path(path).resolve() for path in package_paths)
        self.found: set[Path] = set()  # packages of which a file was asked for

    def allow(self, path: Path) -> bool:
        """Return whether a path, its links followed, lies in the folder of the model, or in one that was given or is a
        package that was found.
        """
        try:
            real = path.resolve()
        except (OSError, ValueError, RuntimeError):  # links in a circle, names that no file can have
            return False
        return any(real.is_relative_to(folder) for folder in (self.home, *self.given, *self.found))

    def find(self, name: str, base: Path | None = None) -> Path | None:
        """Return the file of a name as models write it, or None if it is missing or lies elsewhere.

        ``package://name/x`` and ``model://name/x`` are looked up in the folders given, then upwards from the model;
        ``file://`` and plain paths may lead, also by "..", to where files may be. ``base``: folder of relative paths.
        """
        try:
            for scheme in PACKAGE_PREFIXES:
                if name.startswith(scheme):
                    return self.in_package(*name.removeprefix(scheme).partition("/")[::2])
            plain = name.removeprefix("file://")
            path = (base or self.home) / plain.replace("\\", "/")
            return path if "://" not in plain and self.allow(path) and path.is_file() else None
        except (OSError, ValueError):
            return None

    def in_package(self, package: str, inner: str) -> Path | None:
        """Return the file of a package."""
        for folder in self.packages(package):
            path = folder / inner
            inside = path.resolve().is_relative_to(folder.resolve())
            if (inside or self.allow(path)) and path.is_file():
                self.found |= {folder.resolve()} if inside else set()
                return path
        return None

    def packages(self, name: str) -> Iterator[Path]:
        """Return folders that may be the package of a name, the likeliest first.

        Upwards from the model that is a folder of this name in which the model lies, or a neighbour of such folders if
        it says that it is a package.
        """
        if not name.strip(". ") or "/" in name or "\0" in name:
            return
        for given in self.given:
            if given.name == name:
                yield given
            if (given / name).is_dir():
                yield given / name
        for above in (self.home, *self.home.parents):
            if above.name == name:
                yield above
            beside = above / name
            if beside.is_dir() and (above == self.home or any((beside / mark).is_file() for mark in PACKAGE_FILES)):
                yield beside


def as_folders(value: Any) -> tuple[Path, ...]:
    """Return the folders of the argument ``package_paths``, or raise an InputError for one that is none."""
    given = (value,) if isinstance(value, str | Path) else as_tuple(value, "package_paths", "folders")
    for path in given:
        if not isinstance(path, str | Path) or not is_folder(path):
            raise InputError(f"package_paths: {short_repr(path)} is not a folder; give folders in which packages lie")
    return tuple(map(Path, given))


def is_folder(path: str | Path) -> bool:
    """Return whether a path is one of a folder; the empty one is not."""
    try:
        return bool(str(path)) and Path(path).is_dir()
    except (OSError, ValueError):  # names that no file can have
        return False
