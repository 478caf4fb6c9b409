"""Second formulation of the tyre: contact by an angle on the circle of tube centres, brush by the bristles of its
patch.

Nothing of `mbsd3d` is used. The lowest point of the torus is that of a circle in the plane of the wheel, the force of
the brush an integral over the patch, so that no formula is the same as in the element. And a free wheel on it, by
Newton and Euler.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import leggauss

GAUSS_NODES, GAUSS_WEIGHTS = leggauss(40)
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Rubber:
    """Tyre with the parameters of `mbsd3d.Tyre`; SI units. ``mu`` None: no limit."""

    radius: float
    crown: float
    stiffness: float
    damping: float
    cornering: float
    longitudinal: float
    camber: float
    relaxation: float
    relaxation_x: float
    mu: float | None
    trail: float
    twisting: float
    rolling_resistance: float
    nominal_load: float
    grip_sensitivity: float
    stiffness_sensitivity: float
    standing_damping: float = 0.0
    standing_speed: float = 0.1
    camber_lag: bool = True


@dataclass(frozen=True)
class Wheel:
    """Mass, moments about the axle y and a diameter; SI units."""

    mass: float
    axial: float
    diametral: float
    tyre: Rubber


def rotation(e: np.ndarray) -> np.ndarray:
    """Return the rotation of a quaternion of any length, scalar first, shape (3, 3)."""
    e = e / np.linalg.norm(e)
    v, S = e[1:], np.cross(np.eye(3), e[1:])
    return np.eye(3) + 2.0 * e[0] * S + 2.0 * (np.outer(v, v) - (v @ v) * np.eye(3))


def lowest(w: Rubber, axle: np.ndarray) -> np.ndarray:
    """Return the vector from the hub to the lowest point of the circle of tube centres, by its angle on it [m]."""
    a = np.cross(axle, np.eye(3)[np.argmin(np.abs(axle))])
    a /= np.linalg.norm(a)
    b = np.cross(axle, a)
    angle = np.arctan2(-b[2], -a[2])
    return (w.radius - w.crown) * (a * np.cos(angle) + b * np.sin(angle))


def patch(slip: float) -> tuple[float, float]:
    """Return (force over grip, trail over that at rest) of bristles under a parabolic pressure, for C sigma/mu = slip.

    Along x = -1 ... 1 a bristle is bent by (1 - x) slip/2 and holds up to 3 (1 - x^2)/4; units: mu N, half the patch.
    """
    edge = min(2.0 * slip / 3.0 - 1.0, 1.0)  # where the bent bristles meet the parabola: they stick ahead of it
    bent = 0.5 * (1.0 - edge) * GAUSS_NODES + 0.5 * (1.0 + edge)  # x of the nodes of the sticking part
    stick = 0.5 * (1.0 - edge) * GAUSS_WEIGHTS * 0.5 * slip * (1.0 - bent)
    slid = 0.5 * (edge + 1.0) * GAUSS_NODES + 0.5 * (edge - 1.0)
    slide = 0.5 * (edge + 1.0) * GAUSS_WEIGHTS * 0.75 * (1.0 - slid**2)
    force, moment = stick.sum() + slide.sum(), -(stick @ bent) - slide @ slid
    return float(force), float(3.0 * moment / force) if force > 0.0 else 1.0


def pull(w: Rubber, mu: float | None, bent: np.ndarray) -> tuple[np.ndarray, float]:
    """Return (force over load, trail) of deflections times stiffness, which is the force of the linear tyre."""
    size = float(np.linalg.norm(bent))
    if mu is None or size == 0.0:
        return bent, w.trail
    q = size / mu
    share, trail = patch(min(q / (1.0 - q / 3.0), 3.0) if q < 1.5 else 3.0)
    return mu * share * bent / size, w.trail * trail


def contact_point(w: Rubber, hub: np.ndarray, axle: np.ndarray) -> np.ndarray:
    """Return the vector from the hub to the contact point: below the lowest point of the circle of tube centres [m]."""
    T = lowest(w, axle)
    return np.array([T[0], T[1], -hub[2]])


def tread(
    w: Rubber, mu: float | None, hub: np.ndarray, axle: np.ndarray, v: np.ndarray, omega: np.ndarray, z: np.ndarray,
    turning: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """Return (force on the wheel, its moment about the hub, rates of the deflections) on the ground z = 0, world axes.

    ``mu`` is the grip now, ``v`` the velocity of the hub less that of the ground's matter at the contact point, and
    ``turning`` the angular velocity of the wheel less that of the ground; None: ``omega``, the ground rests.
    """
    T, P = lowest(w, axle), contact_point(w, hub, axle)
    turning = omega if turning is None else turning
    ahead = np.cross(axle, UP)
    ahead /= np.linalg.norm(ahead)
    left = np.cross(UP, ahead)
    slip, rim = v + np.cross(omega, P), v + np.cross(omega, T)
    sunk = w.crown - (hub[2] + T[2])
    N = max(w.stiffness * sunk - w.damping * rim[2], 0.0) if sunk > 0.0 else 0.0
    if mu is not None:
        mu = max(mu, 0.01) * max(1.0 - w.grip_sensitivity * (N / w.nominal_load - 1.0), 0.1)
    soft = max(1.0 - w.stiffness_sensitivity * (N / w.nominal_load - 1.0), 0.1)
    C, lean = soft * np.array([w.longitudinal, w.cornering]), axle[2]
    V, s = abs(v @ ahead), np.array([slip @ ahead, slip @ left])
    bound = 0.0 if mu is None else np.linalg.norm(C * s) / (3.0 * mu)
    lag = np.array([0.0, V * w.camber / w.cornering * lean]) * w.camber_lag
    z_dot = (-s - lag - (V + bound) * z) / np.array([w.relaxation_x, w.relaxation])
    bent = C * z - w.standing_damping * s / (1.0 + (V / w.standing_speed) ** 2)
    share, trail = pull(w, mu, bent)
    held = np.divide(share[1], bent[1], out=np.ones(()), where=bent[1] != 0.0)  # of the linear force, by friction
    by_camber = -soft * w.camber * N * lean * (float(held) if w.camber_lag else 0.0)
    F = N * share
    twist = np.tanh(v @ ahead / 0.01) * (w.twisting * N * lean - trail * (F[1] - by_camber))
    F = F - np.array([0.0, 0.0 if w.camber_lag else soft * w.camber * N * lean])
    r = np.linalg.norm(P)
    force = N * UP + F[0] * ahead + F[1] * left
    drag = -w.rolling_resistance * N * r * np.tanh(turning @ axle * r / 0.05)
    return force, np.cross(P, force) + twist * UP + drag * left, z_dot


def derivative(w: Wheel, y: np.ndarray) -> np.ndarray:
    """Return the rates of (r, e, r_dot, w in world axes, z_x, z_y), 15 numbers."""
    v, omega, axle = y[7:10], y[10:13], rotation(y[3:7])[:, 1]
    force, moment, z_dot = tread(w.tyre, w.tyre.mu, y[:3], axle, v, omega, y[13:15])
    inertia = w.diametral * np.eye(3) + (w.axial - w.diametral) * np.outer(axle, axle)
    alpha = np.linalg.solve(inertia, moment - np.cross(omega, inertia @ omega))
    e = y[3:7]
    e_dot = 0.5 * np.r_[-e[1:] @ omega, e[0] * omega + np.cross(omega, e[1:])]
    return np.concatenate([v, e_dot, force / w.mass - 9.81 * UP, alpha, z_dot])
