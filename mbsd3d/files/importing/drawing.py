"""Shapes from the geometry of a file."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ...base.errors import InputError
from ...base.quaternions import conjugate, multiply
from ...mechanism.shapes.base import Shape
from ...mechanism.shapes.kinds import Box, Capsule, Cylinder, Ellipsoid, MeshFile, Sphere
from .tree import Facts

SIZES: dict[str, tuple[type[Shape], Callable[[float, float, float], tuple[Any, ...]]]] = {
    "box": (Box, lambda a, b, c: ((2 * a, 2 * b, 2 * c),)),
    "sphere": (Sphere, lambda a, b, c: (a,)),
    "capsule": (Capsule, lambda a, b, c: (a, 2 * b)),
    "cylinder": (Cylinder, lambda a, b, c: (a, 2 * b)),
    "ellipsoid": (Ellipsoid, lambda a, b, c: ((a, b, c),)),
}
"""Kinds of geometry with a shape of their own, and its sizes."""


def drawn(geoms: list[Facts], r: np.ndarray, e: np.ndarray, R: np.ndarray, missing: list[str]) -> list[Shape] | None:
    """Shapes of the geometry of a body at (r, e), R = matrix(e); None where none can be drawn.

    Files that cannot be drawn are added to ``missing``.
    """
    found: list[Shape] = []
    for geom in geoms:
        place = {
            "at": R.T @ (np.array(geom["position"]) - r),
            "orientation": multiply(conjugate(e), np.array(geom["quaternion"])),
            "colour": geom["colour"] and "#" + bytes(round(255 * x) for x in geom["colour"]).hex(),
        }
        if geom["shown"] and geom["type"] in SIZES:
            kind, sizes = SIZES[geom["type"]]
            found.append(kind(*sizes(*geom["size"]), **place))
        elif geom["shown"] and geom["type"] == "file":
            found += mesh(geom, place, missing)
    return found or None


def mesh(geom: Facts, place: dict[str, Any], missing: list[str]) -> list[Shape]:
    """The shape of a mesh file, read once so that a drawing will not fail; none, and the file missing, if it cannot."""
    try:
        shape = MeshFile(geom["path"], geom["scale"], **place)
        shape.surface()
    except InputError as error:
        missing.append(str(error))
        return []
    return [shape]
