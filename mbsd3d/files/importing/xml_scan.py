"""What an XML model would open or multiply, found before anything opens it.

A file may name files only inside its own folder, and nothing may grow beyond a limit: MuJoCo reads any path an include
names, and makes as many copies of a body as it says.
"""

from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any
from xml.parsers import expat

from ...base.errors import InputError
from ...base.paths import read_text

LIMIT = 8_000_000  # [bytes] of all files together
COPIES = 20_000  # elements after all copies are made
FILES, NAMED, BASES = 100, 2000, 10  # models that are included, other files, and folders they are looked for in
FOLDERS = ("meshdir", "texturedir", "assetdir")
COUNTED = ("replicate", "composite", "flexcomp")
OPENED = ("include", "model")  # elements whose files are models again
URDF = frozenset(
    "robot mujoco link joint inertial origin mass inertia visual collision geometry box sphere cylinder capsule mesh "
    "material color texture parent child axis limit dynamics mimic calibration verbose".split()
)


@dataclass
class Scan:
    """A model, given by its file ``root``, and all it includes."""

    root: Path
    bytes: int = 0
    copies: int = 0
    files: int = 0
    kind: str = ""
    folders: set[str] = field(default_factory=lambda: {"."})
    named: dict[str, str] = field(default_factory=dict)  # file -> place, of everything that is opened
    unknown: list[tuple[str, str]] = field(default_factory=list)  # elements of URDF that MuJoCo passes over

    def read(self, path: Path, times: int = 1) -> None:
        """Scan one file that is copied ``times`` times."""
        self.files += 1
        if self.files > FILES:
            raise InputError(f"'{self.root}': more than {FILES} files are included; put them into one")
        text = read_text(path, LIMIT - self.bytes)
        self.bytes += path.stat().st_size
        File(self, path, times).parse(text)

    def check_named(self) -> None:
        """Every file that is named lies in the folder of the model, links followed; URDF may drop its folders."""
        if len(self.named) > NAMED or len(self.folders) > BASES:
            raise InputError(f"'{self.root}': names more than {NAMED} files or {BASES} folders; use fewer")
        for name, place in self.named.items():
            for base in self.folders:
                for candidate in {name, PurePosixPath(name).name}:
                    self.inside(self.root.parent / base / candidate, place)

    def inside(self, path: Path, place: str) -> None:
        """Refuse a path whose links lead elsewhere."""
        if not path.resolve().is_relative_to(self.root.parent.resolve()):
            raise InputError(f"{place} leads out of the folder of the model; copy '{path.name}' into the folder")


def inner(name: str, place: str) -> str:
    """A relative path that stays below its folder."""
    name = name.removeprefix("package://")
    parts = PurePosixPath(name.replace("\\", "/")).parts
    outer = name.startswith(("/", "\\", "~")) or ".." in parts or ":" in name or PureWindowsPath(name).drive
    if outer or "\0" in name:
        raise InputError(f"{place} names '{name}', outside of the folder of the model; copy it there, give its name")
    return name


class File:
    """One file while it is parsed; expat resolves no external entities by itself."""

    def __init__(self, scan: Scan, path: Path, times: int) -> None:
        self.scan, self.path = scan, path
        self.stack: list[str] = []
        self.times = [times]

    def parse(self, text: str) -> None:
        """Call the methods below for the elements of a text."""
        self.parser = expat.ParserCreate()
        self.parser.StartElementHandler, self.parser.EndElementHandler = self.start, self.end
        self.parser.EntityDeclHandler = self.entity
        try:
            self.parser.Parse(text.encode(), True)
        except expat.ExpatError as error:
            message = expat.ErrorString(error.code)
            raise InputError(f"'{self.path}', line {error.lineno}: no XML ({message}); correct the file") from error

    def place(self, what: str) -> str:
        """File, line and element for messages."""
        return f"'{self.path}', line {self.parser.CurrentLineNumber}: {what}"

    def entity(self, name: str, *rest: Any) -> None:
        """Models need no entities."""
        raise InputError(f"{self.place(f'entity {name}')} is declared; write its text where it is used")

    def start(self, name: str, attributes: dict[str, str]) -> None:
        """One element."""
        scan, place = self.scan, self.place(f"<{name}>")
        if not self.stack:
            scan.kind = scan.kind or name
        passed = scan.kind == "robot" and "mujoco" not in self.stack and not URDF.issuperset([*self.stack, name])
        if passed and URDF.issuperset(self.stack):  # what it holds is passed over with it
            scan.unknown.append(("extension", f"<{name}> in line {self.parser.CurrentLineNumber}"))
        if name in ("plugin", "extension") and not passed:
            raise InputError(f"{place} asks for a plugin; plugins run foreign code and are not loaded")
        self.times.append(self.times[-1] * (copies(attributes, place) if name in COUNTED else 1))
        self.stack.append(name)
        scan.copies += self.times[-1]
        if scan.copies > COPIES:
            raise InputError(f"{place} makes more than {COPIES} elements of the model; use fewer copies")
        for key, value in attributes.items():
            if key in FOLDERS:
                scan.folders.add(inner(value, f"{place} {key}"))
            elif key.startswith("file"):
                scan.named.setdefault(inner(value, f"{place} {key}"), f"{place} {key}")
                if name in OPENED:
                    self.open(value, place)

    def open(self, name: str, place: str) -> None:
        """Scan a file that is included: beside the model, or beside the file that names it."""
        self.scan.folders.add(str(self.path.parent.relative_to(self.scan.root.parent)))
        for folder in dict.fromkeys((self.scan.root.parent, self.path.parent)):
            if (folder / name).is_file():
                self.scan.inside(folder / name, place)
                self.scan.read(folder / name, self.times[-1])

    def end(self, name: str) -> None:
        """The end of an element."""
        self.stack.pop()
        self.times.pop()


def copies(attributes: dict[str, str], place: str) -> int:
    """How often an element is copied: the product of its counts."""
    product = 1
    for word in attributes.get("count", "1").split():
        try:
            product *= max(int(word), 1)
        except ValueError:
            raise InputError(f"{place} has the count '{word[:40]}'; give a whole number") from None
    return product
