"""Loop of hinges with one degree of freedom, from its axes alone: product of exponentials, closure by Newton, energy.

The curve of closed poses is followed by its arc length: the hinge angles obey ``phi' = tau``, the null vector of the
screws; with ``T = m(phi) sigma^2 / 2``, ``sigma`` the speed along the curve, Lagrange's equation is
``m sigma_dot + m' sigma^2 / 2 + V' = 0``.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import solve_ivp

from validation.theory.common import Array

TIME_RTOL = 1e-13  # [1] of the integration in time; rounding of one evaluation is a tenth of it


@dataclass(frozen=True, eq=False)
class HingeLoop:
    """Loop of n hinges, ground - link 1 - ... - link n - 1 - ground, at a closed pose.

    ``points, axes``: (n, 3) of the hinges, world, axes unit; ``masses`` (n - 1,), ``centres`` (n - 1, 3), ``inertias``
    (n - 1, 3, 3) of the links, world, inertias about the centres; ``gravity`` (3,). SI units.
    """

    points: Array
    axes: Array
    masses: Array
    centres: Array
    inertias: Array
    gravity: Array

    def motion(self, rate: float, times: ArrayLike, hinge: int = 0) -> Array:
        """Return the angles since the start [rad], from the rate of one hinge at the start [rad/s], shape (len(times),
        n).

        ValueError if the loop has not exactly one degree of freedom at its start.
        """
        n, values = len(self.axes), np.linalg.svd(self.screws(np.zeros(len(self.axes)))[0])[1]
        rank = int((values > 1e-8 * values[0]).sum())
        if rank != n - 1:
            raise ValueError(f"loop of {n} hinges: screws of rank {rank}; one degree of freedom needs {n - 1}")
        heading = [self.pose(np.zeros(n), None).tangent]
        if abs(heading[0][hinge]) < 1e-6:
            raise ValueError(f"loop: hinge {hinge + 1} does not turn at the start; give the rate of another")

        def slope(_: float, y: Array) -> Array:
            at = self.pose(y[:-1], heading[0])
            heading[0] = at.tangent
            mass, mass_slope, weight = self.along(at)
            return np.append(at.tangent * y[-1], -(0.5 * mass_slope * y[-1] ** 2 + weight) / mass)

        start, times = np.append(np.zeros(n), rate / heading[0][hinge]), np.asarray(times, float)
        found = solve_ivp(slope, (0.0, times[-1]), start, method="DOP853", rtol=TIME_RTOL, atol=TIME_RTOL, t_eval=times)
        return found.y[:-1].T

    def screws(self, angles: Array) -> tuple[Array, list[Array]]:
        """Return axes and moments ``p x u`` about the world's origin (6, n) after the turns, and displacements (4, 4)
        of the links.
        """
        place: list[Array] = [np.eye(4)]
        columns: list[Array] = []
        for u, p, angle in zip(self.axes, self.points, angles, strict=True):
            R, now = place[-1][:3, :3], place[-1][:3, :3] @ u
            columns.append(np.append(now, _skew(R @ p + place[-1][:3, 3]) @ now))
            place.append(place[-1] @ _turn(u, p, angle))
        return np.array(columns).T, place[1:]

    def pose(self, angles: Array, heading: Array | None) -> "Pose":
        """Return the closed pose nearest to the angles; its tangent points to the side of `heading`."""
        for _ in range(6):
            J, place = self.screws(angles)
            U, values, Vt = np.linalg.svd(J)
            rank = len(angles) - 1
            inverse = Vt[:rank].T @ (U[:, :rank] / values[:rank]).T
            R, end = place[-1][:3, :3], place[-1][:3, 3]
            gap = np.append(0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]), end)
            if np.abs(gap).max() < 1e-14:
                break
            angles = angles - inverse @ gap
        tau = Vt[rank]
        return Pose(J, place, -tau if heading is not None and tau @ heading < 0 else tau, inverse)

    def along(self, at: "Pose") -> tuple[float, float, float]:
        """Return ``m``, ``m'`` and ``V'`` along the curve."""
        turns = at.screws * at.tangent
        before = np.cumsum(turns, axis=1) - turns  # twists of the bodies each hinge is carried by
        carried = np.column_stack([_bracket(v, s) for v, s in zip(before.T, turns.T, strict=True)])
        bend = -at.inverse @ carried.sum(axis=1)  # has no part along tau: of the pseudo-inverse
        twist, change = np.cumsum(turns, axis=1), np.cumsum(at.screws * bend + carried, axis=1)
        mass = mass_slope = weight = 0.0
        links = zip(at.place[:-1], self.masses, self.centres, self.inertias, twist.T, change.T, strict=False)
        for T, m, centre, inertia, v, a in links:
            spin, point, turned = _skew(v[:3]), T[:3, :3] @ centre + T[:3, 3], T[:3, :3] @ inertia @ T[:3, :3].T
            speed = v[3:] + spin @ point
            climb = a[3:] + _skew(a[:3]) @ point + spin @ speed
            mass += m * speed @ speed + v[:3] @ turned @ v[:3]
            mass_slope += 2.0 * (m * speed @ climb + v[:3] @ turned @ a[:3])
            weight -= m * self.gravity @ speed
        return mass, mass_slope, weight


@dataclass(frozen=True, eq=False)
class Pose:
    """Closed pose: ``screws`` (6, n) after the turns; ``place``: displacements of the links; ``tangent`` (n,);
    pseudo-``inverse``.
    """

    screws: Array
    place: list[Array]
    tangent: Array
    inverse: Array


def _skew(u: Array) -> Array:
    """Return the matrix with ``_skew(u) @ x = u x x``, shape (3, 3)."""
    return np.array([[0.0, -u[2], u[1]], [u[2], 0.0, -u[0]], [-u[1], u[0], 0.0]])


def _bracket(v: Array, s: Array) -> Array:
    """Return the rate of a screw s carried by a body of twist v."""
    W = _skew(v[:3])
    return np.append(W @ s[:3], _skew(v[3:]) @ s[:3] + W @ s[3:])


def _turn(u: Array, p: Array, angle: float) -> Array:
    """Return the displacement by a turn about the line through p along u, shape (4, 4)."""
    K, T = _skew(u), np.eye(4)
    T[:3, :3] += np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K
    T[:3, 3] = p - T[:3, :3] @ p
    return T
