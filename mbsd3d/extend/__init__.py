"""Interface for packages built on mbsd3d, by topic; every name can be imported from here too.

``from mbsd3d.extend import number`` or ``from mbsd3d.extend.checks import number``. These names keep their meaning
within a minor version; all other modules below ``mbsd3d`` are internal and may move. Stubs list the names; each is
imported on first use.
"""

from ..lazy import attach

__getattr__, __dir__, __all__ = attach(globals())
