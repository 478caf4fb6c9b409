"""Pose and velocities of a bicycle with both wheels rolling on the ground, in closed form.

Lean, steer and the pitch at which the front wheel touches the ground give the configuration. Lean rate, steer rate and
speed give the velocities, with three unknowns: yaw rate, pitch rate, spin of the front wheel. World axes, x forward, y
left, z up; the rear contact is the origin, the rear wheel heads along x.
"""

from collections.abc import Iterable
from typing import NamedTuple, overload

import numpy as np
from scipy.optimize import brentq

from mbsd3d.errors import InputError
from mbsd3d.extend import as_quaternion, cross, number, skew

from ..parameters import Parameters

X, Y, Z = np.eye(3)


class Pose(NamedTuple):
    """Positions (3,) [m] and orientations (3, 3), body -> world, of the parts of a bicycle."""

    frame: np.ndarray
    fork: np.ndarray
    rear: np.ndarray  # hubs
    front: np.ndarray
    head: np.ndarray  # a point of the steer axis
    contact: np.ndarray  # of the front wheel

    @property
    def q(self) -> np.ndarray:
        """Return the coordinates of rear wheel, frame, fork, front wheel; O at the hubs, hub angles zero; shape
        (28,)."""
        frame, fork = as_quaternion(self.frame, "frame"), as_quaternion(self.fork, "fork")
        return np.concatenate([self.rear, frame, self.rear, frame, self.front, fork, self.front, fork])


def hubs(p: Parameters) -> tuple[np.ndarray, np.ndarray]:
    """Return rear and front hub of the upright bicycle [m]."""
    return np.array([0.0, 0.0, p.rR]), np.array([p.w, 0.0, p.rF])


def steer_axis(p: Parameters) -> tuple[np.ndarray, np.ndarray]:
    """Return (point, direction) of the steer axis of the upright bicycle: above the wheels; downward, so right is
    positive.
    """
    ground, axis = np.array([p.w + p.c, 0.0, 0.0]), np.array([np.sin(p.lam), 0.0, -np.cos(p.lam)])
    return ground - 2.0 * max(p.rR, p.rF) * axis, axis


def rotation_about(axis: np.ndarray, angle: complex) -> np.ndarray:
    """Return the rotation by ``angle`` [rad] about a unit vector, shape (3, 3); the angle may be complex."""
    S = skew(axis)
    return np.eye(3) + np.sin(angle) * S + (1.0 - np.cos(angle)) * S @ S


def foot(axle: np.ndarray, radius: float, crown: float) -> np.ndarray:
    """Return the vector from the centre of a wheel down to its contact point [m]: along the disc, then along the
    vertical.
    """
    across = Z - axle[2] * axle
    return -(radius - crown) * across / np.sqrt(across @ across) - crown * Z


def placed(p: Parameters, lean: complex, steer: complex, pitch: float) -> Pose:
    """Return the bicycle on its rear wheel; only at the right pitch is the front contact at z = 0. Angles may be
    complex.
    """
    frame = rotation_about(X, lean) @ rotation_about(Y, pitch)
    (rear, front), (at, axis) = hubs(p), steer_axis(p)
    fork = frame @ rotation_about(axis, steer)
    hub = -foot(frame @ Y, p.rR, p.tR)
    head = hub + frame @ (at - rear)
    centre = head + fork @ (front - at)
    return Pose(frame, fork, hub, centre, head, centre + foot(fork @ Y, p.rF, p.tF))


class Height:
    """Height of the front contact point over the pitch at a lean and a steer angle, as `placed` finds it [m].

    Only vertical components: with the frame's k = R' z = (-cos lean sin pitch, sin lean, cos lean cos pitch) an axle a
    leans by a_z = k . a and its hub is (r - crown) sqrt(1 - a_z^2) + crown above its contact.
    """

    def __init__(self, p: Parameters, lean: float, steer: float) -> None:
        (rear, front), (at, axis) = hubs(p), steer_axis(p)
        turn = rotation_about(axis, steer)
        self.arm = at - rear + turn @ (front - at)  # from hub to hub, frame axes
        self.axle = turn @ Y  # of the front wheel
        self.sine, self.cosine = np.sin(lean), np.cos(lean)
        self.rear = (p.rR - p.tR) * np.sqrt(1.0 - self.sine**2) + p.tR
        self.radius, self.crown = p.rF - p.tF, p.tF

    @overload
    def __call__(self, pitch: float) -> float: ...
    @overload
    def __call__(self, pitch: np.ndarray) -> np.ndarray: ...
    def __call__(self, pitch: float | np.ndarray) -> float | np.ndarray:
        x, y, z = -self.cosine * np.sin(pitch), self.sine, self.cosine * np.cos(pitch)
        up = x * self.arm[0] + y * self.arm[1] + z * self.arm[2]
        tilt = x * self.axle[0] + y * self.axle[1] + z * self.axle[2]
        return self.rear + up - self.radius * np.sqrt(1.0 - tilt**2) - self.crown


