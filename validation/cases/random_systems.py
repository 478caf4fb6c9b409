"""Random mechanisms: seeded trees and loops of every joint, driver and coupling, with a spring and a gravity."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

import mbsd3d
from validation.cases.examples import EXAMPLES, JOINTS, direction, random_body, signal
from validation.twins.definitions import equations as reference_point
from validation.twins.definitions.rows import GEOMETRY, VELOCITY

TREE = [cls for cls in JOINTS if cls in GEOMETRY or cls in VELOCITY]
"""Joints between two bodies that a second formulation can judge."""
CLOSING = (mbsd3d.Distance, mbsd3d.PointOnPlane, mbsd3d.Perpendicular, mbsd3d.PointOnLine, mbsd3d.Spherical)
HINGES = (mbsd3d.Revolute, mbsd3d.Cylindrical, mbsd3d.Screw)


def rows_of(joints: Sequence[Any]) -> int:
    """Number of rows."""
    return sum(row.n_rows for joint in joints for row in joint.rows())


def random_tree(rng: np.random.Generator) -> tuple[list[mbsd3d.Body], list[Any]]:
    """(bodies, joints): each body on an earlier one or the ground by a joint of any type; a tooth mesh in some."""
    bodies, joints = [], []
    light = rng.choice([1.0, 1.0, 1e-2, 1e-4])
    for k in range(rng.integers(2, 7)):
        mass = rng.uniform(0.7, 2.0) * (light if rng.random() < 0.4 else 1.0)
        bodies.append(random_body(rng, f"body{k}", mass=mass, position=2.0 * rng.normal(size=3)))
        parent = mbsd3d.GROUND if k == 0 else [mbsd3d.GROUND, *bodies[:-1]][rng.integers(0, k + 1)]
        joints += EXAMPLES[TREE[rng.integers(len(TREE))]](rng, parent, bodies[-1], None, None)
    if rng.random() < 0.3:
        gears = [random_body(rng, f"gear{k}", position=bodies[0].position + direction(rng)) for k in range(2)]
        bodies += gears
        joints += EXAMPLES[mbsd3d.GearMesh](rng, bodies[0], *gears, None)
    return bodies, joints


def loops(rng: np.random.Generator, bodies: Sequence[mbsd3d.Body]) -> list[Any]:
    """A candidate that closes a loop between two bodies."""
    a, b = rng.choice(len(bodies), 2, replace=False)
    cls = CLOSING[rng.integers(len(CLOSING))]
    return EXAMPLES[cls](rng, bodies[a], bodies[b], None, None)


def couplings(rng: np.random.Generator, joints: Sequence[Any]) -> list[Any]:
    """Candidates on hinges and sliders that are there."""
    hinges = [j for j in joints if isinstance(j, HINGES)]
    sliders = [j for j in joints if isinstance(j, mbsd3d.Prismatic | mbsd3d.Cylindrical)]
    found = []
    if len(hinges) > 1:
        found.append(mbsd3d.Gear(hinges[0], hinges[-1], ratio=rng.uniform(-2.0, -0.5)))
    if hinges and sliders and hinges[0] is not sliders[-1]:
        found.append(mbsd3d.RackPinion(hinges[0], sliders[-1], radius=rng.uniform(0.2, 0.6)))
    return found


def drivers(rng: np.random.Generator, bodies: Sequence[mbsd3d.Body], joints: Sequence[Any]) -> list[Any]:
    """Candidates that move a coordinate, a point, or keep a speed."""
    angles = [j for j in joints if isinstance(j, (*HINGES, mbsd3d.Planar))]
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
    """A second part where one is enough: another hinge on the same axis, or parallelism that is there already."""
    hinges = [j for j in joints if type(j) is mbsd3d.Revolute]
    rails = [j for j in joints if type(j) is mbsd3d.Prismatic]
    if hinges:
        return [mbsd3d.Revolute(hinges[0].a, hinges[0].b, at=hinges[0].at + 0.6 * hinges[0].axis, axis=hinges[0].axis)]
    return [mbsd3d.Parallel(rails[0].a, rails[0].b, axis=direction(rng))] if rails else []


def independent(bodies: Sequence[mbsd3d.Body], joints: Sequence[Any]) -> bool:
    """Whether the rows are independent, as the second formulation has them: else drivers may contradict each other."""
    system = mbsd3d.System(bodies, joints)
    pose = mbsd3d.State(0.0, np.concatenate([[*b.position, *b.orientation] for b in bodies]), np.zeros(6 * len(bodies)))
    return reference_point.solve(system, pose).rank == rows_of(joints)


def mechanism(seed: int) -> mbsd3d.System:
    """A random mechanism with at least one freedom left: what would lock it is left out."""
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
    ends = dict(at_a=direction(rng), at_b=bodies[-1].position + direction(rng))
    mass = bodies[-1].mass  # a stiff damper on a light body would be another test
    spring = mbsd3d.SpringDamper(mbsd3d.GROUND, bodies[-1], **ends, stiffness=mass * rng.uniform(5, 50), damping=mass)
    return mbsd3d.System(bodies, joints, [spring], gravity=rng.normal(size=3) * 5)


def moving(system: mbsd3d.System, seed: int) -> mbsd3d.State:
    """The reference pose with general velocities of some m/s and rad/s that all joints and drivers allow."""
    rest = system.state()
    _, s, Vt = np.linalg.svd(reference_point.constraint_rows(system, rest)[0])
    free = Vt[int((s > reference_point.RANK * s.max(initial=0.0)).sum()) :]
    wanted = np.random.default_rng([seed, 1]).normal(size=rest.v.size) - rest.v
    return replace(rest, v=rest.v + free.T @ (free @ wanted))
