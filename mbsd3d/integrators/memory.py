"""Memory of a run: its task, the output of the time loop, and its reasons to return to Python."""

from typing import NamedTuple

import numpy as np

from ..compiler.arguments import by_reference
from ..kernels.layout import single, table

RUNNING, DONE, STOPPED, FULL, NEW_TREE, STEP_TOO_SMALL, NOT_CLOSING, NO_SOLUTION = range(8)
NOT_CONVERGED, STIFF = 8, 9

TASK = [  # constant during the run
    ("t_start", float),  # s
    ("t_end", float),  # s
    ("steps", int),  # number of equal steps from t_start to t_end, 0 = adaptive
    ("first_step", float),  # s, the first one tried
    ("max_step", float),  # s
    ("rtol", float),
    ("tolerance", float),  # within which rows left out may be violated, in model lengths and radians
    ("every_step", int),  # 1: every accepted step is a sample
    ("condition", int),  # measure of the condition at hand, -1 = none,
    ("stop", float),  # the value it must reach,
    ("direction", float),  # 1: from below, -1: from above
    ("slack", float),  # within which the measure counts as that value
]
WATCH = [  # conditions that end the run, each with its own of the fields above and below
    ("measure", int),
    ("stop", float),
    ("direction", float),
    ("slack", float),
    ("hop", float),  # s
    ("armed", int),
    ("suspect", int),  # 1: it may come true in the step at hand
]
NOW = [
    ("t", float),  # s, time of the state y
    ("step", float),  # s, length of the next step to be tried
    ("speed", float),  # m/s, greatest so far, relative to the mean of all bodies: scale of velocity errors
    ("fastest", float),  # m/s, the greatest that there was; `speed` is never less than the start leads to expect
    ("turn", float),  # rad/s, greatest angular velocity so far
    ("miscount", float),  # rad, the most that a hinge has turned in a step otherwise than by the mean of its rates
    ("missed", float),  # rad, the most that a body has turned otherwise than by its angular velocity: turning.py
    ("farthest", float),  # rad, the farthest that a body has turned in a step
    ("missed_by", int),  # the body that missed most,
    ("farthest_by", int),  # and the one that turned farthest
    ("steps", int),  # accepted
    ("grid", int),  # of the equal steps those that are done: a signal that turns splits one
    ("rejected", int),
    ("evaluations", int),
    ("longest", float),  # s, of the next step, where contacts in the air turn, touch or lift off: contact_steps.py
    ("jump", float),  # what velocities change in fixed steps in which bodies touch, over the greatest, added up,
    ("jump_most", float),  # the most in one of them,
    ("jump_by", int),  # and its force
    ("overlap", float),  # the deepest of a sphere in a sphere or a round bar, over the sum of the radii,
    ("overlap_by", int),  # and its force
    ("fresh", int),  # nothing has been evaluated since: 1, the tree is new; 2, a signal has jumped
    ("forced", int),  # 1: the step at hand has the least length, as over a jump of a force; 2: the last one had
    ("retried", int),  # 1: the step at hand has been rejected before: it may not grow
    ("spinning", int),  # bodies whose spin is taken out of the step at hand: spinning.py
    ("rotating", int),  # 1: the dense output of the step at hand holds rotation vectors: outputs.py
    ("written", int),  # samples in the buffer
    ("inside", int),  # samples of the step at hand, where every step is one
    ("next_output", int),  # index of the next output time
    ("next_turn", int),  # index of the next time at which a signal turns
    ("hop", float),  # s, after which the condition comes true that a run starts from, if the measure does not show it
    ("armed", int),  # 1: the condition has been false since the start, so that it can come true
    ("fired", int),  # number of the condition that has come true, -1 = none
    ("rates", int),  # at the ends of equal steps that are known: auditing.py,
    ("audited", float),  # s, their length
    ("open_work", float),  # J, the most by which two quadratures of fixed steps differ,
    ("open_push", float),  # N s, of the impulse of external forces,
    ("open_turn", float),  # N m s, of their angular impulse about the centre of mass
]
ROWS = [
    ("pivot", float),  # smallest pivot of the loop rows over the largest it has been, at the end of the last step
    ("ahead", float),  # s, from there to where it would vanish (Runge-Kutta methods)
    ("planned", float),  # s, length of a step before it was shortened to pass over that position; 0 = it was not
    ("missed", float),  # error of the last step over that position that was rejected; 0 = none was
    ("worn", int),  # 1: rows of a joint have become dependent there: another tree is due
    ("lowest", float),  # the least at the end of any step and at any sample
    ("least_pivot", float),  # the least of all stages of the step at hand
    ("residual", float),  # largest scaled |c| of the rows left out
    ("on_manifold", int),  # 1: stages are projected, since the rows are nearly dependent
]
STIFFNESS = [
    ("suspicious", int),  # tests that found stability to limit the step
    ("calm", int),  # tests in a row that did not
    ("patience", float),  # steps times bodies that such a run may still need; inf = any number
]


