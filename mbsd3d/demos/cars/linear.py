"""Small lateral motions of a car that runs straight on, in closed form, and their response to the steer.

Displacements q = (y to the left, heading, roll to the right, travel in front, travel behind): the left wheel of an axle
moves up by its travel along the chassis, the right one down. With the steer d of the front wheels

    M q'' + D q' + K q = B d'' + C d' + T (F_f, F_r, X_f, X_r)

where the wheels' spin Iw v/r, carried round, takes the moments Iw v/r (heading' + steer') in roll and -Iw v/r roll' in
heading, F are side forces and X forces ahead of a left wheel, opposite to those of the right one; deflections z follow
s z' = -V - v z with the slip V of the contact point, F = N c z. Weight works on roll by -(ms h + 4 mw r) g.
"""

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from mbsd3d import Signal

from ..form import Symbol
from .car import Car, G

STEP_DIGITS = 12  # [1] digits of a step in s: times of an even grid are rounded

Y, HEADING, ROLL, FRONT, REAR = range(5)
STATE_COUNT = 16
"""q, q', side deflections front and rear, deflections ahead of the left wheels, spins of these above v/r."""
SIDE_STATES, AHEAD_STATES, SPIN_STATES = slice(10, 12), slice(12, 14), slice(14, 16)
FULL_SPIN, HALF_SPIN = 1.0, 0.5

SYMBOLS = {
    "q": Symbol("sideways, yaw, roll and the rest"),
    "M": Symbol("masses"),
    "D": Symbol("damping"),
    "K": Symbol("stiffness"),
    "B": Symbol("what the rate of the steer does"),
    "C": Symbol("what the steer does"),
    "d": Symbol("steer", "rad", "steer"),
    "T": Symbol("how the tyres act on the car"),
    "F": Symbol("forces of the tyres; in front to the side", "N", curve=(0, 1)),
}
"""Share of the wheels' spin that counts: of the moment half is I dw/dt of a diameter, which no switch takes away."""


class Linear(NamedTuple):
    """Linear equations x' = A x + B (d, d', d'')."""

    A: np.ndarray  # (n, n)
    B: np.ndarray  # (n, 3)

    def respond(self, d: Signal, times: np.ndarray, breaks: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
        """Return (states (k, n), their rates (k, n)) at rising times [s], from rest at 0; d is a cubic between its
        breaks.

        Exact: with d and its three derivatives as states the equations have no input, and exp(A t) solves them.
        """
        n, ends = len(self.A), [0.0, *breaks, max(times[-1], *breaks) + 1.0]
        whole = np.zeros((n + 4, n + 4))
        whole[:n, :n], whole[:n, n : n + 3], whole[n : n + 3, n + 1 :] = self.A, self.B, np.eye(3)
        x, found = np.zeros(n + 4), np.empty((times.size, n + 4))
        steps: dict[float, np.ndarray] = {}
        for start, end in itertools.pairwise(ends):
            middle, last = 0.5 * (start + end), start
            jerk = (d.second_derivative(0.5 * (middle + end)) - d.second_derivative(0.5 * (start + middle))) / (
                end - middle
            )
            x[n:] = d(start), d.derivative(start), d.second_derivative(middle) - jerk * (middle - start), jerk
            inside = np.flatnonzero((times >= start) & (times < end))
            for t, row in [*zip(times[inside], inside, strict=True), (end, None)]:
                step = round(t - last, STEP_DIGITS)
                if step not in steps:
                    steps[step] = expm(step * whole)
                x, last = steps[step] @ x, t
                if row is not None:
                    found[row] = x
        return found[:, :n], found @ whole[:n].T


def linear(c: Car, speed: float, spin: float = FULL_SPIN) -> Linear:
    """Return the small motions at a speed [m/s]."""
    one, half = np.eye(5), 0.5 * c.track
    gyro, diameter = spin * c.Iw * speed / c.r, 0.5 * c.Iw
    M = np.diag([c.ms, c.inertia[2], c.inertia[0], 0.0, 0.0])
    D, K = np.zeros((5, 5)), np.zeros((5, 5))
    D[ROLL, HEADING], D[HEADING, ROLL] = -4.0 * gyro, 4.0 * gyro
    K[ROLL, ROLL] = -(c.ms * c.h + 4.0 * c.mw * c.r) * G
    A, B = np.zeros((STATE_COUNT, STATE_COUNT)), np.zeros((STATE_COUNT, 3))
    pushed = np.zeros((5, STATE_COUNT))  # by the deflections
    axles = (("front left", c.a, FRONT, c.kf, c.bar_f), ("rear left", -c.b, REAR, c.kr, c.bar_r))
    for i, (wheel, x, travel, k, bar) in enumerate(axles):
        across, up, contact = np.zeros((3, 5))
        across[[Y, HEADING, ROLL]], contact[[Y, HEADING, ROLL]] = (1.0, x, c.h - c.r), (1.0, x, c.h)
        up[[ROLL, travel]] = half, 1.0
        M += 2.0 * c.mw * (np.outer(across, across) + np.outer(up, up))
        M[HEADING, HEADING] += 2.0 * (c.mw * half**2 + diameter)
        M[ROLL, ROLL] += 2.0 * diameter
        D += 2.0 * (c.damping * np.outer(one[travel], one[travel]) + c.ct * np.outer(up, up))
        K += 2.0 * ((k + 2.0 * bar / c.track**2) * np.outer(one[travel], one[travel]) + c.kt * np.outer(up, up))
        stiff = c.stiffness(wheel)
        pull = stiff * c.longitudinal / c.cornering
        pushed[:, SIDE_STATES.start + i], pushed[HEADING, AHEAD_STATES.start + i] = (
            2.0 * stiff * contact,
            -c.track * pull,
        )
        side, ahead, spins = (A[part.start + i] for part in (SIDE_STATES, AHEAD_STATES, SPIN_STATES))
        side[5:10], side[HEADING], side[SIDE_STATES.start + i] = -contact, speed, -speed
        ahead[5 + HEADING], ahead[SPIN_STATES.start + i], ahead[AHEAD_STATES.start + i] = half, c.r, -speed
        ahead[:5] += speed / c.r * up  # a wheel that rises rolls on a larger radius
        spins[AHEAD_STATES.start + i] = -c.r * pull / c.Iw
    A[SIDE_STATES] /= c.relaxation
    A[AHEAD_STATES] /= c.relaxation
    B[SIDE_STATES.start, 0] = speed / c.relaxation
    A[:5, 5:10] = np.eye(5)
    A[5:10] = np.linalg.solve(M, pushed - np.hstack([K, D, np.zeros((5, STATE_COUNT - 10))]))
    steered = np.zeros((5, 2))
    steered[ROLL, 0], steered[HEADING, 1] = 2.0 * gyro, -2.0 * diameter
    B[5:10, 1:] = np.linalg.solve(M, steered)
    return Linear(A, B)
