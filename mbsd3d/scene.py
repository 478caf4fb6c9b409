"""What is drawn of a mechanism: outlines of the bodies, joints with their axes, links; lines in space, no plotting.

A body without a shape of its own is drawn as the homogeneous solid that has its mass and inertia: a cylinder if two
principal moments are equal, a sphere if all are, else a box. ``Body(shape=...)`` may be "box", "ellipsoid", or a
(k, 3) polyline in body axes from the reference point [m], with rows of NaN between its strokes.
"""

from typing import Any, NamedTuple

import numpy as np

from .contacts import RollingDisc
from .joints import Joint
from .parts import GROUND, Body
from .rotations import matrix
from .shapes import Lines
from .state import State

LIFT = np.full((1, 3), np.nan)  # lifts the pen between two strokes
EQUAL = 1e-6  # relative difference of principal moments that counts as none
AXES_OF_A, AXES_OF_B = ("axis", "axis_a", "normal"), ("axis_b", "lateral")


def strokes(*lines: Any) -> np.ndarray:
    """(k, 3) one polyline of several, with NaN between them."""
    pieces = [piece for line in lines for piece in (np.reshape(line, (-1, 3)), LIFT)]
    return np.concatenate(pieces) if pieces else np.zeros((0, 3))


def circle(radius: float, normal: int, height: float = 0.0) -> np.ndarray:
    """Circle about coordinate axis ``normal``."""
    turn = np.linspace(0.0, 2.0 * np.pi, 49)
    points = np.full((turn.size, 3), height)
    points[:, (normal + 1) % 3], points[:, (normal + 2) % 3] = radius * np.cos(turn), radius * np.sin(turn)
    return points


