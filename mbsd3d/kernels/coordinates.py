"""Hinge coordinates: angle or slide of a joint, with its gradient.

Angle between x_a, y_a (fixed in a) and x_b (fixed in b): theta = atan2(x_b.y_a, x_b.x_a), exact off the joint's
manifold too. Slide: s = n_a . (p_b - p_a). Path: length s along a curve x(s) of a up to where it is nearest to p_b;
touch: to where it is highest over a face of b. Bearing: angle from x_a towards y_a of p_b - p_a. Angles are unwrapped
against the last accepted state, with the mean of the rates there and now, never by a counter; curves are searched from
there.
"""

import math
from typing import Annotated

import numpy as np
from numba import types

from ..compiler.arguments import Reference
from ..compiler.decorators import inner_kernel, kernel, late_kernel
from ..compiler.late import late
from .force_laws import series
from .kinds import (
    ANGLE,
    BEARING,
    PATH,
    SLIDE,
)
from .surfaces import highest, nearest
from .vectors import add, arm, cross, dot, mat, point, point_velocity, rotate, scale, sub, turning, vec


def number_of(d: Reference) -> types.Type:
    """Return the number type of the computation: real, or complex in a complex step."""
    return d.fields.types[d.fields.fields.index("z")].dtype


def of_coordinate(m: Reference, d: Reference, *given: types.Type) -> types.Type:
    """Return the types of the results of `coordinate`."""
    return types.Tuple([*[number_of(d)] * 2, *[types.UniTuple(number_of(d), 3)] * 4])


CoordinateValues = Annotated[tuple, of_coordinate]


@kernel
def arctan2(y, x):
    """Return the angle of (x, y) [rad] for real numbers and those of a complex step; for functions of `CustomForce`.

    The real angle plus the small rotation left over; (0, 0) has none.
    """
    angle = math.atan2(y.real, x.real)
    c, s = math.cos(angle), math.sin(angle)
    return angle + (c * y - s * x) / (c * x + s * y)


@inner_kernel
def predicted(d, i, t, rate):
    """Predict coordinate i at time t from the mean of its rate at the last accepted state and its rate at t.

    It errs by h^3/12 of the third derivative: not at all under an even acceleration, over any number of turns.
    """
    last = d.coordinate[i]
    return last.value + 0.5 * (last.rate + rate.real) * (t - d.unwrap_time[0])


@inner_kernel
def unwrapped(d, i, angle, rate, t):
    """Return the branch of an angle that is nearest to its predicted value at time t."""
    return angle + 2.0 * math.pi * math.floor((predicted(d, i, t, rate) - angle.real) / (2.0 * math.pi) + 0.5)


@inner_kernel
def turn(m, d, i):
    """Return (x_a, y_a, x_b, sin, cos, f, g) of angle i with theta_dot = g . (w_b - w_a).

    g = x_b x f / (sin^2 + cos^2), f = cos y_a - sin x_a.
    """
    x = m.coordinate[i]
    a, b = d.body[x.body[0]], d.body[x.body[1]]
    xa, ya, xb = arm(a, x.axis[0]), arm(a, x.axis[1]), arm(b, x.axis[2])
    sine, cosine = dot(xb, ya), dot(xb, xa)
    f = sub(scale(cosine, ya), scale(sine, xa))
    return xa, ya, xb, sine, cosine, f, scale(1.0 / (sine * sine + cosine * cosine), cross(xb, f))


@inner_kernel
def angle(m, d, i, t):
    """Return (value, J_dot v, blocks on a and b as (linear, angular)) of angle i."""
    a, b = d.body[m.coordinate[i].body[0]], d.body[m.coordinate[i].body[1]]
    xa, ya, xb, sine, cosine, f, g = turn(m, d, i)
    wa, w = vec(a.w), sub(vec(b.w), vec(a.w))
    n = sine * sine + cosine * cosine
    sine_dot, cosine_dot = dot(w, cross(xb, ya)), dot(w, cross(xb, xa))
    f_dot = sub(
        add(scale(cosine_dot, ya), scale(cosine, cross(wa, ya))), add(scale(sine_dot, xa), scale(sine, cross(wa, xa)))
    )
    n_dot = 2.0 * (sine * sine_dot + cosine * cosine_dot)
    numerator_dot = add(cross(cross(vec(b.w), xb), f), cross(xb, f_dot))
    bias = dot(w, sub(scale(1.0 / n, numerator_dot), scale(n_dot / n, g)))
    zero = scale(0.0, g)
    return unwrapped(d, i, arctan2(sine, cosine), dot(g, w), t), bias, zero, scale(-1.0, g), zero, g


@inner_kernel
def slide_along(a, b, n, sa, sb):
    """Return (value, J_dot v, blocks) of n . (p_b - p_a), n and s_a fixed in body a, s_b in body b (world axes)."""
    wa, wb = vec(a.w), vec(b.w)
    reach = sub(point(b, sb), vec(a.r))  # from O of a to the point of b
    gap = sub(reach, sa)
    gap_dot = sub(point_velocity(b, sb), point_velocity(a, sa))
    n_dot = cross(wa, n)
    bias_points = sub(turning(wb, sb), turning(wa, sa))
    bias = dot(cross(wa, n_dot), gap) + 2.0 * dot(n_dot, gap_dot) + dot(n, bias_points)
    return dot(n, gap), bias, scale(-1.0, n), cross(n, reach), n, cross(sb, n)


@inner_kernel
def slide(m, d, i):
    """Return (value, J_dot v, blocks on a and b as (linear, angular)) of slide i."""
    x = m.coordinate[i]
    a, b = d.body[x.body[0]], d.body[x.body[1]]
    return slide_along(a, b, arm(a, x.axis[0]), arm(a, x.point[0]), arm(b, x.point[1]))


