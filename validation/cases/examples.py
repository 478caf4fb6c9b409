"""Joint of every type, driver and coupling in general position, and random mechanisms of them.

Seeded: r_G != 0, no axis aligned, no zero. Random mechanisms are trees and loops of every joint, driver and coupling,
with a spring and a gravity.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.random import Generator

import mbsd3d
from validation.twins.definitions import equations as reference_point
from validation.twins.definitions.rows import GEOMETRY, VELOCITY


def direction(rng: Generator) -> np.ndarray:
    """Draw a unit vector without a zero component, (3,)."""
    axis = rng.normal(size=3) + np.sign(rng.normal(size=3)) * 0.2
    return axis / np.linalg.norm(axis)


def across(rng: Generator, axis: np.ndarray) -> np.ndarray:
    """Draw a unit vector at right angles to ``axis``, otherwise general, (3,)."""
    other = np.cross(axis, direction(rng))
    return other / np.linalg.norm(other)


def random_orientation(rng: Generator) -> np.ndarray:
    """Draw a unit quaternion, (4,)."""
    e = rng.normal(size=4)
    return e / np.linalg.norm(e)


def random_inertia(rng: Generator, mass: float, size: float = 0.3) -> np.ndarray:
    """Draw the inertia of six equal point masses at random points: any axes, and the triangle rule holds, (3, 3)."""
    points = size * rng.normal(size=(6, 3))
    points -= points.mean(axis=0)
    return mass / 6 * sum((x @ x) * np.eye(3) - np.outer(x, x) for x in points)


def random_body(rng: Generator, name: str = "body", **fields: Any) -> mbsd3d.Body:
    """Draw a body with general numbers; given fields replace them."""
    mass = fields.pop("mass", None) or rng.uniform(0.7, 3.0)
    general = dict(
        inertia=random_inertia(rng, mass),
        com=0.3 * direction(rng),
        position=rng.normal(size=3),
        orientation=random_orientation(rng),
    )
    return mbsd3d.Body(name, mass, **{**general, **fields})


def signal(rng: Generator, offset: float = 0.0) -> mbsd3d.Sine:
    """Draw a sine with f(0) = ``offset`` and no zero derivative."""
    amplitude, frequency, phase = rng.uniform(0.3, 0.6), rng.uniform(0.3, 0.5), rng.uniform(0.2, 1.0)
    return mbsd3d.Sine(amplitude, frequency, phase, offset - amplitude * np.sin(phase))


def rolling_plane(
    rng: Generator, centre: np.ndarray, axis: np.ndarray, radius: float, crown: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return (point, normal) of a plane that a disc in general position touches."""
    normal = direction(rng)
    lean = normal @ axis
    down = -(normal - lean * axis) / np.sqrt(1 - lean**2)
    along = across(rng, normal)
    return centre + (radius - crown) * down - crown * normal + 0.7 * along, normal


def _rolling(rng: Generator, a: Any, b: Any) -> list[mbsd3d.Joint]:
    axis, centre = direction(rng), b.position + 0.2 * direction(rng)
    plane = rolling_plane(rng, centre, axis, 0.5, 0.1)
    return [mbsd3d.RollingDisc(a, b, axis=axis, radius=0.5, crown=0.1, centre=centre, plane=plane)]


def _stone(rng: Generator, a: Any, b: Any) -> list[mbsd3d.Joint]:
    """Draw an ellipsoid in general position on a plane it touches."""
    stone = mbsd3d.shapes.Ellipsoid((0.7, 0.5, 0.3), at=0.2 * direction(rng), orientation=random_orientation(rng))
    turn = mbsd3d.rotations.matrix(b.orientation) @ mbsd3d.rotations.matrix(stone.orientation)
    normal = direction(rng)
    local = stone.radii**2 * (turn.T @ normal)
    lowest = -turn @ local / np.linalg.norm(local / stone.radii)
    centre = b.position + mbsd3d.rotations.matrix(b.orientation) @ stone.at
    plane = (centre + lowest + 0.7 * across(rng, normal), normal)
    return [mbsd3d.Rolling(a, b, stone, plane=plane)]


