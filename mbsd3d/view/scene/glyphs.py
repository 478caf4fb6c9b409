"""Solids of joints, from the motion they allow, not from their names: a new joint needs nothing here.

An angle is a barrel about its axis, a slide a rail along it, a plane a plate, a curve a line, what turns and slides in
no way a cube, a coupling or driver a ring about the axis it acts on, anything else a ball at its point.
"""

from collections.abc import Sequence
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from ...base.rotations import matched_perpendiculars, perpendiculars
from ...mechanism.bodies import Body, Ground, Part
from ...mechanism.contacts import RollingContact, RollingDisc
from ...mechanism.couplings import GearMesh
from ...mechanism.drivers import SpeedDriver
from ...mechanism.force_element import ForceElement
from ...mechanism.forces.cone_stop import ConeStop, RotationStop
from ...mechanism.forces.end_stop import EndStop, PointStop
from ...mechanism.forces.pin_play import PinPlay
from ...mechanism.forces.rope import OverPulleys
from ...mechanism.forces.sum_spring import SumSpring, SumStop
from ...mechanism.joints import Joint
from ...mechanism.joints.curve_contact import CurveContact
from ...mechanism.primitives import Coordinate
from ...mechanism.shapes.triangles import Mesh, ball, block, cylinder, moved, torus
from ...mechanism.sums import weighted
from ...mechanism.tooth_contact import Axle

AXES_OF_A, AXES_OF_B = ("axis", "axis_a", "normal"), ("axis_b", "lateral")
LOCKED_ROWS_MIN = 5  # [rows] from which a joint without an angle cannot turn
PAST_SOLID_RATIO = 1.1  # [1] reach of the marks of a stop over that of the body that would hide them
RIM_RADIUS_RATIO = 0.015  # [1] radius of the tube of a rolling circle over the radius of the circle


class Glyph(NamedTuple):
    """Triangles fixed in a body: in its axes, from O [m]."""

    body: Body | Ground
    mesh: Mesh


@runtime_checkable
class Spanning(Protocol):
    """Part between a point of a and a point of b, both world at the reference pose [m]: a rod, a spring."""

    a: Body | Ground
    b: Body | Ground
    at_a: np.ndarray
    at_b: np.ndarray


@runtime_checkable
class Pinned(Protocol):
    """Part at a point, which body b as built has elsewhere, both world at the reference pose [m]."""

    a: Body | Ground
    b: Body | Ground
    at: np.ndarray
    at_b: np.ndarray


@runtime_checkable
class Wheeled(Protocol):
    """Part that acts on a wheel b with a centre, world at the reference pose [m]."""

    b: Body
    centre: np.ndarray


def placed(mesh: Mesh, body: Body | Ground, point: np.ndarray, axis: np.ndarray) -> Glyph:
    """Return a mesh with its z along an axis and its origin at a point, both world at the reference pose."""
    frame = np.column_stack([body.local_axis(x) for x in (*perpendiculars(axis), axis)])
    return Glyph(body, moved(mesh, frame, body.local_point(point)))


def scaled(mesh: Mesh, *sizes: float) -> Mesh:
    """Return a unit mesh stretched along x, y, z."""
    return moved(mesh, np.diag(sizes), np.zeros(3))


def anchor(joint: Joint) -> tuple[Body | Ground, np.ndarray]:
    """Return the body and the world point at the reference pose where the joint and its name are drawn."""
    if isinstance(joint, RollingContact):
        return joint.b, joint.outline.centre  # the contact travels over both bodies
    return (joint.support() if isinstance(joint, GearMesh) else joint.b), joint.point()


