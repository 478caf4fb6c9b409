"""Live runs: a model that changes while it moves in a browser; `play_model` takes a `Playable`."""

from ..lazy import attach

__getattr__, __dir__, __all__ = attach(globals())
