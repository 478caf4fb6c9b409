"""Public names that are imported on first use, from one list: the stub beside a module, which editors read too."""

import ast
from collections.abc import Callable
from importlib import import_module
from importlib.util import resolve_name
from pathlib import Path
from typing import Any


def attach(module: dict[str, Any]) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """``__getattr__``, ``__dir__`` and ``__all__`` of a module, given its ``globals()``.

    Its stub says where each name lives: ``from .place import name as name``, ``from . import name as name``,
    ``from package.place import name as name`` for one of a package beside, ``from .part import *`` for all of another
    such module of its package.
    """
    places = places_of(Path(module["__file__"]).with_suffix(".pyi"))
    names = sorted(places)

    def load(name: str) -> Any:
        """The object of a name."""
        if name not in places:
            raise AttributeError(f"module {module['__name__']!r} has no attribute {name!r}")
        place, own = places[name]
        package = module["__spec__"].parent
        if place == ".":
            module[name] = import_module(f".{own}", package)
        else:  # `own` may be in that module, or be a module itself
            module[name] = getattr(__import__(resolve_name(place, package), fromlist=[own]), own)
        return module[name]

    return load, names.copy, names


def places_of(stub: Path) -> dict[str, tuple[str, str]]:
    """Return name -> (module, name there) of all names that a stub lists."""
    tree = ast.parse(stub.read_text(encoding="utf-8"))
    places: dict[str, tuple[str, str]] = {}
    for node in (node for node in tree.body if isinstance(node, ast.ImportFrom)):
        place = "." * node.level + (node.module or "")
        if node.names[0].name == "*":
            places |= {name: (place, name) for name in places_of(stub.parent / f"{node.module}.pyi")}
        else:
            places |= {alias.asname or alias.name: (place, alias.name) for alias in node.names}
    return places
