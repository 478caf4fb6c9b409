"""Digest of all sources of the page of a demo: it is written again only if that changes."""

import ast
import hashlib
import sys
from functools import cache
from importlib.util import resolve_name
from pathlib import Path
from types import ModuleType

from .form import Demo

PACKAGE_FOLDER = Path(__file__).parent.parent
SOURCE_SUFFIXES = {".py", ".js", ".css", ".html"}


def digest(demo: Demo, following: Demo) -> str:
    """Return the digest of the package, of the demo with its helpers, and of name and title of the demo its page leads
    to.
    """
    files = sorted(Path(module.__file__) for module in needed(sys.modules[demo.module]))
    texts = [common(), following.name, following.title, *(path.read_text(encoding="utf-8") for path in files)]
    return hashlib.sha256("\n".join(texts).encode()).hexdigest()


def needed(module: ModuleType) -> set[ModuleType]:
    """Return the module and, of its package, what it imports; without the files that all demos share."""
    found, waiting = set(), [module]
    while waiting:
        here = waiting.pop()
        found.add(here)
        package = here.__name__ if hasattr(here, "__path__") else here.__name__.rpartition(".")[0]
        for node in ast.walk(ast.parse(Path(here.__file__).read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.level:
                base = resolve_name("." * node.level + (node.module or ""), package)
                named = [sys.modules.get(name) for name in (base, *(f"{base}.{word.name}" for word in node.names))]
                waiting += [x for x in named if x and x not in found and Path(x.__file__) not in shared()]
    return found


@cache
def shared() -> frozenset[Path]:
    """Return the files of the package, scripts and templates too, but for the families of demos."""
    families = PACKAGE_FOLDER / "demos"
    return frozenset(
        x for x in PACKAGE_FOLDER.rglob("*") if x.suffix in SOURCE_SUFFIXES and families not in x.parent.parents
    )


@cache
def common() -> str:
    """Return the digest of the shared files."""
    return hashlib.sha256(b"".join(path.read_bytes() for path in sorted(shared()))).hexdigest()
