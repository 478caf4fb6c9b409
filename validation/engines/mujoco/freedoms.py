"""What each joint leaves free, as the slides and turns of MuJoCo: first along axes of a, then about axes of b.

A joint of mbsd3d is a frame A on body a, a frame B on body b, and between them slides s along axes of A and turns:
p_b - p_a = A s, B = A R(turns) rest. All coordinates are zero where B = A rest, at the reference pose if a and b are
built to fit.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from mbsd3d import (
    ConstantVelocity,
    Cylindrical,
    Distance,
    Fixed,
    Joint,
    Parallel,
    Perpendicular,
    Planar,
    PointOnLine,
    PointOnPlane,
    PositionDriver,
    Prismatic,
    Revolute,
    Screw,
    Spherical,
    Universal,
)
from mbsd3d.extend import matched_perpendiculars, perpendiculars

from ..base import NotExpressible

X, Y, Z = range(3)
BALL = None  # turns of a ball: a quaternion
ALONG = 1e-9  # [1] what the axes of hinges that count as one may differ by: rounding
ALIGNED = 0.05  # [rad] below this bend the first and third turn of a constant-velocity joint are one


@dataclass(frozen=True)
class Freedoms:
    """Frames of a joint, world at the reference pose, and what is free between them.

    Attributes
    ----------
    A, B : (3, 3) arrays
        Axes as columns, on a and on b.
    at_a, at_b : (3,) arrays
        Origins [m].
    slides : tuple
        Columns of A.
    turns : (k, 3) array or None
        Axes of the hinges in B at rest, the first next to a; None is a ball.
    angles : function
        Hinge angles from R = A'B.
    rest : (3, 3) array
        A'B where all angles are zero.
    """

    A: np.ndarray
    B: np.ndarray
    at_a: np.ndarray
    at_b: np.ndarray
    slides: tuple
    turns: np.ndarray | None
    angles: Callable[[np.ndarray], tuple]
    rest: np.ndarray

    def turn_axis(self) -> np.ndarray | None:
        """World axis of the only hinge, fixed in a and in b; None if there are none or several."""
        return None if self.turns is None or len(self.turns) != 1 else self.A @ self.rest @ self.turns[0]


def no_angle(R: np.ndarray) -> tuple:
    """Of a joint without hinges."""
    return ()


def about_z(R: np.ndarray) -> tuple:
    """Angle of R = Rz(q)."""
    return (np.arctan2(R[1, 0], R[0, 0]),)


def about_xy(R: np.ndarray) -> tuple:
    """Angles of R = Rx(q1) Ry(q2): its second column is (0, cos q1, sin q1), its first row (cos q2, 0, sin q2)."""
    return np.arctan2(R[2, 1], R[1, 1]), np.arctan2(R[0, 2], R[0, 0])


def about_zyz(R: np.ndarray) -> tuple:
    """Angles of R = Rz(q1) Ry(q2) Rz(q3), q2 in (0, pi): third column (cos q1 sin q2, sin q1 sin q2, cos q2)."""
    bend = np.arctan2(np.hypot(R[0, 2], R[1, 2]), R[2, 2])
    return np.arctan2(R[1, 2], R[0, 2]), bend, np.arctan2(R[2, 1], -R[2, 0])


TABLE: dict[type, tuple] = {  # slides, hinges about axes of B, their angles
    Fixed: ((), (), no_angle),
    Revolute: ((), (Z,), about_z),
    Spherical: ((), BALL, no_angle),
    Universal: ((), (X, Y), about_xy),
    Prismatic: ((Z,), (), no_angle),
    Cylindrical: ((Z,), (Z,), about_z),
    Screw: ((Z,), (Z,), about_z),
    Planar: ((X, Y), (Z,), about_z),
    PointOnLine: ((Z,), BALL, no_angle),
    PointOnPlane: ((X, Y), BALL, no_angle),
    PositionDriver: ((X, Y, Z), BALL, no_angle),  # a point of b and its three places, some of which are driven
    Parallel: ((X, Y, Z), (Z,), about_z),
    Perpendicular: ((X, Y, Z), (X, Y), about_xy),
}


def freedoms_of(joint: Joint, name: str) -> Freedoms:
    """Frames and freedoms of a joint of `TABLE`, of a ConstantVelocity or Distance; errors name it."""
    if type(joint) is ConstantVelocity:
        return shafts(joint, name)
    if type(joint) is Distance:  # see `rods`
        return Freedoms(np.eye(3), np.eye(3), joint.at_a, joint.at_b, (), BALL, no_angle, np.eye(3))
    slides, hinges, angles = TABLE[type(joint)]
    A, B = frames(joint)
    at_a, at_b = getattr(joint, "at", joint.point()), joint.point()
    turns = None if hinges is BALL else np.eye(3)[list(hinges)]
    return Freedoms(A, B, at_a, at_b, slides, turns, angles, np.eye(3))


def frames(joint: Any) -> tuple[np.ndarray, np.ndarray]:
    """Axes of A and B: z is the axis of the joint, x and y of A and B those from which mbsd3d counts its angle."""
    if hasattr(joint, "axis_a"):  # a cross: x is axis_a, y is axis_b
        x, y = joint.axis_a, joint.axis_b
        y_a, x_b = y - x * (x @ y), x - y * (x @ y)
        return right_handed(x, y_a), right_handed(x_b, y)
    axis = getattr(joint, "axis", getattr(joint, "normal", None))
    if axis is None:
        return np.eye(3), np.eye(3)
    axis_b = getattr(joint, "axis_b", axis)
    (x, y), (x_b, y_b) = perpendiculars(axis), matched_perpendiculars(axis, axis_b)
    return np.column_stack([x, y, axis]), np.column_stack([x_b, y_b, axis_b])


def right_handed(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Axes with x and y along the given vectors, which are perpendicular."""
    x, y = x / np.linalg.norm(x), y / np.linalg.norm(y)
    return np.column_stack([x, y, np.cross(x, y)])


def shafts(joint: ConstantVelocity, name: str) -> Freedoms:
    """Hinges about shaft a, the common normal n and shaft b; constant velocity is q3 = -q1, a row of its own.

    B = A Rz(q) Ry(bend) Rz(-q) turns about an axis across z, which is what the row of mbsd3d says: with n of both
    sides, n_a . (z_b x n_b) = (z_a x n_a) . n_b.
    """
    normal = np.cross(joint.axis_a, joint.axis_b)
    bend = np.arctan2(np.linalg.norm(normal), joint.axis_a @ joint.axis_b)
    if bend < ALIGNED:
        raise NotExpressible(
            f"joint '{name}' (ConstantVelocity): its shafts enclose {np.degrees(bend):.3g} degrees; MuJoCo has it as "
            f"three hinges, and above {np.degrees(ALIGNED):.3g} degrees only"
        )
    A, B = (right_handed(np.cross(normal, z), normal) for z in (joint.axis_a, joint.axis_b))
    rest = A.T @ B
    turns = np.array([rest.T[:, Z], np.eye(3)[Y], np.eye(3)[Z]])

    def angles(R: np.ndarray) -> tuple:
        first, second, third = about_zyz(R)
        return first, second - bend, third

    return Freedoms(A, B, joint.at, joint.at_b, (), turns, angles, rest)
