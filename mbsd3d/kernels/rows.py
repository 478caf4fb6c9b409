"""Constraint primitives: residual c, Jacobian blocks J, right sides b and gamma of every row.

Per row ``c_dot = J v - b`` and ``d(J v - b)/dt = J v_dot - gamma``, exact off the constraint manifold as well. With
point arms s = R p (world) and w x (w x s) the centripetal acceleration of a body-fixed point. A primitive with a
signal f(t) prescribes its geometry: c = g(q) - f, b = f', gamma = f'' - J_dot v (speeds: b = f, no residual).
A new primitive is one function here and one line in `rows`.
"""

import numpy as np

from ..compiler.decorators import inner_kernel, kernel, late_kernel
from .coordinates import coordinate, slide_along, value_and_rate
from .kinds import (
    BAUMGARTE,
    COINCIDE,
    COUPLE,
    DISTANCE,
    DOT,
    DOT_DIFFERENCE,
    IN_PLANE,
    MESH,
    NO_SIDESLIP,
    ON_CURVE,
    ON_FACE,
    ORIENT,
    RATIO,
    TURN_RATE,
)
from .orientations import back, orientation, product
from .signals import polynomial, signal
from .surfaces import GROUP_NUMBERS_COUNT, contact_row, group, highest, lowest, lowest_rate, nearest
from .vectors import (
    add,
    add6,
    arm,
    clear,
    cross,
    dot,
    mat,
    point,
    point_velocity,
    put6,
    rotate,
    rotate_back,
    scale,
    sub,
    turning,
    vec,
)


@inner_kernel
def coincide(d, p, a, b):
    """Fill c = p_b - p_a (3 rows, world components)."""
    sa, sb = arm(a, p.point[0]), arm(b, p.point[1])
    c = sub(point(b, sb), point(a, sa))
    g = sub(turning(vec(a.w), sa), turning(vec(b.w), sb))
    for i in range(3):
        row = d.row[p.row + i]
        row.c = c[i]
        row.gamma = g[i]
        unit = (1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0)
        put6(row.J[0], scale(-1.0, unit), cross(unit, sa))
        put6(row.J[1], unit, cross(sb, unit))


@inner_kernel
def axes_dot(x, y, wx, wy):
    """Return (x . y, x cross y, J_dot v) for x turning with wx and y with wy: d(x.y)/dt = (wx - wy) . (x cross y).

    With x_dot = wx cross x and y_dot = wy cross y, w . d(x cross y)/dt = (w.x)(wx.y) - (w.y)(wy.x) - w.w x.y.
    """
    w, c = sub(wx, wy), dot(x, y)
    return c, cross(x, y), dot(w, x) * dot(wx, y) - dot(w, y) * dot(wy, x) - dot(w, w) * c


@inner_kernel
def axis_dot(row, p, a, b):
    """Fill c = x_a . y_b."""
    c, n, rest = axes_dot(arm(a, p.axis[0]), arm(b, p.axis[1]), vec(a.w), vec(b.w))
    zero = scale(0.0, n)
    row.c = c
    row.gamma = -rest
    put6(row.J[0], zero, n)
    put6(row.J[1], zero, scale(-1.0, n))


@late_kernel
def axis_dot_difference(row, p, a, b):
    """Fill c = x_a . y_b - y_a . x_b: no relative rotation about the bisector of the shafts."""
    c1, n1, rest1 = axes_dot(arm(a, p.axis[0]), arm(b, p.second_axis[1]), vec(a.w), vec(b.w))
    c2, n2, rest2 = axes_dot(arm(a, p.second_axis[0]), arm(b, p.axis[1]), vec(a.w), vec(b.w))
    n = sub(n1, n2)
    zero = scale(0.0, n)
    row.c = c1 - c2
    row.gamma = rest2 - rest1
    put6(row.J[0], zero, n)
    put6(row.J[1], zero, scale(-1.0, n))


@inner_kernel
def in_plane(row, p, a, b):
    """Fill c = n_a . (p_b - p_a)."""
    value, rest, la, ta, lb, tb = slide_along(a, b, arm(a, p.axis[0]), arm(a, p.point[0]), arm(b, p.point[1]))
    row.c = value
    row.gamma = -rest
    put6(row.J[0], la, ta)
    put6(row.J[1], lb, tb)


