"""Directions that the rows of a link hold, Z with J Z = 1, and directions that they leave free, N with J N = 0.

So an acceleration that meets J a = b is Z b + N x, and a load f = J' lam has lam = Z'f. Rows that only turn the body
come last, J = [L A; 0 T]. Where the rows of L are as independent as those of T, both are inverted as three vectors
each; else rows are orthogonalised one after the other, angular parts in units of `Model.length`. Joint types play no
part, and nothing takes a root.
"""

import numpy as np

from ..compiler.decorators import fused_kernel, kernel
from ..kernels.vectors import add, cross, dot, pair, put6, scale
from .spatial_inertia import along6, dot6

# [1] of a row: least part left, without the rows before it, for a link to take the row at once, and to take it at all
ROW_PREFERRED_MIN, ROW_INDEPENDENCE_MIN = 0.2, 0.05
BLOCK_PIVOT_MIN = 0.01  # [1] of a row: part left below which L is not inverted as a block any more
ROW_DEPENDENCE_MAX = 0.03  # [1] of a row: part left, without the rows before it, at which other rows are due


@fused_kernel
def row_on_body(row, slot, twin):
    """Return (force, moment about O) of a unit multiplier on the body of a slot, of both slots if it has two."""
    force, moment = pair(row.J[slot])
    if twin >= 0:
        more_force, more_moment = pair(row.J[twin])
        force, moment = add(force, more_force), add(moment, more_moment)
    return force, moment


@fused_kernel
def row_of_link(d, joint, j):
    """Return (force, moment about O) of a unit multiplier of row j of ``Tree.joint`` on the body of its link."""
    at = joint[j]
    return row_on_body(d.row[at.row], at.slot, at.twin)


@fused_kernel
def orthogonalise(m, d, s, link):
    """Set basis to orthogonal directions of the rows of a link; False where a row has become dependent on the others.

    Row j is basis_j + sum_i R[j, i] basis_i, i < j; no direction is brought to unit length, R[j, j] is 1 / basis_j^2.
    """
    R, to_angle = link.u, 1.0 / m.length
    for j in range(link.rows):
        linear, angular = row_of_link(d, s.joint, link.joint + j)
        v = linear, scale(to_angle, angular)
        link.e[j] = dot6(v, v)
        put6(link.basis[j], v[0], v[1])
    for i in range(link.rows):  # row i out of all that follow: they do not wait for each other
        q = pair(link.basis[i])
        rest = dot6(q, q)
        if not rest.real > ROW_DEPENDENCE_MAX**2 * link.e[i].real:
            return False
        inverse = 1.0 / rest
        R[i, i] = inverse
        for j in range(i + 1, link.rows):
            v = pair(link.basis[j])
            along = dot6(q, v) * inverse
            R[j, i] = along
            v = along6(v, -along, q)
            put6(link.basis[j], v[0], v[1])
    return True


@fused_kernel
def unit(k, zero):
    """Return unit 6-vector k in the number type of ``zero``."""
    return (
        (zero + (1.0 if k == 0 else 0.0), zero + (1.0 if k == 1 else 0.0), zero + (1.0 if k == 2 else 0.0)),
        (zero + (1.0 if k == 3 else 0.0), zero + (1.0 if k == 4 else 0.0), zero + (1.0 if k == 5 else 0.0)),
    )


@fused_kernel
def release(link):
    """Set the orthogonal directions that those of the rows leave free."""
    R, basis, left = link.u, link.basis, link.e
    for k in range(6):  # of the axes' squares, outside the directions there are
        left[k] = 1.0
        for i in range(link.rows):
            left[k] -= basis[i, k] * basis[i, k] * R[i, i]
    for j in range(link.rows, 6):
        best = 0
        for k in range(1, 6):
            if left[k].real > left[best].real:
                best = k
        v = unit(best, 0.0 * left[0])  # at least a sixth of its square is left, so one pass loses no digits
        for i in range(j):
            v = along6(v, -basis[i, best] * R[i, i], pair(basis[i]))
        R[j, j] = 1.0 / dot6(v, v)
        put6(basis[j], v[0], v[1])
        for k in range(6):
            left[k] -= basis[j, k] * basis[j, k] * R[j, j]


@fused_kernel
def invert(m, link):
    """Turn the orthogonal directions Q of the rows into Z = Q R^-1, and all from the scaled metric into SI units."""
    R, to_angle = link.u, 1.0 / m.length
    for j in range(link.rows - 1, -1, -1):
        q = pair(link.basis[j])
        z = scale(R[j, j], q[0]), scale(R[j, j], q[1])
        for k in range(j + 1, link.rows):
            z = along6(z, -R[k, j], pair(link.basis[k]))
        put6(link.basis[j], z[0], z[1])
    for j in range(6):
        for k in range(3, 6):
            link.basis[j, k] *= to_angle


