"""Contacts without slip: knife edge, and smooth surfaces that roll."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import number, shown, vector
from ..base.directions import perpendiculars, unit
from ..base.errors import InputError
from ..kernels import kinds
from .bodies import GROUND, Body, Ground
from .joints import Joint, PointJoint
from .motion import Motion
from .primitives import ZERO, Primitive
from .rounded import Rounded, circle, rounded
from .shapes import Shape


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


def checked_plane(plane: Sequence | None, what: str) -> tuple[np.ndarray, np.ndarray]:
    """(point, unit normal) of a plane, world at the reference pose; None = z = 0."""
    given = ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)) if plane is None else plane
    if not isinstance(given, Sequence) or isinstance(given, str) or len(given) != 2:
        raise InputError(f"{what}: plane {shown(given)}; give a point and a normal")
    at, normal = given
    return vector(at, f"{what}: plane point"), unit(normal, f"{what}: plane normal")


@dataclass(frozen=True, eq=False)
class RollingContact(Joint):
    """A smooth surface of body b rolls without slip on a plane of body a (1 holonomic and 2 nonholonomic rows)."""

    a: Body | Ground
    b: Body | Ground
    plane: Sequence | None = field(default=None, kw_only=True)

    def check(self, what: str) -> None:
        super().check(what)
        if self.b is GROUND:
            raise InputError(f"{what}: the ground cannot roll; give (ground, body)")
        self.set(plane=checked_plane(self.plane, what))

    def check_tilt(self, what: str) -> None:
        """ValueError for a disc that touches in a circle."""
        if self.outline.lies_flat(self.plane[1]):
            raise InputError(f"{what}: the disc lies flat on the plane, so it has no contact point; tilt its axis")

    @cached_property
    def outline(self) -> Rounded:
        """The surface, world at the reference pose."""
        raise NotImplementedError

    def point(self) -> np.ndarray:
        """The contact point at the reference pose (it travels over both bodies)."""
        return self.outline.lowest(self.outline.centre, self.outline.axes, self.plane[1])

    def reaction_points(self, solution: Motion) -> np.ndarray:
        """(samples, 3) contact points."""
        return self.outline.moving(solution, self.a, self.b, self.plane[1])

    def rows(self) -> list[Primitive]:
        (at, normal), form = self.plane, self.outline
        along = perpendiculars(normal)[0]
        return [
            Primitive(
                kinds.ROLL, (self.a, self.b), points=(at, form.centre), axes=(normal, form.axes[:, 0]),
                second_axes=(along, form.axes[:, 1]), values=(*form.radii, form.tube),
            )
        ]  # fmt: skip


@dataclass(frozen=True, eq=False)
class Rolling(RollingContact):
    """A sphere, an ellipsoid or a torus of body b rolls without slip on a plane of body a (3 rows, 1 holonomic).

    The lowest point over the plane is known in closed form (see `mbsd3d.kernels.surfaces`): row 1 keeps it on the
    plane, rows 2 and 3 its material point at rest on it. Nothing lifts off: the reaction may pull. `Contact` lifts off.

    Parameters
    ----------
    surface : Sphere, Ellipsoid or Torus
        One of `mbsd3d.shapes`, in axes of body b; its centre is the centre of mass unless it says ``at``. A torus is
        a disc with a round edge: the outside of its tube.
    plane : (point, normal) or None
        Plane fixed in a, world at the reference pose; None = z = 0.

    Raises
    ------
    ValueError
        For another surface, the ground as body b, or a torus that lies flat on the plane.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Rolling, System, shapes
    >>> stone = Body("stone", mass=1.0, inertia=(2e-4, 16e-4, 17e-4), position=(0, 0, 0.02))
    >>> found = System([stone], [Rolling(GROUND, stone, shapes.Ellipsoid((0.2, 0.03, 0.02)))]).check()
    >>> found.configuration_freedom, found.velocity_freedom
    (5, 3)
    """

    surface: Shape

    def check(self, what: str) -> None:
        super().check(what)
        rounded(self.surface, self.b, what)
        self.check_tilt(what)

    @cached_property
    def outline(self) -> Rounded:
        return rounded(self.surface, self.b, "surface")


@dataclass(frozen=True, eq=False)
class RollingDisc(RollingContact):
    """A disc of body b rolls without slip on a plane of body a (3 rows, 1 holonomic); see `Rolling`.

    Several wheels of one vehicle roll together only while their axles meet at a common turning centre: `System.check`
    says where they do not. `Tyre` slips instead.

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

    axis: ArrayLike = field(kw_only=True)
    radius: float = field(kw_only=True)
    crown: float = field(default=0.0, kw_only=True)
    centre: ArrayLike | None = field(default=None, kw_only=True)

    def check(self, what: str) -> None:
        super().check(what)
        radius = number(self.radius, f"{what}: radius", positive=True)
        crown = number(self.crown, f"{what}: crown", minimum=0.0)
        if crown > radius:
            raise InputError(f"{what}: crown {crown} exceeds the outer radius {radius}; give crown <= radius")
        centre = self.b.centre if self.centre is None else vector(self.centre, f"{what}: centre")
        self.set(axis=unit(self.axis, f"{what}: axis"), radius=radius, crown=crown, centre=centre)
        self.check_tilt(what)

    @cached_property
    def outline(self) -> Rounded:
        return circle(self.centre, self.axis, self.radius - self.crown, self.crown)
