"""A joint of every type, driver and coupling in general position: seeded, r_G != 0, no axis aligned, no zero."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.random import Generator

import mbsd3d


def direction(rng: Generator) -> np.ndarray:
    """Unit vector without a zero component, (3,)."""
    axis = rng.normal(size=3) + np.sign(rng.normal(size=3)) * 0.2
    return axis / np.linalg.norm(axis)


def across(rng: Generator, axis: np.ndarray) -> np.ndarray:
    """Unit vector at right angles to ``axis``, otherwise general, (3,)."""
    other = np.cross(axis, direction(rng))
    return other / np.linalg.norm(other)


def random_orientation(rng: Generator) -> np.ndarray:
    """Unit quaternion, (4,)."""
    e = rng.normal(size=4)
    return e / np.linalg.norm(e)


def random_inertia(rng: Generator, mass: float, size: float = 0.3) -> np.ndarray:
    """Inertia of six equal point masses at random places: any axes, and the triangle rule holds, (3, 3)."""
    points = size * rng.normal(size=(6, 3))
    points -= points.mean(axis=0)
    return mass / 6 * sum((x @ x) * np.eye(3) - np.outer(x, x) for x in points)


def random_body(rng: Generator, name: str = "body", **fields: Any) -> mbsd3d.Body:
    """A body whose every number is general; given fields win."""
    mass = fields.pop("mass", None) or rng.uniform(0.7, 3.0)
    general = dict(
        inertia=random_inertia(rng, mass),
        com=0.3 * direction(rng),
        position=rng.normal(size=3),
        orientation=random_orientation(rng),
    )
    return mbsd3d.Body(name, mass, **{**general, **fields})


def signal(rng: Generator, offset: float = 0.0) -> mbsd3d.Sine:
    """A sine with f(0) = ``offset`` and no zero derivative."""
    amplitude, frequency, phase = rng.uniform(0.3, 0.6), rng.uniform(0.3, 0.5), rng.uniform(0.2, 1.0)
    return mbsd3d.Sine(amplitude, frequency, phase, offset - amplitude * np.sin(phase))


def rolling_plane(
    rng: Generator, centre: np.ndarray, axis: np.ndarray, radius: float, crown: float
) -> tuple[np.ndarray, np.ndarray]:
    """(point, normal) of a plane that a disc in general position touches."""
    normal = direction(rng)
    lean = normal @ axis
    down = -(normal - lean * axis) / np.sqrt(1 - lean**2)
    along = across(rng, normal)
    return centre + (radius - crown) * down - crown * normal + 0.7 * along, normal


def _rolling(rng: Generator, a: Any, b: Any) -> list[mbsd3d.Joint]:
    axis, centre = direction(rng), b.position + 0.2 * direction(rng)
    plane = rolling_plane(rng, centre, axis, 0.5, 0.1)
    return [mbsd3d.RollingDisc(a, b, axis=axis, radius=0.5, crown=0.1, centre=centre, plane=plane)]


def _shafts(rng: Generator, bend: float) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors that enclose ``bend``."""
    first = direction(rng)
    return first, np.cos(bend) * first + np.sin(bend) * across(rng, first)


def _universal(rng: Generator, cls: type, a: Any, b: Any, **at: Any) -> list[mbsd3d.Joint]:
    axis = direction(rng)
    return [cls(a, b, axis_a=axis, axis_b=across(rng, axis), **at)]


def _constant_velocity(rng: Generator, a: Any, b: Any) -> list[mbsd3d.Joint]:
    axis_a, axis_b = _shafts(rng, 0.6)
    return [mbsd3d.ConstantVelocity(a, b, at=middle(rng, a, b), axis_a=axis_a, axis_b=axis_b)]


def _gear(rng: Generator, a: Any, b: Any, c: Any, d: Any) -> list[mbsd3d.Joint]:
    first = mbsd3d.Revolute(a, b, at=middle(rng, a, b), axis=direction(rng))
    second = mbsd3d.Cylindrical(c, d, at=middle(rng, c, d), axis=direction(rng))
    return [first, second, mbsd3d.Gear(first, second, ratio=-1.7)]


def _mesh(rng: Generator, carrier: Any, gear_a: Any, gear_b: Any) -> list[mbsd3d.Joint]:
    """Helical gears on general parallel axes, at two general points of them."""
    axis = direction(rng)
    out = across(rng, axis)
    first = mbsd3d.Revolute(carrier, gear_a, at=(at := middle(rng, carrier, gear_a)), axis=axis)
    second = mbsd3d.Cylindrical(gear_b, carrier, at=at + 0.9 * out - 0.2 * axis, axis=-axis)
    return [first, second, mbsd3d.GearMesh(first, second, at=at + 0.35 * out + 0.1 * axis, helix_angle=0.4)]


def _rack(rng: Generator, a: Any, b: Any, c: Any, d: Any) -> list[mbsd3d.Joint]:
    pinion = mbsd3d.Revolute(a, b, at=middle(rng, a, b), axis=direction(rng))
    rack = mbsd3d.Prismatic(c, d, at=middle(rng, c, d), axis=direction(rng))
    return [pinion, rack, mbsd3d.RackPinion(pinion, rack, radius=0.37)]


