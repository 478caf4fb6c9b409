"""Small motions about equilibria and steady motions: frequencies and growth rates that tests of `linearize` know."""

from typing import Any

import numpy as np

from validation.theory.whipple_lagrange import accelerations, state

GRAVITY = 9.81  # [m/s^2]
DIFFERENCE_STEP = 2e-3  # [rad, rad/s]: truncation of order eight and rounding are both near 1e-13
DIFFERENCE_WEIGHTS = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}


def upright_disc(
    mass: float, radius: float, transverse: float, axial: float, speed: float, gravity: float = GRAVITY
) -> np.ndarray:
    """Matrix of (lean, lean rate, vertical angular velocity w_z) of a disc that rolls straight at a speed.

    With heading rate ``W = w_z - n lean`` (lean to the right lifts the axis, spin ``n = speed / r``):
    ``(A + m r^2) lean'' = m g r lean + (C + m r^2) n W`` and ``A W' = -C n lean'``; stable for
    ``speed^2 > A m g r^3 / (C (C + m r^2))``, which is g r / 3 for a thin one.

    ``mass, radius``: [kg], r [m]; ``transverse, axial``: A (a diameter) and C about the centre of mass [kg m^2];
    ``speed``: [m/s]; ``gravity``: [m/s^2]. Returns (3, 3): its eigenvalues are 0 and a pair.
    """
    spin, about_contact = speed / radius, transverse + mass * radius**2
    pull, turn = mass * gravity * radius / about_contact, (axial + mass * radius**2) * spin / about_contact
    return np.array([[0, 1, 0], [pull - turn * spin, 0, turn], [0, spin - axial * spin / transverse, 0]])


def circling_disc_rate(
    mass: float, radius: float, transverse: float, axial: float, lean: float, precession: float, spin: float,
    gravity: float = GRAVITY,
) -> float:  # fmt: skip
    """Square of the frequency of a disc about steady rolling on a circle; its angle from the ground is h = pi/2 - lean.

    Linear in the deviation of h of ``(A + m r^2) h'' = A W^2 sin h cos h - (C + m r^2) W n sin h - m g r cos h``, the
    integrals ``(C + m r^2) n' = m r^2 W sin(h) h'`` and ``A sin(h) W' = (C n - 2 A W cos h) h'`` eliminated.

    ``mass, radius, transverse, axial, gravity``: as in `upright_disc`; ``lean``: of the disc plane from the vertical,
    inwards [rad]; ``precession, spin``: W about the vertical; n, the angular velocity along the disc axis that points
    up where h < pi/2 [rad/s]. Returns [1/s^2], negative where the motion is unstable.
    """
    h = 0.5 * np.pi - lean
    s, c, W, n = np.sin(h), np.cos(h), precession, spin
    about, rolling = transverse + mass * radius**2, axial + mass * radius**2
    dn = mass * radius**2 * W * s / rolling
    dW = (axial * n - 2 * transverse * W * c) / (transverse * s)
    steady = transverse * W**2 * s * c - rolling * W * n * s - mass * gravity * radius * c
    if abs(steady) > 1e-9 * mass * gravity * radius:
        raise ValueError(f"precession {W}, spin {n}: no steady motion at this lean, {steady} N m are left over")
    change = transverse * (2 * W * dW * s * c + W**2 * (c**2 - s**2)) + mass * gravity * radius * s
    return -(change - rolling * (dW * n * s + W * dn * s + W * n * c)) / about


def nutation_rate(
    transverse: float, axial: float, spin: float, weight_moment: float, tilt: float, precession: float
) -> float:
    """Square of the frequency of small nutation about the steady precession W of a symmetric top.

    ``A tilt'' = A W^2 sin cos - C w3 W sin + m g l sin`` with both momenta constant, so that
    ``dW/dtilt = (C w3 - 2 A W cos) / (A sin)``.

    ``transverse, axial, spin, weight_moment, tilt``: as in `steady_precession`; ``precession``: W [rad/s]. Returns
    [1/s^2].
    """
    s, c, W = np.sin(tilt), np.cos(tilt), precession
    dW = (axial * spin - 2 * transverse * W * c) / (transverse * s)
    change = transverse * (2 * W * dW * s * c + W**2 * (c**2 - s**2)) - axial * spin * (dW * s + W * c)
    return -(change + weight_moment * c) / transverse


def sleigh_rate(mass: float, inertia: float, ahead: float, speed: float) -> float:
    """Growth rate of the yaw rate of Chaplygin's sleigh in straight motion, ``-m a v / (I + m a^2)``.

    ``mass, inertia``: [kg]; about the vertical through the centre of mass [kg m^2]; ``ahead``: a, the centre of mass
    ahead of the blade [m]; what it is to the side does not matter; ``speed``: v [m/s]. Returns [1/s].
    """
    return -mass * ahead * speed / (inertia + mass * ahead**2)


def whirling_pendulum_rate(
    mass: float, inertia: tuple[float, float, float], arm: float, offset: float, turn: float, angle: float,
    gravity: float = GRAVITY,
) -> float:  # fmt: skip
    """Square of the frequency of a pendulum whose hinge is carried round a vertical shaft at a constant rate.

    ``(I1 + m l^2) p'' = W^2 I_v'(p) / 2 - m g l sin p``, ``I_v = m (e + l sin p)^2 + I2 sin^2 p + I3 cos^2 p``.

    ``mass``: [kg]; ``inertia`` (I1, I2, I3): about the centre of mass: the hinge axis (tangential), across, along the
    pendulum [kg m^2]; ``arm, offset``: l from the hinge to the centre of mass; e from the shaft to the hinge [m];
    ``turn``: W [rad/s]; ``angle``: p, outwards from the vertical [rad]; ``gravity``: [m/s^2]. Returns [1/s^2]; for the
    angle of relative equilibrium, where ``p'' = 0``.
    """
    i1, i2, i3 = inertia
    s, c = np.sin(angle), np.cos(angle)
    curvature = 2 * mass * arm * (arm * c**2 - (offset + arm * s) * s) + 2 * (i2 - i3) * (c**2 - s**2)
    return (mass * gravity * arm * c - 0.5 * turn**2 * curvature) / (i1 + mass * arm**2)


def bicycle_matrix(p: Any, speed: float) -> np.ndarray:
    """(4, 4) A of x' = A x, x = (lean, steer, lean rate, steer rate), by differences of order eight."""

    def swing(x: np.ndarray) -> np.ndarray:
        lean, steer, *rates = x
        return accelerations(p, *state(p, lean, steer, np.array([*rates, speed])))[[3, 5]]

    columns = [
        sum(
            weight * (swing(k * DIFFERENCE_STEP * unit) - swing(-k * DIFFERENCE_STEP * unit)) / DIFFERENCE_STEP
            for k, weight in DIFFERENCE_WEIGHTS.items()
        )
        for unit in np.eye(4)
    ]
    return np.vstack([np.eye(4)[2:], np.array(columns).T])
