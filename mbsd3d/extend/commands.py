"""Parts of a command line: options, files, progress, work in several processes, names that load on first use."""

from ..lazy import attach

__getattr__, __dir__, __all__ = attach(globals())
