"""The kinds of shapes."""

import os
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import short_repr
from ...base.errors import InputError
from ...base.fields import Array, Number, NumberOrDerived, Stored, kept, locked, part_class
from ...base.rotations import matrix
from .shape import AxisOrLetter, Round, Shape, Shaped, Sizes, Solid
from .triangles import MESH_SUFFIXES, Mesh, ball, block, capsule, cylinder, hull, moved, read_mesh, torus

HULL_CORNERS_MAX = 1000  # [corners] of a hull
FLAT_DEPTH_RATIO = 1e-6  # [1] depth over width of points that lie in a plane


@part_class()
class Box(Solid):
    """Box with edges ``lengths`` (3,) > 0 [m] along its axes.

    Examples
    --------
    >>> from mbsd3d import Body
    >>> leaf = Body("leaf", 20.0, (6.7, 8.0, 1.4), com=(0.45, 0, 0), shape=Box((0.9, 0.04, 2.0)))
    >>> leaf.shape.mesh(leaf).vertices.max(axis=0)
    array([0.9 , 0.02, 1.  ])
    """

    lengths: Sizes = kept()

    def surface(self) -> Mesh:
        return moved(block(), np.diag(self.lengths), np.zeros(3))


@part_class()
class Ellipsoid(Solid):
    """Ellipsoid with half axes ``radii`` (3,) > 0 [m] along its axes.

    >>> float(Ellipsoid((1.0, 2.0, 3.0)).surface().vertices[:, 2].max())
    3.0
    """

    radii: Sizes = kept()

    def surface(self) -> Mesh:
        return moved(ball(), np.diag(self.radii), np.zeros(3))


@part_class()
class Sphere(Solid):
    """Sphere of ``radius`` > 0 [m].

    >>> float(Sphere(0.5).surface().vertices[:, 2].max())
    0.5
    """

    radius: Number = kept(positive=True)

    def surface(self) -> Mesh:
        return moved(ball(), self.radius * np.eye(3), np.zeros(3))


@part_class()
class Cylinder(Round):
    """Cylinder of ``radius`` and ``length`` > 0 [m] about ``axis``: "x", "y", "z" or a (3,) vector.

    >>> Cylinder(0.5, 2.0, "x").surface().vertices.max(axis=0).round(12)
    array([1. , 0.5, 0.5])
    """

    radius: Number = kept(positive=True)
    length: Number = kept(positive=True)
    axis: AxisOrLetter = kept(default="z")

    def about_z(self) -> Mesh:
        return moved(cylinder(), np.diag((self.radius, self.radius, self.length)), np.zeros(3))


@part_class()
class Disc(Round):
    """Flat cylinder: ``radius`` > 0, ``thickness`` > 0 along ``axis`` [m]; None is a tenth of the radius.

    >>> Disc(0.5).thickness
    0.05
    """

    radius: Number = kept(positive=True)
    thickness: NumberOrDerived = kept(default=None, positive=True, derived=lambda disc: 0.1 * disc.radius)
    axis: AxisOrLetter = kept(default="z")

    def about_z(self) -> Mesh:
        return moved(cylinder(), np.diag((self.radius, self.radius, self.thickness)), np.zeros(3))


@part_class()
class Torus(Round):
    """Ring: a tube of radius ``tube`` [m] about a circle of ``radius`` > tube [m]; outer radius = radius + tube.

    >>> Torus(0.3, 0.02, "y").surface().vertices.max(axis=0).round(3)
    array([0.32 , 0.017, 0.32 ])
    """

    radius: Number = kept(positive=True)
    tube: Number = kept(positive=True)
    axis: AxisOrLetter = kept(default="z")

    def check(self, what: str) -> None:
        if self.tube >= self.radius:
            raise InputError(
                f"{what}: tube {self.tube} is not below radius {self.radius}; give the radius of the centre line"
            )

    def about_z(self) -> Mesh:
        return torus(self.radius, self.tube)


@part_class()
class Capsule(Round):
    """Cylinder with half balls on both ends; ``length`` [m] is that of the cylinder alone, overall length + 2 radius.

    >>> float(Capsule(0.5, 2.0).surface().vertices[:, 2].max())
    1.5
    """

    radius: Number = kept(positive=True)
    length: Number = kept(positive=True)
    axis: AxisOrLetter = kept(default="z")

    def about_z(self) -> Mesh:
        return capsule(self.radius, self.length)