@late_kernel
def distance(row, p, a, b):
    """Fill c = |p_b - p_a| - L."""
    sa, sb = arm(a, p.point[0]), arm(b, p.point[1])
    gap = sub(point(b, sb), point(a, sa))
    gap_dot = sub(point_velocity(b, sb), point_velocity(a, sa))
    length = np.sqrt(dot(gap, gap))
    n = scale(1.0 / length, gap)
    along = dot(n, gap_dot)
    bias = dot(n, sub(turning(vec(b.w), sb), turning(vec(a.w), sa)))
    row.c = length - p.value[0]
    row.gamma = -(dot(gap_dot, gap_dot) - along * along) / length - bias
    put6(row.J[0], scale(-1.0, n), cross(n, sa))
    put6(row.J[1], n, cross(sb, n))


@late_kernel
def ratio(m, d, row, p, t):
    """Fill c = v0 x0 + v1 x1 for hinge coordinates x0 (slots 0, 1) and x1 (slots 2, 3): gear, screw, rack, driver."""
    row.c = 0.0
    row.gamma = 0.0
    for i in range(2):
        if p.coordinate[i] >= 0:
            f = p.value[i]
            x, rest, la, ta, lb, tb = coordinate(m, d, p.coordinate[i], t)
            row.c += f * x
            row.gamma -= f * rest
            put6(row.J[2 * i], scale(f, la), scale(f, ta))
            put6(row.J[2 * i + 1], scale(f, lb), scale(f, tb))


@late_kernel
def couple(m, d, row, p, t):
    """Fill c = y - f(x) for sums y and x of v_i times a hinge coordinate, f a polynomial: gamma has f'' x_dot^2.

    The numbers are how many coordinates y has, which stand first, then the coefficients of f. A body has one slot.
    """
    x, x_dot, of_y = 0.0, 0.0, int(m.number[p.number].real)
    for i in range(of_y, 4):
        if p.coordinate[i] >= 0:
            value, rate = value_and_rate(m, d, p.coordinate[i], t)
            x += p.value[i] * value
            x_dot += p.value[i] * rate
    f, slope, bend = polynomial(m.number, p.number + 1, p.numbers - 1, x)
    row.c = -f
    row.gamma = bend * x_dot * x_dot
    for slot in range(4):
        clear(row.J[slot])
    for i in range(4):
        k = p.coordinate[i]
        if k >= 0:
            factor = p.value[i] if i < of_y else -slope * p.value[i]
            value, rest, la, ta, lb, tb = coordinate(m, d, k, t)
            if i < of_y:
                row.c += factor * value
            row.gamma -= factor * rest
            for slot in range(4):
                if p.body[slot] == m.coordinate[k].body[0]:
                    add6(row.J[slot], scale(factor, la), scale(factor, ta))
                if p.body[slot] == m.coordinate[k].body[1]:
                    add6(row.J[slot], scale(factor, lb), scale(factor, tb))


@late_kernel
def mesh(m, d, row, p, t):
    """Fill c = sum_i of v_i theta_i + n_i . gap_i + (x_i - s_i n_i) . u_i: teeth of two gears on one carrier.

    Slots 2 i and 2 i + 1 are carrier and gear i; n_i, x_i are fixed in the carrier, u_i is the axis of the gear,
    s_i how far it has slid along it (only the part of n_i across the axis counts in the last product). All but theta
    and the slide vanish with the hinges' own rows; their gradients make J v = n . (v of gear 1 - v of gear 0 at the
    pitch point), so the reaction is a force along the line of action and not a couple.
    """
    ratio(m, d, row, p, t)
    for i in range(2):
        k, g = 2 * i, 2 * i + 1
        a, b = d.body[p.body[k]], d.body[p.body[g]]
        mount, hub, n, spin = arm(a, p.point[k]), arm(b, p.point[g]), arm(a, p.axis[k]), arm(b, p.axis[g])
        across = m.coordinate[p.coordinate[i]].axis
        u = cross(arm(a, across[0]), arm(a, across[1]))
        gap, rest, la, ta, lb, tb = slide_along(a, b, n, mount, hub)
        s, rest_s, las, tas, lbs, tbs = slide_along(a, b, u, mount, hub)
        x, moment, rest_x = axes_dot(arm(a, p.second_axis[k]), spin, vec(a.w), vec(b.w))
        y, turn, rest_y = axes_dot(sub(n, scale(dot(n, u), u)), spin, vec(a.w), vec(b.w))
        y_dot = dot(sub(vec(a.w), vec(b.w)), turn)
        s_dot = dot(las, vec(a.velocity)) + dot(tas, vec(a.w)) + dot(lbs, vec(b.velocity)) + dot(tbs, vec(b.w))
        moment = sub(moment, scale(s, turn))
        row.c += gap + x - s * y
        row.gamma -= rest + rest_x - s * rest_y - y * rest_s - 2.0 * s_dot * y_dot
        add6(row.J[k], sub(la, scale(y, las)), add(sub(ta, scale(y, tas)), moment))
        add6(row.J[g], sub(lb, scale(y, lbs)), sub(sub(tb, scale(y, tbs)), moment))


