"""Engine balance in closed form: the inertia load of a reciprocating engine on its block, as phasors.

One cylinder, crank angle q from its bore u towards v. With lam = R / L, f the place of the rod's centre of mass and

    m_rec = m_p + f m_r          what moves with the piston
    U     = m_c r_c + (1 - f) m_r R        mass moment that turns with the pin

the rod is two point masses at its ends and the defect ``J = I_r - f (1 - f) m_r L^2`` of its inertia. Then

    P = (U + m_rec R) cos q u + U sin q v + m_rec L sqrt(1 - lam^2 sin^2 q) u      first moment of mass [kg m]
    F = -w^2 P'' + m g            force on the block
    C = w^2 J phi'' + (P x g)     torque on the block about the crank axis, driver on the block; sin phi = lam sin q
    T = w^2 d/dq (m_rec s'^2 + J phi'^2) / 2 - P' . g       torque of the driver on the crank

with ``s = R cos q + L sqrt(...)`` the place of the piston, and a dash for d/dq. All follow from one series,

    (1 - lam^2 sin^2 q)^p = sum_k c_2k cos 2 k q,
    c_2k = sum_(j >= k) C(p, j) (-1)^(j+k) 2^(1-2j) C(2j, j-k) lam^(2j),  half of it for k = 0,

with p = 1/2 for P, -1/2 for ``phi' = lam cos q (...)^(-1/2)``, -1 for ``phi'^2 = 1 - (1 - lam^2) (...)^(-1)``.
Cylinder i runs at ``q + pins[i] - bores[i]`` in the plane z = stations[i]; its phasors turn by that angle times the
order, and are summed. A phasor c_n means ``Re(c_n exp(i n q))``.
"""

from typing import Any

import numpy as np

from engines.balance.harmonics import Harmonics
from mbsd3d.errors import InputError

SERIES_TERM_RATIO_MIN = 1e-18  # [1] of the first term of a series; smaller terms are left out


def series(lam: float, power: float, count: int) -> np.ndarray:
    """Return the coefficients c_0, c_2, c_4 ... of (1 - lam^2 sin^2 q)^power.

    ``lam``: R / L, 0 < lam < 1; ``power``: p, below 1; not a natural number; ``count``: number of coefficients. Returns
    (count,).
    """
    return np.array([_coefficient(lam, power, k) for k in range(count)])


def _coefficient(lam: float, power: float, k: int) -> float:
    """Return c_2k; each term of its series follows from the one before, and all have one sign from the second on."""
    term, total, j = (1.0 if k == 0 else 2.0) * (lam / 2) ** (2 * k), 0.0, k
    for i in range(k):
        term *= (power - i) / (i + 1)
    while abs(term) > SERIES_TERM_RATIO_MIN * abs(total):
        total += term
        term *= lam**2 * (j - power) * (2 * j + 1) / (2 * (j + 1 - k) * (j + 1 + k))
        j += 1
    return total


def block_load(
    engine: Any, orders: int = 6, *, article: bool = False, across: bool = True, gravity: Any = (0.0, 0.0),
    dyno: bool = False,
) -> Harmonics:  # fmt: skip
    """Compute the load of all moving parts on the block, and the torque that keeps the crank at constant speed.

    ``engine``: identical cylinders without offset; ``orders``: highest harmonic; ``article``: true leaves out m_c w^2
    r_c, the centripetal force of the crank, as the published figures did; ``across``: false leaves out the force at
    right angles to the bore, as the published figures of V engines did; ``gravity`` (2,): components along x and y
    [m/s^2]; ``dyno``: the driving torque reacts outside of the block. ValueError if cylinders differ or have an
    offset (the closed form holds for identical, centred ones), or at rpm 0.
    """
    check_lemma(engine)
    w, g = engine.rate, np.asarray(gravity, dtype=float)
    n = np.arange(terms(engine, orders) + 1)
    delta, beta = np.radians(engine.layout.phases), np.radians(engine.layout.bores)
    phase = np.exp(1j * np.outer(delta, n))
    axes = np.stack([np.cos(beta), np.sin(beta)], -1), np.stack([-np.sin(beta), np.cos(beta)], -1)
    heavy = turning(engine, crank=True)
    force = w**2 * n[:, None] ** 2 * first_moment(engine, phase, axes, turning(engine, crank=not article), across)
    force[:, 0] += mass(engine) * g
    weight = first_moment(engine, phase, axes, heavy).sum(axis=0)
    kinetic, swing = energy(engine, n.size), swing_acceleration(engine, n.size)
    torque = phase.sum(axis=0) * 1j * n * w**2 * kinetic - 1j * n * (weight @ g)
    couple = phase.sum(axis=0) * w**2 * defect(engine) * swing + weight[:, 0] * g[1] - weight[:, 1] * g[0]
    z = engine.stations
    moment = np.stack([-(z @ force[..., 1]), z @ force[..., 0], couple + (torque if dyno else 0.0)], axis=-1)
    total = np.pad(force.sum(axis=0), ((0, 0), (0, 1)))
    return Harmonics(total[: orders + 1], moment[: orders + 1], torque[: orders + 1])


