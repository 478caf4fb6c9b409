"""Rows of contacts on curves: a point of b beside a curve of a, a flat face of b on one."""

from .coordinates import highest, nearest, slide_along
from .curves import GROUP, group
from .jit import inner_kernel
from .surfaces import contact_row
from .vectors import add, arm, cross, dot, mat, put6, rotate, scale, sub, vec


@inner_kernel
def on_curve(m, d, row, p, t):
    """c = E(s) . (p_b - x(s)) - value[0] at the nearest point of the curve, E its group of directions value[1]."""
    a, b = d.body[p.body[0]], d.body[p.body[1]]
    _, s_dot, s_ddot, ds, k, u, off, along, bend, speed = nearest(m, d, p.coordinate[0], t)
    E, E_rate, E_bend, _ = group(m.number, k + GROUP * int(p.value[1]), u)
    shift = dot(E_rate, off) - dot(E, along)  # dc / ds
    bent = dot(E_bend, off) - 2.0 * dot(E_rate, along) - dot(E, bend)
    n, sb = rotate(mat(a.R), add(E, scale(shift, ds))), arm(b, p.point[1])
    _, bias, la, ta, lb, tb = slide_along(a, b, n, (0.0, 0.0, 0.0), sb)
    row.c = dot(E, off) - p.value[0]
    row.gamma = -bias - (2.0 * dot(E_rate, speed) + bent * s_dot) * s_dot - shift * s_ddot
    put6(row.J[0], la, ta)
    put6(row.J[1], lb, tb)


@inner_kernel
def on_face(m, d, row, p, t):
    """c = n_b . (p_b - x(s)) where the curve is highest over the face of b with the normal n_b."""
    a, b = d.body[p.body[0]], d.body[p.body[1]]
    _, s_dot, _, _, x, along, _ = highest(m, d, p.coordinate[0], t)
    R, n, sb, wa, wb = mat(a.R), arm(b, p.axis[1]), arm(b, p.point[1]), vec(a.w), vec(b.w)
    arm_a = rotate(R, x)
    arm_b = add(sub(vec(a.r), vec(b.r)), arm_a)
    arm_a_dot = add(cross(wa, arm_a), scale(s_dot, rotate(R, along)))
    arm_b_dot = add(sub(vec(a.velocity), vec(b.velocity)), arm_a_dot)
    row.c = dot(n, sub(sb, arm_b))
    contact_row(row, a, b, n, cross(wb, n), arm_b, arm_a, cross(wb, arm_b_dot), arm_a_dot)
