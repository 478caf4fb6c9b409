"""Demos: what a demo measures, its theory, figures and parameters."""

from ..lazy import attach

__getattr__, __dir__, __all__ = attach(globals())
