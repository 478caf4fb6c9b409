"""Surfaces and curves that touch: where smooth convex surfaces are lowest over planes, how hard they press, and where
curves are nearest to points or highest over faces.

A surface is an ellipsoid with half axes r_i along u_i, some of which may be 0, thickened by a ball of radius rho: with
r = (R, R, 0) the outside of a torus, with rho = 0 an ellipsoid, with equal r_i a sphere. Its lowest point over a plane
of normal n lies in closed form at

    l = -A n / h - rho n,   h = sqrt(n'A n),   A = sum_i r_i^2 u_i u_i'         from its centre.

A curve x(s) is made of pieces of fifth degree, in body axes from O; s is its length. In ``Model.number`` it has

    n pieces, period (0: open), k groups, s_0 ... s_n, then per piece k groups of 3 components of 6 coefficients

with the highest power first, in s - s_i. Group 0 is x, the others are directions that go along with it.
"""

import math

import numpy as np

from ..compiler.decorators import inner_kernel
from ..compiler.records import Parameters
from .vectors import add, arm, columns, cross, dot, mat, point, point_velocity, put6, rotate_back, scale, sub, vec

CONTACT = Parameters(
    radii=("m", 3), tube="m", stiffness="N/m^m", exponent="1", damping="N s/m", loss="s/m", grip="N/m",
    grip_damping="N s/m", creep="m/s", size="m", friction="1", rolling="m", spinning="m", other="m", half="m",
)  # fmt: skip
contact_parameters = CONTACT.reader()

# [m^2] added to n'A n: a flat disc that lies on the plane touches it at its centre, and nothing is NaN
DISC_REGULARISATION = 1e-300
# [1] added to 1 + n_0 . n, which vanishes where a normal has turned by half a turn: nothing is NaN
OPPOSITE_REGULARISATION = 1e-300
GROUP_NUMBERS_COUNT = 18  # [numbers] of a group of a piece
LAST_NEWTON_STEP = 1e-8  # [1] of a piece: from there one more step of Newton's method is exact
CURVE_END_MARGIN = 1e-6  # [1] of a piece: distance past the end of an open curve that counts as the end


@inner_kernel
def spread(r, u, n):
    """Return A n for half axes r and directions u."""
    first, second = scale(r[0] * r[0] * dot(u[0], n), u[0]), scale(r[1] * r[1] * dot(u[1], n), u[1])
    return add(add(first, second), scale(r[2] * r[2] * dot(u[2], n), u[2]))


@inner_kernel
def lowest(r, rho, u, n):
    """Return (l, h, A n): the lowest point from the centre, and what its rate needs."""
    q = spread(r, u, n)
    h = np.sqrt(dot(n, q) + DISC_REGULARISATION)
    return sub(scale(-1.0 / h, q), scale(rho, n)), h, q


@inner_kernel
def lowest_rate(r, rho, u, low, h, q, n_dot, n, w):
    """Return the rate of the lowest point of a body that turns with w over a plane whose normal changes by n_dot."""
    turn = sub(n_dot, cross(w, n))  # of the normal, seen from the body
    along = sub(spread(r, u, turn), scale(dot(turn, q) / (h * h), q))
    return sub(cross(w, low), add(scale(1.0 / h, along), scale(rho, turn)))


@inner_kernel
def shortest_line(own, p, a, b):
    """Return (from the axis of a sphere or capsule of a to the centre of a sphere of b, that centre), world."""
    centre = point(b, arm(b, p.point[1]))
    line = sub(centre, point(a, arm(a, p.point[0])))
    u, _, _ = columns(a, p.frame[0])
    s = dot(line, u)
    if s.real > own.half.real:
        s = own.half + 0.0 * s
    elif s.real < -own.half.real:
        s = -own.half + 0.0 * s
    return sub(line, scale(s, u)), centre


@inner_kernel
def round_meeting(own, p, a, b):
    """Return what `meeting` does where a has a sphere or capsule: the point lies midway between both surfaces.

    Its plane has the normal n = line / |line|, and axes that follow n by the least turn from those of the element.
    """
    line, centre = shortest_line(own, p, a, b)
    distance = np.sqrt(dot(line, line))
    n = scale(1.0 / distance, line)
    u, _, n_0 = columns(a, p.frame[0])
    lean = dot(u, n) / (1.0 + dot(n_0, n) + OPPOSITE_REGULARISATION)
    along = sub(u, scale(lean, add(n, n_0)))
    gap = distance - own.other - own.radii[0]
    place = sub(centre, scale(own.radii[0] + 0.5 * gap, n))
    on_a, on_b = sub(place, vec(a.r)), sub(place, vec(b.r))
    return (along, cross(n, along), n), on_a, on_b, gap, sub(point_velocity(b, on_b), point_velocity(a, on_a))


