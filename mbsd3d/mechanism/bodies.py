"""Bodies: frozen descriptions of rigid parts at one reference pose, in world coordinates."""

import os
from collections.abc import Sequence
from dataclasses import KW_ONLY
from functools import cached_property
from typing import Any, ClassVar, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import check_name, short_repr, vector
from ..base.errors import InputError, checks_method_arguments
from ..base.fields import (
    Checked,
    Frozen,
    Inertia,
    Number,
    Orientation,
    Truth,
    Vector,
    VectorOrNone,
    kept,
    part_class,
)
from ..base.rotations import WORLD_AXES, matrix
from ..base.wording import with_article
from .shapes.homogeneous import ShapeOfBody
from .shapes.shape import Shape
from .shapes.solid_meshes import solid_of
from .shapes.solids import MeshFile
from .shapes.triangles import MASS_TRIANGLES_MAX, MESH_TRIANGLES_MAX


class Ground:
    """The fixed frame; its axes are the world axes."""

    name = "ground"
    position = np.zeros(3)
    com = np.zeros(3)
    centre = np.zeros(3)
    orientation = np.array([1.0, 0.0, 0.0, 0.0])
    axes = WORLD_AXES

    def __repr__(self) -> str:
        return "GROUND"

    def __reduce__(self) -> str:
        return "GROUND"

    def local_point(self, point: ArrayLike) -> np.ndarray:
        """Return the point unchanged: the axes of the ground are the world axes."""
        return np.asarray(point, float)

    def local_axis(self, axis: np.ndarray) -> np.ndarray:
        """Return the axis unchanged: the axes of the ground are the world axes."""
        return vector(axis, "local_axis: axis")


GROUND = Ground()


class Start(TypedDict, total=False):
    """Pose and velocities of a body, as for `Body`."""

    position: ArrayLike
    orientation: ArrayLike
    velocity: ArrayLike | None
    omega: ArrayLike | None


