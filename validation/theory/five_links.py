"""Wheel on five rigid links by their Plücker lines: its twist, and its poses by integration of the twist."""

from collections.abc import Sequence

import numpy as np
from scipy.integrate import solve_ivp

Link = tuple[Sequence[float], Sequence[float]]


def twist(links: Sequence[Link], centre: np.ndarray, turn: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """Return the velocity of the wheel's centre and its angular velocity while the centre rises by 1 m/s, shape (6,).

    ``links``: (inner, outer) points at the reference pose; since then the wheel has turned by ``turn`` (3, 3) and its
    ``centre`` has moved by ``shift``. No link changes its length: ``l . (v + w x p) = (l, p x l) . (v, w) = 0``.
    """
    rows = []
    for inner, outer in links:
        arm = turn @ (np.array(outer) - centre)
        along = centre + shift + arm - np.array(inner)
        rows.append(np.concatenate([along, np.cross(arm, along)]))
    rows.append(np.array([0, 0, 1.0, 0, 0, 0]))
    return np.linalg.solve(rows, [0, 0, 0, 0, 0, 1.0])


def poses(links: Sequence[Link], centre: np.ndarray, heights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (shift (n, 3), turn (n, 3, 3)) of the wheel at heights that rise or fall from 0 on [m]: d(pose)/dz =
    twist.
    """
    centre = np.array(centre)

    def rate(_: float, state: np.ndarray) -> np.ndarray:
        turn = state[3:].reshape(3, 3)
        v = twist(links, centre, turn, state[:3])
        return np.concatenate([v[:3], np.cross(v[3:], turn, axisb=0, axisc=0).ravel()])

    start = np.concatenate([np.zeros(3), np.eye(3).ravel()])
    ends = (0.0, float(heights[-1]))
    found = solve_ivp(rate, ends, start, t_eval=heights, rtol=1e-12, atol=1e-13, method="DOP853").y.T
    return found[:, :3], found[:, 3:].reshape(-1, 3, 3)
