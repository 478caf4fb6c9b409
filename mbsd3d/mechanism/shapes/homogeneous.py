"""The shapes of a body: as given, or the homogeneous solid of its mass and inertia."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.errors import InputError
from ...base.fields import Stored
from ...base.rotations import quaternion_from_matrix
from .shape import Shape, Shaped
from .solids import Box, Cylinder, Ellipsoid, Lines

HOMOGENEOUS_SHAPES = ("ellipsoid", "box", "cylinder")
SHAPE_CHOICES = (
    "give 'ellipsoid', 'box', 'cylinder', a shape such as shapes.Box((0.2, 0.1, 0.3)), a list of shapes, or a (k, 3) "
    "polyline in body axes [m]"
)
EQUAL_MOMENT_TOLERANCE = 1e-6  # [1] relative difference of principal moments that count as equal
DRAWN_THICKNESS_MIN = 0.02  # [1] of the largest extent of rods and plates, so that one sees them


def as_shape(shape: Any, what: str, body: Shaped) -> str | Shape | tuple[Shape, ...] | None:
    """Convert the shape of a body: None, one of the texts, a shape, or a tuple of shapes.

    ValueError, naming the body, for an unknown shape or a solid that cannot have the inertia of this body.
    """
    if shape is None or isinstance(shape, Shape):
        return shape
    if isinstance(shape, list | tuple) and shape and all(isinstance(item, Shape) for item in shape):
        return tuple(shape)
    if isinstance(shape, str) and shape in HOMOGENEOUS_SHAPES:
        if shape == "cylinder" or not body.inertia.any():  # any other inertia has an ellipsoid and a box
            homogeneous(body, shape)
        return shape
    try:
        return Lines(shape)
    except ValueError:
        raise InputError(f"body '{body.name}': shape {repr(shape)[:80]} is unknown; {SHAPE_CHOICES}") from None


class ShapeOfBody(Stored[Shape | Sequence[Shape] | str | ArrayLike | None, Shape | tuple[Shape, ...] | str | None]):
    """How a body is drawn: shapes, the name of a homogeneous solid, or a polyline; None = a link or the ellipsoid."""

    accepts, role, file_type = "Shape | Sequence[Shape] | str | array_like | None", "shape", dict | str | list
    convert = staticmethod(as_shape)


def shapes_of(body: Shaped) -> tuple[Shape, ...]:
    """Return the shapes of a body; none for one without inertia and shape."""
    shape = body.shape
    if shape is None and not body.inertia.any():
        return ()
    if shape is None or isinstance(shape, str):
        return (homogeneous(body, shape or "ellipsoid"),)
    return (shape,) if isinstance(shape, Shape) else shape


def homogeneous(body: Shaped, kind: str) -> Shape:
    """Return the homogeneous solid with the mass and inertia of a body, about its centre of mass in its principal axes.

    With moments per mass j and s = (j1 + j2 + j3) - 2 j: half axes sqrt(5 s / 2) of an ellipsoid, edges sqrt(6 s) of a
    box; radius sqrt(2 j_along) and length sqrt(12 j_across - 6 j_along) of a cylinder. At least a fiftieth as thick as
    it is long. ValueError, naming the body, without inertia or for a cylinder where no two principal moments are equal.
    """
    if not body.inertia.any():
        raise InputError(
            f"body '{body.name}': shape '{kind}' follows from its inertia, which is 0; give a shape with sizes or None"
        )
    moments, axes = principal(body.inertia / body.mass)
    place: dict[str, Any] = {"orientation": quaternion_from_matrix(axes)}
    squares = np.maximum(moments.sum() - 2.0 * moments, 0.0)
    if kind == "cylinder":
        return round_solid(body, moments, place)
    if kind == "box":
        return Box(thick(np.sqrt(6.0 * squares)), **place)
    return Ellipsoid(thick(np.sqrt(2.5 * squares)), **place)


def round_solid(body: Shaped, moments: np.ndarray, place: dict[str, Any]) -> Cylinder:
    """Return the homogeneous cylinder with these principal moments per mass [m^2]."""
    apart = np.abs(np.roll(moments, -1) - np.roll(moments, 1))  # entry k: of the two moments across axis k
    k = 2 - int(np.argmin(apart[::-1]))  # the last of equals: z for a body whose moments all agree
    if apart[k] > EQUAL_MOMENT_TOLERANCE * moments.max():
        raise InputError(
            f"body '{body.name}': shape 'cylinder' needs two equal principal moments, "
            f"not {np.sort(moments * body.mass).tolist()} kg m^2; give 'box' or 'ellipsoid'"
        )
    along, across = moments[k], moments[k - 1]
    sizes = np.array([2.0 * np.sqrt(2.0 * along), np.sqrt(max(12.0 * across - 6.0 * along, 0.0))])
    diameter, length = thick(sizes)
    return Cylinder(0.5 * diameter, length, axis="xyz"[k], **place)


def principal(inertia: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return principal moments and, as columns, their right-handed axes: the body axes where those are principal."""
    if np.abs(inertia - np.diag(np.diag(inertia))).max() <= 1e-12 * np.abs(inertia).max():
        return np.diag(inertia), np.eye(3)
    moments, axes = np.linalg.eigh(inertia)
    axes[:, 0] *= np.sign(np.linalg.det(axes))
    return moments, axes


def thick(sizes: np.ndarray) -> np.ndarray:
    """Return sizes of which none is below a fiftieth of the largest."""
    return np.maximum(sizes, DRAWN_THICKNESS_MIN * sizes.max())
