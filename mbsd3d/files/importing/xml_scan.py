"""What an XML model would open or multiply, found before anything opens it.

Models may name other models only inside its own folder and those that were given, and nothing may grow beyond a limit:
MuJoCo reads any path an include names, and makes as many copies of a body as it says.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any
from xml.parsers import expat

from ...base.errors import InputError
from ...base.paths import read_text
from .folders import Folders

FILES_BYTES_MAX = 8_000_000  # [bytes] of all files together
EXPANDED_ELEMENTS_MAX = 20_000  # [elements] after all copies are made
INCLUDED_FILES_MAX = 100  # [files] models that are included
NAMED_FILES_MAX, FOLDERS_MAX = 2000, 10  # [1] other files, and folders they are looked for in
MESH_FOLDERS = ("meshdir", "texturedir", "assetdir")
COPYING_ELEMENTS = ("replicate", "composite", "flexcomp")
INCLUDING_ELEMENTS = ("include", "model")  # their files are models again
# what they name is opened where it is needed, or not at all
LOOK_ELEMENTS = ("mesh", "texture", "hfield", "skin", "material")
NAMING_SECTIONS = ("equality", "tendon", "actuator", "contact")  # whose elements have names of their own


class Parser:
    """An XML parser that declares no entities and opens nothing, with the place of what it reads."""

    def __init__(self, path: Path) -> None:
        self.path, self.above = path, 0

    def parse(
        self, text: str, start: Callable[..., None], end: Callable[..., None], words: Callable[..., None] | None = None
    ) -> None:
        """Call ``start(name, attributes)`` and ``end(name)`` for the elements of a text, ``words(text)`` inside.

        Blank lines may come first.
        """
        self.parser = expat.ParserCreate("utf-8")
        self.parser.StartElementHandler, self.parser.EndElementHandler = start, end
        self.parser.EntityDeclHandler = self.entity
        if words is not None:
            self.parser.CharacterDataHandler, self.parser.buffer_text = words, True
        content = text.lstrip("\ufeff \t\r\n")
        self.above = text[: len(text) - len(content)].count("\n")
        try:
            self.parser.Parse(content.encode(), True)
        except expat.ExpatError as error:
            message, line = expat.ErrorString(error.code), error.lineno + self.above
            raise InputError(f"'{self.path}', line {line}: no XML ({message}); correct the file") from error

    @property
    def line(self) -> int:
        """Return the line that is being read."""
        return self.parser.CurrentLineNumber + self.above

    def place(self, what: str) -> str:
        """Return file, line and element for messages."""
        return f"'{self.path}', line {self.line}: {what}"

    def entity(self, name: str, *rest: Any) -> None:
        """Refuse entities: models need none."""
        raise InputError(f"{self.place(f'entity {name}')} is declared; write its text where it is used")


@dataclass
class Scan:
    """A model, given by its file ``root``, and all it includes."""

    root: Path
    folders: Folders
    bytes: int = 0
    copies: int = 0
    files: int = 0
    kind: str = ""
    whole: bool = False  # whether the mass of all bodies together is given, which MuJoCo does not tell
    bases: set[str] = field(default_factory=lambda: {"."})
    named: dict[str, str] = field(default_factory=dict)  # file -> place, of everything but looks that is opened
    places: dict[tuple[str, str], str] = field(default_factory=dict)  # (tag or section, name) -> line and element

    def read(self, path: Path, times: int = 1) -> None:
        """Scan one file that is copied ``times`` times."""
        self.files += 1
        if self.files > INCLUDED_FILES_MAX:
            raise InputError(f"'{self.root}': more than {INCLUDED_FILES_MAX} files are included; put them into one")
        text = read_text(path, FILES_BYTES_MAX - self.bytes)
        self.bytes += path.stat().st_size
        File(self, path, times).parse(text)

    def check_named(self) -> None:
        """Check that every file that is named lies where files may be, links followed."""
        if len(self.named) > NAMED_FILES_MAX or len(self.bases) > FOLDERS_MAX:
            raise InputError(
                f"'{self.root}': names more than {NAMED_FILES_MAX} files or {FOLDERS_MAX} folders; use fewer"
            )
        for name, place in self.named.items():
            for base in self.bases:
                for candidate in {name, PurePosixPath(name).name}:
                    self.inside(self.root.parent / base / candidate, place)

    def inside(self, path: Path, place: str) -> None:
        """Refuse a path that leads elsewhere, perhaps by links."""
        if not self.folders.allow(path):
            raise InputError(
                f"{place} leads out of the folder of the model; copy '{path.name}' into the folder, or give the folder "
                "it lies in with package_paths"
            )

    def place_of(self, tag: str, name: str) -> str:
        """Return line and element of a part by its name, "" if nobody knows."""
        return self.places.get((tag, name), "")


def relative(name: str, place: str) -> None:
    """Refuse a path that has a root."""
    outer = name.startswith(("/", "\\", "~")) or ":" in name or PureWindowsPath(name).drive
    if outer or "\0" in name:
        raise InputError(f"{place} names '{name}', outside of the folder of the model; copy it there, give its name")


class File:
    """One file while it is parsed."""

    def __init__(self, scan: Scan, path: Path, times: int) -> None:
        self.scan, self.path, self.parser = scan, path, Parser(path)
        self.stack: list[str] = []
        self.times = [times]

    def parse(self, text: str) -> None:
        """Call the methods below for the elements of a text."""
        self.parser.parse(text, self.start, self.end)

    def start(self, name: str, attributes: dict[str, str]) -> None:
        """Read the start of an element."""
        scan, place = self.scan, self.parser.place(f"<{name}>")
        if not self.stack:
            scan.kind = scan.kind or name
        if name in ("plugin", "extension"):
            raise InputError(f"{place} asks for a plugin; plugins run foreign code and are not loaded")
        self.times.append(self.times[-1] * (copies(attributes, place) if name in COPYING_ELEMENTS else 1))
        scan.copies += self.times[-1]
        if scan.copies > EXPANDED_ELEMENTS_MAX:
            raise InputError(f"{place} makes more than {EXPANDED_ELEMENTS_MAX} elements of the model; use fewer copies")
        file = "" if self.path == scan.root else f"'{self.path.name}', "
        section = self.stack[-1] if self.stack and self.stack[-1] in NAMING_SECTIONS else name
        key = ("joint" if section == "freejoint" else section, attributes.get("name", ""))
        scan.places.setdefault(key, f"{file}line {self.parser.line}, <{name}>")
        self.stack.append(name)
        for attribute, value in attributes.items():
            scan.whole = scan.whole or (attribute == "settotalmass" and not value.strip().startswith("-"))
            if attribute in MESH_FOLDERS:
                scan.bases.add(value)
            elif attribute.startswith("file") and name not in LOOK_ELEMENTS:
                relative(value, f"{place} {attribute}")
                if name in INCLUDING_ELEMENTS:
                    self.open(value, place)
                if name != "include":  # MuJoCo looks for it beside the model, for others in the folders of meshes too
                    scan.named.setdefault(value, f"{place} {attribute}")

    def open(self, name: str, place: str) -> None:
        """Scan a file that is included: beside the model, or beside the file that names it."""
        self.scan.bases.add(str(self.path.parent.absolute()))
        for folder in dict.fromkeys((self.scan.root.parent, self.path.parent)):
            self.scan.inside(folder / name, place)
            if (folder / name).is_file():
                self.scan.read(folder / name, self.times[-1])

    def end(self, name: str) -> None:
        """Read the end of an element."""
        self.stack.pop()
        self.times.pop()


def copies(attributes: dict[str, str], place: str) -> int:
    """Return how often an element is copied: the product of its counts."""
    product = 1
    for word in attributes.get("count", "1").split():
        try:
            product *= max(int(word), 1)
        except ValueError:
            raise InputError(f"{place} has the count '{word[:40]}'; give a whole number") from None
    return product
