"""Limits of active mounts in closed form."""

import numpy as np


def skyhook_limit(mass: float, damping: float, rate: float, corner: float, share: float) -> float:
    """Largest gain g [N s/m] of a force -g v through an actuator of second order, by Routh.

    ``mass, damping, rate`` of the body on its mount; ``corner`` [rad/s] and ``share`` of critical damping of the
    actuator. ``(m s^2 + c s + k) (s^2 + 2 z w s + w^2) + g w^2 s`` is stable while a_3 a_2 a_1 > a_4 a_1^2 + a_3^2 a_0.
    """
    a4, a3 = mass, 2 * share * corner * mass + damping
    a2 = mass * corner**2 + 2 * share * corner * damping + rate
    a0 = rate * corner**2
    a1 = (a3 * a2 + np.sqrt((a3 * a2) ** 2 - 4 * a4 * a3**2 * a0)) / (2 * a4)
    return (a1 - damping * corner**2 - 2 * share * corner * rate) / corner**2
