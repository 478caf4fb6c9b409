"""Closed forms of the reference cases: `validation.theory` with the masses and points of a model.

Every law takes a `Run` and returns quantity -> (computed, exact); nothing of the computed motion enters the exact side.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from mbsd3d import Revolute, linearize
from mbsd3d.errors import InputError
from validation import theory
from validation.suite.trials.trial import Run

Pairs = dict[str, tuple[Any, Any]]


def turned(axis: np.ndarray, angle: Any, vector: np.ndarray) -> np.ndarray:
    """Return a vector rotated about a unit axis by angles (n,): Rodrigues; shape (n, 3)."""
    along, side = axis * (axis @ vector), np.cross(axis, vector)
    angle = np.asarray(angle, dtype=float)[:, None]
    return along + np.cos(angle) * (vector - along) + np.sin(angle) * side


def swing(made: Run) -> tuple[Revolute, float, float, float]:
    """Return (hinge, w0, angle from the lowest position, rate) at the start of one body that swings about a fixed
    axis."""
    system = made.system
    body, hinge = system.bodies[0], next(joint for joint in system.joints if isinstance(joint, Revolute))
    u, g, R = hinge.axis, system.gravity, body_rotation(body)
    down, arm = g - u * (u @ g), R @ body.com + body.position - hinge.at
    arm = arm - u * (u @ arm)
    inertia = u @ R @ body.inertia @ R.T @ u + body.mass * arm @ arm
    frequency = theory.pendulum_frequency(inertia, body.mass, float(np.linalg.norm(arm)), float(np.linalg.norm(down)))
    return hinge, frequency, np.arctan2(u @ np.cross(down, arm), down @ arm), float(u @ body.omega)


def body_rotation(body: Any) -> np.ndarray:
    """Return the rotation at the reference pose by the theory's own formula, shape (3, 3)."""
    return np.asarray(theory.rotation_matrix(body.orientation), dtype=float)


def pendulum(made: Run) -> Pairs:
    """Compare a physical pendulum of any amplitude about any axis with elliptic functions."""
    hinge, frequency, angle, rate = swing(made)
    phi, phi_dot = theory.pendulum_motion(made.motion.t, frequency, angle, rate)
    body = made.system.bodies[0]
    arm = body.position + body_rotation(body) @ body.com - hinge.at
    return {
        "centre of mass": (made.motion.com(body), hinge.at + turned(hinge.axis, phi - angle, arm)),
        "rate": (made.motion.omega(body) @ hinge.axis, phi_dot),
    }


def small(made: Run, frequency: float) -> Pairs:
    """Compare the frequency of small oscillations of a hanging body."""
    return {"frequency": (np.abs(linearize(made.system).eigenvalues.imag).max(), frequency)}


def rods_frequency(n: int) -> float:
    """Return the frequency [rad/s] of n hanging four-bars: n + 1 rods of 1 kg, 1 m turn about their feet, n translate
    on a circle.
    """
    return theory.pendulum_frequency((n + 1) / 3 + n, (n + 1) / 2 + n, 1.0)


def four_bars(made: Run) -> Pairs:
    """Compare four-bars over the top, from upright at -1 rad/s, through the poses where all rods lie on one line."""
    n = sum(body.name.startswith("coupler") for body in made.system.bodies)
    phi, phi_dot = theory.pendulum_motion(made.motion.t, rods_frequency(n), np.pi, -1.0)
    half = np.stack([0.5 * np.sin(phi), -0.5 * np.cos(phi), np.zeros_like(phi)], axis=1)
    last = made.system.part(f"rod{n}")
    return {
        "centre of mass of the last rod": (made.motion.com(last), half + (n, 0, 0)),
        "rate of the last rod": (made.motion.omega(last)[:, 2], phi_dot),
    }


def arm_and_slider(made: Run) -> Pairs:
    """Compare r = r0 cosh(w t), and the Coriolis torque of the motor."""
    arm, slider = made.system.bodies
    if arm.omega is None:
        raise InputError("the arm has no angular velocity; give its omega")
    rate = arm.omega[2]
    radius, speed = theory.arm_slider(made.motion.t, rate, 0.1)
    torque = theory.arm_slider_torque(slider.mass, rate, radius, speed)
    return {
        "distance from the axis": (np.linalg.norm(made.motion.com(slider), axis=1), radius),
        "motor torque": (made.motion.effort("M"), torque),
    }