def rows_of_three(points: ArrayLike, what: str, remedy: str) -> np.ndarray:
    """Return a new array (k, 3), or raise an InputError with the remedy."""
    try:
        found = np.array(points, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{what}: points are not numeric; {remedy}") from None
    if found.ndim != 2 or found.shape[1] != 3:
        raise InputError(f"{what}: points have shape {found.shape}; {remedy}")
    return found


def as_corners(value: Any, what: str, part: Any) -> np.ndarray:
    """Convert to (k, 3) corners of a convex body that do not lie in a plane."""
    what = what.removesuffix(": points")
    remedy = f"give 4 to {HULL_CORNERS_MAX} corners (k, 3) [m] that do not lie in a plane"
    points = rows_of_three(value, what, remedy)
    if not 4 <= len(points) <= HULL_CORNERS_MAX or not np.isfinite(points).all():
        raise InputError(f"{what}: points have shape {points.shape}, or some are not finite; {remedy}")
    away = points - points.mean(axis=0)
    width, _, depth = np.linalg.svd(away, compute_uv=False)
    if depth <= FLAT_DEPTH_RATIO * width:
        raise InputError(f"{what}: points lie in a plane; {remedy}")
    return locked(points)


def as_polyline(value: Any, what: str, part: Any) -> np.ndarray:
    """Convert to (k, 3) points, with rows of NaN between strokes."""
    what = what.removesuffix(": points")
    remedy = "give (k, 3) numbers [m], at least two points, with rows of NaN between strokes"
    points = rows_of_three(value, what, remedy)
    lifted = np.isnan(points).all(axis=1)
    if np.sum(~lifted) < 2 or not np.isfinite(points[~lifted]).all():
        raise InputError(f"{what}: {np.sum(~lifted)} points, or some not finite; {remedy}")
    return locked(points)


def as_path(value: Any, what: str, part: Any) -> str:
    """Accept the name of a mesh file."""
    try:
        path = os.fspath(value)
    except TypeError:
        raise InputError(f"{what} is {short_repr(value)}; give the name of a file") from None
    if not isinstance(path, str) or not path.lower().endswith(MESH_SUFFIXES):
        raise InputError(f"{what} {short_repr(path)} is not a mesh; give one that ends in {', '.join(MESH_SUFFIXES)}")
    return path


class Path(Stored[str | os.PathLike[str], str]):
    """The name of a file."""

    accepts, file_type = "str | PathLike", str
    convert = staticmethod(as_path)


@part_class()
class Hull(Solid):
    """The convex body with corners among ``points`` (k, 3) [m], k >= 4 and at most 1000, from O or ``at``.

    >>> Hull([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (0.1, 0.1, 0.1)]).surface().faces.shape
    (4, 3)
    """

    centred: ClassVar = False
    points: Array = kept(by=as_corners)

    def surface(self) -> Mesh:
        return hull(self.points)


@part_class()
class MeshFile(Solid):
    """Triangles of an STL, OBJ, PLY, 3MF or glTF file times ``scale`` [m per unit of the file], from O or ``at``.

    A relative path counts from the working folder; the file is read when the body is drawn, and
    refused if it has more than 20 000 triangles. Colours and materials of the file are not used.

    >>> MeshFile("crank.stl", 0.001).path
    'crank.stl'
    """

    centred: ClassVar = False
    path: Path = kept()
    scale: Number = kept(default=1.0, positive=True)

    def surface(self) -> Mesh:
        return moved(read_mesh(self.path, f"MeshFile '{self.path}'"), self.scale * np.eye(3), np.zeros(3))


@part_class()
class Lines(Shape):
    """Polyline through ``points`` (k, 3) [m], from O unless ``at`` is given; rows of NaN separate its strokes.

    >>> Lines([(0, 0, 0), (1, 0, 0)]).points.shape
    (2, 3)
    """

    centred: ClassVar = False
    points: Array = kept(by=as_polyline)

    def line(self, body: Shaped) -> np.ndarray:
        """Return (k, 3) points in body axes from O [m]."""
        return self.points @ matrix(self.orientation).T + self.origin(body)
