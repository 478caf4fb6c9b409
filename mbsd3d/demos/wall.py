"""The wall of shame: what is lost with each term one may forget, in numbers."""

from types import MappingProxyType
from typing import Any

import numpy as np

from mbsd3d import GROUND, Body, Revolute, Solution, Spherical, State, System, simulate
from mbsd3d.model import Switches
from mbsd3d.rotations import H

from . import crank
from .base import Demo, Outcome, Row
from .drawing import COLOURS, GREY, every, legend_below, new_figure, theory_dots

TURN = 2 * np.pi  # rad/s: one revolution per second
MOMENTS, SPIN = np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.0, 2.0])  # of the free body [kg m^2, rad/s]
ARM = 0.5  # m, centre of mass of the flywheel from its hinge
GAP = 1e-3  # m, opened on purpose
A, B = 20.0, 100.0  # Baumgarte's factors [1/s, 1/s^2]: both roots at -10/s
STEPS = 200  # of the quaternion's integration


def free_body() -> System:
    """A body without forces, turning about an axis that is no principal one."""
    return System([Body("body", 1.0, MOMENTS, omega=SPIN)], gravity=(0, 0, 0))


def flywheel() -> System:
    """A body on a hinge, its centre of mass off the axis, at one revolution per second; no gravity."""
    wheel = Body("wheel", 1.0, (0.1, 0.1, 0.1), position=(ARM, 0, 0), omega=(0, 0, TURN))
    return System([wheel], [Revolute(GROUND, wheel, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")], gravity=(0, 0, 0))


def top() -> System:
    """A fast top whose reference point is its pivot: every term of the equations is at work."""
    body = Body("top", 15.0, (0.234375, 0.46875, 0.234375), com=(0, 1, 0), omega=(0, 150, -4.61538))
    return System([body], [Spherical(GROUND, body, at=(0, 0, 0), name="pivot")])


def lost_momentum() -> float:
    """|L| turned by without w x I w in half a revolution about the constant w: twice its part across w [kg m^2/s]."""
    L = MOMENTS * SPIN
    return float(2 * np.linalg.norm(L - (L @ SPIN) / (SPIN @ SPIN) * SPIN))


def drifted(t: np.ndarray) -> np.ndarray:
    """Gap of the flywheel's hinge without -J_dot v [m]: the centre of mass flies straight on while the wheel turns."""
    angle = TURN * t
    return ARM * np.hypot(1 - np.cos(angle), angle - np.sin(angle))


def closing(t: np.ndarray) -> np.ndarray:
    """Gap under Baumgarte's c_ddot + 2 (10/s) c_dot + (10/s)^2 c = 0, opened by GAP at rest [m]."""
    return GAP * (1 + 0.5 * A * t) * np.exp(-0.5 * A * t)


def opened(stabilisation: str) -> Solution:
    """0.5 s of the flywheel with its hinge a millimetre apart at the start."""
    system = flywheel()
    start = system.state()
    start = State(start.t, start.q + GAP * np.eye(7)[0], start.v + TURN * GAP * np.eye(6)[1], start.z)
    return simulate(
        system, 0.5, state=start, rtol=1e-12, output=51, stabilisation=stabilisation, baumgarte=(A, B)
    )


def hinge_gap(solution: Solution) -> np.ndarray:
    """Distance of the wheel's hinge point from the axis [m]."""
    return np.linalg.norm(solution.point("wheel", (-ARM, 0, 0)), axis=1)


def ghost(h_dot: bool) -> np.ndarray:
    """(STEPS + 1, 4) quaternion from e_ddot = (H w_dot + H_dot w) / 2 by RK4, constant w, one revolution in 1 s."""
    w = np.array([0.0, 0.0, TURN])

    def rate(y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[4:], 0.5 * H(y[4:]) @ w if h_dot else np.zeros(4)])

    e = np.array([1.0, 0.0, 0.0, 0.0])
    y, dt, path = np.concatenate([e, 0.5 * H(e) @ w]), 1.0 / STEPS, []
    for _ in range(STEPS):
        path.append(y[:4])
        k1 = rate(y)
        k2 = rate(y + 0.5 * dt * k1)
        k3 = rate(y + 0.5 * dt * k2)
        y = y + dt / 6 * (k1 + 2 * k2 + 2 * k3 + rate(y + dt * k3))
    return np.array([*path, y[:4]])


def angles(e: np.ndarray) -> np.ndarray:
    """Rotation angles of quaternions [degrees], not past 360."""
    return np.degrees(2 * np.arctan2(np.linalg.norm(e[:, 1:], axis=1), e[:, 0]))
