"""Spatial multibody dynamics in reference coordinates, written like the textbook and checked like an instrument.

All public names are here; ``__init__.pyi`` says where each lives. They are imported on first use, so that the command
line starts fast.
"""

import lazy_loader

from .base.version import __version__ as __version__

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
