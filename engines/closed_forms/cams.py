"""Cam laws in closed form: lift over the angle from the nose, its derivatives, roller followers, float speed."""

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp


def cycloidal(angle: np.ndarray, lift: float, half: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (s, ds, dds) over an angle from the nose [rad]: ``s = h (x - sin(2 pi x) / 2 pi)``, x = 1 - |angle| /
    half.
    """
    x = np.clip(1 - np.abs(angle) / half, 0.0, 1.0)
    way = -np.sign(angle) * lift / half
    return (
        lift * (x - np.sin(2 * np.pi * x) / (2 * np.pi)),
        way * (1 - np.cos(2 * np.pi * x)),
        2 * np.pi * lift / half**2 * np.sin(2 * np.pi * x),
    )


def harmonic(angle: np.ndarray, lift: float, half: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (s, ds, dds) of ``s = h (1 - cos(pi x)) / 2``: the acceleration jumps where the lift begins."""
    x = np.clip(1 - np.abs(angle) / half, 0.0, 1.0)
    way = -np.sign(angle) * np.pi * lift / (2 * half)
    inside = np.abs(angle) < half
    return (
        lift / 2 * (1 - np.cos(np.pi * x)),
        way * np.sin(np.pi * x),
        np.where(inside, np.pi**2 * lift / (2 * half**2) * np.cos(np.pi * x), 0.0),
    )


def pressure_angle(s: np.ndarray, ds: np.ndarray, pitch: float) -> np.ndarray:
    """Return the pressure angle [rad] between the direction of travel of a roller and the force on it: ``tan = s' / (r
    + s)``.

    ``pitch``: r from the axis of the cam to that of the roller where it is lowest [m].
    """
    return np.arctan2(ds, pitch + s)


def roller_cam(angle: np.ndarray, s: np.ndarray, ds: np.ndarray, pitch: float, roller: float) -> np.ndarray:
    """Return the outline, the nose up, as points (across, up) [m], shape (n, 2); roller radius 0 gives the path of its
    centre.
    """
    r, alpha = pitch + s, pressure_angle(s, ds, pitch)
    across, up = roller * np.sin(alpha), r - roller * np.cos(alpha)  # from a cam that has turned by the angle
    return np.stack([across * np.cos(angle) + up * np.sin(angle), up * np.cos(angle) - across * np.sin(angle)], 1)


def float_rate(mass: float, rate: float, preload: float, s: np.ndarray, dds: np.ndarray) -> float:
    """Return the rate w [rad/s] of the cam from which a spring no longer holds a follower on it: least of (F + k s) /
    (-m s'').
    """
    slow = dds < -1e-6 * np.abs(dds).max()
    return float(np.sqrt(np.min((preload + rate * s[slow]) / (-mass * dds[slow]))))


def surge(mass: float, rate: float, count: int) -> np.ndarray:
    """Return w [rad/s] of a spring held at both ends as ``count`` masses, near ``j pi sqrt(k / m)``, shape (count,)."""
    j = np.arange(1, count + 1)
    return 2 * np.sqrt((count + 1) * rate * count / mass) * np.sin(j * np.pi / (2 * (count + 1)))


def bounce(
    law: Callable[[float], tuple[float, float, float]], turn: float, mass: float, spring: tuple[float, float],
    contact: tuple[float, float], t: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """Return the lift x (n,) at times t from rest on the back of a cam turning by ``turn`` [rad/s], in contact and off
    it [m].

    ``m x'' = -(F + k x) + max(0, K d (1 + c d'))`` where d = s - x > 0; ``law``: angle from the nose -> (s, ds, dds);
    ``spring``: (k, F); ``contact``: (K, c).
    """
    (rate, preload), (stiffness, damping) = spring, contact

    def motion(time: float, state: np.ndarray) -> list[float]:
        s, slope, _ = law((turn * time) % (2 * np.pi) - np.pi)
        d = s - state[0]
        push = stiffness * d * (1 + damping * (slope * turn - state[1])) if d > 0 else 0.0
        return [state[1], (max(push, 0.0) - preload - rate * state[0]) / mass]

    found = solve_ivp(
        motion, (0.0, t[-1]), [0.0, 0.0], "DOP853", t_eval=t, rtol=1e-10, atol=1e-13, max_step=t[-1] / 4e3
    )
    return found.y[0]
