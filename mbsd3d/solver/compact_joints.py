"""Joints of compact links, hinges and slides, whose rows need not be formed: see `compact_links`.

What such a joint holds and leaves free is known before anything is computed. With n = x_a cross y_b of each row
x_a . y_b = 0, p_a and p_b the points of the joint on its bodies a and b, and z an axis of a,

    hinge  p_b - p_a = 0 and two turns n_1, n_2            free: the turn about n_1 cross n_2 through the point
    slide  z cross (p_b - p_a) = 0 in axes of a, and       free: the shift along z
           three turns n_1, n_2, n_3

so directions and multipliers are a few products of vectors. The load F, M about O that the joint carries has lam = F in
the rows of the point, and those of the turns are their dual vectors times M less the moment of F.
"""

import numpy as np

from ..compiler.decorators import fused_kernel, inner_kernel
from ..kernels.kinds import COMPACT_ALONE, COMPACT_FREE, COMPACT_SLIDE
from ..kernels.vectors import add, cross, dot, mat, pair, put, put6, rotate, scale, sub, turning, vec
from .joint_basis import ROW_DEPENDENCE_MAX

# what the joints are asked to make up for: -c, -J v, gamma, or nothing, where a factor is all that is wanted
GAPS, SPEEDS, ACCELERATIONS, NOTHING = np.int64(0), np.int64(1), np.int64(2), np.int64(3)


@fused_kernel
def turn_row(x, y, wx, wy, asked):
    """Return (n = x cross y, what is asked of x . y): the row is J v = n . (w_x - w_y)."""
    n, w = cross(x, y), sub(wx, wy)
    if asked == ACCELERATIONS:  # as in `kernels.rows.axes_dot`
        return n, dot(w, w) * dot(x, y) - dot(w, x) * dot(wx, y) + dot(w, y) * dot(wy, x)
    return n, -dot(n, w) if asked == SPEEDS else -dot(x, y)


@fused_kernel
def joint_rows(d, link, asked):
    """Return (arms on child and parent, what is asked of p_b - p_a, three turns and what is asked of them) of a joint.

    A slide measures in axes of body a, and has the arm of the point of b on both bodies. The third turn of a hinge is
    the one it leaves free.
    """
    a, b = d.body[link.on[0]], d.body[link.on[1]]
    Ra, Rb, wa, wb = mat(a.R), mat(b.R), vec(a.w), vec(b.w)
    sa, sb = rotate(Ra, vec(link.point[0])), rotate(Rb, vec(link.point[1]))
    slides = link.kind == COMPACT_SLIDE
    ask = sub(turning(wa, sa), turning(wb, sb))
    if slides or asked != ACCELERATIONS:
        gap = sub(add(vec(b.r), sb), add(vec(a.r), sa))
        rate = sub(add(vec(b.velocity), cross(wb, sb)), add(vec(a.velocity), cross(wa, sa)))
        if slides:
            carried = cross(wa, gap)
            ask = add(ask, cross(wa, sub(scale(2.0, rate), carried)))
            rate, sa = sub(rate, carried), add(sa, gap)
        if asked == SPEEDS:
            ask = scale(-1.0, rate)
        elif asked != ACCELERATIONS:
            ask = scale(-1.0, gap)
    z = rotate(Rb, vec(link.axis[2]))
    x, of_x = turn_row(rotate(Ra, vec(link.axis[0])), z, wa, wb, asked)
    y, of_y = turn_row(rotate(Ra, vec(link.axis[1])), z, wa, wb, asked)
    z, of_z = cross(x, y), 0.0 * of_x
    if slides:
        z, of_z = turn_row(rotate(Ra, vec(link.slide[0])), rotate(Rb, vec(link.slide[1])), wa, wb, asked)
    return (sb, sa) if link.sign > 0.0 else (sa, sb), ask, (x, y, z), (of_x, of_y, of_z)


@fused_kernel
def slide_axis(d, link):
    """Return the direction of a slide: across the normals of its two rows of the point."""
    R = mat(d.body[link.on[0]].R)
    return cross(rotate(R, vec(link.slide[2])), rotate(R, vec(link.slide[3])))


