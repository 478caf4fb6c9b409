"""Spatial multibody dynamics in reference coordinates, written like the textbook and checked like an instrument.

All public names are here; ``__init__.pyi`` says where each lives. They are imported on first use, so that the command
line starts fast.
"""

from .lazy import attach

__getattr__, __dir__, __all__ = attach(globals())
