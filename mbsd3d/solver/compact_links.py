"""Mechanisms of hinges, slides and free bodies: the elimination of `articulated` in a quarter of its memory.

The joints of the tree need no rows (`compact_joints`): the child moves as its parent does and by y + n x, y as its
joint prescribes, and its load F, M, without what n keeps of it, is that of the joint. Rows that close loops are taken
along as there, so `loop_rows` serves both. Inertias [A B; B' C] are 6, 9, 6 numbers, since A and C are symmetric. The
first child of a body sets what it hands down, the others add to it.

A free body has M = [A B; B' C] = L D L' in two blocks, A and C - B'A^-1 B; it is seen by a loop row G as e = L^-1 G.
"""

from ..compiler.decorators import fused_kernel, inner_kernel, kernel
from ..kernels.kinds import COMPACT_ALONE, COMPACT_FREE
from ..kernels.rows import row_speed
from ..kernels.vectors import add, add6, cross, dot, mat, pair, put, put6, rotate, rotate_back, scale, sub, vec
from .articulated import (
    ROUNDING,
    hand_loops,
    less_reflected,
    reflected_share,
    solve_alone,
    start_loops,
    take_out_of_loops,
)
from .compact_joints import ACCELERATIONS, NOTHING, SPEEDS, hold, joint_rows, largest_gap, prescribed, set_multipliers
from .loop_rows import factor_loops, note_gap, solve_loops
from .spatial_inertia import along6, dot6, less_outer


@fused_kernel
def six(a):
    """Return an array of 6 as a tuple."""
    return a[0], a[1], a[2], a[3], a[4], a[5]


@fused_kernel
def symmetric(S, a):
    """Return S a of a symmetric matrix (xx, xy, xz, yy, yz, zz)."""
    return (
        S[0] * a[0] + S[1] * a[1] + S[2] * a[2],
        S[1] * a[0] + S[3] * a[1] + S[4] * a[2],
        S[2] * a[0] + S[4] * a[1] + S[5] * a[2],
    )


@fused_kernel
def inertia_times(A, B, C, a):
    """Return [A B; B' C] a."""
    return add(symmetric(A, a[0]), rotate(B, a[1])), add(rotate_back(B, a[0]), symmetric(C, a[1]))


@fused_kernel
def symmetric_less(S, k, a):
    """Return S - k a a'."""
    x, y, z = k * a[0], k * a[1], k * a[2]
    return (
        S[0] - x * a[0], S[1] - x * a[1], S[2] - x * a[2], S[3] - y * a[1], S[4] - y * a[2], S[5] - z * a[2],
    )  # fmt: skip


@fused_kernel
def put_inertia(link, A, B, C):
    """Set the inertia of a link."""
    for j in range(6):
        link.A[j], link.C[j] = A[j], C[j]
    for j in range(9):
        link.B[j] = B[j]


@fused_kernel
def add_inertia(link, A, B, C):
    """Add to the inertia of a link."""
    for j in range(6):
        link.A[j] += A[j]
        link.C[j] += C[j]
    for j in range(9):
        link.B[j] += B[j]


