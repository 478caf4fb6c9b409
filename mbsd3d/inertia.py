"""Moments and products of inertia of simple solids, and of parts put together."""

from .base.inertia import *