def _angle_driver(rng: Generator, a: Any, b: Any) -> list[mbsd3d.Joint]:
    hinge = mbsd3d.Revolute(a, b, at=middle(rng, a, b), axis=direction(rng))
    return [hinge, mbsd3d.AngleDriver(hinge, signal(rng))]


def _slide_driver(rng: Generator, a: Any, b: Any) -> list[mbsd3d.Joint]:
    slider = mbsd3d.Cylindrical(a, b, at=middle(rng, a, b), axis=direction(rng))
    return [slider, mbsd3d.SlideDriver(slider, signal(rng))]


def _position_driver(rng: Generator, a: Any, b: Any) -> list[mbsd3d.Joint]:
    return [mbsd3d.PositionDriver(b, at=b.position + direction(rng), signal=(signal(rng), None, signal(rng)))]


def middle(rng: Generator, a: Any, b: Any) -> np.ndarray:
    """A general point near the middle of two bodies."""
    return (a.position + b.position) / 2 + 0.3 * direction(rng)


Factory = Callable[..., list[mbsd3d.Joint]]

JOINTS: dict[type, Factory] = {
    mbsd3d.Spherical: lambda rng, a, b, c, d: [mbsd3d.Spherical(a, b, at=middle(rng, a, b))],
    mbsd3d.Revolute: lambda rng, a, b, c, d: [mbsd3d.Revolute(a, b, at=middle(rng, a, b), axis=direction(rng))],
    mbsd3d.Universal: lambda rng, a, b, c, d: _universal(rng, mbsd3d.Universal, a, b, at=middle(rng, a, b)),
    mbsd3d.Prismatic: lambda rng, a, b, c, d: [mbsd3d.Prismatic(a, b, at=middle(rng, a, b), axis=direction(rng))],
    mbsd3d.Cylindrical: lambda rng, a, b, c, d: [mbsd3d.Cylindrical(a, b, at=middle(rng, a, b), axis=direction(rng))],
    mbsd3d.Planar: lambda rng, a, b, c, d: [mbsd3d.Planar(a, b, at=middle(rng, a, b), normal=direction(rng))],
    mbsd3d.Fixed: lambda rng, a, b, c, d: [mbsd3d.Fixed(a, b, at=middle(rng, a, b))],
    mbsd3d.PointOnLine: lambda rng, a, b, c, d: [mbsd3d.PointOnLine(a, b, at=middle(rng, a, b), axis=direction(rng))],
    mbsd3d.PointOnPlane: lambda rng, a, b, c, d: [
        mbsd3d.PointOnPlane(a, b, at=middle(rng, a, b), normal=direction(rng))
    ],
    mbsd3d.Distance: lambda rng, a, b, c, d: [
        mbsd3d.Distance(a, b, at_a=a.position + 0.3 * direction(rng), at_b=b.position + 0.3 * direction(rng))
    ],
    mbsd3d.Parallel: lambda rng, a, b, c, d: [mbsd3d.Parallel(a, b, axis=direction(rng))],
    mbsd3d.Perpendicular: lambda rng, a, b, c, d: _universal(rng, mbsd3d.Perpendicular, a, b),
    mbsd3d.ConstantVelocity: lambda rng, a, b, c, d: _constant_velocity(rng, a, b),
    mbsd3d.Screw: lambda rng, a, b, c, d: [mbsd3d.Screw(a, b, at=middle(rng, a, b), axis=direction(rng), pitch=0.8)],
    mbsd3d.RollingDisc: lambda rng, a, b, c, d: _rolling(rng, a, b),
    mbsd3d.KnifeEdge: lambda rng, a, b, c, d: [mbsd3d.KnifeEdge(a, b, at=middle(rng, a, b), lateral=direction(rng))],
}
"""Class -> factory(rng, a, b, c, d) of a joint of that class between a and b. A new joint needs no other entry."""

EXAMPLES: dict[type, Factory] = {
    **JOINTS,
    mbsd3d.Gear: _gear,
    mbsd3d.GearMesh: lambda rng, a, b, c, d: _mesh(rng, a, b, c),
    mbsd3d.RackPinion: _rack,
    mbsd3d.AngleDriver: lambda rng, a, b, c, d: _angle_driver(rng, a, b),
    mbsd3d.SlideDriver: lambda rng, a, b, c, d: _slide_driver(rng, a, b),
    mbsd3d.PositionDriver: lambda rng, a, b, c, d: _position_driver(rng, a, b),
    mbsd3d.SpeedDriver: lambda rng, a, b, c, d: [mbsd3d.SpeedDriver(a, b, axis=direction(rng), speed=signal(rng, 0.4))],
}
"""The same of couplings, which use all four bodies, and drivers: lists of joints that end with one of the class."""

NOT_ON_GROUND = (mbsd3d.RollingDisc, mbsd3d.PositionDriver)  # Joints whose body b must be a moving body
