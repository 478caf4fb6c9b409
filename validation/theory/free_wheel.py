"""A free wheel on a tyre, written out once more: Newton and Euler, contact by a search, brush by its patch.

Nothing of `mbsd3d` is used. The lowest point of the torus is found as a minimum over its circle, the force of the brush
as an integral over the bristles of the patch, so that no formula is the same as in the element.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.optimize import minimize_scalar

NODES, WEIGHTS = leggauss(40)
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Wheel:
    """Mass, moments about the axle y and a diameter, and its tyre, by the words of `mbsd3d.Tyre`; SI units."""

    mass: float
    axial: float
    diametral: float
    radius: float
    crown: float
    stiffness: float
    damping: float
    cornering: float
    longitudinal: float
    camber: float
    relaxation: float
    relaxation_x: float
    mu: float
    trail: float
    twisting: float
    rolling_resistance: float
    nominal_load: float
    grip_sensitivity: float
    stiffness_sensitivity: float


def rotation(e: np.ndarray) -> np.ndarray:
    """(3, 3) of a quaternion of any length, scalar first."""
    e = e / np.linalg.norm(e)
    v, S = e[1:], np.cross(np.eye(3), e[1:])
    return np.eye(3) + 2.0 * e[0] * S + 2.0 * (np.outer(v, v) - (v @ v) * np.eye(3))


def lowest(w: Wheel, axle: np.ndarray) -> np.ndarray:
    """From the hub to the lowest point of the circle of tube centres, by a search for its angle."""
    a = np.cross(axle, [1.0, 0.0, 0.0])
    a /= np.linalg.norm(a)
    b = np.cross(axle, a)

    def height(angle: float) -> float:
        return a[2] * np.cos(angle) + b[2] * np.sin(angle)

    grid = np.linspace(0.0, 2.0 * np.pi, 9)
    best = grid[np.argmin([height(x) for x in grid])]
    angle = minimize_scalar(height, bracket=(best - 0.4, best, best + 0.4), tol=1e-14).x
    slope, bend = b[2] * np.cos(angle) - a[2] * np.sin(angle), -height(angle)
    angle -= slope / bend  # a search finds a minimum to half the digits only
    return (w.radius - w.crown) * (a * np.cos(angle) + b * np.sin(angle))


def patch(slip: float) -> tuple[float, float]:
    """(force over grip, trail over that at rest) of bristles under a parabolic pressure, for C sigma/mu = slip.

    Along x = -1 ... 1 a bristle is bent by (1 - x) slip/2 and holds up to 3 (1 - x^2)/4; units: mu N, half the patch.
    """
    edge = min(2.0 * slip / 3.0 - 1.0, 1.0)  # where the bent bristles meet the parabola: they stick ahead of it
    bent = 0.5 * (1.0 - edge) * NODES + 0.5 * (1.0 + edge)  # x of the nodes of the sticking part
    stick = 0.5 * (1.0 - edge) * WEIGHTS * 0.5 * slip * (1.0 - bent)
    slid = 0.5 * (edge + 1.0) * NODES + 0.5 * (edge - 1.0)
    slide = 0.5 * (edge + 1.0) * WEIGHTS * 0.75 * (1.0 - slid**2)
    force, moment = stick.sum() + slide.sum(), -(stick @ bent) - slide @ slid
    return float(force), float(3.0 * moment / force) if force > 0.0 else 1.0


def derivative(w: Wheel, y: np.ndarray) -> np.ndarray:
    """Rates of (r, e, r_dot, w in world axes, z_x, z_y), 15 numbers."""
    R, v, omega, z = rotation(y[3:7]), y[7:10], y[10:13], y[13:15]
    axle = R[:, 1]
    T = lowest(w, axle)
    P = np.array([T[0], T[1], -y[2]])  # from the hub to the contact point
    ahead = np.cross(axle, UP)
    ahead /= np.linalg.norm(ahead)
    left = np.cross(UP, ahead)
    slip, tread = v + np.cross(omega, P), v + np.cross(omega, T)
    sunk = w.crown - (y[2] + T[2])
    N = max(w.stiffness * sunk - w.damping * tread[2], 0.0) if sunk > 0.0 else 0.0
    mu = w.mu * (1.0 - w.grip_sensitivity * (N / w.nominal_load - 1.0))
    soft = 1.0 - w.stiffness_sensitivity * (N / w.nominal_load - 1.0)
    C = soft * np.array([w.longitudinal, w.cornering])
    V, s = abs(v @ ahead), np.array([slip @ ahead, slip @ left])
    bound = np.linalg.norm(C * s) / (3.0 * mu)
    lag = np.array([0.0, V * w.camber / w.cornering * axle[2]])
    z_dot = (-s - lag - (V + bound) * z) / np.array([w.relaxation_x, w.relaxation])
    q = np.linalg.norm(C * z) / mu
    share, trail = patch(min(q / (1.0 - q / 3.0), 3.0) if q < 1.5 else 3.0)
    F = mu * N * share * C * z / np.linalg.norm(C * z) if q > 0.0 else np.zeros(2)
    by_camber = -soft * w.camber * N * axle[2] * (share / q if q > 0.0 else 1.0)
    r = np.linalg.norm(P)
    twist = w.twisting * N * axle[2] - w.trail * trail * (F[1] - by_camber)
    force = N * UP + F[0] * ahead + F[1] * left
    drag = -w.rolling_resistance * N * r * np.tanh(omega @ axle * r / 0.05)
    moment = np.cross(P, force) + twist * UP + drag * left
    inertia = w.diametral * np.eye(3) + (w.axial - w.diametral) * np.outer(axle, axle)
    alpha = np.linalg.solve(inertia, moment - np.cross(omega, inertia @ omega))
    e = y[3:7]
    e_dot = 0.5 * np.r_[-e[1:] @ omega, e[0] * omega + np.cross(omega, e[1:])]
    return np.concatenate([v, e_dot, force / w.mass - 9.81 * UP, alpha, z_dot])
