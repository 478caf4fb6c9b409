"""Bicycles: models, stability and manoeuvres, on the public interface of `mbsd3d`.

From the ground up: `parameters` - `model` (the mechanism) - `linear` (small motions and their studies) - `riders` -
`rides` and `turns` (nonlinear) - `pages` (figures and pages) - `commands`. The public modules, listed here, load on
first use.
"""

from importlib import import_module
from typing import Any

_MODULES = {
    "parameters": "parameters", "kinematics": "model.kinematics", "models": "model.mechanism",
    "equations": "linear.equations", "general": "linear.general", "critical": "linear.critical",
    "stability": "linear.stability", "sensitivity": "linear.sensitivity", "why": "linear.why",
    "frequency": "linear.frequency", "ride": "rides.ride", "circles": "turns.circles", "compare": "pages.compare",
    "tyres": "model.tyres", "on_tyres": "linear.on_tyres", "rider": "riders.rider", "assist": "riders.assist",
    "course": "rides.course", "handling": "riders.handling", "play": "rides.play",
}  # fmt: skip
_HOME = {
    "Meijaard2007": "parameters",
    "Parameters": "parameters",
    "named": "parameters",
    "whipple": "models",
    "TYPICAL": "tyres",
}

__all__ = [*_HOME, *_MODULES]


def __getattr__(name: str) -> Any:
    """Import a public name on first use."""
    if name in _MODULES:
        value = import_module(f".{_MODULES[name]}", __name__)
    elif name in _HOME:
        value = getattr(import_module(f".{_MODULES[_HOME[name]]}", __name__), name)
    else:
        raise AttributeError(f"module 'bicycle' has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Public names alone."""
    return sorted(__all__)
