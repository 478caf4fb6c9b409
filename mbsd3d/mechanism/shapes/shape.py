"""Base classes of shapes: a place in the body, a colour, and for most a surface."""

import re
from dataclasses import KW_ONLY
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import short_repr, vector
from ...base.errors import InputError
from ...base.fields import FILE_VECTOR, Checked, Orientation, Stored, VectorOrNone, kept, part_class
from ...base.rotations import AXES, matrix, perpendiculars
from .triangles import Mesh, moved

HEX_COLOUR_PATTERN = re.compile(r"#[0-9a-fA-F]{6}")
CYCLE_COLOUR_PATTERN = re.compile(r"C\d+")  # colours of matplotlib that depend on its settings


class Shaped(Protocol):
    """The fields of a body that shapes use."""

    name: str
    mass: float
    com: np.ndarray
    inertia: np.ndarray
    shape: Any


def hex_colour(colour: Any, what: str, part: Any) -> str | None:
    """Return the colour as "#rrggbb"."""
    if colour is None or (isinstance(colour, str) and HEX_COLOUR_PATTERN.fullmatch(colour)):
        return colour
    from matplotlib.colors import is_color_like, to_hex, to_rgba

    known = isinstance(colour, str) and not CYCLE_COLOUR_PATTERN.fullmatch(colour) and is_color_like(colour)
    if not known or to_rgba(colour)[3] < 1.0:
        raise InputError(f"{what} {short_repr(colour)} is unknown; give '#rrggbb' or a name such as 'steelblue'")
    return to_hex(colour)


@part_class()
class Shape(Checked):
    """Base class of shapes: a place in the body, and perhaps a colour.

    ``at``: centre of the shape (3,) from O, body axes [m]; None = centre of mass of the body (`MeshFile`, `Lines`: O).
    ``orientation``: axes of the shape -> body axes, unit quaternion, scalar first, or rotation matrix. ``colour``:
    "#rrggbb" or a name matplotlib knows; None = that of the body. ValueError naming shape, value and remedy.
    """

    centred: ClassVar[bool] = True  # at the centre of mass unless ``at`` is given, else at O
    _: KW_ONLY
    at: VectorOrNone = kept(default=None)
    orientation: Orientation = kept(default=(1.0, 0.0, 0.0, 0.0))
    colour: str | None = kept(default=None, by=hex_colour)

    def origin(self, body: Shaped) -> np.ndarray:
        """Return the centre of the shape from O, body axes [m]."""
        if self.at is not None:
            return self.at
        return body.com if self.centred else np.zeros(3)


class Solid(Shape):
    """A shape with a surface."""

    def surface(self) -> Mesh:
        """Return the triangles in the axes of the shape from its centre."""
        raise NotImplementedError

    def mesh(self, body: Shaped) -> Mesh:
        """Return the triangles in the axes of the body from O [m]."""
        return moved(self.surface(), matrix(self.orientation), self.origin(body))


def as_axis(value: Any, what: str, part: Any) -> str | np.ndarray:
    """Accept a letter, or a vector that is not zero."""
    axis = value if isinstance(value, str) else vector(value, what)
    if (axis not in AXES) if isinstance(axis, str) else not axis.any():
        raise InputError(f"{what} is {short_repr(value)}; give 'x', 'y', 'z' or a vector that is not zero")
    return axis


class AxisOrLetter(Stored[str | ArrayLike, str | np.ndarray]):
    """Axis of a body of revolution: "x", "y", "z" or a vector of any length."""

    accepts, file_type = "str | array_like", str | list[float]
    convert = staticmethod(as_axis)


def along(axis: str | np.ndarray) -> np.ndarray:
    """Return the vector (3,) along an axis that may be a letter."""
    return np.array(AXES[axis]) if isinstance(axis, str) else axis


class Round(Solid):
    """A body of revolution about ``axis``, of which `about_z` gives the triangles about z."""

    axis: AxisOrLetter

    def about_z(self) -> Mesh:
        """Return the triangles about z."""
        raise NotImplementedError

    def surface(self) -> Mesh:
        axis = along(self.axis)
        z = axis / np.linalg.norm(axis)
        return moved(self.about_z(), np.column_stack([*perpendiculars(z), z]), np.zeros(3))


def as_sizes(value: Any, what: str, part: Any) -> np.ndarray:
    """Convert to (3,) finite numbers > 0."""
    found = vector(value, what)
    if found.min() <= 0.0:
        raise InputError(f"{what}: {found.tolist()} are not all positive; give three numbers > 0 [m]")
    return found


class Sizes(Stored[ArrayLike, np.ndarray]):
    """Three lengths > 0 [m]."""

    accepts, file_type = "array_like", FILE_VECTOR
    convert = staticmethod(as_sizes)
