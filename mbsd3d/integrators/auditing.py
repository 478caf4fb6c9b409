"""What the quadrature of fixed steps makes of work and impulse: how far the audit itself may be off.

Nothing bounds the error of a fixed step, so none bounds that of the integrals of power, forces and moments over it. A
second quadrature, of Adams and Moulton with up to five rates at the ends of steps, shares no stage with the first one.
"""

import numpy as np

from ..compiler.jit import inner_kernel
from ..dynamics.state_rates import audit_rates
from ..kernels.vectors import add, cross, dot, pair, scale, vec

AUDITED = "open_work", "open_push", "open_turn"  # of memory.NOW
BEGIN, ERROR, RATES, ORDERS = 0, 1, 2, 4  # rows of Run.audit: integrals, errors, from the third on rates, newest first
ALIKE = 1e-6  # of a step is what the next one may differ by to count as equally long
MOULTON = np.array([
    [1 / 2, 1 / 2, 0, 0, 0],
    [5 / 12, 8 / 12, -1 / 12, 0, 0],
    [9 / 24, 19 / 24, -5 / 24, 1 / 24, 0],
    [251 / 720, 646 / 720, -264 / 720, 106 / 720, -19 / 720],
])  # fmt: skip


@inner_kernel
def velocity_of_centre(m, d):
    """Velocity of the centre of mass of all bodies; zero if none has a mass."""
    total, momentum = 0.0, (0.0, 0.0, 0.0)
    for i in range(m.body.shape[0]):
        mass, body = m.body[i].mass, d.body[i]
        total += mass
        momentum = add(momentum, scale(mass, add(vec(body.velocity), cross(vec(body.w), vec(body.s)))))
    return scale(1.0 / total, momentum) if total > 0.0 else momentum


@inner_kernel
def begin_audit(m, d, run):
    """Rates at a start, which is evaluated in d; those before a jump say nothing of what comes."""
    if run.task.steps == 0:
        return
    audit_rates(m, d, run.work_rate)
    first = 13 * m.body.shape[0] + m.z_work
    for j in range(run.audit.shape[1]):
        run.audit[BEGIN, j], run.audit[RATES, j] = run.y[first + j], run.work_rate[first + j]
    run.now.rates = 1


@inner_kernel
def go_on_auditing(m, d, run, h):
    """Compare the integrals over a step with those of the rates at the ends of this one and those before."""
    if run.task.steps == 0:
        return
    now, audit = run.now, run.audit
    known = now.rates if abs(h - now.audited) <= ALIKE * h else 1
    audit_rates(m, d, run.work_rate)
    first = 13 * m.body.shape[0] + m.z_work
    for j in range(audit.shape[1]):
        rate = run.work_rate[first + j]
        total = MOULTON[known - 1, 0] * rate
        for i in range(known):
            total += MOULTON[known - 1, i + 1] * audit[RATES + i, j]
        audit[ERROR, j] += run.y[first + j] - audit[BEGIN, j] - h * total
        audit[BEGIN, j] = run.y[first + j]
        for i in range(ORDERS - 1, 0, -1):
            audit[RATES + i, j] = audit[RATES + i - 1, j]
        audit[RATES, j] = rate
    now.rates, now.audited = min(known + 1, ORDERS), h
    note_errors(m, d, run, audit[ERROR])


@inner_kernel
def note_errors(m, d, run, error):
    """The greatest errors so far of the work about the centre of mass, the impulse and the angular impulse."""
    now, works = run.now, error.shape[0] - 6
    push, turn = pair(error[works : works + 6])
    work = -dot(velocity_of_centre(m, d), push)
    for j in range(works):
        work += error[j]
    now.open_work = max(now.open_work, abs(work))
    now.open_push = max(now.open_push, np.sqrt(dot(push, push)))
    now.open_turn = max(now.open_turn, np.sqrt(dot(turn, turn)))
