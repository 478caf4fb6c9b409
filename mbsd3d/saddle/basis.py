"""The directions that the rows of a link hold, and those they leave free: one orthogonal basis in the scaled metric.

J_c = R Z_r' by orthogonalising row after row; angular parts in units of `Model.length`. Joint types play no part. No
direction is brought to unit length, which would take a root each; the diagonal of R, which is 1, holds 1 / Z_j'Z_j.
"""

import numpy as np

from ..compiler.jit import fused_kernel, kernel
from ..kernels.vectors import add, pair, put6, scale
from .spatial import along6, dot6

INDEPENDENT = 0.05  # part of a row that must be left when the rows before it are taken out, for a link to take it
DEPENDENT = 1e-5  # what may be left of a row of a link, relative to it, when the rows before it are taken out


@fused_kernel
def row_on_body(row, slot, twin):
    """(force, moment about O) of a unit multiplier of a row on the body of a slot; of both slots if it has two."""
    force, moment = pair(row.J[slot])
    if twin >= 0:
        more_force, more_moment = pair(row.J[twin])
        force, moment = add(force, more_force), add(moment, more_moment)
    return force, moment


@fused_kernel
def hold(m, d, s, link):
    """basis and R of the rows of a link by orthogonalisation; False where a row has become dependent on the others."""
    to_angle = 1.0 / m.length
    for j in range(link.rows):
        at = s.joint[link.joint + j]
        linear, angular = row_on_body(d.row[at.row], at.slot, at.twin)
        v = linear, scale(to_angle, angular)
        link.e[j] = dot6(v, v)
        put6(link.basis[j], v[0], v[1])
    for i in range(link.rows):  # row i out of all that follow: they do not wait for each other
        q = pair(link.basis[i])
        rest = dot6(q, q)
        if not rest.real > DEPENDENT**2 * link.e[i].real:
            return False
        inverse = 1.0 / rest
        link.R[i, i] = inverse
        for j in range(i + 1, link.rows):
            v = pair(link.basis[j])
            along = dot6(q, v) * inverse
            link.R[j, i] = along
            v = along6(v, -along, q)
            put6(link.basis[j], v[0], v[1])
    return True


@fused_kernel
def unit(k, zero):
    """Unit 6-vector k in the number type of ``zero``."""
    return (
        (zero + (1.0 if k == 0 else 0.0), zero + (1.0 if k == 1 else 0.0), zero + (1.0 if k == 2 else 0.0)),
        (zero + (1.0 if k == 3 else 0.0), zero + (1.0 if k == 4 else 0.0), zero + (1.0 if k == 5 else 0.0)),
    )


@fused_kernel
def release(m, link):
    """The directions of the basis that the rows leave free; then all of them from the scaled metric to SI units."""
    basis, left = link.basis, link.e
    for k in range(6):  # of the axes' squares, outside the directions there are
        left[k] = 1.0
        for i in range(link.rows):
            left[k] -= basis[i, k] * basis[i, k] * link.R[i, i]
    for j in range(link.rows, 6):
        best = 0
        for k in range(1, 6):
            if left[k].real > left[best].real:
                best = k
        v = unit(best, 0.0 * left[0])  # at least a sixth of its square is left, so one pass loses no digits
        for i in range(j):
            v = along6(v, -basis[i, best] * link.R[i, i], pair(basis[i]))
        link.R[j, j] = 1.0 / dot6(v, v)
        put6(basis[j], v[0], v[1])
        for k in range(6):
            left[k] -= basis[j, k] * basis[j, k] * link.R[j, j]
    to_angle = 1.0 / m.length
    for j in range(6):
        for k in range(3, 6):
            basis[j, k] *= to_angle


@kernel
def choose_joint_rows(m, d, joint, first, Q, chosen):
    """chosen[j] = 1 for the rows of each link that are well independent of those before; Q (6, 6) is work space."""
    for i in range(first.shape[0] - 1):
        count = 0
        for j in range(first[i], first[i + 1]):
            linear, angular = row_on_body(d.row[joint[j].row], joint[j].slot, joint[j].twin)
            v = linear, scale(1.0 / m.length, angular)
            before = dot6(v, v)
            for k in range(count):
                q = pair(Q[k])
                v = along6(v, -dot6(q, v), q)
            rest = dot6(v, v)
            if count < 6 and rest > INDEPENDENT**2 * before:
                size = 1.0 / np.sqrt(rest)
                put6(Q[count], scale(size, v[0]), scale(size, v[1]))
                chosen[j] = 1
                count += 1
