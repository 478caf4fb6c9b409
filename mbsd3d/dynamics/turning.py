"""Rotations over a step h: turns of hinges, the way from one orientation to the next, and orientations between.

With w and alpha in body axes at both ends (' at the second one) a body turns, to fourth order, by the rotation vector

    Omega = h/2 (w + w') + h^2/12 (alpha - alpha' + w x w')            e' = e o exp(Omega / 2)

(Magnus, by the trapezoidal rule with end corrections): exact for any number of turns about a fixed axis under an
acceleration that changes evenly. Where a method takes an even spin out of the step (spinning.py), so does this.
"""

import numpy as np

from ..compiler.decorators import inner_kernel
from ..kernels.coordinates import miscount
from ..kernels.kinematics import product, quaternion_of, rotation_matrix
from ..kernels.vectors import add, cross, dot, put, rotate, scale, sub, vec
from .spinning import turned_by

TURN_MISS_MAX = 1.0  # [rad] between an angle and the mean of its rates over a step; turns are miscounted from pi on
# [1] times the squares of the angles by which w turns and swings in a step, times the second term above: what the
# formula may err by. It is six times the error of free bodies, twelve times that of one that swings about an axis.
ORIENTATION_ERROR_FACTOR = 0.2
ERROR_MEMORY_FACTOR = 0.8
TURN_ROUNDING = 1e-12  # [1] of a turn: by which rounding may change it
TURN_PER_STEP_MIN = 1e-12  # [rad] in a step: less is rounding


@inner_kernel
def turns_are_certain(m, d, run, t_new, h):
    """Return False, and reject an adaptive step whose end is in d, if hinges may miscount their turns."""
    apart = miscount(m, d, t_new)
    if run.task.steps == 0 and not apart <= TURN_MISS_MAX:
        run.now.step = 0.5 * h
        run.now.rejected += 1
        run.now.retried = 1
        return False
    run.now.miscount = max(run.now.miscount, apart)
    return True


@inner_kernel
def without_spin(y, dy, q, u, spin, tau):
    """Return (e, angular velocity, its rate) of a body without an even spin, tau after the start of the step."""
    e, w = (y[q + 3], y[q + 4], y[q + 5], y[q + 6]), (y[u + 3], y[u + 4], y[u + 5])
    alpha = (dy[u + 3], dy[u + 4], dy[u + 5])
    if spin == (0.0, 0.0, 0.0):
        return e, w, alpha
    rate = np.sqrt(dot(spin, spin))
    n, c, s = scale(1.0 / rate, spin), np.cos(0.5 * rate * tau), np.sin(0.5 * rate * tau)
    back = (c, -s * n[0], -s * n[1], -s * n[2])
    return product(e, back), turned_by(sub(w, spin), n, c, s), turned_by(add(alpha, cross(spin, w)), n, c, s)


@inner_kernel
def note_miss(run, i, e, missed, allowed):
    """Add by how much more than allowed orientation and angular velocity of a body differ, as a world rotation."""
    x = (missed[1], missed[2], missed[3])
    sine = np.sqrt(dot(x, x))
    angle = max(2.0 * np.arctan2(sine, abs(missed[0])) - allowed, 0.0)
    along = scale((angle if missed[0] >= 0.0 else -angle) / sine, x)
    total = add(vec(run.missed[i]), rotate(rotation_matrix(e[0], e[1], e[2], e[3]), along))
    put(run.missed[i], total)
    size = np.sqrt(dot(total, total))
    if size > run.now.missed:
        run.now.missed, run.now.missed_by = size, i


@inner_kernel
def compare_poses(m, run, h):
    """Record how far bodies turn in the step h from run.y to run.trial, and how far this differs from Omega."""
    n = m.body.shape[0]
    for i in range(n):
        q, u = 7 * i, 7 * n + 6 * i
        spin = vec(run.spin[i]) if run.now.spinning > 0 else (0.0, 0.0, 0.0)
        e, w, alpha = without_spin(run.y, run.dy, q, u, spin, 0.0)
        e_end, w_end, alpha_end = without_spin(run.trial, run.trial_rate, q, u, spin, h)
        turn, change, jerk = scale(0.5 * h, add(w, w_end)), sub(w_end, w), sub(alpha, alpha_end)
        term = scale(h * h / 12.0, add(jerk, cross(w, w_end)))
        whole = add(turn, scale(h, spin))
        if dot(whole, whole) > run.now.farthest**2:
            run.now.farthest, run.now.farthest_by = np.sqrt(dot(whole, whole)), i
        moved = h * h * dot(change, change) + TURN_ROUNDING**2 * dot(whole, whole) + 1e-300
        swing = h**4 * dot(jerk, jerk) / moved
        error = ORIENTATION_ERROR_FACTOR * np.sqrt(dot(term, term)) * (dot(turn, turn) + swing)
        run.missed[i, 3] = max(min(error, TURN_MISS_MAX), ERROR_MEMORY_FACTOR * run.missed[i, 3])
        allowed = run.missed[i, 3] + TURN_PER_STEP_MIN * (1.0 + run.now.farthest)
        back, e_back = quaternion_of(scale(-1.0, add(turn, term))), (e[0], -e[1], -e[2], -e[3])
        missed = product(back, product(e_back, e_end))
        x = (missed[1], missed[2], missed[3])
        if 4.0 * dot(x, x) > (allowed * missed[0]) ** 2:
            note_miss(run, i, e_end, missed, allowed)


@inner_kernel
def turn_back(rho, w):
    """Return the rate of the rotation vector rho [rad] of a body that turns with w, body axes; exact to order 4."""
    swept = cross(rho, w)
    return add(add(w, scale(0.5, swept)), scale(1.0 / 12.0, cross(rho, swept)))


@inner_kernel
def hermite_of_rotations(m, run, h, end):
    """Set coefficients F of orientations: cubics of rotation vectors from run.y to the end, without spins."""
    n = m.body.shape[0]
    for i in range(n):
        q, u = 7 * i + 3, 7 * n + 6 * i + 3
        back, e = (run.y[q], -run.y[q + 1], -run.y[q + 2], -run.y[q + 3]), (end[q], end[q + 1], end[q + 2], end[q + 3])
        c, x, y, z = product(back, e)
        sine = np.sqrt(x * x + y * y + z * z)
        k = 2.0 * np.arctan2(sine if c >= 0.0 else -sine, abs(c)) / sine if sine > 0.0 else 0.0
        rho, spin = (k * x, k * y, k * z), vec(run.spin[i]) if run.now.spinning > 0 else (0.0, 0.0, 0.0)
        rate = scale(h, sub((run.y[u], run.y[u + 1], run.y[u + 2]), spin))
        end_rate = scale(h, turn_back(rho, sub((end[u], end[u + 1], end[u + 2]), spin)))
        for j in range(3):
            run.F[0, q + j] = rho[j]
            run.F[1, q + j] = rate[j] - rho[j]
            run.F[2, q + j] = 2.0 * rho[j] - end_rate[j] - rate[j]
            run.F[j, q + 3] = 0.0
    run.now.rotating = 1


@inner_kernel
def turn_on(m, run, y):
    """Replace rotation vectors in y by what is to be added to the quaternions of run.y."""
    for i in range(m.body.shape[0]):
        q = 7 * i + 3
        e = (run.y[q], run.y[q + 1], run.y[q + 2], run.y[q + 3])
        turned = product(e, quaternion_of((y[q], y[q + 1], y[q + 2])))
        for j in range(4):
            y[q + j] = turned[j] - e[j]
