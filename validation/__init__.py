"""Evidence: closed forms, reference cases and comparisons with other engines, all through the public interface.

The functions of ``__init__.pyi`` are imported on first use: the closed forms do not need the package they judge.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