@late_kernel
def turn_rate(row, p, a, b):
    """Fill J v = x_a . (w_b - w_a): a prescribed relative speed about an axis of a; no residual."""
    x = arm(a, p.axis[0])
    zero = scale(0.0, x)
    row.c = 0.0
    row.gamma = -dot(cross(vec(a.w), x), sub(vec(b.w), vec(a.w)))
    put6(row.J[0], zero, scale(-1.0, x))
    put6(row.J[1], zero, x)


@late_kernel
def no_sideslip(row, p, a, b):
    """Fill J v of a knife edge: the point of b has no velocity along n_b relative to a; no residual."""
    n, s = arm(b, p.axis[1]), arm(b, p.point[1])
    reach = sub(point(b, s), vec(a.r))
    reach_dot = sub(point_velocity(b, s), vec(a.velocity))
    row.c = 0.0
    contact_row(row, a, b, n, cross(vec(b.w), n), s, reach, turning(vec(b.w), s), reach_dot)


@late_kernel
def roll(d, p, a, b):
    """Add the rows of a surface of body b on the plane (P, n) of body a; see `surfaces`.

    The surface has half axes value[0:3] along axis, second_axis and their cross product, thickened by value[3].

    Row 1: c = n.(C - P) - h - rho, the gap; rows 2, 3: no slip along two directions of the plane.
    """
    wa, wb = vec(a.w), vec(b.w)
    n, u, v, s = arm(a, p.axis[0]), arm(b, p.axis[1]), arm(b, p.second_axis[1]), arm(b, p.point[1])
    r, rho, axes, n_dot = vec(p.value), p.value[3], (u, v, cross(u, v)), cross(wa, n)
    low, h, q = lowest(r, rho, axes, n)
    low_dot = lowest_rate(r, rho, axes, low, h, q, n_dot, n, wb)
    centre = sub(point(b, s), vec(a.r))
    arm_b, arm_a = add(s, low), add(centre, low)
    arm_a_dot = add(sub(point_velocity(b, s), vec(a.velocity)), low_dot)
    bias_b = cross(wb, add(cross(wb, s), low_dot))
    along = arm(a, p.second_axis[0])
    across = cross(n, along)
    d.row[p.row].c = dot(n, sub(centre, arm(a, p.point[0]))) - h - rho
    contact_row(d.row[p.row], a, b, n, n_dot, arm_b, arm_a, bias_b, arm_a_dot)
    contact_row(d.row[p.row + 1], a, b, along, cross(wa, along), arm_b, arm_a, bias_b, arm_a_dot)
    contact_row(d.row[p.row + 2], a, b, across, cross(wa, across), arm_b, arm_a, bias_b, arm_a_dot)


