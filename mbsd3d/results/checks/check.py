"""A check, the limits of errors that add up over a run, and the sizes that errors are divided by."""

from dataclasses import dataclass

import numpy as np

from ...integrators.step_control import NEARLY_SINGULAR
from ..record import Record
from ..run_samples import RunSamples

USEFUL = 1e-2  # model lengths or radians: a motion further off than a hundredth is of no use, whatever was asked for
ADDED = 1e3  # times rtol is what local errors may add up to over a run
# Pivot of a singular position, near which rows are let go; by how much they may then gape, velocities and accelerations
# miss them: three times the most at poses 1e-8 ... 1e-3 rad off change points of 1 to 40 four-bars.
PASSED, MAY_GAPE, MAY_TEAR, MAY_MISS = 1e-4, 1e-10, 1e-8, 1e-5
# What rounding leaves in the balances, at any rtol: over the least pivot of a run, and at most, however near it came to
# singular positions; three times the worst of 420 runs of four-bars with windows, each over some twenty of them.
ROUNDED, MOST_ROUNDED, REGULAR = 3e-12, 5e-7, 1e-9
TRAVEL = 1e-6  # of the energy of a machine that flies on as a whole is a size too: it is known to rounding only
LOCAL = 10.0  # times rtol a step: a hundred times what it may err


@dataclass(frozen=True)
class Check:
    """One check: a relative error against its limit."""

    name: str
    error: float
    limit: float
    meaning: str

    @property
    def passed(self) -> bool:
        """True if the error is within its limit."""
        return bool(self.error <= self.limit)


def drift_limit(record: Record) -> float:
    """What errors of the steps may add up to, in the scales of the run: never more than they explain or is useful."""
    explained = LOCAL * record.rtol * record.steps if record.method.dt is None and record.method.order else np.inf
    if record.nearest < NEARLY_SINGULAR:  # forces grow there, and with them what a step may err of their work
        explained = np.inf
    rounding = max(REGULAR, min(MOST_ROUNDED, ROUNDED / max(record.nearest, ROUNDED)))
    return min(USEFUL, max(min(ADDED * record.rtol, explained), rounding))


def gaping(record: Record) -> float:
    """How far joints may gape that the integration holds, by Baumgarte's terms; 0 where projection closes them."""
    return drift_limit(record) if record.switches.stabilisation == "baumgarte" else 0.0


@dataclass(frozen=True)
class Scales:
    """Characteristic sizes of a run that the absolute errors are divided by; never zero."""

    rate: float  # 1/s
    acceleration: float
    force: float
    moment: float
    momentum: float
    angular_momentum: float
    energy: float


def scales_of(solution: RunSamples) -> Scales:
    """Sizes from the run itself, with floors from gravity, so that a mechanism at rest has scales too."""
    arrays, system, length = solution.arrays, solution.system, solution.compiled.model.length
    spin = largest(arrays["v"][..., 3:])
    speed = largest(arrays["v"][..., :3] - arrays["v"][..., :3].mean(axis=1, keepdims=True))
    speed = max(speed, length * spin, solution.record.speed)  # samples may all be of a machine at rest
    a = largest(arrays["acceleration"][..., :3])
    a = max(a, float(np.linalg.norm(system.gravity)), length * spin * spin) or 1.0
    mass = system.total_mass() or 1.0
    reach = largest(arrays["q"][..., :3]) + length
    absolute = max(largest(arrays["v"][..., :3]) + length * spin, speed)
    momentum = mass * max(absolute, 1e-3 * np.sqrt(a * length))
    speed = max(speed, np.sqrt(1e-3 * a * length))
    return Scales(
        rate=max(speed, absolute) / length,
        acceleration=a,
        force=mass * a,
        moment=mass * a * length,
        momentum=momentum,
        angular_momentum=momentum * reach,
        energy=mass * max(speed * max(speed, absolute), TRAVEL * absolute * absolute),  # a speed v errs by dv: m v dv
    )


def largest(values: np.ndarray) -> float:
    """Largest absolute value, 0 for none."""
    return float(np.abs(values).max(initial=0.0))
