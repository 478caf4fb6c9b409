"""Moments and products of inertia of simple solids, and of parts put together."""

from .base.inertia import *
from .base.inertia import __all__ as __all__