@fused_kernel
def whole_inertia(fixed, body, link):
    """Return (A, B, C) of a body about O, m 1, -m [s]x, R I_G R' - m [s]x[s]x, with what the links beyond it added."""
    mass, s, R, I = fixed.mass, vec(body.s), mat(body.R), mat(fixed.inertia)
    x, y, z = scale(mass, s)
    r, q, p = (R[0], R[1], R[2]), (R[3], R[4], R[5]), (R[6], R[7], R[8])
    a, b, c = rotate(I, r), rotate(I, q), rotate(I, p)
    xx, yy, zz = x * s[0], y * s[1], z * s[2]
    A, B = (mass, 0.0, 0.0, mass, 0.0, mass), (0.0, z, -y, -z, 0.0, x, y, -x, 0.0)
    C = (
        dot(a, r) + (yy + zz), dot(a, q) - x * s[1], dot(a, p) - x * s[2],
        dot(b, q) + (xx + zz), dot(b, p) - y * s[2], dot(c, p) + (xx + yy),
    )  # fmt: skip
    if link.leaf == 1:
        return A, B, C
    K, M, N = six(link.A), mat(link.B), six(link.C)
    return (
        (A[0] + K[0], K[1], K[2], A[3] + K[3], K[4], A[5] + K[5]),
        (M[0], B[1] + M[1], B[2] + M[2], B[3] + M[3], M[4], B[5] + M[5], B[6] + M[6], B[7] + M[7], M[8]),
        (C[0] + N[0], C[1] + N[1], C[2] + N[2], C[3] + N[3], C[4] + N[4], C[5] + N[5]),
    )


@fused_kernel
def hand_inertia(A, B, C, d, first, up):
    """Add an inertia to that of the parent, whose O is at -d: A, B - A [d]x, C - B'[d]x + [d]x (B - A [d]x)."""
    x, y, z = cross((A[0], A[1], A[2]), d), cross((A[1], A[3], A[4]), d), cross((A[2], A[4], A[5]), d)
    N = (
        B[0] - x[0], B[1] - x[1], B[2] - x[2], B[3] - y[0], B[4] - y[1], B[5] - y[2], B[6] - z[0], B[7] - z[1],
        B[8] - z[2],
    )  # fmt: skip
    x, y, z = cross((B[0], B[3], B[6]), d), cross((B[1], B[4], B[7]), d), cross((B[2], B[5], B[8]), d)
    p, q, r = cross(d, (N[0], N[3], N[6])), cross(d, (N[1], N[4], N[7])), cross(d, (N[2], N[5], N[8]))
    C = (
        C[0] - x[0] + p[0], C[1] - x[1] + q[0], C[2] - x[2] + r[0], C[3] - y[1] + q[1], C[4] - y[2] + r[1],
        C[5] - z[2] + r[2],
    )  # fmt: skip
    if first == 1:
        put_inertia(up, A, N, C)
    else:
        add_inertia(up, A, N, C)


@fused_kernel
def take_out(m, d, s, i):
    """Take what n yields out of inertia and loop rows, and hand them to the parent; False for a zero pivot."""
    link = s.compact[i]
    A, B, C = whole_inertia(m.body[link.body], d.body[link.body], link)
    n = pair(link.n)
    u = inertia_times(A, B, C, n)
    pivot = dot6(n, u)
    if link.reflections > 0:
        pivot += reflected_share(m, d, link, n, n)
    size = A[0] + A[3] + A[5] + (C[0] + C[3] + C[5]) / m.length**2
    inverse = 1.0 / pivot
    A, B, C = symmetric_less(A, inverse, u[0]), less_outer(B, inverse, u[0], u[1]), symmetric_less(C, inverse, u[1])
    put_inertia(link, A, B, C)
    put6(link.u, u[0], u[1])
    link.inverse = inverse
    if link.up >= 0:
        hand_inertia(A, B, C, vec(link.d), link.opens, s.compact[link.up])
    if link.entries > 0:
        s.link[i].inverse[5] = inverse
        take_out_of_loops(s, link, 5, n, u, inverse)
        hand_loops(s, link)
    return pivot > ROUNDING * size * (dot(n[0], n[0]) + m.length**2 * dot(n[1], n[1]))


@fused_kernel
def factor3(S):
    """Return (1/d_0, l_10, l_20, 1/d_1, l_21, 1/d_2) of L D L' = S, a symmetric matrix."""
    i0 = 1.0 / S[0]
    l10, l20 = S[1] * i0, S[2] * i0
    i1 = 1.0 / (S[3] - l10 * S[1])
    l21 = (S[4] - l20 * S[1]) * i1
    return i0, l10, l20, i1, l21, 1.0 / (S[5] - l20 * S[2] - l21 * l21 / i1)