def _curve(rng: Generator, a: Any, b: Any) -> list[mbsd3d.Joint]:
    """Draw a point of b on a wide closed curve in space."""
    turn, frame = 2 * np.pi * np.arange(60) / 60, mbsd3d.rotations.matrix(random_orientation(rng))
    points = np.column_stack([5 * np.cos(turn), 4.5 * np.sin(turn), 0.8 * np.sin(2 * turn + 0.3)]) @ frame
    at = middle(rng, a, b)
    return [mbsd3d.CurveContact(a, b, points - points[7] + at, at=at)]


def _universal(rng: Generator, cls: type, a: Any, b: Any, **at: Any) -> list[mbsd3d.Joint]:
    axis = direction(rng)
    return [cls(a, b, axis_a=axis, axis_b=across(rng, axis), **at)]


def _constant_velocity(rng: Generator, a: Any, b: Any) -> list[mbsd3d.Joint]:
    first = direction(rng)  # the shafts enclose 0.6 rad
    axis_b = np.cos(0.6) * first + np.sin(0.6) * across(rng, first)
    return [mbsd3d.ConstantVelocity(a, b, at=middle(rng, a, b), axis_a=first, axis_b=axis_b)]


def _gear(rng: Generator, a: Any, b: Any, c: Any, d: Any) -> list[mbsd3d.Joint]:
    first = mbsd3d.Revolute(a, b, at=middle(rng, a, b), axis=direction(rng))
    second = mbsd3d.Cylindrical(c, d, at=middle(rng, c, d), axis=direction(rng))
    return [first, second, mbsd3d.Gear(first, second, ratio=-1.7)]


def _mesh(rng: Generator, carrier: Any, gear_a: Any, gear_b: Any) -> list[mbsd3d.Joint]:
    """Draw helical gears on general parallel axes, at two general points of them."""
    axis = direction(rng)
    out = across(rng, axis)
    first = mbsd3d.Revolute(carrier, gear_a, at=(at := middle(rng, carrier, gear_a)), axis=axis)
    second = mbsd3d.Cylindrical(gear_b, carrier, at=at + 0.9 * out - 0.2 * axis, axis=-axis)
    return [first, second, mbsd3d.GearMesh(first, second, at=at + 0.35 * out + 0.1 * axis, helix_angle=0.4)]


def _rack(rng: Generator, a: Any, b: Any, c: Any, d: Any) -> list[mbsd3d.Joint]:
    pinion = mbsd3d.Revolute(a, b, at=middle(rng, a, b), axis=direction(rng))
    rack = mbsd3d.Prismatic(c, d, at=middle(rng, c, d), axis=direction(rng))
    return [pinion, rack, mbsd3d.RackPinion(pinion, rack, radius=0.37)]


def _coupler(rng: Generator, a: Any, b: Any, c: Any, d: Any) -> list[mbsd3d.Joint]:
    """Draw a slide that follows a polynomial of a weighted sum of angle and slide of another joint."""
    leader = mbsd3d.Cylindrical(a, b, at=middle(rng, a, b), axis=direction(rng))
    follower = mbsd3d.Prismatic(c, d, at=middle(rng, c, d), axis=direction(rng))
    coupler = mbsd3d.Coupler(
        (leader, leader), follower, coefficients=(0, 0.7, -0.3, 0.2), x_weights=(0.8, -0.5), x_of=("angle", "slide"),
        y_weights=(1.3,),
    )  # fmt: skip
    return [leader, follower, coupler]


def _angle_driver(rng: Generator, a: Any, b: Any) -> list[mbsd3d.Joint]:
    hinge = mbsd3d.Revolute(a, b, at=middle(rng, a, b), axis=direction(rng))
    return [hinge, mbsd3d.AngleDriver(hinge, signal(rng))]


