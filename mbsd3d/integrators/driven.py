"""Fully driven systems: the pose by assembly at every sample, velocity and acceleration by linear solves."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..compiler.decorators import inner_kernel, kernel, late_kernel
from ..dynamics.state_rates import FACTOR_FROM_OTHER_POSE, PROJECTED, evaluate, project_and_evaluate
from ..dynamics.turning import TURN_MISS_MAX, compare_poses
from ..kernels.coordinates import miscount, remember
from ..kernels.kinematics import normalise
from ..kernels.layout import Data, Model
from ..kernels.vectors import add_scaled, clear, copy, finite
from ..solver.row_rank import independence
from ..solver.saddle_point import SOLVED
from .memory import DONE, FULL, NEW_TREE, NO_SOLUTION, NOT_CLOSING, RUNNING
from .method import Method, check_max_step
from .outputs import evaluate_start, first_crossing, halt, land, may_come_true, watch_on, write
from .step_control import (
    NEAR_SINGULAR_SHARE,
    full,
    hermite,
    next_turn,
    note_rows,
    pass_turn,
    rows_hold,
    update_scales,
    way_to_singular,
)

TURN_PER_POSE_MAX = 0.3  # [rad] from pose to pose: Newton's method stays on its branch
# [1] of the distance between poses from one to the next, or up to what was enough for the fastest turn so far
POSE_DISTANCE_GROWTH_MAX = 4.0
# [1] of a turn over the turn that the angular velocity at the new pose gives: above it the pose is on another branch
TURN_RATIO_MAX = 2.0
STEP_HALVINGS_MAX = 30  # [halvings] of the distance between poses before a mechanism counts as stuck
# [1] pivot, the square of a small angle: below it, velocities and accelerations are extrapolated from earlier poses
SINGULAR_PIVOT_MAX = 1e-6
SKIPPED_PIVOT_MAX = 1e-7  # [1] pivot below which the next pose may lie behind the singular one
EXTRAPOLATION_TURN = 1e-2  # [rad] between these poses: its square is far above rounding, its sixth power is not
# [1] f(0) = 6 f(-h) - 15 f(-2 h) + ...: exact to h^5
EXTRAPOLATION_WEIGHTS = np.array([6.0, -15.0, 20.0, -15.0, 6.0, -1.0])


class Extrapolated(NamedTuple):
    """Pose extrapolated from earlier ones."""

    y: np.ndarray
    dy: np.ndarray
    acceleration: np.ndarray  # (n, 6) world axes


@dataclass(frozen=True)
class Kinematic(Method):
    """No ODE: for systems whose drivers determine the whole motion (rank of the rows = 6 per body).

    Work, impulse and internal states of forces are integrated over the poses by the trapezoidal rule, of order 2: more
    samples or a smaller ``max_step`` make them as exact as needed. Nothing else depends on the distance of poses.
    ``max_step`` [s] limits the time between poses, so Newton's method stays on its branch. A stop condition is
    monitored between the poses too, on cubics through them.

    Examples
    --------
    >>> from mbsd3d import GROUND, AngleDriver, Body, Kinematic, Ramp, Revolute, System, simulate
    >>> arm = Body("arm", mass=2.0, inertia=(0.1, 0.1, 0.1), position=(0.5, 0, 0))
    >>> hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")
    >>> motor = AngleDriver(hinge, Ramp(3.0))
    >>> turn = simulate(System([arm], [hinge, motor]), 0.7, method=Kinematic(), output=8)
    >>> round(float(turn.angle(hinge)[-1]), 9), round(float(turn.acceleration(arm)[0, 0]), 9)  # w t, -l w^2
    (2.1, -4.5)
    """

    max_step: float = np.inf

    order = 0
    dt = None

    def __post_init__(self) -> None:
        check_max_step(self.max_step, "Kinematic")

    @property
    def loop(self) -> Callable:  # type: ignore[override]  # frozen, as a field is
        """Return the compiled loop over the output times."""
        return follow

    def start(self, model: Model, data: Callable[[type], Data]) -> Extrapolated:
        """Return the memory of the method for a run."""
        n, z = model.body.size, model.state.size
        return Extrapolated(np.zeros(13 * n + z), np.zeros(13 * n + z), np.zeros((n, 6)))


@inner_kernel
def predict(m, run, h):
    """Predict the next pose: y + h dy + h^2/2 d2y for positions, the rotation by its angular velocity."""
    n = m.body.shape[0]
    copy(run.trial, run.y)
    add_scaled(run.trial, h, run.dy)
    for i in range(n):
        for j in range(3):
            run.trial[7 * i + j] += 0.5 * h * h * run.dy[7 * n + 6 * i + j]


@inner_kernel
def advance_to(m, d, s, own, run, t, x, h):
    """Set the trial pose at t, x after the last one, on c = 0, with its velocities and accelerations.

    Work and internal states, predicted by the rate at the last pose, are corrected by the mean of both rates.
    """
    predict(m, run, x)
    status, result = project_and_evaluate(m, d, s, t, run.trial, run.trial_rate, FACTOR_FROM_OTHER_POSE)
    run.now.evaluations += 1
    if status != PROJECTED:
        return NOT_CLOSING
    if result != SOLVED or not finite(run.trial_rate):
        return NO_SOLUTION
    for i in range(13 * m.body.shape[0], run.trial.shape[0]):
        run.trial[i] += 0.5 * x * (run.trial_rate[i] - run.dy[i])
    if s.loop.shape[0] > 0 and s.state.dense == 0:
        s.state.pivot = independence(s)
    return RUNNING


@inner_kernel
def farthest(m, run):
    """Return the longest time [s] to the next pose: by TURN_PER_POSE_MAX, or half the way to a singular pose.

    Turns are h w + h^2/2 alpha of now, and no distance is more than GROWTH of the last one: a dead point tells little
    of what follows. Two branches nearly meet where a mechanism passes close by a singular pose: longer steps would come
    out on the other one, which no sample tells.
    """
    n, w, alpha = m.body.shape[0], 0.0, 0.0
    for i in range(n):
        u = 7 * n + 6 * i + 3
        w = max(w, np.sqrt(run.y[u] ** 2 + run.y[u + 1] ** 2 + run.y[u + 2] ** 2))
        alpha = max(alpha, abs(run.dy[u]), abs(run.dy[u + 1]), abs(run.dy[u + 2]))
    far = (
        TURN_PER_POSE_MAX if run.now.steps > 0 else EXTRAPOLATION_TURN
    )  # the first two poses say whether a singular one is ahead
    speed = w + np.sqrt(w * w + 2.0 * alpha * far)
    most = min(run.task.max_step, 2.0 * far / speed if speed > 0.0 else np.inf)
    if run.now.steps > 0 and run.now.turn > 0.0:
        most = min(most, max(POSE_DISTANCE_GROWTH_MAX * run.now.step, far / run.now.turn))
    if SKIPPED_PIVOT_MAX <= run.rows.pivot < NEAR_SINGULAR_SHARE and run.now.steps > 0:
        most = min(most, 2.0 * run.now.step)
    return min(most, 0.5 * run.rows.ahead) if run.rows.pivot >= SKIPPED_PIVOT_MAX else most


@inner_kernel
def poses_to(m, run, t):
    """Return the number of poses to visit until t."""
    return max(1, int(np.ceil((t - run.now.t) / farthest(m, run))))


@inner_kernel
def watch(m, d, s, run, t_new, h):
    """Return STOPPED, RUNNING or a failure: the run ends where the stop condition comes true before the trial pose."""
    if may_come_true(m, d, s, run, h, t_new):
        hermite(run, h, run.trial, run.dy, run.trial_rate)
        x = first_crossing(m, d, s, run, h, t_new)
        if x >= 0.0:
            status, t_stop = land(m, d, s, None, run, h, x * h, advance_to)
            return halt(m, d, s, run, t_stop) if status == RUNNING else status
    watch_on(m, d, s, run, t_new)
    evaluate(m, d, s, t_new, run.trial, run.work_rate)  # the work space belongs to the pose again
    return RUNNING


@inner_kernel
def end_turn(m, run, h):
    """Return the largest angle [rad] a body turns within h at its angular velocity in the trial pose."""
    n, fastest = m.body.shape[0], 0.0
    for i in range(n):
        u = 7 * n + 6 * i
        fastest = max(fastest, run.trial[u + 3] ** 2 + run.trial[u + 4] ** 2 + run.trial[u + 5] ** 2)
    return h * np.sqrt(fastest)


@inner_kernel
def next_pose(m, d, s, run, t_output):
    """Return (RUNNING, t_new) with the next pose on the way to t_output as trial, or (reason to stop, t_new).

    Nearer and nearer until its rows close and no body has turned further than expected.
    """
    t = run.now.t
    h = (t_output - t) / poses_to(m, run, t_output)
    t_new = t_output if h >= (1.0 - 1e-9) * (t_output - t) else t + h
    status = advance_to(m, d, s, None, run, t_new, h, h)
    for _ in range(STEP_HALVINGS_MAX):
        if (
            status == RUNNING
            and end_turn(m, run, h) <= TURN_RATIO_MAX * TURN_PER_POSE_MAX
            and miscount(m, d, t_new) <= TURN_MISS_MAX
        ):
            break
        h *= 0.5
        t_new = t + h
        run.now.rejected += 1
        status = advance_to(m, d, s, None, run, t_new, h, h)
    return status, t_new


@late_kernel
def extrapolate(m, d, s, own, run, t, apart) -> int:
    """Extrapolate trial and its rate to the singular pose at t from the poses at t - apart, t - 2 apart, ...

    There the rows determine neither along which branch the mechanism moves nor how fast: the motion before it does.
    """
    n = m.body.shape[0]
    clear(own.y)
    clear(own.dy)
    own.acceleration[:] = 0.0
    for k in range(EXTRAPOLATION_WEIGHTS.size, 0, -1):
        x = t - k * apart - run.now.t
        status = advance_to(m, d, s, None, run, run.now.t + x, x, x)
        if status != RUNNING:
            return status
        add_scaled(own.y, EXTRAPOLATION_WEIGHTS[k - 1], run.trial)
        add_scaled(own.dy, EXTRAPOLATION_WEIGHTS[k - 1], run.trial_rate)
        for i in range(n):
            add_scaled(own.acceleration[i], EXTRAPOLATION_WEIGHTS[k - 1], d.body[i].acceleration)
    copy(run.trial, own.y)
    normalise(m, run.trial)
    evaluate(m, d, s, t, run.trial, run.trial_rate)
    copy(run.trial_rate, own.dy)
    for i in range(n):
        copy(d.body[i].acceleration, own.acceleration[i])
    return RUNNING


@inner_kernel
def next_regular(m, d, s, own, run, t_output):
    """Find the next pose as `next_pose`, and a singular pose from those shortly before it, which are visited first."""
    status, t_new = next_pose(m, d, s, run, t_output)
    if status != RUNNING or t_new < t_output or s.state.pivot >= SINGULAR_PIVOT_MAX or run.now.turn == 0.0:
        return status, t_new
    apart = EXTRAPOLATION_TURN / run.now.turn
    first = t_new - (EXTRAPOLATION_WEIGHTS.size + 1) * apart
    if first < run.task.t_start:
        return status, t_new
    if first > run.now.t:
        return next_pose(m, d, s, run, first)
    return extrapolate(m, d, s, own, run, t_new, apart), t_new


@inner_kernel
def step(m, d, s, own, run, t_output):
    """Go to the next pose on the way to t_output; return RUNNING or a reason to return to Python."""
    status, t_new = next_regular(m, d, s, own, run, t_output)
    h, before = t_new - run.now.t, run.rows.pivot
    note_rows(s, run)
    run.now.step, run.rows.ahead = h, way_to_singular(before, run.rows.pivot, h)
    if status == RUNNING and run.task.condition >= 0:
        status = watch(m, d, s, run, t_new, h)
    if status != RUNNING:
        return status
    run.now.miscount = max(run.now.miscount, miscount(m, d, t_new))
    compare_poses(m, run, h)
    remember(m, d, t_new)
    update_scales(m, d, run)
    copy(run.y, run.trial)
    copy(run.dy, run.trial_rate)
    run.now.t = t_new
    run.now.steps += 1
    pass_turn(run)
    return RUNNING


@kernel
def follow(m, d, s, own, run, budget):
    """Visit the output times and the turns of signals; return DONE, RUNNING after `budget` poses, or a reason."""
    for _ in range(budget):
        if run.now.fresh > 0:
            status = evaluate_start(m, d, s, run)
            if status != RUNNING:
                return status
        if run.now.next_output >= run.times.shape[0]:
            return DONE
        if full(run):
            return FULL
        t_output = run.times[run.now.next_output]
        if run.now.t < t_output:
            status = step(m, d, s, own, run, min(t_output, next_turn(run)))
            if status != RUNNING:
                return status
        if run.now.t >= t_output and run.now.fresh == 0:
            write(m, d, s, run, t_output, run.y)
            run.now.next_output += 1
        if not rows_hold(m, d, s, run):
            return NEW_TREE
    return RUNNING
