"""What a package built on mbsd3d may use besides the public names: parts of a command line, of pages and of checks.

``from mbsd3d.extend import number, write_atomically``. These names keep their meaning within a minor version; all other
modules below ``mbsd3d`` are internal and may move. ``extend.pyi`` lists them; each is imported on first use.
"""

from .lazy import attach

__getattr__, __dir__, __all__ = attach(globals())
