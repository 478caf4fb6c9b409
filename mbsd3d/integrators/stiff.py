"""Stiffness seen by an explicit method: fast motion that is too small to matter and yet limits the step."""

import numpy as np

from ..kernels.jit import inner_kernel
from ..kernels.vectors import add_scaled, clear, copy
from .base import CALM_TESTS, STEPS, STIFF_TESTS, T_END, T
from .scales import state_error

FAST = 3.4  # h |lambda| above which a motion passes unseen only below some hundred tolerances; stability ends at 6.1
TEST_EVERY = 32  # steps are tested for stiffness; each one from the first suspicion until CALM tests in a row pass
SUSPICIOUS, CALM = 15, 6


@inner_kernel
def fastest_rate(m, table, run, h):
    """h |lambda| from the last stage Y and the end y of the step, both at t + h: h |f(y) - f(Y)| / |y - Y|."""
    n = table.c.shape[0]
    clear(run.work)
    for j in range(n):
        add_scaled(run.work, h * (table.b[j] - table.A[n - 1, j]), run.K[j])
    apart = state_error(m, run)
    copy(run.work, run.K[n])
    add_scaled(run.work, -1.0, run.K[n - 1])
    return h * np.sqrt(state_error(m, run) / apart) if apart > 0.0 else 0.0


@inner_kernel
def is_stiff(m, table, run, h):
    """True where stability limits the step again and again, and the rest of the run would exceed the patience."""
    if run.count[STIFF_TESTS] == 0 and run.count[STEPS] % TEST_EVERY > 0:
        return False
    if fastest_rate(m, table, run, h) > FAST:
        run.count[STIFF_TESTS] += 1
        run.count[CALM_TESTS] = 0
    else:
        run.count[CALM_TESTS] += 1
        if run.count[CALM_TESTS] == CALM:
            run.count[STIFF_TESTS] = 0
            run.count[CALM_TESTS] = 0
    left = (run.clock[T_END] - run.clock[T]) / h * m.body.shape[0]
    return run.count[STIFF_TESTS] >= SUSPICIOUS and left > table.patience
