"""Shapes of bodies: only drawn, never computed with.

``Body("leaf", ..., shape=shapes.Box((0.9, 0.04, 2.0)))``; a list of shapes is a compound. A shape is centred on the
centre of mass of its body and aligned with its axes unless ``at`` and ``orientation`` say otherwise. A body without
shapes is drawn as a link between its joints, or as the homogeneous ellipsoid of its mass and inertia.
"""

from .shape import (
    Shape as Shape,
)
from .shape import (
    Solid as Solid,
)
from .triangles import (
    Mesh as Mesh,
)
