"""Evidence: closed forms, reference cases and comparisons with other engines, all through the public interface.

Functions are imported when they are asked for: the closed forms do not need the package they judge.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={"crosscheck": ["cross_check"], "engine_balance.planes.reduction": ["reduce_to_planes"]},
)
