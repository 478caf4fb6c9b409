"""Mechanisms as trees of joints with loop closures, as engines in joint coordinates need them."""

from ..lazy import attach

__getattr__, __dir__, __all__ = attach(globals())
