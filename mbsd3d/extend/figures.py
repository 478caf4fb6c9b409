"""Figures and pages in the style of the package."""

from ..lazy import attach

__getattr__, __dir__, __all__ = attach(globals())