def _slide_driver(rng: Generator, a: Any, b: Any) -> list[mbsd3d.Joint]:
    slider = mbsd3d.Cylindrical(a, b, at=middle(rng, a, b), axis=direction(rng))
    return [slider, mbsd3d.SlideDriver(slider, signal(rng))]


def _position_driver(rng: Generator, a: Any, b: Any) -> list[mbsd3d.Joint]:
    return [mbsd3d.PositionDriver(b, at=b.position + direction(rng), signal=(signal(rng), None, signal(rng)))]


def _length_driver(rng: Generator, a: Any, b: Any) -> mbsd3d.Joint:
    at_a, at_b = a.position + 0.3 * direction(rng), b.position + 0.3 * direction(rng)
    return mbsd3d.LengthDriver(a, b, at_a=at_a, at_b=at_b, length=signal(rng, float(np.linalg.norm(at_b - at_a))))


def _orientation_driver(rng: Generator, a: Any, b: Any) -> mbsd3d.Joint:
    return mbsd3d.OrientationDriver(a, b, signal=[signal(rng) for _ in range(3)])


def middle(rng: Generator, a: Any, b: Any) -> np.ndarray:
    """Draw a general point near the middle of two bodies."""
    return (a.position + b.position) / 2 + 0.3 * direction(rng)


def _engaged(rng: Generator, a: Any, b: Any) -> list[mbsd3d.Joint]:
    """Return a hinge whose parts meet at the reference pose because it engaged where b stood elsewhere."""
    at, axis, shift, turn = middle(rng, a, b), direction(rng), direction(rng), random_orientation(rng)
    back = mbsd3d.rotations.matrix(turn).T
    hinge = mbsd3d.Revolute(a, b, at=at, at_b=back @ (at - shift), axis=axis, axis_b=back @ axis)
    return [mbsd3d.Engaged(hinge, shift=shift, turn=turn)]


def _switched(rng: Generator, a: Any, b: Any) -> mbsd3d.Joint:
    """Return a hinge that holds at the start and is let go far away."""
    far = mbsd3d.measures.distance(a, b) > 1e3
    hinge = mbsd3d.Revolute(a, b, at=middle(rng, a, b), axis=direction(rng))
    return mbsd3d.Switched(hinge, release=far, engaged=True)


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
    mbsd3d.CurveContact: lambda rng, a, b, c, d: _curve(rng, a, b),
    mbsd3d.ConstantVelocity: lambda rng, a, b, c, d: _constant_velocity(rng, a, b),
    mbsd3d.Screw: lambda rng, a, b, c, d: [mbsd3d.Screw(a, b, at=middle(rng, a, b), axis=direction(rng), pitch=0.8)],
    mbsd3d.RollingDisc: lambda rng, a, b, c, d: _rolling(rng, a, b),
    mbsd3d.Rolling: lambda rng, a, b, c, d: _stone(rng, a, b),
    mbsd3d.KnifeEdge: lambda rng, a, b, c, d: [mbsd3d.KnifeEdge(a, b, at=middle(rng, a, b), lateral=direction(rng))],
}
"""Class -> factory(rng, a, b, c, d) of a joint of that class between a and b. A new joint needs no other entry."""

EXAMPLES: dict[type, Factory] = {
    **JOINTS,
    mbsd3d.Gear: _gear,
    mbsd3d.Coupler: _coupler,
    mbsd3d.GearMesh: lambda rng, a, b, c, d: _mesh(rng, a, b, c),
    mbsd3d.RackPinion: _rack,
    mbsd3d.AngleDriver: lambda rng, a, b, c, d: _angle_driver(rng, a, b),
    mbsd3d.SlideDriver: lambda rng, a, b, c, d: _slide_driver(rng, a, b),
    mbsd3d.PositionDriver: lambda rng, a, b, c, d: _position_driver(rng, a, b),
    mbsd3d.SpeedDriver: lambda rng, a, b, c, d: [mbsd3d.SpeedDriver(a, b, axis=direction(rng), speed=signal(rng, 0.4))],
    mbsd3d.LengthDriver: lambda rng, a, b, c, d: [_length_driver(rng, a, b)],
    mbsd3d.OrientationDriver: lambda rng, a, b, c, d: [_orientation_driver(rng, a, b)],
    mbsd3d.Engaged: lambda rng, a, b, c, d: _engaged(rng, a, b),
    mbsd3d.Switched: lambda rng, a, b, c, d: [_switched(rng, a, b)],
    mbsd3d.Breaks: lambda rng, a, b, c, d: [
        mbsd3d.Breaks(mbsd3d.Revolute(a, b, at=middle(rng, a, b), axis=direction(rng)), force=1e3)
    ],
}
"""The same of couplings, which use all four bodies, and drivers: lists of joints that end with one of the class."""

