"""When a stop condition comes true within a step: whether it may, where it does, and the end of the run there."""

import numpy as np

from ..kernels.coordinates import remember
from ..kernels.dynamics import evaluate
from ..kernels.jit import inner_kernel, merged_kernel
from ..kernels.kinematics import kinematics
from ..kernels.probes import measure
from ..kernels.vectors import add_scaled, copy
from .base import CONDITION, SIGN, STEPS, STOP, STOPPED, T, interpolate, write

LANDINGS = 6  # Newton steps to the time of an event, each a step of the method; the first is good to its dense output
SCAN = 8  # parts of a step that are searched for an event
GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)


@inner_kernel
def condition(m, d, run, t, y):
    """Signed distance of the stop condition: it holds when this is >= 0."""
    kinematics(m, d, y)
    return run.clock[SIGN] * (measure(m, d, run.count[CONDITION], t) - run.clock[STOP])


@inner_kernel
def slope(m, d, run, t, y, dy, h):
    """Rate of the condition at (t, y), by a forward difference along the motion; work is overwritten."""
    dt = 1e-6 * h
    copy(run.work, y)
    add_scaled(run.work, dt, dy)
    later = condition(m, d, run, t + dt, run.work)
    return (later - condition(m, d, run, t, y)) / dt


@merged_kernel
def may_come_true(m, d, run, h, t_new, dy_new):
    """True if the condition holds at the end of the step, or rises at its start and falls at its end."""
    if condition(m, d, run, t_new, run.trial) >= 0.0:
        return True
    rises = slope(m, d, run, run.clock[T], run.y, run.dy, h) > 0.0
    return rises and slope(m, d, run, t_new, run.trial, dy_new, h) < 0.0


@inner_kernel
def condition_inside(m, d, run, h, x):
    """The condition by dense output at the fraction x of the step."""
    interpolate(run, x, run.work)
    return condition(m, d, run, run.clock[T] + x * h, run.work)


@inner_kernel
def locate(m, d, run, h, low, high):
    """Fraction of the step at which the condition comes true between low and high, by bisection."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        if condition_inside(m, d, run, h, middle) >= 0.0:
            high = middle
        else:
            low = middle
        if high - low < 1e-15:
            break
    return high


@merged_kernel
def first_crossing(m, d, run, h, t_new):
    """Fraction of the step at which the condition first comes true, by dense output; -1 if it does not.

    Looked for at SCAN points and at the peak between them: two peaks less than h/SCAN apart may pass for one.
    """
    place, greatest = 0.0, -np.inf
    for k in range(1, SCAN + 1):
        x = k / SCAN
        g = condition_inside(m, d, run, h, x) if k < SCAN else condition(m, d, run, t_new, run.trial)
        if g >= 0.0:
            return locate(m, d, run, h, (k - 1) / SCAN, x)
        if g > greatest:
            place, greatest = x, g
    low, high = max(0.0, place - 1.0 / SCAN), min(1.0, place + 1.0 / SCAN)
    for _ in range(60):  # golden section
        x, x_high = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        g, g_high = condition_inside(m, d, run, h, x), condition_inside(m, d, run, h, x_high)
        if max(g, g_high) >= 0.0:
            return locate(m, d, run, h, low, x if g >= 0.0 else x_high)
        if g > g_high:
            high = x_high
        else:
            low = x
    return -1.0


@merged_kernel
def missing_time(m, d, run, h, t, dy):
    """Time from t until the condition comes true, by Newton from trial and its rate; 0 where that leads astray."""
    dt = -condition(m, d, run, t, run.trial) / slope(m, d, run, t, run.trial, dy, h)
    return dt if abs(dt) <= 0.1 * h else 0.0


@merged_kernel
def halt(m, d, s, run, t):
    """End the run at t, where trial has been accepted as the state at which the condition comes true."""
    evaluate(m, d, s, t, run.trial, run.dy)
    write(m, d, run, t, run.trial)
    remember(m, d, t)
    copy(run.y, run.trial)
    run.clock[T] = t
    run.count[STEPS] += 1
    return STOPPED