def circles(joint: Joint) -> list[Glyph]:
    """Return the parts of a joint that are to scale: rolling and pitch circles."""
    if isinstance(joint, RollingDisc):
        return [circle(joint.b, joint.centre, joint.axis, joint.radius)]
    if isinstance(joint, GearMesh):
        hinges = [(joint.gear(hinge), joint.axle(hinge)) for hinge in (joint.hinge_a, joint.hinge_b)]
        return [pitch_circle(gear, axle, joint.at) for gear, axle in hinges]
    if isinstance(joint, CurveContact) and joint.radius:
        return [circle(joint.b, joint.at, joint.pin_here, joint.radius)]
    return []


def pulleys(force: ForceElement) -> list[Glyph]:
    """Return the circles that a rope or belt goes round, with a spoke that shows their turning."""
    nodes = force.path.nodes if isinstance(force, OverPulleys) else []
    found = []
    once = {(id(node.body), node.point.tobytes()): node for node in nodes}  # a belt comes back to its first pulley
    for body, point, arm, axis, _ in once.values():
        if arm != 0.0:
            radius, width = abs(arm), 2.0 * RIM_RADIUS_RATIO * abs(arm)
            spoke = moved(scaled(block(), radius, width, width), np.eye(3), np.array([0.5 * radius, 0.0, 0.0]))
            found += [circle(body, point, axis, radius), placed(spoke, body, point, axis)]
    return found


def solids(joint: Joint, size: float) -> list[Glyph]:
    """Return the other solids of a joint; ``size`` [m] is the length of a barrel."""
    if isinstance(joint, RollingContact | GearMesh):
        return []
    if joint.partners():
        moved_by = [(partner, partner.angle() or partner.slide()) for partner in joint.partners()]
        return [ring(partner, x.axis_b, size) for partner, x in moved_by if x is not None]
    return [*guides(joint, size), *ends(joint, *anchor(joint), size)]


def guides(joint: Joint, size: float) -> list[Glyph]:
    """Return barrel, rail and plate, for an angle, a slide and a plane."""
    found, (angle, slide) = [], (joint.angle(), joint.slide())
    if angle is not None:
        found.append(placed(scaled(cylinder(24), 0.36 * size, 0.36 * size, size), angle.b, joint.point(), angle.axis_b))
    if slide is not None and slide.kind == "slide":
        found.append(placed(scaled(block(), 0.24 * size, 0.24 * size, 4.0 * size), slide.a, slide.point_a, slide.axis))
    if hasattr(joint, "normal") and hasattr(joint, "at"):
        found.append(placed(scaled(block(), 3.0 * size, 3.0 * size, 0.12 * size), joint.a, joint.at, joint.normal))
    return found


def ends(joint: Joint, body: Body | Ground, point: np.ndarray, size: float) -> list[Glyph]:
    """Return the solid at the point of a joint without an angle; a ball at the other end of a rod too."""
    if joint.angle() is not None:
        return []
    if isinstance(joint, SpeedDriver):
        return [ring(joint, axis, size) for axis in (joint.axis, joint.direction) if axis is not None]
    if sum(row.n_rows for row in joint.primitives) >= LOCKED_ROWS_MIN:
        along = joint.axis if hasattr(joint, "axis") else np.array([0.0, 0.0, 1.0])
        return [placed(scaled(block(), 0.7 * size, 0.7 * size, 0.9 * size), body, point, along)]
    both = [(body, point), (joint.a, joint.at_a)] if isinstance(joint, Spanning) else [(body, point)]
    up = np.array([0.0, 0.0, 1.0])
    return [placed(scaled(ball(), *3 * (0.42 * size,)), end, place, up) for end, place in both]


def circle(body: Body | Ground, centre: np.ndarray, axis: np.ndarray, radius: float) -> Glyph:
    """Return a thin ring that turns with a body, with the outer radius in its true size."""
    return placed(torus((1.0 - RIM_RADIUS_RATIO) * radius, RIM_RADIUS_RATIO * radius, 60, 4), body, centre, axis)


def pitch_circle(gear: Body | Ground, axle: Axle, at: np.ndarray) -> Glyph:
    """Return the circle about the axis of a gear through the pitch point."""
    arm = axle.arm(at)
    return circle(gear, at - arm, axle.axis, float(np.linalg.norm(arm)))


