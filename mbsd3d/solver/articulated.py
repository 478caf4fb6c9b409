"""Elimination of bodies and tree joints from the leaves to the roots, by what each joint holds and leaves free.

The rows J of a link have directions Z with J Z = 1, and leave others free, J N = 0 (`joint_basis`). A body moves as its
parent does and in its joint, a = X a_p + y + N x, y = Z b with b the right side of the rows, and its equation
I a + J' lam + G' mu = p, G the loop rows it feels, loses lam along N:

    D x = N'(p - G' mu - I (X a_p + y)),   D = N' I N

so the parent sees I_p + X' P' I P X, P = 1 - N D^-1 N' I, and never an inverse of the body's own inertia: light bodies
between heavy ones cost no digits. One free direction after the other is taken out, as in a Cholesky factorisation.
The rows themselves are lam = Z'(p - G' mu - I a). Featherstone, Rigid Body Dynamics Algorithms, chapter 7.

A reflected inertia R of the joint's coordinate, whose rate is j (v - X v_p), adds R (j N)(j N)' to D, takes
R (j N)(j y) from the load along N and R (j (a - X a_p)) Z'j from lam; it never adds to I. With it N'(p - I a) is not
zero, and the load that was handed down is p - I a less what N has kept: `held_back`. A ball has three of the same R,
which add R 1 to D: its directions N are turns about axes that are perpendicular to each other.
"""

from ..compiler.decorators import fused_kernel, inner_kernel
from ..kernels.vectors import add, add6, cross, dot, mat, pair, put, put6, rotate, rotate_back, scale, sub, vec
from .joint_basis import hold, row_on_body
from .spatial_inertia import (
    along6,
    dot6,
    less_outer,
    moved_inertia,
    moved_load,
    moved_motion,
    product,
    sub9,
    times,
    transposed,
)

ROUNDING = 1e-13  # [1] of its terms: pivot that is rounding of their difference


@inner_kernel
def put9(array, a):
    """Set array = a, nine numbers."""
    for j in range(9):
        array[j] = a[j]


@fused_kernel
def body_inertia(fixed, body):
    """Return (A, B, C) of the mass matrix of a body about O: m 1, -m [s]x, R I_G R' - m [s]x[s]x."""
    mass, s, R = fixed.mass, vec(body.s), mat(body.R)
    x, y, z = mass * s[0], mass * s[1], mass * s[2]
    zero = 0.0 * x
    B = (zero, z, -y, -z, zero, x, y, -x, zero)
    A = (zero + mass, zero, zero, zero, zero + mass, zero, zero, zero, zero + mass)
    C = product(product(R, mat(fixed.inertia)), transposed(R))
    xx, yy, zz = x * s[0], y * s[1], z * s[2]
    xy, yz, zx = x * s[1], y * s[2], z * s[0]
    return A, B, sub9(C, (-yy - zz, xy, zx, xy, -xx - zz, yz, zx, yz, -xx - yy))


@inner_kernel
def reflected_share(m, d, link, n, x):
    """Return R (j n)(j x), summed over the reflected inertias R of the joint of a link."""
    total = 0.0 * n[0][0]
    for i in range(link.reflected, link.reflected + link.reflections):
        j = pair(d.reflected[i].J[link.side])
        total += m.reflected[i].inertia * dot6(j, n) * dot6(j, x)
    return total


@inner_kernel
def held_back(link, a):
    """Return sum u (e - u a / D) over the free directions: what they keep of the load of a link that moves at a."""
    load = scale(0.0, a[0]), scale(0.0, a[1])
    for k in range(link.rows, 6):
        u = pair(link.u[k])
        load = along6(load, link.e[k] - dot6(u, a) * link.inverse[k], u)
    return load


@inner_kernel
def less_reflected(m, d, link, f, x):
    """Return the load f of a link less what the reflected inertias of its joint take to move at x."""
    for i in range(link.reflected, link.reflected + link.reflections):
        j = pair(d.reflected[i].J[link.side])
        f = along6(f, -m.reflected[i].inertia * dot6(j, x), j)
    return f


