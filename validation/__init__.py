"""Evidence: closed forms, reference cases and comparisons with other engines, all through the public interface."""

from typing import Any

__all__ = ["reduce_to_planes"]


def __getattr__(name: str) -> Any:
    """`reduce_to_planes`, imported when it is asked for: the closed forms do not need the package they judge."""
    if name == "reduce_to_planes":
        from validation.reduction import reduce_to_planes

        return reduce_to_planes
    raise AttributeError(f"module 'validation' has no attribute {name!r}")
