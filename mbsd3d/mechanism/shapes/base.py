"""Base classes of shapes: a place in the body, a colour, and for most a surface."""

import re
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import Frozen, number, shown, vector
from ...base.directions import perpendiculars
from ...base.errors import InputError
from ...base.rotations import AXES, as_quaternion, matrix
from .surfaces import Mesh, moved

HEX = re.compile(r"#[0-9a-fA-F]{6}")
CYCLE = re.compile(r"C\d+")  # colours of matplotlib that depend on its settings


class Shaped(Protocol):
    """The fields of a body that shapes use."""

    name: str
    mass: float
    com: np.ndarray
    inertia: np.ndarray
    shape: Any


@dataclass(frozen=True, eq=False)
class Shape(Frozen):
    """Base class of shapes: a place in the body, and perhaps a colour.

    ``at``: centre of the shape (3,) from O, body axes [m]; None = centre of mass of the body (`MeshFile`, `Lines`: O).
    ``orientation``: axes of the shape -> body axes, unit quaternion, scalar first, or rotation matrix. ``colour``:
    "#rrggbb" or a name matplotlib knows; None = that of the body. ValueError naming shape, value and remedy.
    """

    sizes: ClassVar[tuple[str, ...]] = ()  # fields that are lengths > 0 [m]
    centred: ClassVar[bool] = True  # at the centre of mass unless ``at`` is given, else at O
    at: ArrayLike | None = field(default=None, kw_only=True)
    orientation: ArrayLike = field(default=(1.0, 0.0, 0.0, 0.0), kw_only=True)
    colour: str | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        what = type(self).__name__
        at = None if self.at is None else vector(self.at, f"{what}: at")
        orientation = as_quaternion(self.orientation, f"{what}: orientation")
        self._store(at=at, orientation=orientation, colour=hex_colour(self.colour, what))
        self.check(what)

    set = Frozen._store

    def check(self, what: str) -> None:
        """Validate and convert the fields of one kind; errors start with ``what``."""
        self._store(**{name: number(getattr(self, name), f"{what}: {name}", positive=True) for name in self.sizes})

    def origin(self, body: Shaped) -> np.ndarray:
        """Centre of the shape from O, body axes [m]."""
        if self.at is not None:
            return self.at
        return body.com if self.centred else np.zeros(3)


class Solid(Shape):
    """A shape with a surface."""

    def surface(self) -> Mesh:
        """Triangles in the axes of the shape from its centre."""
        raise NotImplementedError

    def mesh(self, body: Shaped) -> Mesh:
        """Triangles in the axes of the body from O [m]."""
        return moved(self.surface(), matrix(self.orientation), self.origin(body))


class Round(Solid):
    """A body of revolution about ``axis``, of which `about_z` gives the triangles about z."""

    axis: ArrayLike

    def check(self, what: str) -> None:
        axis = self.axis if isinstance(self.axis, str) else vector(self.axis, f"{what}: axis")
        if (axis not in AXES) if isinstance(axis, str) else not axis.any():
            raise InputError(f"{what}: axis is {shown(self.axis)}; give 'x', 'y', 'z' or a vector that is not zero")
        self._store(axis=axis)
        super().check(what)

    def about_z(self) -> Mesh:
        """Triangles about z."""
        raise NotImplementedError

    def surface(self) -> Mesh:
        axis = np.array(AXES[self.axis] if isinstance(self.axis, str) else self.axis)
        z = axis / np.linalg.norm(axis)
        return moved(self.about_z(), np.column_stack([*perpendiculars(z), z]), np.zeros(3))


def positive(values: ArrayLike, what: str) -> np.ndarray:
    """(3,) finite numbers > 0."""
    found = vector(values, what)
    if found.min() <= 0.0:
        raise InputError(f"{what}: {found.tolist()} are not all positive; give three numbers > 0 [m]")
    return found


def hex_colour(colour: Any, what: str) -> str | None:
    """The colour as "#rrggbb"."""
    if colour is None or (isinstance(colour, str) and HEX.fullmatch(colour)):
        return colour
    from matplotlib.colors import is_color_like, to_hex, to_rgba

    known = isinstance(colour, str) and not CYCLE.fullmatch(colour) and is_color_like(colour)
    if not known or to_rgba(colour)[3] < 1.0:
        raise InputError(f"{what}: colour {shown(colour)} is unknown; give '#rrggbb' or a name such as 'steelblue'")
    return to_hex(colour)
