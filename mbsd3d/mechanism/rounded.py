"""Shapes whose lowest point is known in closed form: ellipsoids thickened by a ball; see `kernels.surfaces`."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.checks import short_repr
from ..base.errors import InputError
from ..base.rotations import matrix, perpendiculars
from .bodies import Body, Ground
from .motion_protocols import Motion
from .shapes.shape import along
from .shapes.solids import Capsule, Ellipsoid, Sphere, Torus

Smooth = Sphere | Ellipsoid | Torus
"""Surfaces that roll and touch: a sphere, an ellipsoid, the outside of a torus."""


@dataclass(frozen=True, eq=False)
class Rounded:
    """Half axes ``radii`` (3,) [m] along the columns of ``axes`` about ``centre``, thickened by ``tube`` [m].

    World coordinates at the reference pose. Radii (R, R, 0) are a circle and give a torus.
    """

    centre: np.ndarray
    axes: np.ndarray
    radii: np.ndarray
    tube: float

    @property
    def size(self) -> float:
        """Return the distance of the farthest point from the centre [m]."""
        return float(self.radii.max()) + self.tube

    def lowest(self, centre: np.ndarray, axes: np.ndarray, normal: np.ndarray) -> np.ndarray:
        """Return the lowest points (..., 3) over planes of these normals, of the surface at (centre, axes), world."""
        along = np.einsum("...ji,...j->...i", axes, normal)
        spread = np.einsum("...ij,...j->...i", axes, self.radii**2 * along)
        height = np.sqrt(np.sum(normal * spread, axis=-1, keepdims=True))
        return centre - spread / np.maximum(height, 1e-12 * self.size) - self.tube * normal

    def moving(self, motion: Motion, a: Body | Ground, b: Body, normal: np.ndarray) -> np.ndarray:
        """Return the lowest points (samples, 3) of the surface of b over a plane of a with this initial normal."""
        axes = np.stack([motion.body_axis(b, axis) for axis in self.axes.T], axis=-1)
        return self.lowest(motion.body_point(b, self.centre), axes, motion.body_axis(a, normal))

    def lies_flat(self, normal: np.ndarray) -> bool:
        """Return whether a torus has its axis along the normal: it touches in a circle."""
        return bool(np.linalg.norm(self.radii * (self.axes.T @ normal)) < 1e-9 * self.size)


@dataclass(frozen=True, eq=False)
class RoundBar:
    """Points no farther than ``radius`` [m] from a straight line of ``half`` [m] to both sides of ``centre``.

    A capsule, or a sphere with half = 0; world coordinates at the reference pose.
    """

    centre: np.ndarray
    axis: np.ndarray
    half: float
    radius: float

    def shortest(self, points: np.ndarray, centre: np.ndarray, axis: np.ndarray) -> np.ndarray:
        """Return the vectors (..., 3) from the line, where it is at (centre, axis), to points, world."""
        off = points - centre
        along = np.clip(np.sum(off * axis, axis=-1, keepdims=True), -self.half, self.half)
        return off - along * axis

    def moving(self, motion: Motion, a: Body | Ground, points: np.ndarray) -> np.ndarray:
        """Return the vectors (samples, 3) from the line, carried by a, to points (samples, 3)."""
        return self.shortest(points, motion.body_point(a, self.centre), motion.body_axis(a, self.axis))


def round_bar(shape: Sphere | Capsule, body: Body | Ground) -> RoundBar:
    """Return a sphere or capsule of a body."""
    R = matrix(body.orientation)
    centre = body.position + R @ (body.com if shape.at is None else shape.at)
    half, axis = 0.0, np.array([0.0, 0.0, 1.0])
    if isinstance(shape, Capsule):
        half, axis = 0.5 * shape.length, R @ matrix(shape.orientation) @ along(shape.axis)
    return RoundBar(centre, axis / np.linalg.norm(axis), half, shape.radius)


def rounded(surface: Any, body: Body, what: str) -> Rounded:
    """Return the surface of a body, or raise an InputError."""
    if not isinstance(surface, Smooth):
        raise InputError(
            f"{what}: surface {short_repr(surface)} has no rule; give shapes.Sphere, shapes.Ellipsoid or shapes.Torus"
        )
    centre = body.position + body.axes @ surface.origin(body)
    axes, tube = body.axes @ matrix(surface.orientation), 0.0
    if isinstance(surface, Sphere):
        radii = np.full(3, surface.radius)
    elif isinstance(surface, Ellipsoid):
        radii = surface.radii
    else:
        axis = axes @ along(surface.axis)
        return circle(centre, axis / np.linalg.norm(axis), surface.radius, surface.tube)
    return Rounded(centre, axes, radii, tube)


def circle(centre: np.ndarray, axis: np.ndarray, radius: float, tube: float) -> Rounded:
    """Return a thickened circle of this radius about an axis; a ball where the radius is 0."""
    axes = np.column_stack([*perpendiculars(axis), axis])
    ball = radius == 0.0
    return Rounded(centre, axes, np.full(3, tube) if ball else np.array([radius, radius, 0.0]), 0.0 if ball else tube)
