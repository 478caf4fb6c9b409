"""Event times: kinks of signals; whether a stop condition can become true at once; and how fast a
motion is at its start."""

import numpy as np

from ..base.errors import InputError
from ..dynamics.state_rates import FACTOR_FROM_OTHER_POSE, evaluate, project_and_evaluate
from ..equations.compiled import Compiled
from ..integrators.memory import Run
from ..kernels.kinds import SINE, SPLINE
from ..kernels.kinematics import kinematics
from ..kernels.layout import Data, Model, Tree
from ..kernels.measures import measure
from ..mechanism.measures import HOLDING_MEASURES, UNIT_EXPONENTS, Condition
from ..mechanism.signals.terms import turning_times

EVENT_TIME_ROUNDING = 1e-15  # [1] of the time: a stage at the end of a step that ends nearer may fall behind a jump
EVENT_VALUE_TOLERANCE = 1e-9  # [1] of the scale of a measure: by less it has the value of a condition
START_UNCERTAINTY_MAX = 1e-2  # rad that the motion turns between two times next to each other at the end of a run
LOW = 1e-3  # of that is a hop whose time is taken from its rates; it errs less so than by the digits of the measure
FIRST_STEP_SHARE = 1e-3  # [1] of the first step, within which the rate changes evenly
WAVE_SHARE = 1.0 / 32.0  # [1] of a period: between two steps a load turns back by 1 - cos(pi / 32) = 0.5 % at most
TINY = 1e-40  # of a complex step: its square vanishes


def turns_of_signals(model: Model, t_start: float) -> np.ndarray:
    """Return times (k, 2) [s], sorted, at which a table or a pulse turns: the end of a step, and the start of the next.

    Where a second derivative jumps, as that of a pulse does, the step ends before by a rounding: a driver would read
    the acceleration behind the jump there.
    """
    found: list[tuple[float, float]] = []
    if not model.term.size:
        return np.zeros((0, 2))
    for x in model.term[model.term["kind"] == SPLINE]:
        times, jumps = turning_times(model.term_data[x["first"] : x["end"]])
        found += zip(times - jumps * EVENT_TIME_ROUNDING * np.maximum(np.abs(times), abs(t_start)), times, strict=True)
    return np.array(sorted(found), float).reshape(-1, 2)


def step_that_sees_waves(model: Model) -> float:
    """Return the longest step [s] that sees the loads of sines pass a limit, also where nothing moves."""
    sines = model.term[model.term["kind"] == SINE]
    fastest = float(np.abs(model.term_data[sines["first"] + 1]).max(initial=0.0))  # rad/s
    return WAVE_SHARE * 2.0 * np.pi / fastest if fastest > 0.0 else np.inf


def armed_at_start(
    compiled: Compiled, data: Data, tree: Tree, run: Run, k: int, stop_when: Condition, slack: float, may_hold: bool
) -> tuple[int, float, float]:  # fmt: skip
    """Return (1 if condition k is false at the start or becomes so at once, else 0; the slack of its value; hop time).

    A run may start where the measure has the value already, as one does that goes on after an event: then the sign of
    its rate says whether the condition becomes false or true there. Where it becomes true, or where nothing moves, the
    condition is not armed before the measure has left the value to the side where the condition is false. A hop away
    and back, as of a ball that bounces ever lower, may be less than the digits of the measure: its rates tell its time.
    The load of what holds is watched from the start: it may begin at its limit and grow beyond it.

    Raises
    ------
    ValueError
        If the condition is already true by more than the slack, unless ``may_hold``: then it is not armed.
    """
    model, t = compiled.model, float(run.now.t)
    now = value_at(compiled, data, tree, t, run.y, k)
    gap = stop_when.direction * (now - stop_when.value)
    if stop_when.measure.kind in HOLDING_MEASURES:
        return 1, slack, 0.0
    if gap > slack and may_hold:
        return 0, slack, 0.0
    if gap > slack:
        raise InputError(
            f"simulate: stop_when: {stop_when} holds already at the start ({now:.6g}); "
            "give another value or another start"
        )
    if gap < -slack:
        return 1, slack, 0.0
    soon = FIRST_STEP_SHARE * float(run.now.step)
    rate = stop_when.direction * rate_of_measure(compiled, data, tree, t, run.y, run.dy, soon, k)
    y, dy = run.y + FIRST_STEP_SHARE * run.now.step * run.dy, run.dy.copy()
    project_and_evaluate(model, data, tree, t + soon, y, dy, FACTOR_FROM_OTHER_POSE)
    back = (stop_when.direction * rate_of_measure(compiled, data, tree, t + soon, y, dy, soon, k) - rate) / soon
    low = rate < 0.0 < back and 0.5 * rate * rate < LOW * slack * back
    return int(rate < 0.0), slack, -2.0 * rate / back if low else 0.0


def comes_true_at_start(
    compiled: Compiled, data: Data, tree: Tree, run: Run, k: int, condition: Condition, slack: float
) -> bool:  # fmt: skip
    """Return whether condition k holds at the start by more than the slack, or within it and soon by more."""
    t = float(run.now.t)
    gap = condition.direction * (value_at(compiled, data, tree, t, run.y, k) - condition.value)
    if abs(gap) > slack:
        return gap > 0.0
    soon = FIRST_STEP_SHARE * float(run.now.step)
    rate = condition.direction * rate_of_measure(compiled, data, tree, t, run.y, run.dy, soon, k)
    return rate * (float(run.task.t_end) - t) > slack


def slack_of(condition: Condition, length: float, speed: float) -> float:
    """Return the tolerance of the value of a condition, for a model of a length [m] and a speed [m/s]."""
    of_length, of_speed = UNIT_EXPONENTS[condition.measure.unit]
    return EVENT_VALUE_TOLERANCE * max(abs(condition.value), length**of_length * speed**of_speed)


def value_at(compiled: Compiled, data: Data, tree: Tree, t: float, y: np.ndarray, k: int) -> float:
    """Return measure k at a state; for a reaction the equations are solved."""
    model = compiled.model
    if model.measure["rows"][k] > 0:
        evaluate(model, data, tree, t, y, np.empty_like(y))
    else:
        kinematics(model, data, y)
    return float(measure(model, data, k, t))


def rate_of_measure(
    compiled: Compiled, data: Data, tree: Tree, t: float, y: np.ndarray, dy: np.ndarray, apart: float, k: int
) -> float:  # fmt: skip
    """Return the rate of measure k at a state with its rate, exact to rounding: a complex step along the motion.

    Of a reaction by a central difference over the time ``apart``, since its tree is one of real numbers.
    """
    if compiled.model.measure["rows"][k] > 0:
        ahead, behind = (value_at(compiled, data, tree, t + h, y + h * dy, k) for h in (apart, -apart))
        return (ahead - behind) / (2.0 * apart)
    varied = compiled.data(complex)
    varied.coordinate[:], varied.unwrap_time[:] = data.coordinate, data.unwrap_time
    kinematics(compiled.model, varied, y + 1j * TINY * dy)
    return float(np.imag(measure(compiled.model, varied, k, t))) / TINY


def check_digits(t_end: float, rate: float) -> None:
    """Raise an InputError for an end so late that rounding of the time hides the motion."""
    apart = float(np.spacing(abs(t_end)))  # NaN for a run without end
    if rate * apart > START_UNCERTAINTY_MAX:
        raise InputError(
            f"simulate: t_end = {t_end:g} s: times there are {apart:.0e} s apart, too far for this motion; give an "
            "earlier end"
        )
