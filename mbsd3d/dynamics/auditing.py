"""Quadrature of work and impulse over fixed steps, and how far this audit itself may be off.

Nothing bounds the error of a fixed step, so none bounds that of the integrals of power, forces and moments over it. A
second quadrature, of Adams and Moulton with five rates at the ends of steps, shares no stage with the first one.
"""

import numpy as np

from ..compiler.decorators import inner_kernel
from ..kernels.vectors import add, cross, dot, pair, scale, vec
from .state_rates import audit_evaluation

AUDITED_FIELDS = "open_work", "open_push", "open_turn"  # of integrators.memory.NOW
INTEGRAL_ROW, ERROR_ROW, FIRST_RATE_ROW = 0, 1, 2  # rows of Run.audit: integrals, errors, then rates, newest first
PAST_RATES_COUNT = 4  # [rates] at the ends of earlier steps, as the formula of fifth order needs
EQUAL_STEP_TOLERANCE = 1e-6  # [1] of a step: difference to the next one that counts as none
# [1] weights of the rates at the ends of earlier steps and of this one: formula of Adams and Moulton, fifth order
MOULTON_WEIGHTS = np.array([646.0, -264.0, 106.0, -19.0]) / 720.0
MOULTON_END_WEIGHT = 251.0 / 720.0


@inner_kernel
def velocity_of_centre(m, d):
    """Return the velocity of the centre of mass of all bodies [m/s]; zero if none has a mass."""
    total, momentum = 0.0, (0.0, 0.0, 0.0)
    for i in range(m.body.shape[0]):
        mass, body = m.body[i].mass, d.body[i]
        total += mass
        momentum = add(momentum, scale(mass, add(vec(body.velocity), cross(vec(body.w), vec(body.s)))))
    return scale(1.0 / total, momentum) if total > 0.0 else momentum


@inner_kernel
def held(m):
    """Return True if a joint holds a body to the ground, which then is the frame in which energy is conserved."""
    for k in range(m.row.shape[0]):
        for slot in range(4):
            if m.row[k].body[slot] == m.body.shape[0]:
                return True
    return False


@inner_kernel
def begin_audit(m, d, s, run):
    """Store the rates at a start, which is evaluated in d, and forget the rates before a jump."""
    if run.task.steps == 0:
        return
    audit_evaluation(m, d, s, run.work_rate)
    first = 13 * m.body.shape[0] + m.z_work
    for j in range(run.audit.shape[1]):
        run.audit[INTEGRAL_ROW, j], run.audit[FIRST_RATE_ROW, j] = run.y[first + j], run.work_rate[first + j]
    run.now.rates = 1


@inner_kernel
def go_on_auditing(m, d, s, run, h):
    """Compare the integrals over a step with those of the rates at the ends of this step and the four before."""
    if run.task.steps == 0:
        return
    now, audit = run.now, run.audit
    known = now.rates if abs(h - now.audited) <= EQUAL_STEP_TOLERANCE * h else 1
    audit_evaluation(m, d, s, run.work_rate)
    first = 13 * m.body.shape[0] + m.z_work
    for j in range(audit.shape[1]):
        rate, total = run.work_rate[first + j], MOULTON_END_WEIGHT * run.work_rate[first + j]
        for i in range(PAST_RATES_COUNT):
            total += MOULTON_WEIGHTS[i] * audit[FIRST_RATE_ROW + i, j]
        if known == PAST_RATES_COUNT:
            audit[ERROR_ROW, j] += run.y[first + j] - audit[INTEGRAL_ROW, j] - h * total
        audit[INTEGRAL_ROW, j] = run.y[first + j]
        for i in range(PAST_RATES_COUNT - 1, 0, -1):
            audit[FIRST_RATE_ROW + i, j] = audit[FIRST_RATE_ROW + i - 1, j]
        audit[FIRST_RATE_ROW, j] = rate
    now.rates, now.audited = min(known + 1, PAST_RATES_COUNT), h
    note_errors(m, d, run, audit[ERROR_ROW])


@inner_kernel
def note_errors(m, d, run, error):
    """Record the largest errors so far of work, impulse and angular impulse; work as `balances` takes it."""
    now, works = run.now, error.shape[0] - 6
    push, turn = pair(error[works : works + 6])
    work = 0.0 if held(m) else -dot(velocity_of_centre(m, d), push)
    for j in range(works):
        work += error[j]
    now.open_work = max(now.open_work, abs(work))
    now.open_push = max(now.open_push, np.sqrt(dot(push, push)))
    now.open_turn = max(now.open_turn, np.sqrt(dot(turn, turn)))
