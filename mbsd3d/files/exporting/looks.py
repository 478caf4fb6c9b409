"""Shapes of bodies for other programs: solids of their own, or meshes in files beside; and how bodies start to move."""

import hashlib
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ...base.errors import AssemblyError, InputError
from ...base.rotations import matrix, perpendiculars
from ...constraints.assembly import reference_state
from ...mechanism.bodies import Body
from ...mechanism.mechanism import Mechanism
from ...mechanism.shapes.homogeneous import shapes_of
from ...mechanism.shapes.shape import Round, Shape, Solid, along
from ...mechanism.shapes.solids import Box, Capsule, Cylinder, Disc, Ellipsoid, MeshFile, Sphere
from ...mechanism.state import State
from .exported import numbers

UNSAFE_LETTERS = re.compile(r"[^A-Za-z0-9_.-]+")  # in names of files that others write into XML and addresses
DIGEST_LETTERS = 8  # [1] of the content of a mesh in the name of its file, so that no two differ under one name
SIZES_OF: dict[type[Shape], tuple[str, Any]] = {
    Box: ("box", lambda x: tuple(x.lengths)),
    Sphere: ("sphere", lambda x: (x.radius,)),
    Cylinder: ("cylinder", lambda x: (x.radius, x.length)),
    Disc: ("cylinder", lambda x: (x.radius, x.thickness)),
    Capsule: ("capsule", lambda x: (x.radius, x.length)),
    Ellipsoid: ("ellipsoid", lambda x: tuple(x.radii)),
}
"""Class of a shape -> kind and sizes [m]: edges, radius, radius and length, half axes."""


class Look(NamedTuple):
    """A shape in the axes of its body: r (3,) from O [m], R (3, 3); a kind with sizes, or a mesh in metres."""

    kind: str
    sizes: tuple[float, ...]
    r: np.ndarray
    R: np.ndarray
    rgba: str  # red, green, blue and 1, or ""
    file: str = ""  # of a mesh


@dataclass
class Looks:
    """Looks of all bodies for a format that knows some ``kinds``; ``meshes``: name of a file -> its OBJ text."""

    kinds: Sequence[str]
    meshes: dict[str, str] = field(default_factory=dict)
    missing: list[str] = field(default_factory=list)
    files: dict[Any, str] = field(default_factory=dict)  # shape, or path and scale of a mesh -> its file

    def of(self, body: Body) -> list[Look]:
        """Return the looks of a body that was given a shape."""
        return [] if body.shape is None else [x for shape in shapes_of(body) if (x := self.look(body, shape))]

    def look(self, body: Body, shape: Shape) -> Look | None:
        """Return the look of a shape, or None for one that cannot be read or has no surface."""
        r, R = shape.origin(body), matrix(shape.orientation)
        rgba = ""
        if shape.colour:
            rgba = numbers([int(shape.colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5)], 1.0)
        kind, sizes = SIZES_OF.get(type(shape), ("mesh", None))
        if kind in self.kinds and sizes is not None:
            if isinstance(shape, Round):
                z = along(shape.axis)
                R = R @ np.column_stack([*perpendiculars(z / np.linalg.norm(z)), z / np.linalg.norm(z)])
            return Look(kind, sizes(shape), r, R, rgba)
        try:
            file = self.file_of(body, shape)
        except InputError as error:
            self.missing.append(f"shape of '{body.name}' is not written: {error}")
            return None
        return Look("mesh", (), r, R, rgba, file)

    def file_of(self, body: Body, shape: Shape) -> str:
        """Return the name of the OBJ file of a shape; those of one mesh file share it."""
        if not isinstance(shape, Solid):
            raise InputError("other programs draw no lines; give a solid")
        key = (shape.path, shape.scale) if isinstance(shape, MeshFile) else shape
        if key not in self.files:
            mesh = shape.surface()
            rows = [f"v {numbers(x)}" for x in mesh.vertices]
            rows += [f"f {' '.join(str(k + 1) for k in face)}" for face in mesh.faces.tolist()]
            text = "\n".join(rows) + "\n"
            digest = hashlib.sha256(text.encode()).hexdigest()[:DIGEST_LETTERS]
            self.files[key] = f"{UNSAFE_LETTERS.sub('_', body.name)}_{digest}.obj"
            self.meshes[self.files[key]] = text
        return self.files[key]


def start_of(system: Mechanism) -> tuple[State | None, list[str]]:
    """Return the state at the start, where bodies were given velocities that are not zero, or say why there is none."""
    given = [x for body in system.bodies for x in (body.velocity, body.omega) if x is not None]
    if not any(np.any(x) for x in given):
        return None, []
    try:
        return reference_state(system, None), []
    except (AssemblyError, InputError) as error:
        return None, [f"velocities at the start are not written: {error}"]