@fused_kernel
def three_rows(d, s, link, first, count):
    """Return (linear, angular) of up to three rows of a link on its body; zeros beyond ``count``."""
    zero = 0.0 * link.d[0]
    none = (zero, zero, zero), (zero, zero, zero)
    return (
        row_of_link(d, s.joint, link.joint + first) if count > 0 else none,
        row_of_link(d, s.joint, link.joint + first + 1) if count > 1 else none,
        row_of_link(d, s.joint, link.joint + first + 2) if count > 2 else none,
    )


@fused_kernel
def dual(x, y, z, count, least):
    """Return (True, dual basis of ``count`` vectors and of others across them); False if the vectors are dependent.

    Their volume is then below ``least`` times that of a box.
    """
    if count == 0:
        zero = 0.0 * x[0]
        return True, unit(0, zero)[0], unit(1, zero)[0], unit(2, zero)[0]
    if count == 1:
        a, b, c = abs(x[0].real), abs(x[1].real), abs(x[2].real)
        y = cross(x, unit(0 if a <= b and a <= c else (1 if b <= c else 2), 0.0 * x[0])[0])
    if count < 3:
        z = cross(x, y)
    yz, zx, xy = cross(y, z), cross(z, x), cross(x, y)
    volume = dot(x, yz)
    box = dot(x, x).real * dot(y, y).real * dot(z, z).real
    inverse = 1.0 / volume
    return volume.real * volume.real > least**2 * box, scale(inverse, yz), scale(inverse, zx), scale(inverse, xy)


@fused_kernel
def hold_blocks(d, s, link, least):
    """Set the basis of a link whose first ``lines`` rows are [L A], the others [0 T]; False where they are dependent.

    With l_i and t_i the dual vectors of L and T, each completed to three, the directions are (l_i, 0) and
    (-sum_j l_j (A_j . t_i), t_i). Where L = 1 or -1 holds a point, the sum is t_i cross its arm.
    """
    basis, lines, turns = link.basis, link.lines, link.rows - link.lines
    (_, a), (_, b), (_, c) = three_rows(d, s, link, lines, turns)
    apart, a, b, c = dual(a, b, c, turns, ROW_DEPENDENCE_MAX)
    if not apart:
        return False
    (x, ax), (y, ay), (z, az) = three_rows(d, s, link, 0, lines)
    none = scale(0.0, x)
    if link.point == 1:
        arm = x[0] * ay[2], x[0] * az[0], x[0] * ax[1]  # a row is (1, arm x 1) along its axis
        u, v, w = cross(arm, a), cross(arm, b), cross(arm, c)
    else:
        apart, x, y, z = dual(x, y, z, lines, least)
        if not apart:
            return False
        u, v, w = shift(x, y, z, ax, ay, az, a), shift(x, y, z, ax, ay, az, b), shift(x, y, z, ax, ay, az, c)
    put6(basis[0 if lines > 0 else turns], x, none)
    put6(basis[1 if lines > 1 else turns + 1], y, none)
    put6(basis[2 if lines > 2 else turns + 2], z, none)
    put6(basis[lines if turns > 0 else 3], u, a)
    put6(basis[lines + 1 if turns > 1 else 4], v, b)
    put6(basis[lines + 2 if turns > 2 else 5], w, c)
    return True


@fused_kernel
def shift(x, y, z, ax, ay, az, t):
    """Return -sum_j l_j (A_j . t): the shift by which a turn t moves none of the rows [L A]; A_j = 0 without a row."""
    return add(scale(-dot(ax, t), x), add(scale(-dot(ay, t), y), scale(-dot(az, t), z)))


@fused_kernel
def hold(m, d, s, link):
    """Set basis := Z of the rows of a link, then N; False where a row has become dependent on the others."""
    if link.lines >= 0:
        return hold_blocks(d, s, link, BLOCK_PIVOT_MIN)
    if not orthogonalise(m, d, s, link):
        return False
    release(link)
    invert(m, link)
    return True


@kernel
def choose_blocks(d, s):
    """Keep blocks for the links whose rows are well independent in both; set lines = -1 for the others."""
    for i in range(s.link.shape[0]):
        link = s.link[i]
        if link.lines >= 0 and not hold_blocks(d, s, link, ROW_INDEPENDENCE_MIN):
            link.lines = -1


@kernel
def choose_joint_rows(m, d, joint, first, Q, chosen):
    """Set chosen[j] = 1 for rows of each link that are well independent of those before; Q (6, 6) is work space.

    A second pass takes what is less so, where the first one left a direction open.
    """
    for i in range(first.shape[0] - 1):
        count, rows = 0, first[i + 1] - first[i]
        for each in range(2 * rows):
            j, least = first[i] + each % rows, ROW_PREFERRED_MIN if each < rows else ROW_INDEPENDENCE_MIN
            if chosen[j] == 1:
                continue
            linear, angular = row_of_link(d, joint, j)
            v = linear, scale(1.0 / m.length, angular)
            before = dot6(v, v)
            for k in range(count):
                q = pair(Q[k])
                v = along6(v, -dot6(q, v), q)
            rest = dot6(v, v)
            if count < 6 and rest > least**2 * before:
                size = 1.0 / np.sqrt(rest)
                put6(Q[count], scale(size, v[0]), scale(size, v[1]))
                chosen[j] = 1
                count += 1