NO_SIGNAL_KNOTS = np.zeros((0, 2))
NONE = np.zeros((0, 3), np.int64)


@by_reference
class Run(NamedTuple):
    """Memory of one run, written in place by the time loop; records have the fields of the tables above."""

    y: np.ndarray  # (ny,) state (q, u, z) at now.t
    dy: np.ndarray  # (ny,) its rate
    trial: np.ndarray  # (ny,) state at the end of the step being tried
    trial_rate: np.ndarray  # (ny,) its rate
    work: np.ndarray  # (ny,) stage or sample state
    work_rate: np.ndarray  # (ny,)
    unit: np.ndarray  # (nz,) what errors of the states z are measured in, at the greatest speed so far
    spin: np.ndarray  # (n, 3) rad/s, of each body, body axes
    missed: np.ndarray  # (n, 4) rad, by how much each body has turned otherwise than by its angular velocity, world
    # axes, and what `compare_poses` allowed it in the last step
    F: np.ndarray  # (terms, ny) dense output of the last step
    task: np.record  # TASK
    now: np.record  # NOW
    rows: np.record  # ROWS
    watch: np.ndarray  # (k,) WATCH
    stiffness: np.record  # STIFFNESS
    times: np.ndarray  # (requested,) output times
    turns: np.ndarray  # (k, 2) where signals turn: the time [s] at which a step ends, and from which the next one goes
    # on, a rounding later where a second derivative jumps
    contacts: np.ndarray  # (k, 3) forces that touch and lift off: see `contact_steps.watched_gaps`
    gaps: np.ndarray  # (k, 2, 5) at both ends of the step: clearance [m], its rate, angular velocity that counts, the
    # load that there would be if it could pull, and the overlap of round bodies over the sum of their radii
    out: np.ndarray  # (capacity, width) samples: t, y, accelerations (6n), lam (m), hinge coordinates, potential and
    # power of the forces, largest |c| and |J v - b| over all rows
    audit: np.ndarray  # (6, audit states) of fixed steps: integrals, errors of theirs, last rates: auditing.py


def allocate_run(
    y: np.ndarray, bodies: int, times: np.ndarray, capacity: int, width: int, terms: int,
    turns: np.ndarray = NO_SIGNAL_KNOTS, contacts: np.ndarray = NONE, audits: int = 6,
    conditions: int = 0,
) -> Run:  # fmt: skip
    """Allocate the memory of a run that starts at y; the fields of its records are zero."""
    dy, trial, trial_rate, work, work_rate = np.zeros((5, y.size))
    return Run(
        y=y, dy=dy, trial=trial, trial_rate=trial_rate, work=work, work_rate=work_rate,
        unit=np.zeros(y.size - 13 * bodies), spin=np.zeros((bodies, 3)), missed=np.zeros((bodies, 4)),
        F=np.zeros((terms, y.size)),
        task=single(TASK), now=single(NOW), rows=single(ROWS), watch=table(WATCH, conditions),
        stiffness=single(STIFFNESS),
        times=times, turns=turns, contacts=contacts, gaps=np.zeros((len(contacts), 2, 5)),
        out=np.zeros((capacity, width)), audit=np.zeros((6, audits)),
    )  # fmt: skip


@by_reference
class Table(NamedTuple):
    """Butcher table of an explicit method with n stages; the rate at the end of the step is stage n + 1."""

    A: np.ndarray  # (n, n)
    b: np.ndarray  # (n,)
    c: np.ndarray  # (n,)
    error: np.ndarray  # (3, n) weights of the error estimates; zero where steps are fixed
    A_dense: np.ndarray  # (extra, n + 1 + extra) extra stages of the dense output
    c_dense: np.ndarray  # (extra,)
    D: np.ndarray  # (terms, n + 1 + extra) beyond the cubic Hermite terms
    order: int
    gap: tuple[float, float]  # two neighbours among the nodes c between which no stage lies: the widest gap


def widest_gap(c: np.ndarray) -> tuple[float, float]:
    """Return the two neighbouring nodes that are farthest apart."""
    nodes = np.sort(c)
    k = int(np.argmax(np.diff(nodes)))
    return float(nodes[k]), float(nodes[k + 1])


@by_reference
class Stages(NamedTuple):
    """Table of a method and its own memory."""

    table: Table
    K: np.ndarray  # (n + 1 + extra, ny) stage rates
    carry: np.ndarray  # (ny,) what rounding cut off y: unstable motions amplify it by up to 1e9
    trial_carry: np.ndarray  # (ny,) the same of trial


def new_stages(table: Table, ny: int) -> Stages:
    """Allocate the memory for states of ny numbers."""
    stages = table.c.size + 1 + table.c_dense.size
    return Stages(table, np.zeros((stages, ny)), np.zeros(ny), np.zeros(ny))
