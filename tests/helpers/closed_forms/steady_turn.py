"""A bicycle in a steady turn by Newton and Euler: speed, steer torque and contact forces at any lean and steer.

Axes x forward, y right, z down, as the parameters of the benchmark bicycle have them. Everything turns with Omega about
the vertical and the wheels spin, so that all centres of mass have ``a = Omega z x v`` and all bodies ``H_dot = Omega z
x H``. Velocities are proportional to one scale, these to its square: contact forces, steer torque and the square of the
scale are the solution of one linear system.
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

DOWN = np.array([0.0, 0.0, 1.0])


class SteadyTurn(NamedTuple):
    """What holds a bicycle at a lean and a steer angle."""

    pitch: float
    """Of the rear frame about its lateral axis [rad]."""
    square: float
    """Of the scale of velocities, speed^2 + (w yaw rate)^2 [m^2/s^2]; negative: no such motion."""
    direction: np.ndarray
    """(2,) speed of the rear contact [m/s] and yaw rate [rad/s] at scale one."""
    torque: float
    """On the front part about the steer axis, from the rear frame, > 0 to the right [N m]."""
    rear: np.ndarray
    """(3,) force of the ground on the rear wheel [N]: forward along its track, right, down."""
    front: np.ndarray
    """(3,) on the front wheel in the same axes [N]."""
    residual: float
    """Largest residual of the nine equations, in total weights (times wheel base)."""


def turned(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rotation by an angle about a unit vector."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def heading(axle: np.ndarray) -> np.ndarray:
    """Horizontal direction in which a wheel rolls."""
    across = np.cross(axle, DOWN)
    return across / np.linalg.norm(across)


def contact_arm(axle: np.ndarray, radius: float, crown: float) -> np.ndarray:
    """From the hub to the contact point of a wheel with outer radius and radius of the rim."""
    across = DOWN - axle * axle[2]
    return (radius - crown) * across / np.linalg.norm(across) + crown * DOWN


class Part(NamedTuple):
    """A body at a moment."""

    mass: float
    inertia: np.ndarray  # world axes
    centre: np.ndarray
    spin: np.ndarray  # relative to the turning axes, at scale one


class Pose:
    """Points and rotations of a bicycle on both wheels: rear contact at the origin, rear track along x."""

    def __init__(self, p: Any, lean: float, steer: float, crowns: tuple[float, float]) -> None:
        self.p, self.lean, self.steer, self.crowns = p, lean, steer, crowns
        self.pitch = brentq(self.place, -1.2, 1.2, xtol=1e-15, rtol=1e-15)
        self.place(self.pitch)

    def place(self, pitch: float) -> float:
        """Put all parts; how far the front contact is below the ground."""
        p, on_axis = self.p, np.array([self.p.w + self.p.c, 0.0, 0.0])
        axis = np.array([np.sin(p.lam), 0.0, np.cos(p.lam)])
        self.B = turned(np.array([1.0, 0, 0]), self.lean) @ turned(np.array([0, 1.0, 0]), pitch)
        self.H, self.axis = self.B @ turned(axis, self.steer), self.B @ axis
        self.arm_R = contact_arm(self.B[:, 1], p.rR, self.crowns[0])
        self.arm_F = contact_arm(self.H[:, 1], p.rF, self.crowns[1])
        self.head = -self.arm_R + self.B @ (on_axis + [0.0, 0.0, p.rR])
        self.front = self.front_point([p.w, 0.0, -p.rF]) + self.arm_F
        return self.front[2]

    def front_point(self, point: Any) -> np.ndarray:
        """Where a point of the front part is, given by its place in the upright bicycle."""
        return self.head + self.H @ (np.asarray(point) - [self.p.w + self.p.c, 0.0, 0.0])

    def direction(self) -> np.ndarray:
        """Speed and yaw rate at scale one, such that the front wheel moves along its track."""
        side = np.cross(DOWN, heading(self.H[:, 1]))
        v, yaw = side @ np.cross(DOWN, self.front), -side @ heading(self.B[:, 1])
        return np.array([v, yaw]) / np.hypot(v, self.p.w * yaw)

    def parts(self, v: float, yaw: float) -> list[Part]:
        """Rear wheel, rear frame, front frame, front wheel."""
        p = self.p
        on = lambda R, xx, yy, zz, xz: R @ np.array([[xx, 0, xz], [0, yy, 0], [xz, 0, zz]]) @ R.T  # noqa: E731
        front_speed = (v * heading(self.B[:, 1]) + yaw * np.cross(DOWN, self.front)) @ heading(self.H[:, 1])
        spins = []
        for R, arm, speed in ((self.B, self.arm_R, v), (self.H, self.arm_F, front_speed)):
            axle = R[:, 1]  # no slip: speed along the track + spin x arm = 0
            spins.append(-speed / (np.cross(axle, arm) @ heading(axle)) * axle)
        return [
            Part(p.mR, on(self.B, p.IRxx, p.IRyy, p.IRxx, 0.0), -self.arm_R, spins[0]),
            Part(p.mB, on(self.B, p.IBxx, p.IByy, p.IBzz, p.IBxz),
                 -self.arm_R + self.B @ [p.xB, 0.0, p.zB + p.rR], 0 * DOWN),
            Part(p.mH, on(self.H, p.IHxx, p.IHyy, p.IHzz, p.IHxz), self.front_point([p.xH, 0.0, p.zH]), 0 * DOWN),
            Part(p.mF, on(self.H, p.IFxx, p.IFyy, p.IFxx, 0.0), self.front - self.arm_F, spins[1]),
        ]  # fmt: skip


def balance(x: Pose, v: float, yaw: float) -> tuple[np.ndarray, np.ndarray]:
    """(9, 8) matrix of (rear force, front force, torque, square of the scale), and what gravity asks for.

    Rows: forces; moments about the rear contact; moment of the front part about the steer axis; moments of rear and
    front wheel about their axles.
    """
    rows, right, cross = np.zeros((9, 8)), np.zeros(9), np.cross
    axles = (x.B[:, 1], x.H[:, 1])
    rows[:3, :3] = rows[:3, 3:6] = np.eye(3)
    rows[3:6, 3:6] = cross(x.front, np.eye(3)).T
    rows[6, 3:6], rows[6, 6] = cross(x.axis, x.front - x.head), 1.0
    rows[7, :3], rows[8, 3:6] = cross(axles[0], x.arm_R), cross(axles[1], x.arm_F)
    for k, part in enumerate(x.parts(v, yaw)):
        a = yaw * cross(DOWN, v * heading(axles[0]) + yaw * cross(DOWN, part.centre))
        H_dot = yaw * cross(DOWN, part.inertia @ (yaw * DOWN + part.spin))
        weight, pull = part.mass * x.p.g * DOWN, part.mass * a
        rows[:3, 7] -= pull
        rows[3:6, 7] -= cross(part.centre, pull) + H_dot
        right[:3] -= weight
        right[3:6] -= cross(part.centre, weight)
        if k >= 2:
            rows[6, 7] -= x.axis @ (cross(part.centre - x.head, pull) + H_dot)
            right[6] -= x.axis @ cross(part.centre - x.head, weight)
        if k in (0, 3):
            rows[7 if k == 0 else 8, 7] -= axles[k // 3] @ H_dot
    return rows, right


def steady_turn(p: Any, lean: float, steer: float, crowns: tuple[float, float] = (0.0, 0.0)) -> SteadyTurn:
    """Balance of a bicycle that turns steadily with the given lean and steer angle.

    One of the nine equations for eight unknowns depends on the others, since the motion run backwards is one too.

    ``p``: with the 25 parameters and g of the linear benchmark as attributes; x forward, y right, z down, lengths in m;
    ``lean, steer``: to the right > 0 [rad]; not both zero; ``crowns`` (float, float): radii of the rims of rear and
    front wheel [m]; rR and rF are the outer radii. ValueError if no pitch below 1.2 rad brings both wheels to the
    ground (from the root search).
    """
    x = Pose(p, lean, steer, crowns)
    v, yaw = x.direction()
    rows, right = balance(x, v, yaw)
    total = (p.mR + p.mB + p.mH + p.mF) * p.g
    unit = np.array([total] * 6 + [total * p.w, p.g * p.w])
    scale = np.r_[np.full(3, total), np.full(6, total * p.w)]
    A, b = rows * unit / scale[:, None], right / scale
    solution = np.linalg.lstsq(A, b, rcond=None)[0]
    known = solution * unit
    residual = float(np.abs(A @ solution - b).max())
    return SteadyTurn(x.pitch, known[7], np.array([v, yaw]), known[6], known[:3], known[3:6], residual)
