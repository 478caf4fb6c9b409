"""Compiled planar dynamics: loads and the saddle point, reduced to the rows.

M = U'U with U v = (sqrt(m) v_G, sqrt(I_G) w), v_G = v_O + w k x s. With Y = J U^-1

    Y Y' lam = Y U^-T (Q - h) - gamma,      v_dot = U^-1 (U^-T (Q - h) - Y' lam)

and S = Y Y' = L D L' is factored by Cholesky within the profile of its ordered lines.
"""

import numpy as np

from engines.planar.rows import SPRING, TORSION, arm, inner, motion, put, rates

PIVOT_RATIO_MIN = 1e-13  # [1] of the diagonal of a row; smaller pivots are redundant rows


@inner
def factor(m, w):
    """Compute Y = J U^-1, S = Y Y' and its factors L D L'; return the first place whose pivot vanishes, or -1."""
    for e in range(m.entry.shape[0]):
        k, i = m.entry[e, 0], m.entry[e, 2]
        J, Y, frame = w.J[k], w.Y[k], w.frame[i]
        Y[0], Y[1] = J[0] * m.body[i, 4], J[1] * m.body[i, 4]
        Y[2] = (J[2] + J[0] * frame[3] - J[1] * frame[2]) * m.body[i, 5]
    for i in range(m.first.shape[0]):
        for j in range(m.first[i], i + 1):
            w.S[i, j] = 0.0
    for k in range(m.product.shape[0]):
        Y, Z = w.Y[m.product[k, 2]], w.Y[m.product[k, 3]]
        w.S[m.product[k, 0], m.product[k, 1]] += Y[0] * Z[0] + Y[1] * Z[1] + Y[2] * Z[2]
    for i in range(m.first.shape[0]):
        L = w.S[i]
        pivot, start = L[i], m.first[i]
        least = PIVOT_RATIO_MIN * pivot
        for j in range(start, i):  # D_j L_ij first
            K, total = w.S[j], L[j]
            for k in range(max(start, m.first[j]), j):
                total -= L[k] * K[k]
            L[j] = total
        for j in range(start, i):
            total = L[j] * w.S[j, j]
            pivot -= L[j] * total
            L[j] = total
        if not pivot > least:
            return i
        L[i] = 1.0 / pivot
    return -1


@inner
def solve(m, w):
    """Solve the saddle point for x and lam, with the loads ``top`` about O and the right side in ``lam``."""
    for i in range(w.top.shape[0] - 1):
        top, frame = w.top[i], w.frame[i]
        top[2] = (top[2] - frame[2] * top[1] + frame[3] * top[0]) * m.body[i, 5]
        top[0], top[1] = top[0] * m.body[i, 4], top[1] * m.body[i, 4]
    for i in range(w.lam.shape[0]):
        w.lam[i] = -w.lam[i]
    for e in range(m.entry.shape[0]):
        Y, top = w.Y[m.entry[e, 0]], w.top[m.entry[e, 2]]
        w.lam[m.entry[e, 1]] += Y[0] * top[0] + Y[1] * top[1] + Y[2] * top[2]
    for i in range(w.lam.shape[0]):
        total, L = w.lam[i], w.S[i]
        for k in range(m.first[i], i):
            total -= L[k] * w.lam[k]
        w.lam[i] = total
    for i in range(w.lam.shape[0]):
        w.lam[i] *= w.S[i, i]
    for i in range(w.lam.shape[0] - 1, -1, -1):
        L, x = w.S[i], w.lam[i]
        for k in range(m.first[i], i):
            w.lam[k] -= L[k] * x
    for e in range(m.entry.shape[0]):
        Y, top, lam = w.Y[m.entry[e, 0]], w.top[m.entry[e, 2]], w.lam[m.entry[e, 1]]
        for k in range(3):
            top[k] -= Y[k] * lam
    for i in range(w.top.shape[0] - 1):
        top, frame, turn = w.top[i], w.frame[i], w.top[i, 2] * m.body[i, 5]
        put(w.x[i], top[0] * m.body[i, 4] + turn * frame[3], top[1] * m.body[i, 4] - turn * frame[2], turn)


@inner
def push(w, i, x, y, fx, fy, turn):
    """Add a force at the arm (x, y) and a torque to the loads about O of body i."""
    w.top[i, 0] += fx
    w.top[i, 1] += fy
    w.top[i, 2] += x * fy - y * fx + turn


@inner
def loads(m, w, t, q, v):
    """Compute top := Q - h: weight, centripetal term, force elements."""
    for i in range(q.shape[0] - 1):
        mass, frame, pull = m.body[i, 0], w.frame[i], m.scale[0] * v[i, 2] * v[i, 2]
        put(w.top[i], 0.0, 0.0, 0.0)
        fx, fy = mass * (m.gravity[0] + pull * frame[2]), mass * (m.gravity[1] + pull * frame[3])
        push(w, i, frame[2], frame[3], fx, fy, 0.0)
    for k in range(m.load.shape[0]):
        kind, a, b, p = m.load[k, 0], m.load[k, 1], m.load[k, 2], m.load_value[k]
        if kind == TORSION:
            turn = -p[0] * (q[b, 2] - q[a, 2] - p[2]) - p[1] * (v[b, 2] - v[a, 2])
            push(w, a, 0.0, 0.0, 0.0, 0.0, -turn)
            push(w, b, 0.0, 0.0, 0.0, 0.0, turn)
            continue
        Bx, By = arm(w.frame[b], p[2], p[3])
        if kind == SPRING:
            Ax, Ay = arm(w.frame[a], p[0], p[1])
            ux, uy = q[b, 0] + Bx - q[a, 0] - Ax, q[b, 1] + By - q[a, 1] - Ay
            length = np.sqrt(ux * ux + uy * uy)
            nx, ny = ux / length, uy / length
            dx = v[b, 0] - v[b, 2] * By - v[a, 0] + v[a, 2] * Ay
            dy = v[b, 1] + v[b, 2] * Bx - v[a, 1] - v[a, 2] * Ax
            pull = p[4] * (length - p[6]) + p[5] * (nx * dx + ny * dy)
            push(w, a, Ax, Ay, pull * nx, pull * ny, 0.0)
            push(w, b, Bx, By, -pull * nx, -pull * ny, 0.0)
            continue
        size = motion(m, m.load_motion[k], t)[0]
        fx, fy = arm(w.frame[a], p[0], p[1])  # a: the body that carries the axes of the force
        push(w, b, Bx, By, size * fx, size * fy, size * p[4])


@inner
def accelerations(m, w, t, q, v):
    """Compute x := v_dot and lam; `rows` and `factor` have been at q."""
    rates(m, w, t, q, v)
    loads(m, w, t, q, v)
    for i in range(w.gamma.shape[0]):
        w.lam[m.place[i]] = w.gamma[i]
    solve(m, w)
