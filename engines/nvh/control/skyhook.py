"""Skyhook damper: an actuator beside a mount pushes against the absolute velocity of the powertrain.

The actuator is slow, of second order: ``f'' / w^2 + 2 z f' / w + f = g v``, with -f on the powertrain and f on the car.
Its two states are linearised with the rest, and say up to which gain it is stable.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from engines.closed_forms import skyhook_limit
from engines.nvh.mounts.checks import Pairs
from engines.nvh.mounts.mounts import Mount, bushings
from mbsd3d import GROUND, Body, CustomForce, Prismatic, SpringDamper, System, linearize
from mbsd3d.errors import InputError
from mbsd3d.extend import number

GROWTH_ROUNDING = 1e-6  # [1/s] growth of undamped motions by rounding stays below
GAIN_MAX = 1e9  # [N s/m] gains beyond it are not searched


def push(t, bodies, z, parameters, loads, z_dot):
    """Apply the force along z on bodies[1] from bodies[0]; parameters: gain, corner, share of critical damping."""
    gain, corner, share = parameters[0], parameters[1], parameters[2]
    z_dot[0] = z[1]
    z_dot[1] = corner * corner * (gain * bodies[1].velocity[2] - z[0]) - 2 * share * corner * z[1]
    arm = bodies[1].r - bodies[0].r
    loads[1, 2], loads[0, 2] = -z[0], z[0]
    loads[0, 3], loads[0, 4] = arm[1] * z[0], -arm[0] * z[0]


@dataclass(frozen=True)
class Skyhook:
    """Skyhook at ``at`` (3,) [m] with ``gain`` g >= 0 [N s/m]; ``corner`` w > 0 [rad/s] and ``share`` z > 0 of the
    actuator. ValueError for others.
    """

    at: tuple[float, float, float]
    gain: float
    corner: float = 2 * np.pi * 60.0
    share: float = 0.6

    def __post_init__(self) -> None:
        number(self.gain, "skyhook: gain", minimum=0.0)
        number(self.corner, "skyhook: corner", positive=True)
        number(self.share, "skyhook: share", positive=True)

    def force(self, body: Body) -> CustomForce:
        """Return the force element between the car and a body."""
        numbers = self.gain, self.corner, self.share
        return CustomForce(
            push, on=(GROUND, body), points=(self.at, self.at), parameters=numbers, states=(0.0, 0.0), name="skyhook"
        )


def growth(system: System) -> float:
    """Return the largest real part of the eigenvalues of small motions about rest [1/s]."""
    return float(linearize(system).eigenvalues.real.max())


def limit(build: Callable[[float], System]) -> float:
    """Return the gain from which ``build(gain)`` is unstable; raise ValueError if always unstable or never below
    `GAIN_MAX`.
    """
    low, high = 0.0, 1.0
    if growth(build(low)) > -GROWTH_ROUNDING:
        raise InputError("skyhook: unstable or undamped without it; give mounts with dampers")
    while growth(build(high)) < 0.0:
        low, high = high, 4 * high
        if high > GAIN_MAX:
            raise InputError(f"skyhook: stable up to {GAIN_MAX:g} N s/m; there is no limit to find")
    return float(brentq(lambda gain: growth(build(gain)), low, high, rtol=1e-10))


def on_mounts(body: Body, placed: list[Mount], hook: Skyhook) -> System:
    """Return a powertrain as one body on its mounts, one of them with a skyhook; no weight."""
    return System([body], forces=[*bushings(placed, body), hook.force(body)], gravity=(0, 0, 0))


def one_body() -> Pairs:
    """Return the skyhook limit of a body that only heaves on a spring, by the eigenvalues and by Routh."""
    mass, rate, damping, corner, share = 178.0, 2.3e5, 640.0, 370.0, 0.6
    body = Body("body", mass, (1, 2, 3), com=(0.1, -0.2, 0.3))
    slide = Prismatic(GROUND, body, at=(0, 0, 0), axis=(0, 0, 1))
    spring = SpringDamper(GROUND, body, at_a=(0, 0, -0.3), at_b=(0, 0, 0), stiffness=rate, damping=damping)

    def build(gain: float) -> System:
        hook = Skyhook((0.2, 0.1, 0.0), gain, corner, share)
        return System([body], [slide], [spring, hook.force(body)], gravity=(0, 0, 0))

    return {"limit of a skyhook": (limit(build), skyhook_limit(mass, damping, rate, corner, share))}
