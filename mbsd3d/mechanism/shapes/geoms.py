"""Shapes of imported bodies, from MuJoCo's geoms (`import_worker`); meshes, planes and height fields have none here."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...base.quaternions import conjugate, multiply
from .base import Shape
from .kinds import Box, Capsule, Cylinder, Ellipsoid, Sphere


def shapes(geoms: list[Mapping[str, Any]], r: np.ndarray, e: np.ndarray, R: np.ndarray) -> list[Shape] | None:
    """Shapes of the geoms of a body at (r, e), with R = matrix(e); None where none can be drawn."""
    found = []
    for geom in geoms:
        a, b, c = geom["size"]
        place = {
            "at": R.T @ (np.array(geom["position"]) - r),
            "orientation": multiply(conjugate(e), np.array(geom["quaternion"])),
            "colour": geom["colour"] and "#" + bytes(round(255 * x) for x in geom["colour"]).hex(),
        }
        sizes = {
            "box": (Box, ((2 * a, 2 * b, 2 * c),)),
            "sphere": (Sphere, (a,)),
            "capsule": (Capsule, (a, 2 * b)),
            "cylinder": (Cylinder, (a, 2 * b)),
            "ellipsoid": (Ellipsoid, ((a, b, c),)),
        }
        if geom["shown"] and geom["type"] in sizes:
            kind, numbers = sizes[geom["type"]]
            found.append(kind(*numbers, **place))
    return found or None
