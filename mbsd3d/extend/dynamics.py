"""The mechanism as rows and forces, rotations, and the equations of motion at one state."""

from ..lazy import attach

__getattr__, __dir__, __all__ = attach(globals())