@fused_kernel
def forward3(L, x):
    """Return L^-1 x of a factor of three."""
    y = x[1] - L[1] * x[0]
    return x[0], y, x[2] - L[2] * x[0] - L[4] * y


@fused_kernel
def solve3(L, x):
    """Return S^-1 x by the factor of S."""
    a, b, c = forward3(L, x)
    z = c * L[5]
    y = b * L[3] - L[4] * z
    return a * L[0] - L[1] * y - L[2] * z, y, z


@inner_kernel
def meet_loops(s, i, L, K):
    """Set pivots and e = L^-1 G of the loop rows that a free body feels."""
    link, out = s.compact[i], s.link[i]
    put6(out.inverse, (L[0], L[3], L[5]), (K[0], K[3], K[5]))
    for e in range(link.entry, link.entry + link.entries):
        at = s.entry[e]
        force, moment = pair(at.G)
        put6(at.e, forward3(L, force), forward3(K, sub(moment, rotate_back(mat(link.B), force))))


@fused_kernel
def factor_free(m, d, s, i):
    """Set the inertia of a free body to factors of A and of C - B'A^-1 B, and A^-1 B; False for a zero pivot."""
    link = s.compact[i]
    A, B, C = whole_inertia(m.body[link.body], d.body[link.body], link)
    a, b, c = (B[0], B[3], B[6]), (B[1], B[4], B[7]), (B[2], B[5], B[8])
    L = factor3(A)
    x, y, z = solve3(L, a), solve3(L, b), solve3(L, c)
    K = factor3(
        (C[0] - dot(a, x), C[1] - dot(a, y), C[2] - dot(a, z), C[3] - dot(b, y), C[4] - dot(b, z), C[5] - dot(c, z))
    )
    put_inertia(link, L, (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]), K)
    if link.entries > 0:
        meet_loops(s, i, L, K)
    greatest = 1.0 / (ROUNDING * (A[0] + A[3] + A[5] + (C[0] + C[3] + C[5]) / m.length**2))
    one, other = max(L[0], L[3], L[5]), max(K[0], K[3], K[5]) * m.length**2
    return min(L[0], L[3], L[5], K[0], K[3], K[5]) > 0.0 and one < greatest and other < greatest


@fused_kernel
def solve_free(link, p):
    """Return the acceleration of a free body under the load p of it and of all that it carries."""
    X = mat(link.B)
    alpha = solve3(six(link.C), sub(p[1], rotate_back(X, p[0])))
    return sub(solve3(six(link.A), p[0]), rotate(X, alpha)), alpha


@fused_kernel
def own_load(body, asked):
    """Return the load Q - h of a body; none where positions or velocities are projected."""
    if asked != ACCELERATIONS:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    force, moment = pair(body.Q)
    pull, _ = pair(body.h)
    return sub(force, pull), sub(sub(moment, cross(vec(body.s), pull)), rotate(mat(body.R), vec(body.spin)))


@fused_kernel
def whole_load(m, d, link, asked):
    """Return the load of a body with what the links beyond it, and the bias of reflected inertias, add."""
    p = own_load(d.body[link.body], asked)
    if link.leaf == 0:
        p = along6(p, 1.0, pair(link.p))
    if asked == ACCELERATIONS:
        for k in range(link.reflected, link.reflected + link.reflections):
            p = along6(p, -m.reflected[k].inertia * d.reflected[k].bias, pair(d.reflected[k].J[link.side]))
    return p


@fused_kernel
def hand_load(m, d, link, f, asked, up):
    """Add a load to that of the parent."""
    f = f[0], add(f[1], cross(vec(link.d), f[0]))
    if asked == ACCELERATIONS:
        for k in range(link.reflected, link.reflected + link.reflections):
            f = along6(f, -m.reflected[k].inertia * d.reflected[k].bias, pair(d.reflected[k].J[1 - link.side]))
    if link.opens == 1:
        put6(up.p, f[0], f[1])
    else:
        add6(up.p, f[0], f[1])


