"""Prescribed rotations: quaternion, angular velocity and angular acceleration of three signals and their derivatives.

They depend on time and on numbers of the model alone, which are complex in a complex step.
"""

import numpy as np

from ..compiler.decorators import inner_kernel
from .kinds import ROTATION_VECTOR
from .signals import signal
from .vectors import add, cross, dot, scale

SERIES_SQUARE_MAX = 1.0  # [rad^2] of an angle below which closed forms lose digits by cancellation
SERIES_TERMS = 10  # [terms] of the series there: the first one left out is 1 / 22!, below rounding


@inner_kernel
def product(p, q):
    """Return the product of two quaternions."""
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


@inner_kernel
def back(e):
    """Return the opposite rotation."""
    return e[0], -e[1], -e[2], -e[3]


@inner_kernel
def turned(e, x):
    """Return x rotated by a unit quaternion: x + 2 e0 e cross x + 2 e cross (e cross x)."""
    axis = (e[1], e[2], e[3])
    half = cross(axis, x)
    return add(x, scale(2.0, add(scale(e[0], half), cross(axis, half))))


@inner_kernel
def series(square, n):
    """Return f = sum of (-s)^k / (2 k + n)! and 2 df/ds for s = x^2: (1 - cos x) / x^2 for n = 2, C for n = 3."""
    term, f, slope = 1.0 / (n * (n - 1.0)), 0.0, 0.0  # n! of both
    for k in range(SERIES_TERMS):
        f += term
        term /= (2.0 * k + n + 1.0) * (2.0 * k + n + 2.0)
        slope -= 2.0 * (k + 1.0) * term
        term *= -square
    return f, slope


@inner_kernel
def left_jacobian(square):
    """Return B = (1 - cos x) / x^2, C = (x - sin x) / x^3 and B_1, C_1, their derivatives by x over x, for x^2."""
    if square.real < SERIES_SQUARE_MAX:
        B, B_1 = series(square, 2.0)
        C, C_1 = series(square, 3.0)
        return B, C, B_1, C_1
    x = np.sqrt(square)
    A, B, C = np.sin(x) / x, (1.0 - np.cos(x)) / square, (x - np.sin(x)) / (square * x)
    return B, C, (A - 2.0 * B) / square, (B - 3.0 * C) / square


@inner_kernel
def by_rotation_vector(x, v, a):
    """Return (quaternion, w, w_dot) of exp(x) for a rotation vector x [rad] with its rate v and acceleration a.

    w = v + B x cross v + C x cross (x cross v), the left Jacobian of the rotations times v, and its derivative.
    """
    square = dot(x, x)
    B, C, B_1, C_1 = left_jacobian(square)
    half = 0.5 * np.sqrt(square)
    share = 0.5 * np.sin(half) / half if half.real > 0.0 else 0.5
    first, rate = cross(x, v), dot(x, v)
    second = cross(x, first)
    w = add(v, add(scale(B, first), scale(C, second)))
    first_rate = cross(x, a)
    second_rate = add(cross(v, first), cross(x, first_rate))
    w_rate = add(a, add(scale(B, first_rate), scale(C, second_rate)))
    w_rate = add(w_rate, scale(rate, add(scale(B_1, first), scale(C_1, second))))
    return (np.cos(half), share * x[0], share * x[1], share * x[2]), w, w_rate


@inner_kernel
def orientation(m, p, first, t):
    """Return (quaternion, w, w_dot) that three signals from ``first`` on prescribe, in axes of body a.

    Numbers of p: kind, then three axes u_i: of the rotation vector sum f_i u_i, or of turns by f_i about u_i, each axis
    carried by the turns before it.
    """
    k = p.number + 1
    e, x, w, w_rate = (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for i in range(3):
        f, rate, bend = signal(m, first + i, t)
        u = (m.number[k + 3 * i], m.number[k + 3 * i + 1], m.number[k + 3 * i + 2])
        if m.number[p.number].real != ROTATION_VECTOR:
            s = np.sin(0.5 * f)
            u = turned(e, u)
            e = product((np.cos(0.5 * f), s * u[0], s * u[1], s * u[2]), e)
            w_rate = add(w_rate, scale(rate, cross(w, u)))
        x, w, w_rate = add(x, scale(f, u)), add(w, scale(rate, u)), add(w_rate, scale(bend, u))
    if m.number[p.number].real == ROTATION_VECTOR:
        return by_rotation_vector(x, w, w_rate)
    return e, w, w_rate
