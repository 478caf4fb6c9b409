"""How well "1 - 1 = 0" holds in the planar and in the spatial solver: sums that vanish, over forces that cancel.

Numbers of mechanisms of `validation.tax.pairs`, driven through one turn by kinematics:

    sum of the forces of the ground + m g - m a_G = 0        Newton for the whole mechanism
    1x force of an inline four on its block = 0              the throws cancel
    force across the bores of an inline four = 0             likewise, at all orders
    force and motion out of the plane = 0                    in space
"""

from typing import Any, NamedTuple

import numpy as np

from mbsd3d import RK4, Kinematic, simulate
from validation.engine_balance.spectrum import spectrum
from validation.tax.pairs import Mechanism, mechanisms
from validation.twins import planar

CYCLE = 72  # samples of a turn
STEPS = 400  # of RK4, for a free turn


class Floor(NamedTuple):
    """Largest amount of a sum that vanishes in theory, relative to the forces that cancel in it."""

    mechanism: str
    what: str
    plane: float | None
    space: float
    redundant: float


def cycle(mechanism: Mechanism) -> list[Any]:
    """One driven turn by kinematics: in the plane, in space, in space with redundant rows."""
    times = mechanism.turn * np.arange(CYCLE + 1) / CYCLE
    spatial = [mechanism.space(driven=True, redundant=redundant) for redundant in (False, True)]
    return [
        planar.kinematics(mechanism.plane(driven=True), times),
        *(simulate(system, times[-1], method=Kinematic(), output=CYCLE + 1) for system in spatial),
    ]


def cubic(values: np.ndarray) -> np.ndarray:
    """(n, 3) of (n, 2), (n, 3) or, about z, (n,)."""
    if values.ndim == 1:
        return values[:, None] * (0.0, 0.0, 1.0)
    return np.pad(values, ((0, 0), (0, 3 - values.shape[1])))


def grounded(mechanism: Mechanism, solution: Any) -> list[np.ndarray]:
    """(n, 3) force of the ground in each of its joints [N]."""
    return [cubic(solution.reaction(c.name).force) for c in mechanism.couplings if c.a is None]


def imbalance(mechanism: Mechanism, solution: Any) -> float:
    """Newton for the whole: largest |forces of the ground + m g - sum m a_G|, relative to the largest force."""
    forces, rest = grounded(mechanism, solution), 0.0
    for link in mechanism.links:
        arm = cubic(solution.com(link.name) - solution.position(link.name))
        alpha, omega = cubic(solution.alpha(link.name)), cubic(solution.omega(link.name))
        a = cubic(solution.acceleration(link.name)) + np.cross(alpha, arm) + np.cross(omega, np.cross(omega, arm))
        rest = rest + link.mass * (a - (*mechanism.gravity, 0.0))
    return float(np.abs(sum(forces) - rest).max() / np.abs(forces).max())


def balanced(mechanism: Mechanism, solution: Any) -> tuple[float, float]:
    """(1x force along the bores, largest force across them) of the inline four on its block over F_single.

    F_single = w^2 (m_c r_c + (m_r + m_p) R), 10 kg m w^2: the 1x force of one cylinder.
    """
    single = 10.0 * mechanism.rate**2
    block = -sum(grounded(mechanism, solution))
    along = spectrum(solution.t, block[:, 1], rate=mechanism.rate)
    return float(abs(along.at(1)) / single), float(np.abs(block[:, 0]).max() / single)


def noise_floors() -> list[Floor]:
    """How well "1 - 1 = 0" holds: sums over a driven turn, and what leaves the plane in space."""
    floors = []
    for mechanism in mechanisms():
        runs = cycle(mechanism)
        floors.append(Floor(mechanism.name, "Newton for the whole", *(imbalance(mechanism, run) for run in runs)))
        lost = [float(np.abs(sum(f))[:, 2].max() / np.abs(f).max()) for f in (grounded(mechanism, r) for r in runs[1:])]
        floors.append(Floor(mechanism.name, "force out of the plane", None, *lost))
        forms = [mechanism.space(redundant=redundant) for redundant in (False, True)]
        free = [simulate(system, mechanism.turn, method=RK4(mechanism.turn / STEPS), output=2) for system in forms]
        size = max(np.abs(link.origin).max() for link in mechanism.links)
        drift = [max(abs(np.ptp(run.com(link.name)[:, 2])) for link in mechanism.links) / size for run in free]
        floors.append(Floor(mechanism.name, "drift out of the plane", None, *map(float, drift)))
    pairs = [balanced(mechanism, run) for run in runs]  # of the last mechanism, the inline four
    floors.append(Floor(mechanism.name, "1x along the bores / F_single", *(pair[0] for pair in pairs)))
    floors.append(Floor(mechanism.name, "force across the bores / F_single", *(pair[1] for pair in pairs)))
    return floors
