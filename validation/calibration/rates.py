"""Truth by integration: equations of motion in minimal coordinates, integrated by scipy; open chains of hinges."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import solve_ivp

from mbsd3d.errors import InputError

Array = np.ndarray
TRUTH_RTOL = 1e-13  # [1] relative, of each step; the least scipy takes is 2.2e-14


def motion(slope: Callable[[float, Array], ArrayLike], start: ArrayLike, t_end: float) -> Callable[[Array], Array]:
    """Return y(t), (n,) -> (n, k), of y' = slope(t, y) up to ``t_end`` [s], to 1e-11 (scipy's interpolation)."""
    start = np.atleast_1d(np.asarray(start, float))
    size = np.maximum(np.abs(start), 1.0)
    course = solve_ivp(
        slope, (0.0, t_end), start, method="DOP853", rtol=TRUTH_RTOL, atol=TRUTH_RTOL * size, dense_output=True
    )
    if not course.success:
        raise InputError(f"truth: {course.message}; draw a shorter motion")

    def at(t: Array) -> Array:
        return course.sol(np.clip(np.asarray(t, float), 0.0, t_end)).T

    return at


def skew(u: Array) -> Array:
    """Return the matrix with ``skew(u) @ x = u x x``, shape (3, 3)."""
    return np.array([[0.0, -u[2], u[1]], [u[2], 0.0, -u[0]], [-u[1], u[0], 0.0]])


def turn(axis: Array, angle: float) -> Array:
    """Return the rotation by an angle [rad] about a unit axis, shape (3, 3)."""
    K = skew(axis)
    return np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * (K @ K)


@dataclass(frozen=True, eq=False)
class Chain:
    """Links in a row on hinges or slides, in minimal coordinates: q (n,), angle or displacement since the reference
    pose.

    ``points, axes`` (n, 3): of the joints, world at the reference pose, axes unit; ``slides`` (n,) bool; ``masses``
    (n,), ``centres`` (n, 3), ``inertias`` (n, 3, 3): of the links there, about their centres; ``gravity`` (3,);
    ``stiffness, damping`` (n,): of springs along the joints, unloaded at the reference pose.
    """

    points: Array
    axes: Array
    slides: Array
    masses: Array
    centres: Array
    inertias: Array
    gravity: Array
    stiffness: Array
    damping: Array

    def equations(self, q: Array, v: Array) -> tuple[Array, Array, Array]:
        """Return (M, right side without springs, centres of mass) by Kane's equations, link after link."""
        n = len(q)
        M, right, places = np.zeros((n, n)), np.zeros(n), np.zeros((n, 3))
        R, shift = np.eye(3), np.zeros(3)  # displacement of a link: x -> R x + shift
        spins, moves = np.zeros((3, n)), np.zeros((3, n))  # per rate: of the link, and of its point at the origin
        w, w_dot, v0, v0_dot = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)  # rates of rates: with q'' = 0
        for k in range(n):
            u, p = R @ self.axes[k], R @ self.points[k] + shift
            s_w, s_v = (np.zeros(3), u) if self.slides[k] else (u, skew(p) @ u)
            W, V = skew(w), skew(v0)  # the screw of the joint is carried by the link before it
            w_dot, v0_dot = w_dot + v[k] * (W @ s_w), v0_dot + v[k] * (W @ s_v + V @ s_w)
            w, v0 = w + v[k] * s_w, v0 + v[k] * s_v
            spins[:, k], moves[:, k] = s_w, s_v
            if self.slides[k]:
                shift = shift + q[k] * u
            else:
                Q = turn(u, q[k])
                R, shift = Q @ R, Q @ (shift - p) + p
            G, I, W = R @ self.centres[k] + shift, R @ self.inertias[k] @ R.T, skew(w)
            a = v0_dot + skew(w_dot) @ G + W @ (v0 + W @ G)  # of the centre
            J_w, m = spins[:, : k + 1], self.masses[k]
            J_v = moves[:, : k + 1] - skew(G) @ J_w
            M[: k + 1, : k + 1] += m * (J_v.T @ J_v) + J_w.T @ I @ J_w
            right[: k + 1] += m * ((self.gravity - a) @ J_v) - (I @ w_dot + W @ (I @ w)) @ J_w
            places[k] = G
        return M, right, places

    def motion(self, q: ArrayLike, v: ArrayLike, t_end: float) -> Callable[[Array], Array]:
        """Return (q, v)(t), (n,) -> (n, 2 k)."""
        n = len(self.masses)

        def slope(_: float, y: Array) -> Array:
            M, right = self.equations(y[:n], y[n:])[:2]
            return np.append(y[n:], np.linalg.solve(M, right - self.stiffness * y[:n] - self.damping * y[n:]))

        return motion(slope, np.concatenate([q, v]), t_end)

    def centre(self, k: int, course: Callable[[Array], Array]) -> Callable[[Array], Array]:
        """Return the centre of mass of a link over time, world."""
        n = len(self.masses)
        return lambda t: np.array([self.equations(y[:n], y[n:])[2][k] for y in course(t)])

    def velocities(self, v: Array) -> list[tuple[Array, Array]]:
        """Return (velocity of the centre, angular velocity) of each link at the reference pose."""
        found, w, v0 = [], np.zeros(3), np.zeros(3)
        for k, rate in enumerate(v):
            if self.slides[k]:
                v0 = v0 + rate * self.axes[k]
            else:
                w, v0 = w + rate * self.axes[k], v0 + rate * np.cross(self.points[k], self.axes[k])
            found.append((v0 + np.cross(w, self.centres[k]), w))
        return found