@inner_kernel
def less_rotor(m, d, s, link, f, a):
    """Return what of the load f of a link, which moves at a, its joint carries beside its reflected inertias."""
    f = along6(f, 1.0, held_back(link, a))
    if link.up >= 0:
        carried = moved_motion(pair(s.link[link.up].a), vec(link.d))
        a = sub(a[0], carried[0]), sub(a[1], carried[1])
    return less_reflected(m, d, link, f, a)


@fused_kernel
def take_out_of_loops(s, link, k, n, u, inverse):
    """Take what free direction k yields out of the loop rows that a link feels."""
    for e in range(link.entry, link.entry + link.entries):
        at = s.entry[e]
        G = pair(at.G)
        share = dot6(G, n)
        at.e[k] = share
        linear, angular = along6(G, -inverse * share, u)
        put6(at.G, linear, angular)


@fused_kernel
def hand_loops(s, link):
    """Add what is left of the loop rows of a link to those of its parent."""
    for e in range(link.entry, link.entry + link.entries):
        at = s.entry[e]
        if at.next >= 0:
            linear, angular = moved_load(pair(at.G), vec(link.d))
            add6(s.entry[at.next].G, linear, angular)


@inner_kernel
def start_loops(d, s, link):
    """Set the loop rows of a link to those that stand on its own body."""
    for e in range(link.entry, link.entry + link.entries):
        at = s.entry[e]
        for j in range(6):
            at.G[j] = 0.0
        if at.slot >= 0:
            linear, angular = row_on_body(d.row[s.loop[at.place].row], at.slot, at.twin)
            put6(at.G, linear, angular)


@fused_kernel
def take_out(m, d, s, link):
    """Factor the free directions and take what they yield out of inertia and loop rows; False for a zero pivot."""
    A, B, C = mat(link.A), mat(link.B), mat(link.C)
    size = abs((A[0] + A[4] + A[8]).real) + abs((C[0] + C[4] + C[8]).real) / m.length**2
    for k in range(link.rows, 6):
        n = pair(link.basis[k])
        u = times(A, B, C, n)
        pivot = dot6(n, u) + reflected_share(m, d, link, n, n)
        if not pivot.real > ROUNDING * size * (dot(n[0], n[0]) + m.length**2 * dot(n[1], n[1])).real:
            return False
        inverse = 1.0 / pivot
        put6(link.u[k], u[0], u[1])
        link.inverse[k] = inverse
        A, B, C = (
            less_outer(A, inverse, u[0], u[0]),
            less_outer(B, inverse, u[0], u[1]),
            less_outer(C, inverse, u[1], u[1]),
        )
        take_out_of_loops(s, link, k, n, u, inverse)
    put9(link.A, A)
    put9(link.B, B)
    put9(link.C, C)
    return True


@fused_kernel
def hand_down(s, link):
    """Add the remaining inertia and loop rows of a link to its parent."""
    if link.up < 0:
        return
    up, shift = s.link[link.up], vec(link.d)
    A, B, C = mat(link.A), mat(link.B), mat(link.C)
    B, C = moved_inertia(A, B, C, shift)
    for j in range(9):
        up.A[j] += A[j]
        up.B[j] += B[j]
        up.C[j] += C[j]
    hand_loops(s, link)


@inner_kernel
def start_links(m, d, s):
    """Set inertias, levers and direct loop rows of all links, before the elimination."""
    for i in range(s.link.shape[0]):
        link = s.link[i]
        body = d.body[link.body]
        if link.alone == 1:
            continue
        A, B, C = body_inertia(m.body[link.body], body)
        put9(link.A, A)
        put9(link.B, B)
        put9(link.C, C)
        if link.up >= 0:
            parent = d.body[s.link[link.up].body]
            for j in range(3):
                link.d[j] = body.r[j] - parent.r[j]
        start_loops(d, s, link)


@inner_kernel
def factor_links(m, d, s):
    """Eliminate all links from the leaves to the roots; set ``dense`` or ``worn`` where that cannot be done."""
    start_links(m, d, s)
    for i in range(s.link.shape[0]):
        link = s.link[i]
        if link.alone == 1:
            continue
        if not hold(m, d, s, link):
            s.state.worn = 1
            s.state.dense = 1
            return
        if not take_out(m, d, s, link):
            s.state.dense = 1
            return
        hand_down(s, link)


