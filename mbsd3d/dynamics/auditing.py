"""What the quadrature of fixed steps makes of work and impulse: how far the audit itself may be off.

Nothing bounds the error of a fixed step, so none bounds that of the integrals of power, forces and moments over it. A
second quadrature, of Adams and Moulton with five rates at the ends of steps, shares no stage with the first one.
"""

import numpy as np

from ..compiler.decorators import inner_kernel
from ..kernels.vectors import add, cross, dot, pair, scale, vec
from .state_rates import audit_rates

AUDITED = "open_work", "open_push", "open_turn"  # of integrators.memory.NOW
BEGIN, ERROR, RATES = 0, 1, 2  # rows of Run.audit: integrals, their errors, and from the third on rates, newest first
KNOWN = 4  # rates at the ends of steps before this one
ALIKE = 1e-6  # of a step is what the next one may differ by to count as equally long
MOULTON = np.array([646.0, -264.0, 106.0, -19.0]) / 720.0  # weights of these rates, and that of the one at the end
MOULTON_END = 251.0 / 720.0


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
def held(m):
    """True if a joint holds a body to the ground, which then is the frame in which energy is kept."""
    for k in range(m.row.shape[0]):
        for slot in range(4):
            if m.row[k].body[slot] == m.body.shape[0]:
                return True
    return False


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
    """Compare the integrals over a step with those of the rates at the ends of this one and the four before."""
    if run.task.steps == 0:
        return
    now, audit = run.now, run.audit
    known = now.rates if abs(h - now.audited) <= ALIKE * h else 1
    audit_rates(m, d, run.work_rate)
    first = 13 * m.body.shape[0] + m.z_work
    for j in range(audit.shape[1]):
        rate, total = run.work_rate[first + j], MOULTON_END * run.work_rate[first + j]
        for i in range(KNOWN):
            total += MOULTON[i] * audit[RATES + i, j]
        if known == KNOWN:
            audit[ERROR, j] += run.y[first + j] - audit[BEGIN, j] - h * total
        audit[BEGIN, j] = run.y[first + j]
        for i in range(KNOWN - 1, 0, -1):
            audit[RATES + i, j] = audit[RATES + i - 1, j]
        audit[RATES, j] = rate
    now.rates, now.audited = min(known + 1, KNOWN), h
    note_errors(m, d, run, audit[ERROR])


@inner_kernel
def note_errors(m, d, run, error):
    """The greatest errors so far of work, impulse and angular impulse; the work as `balances` takes it."""
    now, works = run.now, error.shape[0] - 6
    push, turn = pair(error[works : works + 6])
    work = 0.0 if held(m) else -dot(velocity_of_centre(m, d), push)
    for j in range(works):
        work += error[j]
    now.open_work = max(now.open_work, abs(work))
    now.open_push = max(now.open_push, np.sqrt(dot(push, push)))
    now.open_turn = max(now.open_turn, np.sqrt(dot(turn, turn)))
