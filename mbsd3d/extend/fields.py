"""Fields of frozen classes: each accepts one type, is converted and checked once, and keeps another."""

from ..lazy import attach

__getattr__, __dir__, __all__ = attach(globals())