@inner_kernel
def meeting(own, p, a, b):
    """Return (axes of the plane, arms from O of a and b to the lowest point, gap, velocity of b relative to a).

    p: record of a `Contact` between a and b; own: its parameters, with ``other`` = 0 for a plane.
    """
    if own.other.real > 0.0:
        return round_meeting(own, p, a, b)
    plane = columns(a, p.frame[0])
    low, _, _ = lowest(vec(own.radii), own.tube, columns(b, p.frame[1]), plane[2])
    place = add(point(b, arm(b, p.point[1])), low)
    gap = dot(plane[2], sub(place, point(a, arm(a, p.point[0]))))
    on_a, on_b = sub(place, vec(a.r)), sub(place, vec(b.r))
    return plane, on_a, on_b, gap, sub(point_velocity(b, on_b), point_velocity(a, on_a))


@inner_kernel
def pressure(own, gap, speed):
    """Return (N, k d^m, d) at the penetration d = -gap, growing by ``speed``: N = k d^m (1 + x speed) + c speed."""
    depth = -gap if gap.real < 0.0 else 0.0 * gap
    elastic = own.stiffness * depth**own.exponent if gap.real < 0.0 else depth
    normal = elastic * (1.0 + own.loss * speed) + own.damping * speed if gap.real < 0.0 else depth
    return normal if normal.real > 0.0 else 0.0 * normal, elastic, depth


@inner_kernel
def contact_row(row, a, b, n, n_dot, arm_b, arm_a, arm_b_bias, arm_a_dot):
    """Return the velocity of b relative to a at a contact point that moves on both: J v = n . (V_b - V_a).

    arm_b, arm_a lead from each O to the point; arm_b_bias = d(w_b x arm_b)/dt - alpha_b x arm_b.
    """
    slip = sub(point_velocity(b, arm_b), point_velocity(a, arm_a))
    row.gamma = -(dot(n_dot, slip) + dot(n, sub(arm_b_bias, cross(vec(a.w), arm_a_dot))))
    put6(row.J[0], scale(-1.0, n), cross(n, arm_a))
    put6(row.J[1], n, cross(arm_b, n))


@inner_kernel
def power(data, k, u):
    """Return c5 u^5 + ... + c0 and three derivatives."""
    c5, c4, c3, c2, c1, c0 = data[k], data[k + 1], data[k + 2], data[k + 3], data[k + 4], data[k + 5]
    return (
        ((((c5 * u + c4) * u + c3) * u + c2) * u + c1) * u + c0,
        (((5.0 * c5 * u + 4.0 * c4) * u + 3.0 * c3) * u + 2.0 * c2) * u + c1,
        ((20.0 * c5 * u + 12.0 * c4) * u + 6.0 * c3) * u + 2.0 * c2,
        (60.0 * c5 * u + 24.0 * c4) * u + 6.0 * c3,
    )


@inner_kernel
def group(data, k, u):
    """Return value and three derivatives of a group of a piece, as vectors."""
    x, y, z = power(data, k, u), power(data, k + 6, u), power(data, k + 12, u)
    return (x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2]), (x[3], y[3], z[3])


@inner_kernel
def slope(data, k, u, e, weight):
    """Return f = x' . (e - weight x) and its derivative."""
    x, t, t_rate, _ = group(data, k, u)
    rest = sub(e, scale(weight, x))
    return dot(t, rest), dot(t_rate, rest) - weight * dot(t, t)


@inner_kernel
def piece_of(data, breaks, n, s):
    """Return the number of the piece that holds s, the first or last one outside."""
    low, high = 0, n - 1
    while low < high:
        middle = (low + high + 1) // 2
        if data[breaks + middle].real <= s:
            low = middle
        else:
            high = middle - 1
    return low