@late_kernel
def on_curve(m, d, row, p, t):
    """Fill c = E(s) . (p_b - x(s)) - value[0] at the nearest point of the curve, E its group of directions value[1]."""
    a, b = d.body[p.body[0]], d.body[p.body[1]]
    _, s_dot, s_ddot, ds, k, u, off, along, bend, speed = nearest(m, d, p.coordinate[0], t)
    E, E_rate, E_bend, _ = group(m.number, k + GROUP_NUMBERS_COUNT * int(p.value[1].real), u)
    shift = dot(E_rate, off) - dot(E, along)  # dc / ds
    bent = dot(E_bend, off) - 2.0 * dot(E_rate, along) - dot(E, bend)
    n, sb = rotate(mat(a.R), add(E, scale(shift, ds))), arm(b, p.point[1])
    _, bias, la, ta, lb, tb = slide_along(a, b, n, (0.0, 0.0, 0.0), sb)
    row.c = dot(E, off) - p.value[0]
    row.gamma = -bias - (2.0 * dot(E_rate, speed) + bent * s_dot) * s_dot - shift * s_ddot
    put6(row.J[0], la, ta)
    put6(row.J[1], lb, tb)


@late_kernel
def on_face(m, d, row, p, t):
    """Fill c = n_b . (p_b - x(s)) where the curve is highest over the face of b with the normal n_b."""
    a, b = d.body[p.body[0]], d.body[p.body[1]]
    _, s_dot, _, _, x, along, _ = highest(m, d, p.coordinate[0], t)
    R, n, sb, wa, wb = mat(a.R), arm(b, p.axis[1]), arm(b, p.point[1]), vec(a.w), vec(b.w)
    arm_a = rotate(R, x)
    arm_b = add(sub(vec(a.r), vec(b.r)), arm_a)
    arm_a_dot = add(cross(wa, arm_a), scale(s_dot, rotate(R, along)))
    arm_b_dot = add(sub(vec(a.velocity), vec(b.velocity)), arm_a_dot)
    row.c = dot(n, sub(sb, arm_b))
    contact_row(row, a, b, n, cross(wb, n), arm_b, arm_a, cross(wb, arm_b_dot), arm_a_dot)


@late_kernel
def orient(m, d, row, p, t):
    """Fill c = 2 x_k of the quaternion (x_0, x) by which b misses its prescribed orientation, in axes of b.

    e_b = e_a T(t) e_ab (x_0, x) with e_ab of the reference pose; k is the first of the values. With w the angular
    velocity of the miss, in axes of b, 2 x_dot = x_0 w + x cross w, so c_dot = g . w with g = x_0 e_k + e_k cross x.
    """
    k, first, a, b = int(p.value[0].real), p.number + 10, d.body[p.body[0]], d.body[p.body[1]]
    T, spin, spin_rate = orientation(m, p, p.signal - k, t)
    e_ab = (m.number[first], m.number[first + 1], m.number[first + 2], m.number[first + 3])
    e_a, e_b = (a.e[0], a.e[1], a.e[2], a.e[3]), (b.e[0], b.e[1], b.e[2], b.e[3])
    e = product(back(product(product(e_a, T), e_ab)), e_b)
    sign = -1.0 if e[0].real < 0.0 else 1.0  # of the two quaternions of the miss, that of at most half a turn
    x_0, x, axis = sign * e[0], scale(sign, (e[1], e[2], e[3])), (1.0 * (k == 0), 1.0 * (k == 1), 1.0 * (k == 2))
    R, wa, wb = mat(b.R), vec(a.w), vec(b.w)
    v, v_t = sub(wb, wa), rotate(mat(a.R), spin)  # relative angular velocity, and what of it is prescribed; world
    w = rotate_back(R, sub(v, v_t))
    x_rate = scale(0.5, add(scale(x_0, w), cross(x, w)))
    own = add(scale(x_0, axis), cross(axis, x))
    own_rate = add(scale(-0.5 * dot(x, w), axis), cross(axis, x_rate))
    g = rotate(R, own)
    g_rate = add(rotate(R, own_rate), cross(wb, g))
    row.c = 2.0 * x[k]
    row.b = dot(g, v_t)
    b_rate = dot(g_rate, v_t) + dot(g, add(cross(wa, v_t), rotate(mat(a.R), spin_rate)))
    row.gamma = b_rate - m.gamma * dot(g_rate, v)  # teaching switch: without -J_dot v
    put6(row.J[0], scale(0.0, g), scale(-1.0, g))
    put6(row.J[1], scale(0.0, g), g)


