"""Compiled planar kinematics: the arrays of a planar system and its constraint rows.

Per body q = (x, y, theta) of the reference point O, v = q_dot, s = R(theta) r_G. With the saddle point

    [ M  J' ] [ v_dot ]   [ Q - h ]      M = [[m, 0, -m s_y], [0, m, m s_x], [-m s_y, m s_x, I_G + m s^2]]
    [ J  0  ] [  lam  ] = [ gamma ]      h = (-m w^2 s_x, -m w^2 s_y, 0)

The last row of every body array is the ground, which stays at rest.

Functions are compiled and cached on disk under a digest of the sources of the planar solver.
"""

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np

from mbsd3d.extend import CACHE_FOLDER, keep_code

JIT = not numba.config.DISABLE_JIT  # type: ignore[attr-defined]  # numba sets it when it is imported


def _digest() -> str:
    """Return the digest of every compiled file: numba's own cache misses edits in callees of other files."""
    text = hashlib.sha256(numba.__version__.encode())
    for name in ("rows", "saddle", "march"):
        text.update(Path(__file__).with_name(f"{name}.py").read_bytes())
    return text.hexdigest()[:16]


CACHE_FOLDER = CACHE_FOLDER.parent / f"planar-{_digest()}"


def _compiled(function: Callable, **options: object) -> Callable:
    """Compile in nopython mode without reference counts: the kernels allocate nothing."""
    options |= dict(error_model="numpy", nogil=True, _nrt=False, no_cfunc_wrapper=True)
    made = numba.njit(**options)(function)  # type: ignore[call-overload]  # numba's stubs lack some options
    return keep_code(made, CACHE_FOLDER)


def kernel(function: Callable) -> Callable:
    """Compile a function that allocates nothing."""
    return _compiled(function)


def inner(function: Callable) -> Callable:
    """Compile a kernel that is inlined into other kernels; its sums may be reordered and fused."""
    return _compiled(
        function, no_cpython_wrapper=JIT, fastmath={"contract", "reassoc", "nsz"},
        forceinline=True,
    )  # fmt: skip


COINCIDE, IN_LINE, ANGLE, DISTANCE, SECOND = range(5)  # SECOND: the second row of COINCIDE
FORCE, SPRING, TORSION = range(3)


class Model(NamedTuple):
    """Constants: n bodies and the ground, m rows, e non-ground entries of J, p products of entries in S, k loads."""

    body: np.ndarray  # (n + 1, 6): mass [kg], I_G [kg m^2], r_G (2) [m], 1/sqrt(mass), 1/sqrt(I_G)
    kind: np.ndarray  # (m,)
    slot: np.ndarray  # (m, 4) bodies; n is the ground
    value: np.ndarray  # (m, 8): points in body axes, factors, lengths; see `Row` of parts
    driven: np.ndarray  # (m,) whether a row has a motion
    motion: np.ndarray  # (m, 11): f(t) = sum c_k t^k (6) + A sin(w t + phase); or first of its pieces, their number
    entry: np.ndarray  # (e, 3): place in J (4 row + slot), place of the row in S, body
    product: np.ndarray  # (p, 4): line and column of S, the two places in J
    place: np.ndarray  # (m,) place of a row in S
    first: np.ndarray  # (m,) first column of a line of S
    load: np.ndarray  # (k, 3): kind, bodies
    load_value: np.ndarray  # (k, 8)
    load_motion: np.ndarray  # (k, 11)
    piece: np.ndarray  # (p, 5) of splines: start [s], c_0 ... c_3 of the time since then
    gravity: np.ndarray  # (2,) [m/s^2]
    scale: np.ndarray  # (2,): 1 or 0 with or without the centripetal term; size of the system, at least 1 [m]


class Work(NamedTuple):
    """Work arrays; body arrays have n + 1 rows."""

    frame: np.ndarray  # (n + 1, 4): cos, sin, s
    J: np.ndarray  # (4 m, 3)
    Y: np.ndarray  # (4 m, 3)
    c: np.ndarray  # (m,) residual
    rate: np.ndarray  # (m,) f_dot: J v = f_dot
    gamma: np.ndarray  # (m,)
    S: np.ndarray  # (m, m) lower triangle; after `factor` L of S = L D L', with 1 / D on the diagonal
    lam: np.ndarray  # (m,) in the order of S
    top: np.ndarray  # (n + 1, 3)
    x: np.ndarray  # (n + 1, 3) solution: acceleration, or a correction of q or v
    q: np.ndarray  # (n + 1, 3) of a stage
    v: np.ndarray
    dq: np.ndarray  # sums of the stages
    dv: np.ndarray


@inner
def spline(piece, low, high, t):
    """Evaluate the cubic of the last piece low ... high - 1 that has begun at t; the first and the last one
    extrapolate.
    """
    while high - low > 1:
        middle = (low + high) // 2
        if piece[middle, 0] <= t:
            low = middle
        else:
            high = middle
    p = piece[low]
    s = t - p[0]
    x = p[1] + s * (p[2] + s * (p[3] + s * p[4]))
    return x, p[2] + s * (2.0 * p[3] + 3.0 * s * p[4]), 2.0 * p[3] + 6.0 * s * p[4]


