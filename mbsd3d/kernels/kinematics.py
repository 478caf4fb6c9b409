"""Poses and velocities of all bodies from the state ``y = (q, u, z)``, with u = (r_dot, R'w) per body.

``e_dot = H(e) w / 2`` with ``H(e) = [-e_v' ; e0 1 - [e_v]x]``; ``R(e)`` divides by e'e, so it is a rotation for any e.
"""

import numpy as np

from ..compiler.decorators import inner_kernel, kernel
from .vectors import add, pair, put, put6, rotate, rotate_back, vec

SERIES_ANGLE_SQUARE_MAX = 1e-9  # [rad^2] of half an angle: below it two terms of sine and cosine are exact to rounding


@inner_kernel
def rotation_matrix(e0, e1, e2, e3):
    """Return R(e) as a 9-tuple, exact for quaternions of any length."""
    k = 2.0 / (e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3)
    return (
        1.0 - k * (e2 * e2 + e3 * e3), k * (e1 * e2 - e0 * e3), k * (e1 * e3 + e0 * e2),
        k * (e1 * e2 + e0 * e3), 1.0 - k * (e1 * e1 + e3 * e3), k * (e2 * e3 - e0 * e1),
        k * (e1 * e3 - e0 * e2), k * (e2 * e3 + e0 * e1), 1.0 - k * (e1 * e1 + e2 * e2),
    )  # fmt: skip


@inner_kernel
def quaternion_rate(e, w):
    """Return e_dot = H(e) w / 2, w in world axes."""
    return (
        0.5 * (-e[1] * w[0] - e[2] * w[1] - e[3] * w[2]),
        0.5 * (e[0] * w[0] + e[3] * w[1] - e[2] * w[2]),
        0.5 * (-e[3] * w[0] + e[0] * w[1] + e[1] * w[2]),
        0.5 * (e[2] * w[0] - e[1] * w[1] + e[0] * w[2]),
    )


@kernel
def kinematics(m, d, y):
    """Set r, e, R, s, velocity, w of all bodies and z from the state y."""
    n = m.body.shape[0]
    for i in range(n):
        q, u = 7 * i, 7 * n + 6 * i
        body = d.body[i]
        put(body.r, (y[q], y[q + 1], y[q + 2]))
        put(body.velocity, (y[u], y[u + 1], y[u + 2]))
        for j in range(4):
            body.e[j] = y[q + 3 + j]
        R = rotation_matrix(y[q + 3], y[q + 4], y[q + 5], y[q + 6])
        for j in range(9):
            body.R[j] = R[j]
        put(body.s, rotate(R, vec(m.body[i].com)))
        w_body = (y[u + 3], y[u + 4], y[u + 5])
        put(body.w_body, w_body)
        put(body.w, rotate(R, w_body))
    for j in range(m.z_work):
        d.z[j] = y[13 * n + j]


@kernel
def world_velocities(states, out):
    """Set the world velocities (r_dot, w) out (samples, n, 6) of the states y (samples, 13 n + states of forces)."""
    n = out.shape[1]
    for k in range(states.shape[0]):
        y = states[k]
        for i in range(n):
            q, u = 7 * i, 7 * n + 6 * i
            R = rotation_matrix(y[q + 3], y[q + 4], y[q + 5], y[q + 6])
            put6(out[k, i], (y[u], y[u + 1], y[u + 2]), rotate(R, (y[u + 3], y[u + 4], y[u + 5])))


@kernel
def pack_motion(q, v, y):
    """Set y[:13 n] = (q, u) from poses q (7 n,) and world velocities v (6 n,), u = (r_dot, R'w)."""
    n = v.shape[0] // 6
    for i in range(7 * n):
        y[i] = q[i]
    for i in range(n):
        R = rotation_matrix(q[7 * i + 3], q[7 * i + 4], q[7 * i + 5], q[7 * i + 6])
        velocity, w = pair(v[6 * i : 6 * i + 6])
        put6(y[7 * n + 6 * i :], velocity, rotate_back(R, w))


@inner_kernel
def rates(m, d, dy):
    """Set the rates dy of q and u from velocities and accelerations: u_dot = (r_ddot, R'w_dot), as w x w = 0."""
    n = m.body.shape[0]
    for i in range(n):
        q, u = 7 * i, 7 * n + 6 * i
        body = d.body[i]
        e_dot = quaternion_rate(body.e, vec(body.w))
        for j in range(3):
            dy[q + j] = body.velocity[j]
            dy[u + j] = body.acceleration[j]
            dy[u + 3 + j] = body.alpha[j]
        for j in range(4):
            dy[q + 3 + j] = e_dot[j]


@inner_kernel
def quaternion_of(turn):
    """Return exp(turn / 2): the unit quaternion of a rotation vector [rad]."""
    x, y, z = turn
    square = 0.25 * (x * x + y * y + z * z)
    if square.real < SERIES_ANGLE_SQUARE_MAX:
        p0, k = 1.0 - 0.5 * square, 0.5 - square / 12.0
    else:
        half = np.sqrt(square)
        p0, k = np.cos(half), 0.5 * np.sin(half) / half
    return p0, k * x, k * y, k * z


@inner_kernel
def product(p, e):
    """Return the product p o e of two quaternions."""
    p0, p1, p2, p3 = p
    e0, e1, e2, e3 = e
    return (
        p0 * e0 - p1 * e1 - p2 * e2 - p3 * e3,
        p0 * e1 + p1 * e0 + p2 * e3 - p3 * e2,
        p0 * e2 - p1 * e3 + p2 * e0 + p3 * e1,
        p0 * e3 + p1 * e2 - p2 * e1 + p3 * e0,
    )


@kernel
def displace_body(y, q, dr, dtheta):
    """Move the pose at y[q:q+7]: r += dr, e = exp(dtheta) o e with |e| = 1; world axes."""
    f0, f1, f2, f3 = product(quaternion_of(dtheta), (y[q + 3], y[q + 4], y[q + 5], y[q + 6]))
    norm = np.sqrt(f0 * f0 + f1 * f1 + f2 * f2 + f3 * f3)
    y[q + 3], y[q + 4], y[q + 5], y[q + 6] = f0 / norm, f1 / norm, f2 / norm, f3 / norm
    put(y[q : q + 3], add((y[q], y[q + 1], y[q + 2]), dr))


@kernel
def displace(m, d, y):
    """Move all bodies by the world displacements (dr, dtheta) that `solve` left in their accelerations."""
    for i in range(m.body.shape[0]):
        dr, dtheta = pair(d.body[i].acceleration)
        displace_body(y, 7 * i, dr, dtheta)


@inner_kernel
def push_velocities(m, d, y):
    """Add the world velocity changes that `solve` left in the accelerations; zeros change no digit of u."""
    n = m.body.shape[0]
    for i in range(n):
        u, body = 7 * n + 6 * i, d.body[i]
        for j in range(3):
            y[u + j] += body.acceleration[j]
            y[u + 3 + j] += body.alpha[j]


@inner_kernel
def normalise(m, y):
    """Scale every quaternion to |e| = 1."""
    for i in range(m.body.shape[0]):
        q = 7 * i + 3
        norm = np.sqrt(y[q] * y[q] + y[q + 1] * y[q + 1] + y[q + 2] * y[q + 2] + y[q + 3] * y[q + 3])
        for j in range(q, q + 4):
            y[j] /= norm
