"""One check, the limits of errors that accumulate over a run, and the scales that errors are divided by."""

from dataclasses import dataclass

import numpy as np

from ...integrators.step_control import NEAR_SINGULAR_SHARE
from ..record import Record
from ..result import RunResult

DRIFT_LIMIT_MAX = 1e-2  # model lengths or radians: with larger errors a motion is of no use, whatever rtol was
ACCUMULATED_ERROR_FACTOR = 1e3  # [1] of rtol: what local errors may add up to over a run
# Pivot of a singular position, near which rows are let go; by how much they may then gape, velocities and accelerations
# miss them: three times the most at poses 1e-8 ... 1e-3 rad off change points of 1 to 40 four-bars.
PASSED, GAP_LIMIT_MIN, MAY_TEAR, MAY_MISS = 1e-4, 1e-10, 1e-8, 1e-5
# What rounding leaves in the balances, at any rtol: over the least pivot of a run, and at most, however near it came to
# singular positions; three times the worst of 420 runs of four-bars with windows, each over some twenty of them.
ROUNDED, MOST_ROUNDED, REGULAR = 3e-12, 5e-7, 1e-9
UNITS = 4.0  # of the last place of numbers, times the root of the steps: what rounding leaves of their difference
# Of the speed an observer sees, and of its square over the length: at 1e-8, the limit of rows, some fifty roundings.
UNKNOWN = 1e-6
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
        """Return whether the error is within its limit."""
        return bool(self.error <= self.limit)


def drift_limit(record: Record) -> float:
    """Return what errors of the steps may add up to, in the scales of the run: at most what explains or is useful."""
    explained = LOCAL * record.rtol * record.steps if record.method.dt is None and record.method.order else np.inf
    if record.nearest < NEAR_SINGULAR_SHARE:  # forces grow there, and with them what a step may err of their work
        explained = np.inf
    rounding = max(REGULAR, min(MOST_ROUNDED, ROUNDED / max(record.nearest, ROUNDED)))
    return min(DRIFT_LIMIT_MAX, max(min(ACCUMULATED_ERROR_FACTOR * record.rtol, explained), rounding))


def rounding_of(record: Record) -> float:
    """Return the rounding of a difference of sums over steps, relative to these numbers: a random walk."""
    return UNITS * np.finfo(float).eps * np.sqrt(max(record.steps, 1))


def gaping(record: Record) -> float:
    """Return the permitted gap of joints held by Baumgarte's terms; 0 if projection closes them."""
    return drift_limit(record) if record.switches.stabilisation == "baumgarte" else 0.0


@dataclass(frozen=True)
class Scales:
    """Characteristic sizes of a run that the absolute errors are divided by; never zero.

    They are the same for every observer: velocities count relative to each other and to their mean, positions from the
    centre of mass, and vectors by their Euclidean norm. ``reach`` and ``speed`` are as this observer sees them; they
    set the size of rounding, which is all that a body has of accelerations where it moves on at constant speed: below
    `UNKNOWN` of what velocities of this size may produce, nothing sets a scale.
    """

    rate: float  # 1/s
    acceleration: float
    force: float
    moment: float
    momentum: float
    angular_momentum: float
    energy: float
    reach: float  # m, from the origin
    speed: float  # m/s, absolute


def scales_of(solution: RunResult) -> Scales:
    """Return sizes from the run itself, with floors from gravity, so that a mechanism at rest has scales too.

    A piece between two events has the scales of the whole run.
    """
    if "scales" in solution.derived:
        return solution.derived["scales"]
    arrays, system, length = solution.arrays, solution.system, solution.compiled.model.length
    about, spin, g = solution.about_centre, longest(arrays["v"][..., 3:]), float(np.linalg.norm(system.gravity))
    seen = longest(arrays["v"][..., :3]) + length * spin
    speed = max(about.fastest, length * spin, solution.record.speed, UNKNOWN * seen)  # samples may all be at rest
    a = max(longest(arrays["acceleration"][..., :3]), g, length * spin * spin, UNKNOWN * seen * seen / length) or 1.0
    mass = system.total_mass() or 1.0
    momentum = mass * max(speed, 1e-3 * np.sqrt(a * length))
    speed = max(speed, np.sqrt(1e-3 * a * length))
    stored = (
        float(np.ptp(arrays["potential"].sum(axis=1))) if solution.t.size else 0.0
    )  # of springs: stiff ones hold more
    return Scales(
        rate=speed / length,
        acceleration=a,
        force=mass * a,
        moment=mass * a * length,
        momentum=momentum,
        angular_momentum=momentum * (length + about.farthest),
        energy=max(mass * speed * speed, stored),
        reach=longest(arrays["q"][..., :3]) + length,
        speed=seen,
    )


def largest(values: np.ndarray) -> float:
    """Return the largest absolute value of an array, 0 for an empty one."""
    return float(np.abs(values).max(initial=0.0))


def longest(vectors: np.ndarray) -> float:
    """Return the largest length of vectors (..., 3), 0 for none."""
    return float(np.sqrt((vectors**2).sum(axis=-1).max(initial=0.0)))