def check_lemma(engine: Any) -> None:
    """Raise ValueError unless all cylinders are alike and centred."""
    what = f"phasor of engine '{engine.layout.name}'"
    if len(set(engine.pistons)) > 1:
        light, heavy = min(engine.pistons), max(engine.pistons)
        raise InputError(f"{what}: pistons from {light:g} to {heavy:g} kg are not alike (H2); use planar or spatial")
    if engine.offset:
        raise InputError(f"{what}: offset {engine.offset:g} m has no closed form here; use planar or spatial")


def terms(engine: Any, orders: int) -> int:
    """Return the highest order to keep: coefficients fall like nu^n with nu = lam / (1 + sqrt(1 - lam^2))."""
    lam = engine.radius / engine.rod_length
    return orders + int(np.log(SERIES_TERM_RATIO_MIN) / np.log(lam / (1 + np.sqrt(1 - lam**2)))) + 2


def mass(engine: Any) -> float:
    """Return the mass of all moving parts of one cylinder [kg]."""
    return engine.crank_mass + engine.rod_mass + engine.pistons[0]


def reciprocating(engine: Any) -> float:
    """Return the reciprocating mass m_rec of a cylinder [kg]."""
    return engine.pistons[0] + engine.rod_fraction * engine.rod_mass


def turning(engine: Any, crank: bool) -> float:
    """Return the rotating first moment U of a throw, with or without the crank [kg m]."""
    return crank * engine.crank_mass * engine.crank_centre + (1 - engine.rod_fraction) * engine.rod_mass * engine.radius


def defect(engine: Any) -> float:
    """Return the defect of inertia J of a rod against two point masses [kg m^2]."""
    f = engine.rod_fraction
    return engine.rod_inertia - f * (1 - f) * engine.rod_mass * engine.rod_length**2


def place(engine: Any, size: int) -> np.ndarray:
    """Return the Fourier coefficients of s, from the crank axis to the wristpin [m], shape (size,)."""
    s = np.zeros(size)
    s[::2] = engine.rod_length * series(engine.radius / engine.rod_length, 0.5, s[::2].size)
    s[1] = engine.radius
    return s


def first_moment(engine: Any, phase: np.ndarray, axes: tuple, turning: float, across: bool = True) -> np.ndarray:
    """Return the first moments P of every cylinder as phasors, world axes [kg m], shape (cylinders, size, 2)."""
    along, sideways = reciprocating(engine) * place(engine, phase.shape[1]), np.zeros(phase.shape[1], dtype=complex)
    along[1] += turning
    sideways[1] = -1j * turning * across
    u, v = axes
    return phase[..., None] * (along[:, None] * u[:, None] + sideways[:, None] * v[:, None])


def swing_acceleration(engine: Any, size: int) -> np.ndarray:
    """Return the phasors of phi'', from phi' = lam cos q sum_k c_2k cos 2 k q with p = -1/2."""
    lam = engine.radius / engine.rod_length
    c = series(lam, -0.5, size // 2 + 1)
    c[0] *= 2
    phi = np.zeros(size)
    phi[1::2] = lam * (c[:-1] + c[1:])[: phi[1::2].size] / 2
    return 1j * np.arange(size) * phi


def energy(engine: Any, size: int) -> np.ndarray:
    """Return the phasors of the kinetic energy (m_rec s'^2 + J phi'^2) / 2 [kg m^2]."""
    lam, n = engine.radius / engine.rod_length, np.arange(size)
    swing = np.zeros(size)
    swing[::2] = -(1 - lam**2) * series(lam, -1.0, swing[::2].size)
    swing[0] += 1.0
    return (reciprocating(engine) * square(1j * n * place(engine, size)) + defect(engine) * swing) / 2


def square(c: np.ndarray) -> np.ndarray:
    """Return the phasors of the square of a signal, up to its own highest order."""
    both = np.concatenate([np.conj(c[:0:-1]), [2 * c[0]], c[1:]]) / 2
    product = np.convolve(both, both)[both.size - 1 :][: c.size]
    return np.concatenate([product[:1], 2 * product[1:]])