def pose_of(p: Parameters, lean: float, steer: float) -> Pose:
    """Return the pose in which both wheels stand on the ground, with the pitch nearest to zero.

    Raises
    ------
    ValueError
        If the bicycle lies on the ground, or there is no such pitch.
    """
    what = f"bicycle '{p.name}'"
    lean, steer = number(lean, f"{what}: lean"), number(steer, f"{what}: steer")
    if not abs(lean) < np.pi / 2:
        raise InputError(f"{what}: lean = {lean:.6g} rad: it lies on the ground; give one between -pi/2 and pi/2")
    if lean == steer == 0.0:
        return placed(p, 0.0, 0.0, 0.0)

    height, grid = Height(p, lean, steer), np.linspace(-1.5, 1.5, 121)
    heights = height(grid)
    below = np.flatnonzero(np.diff(np.signbit(heights)))
    if not below.size:
        raise InputError(
            f"{what}: at lean {lean:.6g} rad and steer {steer:.6g} rad the front wheel cannot stand on the ground "
            f"(at best {np.abs(heights).min():.3g} m off); give a smaller lean or steer"
        )
    k = below[np.argmin(np.abs(grid[below]))]
    return placed(p, lean, steer, brentq(height, grid[k], grid[k + 1], xtol=1e-15, rtol=1e-15))


def velocities_of(p: Parameters, at: Pose, speed: float, lean_rate: float, steer_rate: float) -> np.ndarray:
    """Return v and omega of rear wheel, frame, fork, front wheel (O at the hubs) with which both wheels roll, shape (4,
    6).

    Yaw rate, pitch rate and front spin follow from the velocity of the front hub, which the frame and the front
    contact both determine.

    Raises
    ------
    ValueError
        If no velocities let both wheels roll: the front wheel points sideways.
    """
    what = f"bicycle '{p.name}'"
    given = {"speed": speed, "lean rate": lean_rate, "steer rate": steer_rate}
    speed, lean_rate, steer_rate = (number(x, f"{what}: {key}") for key, x in given.items())
    motion, left = rolling(p, at, speed, lean_rate, steer_rate)
    if left > 1e-9 * (abs(speed) / p.w + abs(lean_rate) + abs(steer_rate)):
        raise InputError(
            f"{what}: no velocities let both wheels roll in this pose, the front wheel points sideways; give another "
            "steer angle, or zero speed, lean rate and steer rate"
        )
    return motion


def rolling(
    p: Parameters, at: Pose, speed: complex, lean_rate: complex, steer_rate: complex
) -> tuple[np.ndarray, float]:
    """Return (velocities (4, 6), slip of the front hub over the wheelbase [1/s]); numbers may be complex.

    The velocity of the front hub over the frame must equal that over the front contact: three linear equations for yaw
    rate, pitch rate and front spin, without a solution where the front wheel points sideways.
    """
    axle_r, axle_f, steer = at.frame @ Y, at.fork @ Y, at.frame @ steer_axis(p)[1]
    to_rear, to_front = at.rear, at.front - at.contact  # from the contact points, which do not slip
    to_head, from_head = at.head - at.rear, at.front - at.head

    def difference(frame: np.ndarray, fork: np.ndarray, rear: np.ndarray, front: np.ndarray) -> np.ndarray:
        """Return the velocity of the front hub over the frame less that over the contact [m/s]."""
        return cross(rear, to_rear) + cross(frame, to_head) + cross(fork, from_head) - cross(front, to_front)

    frame, rear = lean_rate * X, lean_rate * X + speed / p.rR * axle_r
    fork = frame + steer_rate * steer
    rest = difference(frame, fork, rear, fork)
    by_yaw, by_pitch = difference(Z, Z, Z, Z), difference(axle_r, axle_r, axle_r, axle_r)
    yaw_rate, pitch_rate, spin = combination(by_yaw, by_pitch, -cross(axle_f, to_front), -rest)
    turning = yaw_rate * Z + pitch_rate * axle_r
    frame, fork, rear, front = frame + turning, fork + turning, rear + turning, fork + turning + spin * axle_f
    v_rear, v_front = cross(rear, to_rear), cross(front, to_front)
    motion = np.array([[*v_rear, *rear], [*v_rear, *frame], [*v_front, *fork], [*v_front, *front]])
    return motion, float(np.abs(difference(frame, fork, rear, front)).max()) / p.w


def combination(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> Iterable[complex]:
    """Solve x a + y b + z c = d for x, y, z by Cramer's rule; by least squares and least size where a, b, c lie in a
    plane.
    """
    bc = cross(b, c)
    volume, box = a @ bc, np.prod([np.linalg.norm(x) for x in (a, b, c)])
    if abs(volume) <= 1e-12 * box:
        return np.linalg.lstsq(np.array([a, b, c]).T, d, rcond=1e-12)[0]
    return d @ bc / volume, a @ cross(d, c) / volume, a @ cross(b, d) / volume
