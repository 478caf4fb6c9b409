"""Bicycles: models, stability and manoeuvres, on the public interface of `mbsd3d`.

From the ground up: `parameters` - `model` (the mechanism) - `linear` (small motions and their studies) - `riders` -
`rides` and `turns` (nonlinear) - `pages` (figures and pages) - `commands`. The public names, listed in
``__init__.pyi``, load on first use.
"""

from mbsd3d.extend import attach

__getattr__, __dir__, __all__ = attach(globals())