def cardan(made: Run) -> Pairs:
    """Compare a Cardan joint at 45 degrees: uneven rate, and the torque for a constant input rate."""
    rate, bend, inertia = 10.0, np.pi / 4, 0.08  # rad/s, rad, kg m^2 of the output about its axis
    angle, axis = rate * made.motion.t, made.system.part("R2", "joints").axis
    return {
        "output rate": (made.motion.omega("out") @ axis, theory.cardan_rate(angle, bend, rate)),
        "motor torque": (made.motion.effort("M"), theory.cardan_motor_torque(angle, bend, rate, inertia)),
    }


def free_body(made: Run) -> Pairs:
    """Compare a torque-free body with elliptic functions, attitude included."""
    body = made.system.bodies[0]
    start = body_rotation(body).T @ body.omega
    exact = theory.free_body(made.motion.t, np.diag(body.inertia), start, body.orientation)
    return {
        "angular velocity": (made.motion.omega_body(body), exact.omega_body),
        "rotation": (made.motion.rotation(body), exact.rotation),
    }


def heavy_top(made: Run) -> Pairs:
    """Compare a body on a ball joint at the origin under its weight with Taylor series in extended precision."""
    body, mass = made.system.bodies[0], made.system.bodies[0].mass
    R = body_rotation(body)
    arm = body.com + R.T @ body.position  # from the pivot, body axes
    about = body.inertia + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    weight = -mass * made.system.gravity[2]
    exact = theory.spinning_body(made.motion.t, about, R.T @ body.omega, body.orientation, weight * arm)
    return {
        "angular velocity": (made.motion.omega_body(body), exact.omega_body),
        "centre of mass": (made.motion.com(body), np.asarray(exact.rotation, dtype=float) @ arm),
    }


def circling(body: str, rate: float, made: Run) -> Pairs:
    """Compare the centre of mass with a circle about the vertical through the origin at a constant rate."""
    part = made.system.part(body)
    start = part.position + body_rotation(part) @ part.com
    exact = turned(np.array([0.0, 0.0, 1.0]), rate * made.motion.t, start)
    return {"centre of mass": (made.motion.com(body), exact)}


def slow_top(made: Run) -> Pairs:
    """Compare regular precession at the slow rate; 150 rad/s about the axis, which leans by 60 degrees."""
    mass, length, transverse, axial = 2.0, 0.3, 0.02, 0.015
    slow, _ = theory.steady_precession(transverse + mass * length**2, axial, 150.0, mass * 9.81 * length, np.pi / 3)
    return circling("top", slow, made)


def gimbal(made: Run) -> Pairs:
    """Compare the steady precession of a wheel on a level axle: W = m g l / (C w)."""
    mass, length, axial = 3.0, 0.2, 0.09375
    slow, _ = theory.steady_precession(axial, axial, 100.0, mass * 9.81 * length, np.pi / 2)
    return circling("wheel", slow, made)


def rolling(made: Run) -> Pairs:
    """Compare a leaning disc on a circle of ten times its radius, clockwise from above."""
    disc, radius = made.system.bodies[0], 0.05
    transverse, axial = np.diag(disc.inertia)[[0, 1]]
    exact = theory.rolling_circle(disc.mass, radius, transverse, axial, 10 * radius, np.radians(5.0))
    return circling("disc", -exact.precession, made)


CLOSED_FORMS: dict[str, Callable[[Run], Pairs]] = {
    "cardan_single_45": cardan,
    "coriolis_slider": arm_and_slider,
    "door_two_hinges": pendulum,
    "eig_fourbar2_hanging": lambda made: small(made, rods_frequency(2)),
    "eig_hanging_pendulum": lambda made: small(made, swing(made)[1]),
    "free_dzhanibekov": free_body,
    "gyro_gimbal_wheel": gimbal,
    "heavy_top_fast": heavy_top,
    "iftomm_A01_pendulum": pendulum,
    "iftomm_A02_fourbar_N2": four_bars,
    "rolling_disc_circular": rolling,
    "top_slow_precession": slow_top,
}
"""Case -> its law."""
