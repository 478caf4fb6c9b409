"""Newton's method for an implicit step: the equations as a residual r(x), and their matrix by complex steps.

        [ M v_dot + h - Q + J' lam ]
    r = [ z_dot - g                ]      x = (v_dot, z_dot, lam) at the end of the step, lam of the rows in use
        [ (J v - b) / h_v          ]

A change dx moves the end of the step by dv = h_v dx, dz = h_v dx and dq = h_q P T dx: T is the tangent of the
exponential map, P the mass-weighted projection onto c = 0 that the position goes through. One complex evaluation
along that motion is one column of dr/dx, exact: no difference formula, no terms dropped by hand.
"""

from typing import NamedTuple

import numpy as np

from ..compiler.arguments import by_reference
from ..compiler.decorators import inner_kernel, kernel, late_kernel
from ..dynamics.applied_forces import loads
from ..dynamics.state_rates import correction
from ..kernels.kinds import PROJECTION
from ..kernels.kinematics import kinematics, quaternion_rate
from ..kernels.layout import Data, Model
from ..kernels.rows import row_speed, rows
from ..kernels.vectors import add, copy, cross, dot, mat, pair, put6, rotate, scale, sub, vec

COMPLEX_STEP = 1e-40  # [1] imaginary part of a complex step: its square vanishes, so derivatives are exact to rounding


@by_reference
class Newton(NamedTuple):
    """Unknowns, matrix and work space; arrays in the layout of y use its velocity and z parts only."""

    rate: np.ndarray  # (ny,) v_dot (angular part in body axes) and z_dot at the end of the step
    lam: np.ndarray  # (m,) multipliers at the end of the step, zero in skipped rows
    move: np.ndarray  # (n, 3) rotation vector of the step, body axes
    x: np.ndarray  # (6 n + internal states + m,) residual, then correction
    rest: np.ndarray  # the residual that is left to solve for
    A: np.ndarray  # its matrix dr/dx, then its factors L and U
    pivot: np.ndarray  # row exchanges
    data: Data  # complex work space
    y_c: np.ndarray  # (ny,) complex state,
    rate_c: np.ndarray  # rates
    x_c: np.ndarray  # and residual


def new_newton(model: Model, data: Data) -> Newton:
    """Allocate the memory for steps of a model; ``data`` is a complex work space."""
    n, m, ny = model.body.size, model.row.size, 13 * model.body.size + model.state.size
    size = 6 * n + model.z_work + m
    return Newton(
        rate=np.zeros(ny), lam=np.zeros(m), move=np.zeros((n, 3)), x=np.zeros(size), rest=np.zeros(size),
        A=np.zeros((size, size)), pivot=np.zeros(size, np.int64), data=data, y_c=np.zeros(ny, complex),
        rate_c=np.zeros(ny, complex), x_c=np.zeros(size, complex),
    )  # fmt: skip


@inner_kernel
def inertia_force(fixed, body, linear, alpha):
    """Return M_b (r_ddot, alpha) as force and moment about O in world axes; alpha in body axes."""
    s, R = vec(body.s), mat(body.R)
    force = scale(fixed.mass, add(linear, cross(rotate(R, alpha), s)))
    return force, add(cross(s, force), rotate(R, rotate(mat(fixed.inertia), alpha)))


@inner_kernel
def add_reflected_force(m, d, i, rate, r):
    """Add the inertia force of reflected inertia i to the residuals of its bodies."""
    own, on, n = d.reflected[i], m.reflected[i].body, m.body.shape[0]
    total = own.bias + 0.0 * rate[0]
    for end in range(2):
        if on[end] < n:
            u, (linear, angular) = 7 * n + 6 * on[end], pair(own.J[end])
            alpha = rotate(mat(d.body[on[end]].R), (rate[u + 3], rate[u + 4], rate[u + 5]))
            total += dot(linear, (rate[u], rate[u + 1], rate[u + 2])) + dot(angular, alpha)
    for end in range(2):
        if on[end] < n:
            for j in range(6):
                r[6 * on[end] + j] += m.reflected[i].inertia * total * own.J[end, j]


