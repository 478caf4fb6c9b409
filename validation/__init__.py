"""Evidence: closed forms, reference cases and comparisons with other engines, all through the public interface."""

from typing import Any

__all__ = ["cross_check", "reduce_to_planes"]


def __getattr__(name: str) -> Any:
    """The functions, imported when they are asked for: the closed forms do not need the package they judge."""
    if name == "reduce_to_planes":
        from validation.engine_balance.planes.reduction import reduce_to_planes

        return reduce_to_planes
    if name == "cross_check":
        from validation.crosscheck import cross_check

        return cross_check
    raise AttributeError(f"module 'validation' has no attribute {name!r}")


def __dir__() -> list[str]:
    """Public names alone."""
    return sorted(__all__)
