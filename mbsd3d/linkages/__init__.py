"""Classical closed loops from their textbook parameters, closed at any angle of their first hinge.

>>> from math import radians, sin
>>> from mbsd3d import linkages
>>> a, alpha, beta = 0.3, radians(40), radians(110)
>>> loop = linkages.bennett(a, alpha, a * sin(beta) / sin(alpha), beta, angle=radians(60))
>>> loop.check().mobility
1
"""

from .bennett import bennett, goldberg, myard
from .bricard import bricard, bricard_line, bricard_plane, schatz
from .dh import hinge_loop
from .rssr import rssr
from .sarrus import sarrus

__all__ = [
    "bennett", "bricard", "bricard_line", "bricard_plane", "goldberg", "hinge_loop", "myard", "rssr", "sarrus",
    "schatz",
]  # fmt: skip


def __dir__() -> list[str]:
    """Return the public names alone."""
    return sorted(__all__)