@kernel
def residual(m, d, s, t, y, rate, lam, h_v, r):
    """Evaluate r at (t, y) for the given rates and multipliers; leave kinematics, rows and loads in d."""
    kinematics(m, d, y)
    rows(m, d, t)
    for k in range(m.row.shape[0]):
        d.row[k].lam = lam[k]  # friction reads them
    loads(m, d, t)
    n, nz = m.body.shape[0], m.z_work
    for i in range(n):
        body, u = d.body[i], 7 * n + 6 * i
        linear, alpha = (rate[u], rate[u + 1], rate[u + 2]), (rate[u + 3], rate[u + 4], rate[u + 5])
        force, moment = inertia_force(m.body[i], body, linear, alpha)
        pull, pull_moment = pair(body.h)
        load, load_moment = pair(body.Q)
        put6(r[6 * i : 6 * i + 6], sub(add(force, pull), load), sub(add(moment, pull_moment), load_moment))
    for i in range(m.reflected.shape[0]):
        add_reflected_force(m, d, i, rate, r)
    for j in range(nz):
        r[6 * n + j] = rate[13 * n + j] - d.state_rate[j]
    for i in range(s.used.shape[0]):
        k = s.used[i]
        r[6 * n + nz + i] = row_speed(m, d, k) / h_v
        for slot in range(4):
            b = m.row[k].body[slot]
            if 0 <= b < n:
                for j in range(6):
                    r[6 * b + j] += d.row[k].J[slot, j] * lam[k]


@kernel
def tangent(x, a):
    """Return T(x) a: turn of the end of exp(x) when x changes by a, body axes (Bruels, Cardona, Arnold 2012)."""
    square = dot(x, x)
    first, second = 0.5 - square / 24.0, 1.0 / 6.0 - square / 120.0
    if square > 1e-3:
        angle = np.sqrt(square)
        first, second = (1.0 - np.cos(angle)) / square, (angle - np.sin(angle)) / (square * angle)
    turned = cross(x, a)
    return add(sub(a, scale(first, turned)), scale(second, cross(x, turned)))


@inner_kernel
def displacement(d, w, j, h_q):
    """Return (dr, dtheta) in world axes of the body that a unit of acceleration j moves."""
    b, k = j // 6, j % 6
    unit = (1.0 if k % 3 == 0 else 0.0, 1.0 if k % 3 == 1 else 0.0, 1.0 if k % 3 == 2 else 0.0)
    zero = scale(0.0, unit)
    if k < 3:
        return scale(h_q, unit), zero
    return zero, scale(h_q, rotate(mat(d.body[b].R), tangent(vec(w.move[b]), unit)))


@inner_kernel
def push_pose(m, d, s, w, j, h_q):
    """Set the imaginary part of the pose for a unit of acceleration j, projected onto the tangent of c = 0."""
    b, n = j // 6, m.body.shape[0]
    dr, turn = displacement(d, w, j, h_q)
    for i in range(n):
        put6(d.body[i].acceleration, scale(0.0, dr), scale(0.0, dr))
    if m.stabilisation == PROJECTION and s.used.shape[0] > 0:
        for i in range(s.used.shape[0]):
            k = s.used[i]
            d.row[k].bottom = 0.0
            for slot in range(4):
                if m.row[k].body[slot] == b and m.row[k].holonomic == 1:
                    linear, angular = pair(d.row[k].J[slot])
                    d.row[k].bottom -= dot(linear, dr) + dot(angular, turn)
        correction(m, d, s)
    for i in range(n):
        linear, angular = pair(d.body[i].acceleration)
        if i == b:
            linear, angular = add(linear, dr), add(angular, turn)
        q, e_dot = 7 * i, quaternion_rate(d.body[i].e, angular)
        for k in range(3):
            w.y_c[q + k] += 1j * COMPLEX_STEP * linear[k]
        for k in range(4):
            w.y_c[q + 3 + k] += 1j * COMPLEX_STEP * e_dot[k]


@late_kernel
def add_friction_of_multipliers(m, s, w, t, y):
    """Add to A what the multipliers change of the loads: those of friction by reactions."""
    n, d = m.body.shape[0], w.data
    for k in range(y.shape[0]):
        w.y_c[k] = y[k]
    kinematics(m, d, w.y_c)
    rows(m, d, t)
    for k in range(m.row.shape[0]):
        d.row[k].lam = w.lam[k]
    for i in range(s.used.shape[0]):
        row = d.row[s.used[i]]
        row.lam += 1j * COMPLEX_STEP
        loads(m, d, t)
        row.lam -= 1j * COMPLEX_STEP
        for b in range(n):
            for j in range(6):
                w.A[6 * b + j, 6 * n + m.z_work + i] -= d.body[b].Q[j].imag / COMPLEX_STEP


