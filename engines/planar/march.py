"""Compiled planar motion: Runge-Kutta with projection, and kinematics of driven systems."""

import numpy as np

from engines.planar.rows import inner, kernel, put, rates, rows
from engines.planar.saddle import accelerations, factor, solve

DONE, SINGULAR, NOT_CLOSED, NOT_FINITE = range(4)
CLOSURE_TARGET, CLOSURE_MAX = 1e-14, 1e-9  # residuals [m, rad] over the size of the system: aimed at, refused
SUBSTEP_ANGLE = 0.1  # [rad] predicted rotation of any body between two positions of `trace`


@inner
def largest(w):
    """Return the largest residual and its row."""
    worst, row = 0.0, 0
    for i in range(w.c.shape[0]):
        size = abs(w.c[i])
        if not size <= worst:
            worst, row = size, i
        if not np.isfinite(size):
            break
    return worst, row


@inner
def add(y, factor, x):
    """Add factor x to y, body by body."""
    for i in range(y.shape[0] - 1):
        for k in range(3):
            y[i, k] += factor * x[i, k]


@inner
def right_side(m, w, values, v):
    """Compute lam := values - J v, without loads."""
    for i in range(w.top.shape[0] - 1):
        put(w.top[i], 0.0, 0.0, 0.0)
    for i in range(values.shape[0]):
        w.lam[m.place[i]] = values[i]
    for e in range(m.entry.shape[0]):
        J, x = w.J[m.entry[e, 0]], v[m.entry[e, 2]]
        w.lam[m.entry[e, 1]] -= J[0] * x[0] + J[1] * x[1] + J[2] * x[2]


@kernel
def close(m, w, t, q):
    """Solve c(q, t) = 0 by Newton in the metric of M, leaving rows and factor there; return (status, row)."""
    before = np.inf
    for _ in range(25):
        rows(m, w, t, q)
        worst, row = largest(w)
        bad = factor(m, w)
        if not np.isfinite(worst):
            return NOT_FINITE, row
        if bad >= 0:
            return SINGULAR, bad
        if worst <= CLOSURE_TARGET * m.scale[1] or (worst > 0.5 * before and worst <= CLOSURE_MAX * m.scale[1]):
            return DONE, row
        before = worst
        for i in range(w.lam.shape[0]):
            w.lam[m.place[i]] = -w.c[i]
        for i in range(w.top.shape[0] - 1):
            put(w.top[i], 0.0, 0.0, 0.0)
        solve(m, w)
        add(q, 1.0, w.x)
    return NOT_CLOSED, row


@inner
def close_rates(m, w, t, q, v):
    """Project v onto J v = f_dot; `close` has been at q."""
    rates(m, w, t, q, v)
    right_side(m, w, w.rate, v)
    solve(m, w)
    add(v, 1.0, w.x)


@inner
def finite(x):
    """Return whether all numbers of the bodies are finite."""
    total = 0.0
    for i in range(x.shape[0] - 1):
        total += x[i, 0] + x[i, 1] + x[i, 2]
    return np.isfinite(total)


@inner
def record(m, w, q, v, out, k):
    """Store sample k: q, v, v_dot of the bodies and -lam J on body b of every row (its wrench about O).

    In a gear that body may be the frame of both hinges and hold two of its places.
    """
    for i in range(q.shape[0] - 1):
        for j in range(3):
            out[0][k, i, j], out[1][k, i, j], out[2][k, i, j] = q[i, j], v[i, j], w.x[i, j]
    for i in range(m.kind.shape[0]):
        for j in range(3):
            total = w.J[4 * i + 1, j]
            for other in range(2, 4):
                total += w.J[4 * i + other, j] * (m.slot[i, other] == m.slot[i, 1])
            out[3][k, i, j] = -w.lam[m.place[i]] * total


@inner
def stage(m, w, t, q, v, h, part):
    """Advance a further stage of Runge-Kutta from (q, v) by h along the last one, and add it to the weighted sums."""
    for i in range(q.shape[0] - 1):
        for j in range(3):
            w.q[i, j] = q[i, j] + h * w.v[i, j]
            w.v[i, j] = v[i, j] + h * w.x[i, j]
    rows(m, w, t, w.q)
    bad = factor(m, w)
    accelerations(m, w, t, w.q, w.v)
    add(w.dq, part, w.v)
    add(w.dv, part, w.x)
    return bad


@inner
def first_stage(w, v, part):
    """Set v of the first stage, and begin the weighted sums."""
    for i in range(v.shape[0] - 1):
        for j in range(3):
            w.v[i, j] = v[i, j]
            w.dq[i, j] = part * v[i, j]
            w.dv[i, j] = part * w.x[i, j]


@kernel
def march(m, w, q, v, t_end, steps, every, out, begin, end):
    """Integrate by RK4 from 0 to t_end, steps begin ... end - 1, projected before each and recorded every ``every``;
    return (status, row, t).
    """
    h = t_end / steps
    for step in range(begin, end):
        t = t_end * (step / steps)
        status, row = close(m, w, t, q)
        if status != DONE:
            return status, row, t
        close_rates(m, w, t, q, v)
        accelerations(m, w, t, q, v)
        if not finite(w.x):
            return NOT_FINITE, row, t
        if step % every == 0:
            record(m, w, q, v, out, step // every)
        if step == steps:
            break
        first_stage(w, v, h / 6.0)
        bad = stage(m, w, t + 0.5 * h, q, v, 0.5 * h, h / 3.0)
        bad = max(stage(m, w, t + 0.5 * h, q, v, 0.5 * h, h / 3.0), bad)
        bad = max(stage(m, w, t + h, q, v, h, h / 6.0), bad)
        if bad >= 0:
            return SINGULAR, bad, t
        add(q, 1.0, w.dq)
        add(v, 1.0, w.dv)
    return DONE, 0, t_end


@kernel
def trace(m, w, q, times, out, begin, end):
    """Compute samples begin ... end - 1 of a fully driven system at the times, the first one q at t = 0; return
    (status, row, t).
    """
    t, v = times[max(begin - 1, 0)], w.v
    if begin == 0:
        v[:], w.x[:] = 0.0, 0.0
    for k in range(begin, end):
        turn = 0.0
        for i in range(q.shape[0] - 1):
            turn = max(turn, abs(v[i, 2] * (times[k] - t)) + abs(0.5 * w.x[i, 2] * (times[k] - t) ** 2))
        pieces = 1 + int(turn / SUBSTEP_ANGLE)
        start, h = t, (times[k] - t) / pieces
        for piece in range(pieces):
            add(q, h, v)
            add(q, 0.5 * h * h, w.x)
            t = times[k] if piece == pieces - 1 else start + (piece + 1) * h
            status, row = close(m, w, t, q)
            if status != DONE:
                return status, row, t
            v[:] = 0.0
            close_rates(m, w, t, q, v)
            close_rates(m, w, t, q, v)
            accelerations(m, w, t, q, v)
        record(m, w, q, v, out, k)
    return DONE, 0, t


@kernel
def evaluate(m, w, t, q, v):
    """Evaluate c, J, rate and gamma of all rows at any state, on the constraints or off them."""
    rows(m, w, t, q)
    rates(m, w, t, q, v)