@checks_method_arguments
@part_class(repr=False)
class Body(Frozen):
    """A rigid body at the reference pose.

    Parameters
    ----------
    name : str
        Unique in its system; results can be asked for by name.
    mass : float
        [kg] >= 0; 0 is permitted if the constraints still determine the motion.
    inertia : (3,) or (3, 3) array_like
        About the centre of mass, body axes [kg m^2]; principal moments obey the triangle rule.
    com : (3,) array_like
        r_G, centre of mass from the reference point O, body axes [m].
    position : (3,) array_like
        Reference point O at the reference pose, world [m].
    orientation : (4,) or (3, 3) array_like
        Unit quaternion (e0, e1, e2, e3), scalar first, body -> world, or a rotation matrix; see `rotation`.
    velocity, omega : (3,) array_like or None
        Velocity of O [m/s] and angular velocity [rad/s] at the start, world axes; None = solved from the constraints
        with least kinetic energy.
    shape : Shape, list of Shape, str or (k, 3) array_like, optional
        Drawing of the body: one or more of `mbsd3d.shapes`; "ellipsoid", "box" or "cylinder", the homogeneous solid
        with its mass and inertia; a polyline in body axes from O [m]. None = a link between its joints and centre of
        mass, with joints at one point or none the ellipsoid. The shape is only drawn: mass and inertia are as given.
    inertia_as_given : bool
        Accept moments that violate the triangle rule: no body can have them, but if none is negative the motion is
        defined, and models of other programs contain them.

    Raises
    ------
    ValueError
        Naming the body, the value and the remedy.

    Examples
    --------
    >>> Body("top", mass=15.0, inertia=(0.234375, 0.46875, 0.234375), position=(0, 1, 0)).mass
    15.0
    """

    name: str
    mass: Number = kept(minimum=0.0)
    inertia: Inertia = kept()
    _: KW_ONLY
    com: Vector = kept(default=(0.0, 0.0, 0.0))
    position: Vector = kept(default=(0.0, 0.0, 0.0))
    orientation: Orientation = kept(default=(1.0, 0.0, 0.0, 0.0))
    velocity: VectorOrNone = kept(default=None)
    omega: VectorOrNone = kept(default=None)
    shape: ShapeOfBody = kept(default=None)
    inertia_as_given: Truth = kept(default=False)

    @classmethod
    def from_mesh(
        cls,
        name: str,
        path: str | os.PathLike[str],
        *,
        density: float,
        unit: str | float | None = None,
        shape: Shape | Sequence[Shape] | str | ArrayLike | None = "mesh",
        **start: Unpack[Start],
    ) -> "Body":
        """Return the homogeneous body that a closed mesh encloses; O and the body axes are those of the file.

        Mass, centre of mass and inertia are exact for the polyhedron, also far from the origin of the file. Curved
        surfaces lose what lies between them and the triangles: a cylinder of 32 sides lacks 0.64 % of its mass.

        Parameters
        ----------
        name : str
            As for `Body`.
        path : str or Path
            STL, OBJ, PLY, 3MF or glTF (.glb; .gltf with its data inside), at most 200 000 triangles. STEP where
            cascadio is installed (``pip install mbsd3d[step]``); its curved surfaces become triangles 0.05 rad apart.
        density : float
            [kg/m^3] > 0.
        unit : str or float, optional
            Unit of the file: "m", "cm", "mm", "um", "in", "ft", or metres per unit. Needed for STL, OBJ and PLY, which
            have none; 3MF and STEP have their own, and glTF is in metres.
        shape : optional
            "mesh" draws the file, which then may have 20 000 triangles; else as for `Body`.
        position, orientation, velocity, omega
            As for `Body`.

        Returns
        -------
        Body
            Its shape is a `MeshFile` that is read again when it is drawn.

        Raises
        ------
        ValueError
            Naming body and file, if the mesh is open, turned in several ways, or overlaps itself, if its unit is
            missing, or if it is not a mesh. A mesh that is inside out as a whole is turned back, with a warning.

        Examples
        --------
        >>> from pathlib import Path
        >>> from tempfile import TemporaryDirectory
        >>> rows = ["v 0 0 0", "v 60 0 0", "v 0 60 0", "v 0 0 60", "f 1 3 2", "f 1 2 4", "f 1 4 3", "f 2 3 4"]
        >>> with TemporaryDirectory() as folder:
        ...     path = Path(folder, "corner.obj")
        ...     _ = path.write_text(chr(10).join(rows))
        ...     corner = Body.from_mesh("corner", path, density=7800.0, unit="mm")
        >>> round(corner.mass, 6), corner.com.round(6)
        (0.2808, array([0.015, 0.015, 0.015]))
        """
        check_name(name, "body")
        if wrong := set(start) - set(Start.__annotations__):
            raise InputError(f"body '{name}': {min(wrong)} is no argument for a mesh; leave it out")
        try:
            file = os.fsdecode(path)
        except TypeError:
            raise InputError(f"body '{name}': mesh is {short_repr(path)}; give the name of a file") from None
        drawn = isinstance(shape, str) and shape == "mesh"
        what = f"body '{name}': mesh '{file}'"
        solid, metres = solid_of(file, density, unit, what, MESH_TRIANGLES_MAX if drawn else MASS_TRIANGLES_MAX)
        look = MeshFile(file, metres) if drawn else shape
        return cls(name, solid.mass, solid.inertia, com=solid.com, shape=look, **start)

    def what(self) -> str:
        check_name(self.name, "body")
        return f"body '{self.name}'"

    def __repr__(self) -> str:
        return f"Body('{self.name}', mass={self.mass:g})"

    @cached_property
    def axes(self) -> np.ndarray:
        """Return R at the reference pose (3, 3), body -> world; read-only."""
        if not any(self.orientation.tolist()[1:]):
            return WORLD_AXES
        R = matrix(self.orientation)
        R.setflags(write=False)
        return R

    @cached_property
    def centre(self) -> np.ndarray:
        """Return the centre of mass r + R r_G at the reference pose, world [m]; read-only."""
        centre = self.position + self.axes @ self.com
        centre.setflags(write=False)
        return centre

    def local_point(self, point: ArrayLike) -> np.ndarray:
        """Return R'(p - r): a world point at the reference pose in body axes from O [m]."""
        return self.axes.T @ (vector(point, "local_point: point") - self.position)

    def local_axis(self, axis: np.ndarray) -> np.ndarray:
        """Return R'a: a world direction at the reference pose in body axes."""
        return self.axes.T @ vector(axis, "local_axis: axis")


@part_class()
class Part(Checked):
    """Base class of joints and force elements: a name, and fields that are checked and converted once."""

    _: KW_ONLY
    name: str | None = None

    role: ClassVar[str] = "part"

    def bodies(self) -> Sequence[Body | Ground]:
        """Return the bodies the part acts on."""
        raise NotImplementedError

    def partners(self) -> Sequence["Part"]:
        """Return joints and forces the part refers to; they must be in the system too."""
        return ()

    def replaces(self) -> Sequence["Part"]:
        """Return the parts that this one replaces; they must not be in the system."""
        return ()

    def what(self) -> str:
        kind = type(self).__name__
        if self.name is None:
            return f"{kind} without a name"
        check_name(self.name, kind)
        return f"{self.role} '{self.name}' ({kind})"


def as_body(value: Any, what: str, part: Any) -> Body:
    """Accept a body."""
    if not isinstance(value, Body):
        raise InputError(f"{what} = {short_repr(value)} is not a body; give a Body")
    return value


def as_body_or_ground(value: Any, what: str, part: Any) -> Body | Ground:
    """Accept a body or the ground."""
    if not isinstance(value, (Body, Ground)):
        raise InputError(f"{what} = {short_repr(value)} is not a body; give a Body or GROUND")
    return value


def describe_part(part: Body | Part) -> str:
    """Return the type and name of a part, as error messages quote them."""
    return (
        f"{type(part).__name__} '{part.name}'" if part.name else f"{with_article(type(part).__name__)} without a name"
    )
