"""Checks of user input; errors name the part, the value and the remedy."""

from ..lazy import attach

__getattr__, __dir__, __all__ = attach(globals())