def ring(joint: Joint, axis: np.ndarray, size: float) -> Glyph:
    """Return a ring at a joint about the axis in which a coupling or driver acts."""
    return placed(torus(0.62 * size, 0.1 * size), joint.b, joint.point(), axis)


def spokes(joint: Joint, length: float) -> list[tuple[Body | Ground, np.ndarray]]:
    """Return (body, (2, 3) ends in its axes from O [m]) of the axes of a joint; (body, (n, 3) points) of its curve."""
    own = {name: joint.a for name in AXES_OF_A} | {name: joint.b for name in AXES_OF_B}
    (_, at), in_a = anchor(joint), getattr(joint, "at", None)
    if isinstance(joint, RollingDisc | GearMesh):
        own["axis"] = joint.b  # of a disc
    axes = {name: getattr(joint, name) for name in own if getattr(joint, name, None) is not None}
    if "axis" in axes and "axis_b" in axes and np.array_equal(axes["axis_b"], axes["axis"]):
        del axes["axis_b"]
    found = [(joint.a, joint.outline)] if isinstance(joint, CurveContact) else []
    for name, axis in axes.items():
        body = own[name]
        point = in_a if body is joint.a and in_a is not None else at
        middle, half = body.local_point(point), 0.5 * length * body.local_axis(axis)
        found.append((body, np.array([middle - half, middle + half])))
    return found


def limits(stop: ForceElement, size: float, solid: np.ndarray) -> list[tuple[Body | Ground, np.ndarray]]:
    """Return (body, points in its axes from O [m]) of what a stop limits: its limits in a, and the pointer in b.

    ``solid``: (k, 3) points of body b, world at the reference pose [m], which must not hide the marks.
    """
    if isinstance(stop, ConeStop | RotationStop):
        length = max(3.0 * size, PAST_SOLID_RATIO * farthest(solid - stop.joint.point()))
        return cone(stop, length) if isinstance(stop, ConeStop) else turn_limit(stop, length)
    if isinstance(stop, PinPlay):
        return hole(stop, size)
    if isinstance(stop, SumStop) and len(stop.joints) == 1:
        ((x, weight),) = weighted(stop.joints, stop.weights, stop.of)
        return range_of(x, [limit / weight for limit in stop.limits], stop.joints[0].point(), size, solid)
    if isinstance(stop, EndStop | PointStop):
        at = stop.joint.point() if isinstance(stop, EndStop) else stop.at
        pin = at if isinstance(stop, EndStop) else stop.at_b
        return range_of(stop.coordinate(), stop.limits, at, size, solid, pin)
    return []


def range_of(
    x: Coordinate, given: Sequence[float], at: np.ndarray, size: float, solid: np.ndarray, pin: np.ndarray | None = None
) -> list[tuple[Body | Ground, np.ndarray]]:
    """Return the strokes of the limits of a coordinate at a point, and of its pointer, of a slide at ``pin``."""
    across, aside = perpendiculars(x.axis)
    ends = [limit for limit in given if np.isfinite(limit)]
    if x.kind == "angle":  # on the nearer face of the body, as the scale of an instrument
        along = (solid - at) @ x.axis
        low, high = along.min(initial=0.0), along.max(initial=0.0)
        at = at + (high + 0.3 * size if high <= -low else low - 0.3 * size) * x.axis if len(solid) else at
        length = max(3.0 * size, 0.5 * farthest((solid - at) @ np.column_stack([across, aside])))
        rays = [np.cos(f) * across + np.sin(f) * aside for f in ends]
        strokes = [(x.a, at, at + length * ray) for ray in rays]
        pointer = matched_perpendiculars(x.axis, x.axis_b)[0] if x.zero_b is None else x.zero_b
        strokes.append((x.b, at, at + 0.8 * length * pointer))
    elif x.kind == "slide":
        bar = max(0.8 * size, PAST_SOLID_RATIO * np.abs((solid - at) @ across).max(initial=0.0) + 0.4 * size) * across
        strokes = [(x.a, at + f * x.axis - bar, at + f * x.axis + bar) for f in ends]
        pointer, middle = bar - 0.4 * size * across, at if pin is None else pin
        strokes.append((x.b, middle - pointer, middle + pointer))
    else:
        return []  # along a curve
    return [(body, np.array([body.local_point(point) for point in points])) for body, *points in strokes]


