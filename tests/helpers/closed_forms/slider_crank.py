"""Forces, driving torque and harmonics of a slider-crank: what tests hold engines and planar models against."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from validation.theory.common import Array


@dataclass(frozen=True)
class SliderCrank:
    """Slider-crank without offset: crank about the origin, piston on the bore axis u, v at right angles to it.

    The crank stands at ``q`` from u towards v; the rod leans by ``sin(phi) = lam sin(q)``, lam = R / L.

    ``radius, rod_length``: crank radius R and rod length L > R [m]; ``crank_mass, crank_centre``: mass [kg] and
    distance of its centre of mass from the axis, towards the pin [m]; ``rod_mass, rod_fraction, rod_inertia``: mass
    [kg], distance of the centre of mass from the crankpin over L [-], inertia about it [kg m^2]; ``piston_mass``: [kg];
    ``crank_inertia``: about the centre of mass of the crank; enters only with an angular acceleration [kg m^2].
    ValueError if the crank is as long as the rod or longer.
    """

    radius: float
    rod_length: float
    crank_mass: float
    crank_centre: float
    rod_mass: float
    rod_fraction: float
    rod_inertia: float
    piston_mass: float
    crank_inertia: float = 0.0

    def __post_init__(self) -> None:
        if not 0 < self.radius < self.rod_length:
            raise ValueError(f"rod_length {self.rod_length} m: must exceed the crank radius {self.radius} m")

    @property
    def reciprocating(self) -> float:
        """Mass that moves with the piston, ``m_p + f m_r`` [kg]."""
        return self.piston_mass + self.rod_fraction * self.rod_mass

    @property
    def rotating_moment(self) -> float:
        """Mass moment that turns with the pin, ``m_c r_c + (1 - f) m_r R`` [kg m]."""
        return self.crank_mass * self.crank_centre + (1 - self.rod_fraction) * self.rod_mass * self.radius


class _CrankPaths(NamedTuple):
    """Positions of the moving parts over the crank angle, first and second derivative, components (u, v)."""

    crank: Array
    """Centre of mass of the crank, (3, n, 2): value, d/dq, d2/dq2 [m]."""
    rod: Array
    piston: Array
    lean: Array
    """Rod angle phi, (3, n) [rad]."""
    direction: Array
    """Unit vector from crankpin to piston, (n, 2)."""


def _crank_paths(mechanism: SliderCrank, angle: Array) -> _CrankPaths:
    """Kinematics of the slider-crank at the crank angles (n,)."""
    lam = mechanism.radius / mechanism.rod_length
    c, s = np.cos(angle), np.sin(angle)
    pin = np.stack([np.stack([c, s], -1), np.stack([-s, c], -1), np.stack([-c, -s], -1)])
    sine = lam * s
    cosine = np.sqrt(1 - sine**2)
    first = lam * c / cosine
    second = (sine * first**2 - lam * s) / cosine
    along, across = np.stack([cosine, -sine], -1), np.stack([-sine, -cosine], -1)
    swing = np.stack([along, first[:, None] * across, second[:, None] * across - first[:, None] ** 2 * along])
    rod = mechanism.radius * pin + mechanism.rod_fraction * mechanism.rod_length * swing
    piston = mechanism.radius * pin + mechanism.rod_length * swing
    return _CrankPaths(mechanism.crank_centre * pin, rod, piston, np.stack([np.arcsin(sine), first, second]), along)


def slider_crank_torque(
    mechanism: SliderCrank, angle: ArrayLike, rate: float, *, gravity: ArrayLike = (0.0, 0.0), acceleration: float = 0.0
) -> Array:
    """Driving torque by virtual power, ``T = sum m x' . (x'' w^2 + x' alpha - g) + J phi' (phi'' w^2 + phi' alpha)``.

    A dash is d/dq; at constant rate this is ``d/dt`` of the kinetic energy minus the power of gravity, over w.

    ``mechanism``: masses and lengths; ``angle`` (n,): crank angle q [rad]; ``rate, acceleration``: crank rate w [rad/s]
    and acceleration alpha [rad/s^2]; ``gravity`` (2,): components along the bore (u, towards the head) and across it
    (v) [m/s^2]. Returns (n,): torque on the crank [N m].
    """
    paths = _crank_paths(mechanism, np.atleast_1d(np.asarray(angle, dtype=float)))
    masses = (mechanism.crank_mass, mechanism.rod_mass, mechanism.piston_mass)
    torque = mechanism.crank_inertia * acceleration
    for mass, (_, first, second) in zip(masses, paths[:3], strict=True):
        inertial = second * rate**2 + first * acceleration - np.asarray(gravity)
        torque = torque + mass * np.sum(first * inertial, axis=-1)
    _, first, second = paths.lean
    return torque + mechanism.rod_inertia * first * (second * rate**2 + first * acceleration)


class CrankLoads(NamedTuple):
    """Forces in a slider-crank, components (u, v), (n, 2) [N], and the driving torque."""

    bearing: Array
    """Of the block on the crank."""
    crankpin: Array
    """Of the crank on the rod."""
    wristpin: Array
    """Of the rod on the piston."""
    guide: Array
    """Of the bore on the piston, (n,), along v [N]."""
    torque: Array
    """On the crank, (n,) [N m]."""


def slider_crank_loads(
    mechanism: SliderCrank,
    angle: ArrayLike,
    rate: float,
    *,
    gravity: ArrayLike = (0.0, 0.0),
    acceleration: float = 0.0,
    centripetal: bool = True,
) -> CrankLoads:
    """Forces in pins, bearing and bore by Newton and Euler, part by part from the piston to the crank.

    ``mechanism``: masses and lengths; ``angle`` (n,): crank angle q [rad]; ``rate, acceleration``: crank rate w [rad/s]
    and acceleration [rad/s^2]; ``gravity`` (2,): components along the bore (u, towards the head) and across it (v)
    [m/s^2]; ``centripetal``: false drops ``m_c w^2 r_c`` of the crank, which falsifies the bearing force only. Returns
    forces and torque.
    """
    angle, g = np.atleast_1d(np.asarray(angle, dtype=float)), np.asarray(gravity, dtype=float)
    paths = _crank_paths(mechanism, angle)
    crank, rod, piston = (p[2] * rate**2 + p[1] * acceleration for p in paths[:3])
    if not centripetal:
        crank = paths.crank[1] * acceleration
    d, length = paths.direction, mechanism.rod_length
    load = mechanism.rod_mass * (rod - g)
    along = mechanism.piston_mass * (piston[:, 0] - g[0])
    # moment about the centre of mass of the rod, whose angle from u is -phi
    spin = -mechanism.rod_inertia * (paths.lean[2] * rate**2 + paths.lean[1] * acceleration)
    across = (d[:, 1] * along - spin / length - mechanism.rod_fraction * _cross2(d, load)) / d[:, 0]
    wristpin = np.stack([along, across], axis=-1)
    crankpin = wristpin + load
    bearing = crankpin + mechanism.crank_mass * (crank - g)
    pin = mechanism.radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    about_axis = mechanism.crank_inertia + mechanism.crank_mass * mechanism.crank_centre**2
    weight = _cross2(paths.crank[0], mechanism.crank_mass * g)
    torque = about_axis * acceleration + _cross2(pin, crankpin) - weight
    return CrankLoads(bearing, crankpin, wristpin, -mechanism.piston_mass * g[1] - across, torque)


def _cross2(a: Array, b: Array) -> Array:
    """Component of a x b out of the plane, (n, 2) -> (n,)."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def block_force(mechanism: SliderCrank, angle: ArrayLike, rate: float, centripetal: bool = True) -> Array:
    """Inertia force on the block at constant crank rate, minus bearing and guide force without gravity.

    ``mechanism``: masses and lengths; ``angle`` (n,): crank angle q [rad]; ``rate``: crank rate [rad/s];
    ``centripetal``: as in :func:`slider_crank_loads`. Returns (n, 2): along the bore and across it [N].
    """
    loads = slider_crank_loads(mechanism, angle, rate, centripetal=centripetal)
    across = loads.bearing[:, 1] + loads.guide
    return -np.stack([loads.bearing[:, 0], across], axis=-1)


def harmonic_amplitudes(signal: Callable[[Array], Array], count: int, samples: int = 256) -> Array:
    """Amplitudes of the harmonics 0 ... count of a signal of one turn, by the discrete Fourier transform.

    ``signal``: maps angles (n,) [rad] to values (n,); smooth and of period 2 pi; ``count``: highest harmonic, below
    ``samples / 2``; ``samples``: samples per turn; the error is that of the harmonics beyond ``samples - count``.
    Returns (count + 1,): mean and amplitudes, unit of the signal.
    """
    angles = 2 * np.pi * np.arange(samples) / samples
    spectrum = np.abs(np.fft.rfft(signal(angles))) / samples
    return np.concatenate([spectrum[:1], 2 * spectrum[1 : count + 1]])