@inner_kernel
def search(data, first, e, weight, expected):
    """Return (s, where its piece starts, s within the piece) at which x' . (e - weight x) falls through zero.

    weight 1: the point of the curve nearest to e; 0: its highest along e. The search goes downhill from ``expected``,
    so it stays on the branch; s counts the turns of a closed curve, and is not a number past the end of an open one.
    """
    n, period, breaks = int(data[first].real), data[first + 1], first + 3
    size, closed = GROUP_NUMBERS_COUNT * int(data[first + 2].real), period.real > 0.0
    pieces, real = breaks + n + 1, (e[0].real, e[1].real, e[2].real)
    turns = period * math.floor((expected - data[breaks].real) / period.real) if closed else 0.0 * period
    j = piece_of(data, breaks, n, expected - turns.real)
    for _ in range(n):
        width = (data[breaks + j + 1] - data[breaks + j]).real
        if slope(data, pieces + size * j, width, real, weight)[0].real > 0.0 and (closed or j < n - 1):
            j += 1
            if j == n:
                j, turns = 0, turns + period
        elif slope(data, pieces + size * j, 0.0, real, weight)[0].real < 0.0 and (closed or j > 0):
            j -= 1
            if j < 0:
                j, turns = n - 1, turns - period
        else:
            break
    at, start, width = pieces + size * j, data[breaks + j], (data[breaks + j + 1] - data[breaks + j]).real
    low = -CURVE_END_MARGIN * width if not closed and j == 0 else 0.0
    high = (1.0 + CURVE_END_MARGIN) * width if not closed and j == n - 1 else width
    left = slope(data, at, low, real, weight)[0].real < 0.0 or slope(data, at, high, real, weight)[0].real > 0.0
    u = min(max((expected - turns - start).real, low), high)
    for _ in range(60):
        f, rate = slope(data, at, u, real, weight)
        if f.real > 0.0:
            low = u
        else:
            high = u
        step = u - f.real / rate.real
        if not low <= step <= high:  # equal where u is the place already
            step = 0.5 * (low + high)
        done = abs(step - u) <= LAST_NEWTON_STEP * width
        u = step
        if done:
            break
    f, rate = slope(data, at, u, e, weight)  # of e and the curve as they are: complex in a complex step
    within = u - f / rate + (math.nan if left and not closed else 0.0)
    return turns + start + within, at, within


@inner_kernel
def expected(d, i, t):
    """Predict coordinate i at time t from the last accepted state and its rate."""
    last = d.coordinate[i]
    return last.value + last.rate * (t - d.unwrap_time[0])


@inner_kernel
def nearest(m, d, i, t):
    """Find the nearest point of path i, in axes of a: F = x' . (p - x) = 0 gives s, and its derivatives the rates.

    Returns (s, its rate, its second rate at rest in a, gradient of s, piece, s in it, p - x, x', x'', velocity of p
    relative to a).
    """
    x = m.coordinate[i]
    a, b = d.body[x.body[0]], d.body[x.body[1]]
    sb = arm(b, x.point[1])
    reach = sub(point(b, sb), vec(a.r))
    moving = sub(sub(point_velocity(b, sb), vec(a.velocity)), cross(vec(a.w), reach))
    place, speed = rotate_back(mat(a.R), reach), rotate_back(mat(a.R), moving)
    s, k, u = search(m.number, x.number, place, 1.0, expected(d, i, t))
    curve, along, bend, twist = group(m.number, k, u)
    off = sub(place, curve)
    yields = dot(along, along) - dot(bend, off)
    s_dot = dot(along, speed) / yields
    s_ddot = (2.0 * dot(bend, speed) + (dot(twist, off) - 3.0 * dot(along, bend)) * s_dot) * s_dot / yields
    return s, s_dot, s_ddot, scale(1.0 / yields, along), k, u, off, along, bend, speed


@inner_kernel
def highest(m, d, i, t):
    """Find the highest point of touch i, in axes of a: F = x' . n = 0 gives s, and its derivatives the rest.

    Returns (s, its rate, J_dot v, gradient by the turn of b relative to a, x, x', normal).
    """
    c = m.coordinate[i]
    a, b = d.body[c.body[0]], d.body[c.body[1]]
    R, wa, wb = mat(a.R), vec(a.w), vec(b.w)
    n, w = rotate_back(R, arm(b, c.axis[2])), rotate_back(R, sub(wb, wa))
    n_dot, swing = cross(w, n), rotate_back(R, cross(wb, wa))
    n_ddot = add(cross(swing, n), cross(w, n_dot))
    s, k, u = search(m.number, c.number, n, 0.0, expected(d, i, t))
    x, along, bend, twist = group(m.number, k, u)
    yields = -dot(bend, n)
    s_dot = dot(along, n_dot) / yields
    s_ddot = ((2.0 * dot(bend, n_dot) + dot(twist, n) * s_dot) * s_dot + dot(along, n_ddot)) / yields
    return s, s_dot, s_ddot, scale(1.0 / yields, cross(n, along)), x, along, n
