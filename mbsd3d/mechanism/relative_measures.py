"""Measures of how bodies stand to each other and to the ground: headings, cambers, lengths, angles, relative poses.

The kernels read them as hinge coordinates, leans and distances, so that each of them also stops a run, is fed back, is
an output of `linearize` and a target of `System.assemble`. Angles are those a protractor fixed in one body shows of a
direction fixed in the other: of its projection on the plane across the axis. They are unwrapped.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import shown
from ..base.directions import cross, perpendiculars, unit
from ..base.errors import InputError, explaining
from .bodies import GROUND, Body, Ground
from .forces.by_table import ForceCurve
from .forces.springs import SpringDamper
from .measures import Measure, body_or_error, distance, label, lean, of_coordinate, point_of
from .primitives import Coordinate

AXES = np.eye(3)
PARALLEL = 1e-6  # sine of the angle below which two directions have no plane


def protractor(
    a: Body | Ground, b: Body | Ground, axis: np.ndarray, zero: np.ndarray, direction: np.ndarray, what: str
) -> Coordinate:
    """The angle about ``axis`` of a from ``zero``, fixed in a, to ``direction``, fixed in b."""
    for x in (zero, direction):
        if np.linalg.norm(cross(axis, x)) < PARALLEL:
            raise InputError(
                f"{what}: {x.tolist()} lies along the axis {axis.tolist()} it is turned about; give another"
            )
    zero = unit(zero - axis * (axis @ zero), f"{what}: zero")
    return Coordinate("angle", a, b, axis, axis, zero_a=zero, zero_b=direction)


@explaining
def heading(body: Body, *, forward: ArrayLike = (1.0, 0.0, 0.0)) -> Measure:
    """Heading of a body [rad]: angle about z from the world x axis to its forward axis, > 0 to the left (z up).

    ``forward`` is given in world axes at the reference pose.
    """
    return of_coordinate(_heading(body, forward, "measures.heading"), f"heading of {label(body)}")


@explaining
def heading_rate(body: Body, *, forward: ArrayLike = (1.0, 0.0, 0.0)) -> Measure:
    """Rate of `heading` [rad/s]."""
    return of_coordinate(_heading(body, forward, "measures.heading_rate"), f"heading rate of {label(body)}", rate=True)


def _heading(body: Body, forward: ArrayLike, what: str) -> Coordinate:
    body_or_error(body, what)
    return protractor(GROUND, body, AXES[2], AXES[0], unit(forward, f"{what}: forward"), what)


@explaining
def camber(wheel: Body, *, axle: ArrayLike = (0.0, 1.0, 0.0)) -> Measure:
    """Camber of a wheel [rad]: elevation of its axle above the horizontal, > 0 where it leans to the right (y left).

    ``axle`` is given in world axes at the reference pose; the spin of the wheel does not matter.
    """
    body_or_error(wheel, "measures.camber")
    return replace(lean(wheel, lateral=unit(axle, "measures.camber: axle")), label=f"camber of {label(wheel)}")


@explaining
def angle_between(
    a: Body | Ground, b: Body | Ground, *, axis_a: ArrayLike, axis_b: ArrayLike, about: ArrayLike | None = None
) -> Measure:
    """Angle from an axis of a to an axis of b [rad], about an axis fixed in a.

    Parameters
    ----------
    a, b : Body or GROUND
    axis_a, axis_b : (3,) array_like
        World at the reference pose.
    about : (3,) array_like or None
        World at the reference pose; None = ``axis_a x axis_b``, so that the angle starts between 0 and pi and is that
        between the axes as long as they turn in this plane.

    Raises
    ------
    ValueError
        If the axes are parallel at the reference pose and ``about`` is not given.
    """
    what = "measures.angle_between"
    for body in (a, b):
        body_or_error(body, what)
    first, second = unit(axis_a, f"{what}: axis_a"), unit(axis_b, f"{what}: axis_b")
    if about is None:
        about = cross(first, second)
        if np.linalg.norm(about) < PARALLEL:
            raise InputError(f"{what}: the axes are parallel at the reference pose; say about which axis with about=")
    x = protractor(a, b, unit(about, f"{what}: about"), first, second, what)
    return of_coordinate(x, f"angle {label(a)} to {label(b)}")


@explaining
def turn(a: Body | Ground, b: Body | Ground, *, about: ArrayLike) -> Measure:
    """Angle of b relative to a about an axis fixed in a [rad], zero at the reference pose; no hinge is needed."""
    return of_coordinate(_turn(a, b, about, "measures.turn"), f"turn of {label(b)} from {label(a)}")


@explaining
def turn_rate(a: Body | Ground, b: Body | Ground, *, about: ArrayLike) -> Measure:
    """Rate of `turn` [rad/s]."""
    x = _turn(a, b, about, "measures.turn_rate")
    return of_coordinate(x, f"turn rate of {label(b)} from {label(a)}", rate=True)


def _turn(a: Body | Ground, b: Body | Ground, about: ArrayLike, what: str) -> Coordinate:
    for body in (a, b):
        body_or_error(body, what)
    axis = unit(about, f"{what}: about")
    zero = perpendiculars(axis)[0]
    return protractor(a, b, axis, zero, zero, what)


@explaining
def offset(
    a: Body | Ground,
    b: Body | Ground,
    *,
    along: ArrayLike,
    at_a: ArrayLike | None = None,
    at_b: ArrayLike | None = None,
) -> Measure:
    """Distance along an axis fixed in a from a point of a to a point of b [m]; None = centre of mass."""
    return of_coordinate(_offset(a, b, along, at_a, at_b, "measures.offset"), f"offset of {label(b)} from {label(a)}")


@explaining
def offset_rate(
    a: Body | Ground,
    b: Body | Ground,
    *,
    along: ArrayLike,
    at_a: ArrayLike | None = None,
    at_b: ArrayLike | None = None,
) -> Measure:
    """Rate of `offset` [m/s]."""
    x = _offset(a, b, along, at_a, at_b, "measures.offset_rate")
    return of_coordinate(x, f"offset rate of {label(b)} from {label(a)}", rate=True)


def _offset(
    a: Body | Ground, b: Body | Ground, along: ArrayLike, at_a: ArrayLike | None, at_b: ArrayLike | None, what: str
) -> Coordinate:
    for body in (a, b):
        body_or_error(body, what)
    axis = unit(along, f"{what}: along")
    return Coordinate("slide", a, b, axis, axis, point_of(a, at_a, what), point_of(b, at_b, what))


@explaining
def between(
    a: Body | Ground, b: Body | Ground, *, at_a: ArrayLike | None = None, at_b: ArrayLike | None = None
) -> dict[str, Measure]:
    """The pose of b relative to a: "x", "y", "z" [m] by `offset` and "turn_x", "turn_y", "turn_z" [rad] by `turn`.

    Along and about the axes of a that are world axes at the reference pose.
    """
    names = f"{label(b)} from {label(a)}"
    found = {}
    for name, axis in zip("xyz", AXES, strict=True):
        found[name] = replace(offset(a, b, along=axis, at_a=at_a, at_b=at_b), label=f"{name} of {names}")
    for name, axis in zip("xyz", AXES, strict=True):
        found[f"turn_{name}"] = replace(turn(a, b, about=axis), label=f"turn about {name} of {names}")
    return found


@explaining
def length(spring: SpringDamper | ForceCurve) -> Measure:
    """Length of a spring or damper between two points [m]."""
    if not isinstance(spring, SpringDamper | ForceCurve):
        raise InputError(
            f"measures.length: {shown(spring)} is not a SpringDamper or ForceCurve; use measures.distance(a, b)"
        )
    measure = distance(spring.a, spring.b, at_a=spring.at_a, at_b=spring.at_b)
    return replace(measure, label=f"length of {label(spring)}")