@late_kernel
def prescribe(m, row, p, t):
    """Subtract the signal of a driven primitive: motion (c, b = f', gamma = f'') or speed (b = f, gamma = f')."""
    f, f_dot, f_ddot = signal(m, p.signal, t)
    if m.row[p.row].holonomic == 1:
        row.c -= f
        row.b = f_dot
        row.gamma += f_ddot
    else:
        row.b = f
        row.gamma += f_dot


@inner_kernel
def row_speed(m, d, k):
    """Return J v - b of row k."""
    row = d.row[k]
    total = -row.b
    for slot in range(4):
        i = m.row[k].body[slot]
        if i >= 0:
            body = d.body[i]
            for j in range(3):
                total += row.J[slot, j] * body.velocity[j] + row.J[slot, 3 + j] * body.w[j]
    return total


@inner_kernel
def fill(m, d, p, t):
    """Fill the rows of one primitive."""
    row, a, b = d.row[p.row], d.body[p.body[0]], d.body[p.body[1]]
    if p.kind == COINCIDE:
        coincide(d, p, a, b)
    elif p.kind == DOT:
        axis_dot(row, p, a, b)
    elif p.kind == IN_PLANE:
        in_plane(row, p, a, b)
    elif p.kind == DISTANCE:
        distance(row, p, a, b)
    elif p.kind == DOT_DIFFERENCE:
        axis_dot_difference(row, p, a, b)
    elif p.kind == RATIO:
        ratio(m, d, row, p, t)
    elif p.kind == MESH:
        mesh(m, d, row, p, t)
    elif p.kind == COUPLE:
        couple(m, d, row, p, t)
    elif p.kind == TURN_RATE:
        turn_rate(row, p, a, b)
    elif p.kind == NO_SIDESLIP:
        no_sideslip(row, p, a, b)
    elif p.kind == ON_CURVE:
        on_curve(m, d, row, p, t)
    elif p.kind == ON_FACE:
        on_face(m, d, row, p, t)
    elif p.kind == ORIENT:
        orient(m, d, row, p, t)
    else:
        roll(d, p, a, b)


@late_kernel
def reflected_rates(m, d, t):
    """Fill the rates of the coordinates that have a reflected inertia: x_dot = J v, and the bias J_dot v."""
    for i in range(m.reflected.shape[0]):
        own, out = m.reflected[i], d.reflected[i]
        if own.coordinate < 0:
            a, b = d.body[own.body[0]], d.body[own.body[1]]
            n, w_b = arm(b, own.axis), vec(b.w)
            out.bias = dot(cross(w_b, n), sub(w_b, vec(a.w)))
            put6(out.J[0], scale(0.0, n), scale(-1.0, n))
            put6(out.J[1], scale(0.0, n), n)
            continue
        _, out.bias, la, ta, lb, tb = coordinate(m, d, own.coordinate, t)
        put6(out.J[0], la, ta)
        put6(out.J[1], lb, tb)


@inner_kernel
def fill_primitive(m, d, p, t):
    """Fill the rows of one primitive with all that its signal and teaching switches do to them."""
    fill(m, d, p, t)
    if p.kind == ORIENT:  # has all of its signals in it
        return
    if m.gamma == 0.0:  # teaching switch: drop -J_dot v, keep the drivers' b_dot
        for k in range(p.row, p.row + p.rows):
            d.row[k].gamma = 0.0
    if p.signal >= 0:
        prescribe(m, d.row[p.row], p, t)


@kernel
def rows(m, d, t):
    """Fill c, J, b, gamma of all rows, and the rates of reflected inertias; needs kinematics."""
    if m.reflected.shape[0] > 0:
        reflected_rates(m, d, t)
    for i in range(m.primitive.shape[0]):
        fill_primitive(m, d, m.primitive[i], t)
    if m.stabilisation == BAUMGARTE:
        for k in range(m.row.shape[0]):
            d.row[k].gamma -= m.baumgarte_velocity * row_speed(m, d, k) + m.baumgarte_position * d.row[k].c


@kernel
def rows_of(m, d, primitives, t):
    """Fill c, J, b, gamma of the rows of some primitives, and the rates of reflected inertias; needs kinematics."""
    if m.reflected.shape[0] > 0:
        reflected_rates(m, d, t)
    for i in primitives:
        fill_primitive(m, d, m.primitive[i], t)
