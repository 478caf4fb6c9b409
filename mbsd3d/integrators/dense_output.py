"""The motion within a step: cubics through both of its ends, those of orientations by rotation vectors."""

import numpy as np

from ..compiler.jit import inner_kernel
from ..dynamics.spinning import spin_on
from ..kernels.kinematics import product, quaternion_of
from ..kernels.vectors import add, add_scaled, clear, cross, scale, sub, vec


@inner_kernel
def hermite(run, h, end, rate, end_rate):
    """Coefficients F of the cubic from run.y to the end of the step, with the rates there."""
    for k in range(run.y.shape[0]):
        step = end[k] - run.y[k]
        run.F[0, k] = step
        run.F[1, k] = h * rate[k] - step
        run.F[2, k] = 2.0 * step - h * (end_rate[k] + rate[k])


@inner_kernel
def turn_back(rho, w):
    """Rate of the rotation vector rho [rad] of a body that turns with w, body axes; exact to order 4 in rho."""
    swept = cross(rho, w)
    return add(add(w, scale(0.5, swept)), scale(1.0 / 12.0, cross(rho, swept)))


@inner_kernel
def hermite_of_rotations(m, run, h, end):
    """Coefficients F of orientations: cubics of rotation vectors from run.y to the end, beside the spins taken out."""
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
    """Rotation vectors in the place of orientations in y -> what is to be added to those of run.y."""
    for i in range(m.body.shape[0]):
        q = 7 * i + 3
        e = (run.y[q], run.y[q + 1], run.y[q + 2], run.y[q + 3])
        turned = product(e, quaternion_of((y[q], y[q + 1], y[q + 2])))
        for j in range(4):
            y[q + j] = turned[j] - e[j]


@inner_kernel
def interpolate(m, run, h, x, y):
    """Dense output of the last step at the fraction x of it (Horner form of Hairer, Norsett, Wanner)."""
    clear(y)
    terms = run.F.shape[0]
    for i in range(terms):
        f = run.F[terms - 1 - i]
        weight = x if (terms - 1 - i) % 2 == 0 else 1.0 - x
        for j in range(y.shape[0]):
            y[j] = (y[j] + f[j]) * weight
    if run.now.rotating == 1:
        turn_on(m, run, y)
    add_scaled(y, 1.0, run.y)
    spin_on(m, run, x * h, y)