@inner_kernel
def same_branch(d, data):
    """Make the complex work space unwrap its angles against the same accepted state."""
    for i in range(d.coordinate.shape[0]):
        data.coordinate[i].value = d.coordinate[i].value
        data.coordinate[i].rate = d.coordinate[i].rate
    data.unwrap_time[0] = d.unwrap_time[0]


@kernel
def fill_matrix(m, d, s, w, t, y, h_q, h_v):
    """Fill A = dr/dx at y; needs rows and factor of the pose of y in d and s.

    Exact but for the curvature of c = 0 over the distance that the projection moved y: fourth digit of a large step.
    """
    n, nz = m.body.shape[0], m.z_work
    size = 6 * n + nz + s.used.shape[0]
    same_branch(d, w.data)
    for j in range(6 * n + nz):
        for k in range(y.shape[0]):
            w.y_c[k] = y[k]
            w.rate_c[k] = w.rate[k]
        if j < 6 * n:
            push_pose(m, d, s, w, j, h_q)
        w.y_c[7 * n + j] += 1j * COMPLEX_STEP * h_v
        w.rate_c[7 * n + j] += 1j * COMPLEX_STEP
        residual(m, w.data, s, t, w.y_c, w.rate_c, w.lam, h_v, w.x_c)
        for i in range(size):
            w.A[i, j] = w.x_c[i].imag / COMPLEX_STEP
    for i in range(s.used.shape[0]):
        column, k = 6 * n + nz + i, s.used[i]
        for j in range(size):
            w.A[j, column] = 0.0
        w.A[column, column] = -s.state.mu / m.row[k].scale ** 2  # rows may repeat each other; Newton takes it away
        for slot in range(4):
            b = m.row[k].body[slot]
            if 0 <= b < n:
                for j in range(6):
                    w.A[6 * b + j, column] += d.row[k].J[slot, j]
    if m.frictions > 0:
        add_friction_of_multipliers(m, s, w, t, y)


@inner_kernel
def lu_factor(A, pivot, n):
    """Factorise P A = L U in place with row exchanges; return False for a zero or NaN pivot."""
    for k in range(n):
        p = k
        for i in range(k + 1, n):
            if abs(A[i, k]) > abs(A[p, k]):
                p = i
        pivot[k] = p
        if not abs(A[p, k]) > 0.0:
            return False
        if p != k:
            for j in range(n):
                A[k, j], A[p, j] = A[p, j], A[k, j]
        for i in range(k + 1, n):
            if A[i, k] != 0.0:
                f = A[i, k] / A[k, k]
                A[i, k] = f
                for j in range(k + 1, n):
                    A[i, j] -= f * A[k, j]
    return True


@inner_kernel
def lu_solve(A, pivot, x, n):
    """Solve x := A^-1 x from the factors."""
    for k in range(n):
        p = pivot[k]
        x[k], x[p] = x[p], x[k]
    for i in range(n):
        for j in range(i):
            x[i] -= A[i, j] * x[j]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            x[i] -= A[i, j] * x[j]
        x[i] /= A[i, i]


@inner_kernel
def solve_for_correction(m, s, w):
    """Solve x := A^-1 x with the minimum-norm multipliers of redundant rows.

    Where the pose has turned since A was made, such rows differ by what no motion of A gives, and mu turns that into
    huge multipliers. The first solution has the motion right: the second asks the rows for no more than it gives.
    """
    free, count = 6 * m.body.shape[0] + m.z_work, s.used.shape[0]
    size = free + count
    copy(w.rest, w.x)
    lu_solve(w.A, w.pivot, w.x, size)
    for i in range(count):
        w.rest[free + i] += s.state.mu / m.row[s.used[i]].scale ** 2 * w.x[free + i]
    copy(w.x, w.rest)
    lu_solve(w.A, w.pivot, w.x, size)


@inner_kernel
def filtered(m, d, s, w, e):
    """Set e := A^-1 M e on velocities and internal states, which removes stiff motion: h_v^2 K >> M."""
    n, nz = m.body.shape[0], m.z_work
    size = 6 * n + nz + s.used.shape[0]
    for i in range(n):
        u = 7 * n + 6 * i
        force, moment = inertia_force(m.body[i], d.body[i], (e[u], e[u + 1], e[u + 2]), (e[u + 3], e[u + 4], e[u + 5]))
        put6(w.x[6 * i : 6 * i + 6], force, moment)
    for j in range(6 * n, size):
        w.x[j] = e[7 * n + j] if j < 6 * n + nz else 0.0
    lu_solve(w.A, w.pivot, w.x, size)
    for j in range(6 * n + nz):
        e[7 * n + j] = w.x[j]
