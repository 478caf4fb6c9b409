"""What errors of a step are measured against: the model's length, a radian, the greatest speeds so far."""

import numpy as np

from ..kernels.jit import inner_kernel
from .base import RTOL, SPEED, TURN

ROUNDING = 1e-15  # of a work or an impulse is what a step may always err: less cannot be had
LOCAL = 0.1  # of rtol is what a single step may err, since errors add up over a run


@inner_kernel
def references(m, d, run):
    """Greatest speed relative to the mean and greatest angular velocity so far: the scales of velocity errors."""
    n = m.body.shape[0]
    x, y, z = 0.0, 0.0, 0.0
    for i in range(n):
        v = d.body[i].velocity
        x, y, z = x + v[0] / n, y + v[1] / n, z + v[2] / n
    for i in range(n):
        v, w = d.body[i].velocity, d.body[i].w
        speed = np.sqrt((v[0] - x) ** 2 + (v[1] - y) ** 2 + (v[2] - z) ** 2)
        turn = np.sqrt(w[0] ** 2 + w[1] ** 2 + w[2] ** 2)
        run.clock[SPEED] = max(run.clock[SPEED], speed, m.length * turn)
        run.clock[TURN] = max(run.clock[TURN], turn)


@inner_kernel
def state_error(m, run):
    """Greatest square in run.work over bodies and states: |dr|/L, angle, |dv|, |dw|, z, in their scales."""
    n = m.body.shape[0]
    speed, turn = run.clock[SPEED], run.clock[TURN]
    worst = 0.0
    for i in range(n):
        q, u = 7 * i, 7 * n + 6 * i
        x = run.work
        shift = (x[q] ** 2 + x[q + 1] ** 2 + x[q + 2] ** 2) / m.length**2
        angle = 4.0 * (x[q + 3] ** 2 + x[q + 4] ** 2 + x[q + 5] ** 2 + x[q + 6] ** 2)
        linear = (x[u] ** 2 + x[u + 1] ** 2 + x[u + 2] ** 2) / speed**2
        angular = (x[u + 3] ** 2 + x[u + 4] ** 2 + x[u + 5] ** 2) / turn**2
        worst = max(worst, shift, angle, linear, angular)
        if not np.isfinite(shift + angle + linear + angular):
            return np.inf
    for j in range(m.state.shape[0]):
        scale = m.state[j].unit * speed ** m.state[j].power
        least = 1.0 if j < m.z_work else ROUNDING / (LOCAL * run.clock[RTOL])  # own states come in any size
        scale = max(scale, least * abs(run.y[13 * n + j]))
        error = (run.work[13 * n + j] / scale) ** 2
        if not np.isfinite(error):
            return np.inf
        worst = max(worst, error)
    return worst
