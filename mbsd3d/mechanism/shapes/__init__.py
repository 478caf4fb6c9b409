"""Shapes of bodies: only drawn, never computed with.

``Body("leaf", ..., shape=shapes.Box((0.9, 0.04, 2.0)))``; a list of shapes is a compound. A shape is centred on the
centre of mass of its body and aligned with its axes unless ``at`` and ``orientation`` say otherwise.

- `kinds`: Box, Ellipsoid, Sphere, Cylinder, Disc, Torus, Capsule, MeshFile, Lines
- `base`: what they share: a place in the body, a colour, a surface
- `surfaces`: their triangles, and those of mesh files
- `guesses`: what a body without shapes looks like, from its mass and inertia
- `geoms`: shapes of models of MuJoCo
"""

from .base import Shape, Solid
from .kinds import Box, Capsule, Cylinder, Disc, Ellipsoid, Lines, MeshFile, Sphere, Torus
from .surfaces import Mesh