@fused_kernel
def duals(link, x, y, z):
    """Return (vectors dual to the turns x, y, z; False where these depend on each other); z of a hinge is x cross y."""
    xx, yy, zz = dot(x, x), dot(y, y), dot(z, z)
    if link.kind == COMPACT_SLIDE:
        p, q, r = cross(y, z), cross(z, x), cross(x, y)
        volume = dot(x, p)
    else:
        xy, volume = dot(x, y), zz
        p, q, r = sub(scale(yy, x), scale(xy, y)), sub(scale(xx, y), scale(xy, x)), z
    inverse, apart = 1.0 / volume, volume * volume > ROW_DEPENDENCE_MAX**2 * (xx * yy * zz)
    return scale(inverse, p), scale(inverse, q), scale(inverse, r), apart


@fused_kernel
def hold(d, link, arms, turns):
    """Set the duals of the turns and the free direction n; False where turns have become dependent on each other."""
    x, y, z, apart = duals(link, turns[0], turns[1], turns[2])
    put6(link.t, x, y)
    put(link.t[6:], z)
    put6(link.arm, arms[0], arms[1])
    put(link.d, sub(vec(d.body[link.body].r), vec(d.body[link.parent].r)))
    if link.kind == COMPACT_SLIDE:
        put6(link.n, slide_axis(d, link), (0.0, 0.0, 0.0))
    else:
        put6(link.n, cross(arms[0], z), z)
    return apart


@fused_kernel
def across(link, v):
    """Return v without its part along the axis of a slide, which has the length 1."""
    z = vec(link.n)
    return sub(v, scale(dot(z, v), z))


@fused_kernel
def prescribed(link, v, turns):
    """Return y: the acceleration of the child, beside that of its parent, that a joint prescribes."""
    t, u = pair(link.t)
    turn = scale(-link.sign, add(scale(turns[0], t), scale(turns[1], u)))
    if link.kind == COMPACT_SLIDE:
        turn = add(turn, scale(-link.sign * turns[2], vec(link.t[6:])))
    shift = add(scale(link.sign, v), cross(vec(link.arm), turn))
    return (across(link, shift) if link.kind == COMPACT_SLIDE else shift), turn


@fused_kernel
def set_multipliers(d, link, f):
    """Set the multipliers of the rows of a link by the load f that its joint carries."""
    first, sign = link.row, link.sign
    moment = sub(f[1], cross(vec(link.arm), f[0]))
    x, y = pair(link.t)
    k = first + 3
    if link.kind == COMPACT_SLIDE:
        R, k = mat(d.body[link.on[0]].R), first + 2
        d.row[first].lam = sign * dot(rotate(R, vec(link.slide[2])), f[0])
        d.row[first + 1].lam = sign * dot(rotate(R, vec(link.slide[3])), f[0])
        d.row[first + 4].lam = -sign * dot(vec(link.t[6:]), moment)
    else:
        for j in range(3):
            d.row[first + j].lam = sign * f[0][j]
    d.row[k].lam = -sign * dot(x, moment)
    d.row[k + 1].lam = -sign * dot(y, moment)


@inner_kernel
def larger(largest, size):
    """Return the larger of two residuals; NaN counts, and stays."""
    return size if largest == largest and not size <= largest else largest


@inner_kernel
def largest_gap(m, d, s):
    """Return the largest scaled |c| of the joints of all links (units of the model's length, radians)."""
    largest = 0.0
    for i in range(s.compact.shape[0]):
        link = s.compact[i]
        if link.kind == COMPACT_ALONE or link.kind == COMPACT_FREE:
            continue
        _, gap, _, (x, y, z) = joint_rows(d, link, GAPS)
        if link.kind == COMPACT_SLIDE:
            axis = slide_axis(d, link)
            gap = sub(gap, scale(dot(axis, gap), axis))
        size = max(max(abs(gap[0]), abs(gap[1]), abs(gap[2])) / m.length, abs(x), abs(y), abs(z))
        largest = larger(largest, size + 0.0 * (gap[0] + gap[1] + gap[2] + x + y + z))  # NaN where there is one
    return largest
