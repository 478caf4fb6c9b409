"""Coordinates in which bodies with an axis of symmetry do not spin: their steps are as long as their axes allow.

Over one step, with the spin Omega that a body has about its axis at the start of it and tau the time since:

    e = e' o exp(Omega tau / 2)                      e_dot' = (e_dot - e o Omega / 2) o exp(-Omega tau / 2)
    w = R(-Omega tau) w'    (body axes)              w_dot' = R(Omega tau) (w_dot + Omega x w)

This holds for any Omega. What it takes out is what a wheel or a top only turns by.
"""

import numpy as np

from ..compiler.decorators import inner_kernel, kernel
from ..kernels.vectors import add, cross, dot, scale, sub, vec

SPIN_ANGLE_MIN = 0.1  # [rad] in a step: bodies that turn by less are integrated as they are
ACCELERATION_ROUNDING = 1e-4  # [1] of the spin squared: angular acceleration that counts as none
SPIN_ANGLE_MAX = 40.0  # [rad] in a step: longest turn of a body


@inner_kernel
def spin_of(fixed, y, u):
    """Return the angular velocity about the axis of symmetry, body axes.

    All of it for bodies of three equal moments.
    """
    w = (y[u + 3], y[u + 4], y[u + 5])
    return w if fixed.symmetry == 2 else scale(dot(w, vec(fixed.axis)), vec(fixed.axis))


@inner_kernel
def limit_turn(m, run):
    """Shorten the next step so that no body turns too far in it."""
    n = m.body.shape[0]
    for i in range(n):
        if m.body[i].symmetry > 0:
            spin = spin_of(m.body[i], run.y, 7 * n + 6 * i)
            run.now.step = min(run.now.step, SPIN_ANGLE_MAX / max(np.sqrt(dot(spin, spin)), 1e-300))


@inner_kernel
def steadier_without(fixed, y, dy, u, spin):
    """Return True where the angular velocity across the axis changes less when the spin is taken out.

    It does for a wheel, for steady precession, and for free bodies that are longer than wide; nutation of a flat one
    is slower in body axes.
    """
    across = sub((y[u + 3], y[u + 4], y[u + 5]), spin)
    rate = (dy[u + 3], dy[u + 4], dy[u + 5])
    rate = sub(rate, scale(dot(rate, vec(fixed.axis)), vec(fixed.axis)))
    without = add(rate, cross(spin, across))
    return dot(without, without) ** 0.5 <= dot(rate, rate) ** 0.5 + ACCELERATION_ROUNDING * dot(spin, spin)


@inner_kernel
def find_spins(m, run, h):
    """Find the spins that are taken out of the step h from run.y on."""
    n = m.body.shape[0]
    run.now.spinning = 0
    for i in range(n):
        if m.body[i].symmetry > 0:
            u = 7 * n + 6 * i
            spin = spin_of(m.body[i], run.y, u)
            out = dot(spin, spin) * h * h > SPIN_ANGLE_MIN**2 and steadier_without(m.body[i], run.y, run.dy, u, spin)
            run.now.spinning += out
            for j in range(3):
                run.spin[i, j] = spin[j] if out else 0.0


@inner_kernel
def find_turns(m, run, h):
    """Find the mean angular velocities of a step from run.y to run.trial, which a cubic of the rotation takes out."""
    n = m.body.shape[0]
    run.now.spinning = 0
    for i in range(n):
        u = 7 * n + 6 * i
        start, end = run.y[u + 3 : u + 6], run.trial[u + 3 : u + 6]
        spin = scale(0.5, add(vec(start), vec(end)))
        out = dot(spin, spin) * h * h > SPIN_ANGLE_MIN**2
        run.now.spinning += out
        for j in range(3):
            run.spin[i, j] = spin[j] if out else 0.0


@inner_kernel
def farthest_turn(run, h):
    """Return the largest angle [rad] by which a spin that is taken out turns its body in the step h."""
    square = 0.0
    for i in range(run.spin.shape[0] if run.now.spinning > 0 else 0):
        square = max(square, dot(vec(run.spin[i]), vec(run.spin[i])))
    return h * square**0.5


@inner_kernel
def turned_by(w, n, c, s):
    """Rotate w about the unit vector n; c, s are cosine and sine of half the angle."""
    cosine, sine = c * c - s * s, 2.0 * s * c
    return add(add(scale(cosine, w), scale(sine, cross(n, w))), scale((1.0 - cosine) * dot(n, w), n))


@inner_kernel
def rotate_body_state(x, q, u, spin, tau):
    """Set e := e o exp(spin tau / 2), w := R(-spin tau) w in x, whose pose starts at q and velocities at u."""
    rate = np.sqrt(dot(spin, spin))
    n, c, s = scale(1.0 / rate, spin), np.cos(0.5 * rate * tau), np.sin(0.5 * rate * tau)
    e0, e = x[q + 3], (x[q + 4], x[q + 5], x[q + 6])
    turned = add(add(scale(c, e), scale(s * e0, n)), scale(s, cross(e, n)))
    x[q + 3] = c * e0 - s * dot(e, n)
    back = turned_by((x[u + 3], x[u + 4], x[u + 5]), n, c, -s)
    for j in range(3):
        x[q + 4 + j] = turned[j]
        x[u + 3 + j] = back[j]


@kernel
def restore_spin(m, run, tau, x):
    """Transform x' -> x, a state or a small part of one, tau after the start of the step; with -tau: x -> x'."""
    n = m.body.shape[0]
    for i in range(n if run.now.spinning > 0 else 0):
        spin = vec(run.spin[i])
        if spin != (0.0, 0.0, 0.0):
            rotate_body_state(x, 7 * i, 7 * n + 6 * i, spin, tau)


@kernel
def rate_without_spin(m, run, tau, y, dy):
    """Transform dy -> dy' at the state y, tau after the start of the step."""
    n = m.body.shape[0]
    for i in range(n if run.now.spinning > 0 else 0):
        spin = vec(run.spin[i])
        if spin != (0.0, 0.0, 0.0):
            q, u = 7 * i, 7 * n + 6 * i
            e0, e = y[q + 3], (y[q + 4], y[q + 5], y[q + 6])
            own = add(scale(e0, spin), cross(e, spin))
            gained = cross(spin, (y[u + 3], y[u + 4], y[u + 5]))
            dy[q + 3] += 0.5 * dot(e, spin)
            for j in range(3):
                dy[q + 4 + j] -= 0.5 * own[j]
                dy[u + 3 + j] += gained[j]
            rotate_body_state(dy, q, u, spin, -tau)