@fused_kernel
def load(m, d, s, link, y, asked):
    """Carry the load of a link to its parent, with what it takes to move at y."""
    p, n, u = whole_load(m, d, link, asked), pair(link.n), pair(link.u)
    share = dot6(n, p)
    if link.reflections > 0:
        share -= reflected_share(m, d, link, n, y)
    share *= link.inverse
    p = along6(p, -share, u)
    link.share = share
    for e in range(link.entry, link.entry + link.entries):
        at = s.entry[e]
        s.vector[0, at.place] += dot6(pair(at.G), y) + at.e[5] * share
    put6(link.p, p[0], p[1])
    put6(link.y, y[0], y[1])
    if link.up >= 0:
        f = inertia_times(six(link.A), mat(link.B), six(link.C), y)
        hand_load(m, d, link, (sub(p[0], f[0]), sub(p[1], f[1])), asked, s.compact[link.up])


@inner_kernel
def load_alone(body, asked):
    """Set the right side of a free body that nothing touches."""
    force, moment = own_load(body, asked)
    put6(body.top, force, add(moment, rotate(mat(body.R), vec(body.spin))))
    put(body.turn, scale(-1.0, vec(body.spin)))


@inner_kernel
def load_free(m, d, s, link, asked):
    """Carry the load of a free body with all beyond it into the loop rows."""
    p = whole_load(m, d, link, asked)
    put6(link.p, p[0], p[1])
    if link.entries > 0:
        a = solve_free(link, p)
        for e in range(link.entry, link.entry + link.entries):
            s.vector[0, s.entry[e].place] += dot6(pair(s.entry[e].G), a)


@inner_kernel
def mark_regular(s):
    """Say of a compact tree what `saddle_point.factor` says of any before its loop rows."""
    s.state.dense, s.state.worn, s.state.graded, s.state.weak, s.state.pivot = 0, 0, 0, 0, 1.0


@inner_kernel
def ask_loops(m, d, s, asked):
    """Set the right side of the loop rows as far as it does not depend on the links."""
    for i in range(s.loop.shape[0]):
        k = s.loop[i].row
        if asked == ACCELERATIONS:
            s.vector[0, i] = -d.row[k].gamma
        else:
            s.vector[0, i] = row_speed(m, d, k) if asked == SPEEDS else d.row[k].c


@inner_kernel
def finish_loops(d, s, asked, anew):
    """Factor and solve the loop rows after the links; False where they need what only `saddle_point` knows."""
    if anew == 1:
        factor_loops(s)
        if s.state.dense == 1 or s.state.graded == 1:
            return False
    if asked != NOTHING:
        solve_loops(s)
        for i in range(s.loop.shape[0]):
            d.row[s.loop[i].row].lam = s.vector[0, i]
    return True


@kernel
def go_down(m, d, s, asked, anew):
    """Carry loads from the leaves to the roots, and inertias if the factor is to be made ``anew``; then close loops.

    ``asked``: what joints and loop rows make up for. Of ACCELERATIONS bodies have their loads Q - h, else none. False
    where a pivot vanishes.
    """
    closed = s.loop.shape[0] > 0
    if closed:
        ask_loops(m, d, s, asked)
        if anew == 1:
            note_gap(m, d, s, largest_gap(m, d, s).real if s.state.idle == 1 else 0.0)
        for i in range(s.compact.shape[0] if anew == 1 else 0):
            start_loops(d, s, s.compact[i])
    for i in range(s.compact.shape[0]):
        link = s.compact[i]
        if link.kind == COMPACT_ALONE:
            load_alone(d.body[link.body], asked)
        elif link.kind == COMPACT_FREE:
            if anew == 1 and not factor_free(m, d, s, i):
                return False
            load_free(m, d, s, link, asked)
        else:
            arms, v, turns, values = joint_rows(d, link, asked)
            if anew == 1 and not (hold(d, link, arms, turns) and take_out(m, d, s, i)):
                return False
            if asked != NOTHING:
                load(m, d, s, link, prescribed(link, v, values), asked)
    return finish_loops(d, s, asked, anew) if closed else True