@inner
def motion(m, f, t):
    """Evaluate f, f_dot, f_ddot of the eleven numbers of a motion."""
    if f[10] > 0.0:
        return spline(m.piece, int(f[9]), int(f[9] + f[10]), t)
    x, v, a = 0.0, 0.0, 0.0
    for k in range(5, -1, -1):
        a = a * t + 2.0 * v
        v = v * t + x
        x = x * t + f[k]
    if f[6] != 0.0:
        s, c = f[6] * np.sin(f[7] * t + f[8]), f[6] * np.cos(f[7] * t + f[8])
        x, v, a = x + s, v + f[7] * c, a - f[7] * f[7] * s
    return x, v, a


@inner
def arm(frame, x, y):
    """Return R (x, y)."""
    return frame[0] * x - frame[1] * y, frame[1] * x + frame[0] * y


@inner
def put(J, x, y, turn):
    """Store the entries of one body in a row."""
    J[0], J[1], J[2] = x, y, turn


@inner
def place_bodies(m, w, q):
    """Set frame := (cos, sin, R r_G) of all bodies."""
    for i in range(q.shape[0]):
        frame = w.frame[i]
        frame[0], frame[1] = np.cos(q[i, 2]), np.sin(q[i, 2])
        frame[2], frame[3] = arm(frame, m.body[i, 2], m.body[i, 3])


@inner
def rows(m, w, t, q):
    """Compute frame, c and J of all rows at q; A and B are the arms R p of the points of bodies a and b, u = p_b -
    p_a."""
    place_bodies(m, w, q)
    for i in range(m.kind.shape[0]):
        kind, a, b, p = m.kind[i], m.slot[i, 0], m.slot[i, 1], m.value[i]
        if kind == SECOND:
            continue
        f = motion(m, m.motion[i], t)[0] if m.driven[i] else 0.0
        if kind == ANGLE:  # sum f_k theta_k + offset = f(t)
            total = p[4] - f
            for k in range(4):
                total += p[k] * q[m.slot[i, k], 2]
                put(w.J[4 * i + k], 0.0, 0.0, p[k])
            w.c[i] = total
            continue
        Ax, Ay = arm(w.frame[a], p[0], p[1])
        Bx, By = arm(w.frame[b], p[2], p[3])
        ux, uy = q[b, 0] + Bx - q[a, 0] - Ax, q[b, 1] + By - q[a, 1] - Ay
        if kind == COINCIDE:  # u = 0
            w.c[i], w.c[i + 1] = ux, uy
            put(w.J[4 * i], -1.0, 0.0, Ay)
            put(w.J[4 * i + 1], 1.0, 0.0, -By)
            put(w.J[4 * i + 4], 0.0, -1.0, -Ax)
            put(w.J[4 * i + 5], 0.0, 1.0, Bx)
        elif kind == IN_LINE:  # n_a . u + rho (theta_b - theta_a) + offset = f(t)
            nx, ny = arm(w.frame[a], p[4], p[5])
            w.c[i] = nx * ux + ny * uy + p[6] * (q[b, 2] - q[a, 2]) + p[7] - f
            put(w.J[4 * i], -nx, -ny, -((Ax + ux) * ny - (Ay + uy) * nx) - p[6])
            put(w.J[4 * i + 1], nx, ny, Bx * ny - By * nx + p[6])
        else:  # DISTANCE: |u| = l + f(t)
            length = np.sqrt(ux * ux + uy * uy)
            nx, ny = ux / length, uy / length
            w.c[i] = length - p[4] - f
            put(w.J[4 * i], -nx, -ny, -(Ax * ny - Ay * nx))
            put(w.J[4 * i + 1], nx, ny, Bx * ny - By * nx)


@inner
def rates(m, w, t, q, v):
    """Compute rate = f_dot and gamma = f_ddot - J_dot v; `rows` has been at q."""
    for i in range(m.kind.shape[0]):
        kind, a, b, p = m.kind[i], m.slot[i, 0], m.slot[i, 1], m.value[i]
        if kind == SECOND:
            continue
        w.rate[i], w.gamma[i] = 0.0, 0.0
        if m.driven[i]:
            _, w.rate[i], w.gamma[i] = motion(m, m.motion[i], t)
        if kind == ANGLE:
            continue
        Ax, Ay = arm(w.frame[a], p[0], p[1])
        Bx, By = arm(w.frame[b], p[2], p[3])
        wa, wb = v[a, 2], v[b, 2]
        gx, gy = wb * wb * Bx - wa * wa * Ax, wb * wb * By - wa * wa * Ay  # centripetal, on the right side
        if kind == COINCIDE:
            w.rate[i + 1] = 0.0
            w.gamma[i], w.gamma[i + 1] = gx, gy
            continue
        ux, uy = q[b, 0] + Bx - q[a, 0] - Ax, q[b, 1] + By - q[a, 1] - Ay
        dx = v[b, 0] - wb * By - v[a, 0] + wa * Ay
        dy = v[b, 1] + wb * Bx - v[a, 1] - wa * Ax
        nx, ny = w.J[4 * i + 1, 0], w.J[4 * i + 1, 1]
        w.gamma[i] += nx * gx + ny * gy
        if kind == IN_LINE:  # n turns with a: n_dot = wa k x n
            w.gamma[i] += 2.0 * wa * (ny * dx - nx * dy) + wa * wa * (nx * ux + ny * uy)
        else:  # n turns with u
            across = nx * dy - ny * dx
            w.gamma[i] -= across * across / np.sqrt(ux * ux + uy * uy)
