"""Demos: one file per effect that exists only in space, each checked against theory. See `form` for what one is.

``demos.run("helicopter_90", Omega=30.0).quantities["lag_deg"].computed``
"""

from .discovery import discover as discover
from .discovery import run as run
