"""Surfaces that touch: where smooth convex ones are lowest over a plane, how hard they press, the row of a contact.

A surface is an ellipsoid with half axes r_i along u_i, some of which may be 0, thickened by a ball of radius rho: with
r = (R, R, 0) the outside of a torus, with rho = 0 an ellipsoid, with equal r_i a sphere. Its lowest point over a plane
of normal n lies in closed form at

    l = -A n / h - rho n,   h = sqrt(n'A n),   A = sum_i r_i^2 u_i u_i'         from its centre.
"""

import numpy as np

from .jit import inner_kernel
from .vectors import add, arm, columns, cross, dot, point, point_velocity, put6, scale, sub, vec

FLAT = 1e-300  # m^2 added to n'A n: a flat disc that lies on the plane touches it in its centre, and nothing is NaN


@inner_kernel
def spread(r, u, n):
    """A n for half axes r and directions u."""
    first, second = scale(r[0] * r[0] * dot(u[0], n), u[0]), scale(r[1] * r[1] * dot(u[1], n), u[1])
    return add(add(first, second), scale(r[2] * r[2] * dot(u[2], n), u[2]))


@inner_kernel
def lowest(r, rho, u, n):
    """(l, h, A n): the lowest point from the centre, and what its rate needs."""
    q = spread(r, u, n)
    h = np.sqrt(dot(n, q) + FLAT)
    return sub(scale(-1.0 / h, q), scale(rho, n)), h, q


@inner_kernel
def lowest_rate(r, rho, u, low, h, q, n_dot, n, w):
    """Rate of the lowest point of a body that turns with w over a plane whose normal changes by n_dot."""
    turn = sub(n_dot, cross(w, n))  # of the normal, seen from the body
    along = sub(spread(r, u, turn), scale(dot(turn, q) / (h * h), q))
    return sub(cross(w, low), add(scale(1.0 / h, along), scale(rho, turn)))


@inner_kernel
def meeting(p, a, b):
    """(axes of the plane, arms from O of a and of b to the lowest point, gap, velocity of b relative to a there).

    p: record of a `Contact` between a and b.
    """
    plane = columns(a, p.frame[0])
    low, _, _ = lowest(vec(p.value), p.value[3], columns(b, p.frame[1]), plane[2])
    place = add(point(b, arm(b, p.point[1])), low)
    gap = dot(plane[2], sub(place, point(a, arm(a, p.point[0]))))
    on_a, on_b = sub(place, vec(a.r)), sub(place, vec(b.r))
    return plane, on_a, on_b, gap, sub(point_velocity(b, on_b), point_velocity(a, on_a))


@inner_kernel
def pressure(p, gap, speed):
    """(N, k d^m, d) at the penetration d = -gap, which grows by ``speed``: N = k d^m (1 + x speed) + c speed >= 0."""
    depth = -gap if gap.real < 0.0 else 0.0 * gap
    elastic = p.value[4] * depth ** p.value[5] if gap.real < 0.0 else depth
    normal = elastic * (1.0 + p.value[7] * speed) + p.value[6] * speed if gap.real < 0.0 else depth
    return normal if normal.real > 0.0 else 0.0 * normal, elastic, depth


@inner_kernel
def contact_row(row, a, b, n, n_dot, arm_b, arm_a, arm_b_bias, arm_a_dot):
    """Velocity of b relative to a at a contact point that moves on both: J v = n . (V_b - V_a).

    arm_b, arm_a lead from each O to the point; arm_b_bias = d(w_b x arm_b)/dt - alpha_b x arm_b.
    """
    slip = sub(point_velocity(b, arm_b), point_velocity(a, arm_a))
    row.gamma = -(dot(n_dot, slip) + dot(n, sub(arm_b_bias, cross(vec(a.w), arm_a_dot))))
    put6(row.J[0], scale(-1.0, n), cross(n, arm_a))
    put6(row.J[1], n, cross(arm_b, n))