@late_kernel
def path(m, d, i, t) -> CoordinateValues:
    """Return (value, J_dot v, blocks on a and b as (linear, angular)) of path i."""
    x = m.coordinate[i]
    a, b = d.body[x.body[0]], d.body[x.body[1]]
    s, _, s_ddot, gradient, _, _, _, _, _, _ = nearest(m, d, i, t)
    _, bias, la, ta, lb, tb = slide_along(a, b, rotate(mat(a.R), gradient), (0.0, 0.0, 0.0), arm(b, x.point[1]))
    return s, bias + s_ddot, la, ta, lb, tb


@late_kernel
def touch(m, d, i, t) -> CoordinateValues:
    """Return (value, J_dot v, blocks on a and b as (linear, angular)) of the contact of a curve and a face, i."""
    a = d.body[m.coordinate[i].body[0]]
    s, _, bias, gradient, _, _, _ = highest(m, d, i, t)
    turn = rotate(mat(a.R), gradient)
    zero = scale(0.0, turn)
    return s, bias, zero, scale(-1.0, turn), zero, turn


@late_kernel
def bearing(m, d, i, t) -> CoordinateValues:
    """Return (value, J_dot v, blocks on a and b as (linear, angular)) of bearing i.

    With X and Y the slides of p_b along x_a and y_a: theta_dot = (X Y_dot - Y X_dot) / (X^2 + Y^2).
    """
    x = m.coordinate[i]
    a, b = d.body[x.body[0]], d.body[x.body[1]]
    sa, sb = arm(a, x.point[0]), arm(b, x.point[1])
    X, X_bias, la, ta, lb, tb = slide_along(a, b, arm(a, x.axis[0]), sa, sb)
    Y, Y_bias, ma, ua, mb, ub = slide_along(a, b, arm(a, x.axis[1]), sa, sb)
    va, wa, vb, wb = vec(a.velocity), vec(a.w), vec(b.velocity), vec(b.w)
    X_dot = dot(la, va) + dot(ta, wa) + dot(lb, vb) + dot(tb, wb)
    Y_dot = dot(ma, va) + dot(ua, wa) + dot(mb, vb) + dot(ub, wb)
    square = X * X + Y * Y
    p, q = -Y / square, X / square
    rate = p * X_dot + q * Y_dot
    bias = p * X_bias + q * Y_bias - 2.0 * rate * (X * X_dot + Y * Y_dot) / square
    la, ta = add(scale(p, la), scale(q, ma)), add(scale(p, ta), scale(q, ua))
    lb, tb = add(scale(p, lb), scale(q, mb)), add(scale(p, tb), scale(q, ub))
    return unwrapped(d, i, arctan2(Y, X), rate, t), bias, la, ta, lb, tb


@late
@kernel
def coordinate(m, d, i, t) -> CoordinateValues:
    """Return (value, J_dot v, linear a, angular a, linear b, angular b) of hinge coordinate i at time t."""
    kind = m.coordinate[i].kind
    if kind == ANGLE:
        return angle(m, d, i, t)
    if kind == SLIDE:
        return slide(m, d, i)
    if kind == PATH:
        return path(m, d, i, t)
    if kind == BEARING:
        return bearing(m, d, i, t)
    return touch(m, d, i, t)


@inner_kernel
def value_and_rate(m, d, i, t):
    """Return hinge coordinate i at time t and its rate [rad, rad/s or m, m/s]."""
    a, b = d.body[m.coordinate[i].body[0]], d.body[m.coordinate[i].body[1]]
    kind = m.coordinate[i].kind
    if kind == ANGLE:
        _, _, _, sine, cosine, _, g = turn(m, d, i)
        rate = dot(g, sub(vec(b.w), vec(a.w)))
        return unwrapped(d, i, arctan2(sine, cosine), rate, t), rate
    value, _, la, ta, lb, tb = coordinate(m, d, i, t)
    return value, dot(la, vec(a.velocity)) + dot(ta, vec(a.w)) + dot(lb, vec(b.velocity)) + dot(tb, vec(b.w))


@inner_kernel
def sum_and_rate(m, d, p, t):
    """Return the weighted sum of the coordinates that a force reads, and its rate."""
    weights = series(m, p, 0, p.measures)
    x, rate = 0.0, 0.0
    for i in range(p.measures):
        value, speed = value_and_rate(m, d, m.measure[p.measure + i].coordinate, t)
        x += weights[i] * value
        rate += weights[i] * speed
    return x, rate


@kernel
def coordinate_rate(m, d, i, t):
    """Return the rate of hinge coordinate i [rad/s or m/s]."""
    return value_and_rate(m, d, i, t)[1]


@kernel
def remember(m, d, t):
    """Store all hinge coordinates and their rates, against which later angles are unwrapped."""
    for i in range(m.coordinate.shape[0]):
        value, rate = value_and_rate(m, d, i, t)
        d.coordinate[i].value = np.real(value)
        d.coordinate[i].rate = np.real(rate)
    d.unwrap_time[0] = t


@inner_kernel
def miscount(m, d, t):
    """Return the largest distance [rad] of an angle from `predicted` at time t; near pi its turns are not certain.

    Lengths along closed curves count as angles: once round is 2 pi.
    """
    largest = 0.0
    for i in range(m.coordinate.shape[0]):
        kind, period = m.coordinate[i].kind, 2.0 * math.pi
        if kind != ANGLE and kind != BEARING:
            period = m.number[m.coordinate[i].number + 1] if kind != SLIDE else 0.0
        if period > 0.0:
            value, rate = value_and_rate(m, d, i, t)
            largest = max(largest, abs(value - predicted(d, i, t, rate)) * (2.0 * math.pi / period))
    return largest
