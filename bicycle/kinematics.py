"""Where the wheels stand and how they roll: pose and velocities of the bicycle in closed form.

The configuration is given by lean, steer and the pitch at which the front wheel touches the ground; the velocities by
lean rate, steer rate and speed, and three unknowns: yaw rate, pitch rate, spin of the front wheel. World axes, x
forward, y left, z up; the rear contact is the origin, the rear wheel heads along x.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from mbsd3d.parts import number
from mbsd3d.rotations import as_quaternion, skew

from .parameters import Parameters

X, Y, Z = np.eye(3)


class Pose(NamedTuple):
    """Places (3,) [m] and orientations (3, 3), body -> world."""

    frame: np.ndarray
    fork: np.ndarray
    rear: np.ndarray  # hubs
    front: np.ndarray
    head: np.ndarray  # a point of the steer axis
    contact: np.ndarray  # of the front wheel

    @property
    def q(self) -> np.ndarray:
        """(28,) coordinates of rear wheel, frame, fork, front wheel; O at the hubs, hub angles zero."""
        frame, fork = as_quaternion(self.frame, "frame"), as_quaternion(self.fork, "fork")
        return np.concatenate([self.rear, frame, self.rear, frame, self.front, fork, self.front, fork])


def hubs(p: Parameters) -> tuple[np.ndarray, np.ndarray]:
    """Rear and front hub of the upright bicycle."""
    return np.array([0.0, 0.0, p.rR]), np.array([p.w, 0.0, p.rF])


def steer_axis(p: Parameters) -> tuple[np.ndarray, np.ndarray]:
    """(point, direction) of the upright bicycle: where the axis meets the ground; downward, so right is positive."""
    return np.array([p.w + p.c, 0.0, 0.0]), np.array([np.sin(p.lam), 0.0, -np.cos(p.lam)])


def turn(axis: np.ndarray, angle: float) -> np.ndarray:
    """(3, 3) rotation by ``angle`` [rad] about a unit vector."""
    cross = skew(axis)
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def foot(axle: np.ndarray, radius: float, crown: float) -> np.ndarray:
    """From the centre of a wheel down to its contact point: along the disc, then along the vertical."""
    across = Z - axle[2] * axle
    return -(radius - crown) * across / np.sqrt(across @ across) - crown * Z


def placed(p: Parameters, lean: float, steer: float, pitch: float) -> Pose:
    """The bicycle on its rear wheel; the front contact is at z = 0 for one pitch only."""
    frame = turn(X, lean) @ turn(Y, pitch)
    (rear, front), (at, axis) = hubs(p), steer_axis(p)
    fork = frame @ turn(axis, steer)
    hub = -foot(frame @ Y, p.rR, p.tR)
    head = hub + frame @ (at - rear)
    centre = head + fork @ (front - at)
    return Pose(frame, fork, hub, centre, head, centre + foot(fork @ Y, p.rF, p.tF))


def pose_of(p: Parameters, lean: float, steer: float) -> Pose:
    """The pose in which both wheels stand on the ground, with the pitch nearest to zero.

    Raises
    ------
    ValueError
        If the bicycle lies on the ground, or there is no such pitch.
    """
    what = f"bicycle '{p.name}'"
    lean, steer = number(lean, f"{what}: lean"), number(steer, f"{what}: steer")
    if not abs(lean) < np.pi / 2:
        raise ValueError(f"{what}: lean = {lean:.6g} rad: it lies on the ground; give one between -pi/2 and pi/2")
    if lean == steer == 0.0:
        return placed(p, 0.0, 0.0, 0.0)

    def height(pitch: float) -> float:
        return placed(p, lean, steer, pitch).contact[2]

    grid = np.linspace(-1.5, 1.5, 121)
    heights = np.array([height(pitch) for pitch in grid])
    below = np.flatnonzero(np.diff(np.signbit(heights)))
    if not below.size:
        raise ValueError(
            f"{what}: at lean {lean:.6g} rad and steer {steer:.6g} rad the front wheel cannot stand on the ground "
            f"(at best {np.abs(heights).min():.3g} m off); give a smaller lean or steer"
        )
    k = below[np.argmin(np.abs(grid[below]))]
    return placed(p, lean, steer, brentq(height, grid[k], grid[k + 1], xtol=1e-15, rtol=1e-15))


def velocities_of(p: Parameters, at: Pose, speed: float, lean_rate: float, steer_rate: float) -> np.ndarray:
    """(4, 6) v and omega of rear wheel, frame, fork, front wheel (O at the hubs) with which both wheels roll.

    Yaw rate, pitch rate and front spin follow from the velocity of the front hub, which the frame and the front
    contact both determine.

    Raises
    ------
    ValueError
        If no velocities let both wheels roll: the front wheel stands across the way.
    """
    what = f"bicycle '{p.name}'"
    given = {"speed": speed, "lean rate": lean_rate, "steer rate": steer_rate}
    speed, lean_rate, steer_rate = (number(x, f"{what}: {key}") for key, x in given.items())

    def motion(yaw_rate: float, pitch_rate: float, spin: float, on: float) -> tuple[np.ndarray, np.ndarray]:
        """((4, 6) velocities, how much those of the front hub differ); linear in all four."""
        axle_r, axle_f, steer = at.frame @ Y, at.fork @ Y, at.frame @ steer_axis(p)[1]
        frame = yaw_rate * Z + on * lean_rate * X + pitch_rate * axle_r
        fork = frame + on * steer_rate * steer
        rear, front = frame + on * speed / p.rR * axle_r, fork + spin * axle_f
        v_rear, v_front = np.cross(rear, at.rear), np.cross(front, at.front - at.contact)
        carried = v_rear + np.cross(frame, at.head - at.rear) + np.cross(fork, at.front - at.head)
        return np.array([[*v_rear, *rear], [*v_rear, *frame], [*v_front, *fork], [*v_front, *front]]), carried - v_front

    A = np.array([motion(*unit, 0.0)[1] for unit in np.eye(3)]).T
    A, rest = A / [p.w, p.w, p.rF], motion(0.0, 0.0, 0.0, 1.0)[1]
    if np.linalg.cond(A) > 1e12:
        if np.abs(rest).max() == 0.0:
            return np.zeros((4, 6))
        raise ValueError(
            f"{what}: no velocities let both wheels roll in this pose, the front wheel stands across; give another "
            "steer angle, or speed, lean rate and steer rate zero"
        )
    return motion(*(-np.linalg.solve(A, rest) / [p.w, p.w, p.rF]), 1.0)[0]