@inner_kernel
def less_loops(s, link, p):
    """Return the load p of a link less that of the loop rows it feels."""
    for e in range(link.entry, link.entry + link.entries):
        p = along6(p, -s.vector[0, s.entry[e].place], pair(s.entry[e].G))
    return p


@inner_kernel
def free_share(s, link):
    """Return the acceleration along the free direction of a link as far as its load and the loop rows give it."""
    share = link.share
    for e in range(link.entry, link.entry + link.entries):
        share -= s.entry[e].e[5] * link.inverse * s.vector[0, s.entry[e].place]
    return share


@inner_kernel
def carried(s, link):
    """Return how a link moves with its parent."""
    if link.up < 0:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    a, w = pair(s.compact[link.up].a)
    return add(a, cross(w, vec(link.d))), w


@inner_kernel
def go_up(m, d, s, asked):
    """Compute accelerations from the roots to the leaves."""
    for i in range(s.compact.shape[0] - 1, -1, -1):
        link = s.compact[i]
        body = d.body[link.body]
        if link.kind == COMPACT_ALONE:
            if asked == ACCELERATIONS:
                solve_alone(m.body[link.body], body)
            else:
                put6(body.acceleration, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
                put(body.alpha, (0.0, 0.0, 0.0))
            continue
        if link.kind == COMPACT_FREE:
            a = solve_free(link, less_loops(s, link, pair(link.p)))
        else:
            y, (linear, angular) = pair(link.y), carried(s, link)
            a = add(y[0], linear), add(y[1], angular)
            a = along6(a, free_share(s, link) - link.inverse * dot6(pair(link.u), a), pair(link.n))
        put6(link.a, a[0], a[1])
        put6(body.acceleration, a[0], a[1])
        put(body.alpha, rotate_back(mat(body.R), a[1]))


@fused_kernel
def joint_load(m, d, s, link):
    """Return the load of a link that its joint carries, about the O of its body, after `go_up`."""
    p, a = less_loops(s, link, pair(link.p)), pair(link.a)
    f = inertia_times(six(link.A), mat(link.B), six(link.C), a)
    f = sub(p[0], f[0]), sub(p[1], f[1])
    if link.reflections > 0:  # what n has kept of the load as well: see `articulated`
        u, (linear, angular) = pair(link.u), carried(s, link)
        f = along6(f, free_share(s, link) - link.inverse * dot6(u, a), u)
        f = less_reflected(m, d, link, f, (sub(a[0], linear), sub(a[1], angular)))
    return f


@kernel
def set_link_multipliers(m, d, s):
    """Set the multipliers of the joints of all links, which no rate needs, after `go_up` for accelerations."""
    for i in range(s.compact.shape[0]):
        link = s.compact[i]
        if link.kind != COMPACT_ALONE and link.kind != COMPACT_FREE:
            set_multipliers(d, link, joint_load(m, d, s, link))


@inner_kernel
def store_ground_reaction(m, d, s, out):
    """Store force and moment about O of the ground that the joints of links exert on the bodies, after `go_up`."""
    force, moment = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for i in range(s.compact.shape[0]):
        link = s.compact[i]
        if link.up < 0 and link.kind != COMPACT_ALONE and link.kind != COMPACT_FREE:
            f, (arm_on_child, arm_on_ground) = joint_load(m, d, s, link), pair(link.arm)
            force = sub(force, f[0])
            moment = sub(moment, add(f[1], cross(sub(arm_on_ground, arm_on_child), f[0])))
    put6(out, force, moment)
