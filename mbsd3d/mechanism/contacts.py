"""Contacts without slip: knife edge and rolling disc."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import number, vector
from ..base.directions import perpendiculars, unit
from ..base.errors import InputError
from ..kernels import kinds
from .bodies import GROUND, Body, Ground
from .joints import Joint, PointJoint
from .motion import Motion
from .primitives import ZERO, Primitive


@dataclass(frozen=True, eq=False)
class KnifeEdge(PointJoint):
    """The point of b does not move along ``lateral`` (fixed in b) relative to a (1 nonholonomic row).

    Or ``heading``, the way a horizontal blade points: ``lateral`` is level then and across it (z up).

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, KnifeEdge
    >>> part = Body("part", mass=1.2, inertia=(0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    >>> sum(row.n_rows for row in KnifeEdge(GROUND, part, at=(0.1, 0.2, 0), lateral=(0, 1, 0)).rows())
    1
    """

    lateral: ArrayLike | None = field(default=None, kw_only=True)
    heading: ArrayLike | None = field(default=None, kw_only=True)

    def check(self, what: str) -> None:
        super().check(what)
        if (self.lateral is None) == (self.heading is None):
            given = "neither lateral nor heading" if self.lateral is None else "both lateral and heading"
            raise InputError(f"{what}: {given}; give the direction it cannot move along, or the one it points")
        if self.lateral is None:
            ahead = unit(self.heading, f"{what}: heading")
            self.set(heading=None, lateral=unit(np.cross((0.0, 0.0, 1.0), ahead), f"{what}: heading seen from above"))
        self.set(lateral=unit(self.lateral, f"{what}: lateral"))

    def rows(self) -> list[Primitive]:
        return [Primitive(kinds.NO_SIDESLIP, (self.a, self.b), points=(self.at, self.at_b), axes=(ZERO, self.lateral))]


@dataclass(frozen=True, eq=False)
class RollingDisc(Joint):
    """A disc of body b rolls without slip on a plane of body a (1 holonomic and 2 nonholonomic rows).

    Parameters
    ----------
    axis : (3,) array_like
        Axis of the disc, world at the reference pose.
    radius : float
        Outer radius [m] > 0.
    crown : float
        Radius of the rounded rim [m], 0 <= crown <= radius; 0 is a knife edge.
    centre : (3,) array_like or None
        Centre of the disc, world [m]; None = centre of mass of the body.
    plane : (point, normal) or None
        Plane fixed in a, world at the reference pose; None = z = 0.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, RollingDisc, System
    >>> coin = Body("coin", mass=0.1, inertia=(2e-4, 4e-4, 2e-4), position=(0, 0, 0.1))
    >>> found = System([coin], [RollingDisc(GROUND, coin, axis=(0, 1, 0), radius=0.1)]).check()
    >>> found.configuration_freedom, found.velocity_freedom
    (5, 3)
    """

    a: Body | Ground
    b: Body | Ground
    axis: ArrayLike = field(kw_only=True)
    radius: float = field(kw_only=True)
    crown: float = field(default=0.0, kw_only=True)
    centre: ArrayLike | None = field(default=None, kw_only=True)
    plane: Sequence | None = field(default=None, kw_only=True)

    def check(self, what: str) -> None:
        super().check(what)
        if self.b is GROUND:
            raise InputError(f"{what}: the ground cannot roll; give (ground, body)")
        radius = number(self.radius, f"{what}: radius", positive=True)
        crown = number(self.crown, f"{what}: crown", minimum=0.0)
        if crown > radius:
            raise InputError(f"{what}: crown {crown} exceeds the outer radius {radius}; give crown <= radius")
        at, normal = ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)) if self.plane is None else self.plane
        plane = (vector(at, f"{what}: plane point"), unit(normal, f"{what}: plane normal"))
        axis = unit(self.axis, f"{what}: axis")
        if np.linalg.norm(np.cross(axis, plane[1])) < 1e-9:
            raise InputError(f"{what}: the disc lies flat on the plane, so it has no contact point; tilt its axis")
        centre = self.b.centre if self.centre is None else vector(self.centre, f"{what}: centre")
        self.set(axis=axis, radius=radius, crown=crown, plane=plane, centre=centre)

    def point(self) -> np.ndarray:
        """The contact point at the reference pose (it travels over both bodies)."""
        return self.contact(self.centre, self.plane[1], self.axis)

    def contact(self, centre: np.ndarray, normal: np.ndarray, axis: np.ndarray) -> np.ndarray:
        """(..., 3) contact points: centre + (radius - crown) down - crown normal, all in world axes."""
        lean = np.sum(normal * axis, axis=-1, keepdims=True)
        across = normal - lean * axis
        down = -across / np.maximum(np.linalg.norm(across, axis=-1, keepdims=True), 1e-12)
        return centre + (self.radius - self.crown) * down - self.crown * normal

    def reaction_points(self, solution: Motion) -> np.ndarray:
        """(samples, 3) contact points."""
        centre, axis = solution.body_point(self.b, self.centre), solution.body_axis(self.b, self.axis)
        return self.contact(centre, solution.body_axis(self.a, self.plane[1]), axis)

    def rows(self) -> list[Primitive]:
        at, normal = self.plane
        along = perpendiculars(normal)[0]
        return [
            Primitive(
                kinds.ROLL, (self.a, self.b), points=(at, self.centre), axes=(normal, self.axis),
                second_axes=(along, ZERO), values=(self.radius, self.crown),
            )
        ]  # fmt: skip
