"""Bicycles: models, stability and manoeuvres, on the public interface of `mbsd3d`."""

from importlib import import_module
from typing import Any

_HOME = {"Meijaard2007": "parameters", "Parameters": "parameters", "named": "parameters", "whipple": "models"}
_MODULES = (
    "parameters", "models", "kinematics", "equations", "general", "critical",
    "stability", "sensitivity", "why", "ride", "circles", "frequency", "compare",
)  # fmt: skip

__all__ = [*_HOME, *_MODULES]


def __getattr__(name: str) -> Any:
    """Import a public name on first use."""
    if name in _HOME:
        value = getattr(import_module(f".{_HOME[name]}", __name__), name)
    elif name in _MODULES:
        value = import_module(f".{name}", __name__)
    else:
        raise AttributeError(f"module 'bicycle' has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
