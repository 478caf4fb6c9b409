"""Bodies on springs in closed form: transmissibility, bounce and pitch on two mounts, three coupled degrees of freedom,
a quarter car, the limit of an active mount.
"""

import numpy as np


def transmissibility(frequency: np.ndarray, natural: float, damping: float) -> np.ndarray:
    """Return the force transmitted over the force applied of a mass on spring and damper, complex.

    ``T = (1 + 2 i z r) / (1 - r^2 + 2 i z r)`` with r = frequency / natural, z the share of critical damping.
    """
    r = np.asarray(frequency) / natural
    return (1 + 2j * damping * r) / (1 - r**2 + 2j * damping * r)


def bounce_and_pitch(
    mass: float, gyration: float, rates: tuple[float, float], arms: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Return (w [rad/s], centres [m]) of the modes of a beam on two springs, arms in front (+) and behind (-) of the
    centre.

    With a = (k1 + k2) / m, b = (k1 l1 + k2 l2) / m, c = (k1 l1^2 + k2 l2^2) / (m i^2) the frequencies are

        w^2 = (a + c) / 2 -+ sqrt((a - c)^2 / 4 + b^2 / i^2)

    and every mode turns about a fixed point: where the displacement at x is z + x theta, it lies at x = b / (a - w^2).
    """
    (k1, k2), (l1, l2) = rates, arms
    a, b, c = (k1 + k2) / mass, (k1 * l1 + k2 * l2) / mass, (k1 * l1**2 + k2 * l2**2) / (mass * gyration**2)
    spread = np.sqrt((a - c) ** 2 / 4 + b**2 / gyration**2)
    squares = (a + c) / 2 + np.array([-spread, spread])
    return np.sqrt(squares), b / (a - squares)


def three_coupled(mass: float, inertia: tuple[float, float], rates: dict[str, float]) -> np.ndarray:
    """Return w [rad/s] of a body symmetric to one plane: y, rotation about x and about z, from its cubic, shape (3,).

    ``inertia``: (I_x, I_z) about the centre of mass, principal; ``rates``: entries yy, yx, yz, xx, xz, zz of the
    stiffness (displacement y, rotations about x and z). det(K - w^2 M) = 0 is written out by its minors.
    """
    k = rates
    m, (A, C) = mass, inertia
    yy, xx, zz = k["yy"], k["xx"], k["zz"]
    yx, yz, xz = k["yx"], k["yz"], k["xz"]
    cubic = [
        -m * A * C,
        yy * A * C + xx * m * C + zz * m * A,
        -(yy * xx - yx**2) * C - (yy * zz - yz**2) * A - (xx * zz - xz**2) * m,
        yy * (xx * zz - xz**2) - yx * (yx * zz - xz * yz) + yz * (yx * xz - xx * yz),
    ]
    return np.sqrt(np.sort(np.roots(cubic).real))


def quarter_car(
    rate: np.ndarray,
    masses: tuple[float, float],
    spring: tuple[float, float],
    tyre: tuple[float, float],
    inerter: float = 0.0,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the heights of body and wheel over that of the road, complex, at rates w [rad/s].

    ``masses``: (m_s, m_u) of body and wheel; ``spring``, ``tyre``: (stiffness, damping); ``inerter``: b [kg], which
    takes the force b (z_s'' - z_u''). With S = k_s + i w c_s - b w^2 and T = k_t + i w c_t, from both equations by
    elimination:

        z_u / z = T (S - m_s w^2) / D,   z_s / z = T S / D,   D = (S - m_s w^2) (S + T - m_u w^2) - S^2
    """
    w = np.asarray(rate)
    S, T = spring[0] + 1j * w * spring[1] - inerter * w**2, tyre[0] + 1j * w * tyre[1]
    above = S - masses[0] * w**2
    D = above * (S + T - masses[1] * w**2) - S**2
    return T * S / D, T * above / D


def skyhook_limit(mass: float, damping: float, rate: float, corner: float, share: float) -> float:
    """Return the largest gain g [N s/m] of a force -g v through an actuator of second order, by Routh.

    ``mass, damping, rate`` of the body on its mount; ``corner`` [rad/s] and ``share`` of critical damping of the
    actuator. ``(m s^2 + c s + k) (s^2 + 2 z w s + w^2) + g w^2 s`` is stable while a_3 a_2 a_1 > a_4 a_1^2 + a_3^2 a_0.
    """
    a4, a3 = mass, 2 * share * corner * mass + damping
    a2 = mass * corner**2 + 2 * share * corner * damping + rate
    a0 = rate * corner**2
    a1 = (a3 * a2 + np.sqrt((a3 * a2) ** 2 - 4 * a4 * a3**2 * a0)) / (2 * a4)
    return (a1 - damping * corner**2 - 2 * share * corner * rate) / corner**2