@fused_kernel
def prescribed(d, s, link):
    """Return y: the acceleration that the right sides of the rows prescribe along the directions they hold."""
    y = scale(0.0, vec(link.d)), scale(0.0, vec(link.d))
    for j in range(link.rows):
        y = along6(y, d.row[s.joint[link.joint + j].row].bottom, pair(link.basis[j]))
    return y


@inner_kernel
def load_links(m, d, s):
    """Carry the loads of all links from the leaves to the roots, and form the right side of the loop rows."""
    for i in range(s.link.shape[0]):
        for j in range(6):
            s.link[i].p[j] = 0.0
    for i in range(s.link.shape[0]):
        link = s.link[i]
        body = d.body[link.body]
        if link.alone == 1:
            continue
        force, moment = pair(body.top)
        p = pair(link.p)
        p = add(p[0], force), add(p[1], add(moment, rotate(mat(body.R), vec(body.turn))))
        y = prescribed(d, s, link)
        for k in range(link.rows, 6):
            n = pair(link.basis[k])
            share = (dot6(n, p) - reflected_share(m, d, link, n, y)) * link.inverse[k]
            link.e[k] = share
            p = along6(p, -share, pair(link.u[k]))
        put6(link.p, p[0], p[1])
        put6(link.y, y[0], y[1])
        for e in range(link.entry, link.entry + link.entries):
            at = s.entry[e]
            total = dot6(pair(at.G), y)
            for k in range(link.rows, 6):
                total += at.e[k] * link.e[k]
            s.vector[0, at.place] += total
        if link.up >= 0:
            up = s.link[link.up]
            force, moment = times(mat(link.A), mat(link.B), mat(link.C), y)
            p = along6(p, -1.0, (force, moment))
            force, moment = moved_load(p, vec(link.d))
            for j in range(3):
                up.p[j] += force[j]
                up.p[3 + j] += moment[j]


@inner_kernel
def solve_alone(fixed, body):
    """Return the acceleration of a free body from force and moment about G, the moment in body axes."""
    force, moment = pair(body.top)
    s, R = vec(body.s), mat(body.R)
    moment = add(rotate_back(R, add(moment, cross(force, s))), vec(body.turn))
    alpha = rotate(mat(fixed.inv_inertia), moment)
    w = rotate(R, alpha)
    put(body.alpha, alpha)
    put6(body.acceleration, add(scale(fixed.inv_mass, force), cross(s, w)), w)


@inner_kernel
def move_links(m, d, s):
    """Compute accelerations from the roots to the leaves and multipliers of links; those of loop rows are known."""
    for i in range(s.link.shape[0] - 1, -1, -1):
        link = s.link[i]
        body = d.body[link.body]
        if link.alone == 1:
            solve_alone(m.body[link.body], body)
            continue
        p, a = pair(link.p), pair(link.y)
        if link.up >= 0:
            carried = moved_motion(pair(s.link[link.up].a), vec(link.d))
            a = add(a[0], carried[0]), add(a[1], carried[1])
        for e in range(link.entry, link.entry + link.entries):
            at = s.entry[e]
            lam = s.vector[0, at.place]
            p = along6(p, -lam, pair(at.G))
            for k in range(link.rows, 6):
                link.e[k] -= at.e[k] * link.inverse[k] * lam
        for k in range(5, link.rows - 1, -1):
            a = along6(a, link.e[k] - dot6(pair(link.u[k]), a) * link.inverse[k], pair(link.basis[k]))
        put6(link.a, a[0], a[1])
        put6(body.acceleration, a[0], a[1])
        put(body.alpha, rotate_back(mat(body.R), a[1]))
        if link.rows > 0:
            f = along6(p, -1.0, times(mat(link.A), mat(link.B), mat(link.C), a))
            if link.reflections > 0:
                f = less_rotor(m, d, s, link, f, a)
            for j in range(link.rows):
                d.row[s.joint[link.joint + j].row].lam = dot6(pair(link.basis[j]), f)
