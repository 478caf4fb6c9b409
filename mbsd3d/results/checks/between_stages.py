"""Effects that act unseen between the stages of steps: user forces that jump, fast sines, short contacts."""

from typing import NamedTuple

import numpy as np

from ...equations.tables import signals_of
from ...mechanism.forces.custom import FunctionForce
from ...mechanism.signals.terms import SINE
from ..result import RunResult
from .check import Check

TOUCHES = "contacts"  # the check of them
OVERLAP_MAX = 0.5  # [1] of a sphere in a sphere or bar, over the sum of radii: past the centre it is pushed out behind
STEPS_PER_PERIOD_MIN = 10  # [1] fixed steps in a period of a sine, for a resolved one
TOUCH_CHANGE_MAX = 0.01  # [1] of the velocities, in all fixed steps in which bodies touch: when is open by up to a step
PERIODS_PER_STEP_MAX = 0.5  # [1] of a sine in a fixed step: beyond, the stages may all see one phase (Nyquist)


class FastSine(NamedTuple):
    """Sine of a force or driver that fixed steps barely resolve."""

    part: str
    period: float  # s


def unwatched(solution: RunResult) -> list[FunctionForce]:
    """Return the forces given by functions for which the step length is not limited."""
    if solution.record.kinematic or solution.record.method.max_step < np.inf:
        return []  # poses follow from drivers
    forces = [force for force in solution.system.forces if isinstance(force, FunctionForce)]
    return [force for force in forces if force.max_step == np.inf]


def fast_sines(solution: RunResult) -> list[FastSine]:
    """Return the sines with fewer than STEPS_PER_PERIOD_MIN fixed steps per period."""
    dt = solution.record.method.dt
    if dt is None or solution.record.kinematic:
        return []  # adaptive steps follow them
    found = []
    for part, signal in signals_of(solution.system):
        for term in signal.terms():
            amplitude, rate = term.data[:2] if term.kind == SINE else (0.0, 0.0)
            if amplitude != 0.0 and abs(rate) * dt * STEPS_PER_PERIOD_MIN > 2.0 * np.pi:
                found.append(FastSine(solution.system.name(part), 2.0 * np.pi / abs(rate)))
    return list(dict.fromkeys(found))


def signal_checks(solution: RunResult) -> list[Check]:
    """Return the check of sines that fixed steps cannot follow; none where all are resolved."""
    sines, dt = fast_sines(solution), solution.record.method.dt
    if not sines or dt is None:
        return []
    fastest = min(sines, key=lambda sine: sine.period)
    periods = dt / fastest.period
    return [Check("signals", periods, PERIODS_PER_STEP_MAX, f"'{fastest.part}' swings within a step; shorten dt")]


def touch_checks(solution: RunResult) -> list[Check]:
    """Return the check of contacts and stops whose load changed the velocities within implicit fixed steps."""
    record = solution.record
    if record.jump == 0.0:
        return []
    meaning = f"'{record.jump_by}' presses from somewhere within a step on; shorten dt, or use adaptive steps"
    return [Check(TOUCHES, record.jump, TOUCH_CHANGE_MAX, meaning)]


def overlap_checks(solution: RunResult) -> list[Check]:
    """Return the check of spheres so deep in a sphere or a bar that the contact may let them through."""
    record = solution.record
    if record.overlap == 0.0:
        return []
    meaning = f"'{record.overlap_by}' is too soft and lets bodies through; raise its stiffness"
    return [Check("overlap", record.overlap, OVERLAP_MAX, meaning)]


def unseen_parts(solution: RunResult) -> list[str]:
    """Return the names of the parts whose action the stages of steps may miss."""
    forces = [solution.system.name(force) for force in unwatched(solution)]
    return [*forces, *(sine.part for sine in fast_sines(solution))]


def stage_notes(solution: RunResult) -> list[str]:
    """State which forces and signals were not monitored between stages, and the remedy."""
    return [
        f"force '{solution.system.name(force)}' was not looked for between the stages of steps"
        f"{', but at its times' if force.times else ''}: what it does for a shorter time is stepped over; give it "
        "max_step=, the shortest time it acts, or times= at which it jumps"
        for force in unwatched(solution)
    ] + [
        f"'{sine.part}' swings faster than the steps: its Sine has a period of {sine.period:.3g} s, and a step is "
        f"{solution.record.method.dt:.3g} s long; shorten dt to 1/{STEPS_PER_PERIOD_MIN} of the period"
        for sine in fast_sines(solution)
    ]
