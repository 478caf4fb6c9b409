"""A solid of every kind, and its mesh."""

import trimesh

from mbsd3d import Body
from mbsd3d.shapes import Box, Capsule, Cylinder, Disc, Ellipsoid, Sphere, Torus

PLAIN = Body("plain", 1.0, (1, 1, 1))

SOLIDS = (
    Box((0.3, 0.4, 0.7)), Ellipsoid((0.3, 0.4, 0.7)), Sphere(0.6), Cylinder(0.3, 0.8, "x"), Disc(0.4, axis="y"),
    Torus(0.4, 0.1, (1, 2, -2)), Capsule(0.2, 0.5, (0.3, -0.2, 0.7)),
)  # fmt: skip


def solid(shape, body=PLAIN):
    """The mesh of a shape in trimesh, with its vertices merged."""
    mesh = shape.mesh(body)
    return trimesh.Trimesh(mesh.vertices, mesh.faces)
