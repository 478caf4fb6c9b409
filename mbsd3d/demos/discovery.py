"""Discovery of demos: in the folders here, one per family, and in other packages."""

import pkgutil
from collections.abc import Iterator, Mapping
from importlib import import_module, metadata
from types import ModuleType

from ..base.errors import InputError
from ..base.version import load_entry
from .base import Outcome
from .form import Demo
from .parameters import listed

GROUP = "mbsd3d.demos"


class Demos(dict[str, Demo]):
    """Demos by name; ``broken`` says of each entry point that could not be loaded why not."""

    def __init__(self, demos: Mapping[str, Demo], broken: Mapping[str, str]) -> None:
        super().__init__(demos)
        self.broken = dict(broken)

    def find(self, name: str) -> Demo:
        """Return a demo by its name, with - or _ between the words."""
        key = name.replace("-", "_")
        if key not in self:
            raise InputError(f"there is no demo '{name}'; {listed(key, list(self))}")
        return self[key]

    def families(self) -> dict[str, list[Demo]]:
        """Return the demos by family."""
        found: dict[str, list[Demo]] = {}
        for demo in self.values():
            found.setdefault(demo.family, []).append(demo)
        return found


def discover() -> Demos:
    """Return all demos by name: those of this folder, then the entry points of "mbsd3d.demos", a demo or a folder of
    demos.

    Entry points that cannot be loaded, or whose name is taken, are in ``broken``.
    """
    found, broken = own_demos(), {}
    for entry in metadata.entry_points(group=GROUP):
        try:
            for demo in demos_of(load_entry(entry, Demo, ModuleType)):
                if demo.name in found:
                    raise InputError(f"a demo is already named '{demo.name}'; rename one")
                found[demo.name] = demo
        except ValueError as error:
            broken[entry.name] = str(error)
    return Demos(found, broken)


def own_demos() -> dict[str, Demo]:
    """Return the demos of this folder: families in the order of their PLACE, each in the order of its names."""
    return {demo.name: demo for demo in walk(import_module(__name__.rpartition(".")[0]))}


def demos_of(loaded: object) -> Iterator[Demo]:
    """Yield a demo itself, or every demo of a package."""
    if isinstance(loaded, ModuleType):
        yield from walk(loaded)
    elif isinstance(loaded, Demo):
        yield loaded


def walk(package: ModuleType) -> Iterator[Demo]:
    """Yield every ``demo`` of the modules of a package and of the packages in it."""
    names = sorted(found.name for found in pkgutil.iter_modules(package.__path__))
    modules = [import_module(f"{package.__name__}.{name}") for name in names]
    for module in sorted(modules, key=lambda found: getattr(found, "PLACE", 0)):
        if hasattr(module, "__path__"):
            yield from walk(module)
        elif isinstance(getattr(module, "demo", None), Demo):
            yield module.demo


def run(name: str, without: str | None = None, /, **parameters: object) -> Outcome:
    """Run a demo by its name with some parameters changed: ``run("helicopter_90", Omega=30.0)``."""
    return discover().find(name).run(without, **parameters)