NOT_ON_GROUND = (mbsd3d.RollingDisc, mbsd3d.Rolling, mbsd3d.PositionDriver)  # Joints whose body b must be a moving body


TREE_JOINTS = [cls for cls in JOINTS if (cls in GEOMETRY or cls in VELOCITY) and cls is not mbsd3d.CurveContact]
"""Joints between two bodies that a second formulation can judge; contacts on curves have trials of their own."""
CLOSING_JOINTS = (mbsd3d.Distance, mbsd3d.PointOnPlane, mbsd3d.Perpendicular, mbsd3d.PointOnLine, mbsd3d.Spherical)
HINGE_JOINTS = (mbsd3d.Revolute, mbsd3d.Cylindrical, mbsd3d.Screw)


def rows_of(joints: Sequence[Any]) -> int:
    """Return the number of rows of joints."""
    return sum(row.n_rows for joint in joints for row in joint.rows())


def random_tree(rng: np.random.Generator) -> tuple[list[mbsd3d.Body], list[Any]]:
    """Draw (bodies, joints): each body on an earlier one or the ground by a joint of any type; a tooth mesh in some."""
    bodies, joints = [], []
    light = rng.choice([1.0, 1.0, 1e-2, 1e-4])
    for k in range(rng.integers(2, 7)):
        mass = rng.uniform(0.7, 2.0) * (light if rng.random() < 0.4 else 1.0)
        bodies.append(random_body(rng, f"body{k}", mass=mass, position=2.0 * rng.normal(size=3)))
        parent = mbsd3d.GROUND if k == 0 else [mbsd3d.GROUND, *bodies[:-1]][rng.integers(0, k + 1)]
        joints += EXAMPLES[TREE_JOINTS[rng.integers(len(TREE_JOINTS))]](rng, parent, bodies[-1], None, None)
    if rng.random() < 0.3:
        gears = [random_body(rng, f"gear{k}", position=bodies[0].position + direction(rng)) for k in range(2)]
        bodies += gears
        joints += EXAMPLES[mbsd3d.GearMesh](rng, bodies[0], *gears, None)
    return bodies, joints


def loops(rng: np.random.Generator, bodies: Sequence[mbsd3d.Body]) -> list[Any]:
    """Draw a candidate that closes a loop between two bodies."""
    a, b = rng.choice(len(bodies), 2, replace=False)
    cls = CLOSING_JOINTS[rng.integers(len(CLOSING_JOINTS))]
    return EXAMPLES[cls](rng, bodies[a], bodies[b], None, None)


def couplings(rng: np.random.Generator, joints: Sequence[Any]) -> list[Any]:
    """Return candidates on existing hinges and sliders."""
    hinges = [j for j in joints if isinstance(j, HINGE_JOINTS)]
    sliders = [j for j in joints if isinstance(j, mbsd3d.Prismatic | mbsd3d.Cylindrical)]
    found: list[mbsd3d.Joint] = []
    if len(hinges) > 1:
        found.append(mbsd3d.Gear(hinges[0], hinges[-1], ratio=rng.uniform(-2.0, -0.5)))
    if hinges and sliders and hinges[0] is not sliders[-1]:
        found.append(mbsd3d.RackPinion(hinges[0], sliders[-1], radius=rng.uniform(0.2, 0.6)))
    return found