def farthest(arms: np.ndarray) -> float:
    """Return the length of the longest of some vectors (k, n), 0 of none."""
    return float(np.sqrt((arms**2).sum(axis=1)).max(initial=0.0))


def hole(play: PinPlay, size: float) -> list[tuple[Body | Ground, np.ndarray]]:
    """Return the rim of the bearing of a pin with play, larger than it is, and the axis of the pin."""
    x, y = perpendiculars(play.axis)
    around = np.linspace(0.0, 2.0 * np.pi, 37)[:, None]
    rim = play.at + max(play.pin_radius + play.clearance, 0.6 * size) * (np.cos(around) * x + np.sin(around) * y)
    pin = (play.at_b - 0.5 * size * play.axis, play.at_b + 0.5 * size * play.axis)
    return [(body, np.array([body.local_point(point) for point in points])) for body, points in
            ((play.a, rim), (play.b, pin))]  # fmt: skip


def cone(stop: ConeStop, length: float) -> list[tuple[Body | Ground, np.ndarray]]:
    """Return the rim of the cone of a stop, and the axis that stays in it."""
    return rim(stop.joint, (stop.axis_a, stop.axis_b), stop.half_angle, length)


def turn_limit(stop: RotationStop, length: float) -> list[tuple[Body | Ground, np.ndarray]]:
    """Return rims that two hands of b at right angles do not leave: a turn across a hand by the limit leads it there.

    The first hand points from the joint to the centre of mass.
    """
    arm = stop.joint.b.centre - stop.joint.point()
    reach = float(np.linalg.norm(arm))
    hand = arm / reach if reach > 0.0 else np.array([0.0, 0.0, 1.0])
    return [x for one in (hand, perpendiculars(hand)[0]) for x in rim(stop.joint, (one, one), stop.angle, length)]


def rim(
    joint: Joint, axes: tuple[np.ndarray, np.ndarray], half_angle: float, length: float
) -> list[tuple[Body | Ground, np.ndarray]]:
    """Return the rim of a cone about the first of two axes, in a, and the second one as a hand, in b."""
    at, (x, y) = joint.point(), perpendiculars(axes[0])
    around = np.linspace(0.0, 2.0 * np.pi, 37)[:, None]
    side = np.sin(half_angle) * (np.cos(around) * x + np.sin(around) * y)
    strokes = (joint.a, at + length * (np.cos(half_angle) * axes[0] + side)), (joint.b, (at, at + length * axes[1]))
    return [(body, np.array([body.local_point(point) for point in points])) for body, points in strokes]


def strung(force: ForceElement) -> list[tuple[Body | Ground, np.ndarray]]:
    """Return (body, world point at the reference pose) of the joints that a sum strings together, else nothing."""
    return [(joint.b, joint.point()) for joint in force.joints] if isinstance(force, SumSpring | SumStop) else []


def joints_of(part: Part) -> list[tuple[Body | Ground, np.ndarray]]:
    """Return (body, world point at the reference pose) of the points of a part to which its bodies reach out."""
    if isinstance(part, Spanning):
        return [(part.a, part.at_a), (part.b, part.at_b)]
    if isinstance(part, Pinned):
        return [(part.a, part.at), (part.b, part.at_b)]
    return [(part.b, part.centre)] if isinstance(part, Wheeled) else []
