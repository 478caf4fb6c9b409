"""Evidence: closed forms, reference cases and comparisons with other engines, all through the public interface.

The functions of ``__init__.pyi`` are imported on first use: the closed forms load nothing of what they judge.
"""

from mbsd3d.extend import attach

__getattr__, __dir__, __all__ = attach(globals())
