"""What bodies look like."""

from .mechanism.shapes import (
    Box,
    Capsule,
    Cylinder,
    Disc,
    Ellipsoid,
    Hull,
    Lines,
    Mesh,
    MeshFile,
    Shape,
    Solid,
    Sphere,
    Torus,
)  # fmt: skip

__all__ = [
    "Box", "Capsule", "Cylinder", "Disc", "Ellipsoid", "Hull", "Lines", "Mesh", "MeshFile", "Shape", "Solid",
    "Sphere", "Torus",
]  # fmt: skip
