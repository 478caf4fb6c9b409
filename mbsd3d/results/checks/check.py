"""One check, the limits of errors that accumulate over a run, and the scales that errors are divided by."""

from dataclasses import dataclass

import numpy as np

from ...integrators.step_control import NEAR_SINGULAR_SHARE
from ...mechanism.forces.custom import SavedForce
from ..element_loads import load_of
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
LOCAL = 10.0  # times rtol a step: a hundred times what it may err
# [1] of a speed that all share and of forces in balance: no motion below it is told from their rounding, which stays
# below 1e-8 of it; and of the model's length: accelerations that move nothing as far in a run are those of rest
UNSEEN_SHARE, UNMOVED_SHARE = 1e-5, 1e-6


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
    set the size of rounding.
    """

    rate: float  # 1/s
    acceleration: float
    least: float  # m/s^2, of gravity, of spins, of what is in balance: not of light bodies that rounding moves
    force: float
    moment: float
    momentum: float
    angular_momentum: float
    energy: float
    reach: float  # m, from the origin
    speed: float  # m/s, absolute


def scales_of(solution: RunResult, known: float | None = None) -> Scales:
    """Return sizes from the run itself, with floors from gravity, forces in balance and the speed that all share.

    So a mechanism at rest has scales too. A piece between two events has the scales of the whole run. ``known``: the
    least acceleration by the samples, where the start stands before them and forces are not known.
    """
    if "scales" in solution.derived:
        return solution.derived["scales"]
    arrays, system, length = solution.arrays, solution.system, solution.compiled.model.length
    about, spin, g = solution.about_centre, longest(arrays["v"][..., 3:]), float(np.linalg.norm(system.gravity))
    carried = longest(arrays["v"][..., :3]) + length * spin
    unseen = UNSEEN_SHARE * carried
    speed = max(about.fastest, length * spin, solution.record.speed, unseen)  # samples may all be of a machine at rest
    mass, span = system.total_mass() or 1.0, float(solution.t[-1] - solution.start.t) if solution.t.size else 0.0
    moved, least = longest(arrays["acceleration"][..., :3]), max(g, length * spin * spin, known or 0.0)
    if known is None and max(moved, least) * span**2 < UNMOVED_SHARE * length:
        least = max(least, UNSEEN_SHARE * largest_force(solution) / mass, unseen * unseen / length)
    a = max(moved, least) or 1.0
    momentum = mass * max(speed, 1e-3 * np.sqrt(a * length))
    speed = max(speed, np.sqrt(1e-3 * a * length))
    # of springs: stiff ones hold more
    stored = float(np.ptp(arrays["potential"].sum(axis=1))) if solution.t.size else 0.0
    return Scales(
        rate=speed / length,
        acceleration=a,
        least=least,
        force=mass * a,
        moment=mass * a * length,
        momentum=momentum,
        angular_momentum=momentum * (length + about.farthest),
        energy=max(mass * speed * speed, stored),
        reach=longest(arrays["q"][..., :3]) + length,
        speed=carried,
    )


def largest_force(solution: RunResult) -> float:
    """Return the largest force of a force element at a sample [N]; a moment counts at the model's length."""
    known = [force for force in solution.system.forces if not isinstance(force, SavedForce)]
    loads = [load_of(solution, force) for force in known]
    length = solution.compiled.model.length
    return max((max(longest(load.force), longest(load.moment) / length) for load in loads), default=0.0)


def largest(values: np.ndarray) -> float:
    """Return the largest absolute value of an array, 0 for an empty one."""
    return float(np.abs(values).max(initial=0.0))


def longest(vectors: np.ndarray) -> float:
    """Return the largest length of vectors (..., 3), 0 for none."""
    return float(np.sqrt((vectors**2).sum(axis=-1).max(initial=0.0)))