def box_lines(edges: np.ndarray) -> np.ndarray:
    """The twelve edges of a box about the origin."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * edges
    pairs = [(i, i | bit) for bit in (1, 2, 4) for i in range(8) if not i & bit]
    return strokes(*(corners[list(pair)] for pair in pairs))


def cylinder_lines(radius: float, length: float, axis: int) -> np.ndarray:
    """Both ends of a cylinder, four lines along it, and on each end a radius that shows its turning."""
    low, high = circle(radius, axis, -0.5 * length), circle(radius, axis, 0.5 * length)
    middle = np.eye(3)[axis] * 0.5 * length
    sides = [np.array([low[k], high[k]]) for k in (0, 12, 24, 36)]
    return strokes(low, high, *sides, [-middle, low[0]], [middle, high[0]])


def ellipsoid_lines(radii: np.ndarray) -> np.ndarray:
    """The three principal sections of an ellipsoid."""
    return strokes(*(circle(1.0, normal) * (np.arange(3) != normal) * radii for normal in range(3)))


def outline(body: Body) -> np.ndarray:
    """Strokes of a body in body axes from its reference point.

    Parameters
    ----------
    body : Body
        With or without a shape of its own.

    Returns
    -------
    (k, 3) ndarray
        [m]; rows of NaN separate strokes; none for a body without inertia.
    """
    if isinstance(body.shape, Lines):
        return body.shape.line(body)
    if body.mass == 0.0 or not body.inertia.any():
        return np.zeros((0, 3))
    moments, principal = np.linalg.eigh(body.inertia)
    return solid(moments / body.mass, body.shape) @ principal.T + body.com


def solid(moments: np.ndarray, shape: str | None) -> np.ndarray:
    """Outline, in principal axes, of the homogeneous solid with these ascending moments per mass [m^2]."""
    squares = np.maximum(moments.sum() - 2.0 * moments, 0.0)  # of the extents, but for a factor
    low, high = (moments[1] - moments[0], moments[2] - moments[1]) <= EQUAL * moments[2]
    if shape == "ellipsoid" or (shape is None and low and high):
        return ellipsoid_lines(np.sqrt(2.5 * squares))
    if shape is None and (low or high):
        axis = 2 if low else 0
        along, across = moments[axis], moments[1]
        return cylinder_lines(np.sqrt(2.0 * along), np.sqrt(max(12.0 * across - 6.0 * along, 0.0)), axis)
    return box_lines(np.sqrt(6.0 * squares))


class Mark(NamedTuple):
    """A joint: its point and axes fixed in bodies, which are given by their places; the ground comes last."""

    joint: Joint
    body: int
    point: np.ndarray
    axes: list[tuple[int, np.ndarray]]

    def shown_at(self, place: np.ndarray, R: np.ndarray, R_a: np.ndarray) -> np.ndarray:
        """World position of the marker: the point itself, or where a disc with its centre there touches its plane."""
        disc = self.joint
        if not isinstance(disc, RollingDisc):
            return place
        return disc.contact(place, R_a @ disc.a.local_axis(disc.plane[1]), R @ disc.b.local_axis(disc.axis))


class Scene:
    """What is drawn of a system, in body axes; poses (r, R) are (n + 1, 3) and (n + 1, 3, 3), the ground last."""

    def __init__(self, system: Any) -> None:
        self.system, self.bodies = system, [*system.bodies, GROUND]
        self.index = {id(body): i for i, body in enumerate(self.bodies)}
        self.outlines = [outline(body) for body in system.bodies]
        self.joints = [self.mark(joint) for joint in system.joints]
        self.arms = [self.arm(body) for body in system.bodies]
        links = [part for part in (*system.joints, *system.forces) if hasattr(part, "at_a") and hasattr(part, "at_b")]
        self.links = [[self.fixed(link.a, link.at_a), self.fixed(link.b, link.at_b)] for link in links]

    def fixed(self, body: Any, point: np.ndarray) -> tuple[int, np.ndarray]:
        """Place of a body, and in its axes a world point of the reference pose."""
        return self.index[id(body)], body.local_point(point)

    def mark(self, joint: Joint) -> Mark:
        """A joint's point on body b and its axes."""
        disc = isinstance(joint, RollingDisc)
        own = {name: joint.b if disc else joint.a for name in AXES_OF_A} | {name: joint.b for name in AXES_OF_B}
        axes = {name: getattr(joint, name) for name in own if getattr(joint, name, None) is not None}
        if "axis_b" in axes and np.array_equal(axes["axis_b"], axes.get("axis")):
            del axes["axis_b"]
        directions = [(self.index[id(own[name])], own[name].local_axis(axis)) for name, axis in axes.items()]
        return Mark(joint, *self.fixed(joint.b, joint.centre if disc else joint.point()), directions)

    def arm(self, body: Body) -> np.ndarray:
        """Lines from the centre of mass of a body to its joints, body axes."""
        points = []
        for joint in self.system.joints:
            if joint.b is body and (hasattr(joint, "at_b") or hasattr(joint, "centre")):
                points.append(getattr(joint, "at_b", getattr(joint, "centre", None)))
            elif joint.a is body and hasattr(joint, "at_b"):
                points.append(joint.at_a if hasattr(joint, "at_a") else joint.at)
        return strokes(*([body.com, body.local_point(point)] for point in points))

    def poses(self, r: np.ndarray, e: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(r, R) with the ground, from positions (n, 3) and quaternions (n, 4)."""
        return np.vstack([r, np.zeros(3)]), np.concatenate([matrix(e), np.eye(3)[None]])

    def pose(self, state: State | None) -> tuple[np.ndarray, np.ndarray]:
        """(r, R) at a state, or at the reference pose."""
        if state is None:
            bodies = self.system.bodies
            return self.poses(np.array([b.position for b in bodies]), np.array([b.orientation for b in bodies]))
        q = state.q.reshape(-1, 7)
        if len(q) != len(self.outlines):
            raise ValueError(f"state has {len(q)} bodies, the system {len(self.outlines)}; give a state of this system")
        return self.poses(q[:, :3], q[:, 3:])

    def lines(self, pose: tuple[np.ndarray, np.ndarray], size: float) -> list[np.ndarray]:
        """Outlines, arms, centres of mass, reference points of every body; then links, joints, joint axes."""
        r, R = pose
        drawn = []
        for i, body in enumerate(self.system.bodies):
            drawn += [x @ R[i].T + r[i] for x in (self.outlines[i], self.arms[i], body.com[None], np.zeros((1, 3)))]
        at = [mark.point @ R[mark.body].T + r[mark.body] for mark in self.joints]
        tips = [(p, R[k] @ axis) for p, mark in zip(at, self.joints, strict=True) for k, axis in mark.axes]
        shown = [
            mark.shown_at(p, R[mark.body], R[self.index[id(mark.joint.a)]])
            for p, mark in zip(at, self.joints, strict=True)
        ]
        links = [[p @ R[k].T + r[k] for k, p in ends] for ends in self.links]
        spokes = [[p - 0.5 * size * axis, p + 0.5 * size * axis] for p, axis in tips]
        return [*drawn, strokes(*links), np.reshape(shown, (-1, 3)), strokes(*spokes)]
