"""Flexible head tube: a hinge between frame and steer axis, at right angles to it, with spring and damper."""

from collections.abc import Sequence

import numpy as np

from mbsd3d import Body, Revolute, TorsionSpring, shapes
from mbsd3d.extend import cross

from ..parameters import Parameters
from .kinematics import Pose, steer_axis

HEAD_TUBE_LENGTH = 0.12  # [m] of the head tube in drawings


def head_of(
    p: Parameters, bodies: Sequence[Body], stiffness: float, damping: float
) -> tuple[Body, Revolute, Revolute, TorsionSpring]:  # fmt: skip
    """Return (body "head" without mass, joint "steer" on it, joint "head twist" on the frame, spring "head spring").

    The axis of twist lies in the plane of the frame, goes through the head and points ahead: the frame gives about it
    as its tubes twist, and the front wheel moves sideways.
    """
    (at, axis), (_, frame, fork, _) = steer_axis(p), bodies
    ahead = np.cross((0.0, 1.0, 0.0), -axis)
    tube = shapes.Lines([tuple(-0.5 * HEAD_TUBE_LENGTH * axis), tuple(0.5 * HEAD_TUBE_LENGTH * axis)])
    head = Body("head", 0.0, (0, 0, 0), position=at, shape=tube)
    twist = Revolute(frame, head, at=at, axis=ahead, name="head twist")
    spring = TorsionSpring(twist, stiffness=stiffness, damping=damping, name="head spring")
    return head, Revolute(head, fork, at=at, axis=axis, name="steer"), twist, spring


def head_state(place: Pose, q: np.ndarray, motion: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (q, v) of the bicycle and of its head, which moves with the frame (row 1 of q and ``motion`` (4, 6))."""
    v, omega = motion[1, :3], motion[1, 3:]
    there = v + cross(omega, place.head - place.rear)
    return np.concatenate([q, place.head, q[10:14]]), np.concatenate([motion.ravel(), there, omega])
