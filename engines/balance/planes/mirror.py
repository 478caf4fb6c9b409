"""Constraint rows of a spatial system seen from a plane: in-plane, out-of-plane and coupled rows.

A reflection in a plane with normal n keeps the velocity in the plane and the spin about n (the in-plane part of a
twist) and reverses the rest (the out-of-plane part). Rows whose space of allowed twists the reflection maps into itself
let bodies that move in the plane stay in it. Rows are judged at the reference pose and at a pose in which every body is
shifted and turned in its plane, so that nothing holds by chance of the pose.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from mbsd3d import State, System, rotation
from mbsd3d.extend import equations, multiply, perpendiculars

SINGULAR_VALUE_RATIO_MIN = 1e-9  # [1] of the largest singular value of the scaled rows; smaller ones are rounding
IN_PLANE, OUT_OF_PLANE = [0, 1, 5], [2, 3, 4]  # columns of a twist (v, w) in axes (e1, e2, n)


class Pose(NamedTuple):
    """Constraint rows of all joints at a pose."""

    q: np.ndarray  # (n, 7)
    J: np.ndarray  # (rows, n, 2, 3) of (r_dot, w), world


class Rows:
    """Constraint rows of a system by joint, at two poses.

    ``normal`` (3,): unit vector.
    """

    def __init__(self, system: System, normal: np.ndarray) -> None:
        self.system, self.n = system, len(system.bodies)
        self.axes = np.stack([*perpendiculars(normal), normal])
        self.index = {id(body): i for i, body in enumerate(system.bodies)}
        counts = np.cumsum([0] + [sum(row.n_rows for row in joint.primitives) for joint in system.joints])
        self.rows_of = {id(joint): np.arange(*counts[k : k + 2]) for k, joint in enumerate(system.joints)}
        points = np.array([body.centre for body in system.bodies] + [joint.point() for joint in system.joints])
        self.length = max(float(np.ptp(points, axis=0).max()), 1e-3)
        state = system.state()
        self.velocity = state.v.reshape(self.n, 2, 3)
        self.poses = self.pose(state), self.pose(self.shaken(state))

    def pose(self, state: State) -> Pose:
        """Return the constraint rows at a state."""
        return Pose(state.q.reshape(self.n, 7), equations(self.system, state)[2].reshape(-1, self.n, 2, 3))

    def shaken(self, state: State) -> State:
        """Return a state with every body shifted and rotated in its plane by a different amount."""
        q = state.q.reshape(self.n, 7).copy()
        for i, body in enumerate(q):
            shift = 0.1 * self.length * np.array([np.cos(1.0 + 2.0 * i), np.sin(2.0 + 3.0 * i)])
            body[:3] += shift @ self.axes[:2]
            body[3:] = multiply(rotation(self.axes[2], 0.3 + 0.1 * np.sin(1.0 + 5.0 * i)), body[3:])
        return State(state.t, q.ravel(), np.zeros_like(state.v), state.z)

    def height(self, point: np.ndarray) -> float:
        """Return z = point . n [m]."""
        return float(point @ self.axes[2])

    def flat(self, vector: np.ndarray) -> np.ndarray:
        """Return the components of a vector along e1 and e2."""
        return self.axes[:2] @ vector

    def twists(self, joints: Sequence[Any], body: Any, z: float, pose: Pose) -> np.ndarray:
        """Return the twist rows of a body at its reference point moved into the plane, axes e1, e2, n, shape (k, 6)."""
        i = self.index[id(body)]
        rows = np.concatenate([self.rows_of[id(joint)] for joint in joints])
        J = pose.J[rows, i]
        up = (self.height(pose.q[i, :3]) - z) * self.axes[2]
        turn = J[:, 1] + np.cross(up, J[:, 0])
        return np.concatenate([J[:, 0] @ self.axes.T, turn @ self.axes.T / self.length], axis=1)

    def tilt(self, joints: Sequence[Any], bodies: Sequence[Any], z: float) -> float:
        """Return the angle [rad] between the space of allowed twists and its mirror image in the plane, at the worse
        pose.

        With V an orthonormal basis of the rows and P the reflection: sin(2 angle) = |V P (1 - V'V)|; of a slide that is
        tilted out of the plane it is the tilt.
        """
        worst = 0.0
        for pose in self.poses:
            V = row_space(np.concatenate([self.twists(joints, body, z, pose) for body in bodies], axis=1))
            mirrored = V.copy()
            mirrored[:, [6 * k + c for k in range(len(bodies)) for c in OUT_OF_PLANE]] *= -1.0
            off = mirrored - (mirrored @ V.T) @ V
            worst = max(worst, float(np.linalg.norm(off, 2)) if off.size else 0.0)
        return float(np.arcsin(min(worst, 1.0))) / 2

    def wrenches(self, joints: Sequence[Any], body: Any, z: float, pose: Pose) -> np.ndarray:
        """Return orthonormal in-plane wrenches (force, moment about O over the length) of the rows on a body, shape (r,
        3).
        """
        return row_space(self.twists(joints, body, z, pose)[:, IN_PLANE])

    def loose(self, bodies: Sequence[Any], heights: Sequence[float]) -> np.ndarray:
        """Return a basis of the out-of-plane motions of bodies that no row resists, each from its own plane, shape (k,
        bodies, 3).

        Of both poses the one that leaves fewer: at a dead point of the reference pose some are free that are not else.
        """
        found = []
        for pose in self.poses:
            twists = [self.twists(self.system.joints, b, z, pose) for b, z in zip(bodies, heights, strict=True)]
            J = np.concatenate([twist[:, OUT_OF_PLANE] for twist in twists], axis=1)
            found.append(np.linalg.svd(J)[2][len(row_space(J)) :])
        return min(found, key=len).reshape(-1, len(bodies), 3)


def row_space(J: np.ndarray) -> np.ndarray:
    """Return an orthonormal basis of the rows, shape (rank, columns)."""
    if not J.size:
        return np.zeros((0, J.shape[1]))
    scale = np.linalg.norm(J, axis=1, keepdims=True)
    _, s, V = np.linalg.svd(J / np.where(scale > SINGULAR_VALUE_RATIO_MIN, scale, np.inf), full_matrices=False)
    return V[s > SINGULAR_VALUE_RATIO_MIN * max(s[0], SINGULAR_VALUE_RATIO_MIN)]
