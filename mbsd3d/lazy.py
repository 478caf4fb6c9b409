"""Public names that are imported on first use, from one list: the stub beside a module, which editors read too."""

import ast
from collections.abc import Callable
from importlib import import_module
from importlib.util import resolve_name
from pathlib import Path
from typing import Any


def attach(module: dict[str, Any]) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """``__getattr__``, ``__dir__`` and ``__all__`` of a module, given its ``globals()``.

    Its stub says where each name lives: ``from .place import name as name``, ``from . import name as name``, or
    ``from package.place import name as name`` for one of a package beside.
    """
    stub = ast.parse(Path(module["__file__"]).with_suffix(".pyi").read_text(encoding="utf-8"))
    lines = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    places = {
        alias.asname: ("." * node.level + (node.module or ""), alias.name) for node in lines for alias in node.names
    }
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
