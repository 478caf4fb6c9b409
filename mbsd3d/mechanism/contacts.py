"""Contacts without slip: knife edge, and smooth surfaces that roll."""

from collections.abc import Sequence
from dataclasses import KW_ONLY
from functools import cached_property
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import short_repr, vector
from ..base.errors import InputError
from ..base.fields import (
    FILE_VECTOR,
    Direction,
    DirectionOrDerived,
    Number,
    Stored,
    VectorOrDerived,
    kept,
    part_class,
)
from ..base.rotations import perpendiculars, unit
from ..kernels import kinds
from .bodies import GROUND, Body, Ground, as_body
from .joints import Joint, PointJoint
from .motion_protocols import Motion
from .primitives import ZERO, Primitive
from .rounded import Rounded, circle, rounded
from .shapes import Shape

NORMAL_REMEDY = "give the direction it cannot move along, or the one it points"


def as_lateral(value: Any, what: str, part: Any) -> np.ndarray:
    """Convert the direction that a knife edge cannot move along."""
    if part.heading is not None:
        raise InputError(f"{part.what()}: both lateral and heading; {NORMAL_REMEDY}")
    return unit(value, what)


def level_across(part: Any) -> np.ndarray:
    """Return the level direction across the heading of a knife edge."""
    what = part.what()
    if part.heading is None:
        raise InputError(f"{what}: neither lateral nor heading; {NORMAL_REMEDY}")
    ahead = unit(part.heading, f"{what}: heading")
    return unit(np.cross((0.0, 0.0, 1.0), ahead), f"{what}: heading seen from above")


class Heading(Stored[ArrayLike | None, None]):
    """Direction in which a horizontal blade points; stored as ``lateral``."""

    accepts, file_type = "array_like | None", FILE_VECTOR
    convert = staticmethod(lambda value, what, part: None)


@part_class()
class KnifeEdge(PointJoint):
    """The point of b does not move along ``lateral`` relative to a: a blade or a skate (1 nonholonomic row).

    Parameters
    ----------
    a, b : Body or GROUND
        The bodies; the reaction is that of a on b.
    at : (3,)
        Point of the blade [m], fixed in b, world axes at the reference pose.
    lateral : "x", "y", "z" or (3,)
        Direction across the blade, fixed in b, world axes at the reference pose; any length.
    heading : (3,)
        Instead of ``lateral``: the direction of a horizontal blade; ``lateral`` is level then and across it (z up).
    at_b : (3,), optional
        Actual point of b, if the bodies do not fit as built; the first run moves it into place.
    name : str, optional
        For results and messages; "KnifeEdge 1" and so on by default.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, KnifeEdge, Planar, System, simulate
    >>> sled = Body("sled", mass=4.0, inertia=(0.1, 0.1, 0.2), velocity=(2.0, 0, 0), omega=(0, 0, 0.5))
    >>> ice = Planar(GROUND, sled, at=(0, 0, 0), normal=(0, 0, 1), name="ice")
    >>> skate = KnifeEdge(GROUND, sled, at=(0, 0, 0), lateral=(0, 1, 0), name="skate")
    >>> run = simulate(System([sled], [ice, skate]), 3.0)
    >>> run.position(sled)[-1].round(6).tolist()  # a circle of radius v / omega = 4 m
    [3.98998, 3.717051, 0.0]
    """

    _: KW_ONLY
    lateral: DirectionOrDerived = kept(default=None, by=as_lateral, derived=level_across)
    heading: Heading = kept(default=None)

    def rows(self) -> list[Primitive]:
        return [Primitive(kinds.NO_SIDESLIP, (self.a, self.b), points=(self.at, self.at_b), axes=(ZERO, self.lateral))]


class Plane(Stored[Sequence[ArrayLike] | None, tuple[np.ndarray, np.ndarray]]):
    """(point, normal) of a plane, world at the reference pose; None = z = 0. The normal is kept as a unit vector."""

    accepts, file_type = "tuple[array_like, array_like] | None", list
    convert = staticmethod(lambda value, what, part: checked_plane(value, what.removesuffix(": plane")))


def checked_plane(plane: Sequence[ArrayLike] | None, what: str) -> tuple[np.ndarray, np.ndarray]:
    """Return (point, unit normal) of a plane, world at the reference pose; None = z = 0."""
    given = ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)) if plane is None else plane
    if not isinstance(given, Sequence) or isinstance(given, str) or len(given) != 2:
        raise InputError(f"{what}: plane {short_repr(given)}; give a point and a normal")
    at, normal = given
    return vector(at, f"{what}: plane point"), unit(normal, f"{what}: plane normal")


def level_plane(part: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the plane z = 0."""
    return checked_plane(None, part.what())


def as_rolling(value: Any, what: str, part: Any) -> Body:
    """Accept a body, not the ground."""
    if value is GROUND:
        raise InputError(f"{what.removesuffix(': b')}: the ground cannot roll; give (ground, body)")
    return as_body(value, what, part)


@part_class()
class RollingContact(Joint):
    """A smooth surface of body b rolls without slip on a plane of body a (1 holonomic and 2 nonholonomic rows)."""

    a: Body | Ground
    b: Body = kept(by=as_rolling)
    _: KW_ONLY
    plane: Plane = kept(default=None, derived=level_plane)

    def check_tilt(self, what: str) -> None:
        """Raise a ValueError for a disc that touches in a circle."""
        if self.outline.lies_flat(self.plane[1]):
            raise InputError(f"{what}: the disc lies flat on the plane, so it has no contact point; tilt its axis")

    @cached_property
    def outline(self) -> Rounded:
        """Return the surface, world at the reference pose."""
        raise NotImplementedError

    def point(self) -> np.ndarray:
        """Return the contact point at the reference pose (it moves over both bodies)."""
        return self.outline.lowest(self.outline.centre, self.outline.axes, self.plane[1])

    def reaction_points(self, solution: Motion) -> np.ndarray:
        """Return (samples, 3) contact points."""
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


@part_class()
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


@part_class()
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

    _: KW_ONLY
    axis: Direction = kept()
    radius: Number = kept(positive=True)
    crown: Number = kept(default=0.0, minimum=0.0)
    centre: VectorOrDerived = kept(default=None, derived=attrgetter("b.centre"))

    def check(self, what: str) -> None:
        super().check(what)
        if self.crown > self.radius:
            raise InputError(f"{what}: crown {self.crown} exceeds the outer radius {self.radius}; give crown <= radius")
        self.check_tilt(what)

    @cached_property
    def outline(self) -> Rounded:
        return circle(self.centre, self.axis, self.radius - self.crown, self.crown)