def drivers(rng: np.random.Generator, bodies: Sequence[mbsd3d.Body], joints: Sequence[Any]) -> list[Any]:
    """Return candidates that move a coordinate, a point, or prescribe a speed."""
    angles = [j for j in joints if isinstance(j, (*HINGE_JOINTS, mbsd3d.Planar))]
    slides = [j for j in joints if isinstance(j, mbsd3d.Prismatic | mbsd3d.Cylindrical)]
    body = bodies[-1]
    found = [
        mbsd3d.PositionDriver(body, at=body.position + 0.3 * direction(rng), signal=(signal(rng), None, None)),
        mbsd3d.SpeedDriver(mbsd3d.GROUND, bodies[len(bodies) // 2], axis=direction(rng), speed=signal(rng, 0.4)),
    ]
    found += [mbsd3d.AngleDriver(angles[-1], signal(rng))] if angles else []
    found += [mbsd3d.SlideDriver(slides[-1], signal(rng))] if slides else []
    return [joint for joint in found if rng.random() < 0.4]


def redundant(rng: np.random.Generator, joints: Sequence[Any]) -> list[Any]:
    """Draw a redundant part: another hinge on the same axis, or parallelism that exists already."""
    hinges = [j for j in joints if type(j) is mbsd3d.Revolute]
    rails = [j for j in joints if type(j) is mbsd3d.Prismatic]
    if hinges:
        return [mbsd3d.Revolute(hinges[0].a, hinges[0].b, at=hinges[0].at + 0.6 * hinges[0].axis, axis=hinges[0].axis)]
    return [mbsd3d.Parallel(rails[0].a, rails[0].b, axis=direction(rng))] if rails else []


def independent(bodies: Sequence[mbsd3d.Body], joints: Sequence[Any]) -> bool:
    """Return whether the rows are independent, by the second formulation: dependent drivers may contradict each
    other."""
    system = mbsd3d.System(bodies, joints)
    pose = mbsd3d.State(0.0, np.concatenate([[*b.position, *b.orientation] for b in bodies]), np.zeros(6 * len(bodies)))
    return reference_point.solve(system, pose).rank == rows_of(joints)


def mechanism(seed: int) -> mbsd3d.System:
    """Draw a random mechanism with at least one degree of freedom, without parts that would lock it."""
    rng = np.random.default_rng([seed, 2026])
    bodies, joints = random_tree(rng)
    extra = [[joint] for joint in couplings(rng, joints)] + [[joint] for joint in drivers(rng, bodies, joints)]
    if len(bodies) > 2:
        extra += [loops(rng, bodies) for _ in range(rng.integers(0, 3))]
    for candidate in extra:
        if rows_of([*joints, *candidate]) < 6 * len(bodies) and independent(bodies, [*joints, *candidate]):
            joints += candidate
    if rng.random() < 0.3:
        joints += redundant(rng, joints)
    ends: dict[str, Any] = dict(at_a=direction(rng), at_b=bodies[-1].position + direction(rng))
    mass = bodies[-1].mass  # a stiff damper on a light body would be another test
    spring = mbsd3d.SpringDamper(mbsd3d.GROUND, bodies[-1], **ends, stiffness=mass * rng.uniform(5, 50), damping=mass)
    return mbsd3d.System(bodies, joints, [spring], gravity=rng.normal(size=3) * 5)


def moving(system: mbsd3d.System, seed: int) -> mbsd3d.State:
    """Draw the reference pose with general velocities of some m/s and rad/s that all joints and drivers allow."""
    rest = system.state()
    _, s, Vt = np.linalg.svd(reference_point.constraint_rows(system, rest).J)
    free = Vt[int((s > reference_point.SINGULAR_VALUE_RATIO_MIN * s.max(initial=0.0)).sum()) :]
    wanted = np.random.default_rng([seed, 1]).normal(size=rest.v.size) - rest.v
    return replace(rest, v=rest.v + free.T @ (free @ wanted))
